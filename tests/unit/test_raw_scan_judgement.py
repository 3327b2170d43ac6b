"""What a filter or a filling hides is judged before it, and what a file may hide is told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from made_surfaces import rough

import microslip as ms
from microslip.surfaces import verdicts

GROUND = rough((128, 128), 1e-6, 1e-7, longest=1.12e-4, shortest=8.6e-6, seed=1)


def words(scan: ms.Scan) -> dict[str, tuple[float | None, str]]:
    return {v.name: (v.value, v.word) for v in verdicts(scan)}


def test_filling_does_not_make_missing_points_present() -> None:
    heights = GROUND.heights.copy()
    heights[20:40, 20:60] = np.nan
    share = 800 / 128**2
    scan = ms.Scan(heights, 1e-6).condition(level="plane", fill="interpolate")
    assert scan.missing == 0.0
    assert words(scan)["missing"] == (pytest.approx(share), "watch")
    assert words(scan.condition(cutoff="8 um"))["missing"][0] == pytest.approx(share)


def test_a_cutoff_does_not_hide_spikes() -> None:
    heights = GROUND.heights.copy()
    places = np.random.default_rng(3).choice(heights.size, heights.size // 1000, replace=False)
    heights.flat[places] += 79.0 * heights.std()
    scan = ms.Scan(heights, 1e-6).condition(level="plane", cutoff="20 um")
    assert scan.statistics().kurtosis < 6.0  # nothing shows them any more
    found = words(scan)
    assert found["fraction of m0 in 0.1 % of points"][1] == "outside"
    assert found["kurtosis"][1] == "outside"
    clean = words(ms.Scan(GROUND.heights, 1e-6).condition(level="plane", cutoff="20 um"))
    assert clean["fraction of m0 in 0.1 % of points"][1] == "ok"


def test_noise_that_is_roughness_is_distinguished_from_noise() -> None:
    """Fractal to the pixel, the differences grow with their distance; those of noise do not."""
    q = np.hypot(*np.meshgrid(np.fft.fftfreq(256), np.fft.fftfreq(256)))
    amplitude = np.where(q > 0.0, np.maximum(q, 0.03) ** -1.5, 0.0)
    noise = np.random.default_rng(2).standard_normal((256, 256))
    rough = 1e-9 * np.fft.ifft2(np.fft.fft2(noise) * amplitude).real
    fractal, smooth = ms.Scan(rough, 1e-6), ms.Scan(1e-8 * noise, 1e-6)
    assert fractal.rough_share_of_noise > 0.8
    assert smooth.rough_share_of_noise < 0.1
    found = {v.name: v for v in fractal.summits("4 um").validity()}
    told = found["peaks dropped for noise that is roughness"]
    assert told.word in ("watch", "outside")
    assert "prominence" in told.remedy


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("y [um],x [um],z [um]", "columns: y, x, z, by their names."),
        ("z [um],x [um],y [um]", "columns: z, x, y, by their names."),
    ],
)
def test_columns_go_by_their_names(tmp_path: Path, text: str, told: str) -> None:
    x, y = np.meshgrid(np.arange(5.0), np.arange(4.0))
    z = np.sin(x) + 2.0 * y
    columns = {"x": x.ravel(), "y": y.ravel(), "z": z.ravel()}
    order = [name.split(" ")[0] for name in text.split(",")]
    table = np.column_stack([columns[name] for name in order])
    np.savetxt(tmp_path / "a.csv", table, delimiter=",", header=text, comments="")
    scan = ms.Scan.read(tmp_path / "a.csv")
    np.testing.assert_allclose(scan.heights, 1e-6 * z, rtol=1e-12)
    assert told in scan.notes


def test_exact_zeros_and_odd_units_are_reported(tmp_path: Path) -> None:
    heights = 1e6 * GROUND.heights
    heights[::9, ::9] = 0.0
    np.save(tmp_path / "z.npy", heights)
    notes = ms.Scan.read(tmp_path / "z.npy", unit="um", pixel=1e-6).notes
    assert any("225 points are exactly 0" in note for note in notes)
    # Few digits have each height often.
    np.save(tmp_path / "d.npy", np.round(heights, 2))
    notes = ms.Scan.read(tmp_path / "d.npy", unit="um", pixel=1e-6).notes
    assert not any("exactly 0" in note for note in notes)
    notes = ms.Scan.read(tmp_path / "z.npy", unit="m", pixel=1e-6).notes
    assert any(note.startswith("likely unit error: heights span") for note in notes)
