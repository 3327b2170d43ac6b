"""Parameters of scans: their numbers on small arrays, and what is refused and why."""

from __future__ import annotations

import copy
import math
import pickle
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from scipy import stats

from microslip.errors import InputError
from microslip.scans import (
    HeightFit,
    Moments,
    NayakSummits,
    Scan,
    SummitStatistics,
    combine,
    cut,
    default_cutoffs,
    extreme_shares,
    height_distribution,
    over_cutoffs,
    patch_errors,
    random_surface,
    verdicts,
)
from microslip.scans import paraboloids as paraboloids
from microslip.scans.height_fit import height_distribution_of
from microslip.scans.moments import moments_of, statistics_of
from microslip.scans.spectrum import spectrum

RNG = np.random.default_rng(7)
NOISE = Scan(RNG.normal(size=(60, 80)) * 1e-7, (1e-6, 2e-6))
SUMMITS = SummitStatistics(density=1e10, radius=1e-5, std=2e-7)


# Heights.


def test_height_parameters_are_those_of_scipy() -> None:
    z = RNG.gamma(3.0, 1e-7, size=(90, 110))
    z[3, 4:20] = np.nan
    there = z[~np.isnan(z)]
    found = Scan(z, 1e-6).statistics()
    assert found.mean == pytest.approx(there.mean())
    assert found.rms == pytest.approx(there.std())
    assert found.mean_deviation == pytest.approx(np.abs(there - there.mean()).mean())
    assert found.skewness == pytest.approx(stats.skew(there))
    assert found.kurtosis == pytest.approx(stats.kurtosis(there, fisher=False))
    assert found.flatness == pytest.approx(np.ptp(there))
    assert found.highest == pytest.approx(there.max() - there.mean())
    assert found.count == there.size
    assert found.missing == pytest.approx(16 / z.size)


def test_tiny_and_huge_heights_stay_finite() -> None:
    for size in (1e-35, 1e35):
        found = statistics_of(np.array([0.0, 1.0, 2.0, 7.0]) * size)
        assert found.kurtosis == pytest.approx(statistics_of(np.array([0.0, 1, 2, 7])).kurtosis)


def test_shares_of_the_extreme_points() -> None:
    shares = extreme_shares(Scan(np.random.default_rng(0).normal(size=(500, 600)), 1.0))
    # Twice the integral of x^2 phi above the quantile of 0.05 %; 300 points of extremes: 2 %.
    x = stats.norm.isf(0.0005)
    expected = 2 * (x * stats.norm.pdf(x) + stats.norm.sf(x))
    assert shares == pytest.approx((expected,) * 3, rel=0.02)
    z = np.random.default_rng(0).normal(size=(100, 100)) * 1e-9
    z[50, 50] += 1e-6
    assert min(extreme_shares(Scan(z, 1e-6))) > 0.9


def test_verdicts_on_noise_and_on_a_surface() -> None:
    noise = {verdict.name: verdict for verdict in verdicts(NOISE)}
    assert noise["share of m4 lost to the pixel"].word == "outside"
    assert noise["kurtosis"].word == "ok"
    fine = random_surface((300, 300), 1e-6, m0=1.2e-13, m2=0.004, m4=0.004 * 0.1e12)
    assert {verdict.word for verdict in verdicts(fine)} == {"ok"}
    profile = Scan(RNG.normal(size=500).cumsum() * 1e-9, 1e-6)
    assert "anisotropy" not in {verdict.name for verdict in verdicts(profile)}


# Moments.


def test_moments_of_a_profile() -> None:
    z = RNG.normal(size=300)
    found = Scan(z, 0.5).moments()
    assert found.m0 == pytest.approx(z.var())
    assert found.m2 == pytest.approx(np.mean(np.diff(z) ** 2) / 0.25)
    assert found.m4 == pytest.approx(np.mean(np.diff(z, 2) ** 2) / 0.5**4)
    assert (found.anisotropy, found.lay) == (1.0, 0.0)
    assert found.rms_slope == math.sqrt(found.m2)
    assert found.rms_curvature == math.sqrt(found.m4)


