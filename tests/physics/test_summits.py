"""Summits of scans: exact ones, Nayak's theory, a flood by brute force, real scans, joints."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from laps import surface_of_gaps
from made_surfaces import paraboloids, rough
from scipy import io, optimize, special
from usual import PAIR

import microslip as ms
from microslip.surfaces import Moments, verdicts
from microslip.surfaces.peaks import find_peaks

SCANS = Path(__file__).parents[3] / "shared/data/scans"


def real(name: str, level: str | None = "quadratic") -> Any:
    path = SCANS / name
    if not path.exists():
        pytest.skip("no folder `shared` with scans beside this one")
    pytest.importorskip("SurfaceTopography", reason='needs the extra "scan"')
    return ms.Scan.read(path, format=path.suffix[1:]).condition(level=level)


# -- a field of paraboloids, known exactly ---------------------------------------------------------


def field(elliptic: bool) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(3)
    n, step = 7, 40
    y, x = (np.arange(n) * step + 0.5 * step for _ in "yx")
    places = np.stack([v.ravel() for v in np.meshgrid(x, y)], axis=1)
    places = (places + rng.uniform(-8.0, 8.0, places.shape)) * (1e-6, 2e-6)
    heights = rng.uniform(2e-7, 1e-6, n * n)
    radii = rng.uniform(5e-5, 2e-4, (n * n, 2 if elliptic else 1))
    radii = np.broadcast_to(radii, (n * n, 2))
    scan = paraboloids(
        (n * step, n * step), (1e-6, 2e-6), positions=places, heights=heights, radii=radii
    )
    return scan, places, heights, radii


@pytest.mark.parametrize("elliptic", [False, True], ids=["round", "elliptic"])
def test_paraboloids_are_exact(elliptic: bool) -> None:
    """Places, heights above the mean and equivalent radii, to the rounding of a difference."""
    scan, places, heights, radii = field(elliptic)
    found = scan.summits(None)
    assert found.count == len(heights)
    assert found.dropped == 0
    order = np.lexsort((places[:, 0], places[:, 1]))
    ours = np.array([np.argmin(np.hypot(*(found.positions - p).T)) for p in places[order]])
    np.testing.assert_allclose(found.positions[ours], places[order], atol=1e-14)
    mean = scan.heights.mean()
    np.testing.assert_allclose(found.heights[ours], heights[order] - mean, atol=1e-19)
    wanted = np.sqrt(radii[order].prod(axis=1))
    np.testing.assert_allclose(found.radii[ours], wanted, rtol=1e-9)
    curved = np.sort(1.0 / radii[order], axis=1)[:, ::-1]
    np.testing.assert_allclose(found.curvatures[ours], curved, rtol=1e-9)
    # Each stands on the plane at zero, or on a saddle to its neighbour.
    assert np.all(found.prominences[ours] <= heights[order] * (1 + 1e-12))
    shape = np.array(scan.heights.shape) - 2
    assert found.area == pytest.approx(shape.prod() * 2e-12, rel=1e-12)


def test_rotated_ellipse() -> None:
    """Principal curvatures and not those along the axes: z = -(k1 u^2 + k2 v^2)/2."""
    y, x = np.meshgrid(np.arange(-10, 11) * 2e-6, np.arange(-12, 13) * 1e-6, indexing="ij")
    x, y, angle = x - 3.1e-7, y + 4.7e-7, 0.6
    u, v = x * math.cos(angle) + y * math.sin(angle), y * math.cos(angle) - x * math.sin(angle)
    scan = ms.Scan(-0.5 * (2e4 * u**2 + 5e3 * v**2), (1e-6, 2e-6))
    found = scan.summits(None)
    np.testing.assert_allclose(found.curvatures, [[2e4, 5e3]], rtol=1e-9)
    np.testing.assert_allclose(found.radii, [1e-4], rtol=1e-9)
    np.testing.assert_allclose(found.positions, [[12.31e-6, 19.53e-6]], atol=1e-15)


@pytest.mark.parametrize(
    ("ratio", "low", "by_mean"), [(2, 0.010, 0.039), (3, 0.024, 0.092), (10, 0.098, 0.316)]
)
def test_elliptic_summit_as_a_sphere(ratio: float, low: float, by_mean: float) -> None:
    """What find_summits says of 1/sqrt(k1 k2), by Hertz's ellipse; the half axes are 1 and b."""

    def curvatures(m: float) -> tuple[float, float]:
        k, e, b = special.ellipk(m), special.ellipe(m), math.sqrt(1.0 - m)
        return 2.0 * b / m * (k - e), 2.0 * b / m * (e / (1.0 - m) - k)

    m = optimize.brentq(lambda m: curvatures(m)[1] / curvatures(m)[0] - ratio, 1e-3, 0.9999)
    k1, k2 = curvatures(m)
    b = math.sqrt(1.0 - m)
    load, indentation = 2.0 / 3.0 * math.pi * b, b * special.ellipk(m)
    for radius, wanted in ((1.0 / math.sqrt(k1 * k2), low), (2.0 / (k1 + k2), by_mean)):
        sphere = 4.0 / 3.0 * math.sqrt(radius) * indentation**1.5
        assert 1.0 - sphere / load == pytest.approx(wanted, abs=6e-4)


