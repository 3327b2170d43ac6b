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
    bands = ms.Study.from_toml(text).run().structure.modes[0].bands
    monkeypatch.setattr(quantiles, "_EXPLAINED", 2.0)  # never reached: no column is interpolated
    more = text.replace("samples = 64", "samples = 256")
    wanted = ms.Study.from_toml(more).run().structure.modes[0].bands
    np.testing.assert_allclose(bands.frequency, wanted.frequency, rtol=2e-3)
    np.testing.assert_allclose(bands.damping_ratio, wanted.damping_ratio, rtol=0.105)