def test_white_noise_has_the_moments_of_its_differences() -> None:
    found = moments_of(np.random.default_rng(2).normal(size=(800, 800)), (1.0, 1.0))
    # Variances of sums of squares of coefficients: 1, 2 and 6; 640 000 points.
    assert (found.m0, found.m2, found.m4) == pytest.approx((1.0, 2.0, 6.0), rel=0.01)
    assert found.nayak == pytest.approx(1.5, rel=0.01)


@pytest.mark.parametrize("bad", [0.0, -1.0, math.nan, math.inf, "1", None])
@pytest.mark.parametrize("at", [0, 1, 2])
def test_moments_must_be_positive(bad: Any, at: int) -> None:
    numbers: list[Any] = [1.0, 1.0, 3.0]
    numbers[at] = bad
    for kind in (Moments, NayakSummits):
        with pytest.raises(InputError, match=f"m{2 * at} must be"):
            kind(*numbers)


@pytest.mark.parametrize(
    ("name", "bad"),
    [("density", 0.0), ("radius", -1e-6), ("std", -1e-9), ("std", "1 um"), ("mean_height", None)],
)
def test_summit_statistics_check_their_numbers(name: str, bad: Any) -> None:
    numbers: dict[str, Any] = {"density": 1e10, "radius": 1e-5, "std": 1e-7} | {name: bad}
    with pytest.raises(InputError, match=name):
        SummitStatistics(**numbers)


def test_nayak_takes_any_shape() -> None:
    theory = NayakSummits(1.0, 1.0, 3.0)
    for function in (theory.height_density, theory.share_below, theory.curvature_at):
        assert isinstance(function(0.5), float)
        grid = function(np.linspace(-2, 3, 6).reshape(2, 3))
        assert grid.shape == (2, 3)
        assert grid[0, 0] == pytest.approx(function(-2.0), rel=1e-12)
        assert np.isfinite(function([-50.0, -10.0, 10.0, 50.0])).all()
        with pytest.raises(InputError, match="finite"):
            function(math.nan)
    assert theory.statistics().estimate == "nayak"
    assert theory.radius < theory.equivalent_radius


def test_two_kinds_do_not_combine() -> None:
    assert combine(SUMMITS, SUMMITS).estimate == "combined given"
    profile, area = Scan(RNG.normal(size=99), 1.0).moments(), NOISE.moments()
    assert combine(profile, area).m2_axes == ()


# Spectra.


def test_a_spectrum_says_its_band_and_is_locked() -> None:
    scan = Scan(NOISE.heights, NOISE.pixel, cutoff=5e-6, long_cutoff=40e-6)
    found = pickle.loads(pickle.dumps(scan.spectrum()))
    assert (found.cutoff, found.long_cutoff, found.window) == (5e-6, 40e-6, "hann")
    for array in (found.wavenumber, found.density, found.power, found.axes[1].power):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    assert (np.diff(found.wavenumber) > 0).all()
    assert found.wavelength[0] <= 1.5 * max(scan.size)


@pytest.mark.parametrize("shape", [(2, 2), (2, 9), (9, 2), (3, 3)])
def test_the_smallest_scans_have_spectra(shape: tuple[int, int]) -> None:
    scan = Scan(RNG.normal(size=shape), (1.0, 0.5))
    found = spectrum(scan, window=None)
    assert found.m0 == pytest.approx(scan.heights.var())
    assert math.isfinite(scan.spectrum().m0)


# Height densities.


def best_of(values: Any) -> HeightFit:
    return height_distribution_of(np.asarray(values))