def test_noise_is_no_summit() -> None:
    """Paraboloids under white noise: the threshold leaves them and drops what noise adds."""
    scan, _, heights, _ = field(False)
    noise = 2e-9
    rough = scan.heights + noise * np.random.default_rng(0).standard_normal(scan.heights.shape)
    found = ms.Scan(rough, scan.pixel).summits(None)
    assert found.threshold == pytest.approx(3.0 * noise, rel=0.1)
    # One peak in two hundred of pure noise is as prominent: of 8000 some tens.
    assert len(heights) <= found.count < len(heights) + 60
    assert found.peaks > 5000


# -- Nayak's Gaussian surface ----------------------------------------------------------------------


def test_summits_of_a_gaussian_surface() -> None:
    """Counts, heights and curvatures against Nayak (1971), within 3 %.

    Summits are 18 pixels apart, so that the pixel takes little from their curvature, and 3000 of
    them, so that chance adds one or two per cent. The default threshold drops one in a hundred.
    """
    scan = rough((1000, 1000), 1e-6, 1e-7, longest=3.44e-5, shortest=1.135e-5, seed=1)
    theory = scan.moments().mccool()
    found = scan.summits(None)
    assert found.count > 2500
    assert found.density == pytest.approx(theory.density, rel=0.03)
    assert found.mean_radius == pytest.approx(theory.radius, rel=0.03)
    assert found.std == pytest.approx(theory.std, rel=0.03)
    assert found.mean_height == pytest.approx(theory.mean_height, rel=0.03)
    # The fit over several pixels lessens curvatures, by 2 % in the mean radius, and makes more of
    # the flattest tops, which weigh most in the mean of roots; chance adds one per cent. Nayak's
    # theory gives 1.277 times the radius by curvature.
    assert found.equivalent_radius == pytest.approx(1.2768 * theory.radius, rel=0.05)


