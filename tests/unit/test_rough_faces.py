"""Faces by scans, by summits and by drawings, alone and two together."""

from __future__ import annotations

import math
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from studies import SURFACE, edited

import microslip as ms
from microslip.scans import Moments, SummitStatistics, average, combine, random_surface

SHARED = Path(__file__).resolve().parents[3] / "shared" / "data" / "scans" / "plu-1.plu"
GROUND = 'scan = "a.npy", unit = "um", pixel = "1 um", cutoff = "8 um"'
BOTH = GROUND.replace('"a.npy"', '["a.npy", "b.npy"]')
DRAWN = 'ra = "0.8 um", rsm = "60 um"'
SUMMITS = 'std = "0.4 um", radius = "20 um", density = "3000 1/mm^2"'


def study(first: str, second: str, extra: str = "") -> str:
    block = f'law = "two-faces"\narea = "2 cm^2"\nfirst = {{ {first} }}\nsecond = {{ {second} }}\n'
    return edited((SURFACE, block + extra))


@pytest.fixture(name="home")
def _home(tmp_path: Path) -> Path:
    for seed, name in ((1, "a"), (2, "b")):
        made = random_surface((96, 96), 1e-6, m0=4e-14, m2=1e-3, m4=2e8, seed=seed)
        np.save(tmp_path / f"{name}.npy", made.heights * 1e6)
    return tmp_path


def scanned(home: Path, name: str) -> SummitStatistics:
    scan = ms.Scan.read(home / f"{name}.npy", unit="um", pixel=1e-6).condition(level="plane")
    return scan.summits(8e-6, level=None).statistics()


# -- two faces -------------------------------------------------------------------------------------


def test_faces_of_each_kind_add_up(home: Path) -> None:
    """A study is what combine makes of the faces, whichever way each is described."""
    one, drawn = scanned(home, "a"), ms.SurfaceFinish(ra=8e-7, rsm=60e-6).statistics
    given = SummitStatistics(3e9, 2e-5, 4e-7)
    pooled, scatter = average([one, scanned(home, "b")])
    ways = {GROUND: one, BOTH: pooled, DRAWN: drawn, SUMMITS: given}
    for (first, a), (second, b) in product(ways.items(), repeat=2):
        made = ms.Study.from_toml(study(first, second), folder=home)
        surface = made.surface.build(ms.MaterialPair(*[ms.Material(69e9, 0.33)] * 2))
        wanted = combine(a, b)
        # Read and summed again: the order of BLAS's sums depends on where an array lies in memory.
        found = (surface.radius, surface.density, surface.heights.std, surface.area)
        sums = (wanted.radius, wanted.density, wanted.std, 2e-4)
        assert found == pytest.approx(sums, rel=1e-12, abs=0.0)
    result = ms.Study.from_toml(study(BOTH, DRAWN), folder=home).run()
    faces = result.summary["faces"]
    assert faces["first"]["scatter"] == pytest.approx(scatter._asdict(), rel=1e-12, abs=0.0)
    assert set(faces["second"]["ranges"]) == {"std", "radius", "density"}
    assert faces["together"]["std"] == pytest.approx(combine(pooled, drawn).std, rel=1e-12)
    notes = " ".join(result.summary["notes"])
    assert "2 scans, which scatter by density" in notes
    assert "spectral moments add (Greenwood 1984)" in notes
    names = [verdict["name"] for verdict in result.summary["joints"][0]["validity"]]
    assert names.count("summit radius in pixels") == 2  # one for each scan


def test_the_gap_of_two_faces_has_the_moments(home: Path) -> None:
    """The difference of two scans, counted by itself, against what combine says of both."""
    faces = [
        random_surface((512, 512), 1e-6, m0=m0, m2=1e-3, m4=m4, seed=seed)
        for seed, m0, m4 in ((3, 4e-14, 2e8), (4, 1e-13, 1e8))
    ]
    gap = ms.Scan(faces[0].heights - faces[1].heights, 1e-6).moments()
    both = combine(faces[0].moments(), faces[1].moments())
    for name in ("m0", "m2", "m4"):
        # Cross terms of two finite scans vanish like one over the root of the waves in them.
        assert getattr(gap, name) == pytest.approx(getattr(both, name), rel=0.03)


def test_a_saved_study_finds_its_scans(home: Path) -> None:
    (home / "faces.toml").write_text(study(BOTH, GROUND), encoding="utf-8")
    made = ms.Study.load(home / "faces.toml")
    text = made.text_for(home / "deeper")
    assert '["../a.npy", "../b.npy"]' in text
    (home / "deeper").mkdir()
    again = ms.Study.from_toml(text, folder=home / "deeper")
    assert again.surface.statistics == made.surface.statistics


def test_average_pools_the_summits() -> None:
    rng = np.random.default_rng(3)
    counts, areas = (40, 160), 1e-6
    heights = [rng.normal(0.0, s, n) for s, n in zip((1e-7, 3e-7), counts, strict=True)]
    curved = [rng.uniform(1e4, 2e4, n) for n in counts]
    each = [
        SummitStatistics(h.size / areas, 1.0 / c.mean(), h.std(), 1e-7, "counted")
        for h, c in zip(heights, curved, strict=True)
    ]
    pooled, scatter = average(each)
    level = np.concatenate([h - h.mean() for h in heights])
    assert pooled.density == pytest.approx(level.size / (2 * areas))
    assert pooled.radius == pytest.approx(1.0 / np.concatenate(curved).mean())
    assert pooled.std == pytest.approx(level.std())
    assert scatter.density == pytest.approx(np.std(counts, ddof=1) / np.mean(counts))
    alone, none = average(each[:1])
    assert alone == each[0]
    assert math.isnan(none.std)
    other = SummitStatistics(1e9, 1e-5, 1e-7, radius_by="load")
    for wrong in ([], [each[0], other], [each[0], 3]):
        with pytest.raises(ms.InputError, match="average wants"):
            average(wrong)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("second", "says"),
    [
        ('ra = "0.8 um", rq = "1 um"', "surface.second.ra: one of ra, rq and rz must be given"),
        ('rsm = "60 um"', "or a process such as ground, got nothing of it"),
        ('process = "drilled"', 'surface.second.process: wanted "milled"'),
        ('ra = "0.8 um", breadth = 1.2', "surface.second.breadth: wanted a number of at least 1.5"),
        ('std = "1 um"', 'surface.second.radius: missing; write for example radius = "20 um"'),
        ('scan = "c.npy", cutoff = "none"', "surface.second.scan: c.npy: no such file"),
        ('scan = "a.npy", cutoff = "8 um"', "surface.second.scan: a.npy: the file does not say"),
        (f'{GROUND}, area = "1 mm^2"', "surface.second.area: unknown key"),
        (f'{GROUND}, estimate = "population"', "surface.second.estimate: wanted one radius"),
        ('ra = "0.8 um", cutof = 3', "surface.second.cutof: unknown key"),
    ],
)
def test_mistakes_of_a_face(home: Path, second: str, says: str) -> None:
    with pytest.raises(ms.StudyError) as caught:
        ms.Study.from_toml(study(GROUND, second), folder=home)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


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
