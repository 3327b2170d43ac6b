"""The law of a face by the numbers of its drawing."""

from __future__ import annotations

import math

import numpy as np
import pytest

import microslip as ms
from microslip.contact import face_table as table

STEEL = ms.Material(210e9, 0.3, hardness=2.4e9)
PAIR = ms.MaterialPair(STEEL, STEEL)


def ground(**changes: object) -> ms.DrawnFace:
    values = {"rms": 4e-7, "slope": 0.1, "area": 1e-4, "tightening_pressure": 1e8} | changes
    return ms.DrawnFace(values.pop("pair", PAIR), **values)  # type: ignore[arg-type]


def test_the_stored_nodes_give_the_stored_fit() -> None:
    """The coefficients are those of the nodes; single precision of these leaves 1e-6."""
    arrays = table.stored()
    at = arrays["hardness"], arrays["pressure"], arrays["breadth"]
    shipped = table.values(*at)
    fitted = table.fit(arrays)
    for name, terms in table._TERMS.items():
        basis = table._basis(table._powers(*table.groups(*at[:2]))[0], at[2], terms)
        assert fitted[name] @ basis == pytest.approx(arrays[f"fitted_{name}"] @ basis, abs=1e-6)
    # The fit is a mean over the faces: single nodes of few faces scatter about it.
    heavy = arrays["level"] >= 0.03
    miss = (np.log(shipped.stiffness) - arrays["stiffness"])[heavy]
    assert math.sqrt(np.mean(miss**2)) < 0.09


def test_the_law_has_the_stiffness_of_its_table_and_is_convex() -> None:
    law = ground()
    numbers = table.values(law._groups[0], law._groups[1])
    assert law.stiffness(law.closest) == pytest.approx(
        float(numbers.stiffness[0]) * 1e8 * 1e-4 / 4e-7, rel=2e-3
    )
    assert law.load(law.closest) == pytest.approx(1e4, rel=1e-12)
    d = np.linspace(law.closest, law.closest + 2e-6, 4000)
    fall = law.stiffness(d)
    assert np.all(np.diff(law.load(d)) < 0.0)
    assert np.all(np.diff(fall) <= 1e-9 * fall[0])
    assert law.contact_area(law.closest) / 1e-4 == pytest.approx(1e8 / 2.4e9, rel=0.2)


@pytest.mark.parametrize("hardness", [0.2, 0.5, 1.3, 3.0, 20.0, 1e6])
@pytest.mark.parametrize("pressure", [1e-6, 0.004, 0.05, 0.3, 0.5])
def test_every_law_of_the_table_falls_and_is_convex(hardness: float, pressure: float) -> None:
    """By its groups: hardness over E* h' from 0.01 to elastic."""
    pair = PAIR.with_hardness(hardness * 1e9)
    pressure = min(pressure * hardness * 1e9, 0.3 * 0.14 * PAIR.composite_modulus)
    law = ground(pair=pair, tightening_pressure=pressure)
    d = np.linspace(law.closest, law._span[1], 2000)
    loads, fall = law.load(d), law.stiffness(d)
    assert np.all(np.diff(loads[loads > 0.0]) < 0.0)
    assert np.all(np.diff(fall) <= 1e-9 * fall[0])
    first = law.first_loading
    assert np.all(np.diff(first.separation) < 0.0)
    # Unloading is stiffer than first loading; the spline of the table leaves 0.2 %.
    assert law.stiffness(law.closest) > 0.998 * first.stiffness[-1]


def test_the_law_scales_as_its_groups_say() -> None:
    """One shape at k times the heights and lengths; and twice the modulus, hardness and load."""
    law, higher = ground(), ground(rms=1.2e-6)
    assert higher.slip_length == pytest.approx(3.0 * law.slip_length, rel=1e-12)
    hard = ms.Material(420e9, 0.3, hardness=4.8e9)
    stiff = ground(pair=ms.MaterialPair(hard, hard), tightening_pressure=2e8)
    assert stiff.stiffness(stiff.closest) == pytest.approx(2 * law.stiffness(law.closest), rel=1e-9)
    assert stiff.slip_length == pytest.approx(law.slip_length, rel=1e-9)


def test_a_lay_turns_the_ratio_of_stiffnesses() -> None:
    """Mean and the two axes: (1 - nu c)/(1 - nu), c the share of the slope along the motion."""
    law = ground(lay=1.0 / 3.0)
    for direction, share in ((0.0, 0.75), (math.pi / 2.0, 0.25)):
        ratio = (1.0 - 0.3 * share) / 0.7
        assert law.slip_per_indentation(direction) == pytest.approx(ratio, rel=1e-12)
        assert law.along(direction).stiffness_ratio == pytest.approx(ratio, rel=1e-12)
    assert ground().slip_per_indentation() == pytest.approx(PAIR.stiffness_ratio, rel=1e-12)
    joint = ms.Interface(law, 0.2, normal_load=5e3, direction=0.0)
    assert joint.normal_stiffness / joint.tangential_stiffness == pytest.approx(0.775 / 0.7)


def test_a_heavier_joint_tightens_the_face_anew() -> None:
    joint = ms.Interface(ground(), 0.2, normal_load=3e4)
    assert joint.surface.tightening_pressure == pytest.approx(3e8)  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"pair": ms.MaterialPair(ms.Material(210e9, 0.3), STEEL.rigid())}, "hardness=2.4e9"),
        ({"tightening_pressure": 1.3e9}, "at most 0.5 of the hardness"),
        ({"slope": 15.0}, "tangent"),
        ({"slope": 0.001, "tightening_pressure": 5e8}, "rms gradient"),
        ({"plateau": 5e-7}, "at most 4e-07"),
        ({"breadth": 1.5}, "at most 0.95"),
        ({"lay": 3.0}, "lay must be at most 1"),
        ({"rms": -1.0}, "rms must be above zero"),
        ({"spreads": {"ra": 0.1}}, "must name some of rms"),
    ],
)
def test_what_it_refuses(changes: dict[str, object], words: str) -> None:
    with pytest.raises(ms.InputError) as caught:
        ground(**changes)
    assert words in str(caught.value)