@pytest.mark.parametrize(
    ("short", "free", "default", "words"),
    [
        (5, -0.095, -0.17, ("watch", "watch")),
        (8, -0.025, -0.045, ("ok", "ok")),
        (12, -0.01, -0.015, ("ok", "ok")),
    ],
)
def test_summits_of_exact_fields(
    short: int, free: float, default: float, words: tuple[str, str]
) -> None:
    """A Gaussian field of waves from ``short`` pixels on, with moments that no difference has seen.

    Of waves of few pixels the grid misses summits, and the default prominence takes more of them
    for noise; both are told. Three fields of a thousand to five thousand summits: chance adds about
    one per cent to the mean.
    """
    n, counts, drops = 512, [], set()
    q = 2 * math.pi * np.hypot(np.fft.fftfreq(n)[:, None], np.fft.rfftfreq(n)) / 1e-6
    band = (q >= 2 * math.pi / 60e-6) & (q <= 2 * math.pi / (short * 1e-6))
    amplitude = np.where(band, np.where(band, q * 1e-6, 1.0) ** -1.5, 0.0) * 1e-8
    for seed in range(3):
        waves = np.fft.rfft2(np.random.default_rng(seed).standard_normal((n, n))) * amplitude
        power = np.abs(waves) ** 2 / n**4
        power[:, 1:-1] *= 2.0
        orders = power.sum(), 0.5 * (power * q**2).sum(), 0.375 * (power * q**4).sum()
        theory = Moments(*map(float, orders)).mccool()
        scan = ms.Scan(np.fft.irfft2(waves, (n, n)), 1e-6)
        every, found = scan.summits(None, prominence=0.0), scan.summits(None)
        counts.append([every.density / theory.density, found.density / theory.density])
        verdict = {v.name: v for v in found.validity()}["fraction of peaks below the prominence"]
        # Either drops a few peaks more as not round.
        assert verdict.value == pytest.approx(1.0 - found.count / every.count, abs=0.02)
        drops.add((verdict.word, *(v.word for v in verdicts(scan) if "lost" in v.name)))
        assert "fraction of peaks below the prominence" not in {v.name for v in every.validity()}
    got = np.mean(counts, axis=0) - 1.0
    assert got == pytest.approx([free, default], abs=0.02)
    assert drops == {words}


# -- prominence ------------------------------------------------------------------------------------


def flood(h: np.ndarray) -> dict[int, float]:
    """Point by point from the top: each new point joins the parts that its neighbours are in."""
    columns, flat = h.shape[1], h.ravel()
    points = [int(p) for p in np.lexsort((np.arange(flat.size), flat))[::-1] if flat[p] == flat[p]]
    rank = {p: k for k, p in enumerate(points)}
    part: dict[int, int] = {}
    found = {}
    for p in points:
        y, x = divmod(p, columns)
        near = {
            part[q]
            for dy in (-1, 0, 1)
            for dx in (-1, 0, 1)
            if 0 <= x + dx < columns and (q := (y + dy) * columns + x + dx) in part
        }
        part[p] = top = min(near, key=rank.__getitem__, default=p)
        if top == p:
            found[p] = float(flat[p] - np.nanmin(flat))
        for other in near - {top}:
            found[other] = float(flat[other] - flat[p])
            part.update({q: top for q, its in part.items() if its == other})
    return found


@pytest.mark.parametrize("levels", [3, 9, 1000])
@pytest.mark.parametrize("seed", range(6))
def test_prominence_against_a_flood(levels: int, seed: int) -> None:
    """With many ties and with none, with missing points and without."""
    rng = np.random.default_rng(seed)
    h = rng.integers(0, levels, size=rng.integers(2, 24, 2)).astype(float)
    if seed % 2:
        h[rng.random(h.shape) < 0.15] = np.nan
    peaks = find_peaks(h)
    assert dict(zip(peaks.places.tolist(), peaks.prominences.tolist(), strict=True)) == flood(h)
    assert np.all(np.diff(h.ravel()[peaks.places]) <= 0.0)


