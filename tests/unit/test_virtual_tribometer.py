"""The virtual rig: its record is the model's, its imperfections are those asked for."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from own_laws import LAWS

import microslip as ms
from microslip.laboratory import virtual
from microslip.laboratory.virtual import InSeries

JOINT = ms.Interface.examples()[0]  # milled Al 2017 at 2 kN
RIG = 1e8


@pytest.mark.parametrize(
    ("stiffness", "phase"), [(None, 0.5), (None, 2.5), (RIG, 0.5), (RIG, -0.5), (RIG, 2.5)]
)
def test_ripple_out_of_step_converges(
    stiffness: float | None, phase: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With the square of the steps a cycle; with those there are below 1e-4 of the force here."""
    forces = []
    for steps in (128, virtual.STEPS_A_CYCLE, 8 * virtual.STEPS_A_CYCLE):
        monkeypatch.setattr(virtual, "STEPS_A_CYCLE", steps)
        rig = ms.VirtualTribometer(
            JOINT, rig_stiffness=stiffness, load_ripple=0.3, ripple_phase=phase, sample_rate=20.7
        )
        record = rig.record(amplitude=3e-6, cycles=2)
        # The load is exact at any: the force that makes it needs no steps.
        assert np.abs(np.asarray(record.normal_load) / 2000.0 - 1.0).max() <= 0.3 + 1e-12
        forces.append(record.force)
    coarse, usual = (np.abs(f - forces[-1]).max() / np.abs(f).max() for f in forces[:2])
    assert usual < 1e-4
    # Eight times the steps: 1/64 of the error in the mean, of which one record may be half or
    # twice; what is exact anyway stays so.
    assert usual < coarse / 16.0 or usual < 1e-9


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.__name__)
@pytest.mark.parametrize("stiffness", [1e6, 1e8, 1e12])
def test_rig_is_in_series(law: Any, stiffness: float) -> None:
    """k (x - delta) = T(delta), on the first loading and along any record."""
    for joint in law.examples()[:3]:
        series = InSeries(joint, stiffness)
        reach = joint.force_limit * (1.0 / stiffness + 1.0 / joint.tangential_stiffness)
        reach = reach or joint.force_limit / stiffness
        x = reach * np.array([0.1, 0.5, 0.9, 1.3, -0.7, 0.4, 2.5, -3.0, 1.0, 0.2])
        force = series.force(x)
        if np.isfinite(joint.tangential_stiffness):
            np.testing.assert_allclose(
                joint.force(x - force / stiffness), force, rtol=0, atol=1e-8 * joint.force_limit
            )
        else:
            np.testing.assert_allclose(
                ms.Jenkins(stiffness, joint.force_limit).force(x), force, rtol=1e-12
            )
        step = 1e-6 * reach
        middle = 0.4 * reach
        slope = (series.backbone(middle + step) - series.backbone(middle - step)) / (2 * step)
        assert series.backbone_stiffness(middle) == pytest.approx(slope, rel=1e-4)


@pytest.mark.parametrize("share", [0.0, 0.05, 1.0 / 9.0])
def test_third_harmonic(share: float) -> None:
    rig = ms.VirtualTribometer(JOINT, third_harmonic=share, sample_rate=1024)
    record = rig.record(amplitude=5e-6, frequency=1, cycles=1)
    assert record.displacement.max() == pytest.approx(5e-6, rel=1e-4)
    spectrum = np.abs(np.fft.rfft(record.displacement[:1024]))
    assert spectrum[3] / spectrum[1] == pytest.approx(share, abs=1e-12)


def test_noise_and_seed() -> None:
    given: dict[str, Any] = {"amplitude": 5e-6, "cycles": 40}
    rigs = [ms.VirtualTribometer(JOINT, noise=0.01, seed=seed) for seed in (1, 1, 2)]
    first, same, other = (rig.record(**given) for rig in rigs)
    for channel in ("displacement", "force", "normal_load"):
        np.testing.assert_array_equal(getattr(first, channel), getattr(same, channel))
        assert not np.array_equal(getattr(first, channel), getattr(other, channel))
    clean = ms.VirtualTribometer(JOINT).record(**given)
    assert np.std(first.displacement - clean.displacement) == pytest.approx(5e-8, rel=0.03)
    assert np.std(first.force - clean.force) == pytest.approx(0.01 * 1100.0, rel=0.03)
    assert np.std(first.normal_load) == pytest.approx(20.0, rel=0.03)


def test_a_law_without_a_surface() -> None:
    record = ms.VirtualTribometer(ms.Jenkins(1e8, 500.0)).record(amplitude=2e-5, cycles=1)
    assert record.normal_load is None
    assert record.force.max() == 500.0
