"""A law and heights of one's own, one file each, in all that fits, guesses and compares."""

from __future__ import annotations

import numpy as np
import pytest
from own_laws import Hyperbola, Ramp

import microslip as ms
from microslip._core.parameters import parameters_of
from microslip.friction.base import BackboneLaw
from microslip.identification.models import model_of
from microslip.identification.models.base import Materials

LAW = Hyperbola(stiffness=2e7, force_limit=300.0)
REACH = LAW.force_limit / LAW.stiffness
NAMES = [said.name for said in parameters_of(Hyperbola)]


@pytest.fixture(scope="module")
def records() -> list[ms.Record]:
    found = []
    for seed, amplitude in enumerate((0.5, 2.0, 6.0)):
        rig = ms.VirtualTribometer(
            LAW, rig_stiffness=5e7, noise={"force": 0.5, "displacement": 1e-10}, seed=seed
        )
        found.append(rig.record(amplitude=amplitude * REACH, frequency=10.0, cycles=12))
    return found


def test_a_law_is_guessed_by_its_own_shape() -> None:
    loops = [LAW.loop(a * REACH, 400) for a in (1.0, 5.0)]
    guessed = Hyperbola.guess(loops)
    # Bins of a branch are as wide as they are, and samples of one are one place.
    assert guessed.stiffness == pytest.approx(LAW.stiffness, rel=0.05)
    assert guessed.force_limit == pytest.approx(LAW.force_limit, rel=0.05)


@pytest.mark.parametrize("how", [Hyperbola, Hyperbola(1e7, 200.0)], ids=["class", "instance"])
def test_a_law_is_identified(how: object, records: list[ms.Record]) -> None:
    found = ms.identify(records, how)
    assert found.law == "hyperbola"
    assert found.converged
    for name in NAMES:
        fitted = found.parameters[name]
        assert fitted.low <= getattr(LAW, name) <= fitted.high
        assert fitted.value == pytest.approx(getattr(LAW, name), rel=0.02)
    assert found.reduced_chi_squared == pytest.approx(1.0, abs=0.3)
    assert isinstance(found.joint(), Hyperbola)


def test_a_law_is_compared(records: list[ms.Record]) -> None:
    compared = ms.compare(records, ["jenkins", Hyperbola, "segalman"])
    assert compared.best == "hyperbola"
    assert list(compared.fits) == ["hyperbola", "segalman", "jenkins"]


def test_one_export_is_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    """A law in LAWS has a model, which ``identify`` and ``compare`` find by its name."""
    from microslip.identification import models

    monkeypatch.setattr(models, "MODELS", (*models.MODELS, models.model_of(Hyperbola)))
    assert models._model(Hyperbola) == model_of("hyperbola") == model_of("Hyperbola")


def test_differences_are_as_good_as_formulas() -> None:
    """Those of Jenkins's and Segalman's laws, whose derivatives are exact, and of the hyperbola."""
    u = REACH * np.append(0.0, np.geomspace(1e-6, 50.0, 200))
    values = {"stiffness": LAW.stiffness, "force_limit": LAW.force_limit}
    by_values = model_of(Hyperbola).branch(u, values, None)[2]  # type: ignore[attr-defined]
    x = u / REACH
    exact = np.stack((u / (1.0 + x) ** 2, (x / (1.0 + x)) ** 2))
    error = np.abs(by_values - exact).max(axis=1) / np.abs(exact).max(axis=1)
    assert error.max() <= 1e-11
    for law in ms.SegalmanIwan.examples():
        model = model_of(law)
        v = law.slip_displacement * np.linspace(0.0, 0.9, 50)
        values = {name: getattr(law, name) for name in model.names}
        exact = law._parameter_derivatives(v)
        sizes = [max(abs(values[name]), 1e-3) for name in model.names]
        least = 1e-3 * law.force_limit / np.array(sizes)
        scale = np.maximum(np.abs(exact).max(axis=1), least)[:, None]
        same = model._differences(  # type: ignore[attr-defined]
            lambda other, v=v: other._backbone(v), values, v.size
        )
        # Next to what they may be chi and beta have all their steps on one side.
        assert np.abs(same / scale - exact / scale).max() <= 1e-9


def test_heights_of_ones_own_stand_on_surfaces_and_in_fits() -> None:
    pair = ms.Interface.examples()[0].surface.pair
    surface = ms.GreenwoodWilliamson(pair, Ramp(2e-6), radius=1e-3, density=1e8, area=2e-4)
    joint = ms.Interface(surface, 0.5, normal_load=500.0)
    model = model_of("interface", heights=Ramp(1e-3), reference_load=500.0)
    values = {
        "friction_coefficient": 0.5,
        "slip_scale": joint.slip_per_indentation * surface.heights.spread,
        "standardised_separation": joint.separation / surface.heights.spread,
    }
    again = model.build(values, 500.0, Materials(pair, 2e-4, 1e-3))
    assert again.surface.heights.highest == pytest.approx(2e-6, rel=1e-12)
    u = joint.force_limit / joint.tangential_stiffness * np.geomspace(1e-3, 30.0, 40)
    assert again.backbone(u) == pytest.approx(joint.backbone(u), rel=1e-9)
    guessed = ms.Interface.guess(
        joint.loop(5.0 * u[0] * 1e3), pair=pair, normal_load=500.0, heights=Ramp(1.0)
    )
    assert guessed.friction_coefficient == pytest.approx(0.5, rel=0.05)
    assert isinstance(guessed.surface.heights, Ramp)


def test_a_law_without_numbers_is_refused() -> None:
    class Silent(BackboneLaw):
        force_limit = 1.0

        def _backbone(self, u: np.ndarray) -> np.ndarray:
            return np.minimum(u, 1.0)

        def _slope(self, u: np.ndarray) -> np.ndarray:
            return np.where(u < 1.0, 1.0, 0.0)

    with pytest.raises(ms.InputError, match="a law that declares its parameters"):
        model_of(Silent)
