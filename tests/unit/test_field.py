"""Fields of nodes: what they take and what they refuse."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pytest

import microslip as ms

AL = ms.Material(69e9, 0.33)
PAIR = ms.MaterialPair(AL, AL)
SURFACE = ms.GreenwoodWilliamson(PAIR, ms.Gaussian(5e-7), radius=1e-3, density=1e8, area=2e-4)
SPHERE = ms.SphereOnFlat(PAIR, radius=5e-3)
TABLE = ms.TabulatedNormalLaw(PAIR, [0.0, 1e-6, 2e-6], [100.0, 20.0, 0.0])
NAN = float("nan")


def field(surface: Any = SURFACE, friction: Any = 0.3, **given: Any) -> ms.JointField:
    return ms.JointField(surface, friction, **({"areas": [1e-5, 2e-5, 3e-5]} | given))


def test_what_a_field_says() -> None:
    made = field(loads=[10.0, 0.0, 300.0])
    assert made.size == 3
    assert made.gaps is None
    assert repr(made) == "JointField(GreenwoodWilliamson, 3 nodes, area=6e-05, normal_load=310)"
    np.testing.assert_array_equal(made.friction, [0.3, 0.3, 0.3])
    np.testing.assert_array_equal(made.normal_loads, [10.0, 0.0, 300.0])
    assert made.force_limits[1] == made.tangential_stiffnesses[1] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        made.areas[0] = 1.0
    given = np.array([10.0, 20.0, 30.0])
    kept = field(loads=given)
    given[0] = 0.0
    assert kept.normal_loads[0] == 10.0
    for other in (copy.copy(made), copy.deepcopy(made), pickle.loads(pickle.dumps(made))):
        again = other.first_loading(1e-7, 5e-7).force
        np.testing.assert_array_equal(again, made.first_loading(1e-7, 5e-7).force)
        assert not other.areas.flags.writeable


def test_without_load_nothing_is_touched_until_it_closes() -> None:
    made = field(loads=[0.0, 0.0, 0.0])
    answer = made.first_loading(1e-6, made.separations)
    assert not answer.force.any()
    assert not answer.load.any()
    assert not answer.tangent.any()
    closed = made.first_loading(1e-7, 3e-7)
    assert (closed.load > 0.0).all()
    assert (closed.force > 0.0).all()
    with pytest.raises(ms.InputError, match="rigid needs a node that carries a load"):
        made.rigid()


def test_gaps_stay_as_the_state_of_rest_moves() -> None:
    open_ = field(gaps=[1e-4, 0.0, -2e-7])
    np.testing.assert_array_equal(open_.gaps, [1e-4, 0.0, -2e-7])
    np.testing.assert_array_equal(open_.gaps, open_.separations)
    assert open_.normal_loads[0] == 0.0
    closed = open_.at(separations=3e-7)
    np.testing.assert_array_equal(closed.gaps, open_.gaps)
    np.testing.assert_allclose(closed.normal_loads, open_.load(3e-7)[0], rtol=1e-15)
    again = closed.at(loads=closed.normal_loads)
    np.testing.assert_allclose(again.separations, 3e-7, rtol=1e-13)


def test_load_is_that_of_the_surface() -> None:
    made = field(loads=[10.0, 20.0, 0.0])
    d = np.array([-1e-6, 3e-7, 2e-6])
    loads, slopes = made.load(d)
    share = made.areas / SURFACE.area
    np.testing.assert_allclose(loads, share * SURFACE.load(d), rtol=1e-13)
    np.testing.assert_allclose(slopes, -share * SURFACE.stiffness(d), rtol=1e-13)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: field(loads=[1.0, 2.0]), "got 3 areas, 2 loads"),
        (lambda: field(friction=[0.3, 0.2], loads=1.0), "got 2 friction_coefficient, 3 areas"),
        (lambda: field(), "loads .* must be given, got none"),
        (lambda: field(loads=1.0, gaps=0.0), "got loads and gaps"),
        (lambda: field(loads=[1.0, -5.0, 2.0]), r"negative \[N\], got -5 at node 1"),
        (lambda: field(pressures=[1.0, -5.0, 2.0]), r"negative \[Pa\], got -5 at node 1"),
        (lambda: field(areas=[1e-5, -1e-5, 1e-5], loads=1.0), r"areas .* got -1e-05 at node 1"),
        (lambda: field(friction=[0.3, 0.3, 0.0], loads=1.0), "friction_c.* got 0 at node 2"),
        (lambda: field(loads=[1.0, NAN, 2.0]), "loads must be finite: .* nan at index 1"),
        (lambda: field(loads=[[1.0, 2.0, 3.0]]), "loads must be one-dimensional"),
        (lambda: field(loads="heavy"), "loads must be a number or an array"),
        (lambda: field(loads=[]), "loads must hold at least one number"),
        (lambda: field(surface=3.0, loads=1.0), "surface must be a normal load law"),
        (lambda: field(surface=SPHERE, loads=1.0), "surface_area must be given"),
        (lambda: field(surface=SPHERE, loads=1.0, surface_area=0.0), "area must be above zero"),
        (
            lambda: field(surface=TABLE, loads=[1.0, 1.0, 350.0], surface_area=1e-5),
            "350 N at node 2",
        ),
        (
            lambda: field(surface=TABLE, separations=[1e-6, -1e-9, 0.0], surface_area=1e-5),
            "where the table begins, got -1e-09 at node 1",
        ),
        (lambda: field(loads=1.0).at(), "got neither"),
        (lambda: field(loads=1.0).at(separations=0.0, loads=1.0), "got both"),
        (lambda: field(loads=1.0).at(loads=[1.0, -1.0, 1.0]), "got -1 at node 1"),
        (lambda: field(loads=1.0).load([1.0, 2.0]), "one for each of the 3 nodes"),
        (lambda: field(loads=1.0).first_loading([1.0, NAN, 0.0], 0.0), "displacement must be fin"),
        (lambda: ms.Parallel([]), "got none"),
        (lambda: ms.Parallel([3.0]), "got 3.0 at index 0"),
        (lambda: ms.Parallel("law"), "sequence of backbone laws"),
    ],
)  # fmt: skip
def test_bad_input(call: Any, message: str) -> None:
    with pytest.raises(ms.InputError, match=message):
        call()


def test_laws_beside_a_rigid_one() -> None:
    joint = ms.Interface(SURFACE, 0.5, normal_load=1000.0)
    both = ms.Parallel([joint, ms.Coulomb(100.0)])
    assert both.tangential_stiffness == np.inf
    assert both.backbone_displacement(90.0) == 0.0
    assert both.backbone(both.backbone_displacement(400.0)) == pytest.approx(400.0, rel=1e-13)
    moved = both.displacement([50.0, 300.0, 150.0, -300.0])
    np.testing.assert_allclose(both.force(moved)[[1, 3]], [300.0, -300.0], rtol=1e-12)
    assert moved[2] == moved[1], "what is rigid holds until twice its limit is taken back"
    with pytest.raises(ms.InputError, match="rigid below its limit"):
        ms.Parallel([ms.Coulomb(100.0)]).backbone_displacement(1.0)
