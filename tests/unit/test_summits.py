"""Summits of scans: what counts, what is noted, what is refused."""

from __future__ import annotations

import copy

import numpy as np
import pytest
from made_surfaces import rough
from usual import PAIR

import microslip as ms
from microslip.surfaces.height_map import noise_passed, noise_std


def dome(shape: tuple[int, int] = (9, 11), at: tuple[int, int] = (4, 5)) -> np.ndarray:
    y, x = np.indices(shape)
    return -1e-9 * ((x - at[1]) ** 2 + (y - at[0]) ** 2)


def noisy(seed: int = 0, shape: tuple[int, int] = (60, 80)) -> ms.Scan:
    return ms.Scan(1e-7 * np.random.default_rng(seed).standard_normal(shape), 1e-6)


# -- what counts -----------------------------------------------------------------------------------


def test_edges_of_gaps_have_no_summits() -> None:
    heights = np.concatenate([dome(), dome()], axis=1)
    heights[3, 4] = np.nan  # a neighbour of the first top
    found = ms.Scan(heights, 1e-6).summits(None, prominence=0.0)
    np.testing.assert_allclose(found.positions, [[16e-6, 4e-6]], atol=1e-15)
    # A square of nine points is lost with one.
    assert found.area == pytest.approx((7 * 20 - 9) * 1e-12, rel=1e-12)


def test_plateaus_count_once() -> None:
    heights = np.maximum(np.concatenate([dome(), dome()], axis=1), -8e-9)
    heights = np.minimum(heights, -1.5e-9)  # flat tops of five points, a flat ground
    found = ms.Scan(heights, 1e-6).summits(None, prominence=0.0)
    assert found.count == 2
    np.testing.assert_allclose(found.prominences, 6.5e-9, rtol=1e-9)


def test_terraces_are_no_summits() -> None:
    """Flat steps on a slope: no point of theirs is above the next step."""
    heights = np.floor(np.indices((12, 20))[1] / 4.0) * 1e-7
    with pytest.raises(ms.InputError, match="no point is above its eight neighbours"):
        ms.Scan(heights, 1e-6).summits(None)


def test_the_threshold_decides_what_counts() -> None:
    scan = noisy()
    low = scan.summits(None, prominence=0.0)
    high = scan.summits(None, prominence=3e-7)
    assert low.count + low.dropped == low.peaks == high.peaks
    assert high.count < 0.1 * low.peaks
    assert high.prominences.min() >= 3e-7
    assert scan.summits(None).threshold == pytest.approx(3e-7, rel=0.1)
    np.testing.assert_array_equal(scan.summits(None, prominence="300 nm").radii, high.radii)


# -- noise -----------------------------------------------------------------------------------------


def test_noise_of_white_noise() -> None:
    rng = np.random.default_rng(0)
    noise = 2e-9 * rng.standard_normal((300, 400))
    y, x = np.indices(noise.shape) * 1e-6
    assert noise_std(noise) == pytest.approx(2e-9, rel=0.02)
    assert noise_std(noise + 5.0 * x**3 + 0.1 * x * y + 3.0 * y) == pytest.approx(2e-9, rel=0.02)
    spikes = noise.copy()
    spikes[rng.integers(0, 300, 60), rng.integers(0, 400, 60)] += 1e-6
    # Sixty spikes spoil nine points each, half a per cent of all, which move a median by about 1 %.
    assert noise_std(spikes) == pytest.approx(2e-9, rel=0.03)
    smooth = ms.Scan(noise, (1e-6, 2e-6)).condition(cutoff=12e-6).heights
    passed = noise_passed(2e-9, (1e-6, 2e-6), 12e-6)
    assert smooth[20:-20, 20:-20].std() == pytest.approx(passed, rel=0.1)
    assert noise_passed(2e-9, (1e-6, 2e-6), None) == 2e-9
    assert noise_std(np.zeros((2, 9))) == 0.0


# -- joints ----------------------------------------------------------------------------------------


def test_surfaces() -> None:
    found = noisy().summits(1e-5, prominence=0.0)
    surface = found.to_surface(PAIR)
    assert isinstance(surface, ms.GreenwoodWilliamson)
    assert surface.area == found.scan.area
    assert (surface.radius, surface.density) == (found.equivalent_radius, found.density)
    assert surface.heights == ms.Gaussian(found.std, found.mean_height)
    population = found.to_surface(PAIR, heights="population")
    assert isinstance(population, ms.AsperityPopulation)
    assert found.to_surface(PAIR, "2 cm^2").area == pytest.approx(2e-4)
    # A little more than was counted, for the edge on which none could be.
    assert found.count <= population.summit_count < 1.2 * found.count
    assert population.summit_count == pytest.approx(found.density * found.scan.area, rel=1e-14)
    with pytest.raises(ms.InputError, match='"gaussian" or "population", got'):
        found.to_surface(PAIR, heights="table")  # type: ignore[arg-type]
    # As many as an area of ten square metres has: each summit with its weight.
    large = found.to_surface(PAIR, 10.0, heights="population")
    ratio = 10.0 / found.scan.area
    assert large.load(1e-8) == pytest.approx(ratio * population.load(1e-8), rel=1e-14)
    assert large.contact_area(0.0) == pytest.approx(ratio * population.contact_area(0.0), rel=1e-14)


# -- a cut-off twice -------------------------------------------------------------------------------


def test_the_same_cutoff_twice_filters_once() -> None:
    scan = noisy(shape=(120, 120))
    once = scan.condition(cutoff="10 um")
    again, before = once.summits("10 um", prominence=0.0), once.summits(None, prominence=0.0)
    assert again.cutoff == before.cutoff == pytest.approx(1e-5)
    np.testing.assert_array_equal(again.heights, before.heights)
    np.testing.assert_array_equal(again.heights, scan.summits("10 um", prominence=0.0).heights)


def test_noise_is_that_before_the_cutoff_wherever_it_was_applied() -> None:
    """Behind a filter hardly a difference from point to point is left to tell noise by."""
    smooth = rough((120, 120), 1e-6, 1e-7, longest=7.2e-5, shortest=2.7e-5, seed=2)
    scan = ms.Scan(smooth.heights + noisy(shape=(120, 120)).heights / 20.0, 1e-6)
    once = scan.condition(level="plane", cutoff="6 um")
    wanted = scan.condition(level="plane").summits("6 um")
    for found in (once.summits(None), once.summits("6 um"), copy.deepcopy(once).summits(None)):
        assert found.threshold == pytest.approx(wanted.threshold, rel=1e-6)
        assert found.count == wanted.count
    further = once.summits("12 um")
    assert further.threshold == pytest.approx(scan.summits("12 um").threshold, rel=1e-6)
    whole = once.condition(crop="30 um").summits(None).threshold
    assert whole == pytest.approx(wanted.threshold, rel=1e-6)
    # Of heights that came filtered from elsewhere nothing else is known.
    other = ms.Scan(once.heights, 1e-6, cutoff=6e-6).summits(None)
    assert other.threshold < 0.5 * wanted.threshold
