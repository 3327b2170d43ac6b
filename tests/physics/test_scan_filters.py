"""Conditioning of scans against the formulas of ISO 16610, brute force and what must not matter."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import microslip as ms
from microslip.surfaces import filters
from microslip.surfaces.conditioning import filled as fill
from microslip.surfaces.filters import smooth, weights
from microslip.surfaces.levelling import level

STEP = 2e-6
RNG = np.random.default_rng(19)
ROUGH = RNG.normal(scale=1e-7, size=(61, 83))
HOLED = np.where(RNG.random(ROUGH.shape) < 0.2, np.nan, ROUGH)


def transmission(wavelength: Any, cutoff: float) -> Any:
    """ISO 16610-21 and -61: the amplitude that a short-wave filter leaves of a wave."""
    return 0.5 ** ((cutoff / wavelength) ** 2)


def amplitude(values: np.ndarray, wave: np.ndarray) -> float:
    """Amplitude of a wave in values, by least squares."""
    return float((values * wave).sum() / (wave * wave).sum())


# -- transmission ----------------------------------------------------------------------------------


@pytest.mark.parametrize("cutoff", [2.01, 2.5, 3.0, 4.0, 7.3, 40.0, 333.0])
def test_weights_transmit_half_at_the_cut_off(cutoff: float) -> None:
    w = weights(cutoff)
    place = np.arange(w.size) - w.size // 2
    assert (w > 0.0).all()
    assert w.sum() == pytest.approx(1.0, rel=1e-14)
    assert (w * np.cos(2.0 * np.pi * place / cutoff)).sum() == pytest.approx(0.5, abs=1e-12)


@pytest.mark.parametrize(
    ("cutoff", "off"), [(4.0, 0.065), (5.0, 0.014), (6.0, 2.1e-3), (9.0, 1e-6), (60.0, 1e-6)]
)
def test_weights_follow_the_formula_as_stated(cutoff: float, off: float) -> None:
    w = weights(cutoff)
    place = np.arange(w.size) - w.size // 2
    wavelength = 2.0 * np.geomspace(1.0, 500.0, 60)
    found = np.cos(2.0 * np.pi * np.outer(1.0 / wavelength, place)) @ w
    difference = np.abs(found - transmission(wavelength, cutoff)).max()
    assert difference < off
    if off > 1e-5:  # what the docstring states is no exaggeration either
        assert difference > 0.8 * off


@pytest.mark.parametrize("cutoff", [12.0, 80.0], ids=["direct", "by transform"])
@pytest.mark.parametrize("waves", [(1.0, 0.0), (0.0, 1.0), (0.6, 0.8)], ids=["x", "y", "skew"])
@pytest.mark.parametrize("ratio", [0.5, 1.0, 2.0])
def test_a_wave_keeps_the_share_that_the_standard_says(
    cutoff: float, waves: tuple[float, float], ratio: float
) -> None:
    # ISO 16610-61: what counts is the wavelength, whatever the direction.
    n = 400
    y, x = np.mgrid[:n, :n] * STEP
    phase = 2.0 * np.pi / (ratio * cutoff * STEP) * (waves[0] * x + waves[1] * y)
    scan = ms.Scan(1e-7 * np.sin(phase), STEP)
    inner = (slice(100, -100),) * 2  # a cut-off and more away from the edges
    wave = np.sin(phase)[inner]
    low = amplitude(scan.condition(cutoff=cutoff * STEP).heights[inner], wave)
    high = amplitude(scan.condition(long_cutoff=cutoff * STEP).heights[inner], wave)
    expected = 0.5 ** (1.0 / ratio**2)
    # The weights end at one cut-off, where they have come down to 7e-7.
    assert low == pytest.approx(1e-7 * expected, abs=1e-7 * 2e-6)
    assert high == pytest.approx(1e-7 * (1.0 - expected), abs=1e-7 * 2e-6)


def test_a_band_is_the_product_of_both() -> None:
    x = np.arange(3000) * STEP
    short, long, middle = 10 * STEP, 200 * STEP, 50 * STEP
    wave = np.sin(2.0 * np.pi * x / middle)
    band = ms.Scan(1e-6 * wave, STEP).condition(cutoff=short, long_cutoff=long)
    expected = transmission(middle, short) * (1.0 - transmission(middle, long))
    inner = slice(600, -600)
    assert amplitude(band.heights[inner], wave[inner]) == pytest.approx(1e-6 * expected, rel=2e-6)
    assert (band.cutoff, band.long_cutoff) == (short, long)


def test_pixels_may_be_longer_than_wide() -> None:
    y, x = np.mgrid[:200, :300]
    x, y = x * STEP, y * 2.0 * STEP
    for axis in (x, y):
        wave = np.sin(2.0 * np.pi * axis / (30 * STEP))
        out = ms.Scan(wave, (STEP, 2.0 * STEP)).condition(cutoff=30 * STEP).heights
        inner = (slice(60, -60),) * 2
        assert amplitude(out[inner], wave[inner]) == pytest.approx(0.5, abs=2e-6)


def test_two_short_cut_offs_add_in_squares() -> None:
    scan = ms.Scan(ROUGH, STEP)
    twice = scan.condition(cutoff=9 * STEP).condition(cutoff=12 * STEP)
    once = scan.condition(cutoff=15 * STEP)
    assert twice.cutoff == pytest.approx(15 * STEP, rel=1e-14)
    inner = (slice(21, -21),) * 2  # at the edges the means of means differ
    # Both are sampled Gaussians, cut at 7e-7 of their middle.
    np.testing.assert_allclose(twice.heights[inner], once.heights[inner], atol=1e-7 * 1e-5)


# -- the weighted mean -----------------------------------------------------------------------------


@pytest.mark.parametrize("cutoff", [5.0, 24.0, 45.0])
@pytest.mark.parametrize("heights", [ROUGH, HOLED, HOLED[30]], ids=["whole", "holes", "profile"])
def test_each_point_is_the_weighted_mean_of_those_there_are(
    heights: np.ndarray, cutoff: float
) -> None:
    found = smooth(heights, (STEP,) * heights.ndim, cutoff * STEP)
    w = weights(cutoff)
    reach = w.size // 2
    there = np.argwhere(~np.isnan(heights))
    values = heights[~np.isnan(heights)]
    for at in there[:: len(there) // 40]:
        apart = np.abs(there - at)
        near = (apart <= reach).all(axis=1)
        share = np.prod(w[reach + apart[near]], axis=1)
        mean = (share * values[near]).sum() / share.sum()
        # Rounding of a sum of weights as small as 1e-3 of all.
        assert found[tuple(at)] == pytest.approx(mean, abs=1e-7 * 1e-12)
    np.testing.assert_array_equal(np.isnan(found), np.isnan(heights))


def test_both_ways_to_convolve_agree(monkeypatch: pytest.MonkeyPatch) -> None:
    direct = smooth(HOLED, (STEP, STEP), 14 * STEP)
    monkeypatch.setattr(filters, "_LONG_KERNEL", 1)
    monkeypatch.setattr(filters, "_BLOCK", 1000)  # several blocks, the last one short
    np.testing.assert_allclose(smooth(HOLED, (STEP, STEP), 14 * STEP), direct, atol=1e-7 * 1e-13)


@pytest.mark.parametrize("heights", [ROUGH, HOLED, HOLED[:, 7]], ids=["whole", "holes", "profile"])
@pytest.mark.parametrize(
    "steps",
    [
        {"level": "plane"},
        {"level": "quadratic"},
        {"level": "mean"},
        {"fill": "interpolate"},
        {"cutoff": 6 * STEP},
        {"long_cutoff": 20 * STEP},
        {"level": "plane", "cutoff": 6 * STEP, "long_cutoff": 20 * STEP},
    ],
    ids=lambda steps: "+".join(steps),
)
@settings(max_examples=15)  # of each kind; there is little that one could be unlucky with
@given(factor=st.floats(0.1, 10.0), shift=st.floats(-1e-6, 1e-6), seed=st.integers(0, 1000))
def test_conditioning_is_linear(
    heights: np.ndarray, steps: dict[str, Any], factor: float, shift: float, seed: int
) -> None:
    other = np.random.default_rng(seed).normal(scale=1e-7, size=heights.shape)

    def conditioned(values: np.ndarray) -> np.ndarray:
        return ms.Scan(values, STEP).condition(**steps).heights

    whole = conditioned(factor * heights + other + shift)
    there = np.isfinite(conditioned(heights))
    other = np.where(np.isnan(heights), np.nan, other)
    parts = factor * conditioned(heights) + conditioned(other)
    kept = 0.0 if "level" in steps or "long_cutoff" in steps else shift
    # Filling stops at 1e-5 of the first residual, the rest is rounding.
    off = (factor * 1e-6 + abs(shift) + 1e-6) * (1e-3 if "fill" in steps else 1e-12)
    np.testing.assert_allclose(whole[there], parts[there] + kept, rtol=0.0, atol=off)


@pytest.mark.parametrize("steps", [{"level": "quadratic"}, {"level": "plane", "cutoff": 8 * STEP}])
def test_the_axes_may_be_swapped_and_turned_round(steps: dict[str, Any]) -> None:
    whole = ms.Scan(HOLED, (STEP, 3 * STEP)).condition(**steps).heights
    swapped = ms.Scan(HOLED.T, (3 * STEP, STEP)).condition(**steps).heights.T
    turned = ms.Scan(HOLED[::-1, ::-1], (STEP, 3 * STEP)).condition(**steps).heights[::-1, ::-1]
    np.testing.assert_allclose(swapped, whole, atol=1e-7 * 1e-7)
    np.testing.assert_allclose(turned, whole, atol=1e-7 * 1e-7)


# -- form ------------------------------------------------------------------------------------------


def form(kind: str, shape: tuple[int, int], far: float = 0.0) -> np.ndarray:
    y, x = np.mgrid[: shape[0], : shape[1]] * STEP
    z = far + 0.0 * x
    if kind != "mean":
        z = z + 0.02 * x - 0.05 * y
    if kind == "quadratic":
        z = z + 3.0 * x * x - 20.0 * x * y + 9.0 * y * y
    return z


@pytest.mark.parametrize("kind", ["mean", "plane", "quadratic"])
@pytest.mark.parametrize("holes", [False, True])
@pytest.mark.parametrize("far", [0.0, 1e-3])
def test_a_form_goes_entirely_and_the_rest_stays(kind: str, holes: bool, far: float) -> None:
    base = form(kind, ROUGH.shape, far)
    mask = np.isnan(HOLED) & holes
    given_ = np.where(mask, np.nan, base)
    rest, height = level(given_, kind)
    close = (np.ptp(base) + far) * 2e-15  # doubles round at 1e-16
    assert np.nanmax(np.abs(rest)) <= close
    assert height == pytest.approx(np.ptp(base), rel=1e-6, abs=1e-18)
    # Beside roughness: what is left is what would be left of the roughness alone.
    both, _ = level(np.where(mask, np.nan, base + ROUGH), kind)
    alone, _ = level(np.where(mask, np.nan, ROUGH), kind)
    np.testing.assert_allclose(both, alone, rtol=0.0, atol=1e-7 * 1e-9 + close)


@pytest.mark.parametrize("kind", ["plane", "quadratic"])
def test_nothing_of_the_form_is_left_in_what_remains(kind: str) -> None:
    rest, _ = level(HOLED + form("quadratic", ROUGH.shape), kind)
    y, x = np.mgrid[-1 : 1 : ROUGH.shape[0] * 1j, -1 : 1 : ROUGH.shape[1] * 1j]
    terms = [np.ones_like(x), x, y] + ([x * x, x * y, y * y] if kind == "quadratic" else [])
    for term in terms:
        assert abs(np.nansum(rest * term)) < 1e-12 * np.nansum(np.abs(rest * term))


def test_profiles_lose_their_line_and_parabola() -> None:
    x = np.linspace(0.0, 1e-3, 200)
    rest, _ = level(1e-6 + 0.01 * x - 3.0 * x * x, "quadratic")
    assert np.abs(rest).max() < 1e-19
    rest, _ = level(1e-6 + 0.01 * x, "plane")
    assert np.abs(rest).max() < 1e-19


# -- gaps ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("hole", ["half", "disc", "strip"])
def test_gaps_in_a_plane_are_filled_by_the_plane(hole: str) -> None:
    y, x = np.mgrid[:90, :120]
    gone = {
        "half": np.random.default_rng(1).random(x.shape) < 0.5,
        "disc": (x - 60) ** 2 + (y - 45) ** 2 < 35**2,
        "strip": x < 30,
    }[hole]
    plane = 1e-3 + 1e-6 * x - 2e-6 * y
    filled = fill(np.where(gone, np.nan, plane))
    np.testing.assert_allclose(filled, plane, rtol=0.0, atol=1e-3 * 1e-14)


def test_a_gap_is_filled_by_the_harmonic_surface() -> None:
    # Re (x + iy)^3 has each point the mean of its neighbours, to the order of the grid.
    y, x = np.mgrid[-60:61, -80:81] / 60.0
    wave = x**3 - 3.0 * x * y**2
    gone = x**2 + y**2 < 0.5
    filled = fill(np.where(gone, np.nan, wave))
    np.testing.assert_allclose(filled, wave, rtol=0.0, atol=2e-3 * np.ptp(wave[gone]))
    assert np.array_equal(filled[~gone], wave[~gone])


def test_a_profile_is_filled_by_straight_lines() -> None:
    z = np.array([0.0, 1.0, np.nan, np.nan, np.nan, 5.0, 2.0, np.nan, 4.0]) * 1e-6
    expected = np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 2.0, 3.0, 4.0]) * 1e-6
    np.testing.assert_allclose(fill(z), expected, rtol=0.0, atol=1e-6 * 1e-4)


def test_steps_are_done_in_the_order_that_is_reported() -> None:
    tilted = form("plane", ROUGH.shape) + HOLED
    steps: dict[str, Any] = {"level": "plane", "fill": "interpolate"}
    band: dict[str, Any] = {"cutoff": 5 * STEP, "long_cutoff": 20 * STEP}
    at_once = ms.Scan(tilted, STEP).condition(**band, **steps)
    one_by_one = ms.Scan(tilted, STEP)
    for name, value in (steps | band).items():
        one_by_one = one_by_one.condition(**{name: value})
    np.testing.assert_array_equal(at_once.heights, one_by_one.heights)
    assert at_once.notes == one_by_one.notes
    words = [note.split(":")[0] for note in at_once.notes]
    assert words == ["level", "fill", "cutoff", "long_cutoff"]
    assert at_once.missing == 0.0
