"""Moments of two faces together, and summits of a drawing."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import microslip as ms
from microslip.surfaces import Moments, random_surface

SHARED = Path(__file__).resolve().parents[3] / "shared" / "data" / "scans" / "plu-1.plu"

# -- two faces -------------------------------------------------------------------------------------


def test_the_gap_of_two_faces_has_the_moments() -> None:
    """Moments of the difference of two scans are the sums of theirs."""
    faces = [
        random_surface((512, 512), 1e-6, m0=m0, m2=1e-3, m4=m4, seed=seed)
        for seed, m0, m4 in ((3, 4e-14, 2e8), (4, 1e-13, 1e8))
    ]
    gap = ms.Scan(faces[0].heights - faces[1].heights, 1e-6).moments()
    for name in ("m0", "m2", "m4"):
        # Cross terms of two finite scans vanish like one over the root of the waves in them.
        both = sum(getattr(face.moments(), name) for face in faces)
        assert getattr(gap, name) == pytest.approx(both, rel=0.03)


# -- drawings --------------------------------------------------------------------------------------


def test_a_drawing_finds_the_gaussian_surface_again() -> None:
    """Ra and RSm of long Gaussian profiles, by counting, lead back to their moments."""
    made = random_surface((1024, 256), 1e-6, m0=1e-12, m2=4e-3, m4=8e7, seed=5)
    heights = made.heights - made.heights.mean()
    ra = float(np.abs(heights).mean())
    ups = np.count_nonzero((heights[:, :-1] < 0.0) & (heights[:, 1:] >= 0.0))
    rsm = heights.shape[0] * (heights.shape[1] - 1) * 1e-6 / ups
    wanted = made.moments()
    finish = ms.SurfaceFinish(ra=ra, rsm=rsm, breadth=wanted.nayak)
    # One realisation: some hundred waves along each axis.
    assert finish.rms.middle == pytest.approx(wanted.rms, rel=0.02)
    assert finish.slope.middle == pytest.approx(wanted.rms_slope, rel=0.05)
    assert finish.statistics.radius == pytest.approx(wanted.mccool().radius, rel=0.15)
    for rz in (5e-6, 4e-5):
        by_height = ms.SurfaceFinish(rz=rz, rsm=1e-4).rms
        assert by_height.low < by_height.middle < by_height.high
        waves = (0.8e-3 if rz < 1e-5 else 2.5e-3) / 1e-4
        rng = np.random.default_rng(0)
        # Extremes of so many independent waves: Rayleigh peaks of a narrow band.
        peaks = np.sqrt(-2.0 * np.log(rng.random((4000, round(waves), 2)))).max(axis=1)
        assert rz / by_height.middle == pytest.approx(peaks.sum(axis=1).mean(), rel=0.02)


def test_ranges_hold_every_surface_that_the_drawing_allows() -> None:
    finish = ms.SurfaceFinish(ra=8e-7, rsm=60e-6)
    rng = np.random.default_rng(1)
    for _ in range(200):
        rms, slope, alpha = (
            math.exp(rng.uniform(math.log(item.low), math.log(item.high)))
            for item in (finish.rms, finish.slope, finish.alpha)
        )
        slope *= rms / finish.rms.middle
        found = Moments(rms**2, slope**2, alpha * slope**4 / rms**2).mccool()
        for name, (low, high) in finish.ranges.items():
            assert low * (1 - 1e-12) <= getattr(found, name) <= high * (1 + 1e-12)
    assert ms.SurfaceFinish(rq=1e-6).rms == (1e-6, 1e-6, 1e-6)
    assert ms.SurfaceFinish(process="EDM").process == "eroded"


@pytest.mark.slow
@pytest.mark.skipif(not SHARED.is_file(), reason="no scans in a folder `shared` beside the project")
def test_a_machined_face_lies_within_its_drawing() -> None:
    scan = ms.Scan.read(SHARED).condition(
        level="plane", long_cutoff=0.8e-3, outliers=8.0, fill="interpolate"
    )
    for cutoff in (8e-6, 20e-6):
        summits = scan.summits(cutoff, level=None)
        z, pixel = summits.scan.heights, summits.scan.pixel
        distances = []
        for rows, step in ((z, pixel[0]), (z.T, pixel[1])):
            high, low = 0.1 * rows.max(axis=1), 0.1 * rows.min(axis=1)
            elements = 0
            for row, top, bottom in zip(rows, high, low, strict=True):
                side = np.where(row > top, 1, np.where(row < bottom, -1, 0))
                side = side[side != 0]
                elements += np.count_nonzero((side[:-1] < 0) & (side[1:] > 0))
            distances.append(rows.size * step / elements)
        finish = ms.SurfaceFinish(ra=float(np.abs(z - z.mean()).mean()), rsm=min(distances))
        assert finish.slope.middle == pytest.approx(summits.scan.moments().rms_slope, rel=0.25)
        counted = summits.statistics()
        for name, (low, high) in finish.ranges.items():
            assert low <= getattr(counted, name) <= high, (cutoff, name)
