"""What `check` and `predict` say of a study: likely unit errors, sensitivities."""

from __future__ import annotations

import math
from typing import Any

import pytest
from studies import STUDY, edited

import microslip as ms
from microslip._core.units import HARDNESS, QuantityError, to_si
from microslip.contact import NORMAL_LAWS
from microslip.friction.input_slopes import input_slopes
from microslip.report.predicted.preview import preview


def study(*edits: tuple[str, str]) -> ms.Study:
    return ms.Study.from_toml(edited(*edits))


def test_slopes_of_exponential_heights_are_closed_forms() -> None:
    """There k_t = (3/2) N / (lambda sigma): one in load, less one in the spread, no other."""
    surface = ms.GreenwoodWilliamson.examples()[1]
    joint = ms.Interface(surface, 0.5, separation=4e-7)
    slopes = input_slopes(joint, 1e-7)
    stiff = slopes["tangential_stiffness"]
    assert stiff["normal_load"] == pytest.approx(1.0, abs=1e-10)
    assert stiff["heights"] == pytest.approx(-1.0, abs=1e-10)
    for name in ("young_modulus", "radius", "density", "friction_coefficient"):
        assert stiff[name] == pytest.approx(0.0, abs=1e-10)
    # The loss factor depends on amplitude/(mu lambda sigma) alone.
    loss = slopes["loss_factor"]
    assert loss["friction_coefficient"] == pytest.approx(loss["heights"], rel=1e-6)
    assert next(iter(loss)) in ("friction_coefficient", "heights")


@pytest.mark.parametrize("surface", [s for law in NORMAL_LAWS for s in law.examples()])
def test_every_law_has_slopes(surface: Any) -> None:
    load = 0.3 * min(float(surface.load(surface._span[0])), 1e3)
    slopes = input_slopes(ms.Interface(surface, 0.4, normal_load=load), 1e-8)
    stiff = slopes["tangential_stiffness"]
    assert {"friction_coefficient", "normal_load"} <= set(stiff)
    assert all(math.isfinite(slope) for found in slopes.values() for slope in found.values())
    sizes = [abs(slope) for slope in stiff.values()]
    assert sizes == sorted(sizes, reverse=True)


@pytest.mark.parametrize(
    ("text", "value"),
    [("200 HB", 1.96133e9), ("350 HV10", 3.4323275e9), ("180 HBW 2.5/187.5", 1.765197e9)],
)
def test_hardness_numbers(text: str, value: float) -> None:
    assert to_si(text, HARDNESS, "1.2 GPa") == pytest.approx(value, rel=1e-14)


def test_hardness_without_an_area_is_refused() -> None:
    with pytest.raises(QuantityError, match="convert it to HB or HV"):
        to_si("60 HRC", HARDNESS, "1.2 GPa")


def test_odd_values_are_flagged() -> None:
    assert preview(study()).remarks == ()
    odd = STUDY.replace('"69 GPa"', '"69 MPa"').replace(
        "friction_coefficient = 0.55", "friction_coefficient = 15"
    )
    assert odd.count("69 MPa") == 1
    said = preview(ms.Study.from_toml(odd)).remarks
    assert any("Was 69 GPa meant?" in text for text in said)
    assert any("joint.friction_coefficient: is it really 15" in text for text in said)
