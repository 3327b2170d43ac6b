"""Scans in Python: what they hold, what they refuse, and what conditioning refuses."""

from __future__ import annotations

import copy
import pickle
import time
import tracemalloc
from typing import Any

import numpy as np
import pytest

import microslip as ms
from microslip.scans.checks import spikes
from microslip.scans.conditioning import band

HEIGHTS = np.random.default_rng(0).normal(scale=1e-7, size=(30, 40))
NAN = np.nan


def test_a_scan_holds_what_it_is_given() -> None:
    scan = ms.Scan(HEIGHTS, (2e-6, "3 um"), name="plate", notes=("by hand.",), cutoff=1e-5)
    assert np.array_equal(scan.heights, HEIGHTS)
    assert scan.pixel == (2e-6, 3e-6)
    assert scan.size == (40 * 2e-6, 30 * 3e-6)
    assert scan.area == pytest.approx(40 * 30 * 6e-12, rel=1e-15)
    assert (scan.name, scan.notes, scan.cutoff, scan.long_cutoff) == (
        "plate",
        ("by hand.",),
        1e-5,
        None,
    )
    assert not scan.is_profile
    assert scan.missing == 0.0
    assert repr(scan) == "Scan('plate', 40 x 30 points, pixel 2.00 µm x 3.00 µm)"


def test_a_profile_is_a_scan_of_one_dimension() -> None:
    scan = ms.Scan([1e-6, NAN, 2e-6, 0.0], "2 um")
    assert scan.is_profile
    assert scan.pixel == (2e-6,)
    assert scan.size == (8e-6,)
    assert scan.missing == 0.25
    with pytest.raises(ms.InputError, match="a profile has no area"):
        _ = scan.area


def test_one_distance_is_for_both_axes() -> None:
    assert ms.Scan(HEIGHTS, 1e-6).pixel == ms.Scan(HEIGHTS, [1e-6, 1e-6]).pixel == (1e-6, 1e-6)


def test_masked_points_and_whole_numbers_are_understood() -> None:
    masked = ms.Scan(np.ma.masked_greater(np.arange(12).reshape(3, 4), 9), 1.0)
    assert np.isnan(masked.heights).sum() == 2
    assert masked.heights.dtype == np.float64
    assert ms.Scan(HEIGHTS.astype(np.float32), 1.0).heights.dtype == np.float64
    assert ms.Scan(HEIGHTS.T, 1.0).heights.flags.c_contiguous


def test_a_scan_is_frozen_and_its_own() -> None:
    mine = HEIGHTS.copy()
    scan = ms.Scan(mine, 1e-6)
    mine[0, 0] = 1.0
    assert scan.heights[0, 0] == HEIGHTS[0, 0]
    view = HEIGHTS.view()
    view.setflags(write=False)
    assert not np.shares_memory(ms.Scan(view, 1e-6).heights, HEIGHTS)
    with pytest.raises(ValueError, match="read-only"):
        scan.heights[0, 0] = 0.0
    with pytest.raises(AttributeError):
        scan.name = "other"  # type: ignore[misc]
    for twin in (pickle.loads(pickle.dumps(scan)), copy.deepcopy(scan)):
        assert np.array_equal(twin.heights, scan.heights)
        assert not twin.heights.flags.writeable


@pytest.mark.parametrize(
    ("heights", "says"),
    [
        (np.zeros((1, 50)), "at least two rows and two columns, got 1 x 50; for a profile, give"),
        (np.zeros((50, 1)), "got 50 x 1"),
        (np.zeros((0, 0)), "got 0 x 0"),
        (np.zeros(3), "at least four points, got 3"),
        (np.zeros((2, 2, 2)), "got shape"),
        (5.0, "got shape"),
        (np.full((4, 4), NAN), "all 16 heights are missing"),
        (np.ma.masked_all((4, 4)), "all 16 heights are missing"),
        (np.where(np.eye(4), np.inf, 0.0), "4 of 16 are infinite"),
        (np.where(np.eye(4), 1e200, 0.0), "must be heights in metres, got 1e.200 m"),
        ("heights", "must be an array of numbers, got 'heights'"),
        ([[1.0, 2.0], [3.0]], "must be an array of numbers"),
        (HEIGHTS + 1j, "must be an array of numbers"),
        (HEIGHTS > 0.0, "must be an array of numbers"),
        (None, "must be an array of numbers, got None"),
    ],
    ids=lambda value: value[:20] if isinstance(value, str) else "",
)
def test_heights_that_are_none(heights: Any, says: str) -> None:
    with pytest.raises(ms.InputError, match=says):
        ms.Scan(heights, 1e-6)