def test_prominence_does_not_depend_on_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nor on how long the climbs are: a comb of slopes as long as the map, with gaps and ties."""
    rng = np.random.default_rng(8)
    ramp = np.arange(60.0)[:, None] + 3.0 * rng.integers(0, 2, (60, 45))
    for h in (rng.standard_normal((60, 45)), np.floor(ramp / 2.0)):
        h[rng.random(h.shape) < 0.05] = np.nan
        whole = find_peaks(h)
        with monkeypatch.context() as patched:
            patched.setattr("microslip.surfaces.peaks._BLOCK", 100)
            parts = find_peaks(h)
        np.testing.assert_array_equal(whole.places, parts.places)
        np.testing.assert_array_equal(whole.prominences, parts.prominences)
        assert dict(zip(whole.places.tolist(), whole.prominences.tolist(), strict=True)) == flood(h)


@pytest.mark.parametrize("rounds", [1, 2, 6])
@pytest.mark.parametrize("levels", [4, 1000])
def test_many_hills_at_once(rounds: int, levels: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Hills that end at their own first meeting are merged together, on large maps only."""
    for seed in range(4):
        rng = np.random.default_rng(100 + seed)
        h = rng.integers(0, levels, size=(30, 41)).astype(float)
        if seed % 2:
            h[rng.random(h.shape) < 0.1] = np.nan
        with monkeypatch.context() as patched:
            patched.setattr("microslip.surfaces.peaks._FEW_MEETINGS", 0)
            patched.setattr("microslip.surfaces.peaks._ROUNDS", rounds)
            peaks = find_peaks(h)
        found = dict(zip(peaks.places.tolist(), peaks.prominences.tolist(), strict=True))
        assert found == flood(h)


maps = hnp.arrays(
    np.int64, st.tuples(st.integers(2, 12), st.integers(2, 12)), elements=st.integers(0, 20)
)


@given(maps, st.integers(-1000, 1000), st.integers(1, 9))
def test_shift_and_scale(h: np.ndarray, shift: int, scale: int) -> None:
    one, two = find_peaks(h.astype(float)), find_peaks(h * scale + float(shift))
    np.testing.assert_array_equal(one.places, two.places)
    np.testing.assert_array_equal(one.prominences * scale, two.prominences)


@given(maps)
def test_turned_map(h: np.ndarray) -> None:
    """Ties are ordered by place, so which point of a plateau counts may differ, but not how far."""
    one = find_peaks(h.astype(float)).prominences
    for turned in (h.T, h[::-1], h[:, ::-1]):
        two = find_peaks(np.ascontiguousarray(turned, dtype=float)).prominences
        np.testing.assert_array_equal(np.sort(one[one > 0]), np.sort(two[two > 0]))


@given(st.integers(0, 10_000), st.floats(0.01, 100.0), st.floats(0.01, 100.0))
def test_summits_scale(seed: int, up: float, along: float) -> None:
    """Heights times a, lengths times b: radii times b^2/a, and so the rest; transposed alike."""
    h = np.random.default_rng(seed).standard_normal((24, 31)) * 1e-7
    one = ms.Scan(h, (1e-6, 2e-6)).summits(None, prominence=0.0)
    two = ms.Scan(h * up + 1e-7, (along * 1e-6, along * 2e-6)).summits(None, prominence=0.0)
    turned = ms.Scan(h.T.copy(), (2e-6, 1e-6)).summits(None, prominence=0.0)
    assert one.count == two.count == turned.count
    # A nearly flat summit turns a rounding of its heights into more of its radius.
    np.testing.assert_allclose(two.radii, one.radii * along**2 / up, rtol=1e-6)
    np.testing.assert_allclose(two.positions, one.positions * along, rtol=1e-6)
    np.testing.assert_allclose(two.heights, one.heights * up, atol=1e-18 * up + 1e-20)
    np.testing.assert_allclose(turned.mean_radius, one.mean_radius, rtol=1e-9)
    order = np.argsort(turned.heights), np.argsort(one.heights)
    np.testing.assert_allclose(
        turned.positions[order[0]][:, ::-1], one.positions[order[1]], rtol=1e-6, atol=1e-12
    )


# -- real scans ------------------------------------------------------------------------------------


