"""Figures and tables of measured scans: ranges that show the surface, and what they say of gaps."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from microslip.figures.picture import PictureCache
from microslip.figures.plot import Line, Panel, Pixels
from microslip.report.html import html_page
from microslip.report.scanned.document import scan_document
from microslip.report.scanned.height_pictures import height_plot, spectrum_plot
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


def lines(panel: Panel) -> list[Line]:
    return [item for item in panel.items if isinstance(item, Line)]


def test_spectra_are_shown_where_they_are(tmp_path: Path, ground: np.ndarray) -> None:
    """From the lowest density in view up, but no farther below what was there before the filter."""
    noisy = ground + 1e-10 * np.random.default_rng(0).standard_normal(ground.shape)
    drawn = spectrum_plot(found(tmp_path, noisy, cutoff=10e-6))
    for panel, before in zip(drawn.panels, (1, 2), strict=True):
        assert panel.y.low is not None
        assert panel.y.high is not None
        lows = []
        for line in lines(panel)[: 2 * before]:
            seen = (line.x >= panel.x.low) & (line.x <= panel.x.high)
            lows.append(np.nanmin(line.y[seen]))
            assert np.nanmax(line.y) < panel.y.high
        wanted = 0.5 * max(min(lows), 1e-3 * min(lows[:before]))
        assert panel.y.low == pytest.approx(wanted, rel=1e-6)
    # Names of cut-offs and lines are beside the panels and not on the lines.
    names = ["levelled", "cut off", "± its uncertainty", "along x", "along y"]
    told = [entry.label for entry in drawn.legend]
    assert [name for name in told if not name.startswith("H = ")] == [
        *names,
        "cut-off: short-wave 10 µm",
    ]


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


@pytest.mark.parametrize("gaps", [True, False])
def test_gaps_of_a_profile_are_reported_beside_the_spectrum(
    tmp_path: Path, ground: np.ndarray, gaps: bool
) -> None:
    heights = ground.ravel().copy()
    if gaps:
        heights[90:99] = np.nan
    text = html_page(scan_document(found(tmp_path, heights, cutoff=10e-6)), PictureCache())
    assert ("steps at the edges of gaps add waves of every length" in text) == gaps