@pytest.mark.parametrize(
    ("pixel", "says"),
    [
        (0.0, "pixel must be above zero"),
        (-1e-6, "pixel must be above zero"),
        (NAN, "pixel must be a finite number"),
        (None, "pixel must be a finite number"),
        (5e3, "between 1e-15 m and 1000 m"),
        ("1.66", "no unit"),
        ("1 s", "a time"),
        ((1e-6, 1e-6, 1e-6), "got 3 of them"),
        ((1e-6, 0.0), "above zero"),
    ],
)
def test_pixels_that_are_none(pixel: Any, says: str) -> None:
    with pytest.raises(ms.InputError, match=says):
        ms.Scan(HEIGHTS, pixel)


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ({"name": 5}, "name must be text"),
        ({"notes": "one"}, "notes must be a tuple"),
        ({"cutoff": 0.0}, "cutoff must be above zero"),
        ({"long_cutoff": "x"}, "long_cutoff must be a finite number"),
    ],
)
def test_words_that_are_none(more: dict[str, Any], says: str) -> None:
    with pytest.raises(ms.InputError, match=says):
        ms.Scan(HEIGHTS, 1e-6, **more)


# -- what cannot be measured -----------------------------------------------------------------------


MEASURES = ["statistics", "moments", "spectrum", "height_distribution", "over_cutoffs", "condition"]


@pytest.mark.parametrize("method", MEASURES)
def test_the_same_height_everywhere_is_no_scan(method: str) -> None:
    flat = ms.Scan(np.full((20, 20), 1e-6), 1e-6, name="glass")
    with pytest.raises(ms.InputError, match="glass: all heights are 1e-06 m"):
        getattr(flat, method)()
    with pytest.raises(ms.InputError, match="all heights are"):
        flat.summits(None)


@pytest.mark.parametrize("method", MEASURES)
def test_spikes_are_told_and_not_measured(method: str) -> None:
    heights = HEIGHTS.copy()
    heights[3, 4], heights[20, 9] = 1e5, -1e5
    scan = ms.Scan(heights, 1e-6)
    with pytest.raises(ms.InputError, match=r"2 of 1200 points lie more than 1e\+06 times"):
        getattr(scan, method)()
    cleaned = scan.condition(outliers=6.0)
    assert np.isnan(cleaned.heights[[3, 20], [4, 9]]).all()
    assert cleaned.measurable() is cleaned


def test_too_few_points_to_tell_have_no_spikes() -> None:
    assert spikes(np.array([0.0, np.nan, 1.0, 1e9])) == 0


def test_what_stands_on_a_flat_is_no_spike() -> None:
    flat = np.zeros((100, 100))
    flat[40:60, 40:60] = 1e-6
    assert spikes(flat) == 0
    flat[0, 0] = 10.0
    assert spikes(flat) == 1
    # One bump on a flat that levelling left at its rounding.
    bump = np.random.default_rng(0).normal(scale=1e-22, size=(100, 100))
    bump[50, 50] = 1e-6
    assert spikes(bump) == 0
    bump[0, 0] = 1e30
    assert spikes(bump) == 1


# -- conditioning ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("steps", "says"),
    [
        ({"level": "plan"}, 'level must be "plane", .* got "plan"; did you mean "plane"'),
        ({"level": 1}, "level must be"),
        ({"fill": True}, 'fill must be "interpolate" or None, got true'),
        ({"outliers": 0.5}, "outliers must be at least 2, got 0.5"),
        ({"outliers": "six"}, "outliers must be a finite number"),
        ({"cutoff": 2e-6}, "cutoff must be between two pixels .* exactly two pixels"),
        ({"cutoff": "30 um"}, "exactly the size of the scan"),
        ({"cutoff": 1.9e-6}, r"two pixels \(2 µm\) .*\(30 µm\), got 1.9 µm: below two pixels"),
        ({"cutoff": "10"}, "no unit"),
        ({"cutoff": -1.0}, "cutoff must be above zero"),
        ({"long_cutoff": 1.0}, "long_cutoff must be between .* beyond the size"),
        ({"cutoff": 9e-6, "long_cutoff": 8e-6}, "long_cutoff must be longer than cutoff"),
    ],
    ids=str,
)
def test_steps_that_are_none(steps: dict[str, Any], says: str) -> None:
    with pytest.raises(ms.InputError, match=says):
        ms.Scan(HEIGHTS, 1e-6).condition(**steps)


def test_cut_offs_of_two_passes_have_to_fit() -> None:
    scan = ms.Scan(HEIGHTS, 1e-6)
    with pytest.raises(ms.InputError, match="longer than cutoff"):
        scan.condition(cutoff=1e-5).condition(long_cutoff=9e-6)
    with pytest.raises(ms.InputError, match="must be shorter than the long_cutoff"):
        scan.condition(long_cutoff=1e-5).condition(cutoff=1.1e-5)
    twice = scan.condition(long_cutoff=2e-5).condition(long_cutoff=1e-5)
    assert twice.long_cutoff == 1e-5


