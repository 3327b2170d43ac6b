"""Fields of nodes: what they take and what they refuse."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pytest
from usual import SURFACE

import microslip as ms


def field(surface: Any = SURFACE, friction: Any = 0.3, **given: Any) -> ms.JointField:
    return ms.JointField(surface, friction, **({"areas": [1e-5, 2e-5, 3e-5]} | given))


def test_descriptions_of_a_field() -> None:
    made = field(loads=[10.0, 0.0, 300.0])
    assert made.size == 3
    assert made.gaps is None
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
        again = other.start().try_(1e-7, 5e-7).force
        np.testing.assert_array_equal(again, made.start().try_(1e-7, 5e-7).force)
        assert not other.areas.flags.writeable


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


def test_laws_beside_a_rigid_one() -> None:
    joint = ms.Interface(SURFACE, 0.5, normal_load=1000.0)
    both = ms.Parallel([joint, ms.Coulomb(100.0)])
    assert both.tangential_stiffness == np.inf
    assert both.backbone_displacement(90.0) == 0.0
    assert both.backbone(both.backbone_displacement(400.0)) == pytest.approx(400.0, rel=1e-13)
    moved = both.displacement([50.0, 300.0, 150.0, -300.0])
    np.testing.assert_allclose(both.force(moved)[[1, 3]], [300.0, -300.0], rtol=1e-12)
    assert moved[2] == moved[1], "what is rigid holds until twice its limit is taken back"


def test_one_type_answers_trials_with_and_without_separations():
    """By name all is there; it unpacks as it was asked for."""
    surface = ms.Interface.examples()[0].surface
    field = ms.JointField(surface, 0.3, areas=1.0, loads=[5.0, 8.0], surface_area=1.0)
    flat = field.two_directions(16)
    for states, x in ((field.start, [1e-9, 2e-9]), (flat.start, [[1e-9, 2e-9], [3e-9, 0.0]])):
        one, other = states(), states()
        held, varied = one.try_(x), other.try_(x, field.separations)
        assert type(held) is type(varied)
        force, stiffness = held
        forces, load, tangent = varied
        for found, wanted in (
            (force, forces), (held.force, forces), (held.load, load), (held.tangent, tangent),
            (stiffness, held.stiffness), (varied.stiffness, held.stiffness),
        ):  # fmt: skip
            np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-12 * abs(wanted).max())
