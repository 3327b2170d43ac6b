"""Designs of a mode of a structure, against roots and draws by the library alone."""

from __future__ import annotations

import numpy as np
import pytest
from laps import DENSITY, STRIP, small_lap
from scipy import stats
from scipy.optimize import brentq

import microslip as ms
from microslip.errors import InputError
from microslip.runs.design import DesignPoint, Target
from microslip.runs.modal_design import open_search
from microslip.study.description import StudyDescription

UNSURE = STRIP.replace("= 0.35", "= { low = 0.2, high = 0.5 }")
TENSION = "structure.bolts.tension"


@pytest.fixture(scope="module")
def drawn() -> ms.ReducedJoint:
    """The strip of the study by the library."""
    return small_lap().reduce(
        ms.Material.named("steel"), DENSITY, (3, 2), element_size=0.012,
        sensors={"sensor": ((0.1, 0.0, 0.0), "z")},
    )  # fmt: skip


def mode(drawn: ms.ReducedJoint, tension: float, friction: float, quantity: str) -> float:
    """A quantity of mode 1 at 5 um."""
    steel = ms.Material.named("steel")
    surface = ms.GreenwoodWilliamson(
        ms.MaterialPair(steel, steel), ms.Gaussian(std=1e-6), radius=1e-3, density=5e7, area=2e-4
    )
    joint = drawn.with_tension(tension)
    state = joint.tightened(surface, friction)
    curve = state.modes(0, [5e-6], at=joint.sensor("sensor"), damping_ratio=5e-4)
    return float(getattr(curve, quantity)[0])


def design(text: str, target: str, *ranges: str) -> DesignPoint:
    study = StudyDescription.from_toml(text, "strip")
    return open_search(study, Target.read(target), ranges, 0.9).solve()


@pytest.mark.slow
@pytest.mark.parametrize("quantity", ["frequency", "damping_ratio"])
def test_a_tension_by_a_root(drawn: ms.ReducedJoint, quantity: str) -> None:
    level = mode(drawn, 8e3, 0.35, quantity)
    root = brentq(lambda t: mode(drawn, t, 0.35, quantity) - level, 5e3, 1e4, rtol=1e-4)
    sign = ">=" if quantity == "frequency" else "<="
    found = design(STRIP, f"mode 1 {quantity} {sign} {level!r} at 5 um", f"{TENSION}=2 kN..20 kN")
    assert found.feasible
    # The least change, and at most one and a half percent more of it.
    assert root * (1.0 - 1e-3) <= found.values[TENSION] <= 1.02 * root


@pytest.mark.slow
def test_a_probability_is_that_of_own_draws(drawn: ms.ReducedJoint) -> None:
    level = mode(drawn, 6e3, 0.35, "damping_ratio")
    text = f"mode 1 damping_ratio <= {100.0 * level!r} % at 5 um"
    found = design(UNSURE, text, f"{TENSION}=2 kN..30 kN", "structure.density=7 t/m^3..9 t/m^3")
    assert found.feasible
    assert found.probability >= 0.9
    assert found.samples == 32
    assert found.values["structure.density"] == pytest.approx(7800.0, rel=0.1)
    # The model with another density is that of the library, scaled.
    heavier = drawn.scaled(1.0, found.values["structure.density"] / 7800.0)
    draws = stats.qmc.LatinHypercube(1, rng=np.random.default_rng(5)).random(60)[:, 0]
    lost = [
        mode(heavier, found.values[TENSION], 0.2 + 0.3 * share, "damping_ratio") for share in draws
    ]
    assert np.mean(np.array(lost) <= level) == pytest.approx(found.probability, abs=0.05)


def test_targets_of_modes_are_read_or_refused() -> None:
    target = Target.read("mode 3 frequency >= 1.2 kHz at 1 um")
    assert (target.mode, target.value) == (3, 1200.0)
    assert target.written == "mode 3 frequency >= 1.2 kHz at 1 µm"
    assert Target.read("dissipated_energy <= 3 mJ at 1 um").value == pytest.approx(3e-3)
    assert Target.read("secant_stiffness >= 2 MN/m at 1 um").value == pytest.approx(2e6)
    for text, message in (
        ("frequency >= 5 Hz at 1 um", "of a mode"),
        ("mode 1 loss_factor >= 0.1 at 1 um", "frequency, damping_ratio of a mode"),
        ("mode 0 frequency >= 5 Hz at 1 um", "counted from 1"),
        ("damping_ratio >= 5 Hz at 1 um", "as a number or in %"),
        ("dissipated_energy >= 3 kWh at 1 um", "in J, mJ"),
    ):
        with pytest.raises(InputError, match=message):
            Target.read(text)
    joint = STRIP[: STRIP.index("[structure]")].replace("= 0.35", '= 0.35\nnormal_load = "2 kN"')
    with pytest.raises(InputError, match="structure: wanted one, for a target on a mode"):
        design(joint, "mode 1 frequency >= 5 Hz at 1 um", "joint.friction_coefficient=0.1..0.5")
