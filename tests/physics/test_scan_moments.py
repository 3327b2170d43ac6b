"""Moments, summit theory, spectra and made surfaces: closed forms and independent answers."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_surfaces import rough

from microslip.surfaces import (
    Moments,
    Scan,
    verdicts,
)
from microslip.surfaces.moments import moments_of

SCANS = Path(__file__).parents[3] / "shared/data/scans"


# Sines: everything is known.


@pytest.mark.parametrize("axis", ["x", "y", "both"])
def test_a_sine_has_its_moments(axis: str) -> None:
    rows, columns, dx, dy = 400, 600, 1e-6, 1.5e-6
    x, y = np.arange(columns) * dx, np.arange(rows)[:, None] * dy
    qx, qy, a = 2 * math.pi * 12 / (columns * dx), 2 * math.pi * 10 / (rows * dy), 3e-7
    z = np.zeros((rows, columns))
    if axis in ("x", "both"):
        z = z + a * np.sin(qx * x)
    if axis in ("y", "both"):
        z = z + a * np.sin(qy * y)
    found = moments_of(z, (dx, dy))
    parts = [(qx if axis in ("x", "both") else 0.0), (qy if axis in ("y", "both") else 0.0)]
    # Whole waves on the grid: the mean of a square is half the amplitude's, but for the edge.
    waves = sum(q > 0 for q in parts)
    assert found.m0 == pytest.approx(0.5 * a * a * waves, rel=1e-12)
    for power, got in ((2, found.m2_axes), (4, found.m4_axes)):
        for q, h, value in zip(parts, (dx, dy), got, strict=True):
            seen = 2 / h * math.sin(0.5 * q * h)
            assert value == pytest.approx(0.5 * a * a * seen**power, rel=1e-2, abs=1e-30)
            assert value == pytest.approx(0.5 * a * a * q**power, rel=2e-2, abs=1e-30)
    assert found.m2 == pytest.approx(np.mean(found.m2_axes))
    if axis != "both":
        # Ridges along y have slopes along x only.
        assert found.anisotropy > 1e6
        assert found.lay == pytest.approx(math.pi / 2 if axis == "x" else 0.0, abs=1e-6)


@pytest.mark.parametrize("degrees", [-60.0, -45.0, 10.0, 30.0, 75.0])
def test_the_lay_is_the_direction_of_the_ridges(degrees: float) -> None:
    angle, h = math.radians(degrees), 1e-6
    x, y = np.arange(500) * h, np.arange(400)[:, None] * h
    across = angle + math.pi / 2
    q = 2 * math.pi / 40e-6
    z = 1e-7 * np.sin(q * (x * math.cos(across) + y * math.sin(across)))
    found = moments_of(z, (h, h))
    # Differences see a wave of 40 pixels short by parts in a thousand, and differently along x, y.
    assert found.lay == pytest.approx(angle, abs=5e-3)
    assert found.anisotropy > 15.0


def test_differences_converge_with_the_square_of_the_pixel() -> None:
    """Of slanting waves of 10, 20 and 40 pixels: m2 and m4 along x, and the mean product m11."""
    errors: dict[str, list[float]] = {"m2": [], "m4": [], "m11": []}
    q, waves = 2 * math.pi * 10 / 1e-3, 0.5e-14
    for count in (100, 200, 400):
        h = 1e-3 / count
        for name, extra, power in (("m2", 1, 2), ("m4", 2, 4), ("m11", 1, 2)):
            # So many points that the differences have whole waves, along x and y.
            x = np.arange(count + extra) * h
            z = 1e-7 * np.sin(q * (x + x[:, None]))
            found = moments_of(z, (h, h))
            seen = found.m11 if name == "m11" else getattr(found, f"{name}_axes")[0]
            errors[name].append(1.0 - seen / (waves * q**power))
            # What differences see of a wave; a slope in the middle of a cell is over two points.
            u = 0.5 * q * h * (2.0 if name == "m11" else 1.0)
            assert 1.0 - errors[name][-1] == pytest.approx((math.sin(u) / u) ** power, rel=1e-9)
    for name, off in errors.items():
        orders = np.log2(np.array(off[:-1]) / np.array(off[1:]))
        # The next term takes 0.06 of an order from ten pixels a wave to twenty.
        assert orders == pytest.approx([2.0, 2.0], abs=0.07), name


@pytest.mark.parametrize("slant", [1, -1])
def test_gaps_are_no_lay(slant: int) -> None:
    """An isotropic surface with every sixth diagonal missing: along either, slopes are alike."""
    scan = rough((400, 400), 1e-6, 4e-7, longest=3.3e-5, shortest=7.1e-6, seed=7)
    z = scan.heights.copy()
    i, j = np.indices(z.shape)
    z[(i + slant * j) % 6 == 0] = np.nan
    # Both are isotropic but for chance, parts in a hundred; half of the cells are left.
    assert scan.moments().anisotropy < 1.02
    found = moments_of(z, (1e-6, 1e-6))
    assert found.anisotropy < 1.03
    # Cell by cell: the mean of what the whole surface has in those cells that are still there.
    corners = np.stack([z[:-1, :-1], z[:-1, 1:], z[1:, :-1], z[1:, 1:]])
    p, q = corners[3] - corners[0], corners[2] - corners[1]
    wanted = np.nanmean((p - q) * (p + q)) / 4e-12
    assert found.m11 == pytest.approx(wanted, rel=1e-9, abs=1e-12)


def test_blocks_and_gaps_change_nothing() -> None:
    rng = np.random.default_rng(1)
    z = rng.normal(size=(700, 900))  # several blocks of rows
    z[rng.random(z.shape) < 0.05] = np.nan
    found = moments_of(z, (2.0, 3.0))
    for axis, step, k in ((1, 2.0, 0), (0, 3.0, 1)):
        slopes, curves = np.diff(z, axis=axis) / step, np.diff(z, 2, axis=axis) / step**2
        assert found.m2_axes[k] == pytest.approx(np.nanmean(slopes**2), rel=1e-12)
        assert found.m4_axes[k] == pytest.approx(np.nanmean(curves**2), rel=1e-12)
    assert found.m0 == pytest.approx(np.nanvar(z), rel=1e-12)
    p, q = z[1:, 1:] - z[:-1, :-1], z[1:, :-1] - z[:-1, 1:]
    assert found.m11 == pytest.approx(np.nanmean((p - q) * (p + q)) / 24.0, rel=1e-10, abs=1e-12)


# Exact Gaussian fields: their moments are sums over their own waves, without any difference.


def waves(short: float, hurst: float, seed: int, n: int = 512) -> tuple[Scan, Moments]:
    """Waves of ``short`` to 100 pixels of 1 um, and their moments.

    Amplitudes are drawn, too, so this is a Gaussian field in the strict sense; m2 and m4 are sums
    over its own waves along x and along y.
    """
    qy, qx = (2e6 * math.pi * part for part in (np.fft.fftfreq(n)[:, None], np.fft.rfftfreq(n)))
    q = np.hypot(qx, qy)
    band = (q >= 2 * math.pi / 100e-6) & (q <= 2 * math.pi / (short * 1e-6))
    field = np.fft.rfft2(np.random.default_rng(seed).standard_normal((n, n)))
    field *= np.where(band, np.where(band, q * 1e-6, 1.0) ** (-1.0 - hurst), 0.0) * 1e-8
    power = np.abs(field) ** 2 / n**4
    power[:, 1:-1] *= 2.0  # the other half of the plane
    m0, m2, m4 = (0.5 * (power * (qx**k + qy**k)).sum() for k in (0, 2, 4))
    return Scan(np.fft.irfft2(field, (n, n)), 1e-6), Moments(m0, m2, m4)


@pytest.mark.parametrize("hurst", [0.2, 0.8])
@pytest.mark.parametrize(
    ("short", "low", "word"),
    [(5, 0.121, "watch"), (7, 0.0655, "watch"), (9, 0.0385, "ok"), (12, 0.0222, "ok")],
)
def test_the_pixel_lessens_the_moments_and_says_so(
    short: int, low: float, word: str, hurst: float
) -> None:
    """m4 falls short of the true one with the square of the pixel, and the verdict tells by what.

    ``low`` is the mean over both spectra of one run; it holds to a tenth of itself for either.
    """
    scan, truth = waves(short, hurst, seed=short)
    found = scan.moments()
    lost = 1.0 - found.m4 / truth.m4
    assert lost == pytest.approx(low, rel=0.1)
    assert found.m0 == pytest.approx(truth.m0, rel=1e-12)
    assert 0.0 < 1.0 - found.m2 / truth.m2 < 0.5 * lost
    verdict = next(v for v in verdicts(scan) if v.name == "fraction of m4 lost to the pixel")
    # To the first order in the square of q h, and from differences that lose m6 as well.
    assert verdict.value == pytest.approx(lost, rel=0.06)
    assert verdict.word == word == ("watch" if lost > 0.05 else "ok")


def test_what_is_lost_to_the_pixel_is_of_each_axis() -> None:
    """A sine along y of eight pixels loses h^2 q^2/6 there, however fine the pixel along x is."""
    y = np.arange(160)[:, None]
    scan = Scan(np.sin(2 * math.pi * y / 8.0) * 1e-7 + np.zeros((160, 40)), (1e-8, 1e-6))
    value = next(v.value for v in verdicts(scan) if v.name == "fraction of m4 lost to the pixel")
    seen = 2 * math.sin(math.pi / 8.0)  # what differences see of q h
    assert value == pytest.approx(seen**2 / 6, rel=0.02)
    profile = Scan(np.sin(2 * math.pi * np.arange(800) / 8.0) * 1e-7, 1e-6)
    value = next(v.value for v in verdicts(profile) if v.name == "fraction of m4 lost to the pixel")
    assert value == pytest.approx(seen**2 / 6, rel=0.02)


# White noise and scaling.


@given(height=st.floats(1e-9, 1e-5), length=st.floats(1e-8, 1e-4), seed=st.integers(0, 2**16))
def test_moments_scale(height: float, length: float, seed: int) -> None:
    z = np.random.default_rng(seed).normal(size=(20, 30))
    one, other = moments_of(z, (1.0, 1.0)), moments_of(z * height, (length, length))
    assert other.m0 == pytest.approx(one.m0 * height**2)
    assert other.m2 == pytest.approx(one.m2 * (height / length) ** 2)
    assert other.m4 == pytest.approx(one.m4 * (height / length**2) ** 2)
    assert other.nayak == pytest.approx(one.nayak)
    turned = moments_of(np.ascontiguousarray(z.T), (1.0, 1.0))
    assert turned.m2_axes == pytest.approx(one.m2_axes[::-1])
    assert turned.m11 == pytest.approx(one.m11)


# Nayak's theory.

BY_LOAD = 1.2768192821378979
"""Radius by load over radius by curvature [-], of summits of an isotropic Gaussian surface."""


def test_the_summits_of_a_gaussian_field_are_nayaks() -> None:
    # Waves of 18 pixels at least, so that eight neighbours miss and make no summits; some four
    # thousand summits, of which a count scatters by 1 to 2 %.
    scan = rough((1500, 1500), 1e-6, 7e-7, longest=6e-5, shortest=1.32e-5, seed=11)
    z = scan.heights
    inner = z[1:-1, 1:-1]
    top = np.ones(inner.shape, dtype=bool)
    for i in range(3):
        for j in range(3):
            if (i, j) != (1, 1):
                top &= inner > z[i : i + inner.shape[0], j : j + inner.shape[1]]
    heights = inner[top]
    theory = scan.moments().mccool()
    assert heights.size > 3500
    # Of N independent summits the count scatters by 1/sqrt N = 1.6 %, the std by 1.1 %, the mean of
    # heights, which is about their std, by 1.6 %; near ones are alike, so the std scatters more.
    assert heights.size / (inner.size * 1e-12) == pytest.approx(theory.density, rel=0.03)
    assert heights.mean() == pytest.approx(theory.mean_height, rel=0.03)
    assert heights.std() == pytest.approx(theory.std, rel=0.04)
    kxx = (2 * z - np.roll(z, 1, 1) - np.roll(z, -1, 1))[1:-1, 1:-1][top] / 1e-12
    kyy = (2 * z - np.roll(z, 1, 0) - np.roll(z, -1, 0))[1:-1, 1:-1][top] / 1e-12
    mean = 0.5 * (kxx + kyy)
    # Curvatures differ by half of themselves, so their mean by 0.8 %; both saw the same pixel.
    assert mean.mean() == pytest.approx(1.0 / theory.radius, rel=0.02)


def test_nayaks_density_by_the_determinant_of_random_curvatures() -> None:
    """Another road: draw second derivatives of the field and weigh summits by hand."""
    rng = np.random.default_rng(3)
    m0, m2, m4 = 1.0, 1.0, 2.5
    cov = np.array(
        [
            [m0, -m2, -m2, 0.0],
            [-m2, m4, m4 / 3, 0.0],
            [-m2, m4 / 3, m4, 0.0],
            [0.0, 0.0, 0.0, m4 / 3],
        ]
    )
    z, xx, yy, xy = rng.multivariate_normal(np.zeros(4), cov, size=1_000_000).T
    det = xx * yy - xy * xy
    weight = np.where((det > 0) & (xx + yy < 0), det, 0.0)
    theory = Moments(m0, m2, m4).mccool()
    # A million draws: parts in a thousand.
    assert weight.mean() / (2 * math.pi * m2) == pytest.approx(theory.density, rel=5e-3)
    assert (weight @ z) / weight.sum() == pytest.approx(theory.mean_height, rel=5e-3)
    roots = np.where(weight > 0, np.abs(det), 1.0) ** -0.25
    radius = ((weight @ roots) / weight.sum()) ** 2
    assert radius == pytest.approx(BY_LOAD * theory.radius, rel=5e-3)


# Spectra.


def test_a_sine_stands_in_its_ring() -> None:
    h, wave = 1e-6, 20e-6
    x = np.arange(400) * h
    z = 1e-7 * np.sin(2 * math.pi * x / wave) + np.zeros((300, 1))
    found = Scan(z, h).spectrum()
    # The next ring is a wave more or less of 20 along x, 5 % away.
    assert found.wavelength[int(np.argmax(found.power))] == pytest.approx(wave, rel=0.02)
    assert found.power.sum() == pytest.approx(0.5e-14, rel=1e-3)
    assert found.axes[0].power.sum() == pytest.approx(0.5e-14, rel=1e-3)
    # The density, integrated over the plane of wavenumbers, but for the raggedness of the rings.
    widths = np.diff(found.wavenumber, prepend=0.0)
    assert np.sum(2 * math.pi * found.wavenumber * found.density * widths) == pytest.approx(
        0.5e-14, rel=0.02
    )


def test_a_profile_has_a_spectrum() -> None:
    h = 1e-6
    z = 1e-7 * np.sin(2 * math.pi * np.arange(1000) * h / 25e-6)
    found = Scan(z, h).spectrum()
    assert found.power.sum() == pytest.approx(0.5e-14, rel=1e-9)
    assert found.wavelength[int(np.argmax(found.power))] == pytest.approx(25e-6)


def test_few_missing_points_hardly_change_a_spectrum() -> None:
    scan = rough((256, 256), 1e-6, 5e-7, longest=4.6e-5, shortest=1.02e-5, seed=8)
    z = scan.heights.copy()
    z[100:110, 50:60] = np.nan
    whole, gappy = scan.spectrum(), Scan(z, 1e-6).spectrum()
    # 0.15 % of the points are gone, and where they are the taper weighs more than in the mean.
    assert gappy.power.sum() == pytest.approx(whole.power.sum(), rel=0.02)


# The files.

RECKONING = {
    # rms, McCool's density, radius and std by an independent reckoning
    "plu-1.plu": (18.2e-9, 1.66e10, 276e-6, 17.7e-9),
    "al3d-1.al3d": (259e-9, 2.07e10, 12.7e-6, 249e-9),
}
NEEDS = pytest.mark.skipif(not SCANS.exists(), reason="the scans in ../shared/data are not here")


def real(name: str) -> Scan:
    pytest.importorskip("SurfaceTopography", reason="the extra microslip[scan] is not installed")
    return Scan.read(SCANS / name, name.split(".")[-1]).condition(level="quadratic")


@NEEDS
@pytest.mark.parametrize("name", sorted(RECKONING))
def test_measured_surfaces_have_their_parameters(name: str) -> None:
    scan = real(name)
    rms, density, radius, std = RECKONING[name]
    assert scan.statistics().rms == pytest.approx(rms, rel=0.01)
    found = scan.moments().mccool()
    assert found.density == pytest.approx(density, rel=0.01)
    assert found.radius == pytest.approx(radius, rel=0.01)
    assert found.std == pytest.approx(std, rel=0.01)


@NEEDS
def test_a_scratch_is_reported() -> None:
    scan = real("mnt-1.mnt")
    assert scan.statistics().kurtosis > 300.0
    words = {verdict.name: verdict.word for verdict in verdicts(scan)}
    assert words["kurtosis"] == "outside"
    assert words["fraction of m0 in 0.1 % of points"] == "outside"
    assert words["fraction of m4 lost to the pixel"] == "outside"
    fine = {verdict.name: verdict.word for verdict in verdicts(real("al3d-1.al3d"))}
    # Its form is long waves, its curvature noise: without a cut-off the pixel makes m4.
    assert fine.pop("fraction of m4 lost to the pixel") == "outside"
    assert fine == dict.fromkeys(fine, "ok")
    smooth = verdicts(real("al3d-1.al3d").condition(cutoff=5e-6))
    assert [v.word for v in smooth if v.name.startswith("fraction of m4 lost")] == ["ok"]


# The cut-off decides.


def test_a_cutoff_makes_summits_fewer_and_rounder() -> None:
    scan = rough((200, 240), 1e-6, 4e-7, longest=4.2e-5, shortest=4.25e-6, seed=7)
    tables = [scan.summits(cutoff) for cutoff in (None, 6e-6, 12e-6, 20e-6)]
    moments = [summits.scan.moments() for summits in tables]
    for name in ("rms", "m2", "m4"):
        assert (np.diff([getattr(item, name) for item in moments]) < 0.0).all(), name
    assert (np.diff([summits.density for summits in tables]) < 0.0).all()
    assert (np.diff([item.mccool().density for item in moments]) < 0.0).all()
    assert (np.diff([item.mccool().radius for item in moments]) > 0.0).all()
