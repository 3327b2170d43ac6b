"""Contact cards: their numbers beside the law, their units, and what they refuse."""

import re

import numpy as np
import pytest
from command import STUDY, fails, run
from exported import JOINT
from usual import rough

import microslip as ms
from microslip import export
from microslip.cli.export import _CARD_OPTIONS
from microslip.export.card_files import CARD_UNITS


def test_heights_that_fall_exponentially_have_a_card_in_closed_form():
    """Pressure is exponential in the separation: both stiffnesses are the pressure by a length."""
    scale = 8e-7
    surface = rough(ms.Exponential(scale=scale))
    card = export.ContactCard.of(ms.Interface(surface, 0.4, normal_load=100.0), thickness=2e-3)
    ratio = surface.pair.stiffness_ratio
    assert card.pressure == pytest.approx(5e5)
    assert card.normal_stiffness == pytest.approx(5e5 / scale, rel=1e-9)
    assert card.elastic_slip == pytest.approx(0.4 * ratio * scale, rel=1e-9)
    assert card.layer.young_modulus == pytest.approx(5e5 / scale * 2e-3, rel=1e-9)
    assert card.errors.elastic_slip < 1e-9
    assert card.errors.normal_stiffness == pytest.approx(1.0, rel=1e-9)  # at half the pressure
    assert card.errors.force == pytest.approx(1.0 / (1.0 - np.exp(-1.0)) - 1.0, rel=1e-9)
    p, c = card.pressures[1:], card.overclosures[1:]
    np.testing.assert_allclose(np.diff(c), scale * np.diff(np.log(p)), rtol=1e-7)
    step = np.diff(np.log(p))[0]
    assert card.errors.pressure == pytest.approx(np.cosh(step / 2) - 1.0, rel=1e-5)
    slopes = np.diff(card.pressures) / np.diff(card.overclosures)
    assert np.all(np.diff(slopes) >= -1e-6 * slopes[:-1]), "stiffer with pressure"
    assert np.interp(5e5, p[:-1], slopes[1:]) == pytest.approx(5e5 / scale, rel=0.1)


@pytest.mark.parametrize("program", export.PROGRAMS)
def test_each_program_gets_both_stiffnesses_and_what_is_off(tmp_path, program):
    card = export.write_card(program, JOINT, tmp_path / "c", density=2700.0)
    text = (tmp_path / "c").read_text()
    numbers = [float(n) for n in re.findall(r"\d\.\d+e[+-]\d\d", text)]
    held = [card.stick_stiffness, card.normal_stiffness, 0.55]
    if program in ("openradioss", "ls-dyna"):
        held[0] = card.layer.shear_modulus / card.layer.thickness
    if program == "abaqus":  # which takes the slip, and the table
        held[0], held[1] = card.elastic_slip, card.overclosures[20]
    for value in held:
        assert min(abs(number / value - 1.0) for number in numbers) < 5e-5, (program, value)
    words = " ".join(re.sub(r"(?m)^\W*", "", text).split())
    assert ("up to 17 %" if program == "abaqus" else "up to 76 %") in words
    assert ("not run," in words) == (program != "calculix")


def test_the_command_writes_a_card(here):
    (here / "joint.toml").write_text(STUDY)
    assert _CARD_OPTIONS[0].choices == tuple(export.PROGRAMS)
    assert _CARD_OPTIONS[1].choices == tuple(CARD_UNITS)
    done = run("export", "card", "joint.toml", "-o", "c.inp", "--for", "calculix")
    assert "Written: c.inp\nAt 1e+07 Pa: normal stiffness" in done.output
    assert (here / "c.inp").exists()
    assert "wanted the program" in fails("export", "card", "joint.toml", "-o", "d.inp")
    assert "requires kind card" in fails("export", "c", "joint.toml", "-o", "d.c", "--for", "ansys")