def test_the_longer_side_of_a_pixel_counts() -> None:
    with pytest.raises(ms.InputError, match="two pixels"):
        ms.Scan(HEIGHTS, (1e-6, 3e-6)).condition(cutoff=5e-6)
    assert band(ms.Scan(HEIGHTS, (1e-6, 3e-6)), "6.1 um", None) == (6.1e-6, None)


def test_too_few_points_for_a_form() -> None:
    heights = np.full((10, 10), NAN)
    heights[5] = np.arange(10.0)
    with pytest.raises(ms.InputError, match='level="plane": the 10 points that are there'):
        ms.Scan(heights, 1e-6).condition(level="plane")
    with pytest.raises(ms.InputError, match='level="quadratic"'):
        ms.Scan(HEIGHTS[:2], 1e-6).condition(level="quadratic")


def test_conditioning_leaves_the_scan_alone_and_tells_what_it_did() -> None:
    heights = HEIGHTS.copy()
    heights[3, 3] = NAN
    scan = ms.Scan(heights, 1e-6, name="plate", notes=("before.",))
    out = scan.condition(level="plane", fill="interpolate", cutoff="5 um", long_cutoff=2e-5)
    assert np.array_equal(scan.heights, heights, equal_nan=True)
    assert (out.name, out.pixel, out.missing) == ("plate", (1e-6, 1e-6), 0.0)
    assert (out.cutoff, out.long_cutoff) == (5e-6, 2e-5)
    assert out.notes[0] == "before."
    assert "fill: 1 of 1200 points interpolated from around them." in out.notes
    assert "cutoff: waves shorter than 5.00 µm removed" in out.notes[-2]
    again = out.condition(cutoff="5 um")
    assert "7.07 µm with the one before" in again.notes[-1]


def test_nothing_asked_is_nothing_done() -> None:
    scan = ms.Scan(HEIGHTS, 1e-6)
    same = scan.condition()
    assert np.shares_memory(same.heights, scan.heights)
    assert same.notes == ()


@pytest.mark.parametrize("holes", [False, True])
def test_memory_is_a_small_multiple_of_the_scan(holes: bool) -> None:
    heights = np.random.default_rng(1).normal(scale=1e-7, size=(700, 900))
    if holes:
        heights[::5, ::3] = NAN
    scan = ms.Scan(heights, 1e-6)
    scan.condition(level="plane", cutoff=5e-6, long_cutoff=1e-4)  # imports are none of it
    tracemalloc.start()
    scan.condition(level="plane", cutoff=5e-6, long_cutoff=1e-4)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    # Blocks of a few megabytes come on top, which is nothing for larger scans.
    assert most < 7.5 * heights.nbytes + 2**25


@pytest.mark.slow
def test_four_megapixels_are_conditioned_in_seconds() -> None:
    import time

    heights = np.random.default_rng(1).normal(scale=1e-7, size=(2000, 2000))
    scan = ms.Scan(heights, 1e-6)
    began = time.perf_counter()
    scan.condition(level="plane", cutoff=1e-5, long_cutoff=2e-4)
    # 1.3 s on two cores; a busy machine may take longer.
    assert time.perf_counter() - began < 10.0


def test_what_is_reckoned_once_is_that_of_the_scan_and_stays_with_it() -> None:
    rng = np.random.default_rng(2)
    scan = ms.Scan(rng.standard_normal((40, 50)) * 1e-7, 1e-6)
    assert scan.moments() is scan.moments()
    assert scan.statistics() is scan.statistics()
    level = scan.condition(level="plane")
    assert level.statistics().rms < scan.statistics().rms
    again = pickle.loads(pickle.dumps(scan))
    assert again.moments() == scan.moments()
    assert not again.heights.flags.writeable


@pytest.mark.slow
def test_four_megapixels_take_little_time_and_memory() -> None:
    """All parameters and summits at ten cut-offs: seven seconds where this was written."""
    from microslip.scans import random_surface

    scan = random_surface((2048, 2048), 1e-6, m0=4e-14, m2=4e-4, m4=1e8, seed=7)
    tracemalloc.start()
    begin = time.process_time()
    table = ms.Scan(scan.heights, 1e-6).condition(level="plane").over_cutoffs()
    spent = time.process_time() - begin
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert np.isfinite(table.counted_radius).all()
    assert most < 9 * scan.heights.nbytes
    assert spent < 30.0  # with all allocations traced, on a machine three times as slow