@pytest.mark.parametrize(
    ("law", "names"),
    [
        (stats.norm(3e-7, 2e-8), ("gaussian",)),
        (stats.skewnorm(4.0, 0.0, 1e-7), ("skew-normal",)),
        (stats.lognorm(0.5, 1e-7, 1e-7), ("lognormal",)),
        (stats.weibull_min(1.5, 0.0, 1e-7), ("weibull",)),
        (stats.t(3.0, 0.0, 1e-7), ("student t",)),
        # A Weibull distribution of shape 1 is the exponential one.
        (stats.expon(-1e-7, 1e-7), ("exponential", "weibull")),
    ],
)
@pytest.mark.parametrize("mirrored", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_each_law_is_recognised(law: Any, names: tuple[str, ...], mirrored: bool) -> None:
    z = law.ppf((np.arange(4000) + 0.5) / 4000)
    found = best_of(-z if mirrored else z)
    assert found.best.name in names or found.best.effect == pytest.approx(0.0, abs=0.02)
    fit = next(fit for fit in found.fits if fit.name == names[0])
    assert fit.word == "ok"
    assert fit.effect < 0.1
    if names[0] not in ("gaussian", "student t"):
        assert fit.mirrored is mirrored
    # Of that side, not of its mirror image.
    height = -law.ppf(0.3) if mirrored else law.ppf(0.3)
    assert fit.share_below(height) == pytest.approx(0.7 if mirrored else 0.3, abs=0.005)
    # The density is the slope of the distribution function.
    step = 1e-4 * z.std()
    slope = (fit.share_below(height + step) - fit.share_below(height - step)) / (2 * step)
    assert fit.density(height) == pytest.approx(slope, rel=1e-4)


def test_the_verdict_is_on_the_effect_and_not_on_the_number_of_points() -> None:
    # A little skewed: rejected by tests on a million points, and of no consequence.
    law = stats.skewnorm(0.8)
    few, many = (best_of(law.ppf((np.arange(n) + 0.5) / n)) for n in (2000, 20_000))
    assert few.gaussian.share == pytest.approx(many.gaussian.share, abs=1e-3)
    assert many.gaussian.word == "ok"
    assert "Gaussian to practical accuracy" in many.verdict
    skew = best_of(stats.expon.ppf((np.arange(9000) + 0.5) / 9000))
    assert skew.gaussian.word == "outside"
    assert "not Gaussian" in skew.verdict
    assert {verdict.word for verdict in skew.verdicts()} == {"outside"}


def test_the_tail_of_an_exponential_is_its_scale() -> None:
    z = stats.expon.ppf((np.arange(100_000) + 0.5) / 100_000) * 2e-7
    found = best_of(z)
    assert found.tail_scale == pytest.approx(2e-7, rel=1e-3)
    assert found.tail_start == pytest.approx(2e-7 * math.log(10.0), rel=1e-3)
    assert found.tail_share < 1e-3


def test_the_density_integrates_to_the_points_in_its_bins() -> None:
    z = np.append(RNG.normal(size=20_000) * 1e-8, -1e-5)  # and a pit
    found = height_distribution(Scan(z, 1e-6), bins=80)
    width = found.height[1] - found.height[0]
    assert found.height.size == found.density.size == 80
    assert found.density.sum() * width == pytest.approx(1.0, abs=1e-3)
    assert found.height[0] > -1e-7  # the pit leaves the bins to the others


@pytest.mark.parametrize("size", [1e-30, pytest.param(1e30, marks=pytest.mark.slow)])
def test_fits_scale(size: float) -> None:
    z = stats.skewnorm(3.0).ppf((np.arange(500) + 0.5) / 500)
    one, other = best_of(z), best_of(z * size)
    assert other.best.name == one.best.name
    assert other.best.share == pytest.approx(one.best.share, rel=1e-3)
    assert other.best.scale == pytest.approx(one.best.scale * size, rel=1e-3)


def test_heights_of_two_values_and_too_few_are_dealt_with() -> None:
    two = best_of([0.0] * 50 + [1.0] * 50)
    assert two.gaussian.word == "outside"


# Patches.


def test_patches_are_the_scan() -> None:
    parts = cut(NOISE, (2, 3))
    rows = [np.hstack([part.heights for part in parts[3 * i : 3 * i + 3]]) for i in range(2)]
    assert np.array_equal(np.vstack(rows), NOISE.heights)
    assert all(part.pixel == NOISE.pixel for part in parts)
    assert "patch (0, 1) of (2, 3)" in parts[1].notes[-1]


def test_errors_of_patches() -> None:
    found = patch_errors(NOISE, "rms", (3, 4))
    values = [part.statistics().rms for part in cut(NOISE, (3, 4))]
    assert found.values.tolist() == pytest.approx(values)
    scatter = np.std(values, ddof=1) / math.sqrt(12)
    assert found.standard_error == pytest.approx(max(scatter, found.long_waves))
    # Of white noise the rms is known to one over the root of twice the points.
    assert found.long_waves / found.value == pytest.approx(
        1.0 / math.sqrt(2.0 * NOISE.heights.size), rel=0.1
    )
    assert found.bias == pytest.approx(np.mean(values) - NOISE.statistics().rms)
    low, high = found.interval(0.9)
    reach = stats.t(11).ppf(0.95) * found.standard_error
    assert (low, high) == pytest.approx((found.value - reach, found.value + reach))
    own = patch_errors(NOISE, lambda scan: float(np.nanmax(scan.heights)))
    assert own.value == NOISE.heights.max()
    assert own.values.max() == NOISE.heights.max()


def test_patches_without_points_are_left_out() -> None:
    z = NOISE.heights.copy()
    z[:30, :40] = np.nan
    found = patch_errors(Scan(z, 1e-6), "m2", (2, 2))
    assert (found.values.size, found.failed) == (3, 1)  # one holds no point
    z[:30, 41:] = np.nan  # a patch with a single column: no slopes along x
    z[2:30, 40] = np.nan
    found = patch_errors(Scan(z, 1e-6), "m2", (2, 2))
    assert (found.values.size, found.failed) == (2, 2)


def test_a_profile_has_patches() -> None:
    assert patch_errors(Scan(RNG.normal(size=300), 1.0), "m0", 5).values.size == 5
    assert patch_errors(Scan(RNG.normal(size=300), 1.0), "m0").values.size == 9
    nine = (np.int64(3), np.int64(3))
    assert patch_errors(Scan(RNG.normal(size=300), 1.0), "m0", nine).values.size == 9


# Cut-offs.


def test_default_cutoffs() -> None:
    found = default_cutoffs(NOISE)
    assert found[0] == 0.0
    assert found[1] == pytest.approx(8e-6)
    assert found[-1] == pytest.approx(80e-6 / 3)  # of 60 x 80 points
    assert default_cutoffs(Scan(np.eye(11), 1e-6)).tolist() == [0.0]
    long = Scan(np.random.default_rng(0).normal(size=(400, 400)), 1e-6, cutoff=10e-6)
    assert default_cutoffs(long)[1] == pytest.approx(12.5e-6)
    assert default_cutoffs(long)[-1] == pytest.approx(50e-6)  # an eighth of 400 um
    banded = Scan(long.heights, 1e-6, long_cutoff=30e-6)
    assert default_cutoffs(banded)[-1] == pytest.approx(15e-6)


@pytest.mark.parametrize("shape", [(40, 50), (16, 16), (12, 300), (90, 90), (600, 130)])
def test_default_cutoffs_of_small_scans_are_worth_a_table(shape: tuple[int, int]) -> None:
    """Several, a quarter apart or more, up to a third of the side or four times the least."""
    scan = Scan(np.random.default_rng(0).normal(size=shape), 1e-6)
    found = default_cutoffs(scan)[1:]
    side = min(shape) * 1e-6
    assert found[0] == pytest.approx(4e-6)
    assert found[-1] == pytest.approx(max(side / 8, min(side / 3, 16e-6)))
    assert found.size == (1 if side < 13e-6 else found.size) <= 8
    assert (found[1:] / found[:-1] > 1.15).all()
    table = over_cutoffs(scan)
    assert np.isfinite(table.mccool_radius).sum() >= found.size


def test_a_table_of_cutoffs() -> None:
    calls: list[tuple[int, int]] = []
    table = over_cutoffs(
        NOISE, [10e-6, 0.0], counted=False, progress=lambda done, all_: calls.append((done, all_))
    )
    assert calls == [(1, 2), (2, 2)]
    assert table.cutoff.tolist() == [0.0, 10e-6]
    assert np.isnan(table.counted_density).all()
    rows = table.rows()
    assert list(rows[0]) == list(table.names)
    assert rows[1]["mccool_radius"] == table.mccool_radius[1]
    with pytest.raises(ValueError, match="read-only"):
        copy.deepcopy(table).rms[0] = 1.0


def test_a_profile_has_no_counted_summits() -> None:
    table = over_cutoffs(Scan(RNG.normal(size=400), 1e-6), [0.0, 2e-5])
    assert np.isfinite(table.mccool_density).all()
    assert np.isnan(table.counted).all()
    assert any("no summits to count" in note for note in table.notes)


@pytest.mark.parametrize("cutoffs", [["10 um", None], ("10 um", 0.0), [1e-5, 0], [None, 1e-5]])
def test_cutoffs_as_text_and_as_numbers(cutoffs: Any) -> None:
    assert over_cutoffs(NOISE, cutoffs, counted=False).cutoff.tolist() == [0.0, 1e-5]


# Made surfaces.

WAVES: dict[str, Any] = {"m0": 1.6e-13, "m2": 0.004, "m4": 0.004 * 0.1e12}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"m0": 0.0}, "m0 must be above zero"),
        ({"m2": "steep"}, "m2 must be"),
        ({"m0": 1e-18}, r"above 1\.5"),
        ({"m0": 5.2e-14}, r"below 1\.5"),
        ({"m0": 1e-9}, "it goes up to"),
        ({"m4": 1e12}, "cannot be had on this grid"),
        ({"m4": 1.0}, "cannot be had on this grid"),
        ({"hurst": 5.0}, "hurst must be from"),
        ({"seed": -1}, "seed must be"),
        ({"seed": 1.5}, "seed must be"),
        ({"shape": (8, 100)}, "16 or more"),
        ({"shape": (100,)}, "rows, columns"),
        ({"shape": (100.0, 100)}, "rows, columns"),
        ({"shape": (10**6, 10**6)}, "points in all"),
        ({"pixel": 0.0}, "pixel must be"),
        ({"pixel": (1e-6, 1e-6, 1e-6)}, "pixel must be"),
    ],
)
def test_surfaces_that_cannot_be_made(change: dict[str, Any], message: str) -> None:
    arguments: dict[str, Any] = {"shape": (64, 64), "pixel": 1e-6, **WAVES, **change}
    with pytest.raises(InputError, match=message):
        random_surface(arguments.pop("shape"), arguments.pop("pixel"), **arguments)


