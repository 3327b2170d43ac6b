"""Figures and tables of measured scans: ranges that show the surface, and what they say of gaps."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from studies import SURFACE, edited

import microslip as ms
from microslip.scans import random_surface
from microslip.study.report_tables import quantity
from microslip.study.scanned import Findings, Request, analyse
from microslip.study.scanned_files import figure, figures_of, write
from microslip.study.scanned_summary import summarise
from microslip.study.scanned_tables import cutoffs_explained


def found(folder: Path, heights: np.ndarray, **wishes: str) -> Findings:
    np.save(folder / "z.npy", heights)
    request = Request.of(folder / "z.npy", unit="m", pixel=("1 um",), **wishes)  # type: ignore[arg-type]
    return analyse(request)


@pytest.fixture(name="ground", scope="module")
def _ground() -> np.ndarray:
    return random_surface((128, 128), 1e-6, m0=1e-16, m2=1e-6, m4=4e4, seed=2).heights


@pytest.fixture(name="undrawn")
def _undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Drawing takes most of the time; what is drawn is looked at in other tests."""
    from matplotlib.figure import Figure

    empty = b'<svg xmlns="http://www.w3.org/2000/svg"></svg>'
    monkeypatch.setattr(Figure, "savefig", lambda figure, path, **_: path.write_bytes(empty))
    monkeypatch.setattr("microslip.study.drawing.settle", lambda figure: None)


def test_spectra_are_shown_where_they_are(tmp_path: Path, ground: np.ndarray) -> None:
    """From the lowest density in view up, but no farther below what was there before the filter."""
    noisy = ground + 1e-10 * np.random.default_rng(0).standard_normal(ground.shape)
    drawn = figure(found(tmp_path, noisy, cutoff="10 um"), "spectrum")
    for axes, before in zip(drawn.axes, (1, 2), strict=True):
        left, right = axes.get_xlim()
        low, high = axes.get_ylim()
        lows = []
        for line in axes.lines[: 2 * before]:
            x, y = (np.asarray(part, dtype=float) for part in line.get_data())
            lows.append(np.nanmin(y[(x >= left) & (x <= right)]))
            assert np.nanmax(y) < high
        assert low == pytest.approx(0.5 * max(min(lows), 1e-3 * min(lows[:before])), rel=1e-6)
    # Names of cut-offs and lines are beside the panels and not on the lines.
    texts = [text.get_text() for text in drawn.legends[0].get_texts()]
    assert texts == ["levelled", "cut off", "along x", "along y", "cut-off: short-wave 10 µm"]
    assert not any(axes.texts for axes in drawn.axes)


def test_a_spike_of_a_density_has_a_range_of_its_own(tmp_path: Path, ground: np.ndarray) -> None:
    scratched = ground.copy()
    scratched[60:62] -= 6e-7
    for heights, alone in ((scratched, True), (ground, False)):
        one = found(tmp_path, heights, cutoff="none")
        trace, density, tails = figure(one, "density").axes
        assert trace.get_ylim() == tails.get_ylim()
        low, high = density.get_ylim()
        span = trace.get_ylim()[1] - trace.get_ylim()[0]
        assert (high - low < 0.4 * span) == alone
        assert (density.get_ylim() == trace.get_ylim()) == (not alone)
        inside = (one.scan.heights - one.statistics.mean) * 1e9
        assert np.mean((inside >= low) & (inside <= high)) > 0.95


def test_a_scan_without_a_choice_of_cutoffs_has_no_figure_of_it(
    tmp_path: Path, undrawn: None
) -> None:
    one = found(tmp_path, 1e-8 * np.random.default_rng(3).standard_normal((10, 11)))
    assert figures_of(one) == ("heights", "density", "spectrum")
    (tmp_path / "out").mkdir()
    files = write(one, tmp_path / "out")["files"]
    assert not any(name.startswith("cutoffs.") and name != "cutoffs.csv" for name in files)
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == sorted(files)


@pytest.mark.parametrize("gaps", [True, False])
def test_gaps_are_told_beside_the_spectrum(
    tmp_path: Path, ground: np.ndarray, undrawn: None, gaps: bool
) -> None:
    heights = ground.copy()
    if gaps:
        heights[:9] = np.nan
    (tmp_path / "out").mkdir()
    write(found(tmp_path, heights, cutoff="10 um"), tmp_path / "out")
    page = (tmp_path / "out/report.html").read_text("utf-8")
    assert ("steps at the edges of gaps make waves of every length" in page) == gaps


def test_a_table_with_none_counted_says_so(tmp_path: Path, ground: np.ndarray) -> None:
    summary = summarise(found(tmp_path, ground, cutoff="10 um"))
    assert "beside each the counted ones" in cutoffs_explained(summary)
    for row in summary["over_cutoffs"]:
        row["counted_radius"] = None
    assert "none were counted" in cutoffs_explained(summary)


def test_yes_and_no_are_words() -> None:
    assert [quantity(value, "") for value in (True, False)] == ["yes", "no"]
    assert quantity("plane", "") == "plane"


def test_the_pixel_is_judged_in_a_study(tmp_path: Path, ground: np.ndarray) -> None:
    """Of a scan, both verdicts that watch over waves of few pixels reach the joint's own."""
    np.save(tmp_path / "z.npy", ground)
    block = 'law = "scan"\nscan = "z.npy"\nunit = "m"\npixel = "1 um"\ncutoff = "6 um"\n'
    loads = ('["500 N", "2 kN"]', '["0.05 N", "0.2 N"]')
    study = ms.Study.from_toml(edited((SURFACE, block), loads), folder=tmp_path)
    names = [verdict["name"] for verdict in study.run().summary["joints"][0]["validity"]]
    assert "share of m4 lost to the pixel" in names
    assert "share of peaks below the prominence" in names
    assert len(names) == len(set(names))
