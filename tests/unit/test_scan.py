"""Scans in Python: what they hold, what they refuse, and what conditioning refuses."""

from __future__ import annotations

import numpy as np
import pytest

import microslip as ms
from microslip.surfaces.checks import far_points

HEIGHTS = np.random.default_rng(0).normal(scale=1e-7, size=(30, 40))
NAN = np.nan


# -- what cannot be measured -----------------------------------------------------------------------


MEASURES = ["statistics", "moments", "spectrum", "condition"]


@pytest.mark.parametrize("method", MEASURES)
def test_spikes_are_reported_and_not_measured(method: str) -> None:
    heights = HEIGHTS.copy()
    heights[3, 4], heights[20, 9] = 1e5, -1e5
    scan = ms.Scan(heights, 1e-6)
    with pytest.raises(ms.InputError, match=r"2 of 1200 points lie more than 1e\+06 times"):
        getattr(scan, method)()
    cleaned = scan.repaired()
    assert np.abs(cleaned.heights[[3, 20], [4, 9]]).max() < 1e-3
    assert cleaned.measurable() is cleaned


def test_what_stands_on_a_flat_is_no_spike() -> None:
    flat = np.zeros((100, 100))
    flat[40:60, 40:60] = 1e-6
    assert far_points(flat).sum() == 0
    flat[0, 0] = 10.0
    assert far_points(flat).sum() == 1
    # One bump on a flat that levelling left at its rounding.
    bump = np.random.default_rng(0).normal(scale=1e-22, size=(100, 100))
    bump[50, 50] = 1e-6
    assert far_points(bump).sum() == 0
    bump[0, 0] = 1e30
    assert far_points(bump).sum() == 1


# -- conditioning ----------------------------------------------------------------------------------


def test_conditioning_leaves_the_scan_alone_and_tells_what_it_did() -> None:
    heights = HEIGHTS.copy()
    heights[3, 3] = NAN
    scan = ms.Scan(heights, 1e-6, name="plate", notes=("before.",))
    out = scan.condition(level="plane", fill="interpolate", cutoff="5 um", long_cutoff=2e-5)
    assert np.array_equal(scan.heights, heights, equal_nan=True)
    assert (out.name, out.pixel, out.missing) == ("plate", (1e-6, 1e-6), 0.0)
    assert (out.cutoff, out.long_cutoff) == (5e-6, 2e-5)
    assert out.notes[0] == "before."
    assert "fill: 1 of 1200 points interpolated." in out.notes
    assert "cutoff: waves shorter than 5.00 µm removed" in out.notes[-2]
    again = out.condition(cutoff="5 um")
    assert "7.07 µm with the earlier filter" in again.notes[-1]
