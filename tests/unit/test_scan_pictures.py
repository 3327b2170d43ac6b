"""Figures and tables of measured scans: ranges that show the surface, and what they say of gaps."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from microslip.figures.plot import Pixels
from microslip.report.scanned.height_pictures import height_plot
from microslip.surfaces import random_surface
from microslip.surfaces.findings import Findings, Request, analyse


def found(folder: Path, heights: np.ndarray, **wishes: Any) -> Findings:
    np.save(folder / "z.npy", heights)
    given = "cutoff" in wishes
    reading = {"unit": "m", "pixel": "1 um"}
    return analyse(Request.of(folder / "z.npy", cutoff_given=given, **reading, **wishes))


@pytest.fixture(name="ground", scope="module")
def _ground() -> np.ndarray:
    return random_surface((128, 128), 1e-6, m0=1e-16, m2=1e-6, m4=4e4, seed=2).heights


def test_colours_are_heights(tmp_path: Path, ground: np.ndarray) -> None:
    heights = ground.copy()
    heights[5:9, 7:11] = np.nan
    findings = found(tmp_path, heights, cutoff=None)
    whole, part, bar = height_plot(findings).panels
    (pixels,) = (item for item in whole.items if isinstance(item, Pixels))
    grey = pixels.values[::-1].sum(axis=2)  # cividis gets lighter all the way
    assert (grey[5:9, 7:11] == 3 * 255).all()
    there = ~np.isnan(heights)
    order = np.argsort(findings.scan.heights[there])
    assert np.corrcoef(np.arange(order.size), grey[there][order])[0, 1] > 0.97
    assert part.x.low > whole.x.low  # type: ignore[operator]
    assert bar.x.low < 0.0 < bar.x.high  # type: ignore[operator]