def test_results_depend_on_the_cutoff() -> None:
    """Gaussians of 1, 2 and 4 pixels move McCool's radius from 276 to 783, 2627 and 12 854 um."""
    scan = real("plu-1.plu")
    # Half the amplitude at 2 pi/sqrt(2 ln 2) standard deviations.
    wave = 2.0 * math.pi / math.sqrt(2.0 * math.log(2.0)) * scan.pixel[0]
    cutoffs = [None, wave, 2.0 * wave, 4.0 * wave]
    found = [scan.summits(cutoff) for cutoff in cutoffs]
    mccool = [f.scan.moments().mccool().radius for f in found]
    np.testing.assert_allclose(mccool, [276e-6, 783e-6, 2627e-6, 12854e-6], rtol=0.02)
    radii = [f.statistics().radius for f in found]
    assert np.all(np.diff(np.log(radii)) > math.log(2.0))
    assert "no short-wave cut-off" in " ".join(found[0].notes)
    assert all("short-wave cut-off" in " ".join(f.notes) for f in found)


# -- joints ----------------------------------------------------------------------------------------


def test_gap_table_to_joint() -> None:
    """The Brake-Reuss beam: from the file to a loop, the load against a sum over the file."""
    path = SCANS / "brb_surface_data.mat"
    if not path.exists():
        pytest.skip("no folder `shared` with scans beside this one")
    file = io.loadmat(path)
    gaps = file["normzinterp"][0] * file["z_max"].item()
    share = file["pzinterp"][0]
    held = gaps[np.append(share[1:], 0.0) + share > 0.0]
    steel = ms.Material(192.31e9, 0.3)
    surface = surface_of_gaps(path, ms.MaterialPair(steel, steel), 2.921e-3)
    assert surface.heights.span[1] == 0.0
    assert surface.heights.span[0] == pytest.approx(-held[-1], rel=1e-2)
    for closure in (3e-6, 1e-5, 2e-5):
        # Fine enough that the root at first touch does not matter.
        z = np.linspace(0.0, closure, 200_001)
        density = np.interp(z, gaps, share)
        whole = np.trapezoid(density * (closure - z) ** 1.5, z) / np.trapezoid(share, gaps)
        load = 4 / 3 * surface.pair.composite_modulus * math.sqrt(surface.radius) * whole
        wanted = load * file["area_density"].item() * 2.921e-3
        assert surface.load(-closure) == pytest.approx(wanted, rel=1e-8)
    joint = ms.Interface(surface, 0.3, normal_load=36.7e3)
    loop = joint.loop(1e-6, samples=8192)
    assert loop.dissipated_energy == pytest.approx(joint.dissipated_energy(1e-6), rel=1e-6)
    assert 2.0 < joint.dissipation_exponent(1e-8) <= 3.0 + 1e-3


@pytest.mark.slow
def test_counted_summits_are_softer_than_the_face_solved_point_by_point() -> None:
    """Of nine isotropic faces, at 0.5 and 2 % of real area: they neither interact nor coalesce."""
    n, pixel = 256, 1e-6
    f = np.fft.fftfreq(n) * n
    q = np.hypot(f[:, None], f[None])
    ratios = []
    for low, high in ((4, 16), (4, 32), (8, 32)):
        for seed in range(3):
            noise = np.fft.fft2(np.random.default_rng(seed).normal(size=(n, n)))
            shape = np.where((q >= low) & (q <= high), np.maximum(q, 1.0) ** -1.8, 0.0)
            heights = np.fft.ifft2(shape * noise).real
            scan = ms.Scan(heights / heights.std() * 1e-6, pixel)
            counted, solved = scan.summits(None).to_surface(PAIR), scan.to_contact(PAIR)
            for share in (0.005, 0.02):
                d = optimize.brentq(
                    lambda d, law=counted, part=share * (n * pixel) ** 2: (
                        law.contact_area(d) - part
                    ),
                    -2e-6,
                    4e-6,
                )
                load = counted.load(d)
                ratios.append(counted.stiffness(d) / solved.stiffness(solved.separation(load)))
    at_half, at_two = np.log(ratios).reshape(-1, 2).T
    assert np.exp(at_half.mean()) == pytest.approx(0.87, abs=0.02)
    assert np.exp(at_two.mean()) == pytest.approx(0.82, abs=0.02)
    assert 0.6 < np.exp(min(at_half)) < np.exp(max(at_half)) < 1.25
