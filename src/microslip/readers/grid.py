"""Points in any order, put on the regular grid that they were measured on."""

from __future__ import annotations

import numpy as np

from microslip._core.checks import Floats
from microslip.readers.files import refuse_beyond

_OFF = 0.05  # share of a step by which a coordinate may be off its place
_SMALLEST_SHARE = 0.01  # share of the places that must be filled
_BESIDE = 0.02  # neighbours along an axis, for each point: a grid that is turned has none


def on_grid(coordinates: list[Floats], heights: Floats) -> tuple[Floats, tuple[float, ...]]:
    """Heights as an array, NaN where the grid has no point."""
    places, counts, steps = [], [], []
    for name, values in zip("xy", coordinates, strict=False):
        place, count, step = _axis(name, values)
        places.append(place)
        counts.append(count)
        steps.append(step)
    refuse_beyond(*counts[::-1])
    total = int(np.prod(counts, dtype=float))
    if heights.size < _SMALLEST_SHARE * total:
        raise ValueError(
            f"{heights.size} points on a grid of {' x '.join(map(str, counts))}: scattered points "
            "are no scan; interpolate them on a regular grid first"
        )
    index = places[0] if len(places) == 1 else places[1] * counts[0] + places[0]
    occupied = np.zeros(total, dtype=bool)
    occupied[index] = True
    if (twice := index.size - int(np.count_nonzero(occupied))) > 0:
        raise ValueError(f"{twice} points lie where another one is already")
    grid = occupied.reshape(counts[::-1])
    if grid.ndim == 2:
        beside = np.count_nonzero(grid[:, 1:] & grid[:, :-1])
        beside += np.count_nonzero(grid[1:] & grid[:-1])
        if beside < _BESIDE * heights.size:
            raise ValueError(
                f"{heights.size} points on a grid of {' x '.join(map(str, counts))}, hardly any "
                "beside another: points of a grid that is turned, or scattered, are no scan; "
                "interpolate them on a regular grid along x and y first"
            )
    result = np.full(total, np.nan)
    result[index] = heights
    return result.reshape(counts[::-1]), tuple(steps)


def _axis(name: str, values: Floats) -> tuple[np.ndarray, int, float]:
    """Place of each point along an axis, how many there are, and their distance."""
    if not np.all(np.isfinite(values)):
        raise ValueError(f"{name} must be finite numbers, one for each point")
    distinct = np.unique(values)
    gaps = np.diff(distinct)
    if not gaps.size:
        raise ValueError(f"all points have the same {name}: wanted a grid, or columns x and z")
    # Coordinates out of an encoder repeat themselves only nearly: small gaps are none.
    step = float(np.median(gaps[gaps > 1e-4 * gaps.max()]))
    if gaps.sum() / step < 2.0**53:
        # Gap by gap, as a step of few digits adds up; then all points together tell it better.
        places = np.concatenate([[0.0], np.cumsum(np.rint(gaps / step))])
        place = places[np.searchsorted(distinct, values)]
        for _ in range(2):
            mean = place.mean()
            spread = place - mean
            step = float(spread @ values / (spread @ spread))
            start = float(values.mean() - step * mean)
            place = np.rint((values - start) / step)
        off = float(np.abs(values - start - step * place).max())
        if off <= _OFF * step:
            place -= place.min()
            return place.astype(np.int64), int(place.max()) + 1, step
    raise ValueError(
        f"{name} is not on a regular grid (neighbours are mostly {step:g} apart); interpolate the "
        "points on one first"
    )