def test_a_made_surface_describes_itself() -> None:
    scan = random_surface((64, 80), 1e-6, **WAVES, seed=3, name="mine")
    assert (scan.name, scan.heights.shape) == ("mine", (64, 80))
    assert "seed 3" in scan.notes[0]
    assert abs(scan.heights.mean()) < 1e-12 * scan.statistics().rms


HILLS: dict[str, Any] = {
    "positions": [[10e-6, 10e-6], [30e-6, 20e-6]],
    "heights": [1e-6, 2e-6],
    "radii": 5e-6,
}


def test_importing_scans_loads_no_scipy() -> None:
    code = (
        "import sys, microslip.scans; "
        "print([name for name in sys.modules if name.startswith(('scipy', 'matplotlib'))])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_summits_known_before_are_not_sought_again() -> None:
    scan = random_surface((96, 96), 1e-6, m0=1e-14, m2=1e-4, m4=4e6, seed=1)
    known = scan.summits(8e-6)
    one = over_cutoffs(scan, [0.0, 8e-6])
    two = over_cutoffs(scan, [0.0, 8e-6], known=known)
    for name in one.names:
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))


def test_steep_heights_are_reported() -> None:
    """Such as heights in another unit than the one that was said."""
    scan = random_surface((96, 96), 1e-6, m0=1e-14, m2=1e-4, m4=4e6, seed=1)
    words = {v.name: v.word for v in verdicts(scan)}
    assert words["rms slope"] == "ok"
    words = {v.name: v.word for v in verdicts(Scan(1e3 * scan.heights, 1e-6))}
    assert words["rms slope"] == "outside"
