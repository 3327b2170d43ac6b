"""Bands of a bolted beam from few samples, against quantiles of four times as many."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import microslip as ms
from microslip.friction.sweeps import quantiles

STUDY = Path(__file__).parents[2] / "examples" / "bolted_beam.toml"


@pytest.mark.slow
def test_bands_of_the_demo_beam_agree_with_solved_samples(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without interpolation the quantiles are those of 256 solutions by harmonic balance."""
    text = STUDY.read_text("utf-8").replace("modes = [1, 3]", "modes = [1]")
    text = text.replace("points = 8", "points = 3")
    assert "points = 3" in text
    text = text.replace("[structure]", '[structure]\nforce = { amplitude = "0.02 N" }')
    few = ms.Study.from_toml(text).run().structure.modes[0]
    monkeypatch.setattr(quantiles, "_EXPLAINED", 2.0)  # never reached: no column is interpolated
    more = text.replace("samples = 64", "samples = 256")
    many = ms.Study.from_toml(more).run().structure.modes[0]
    np.testing.assert_allclose(few.bands.frequency, many.bands.frequency, rtol=2e-3)
    np.testing.assert_allclose(few.bands.damping_ratio, many.bands.damping_ratio, rtol=0.1)
    peaks, wanted = (mode.forced[0].peak_bands for mode in (few, many))
    np.testing.assert_allclose(peaks[:, 0], wanted[:, 0], rtol=0.1)
    np.testing.assert_allclose(peaks[:, 1], wanted[:, 1], rtol=2e-3)
