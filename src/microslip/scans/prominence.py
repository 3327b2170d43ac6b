"""Floor 6: the peaks of a height map and how far each rises above the saddle to a higher one.

Every point climbs to its highest neighbour, and so belongs to the hill of one peak. Peaks meet at
saddles: points whose higher neighbours fall into more than one connected part. Going down through
the saddles, whichever of two hills has the lower peak ends there (Edelsbrunner, Letscher and
Zomorodian 2002, DOI 10.1007/s00454-002-2885-2); what is left of the lower hill above its saddle is
its prominence. Removing hills below a threshold is the pruning of ISO 16610-85 and ISO 25178-3.

Neighbours are the eight around a point. Equal heights are ordered by their place, so that a
plateau has one peak: the others on it have no prominence.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._checks import Floats

_BLOCK = 1 << 18  # points a pass, as many as a cache holds

# The neighbours in the order of their places, and their order around the point.
_AROUND = ((-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1))
_RING = (0, 1, 2, 4, 7, 6, 5, 3)


def _parts_of_rings() -> tuple[NDArray[np.uint8], NDArray[np.int8]]:
    """For each set of higher neighbours (a bit each): how many parts, and one of each part."""
    counts = np.zeros(256, dtype=np.uint8)
    members = np.full((256, 4), -1, dtype=np.int8)
    for code in range(256):
        higher = {k for k in range(8) if code >> k & 1}
        while higher:
            todo = [min(higher)]
            members[code, counts[code]] = todo[0]
            counts[code] += 1
            while todo:
                row, column = _AROUND[todo.pop()]
                near = {
                    k
                    for k in higher
                    if abs(_AROUND[k][0] - row) <= 1 and abs(_AROUND[k][1] - column) <= 1
                }
                higher -= near
                todo += near
    return counts, members


_COUNTS, _MEMBERS = _parts_of_rings()


class Peaks(NamedTuple):
    """Local maxima of a map, highest first."""

    places: NDArray[np.intp]
    """Flat indices into the map."""
    prominences: Floats
    """Rise above the saddle to a higher peak [m]; of the highest, above the lowest point."""


def find_peaks(heights: Floats) -> Peaks:
    """Peaks of a map and their prominences, in O(n log n).

    Parameters
    ----------
    heights : ndarray
        Heights [m], two-dimensional; missing points are NaN and belong to no hill.

    Returns
    -------
    Peaks
        Every point above its eight neighbours; a plateau once. Those at the edge of the map or of
        missing points are among them.
    """
    uphill, codes = _climb(heights)
    flat = heights.reshape(-1)
    own = np.arange(flat.size, dtype=uphill.dtype)
    peaks = np.flatnonzero((uphill == own) & ~np.isnan(flat))
    order = np.lexsort((peaks, flat[peaks]))[::-1]  # from the highest down, as ties are ordered
    peaks = peaks[order]
    saddles = np.flatnonzero(_COUNTS[codes] > 1)
    if saddles.size:
        hill = _hills(uphill, peaks)
        edges = _meetings(flat, codes, hill, saddles, heights.shape[1])
        lowest = _merge(peaks.size, *edges)
    else:
        lowest = np.full(peaks.size, -np.inf)
    lowest = np.where(np.isneginf(lowest), np.nanmin(flat), lowest)
    return Peaks(peaks, flat[peaks] - lowest)


def _climb(heights: Floats) -> tuple[NDArray[np.int32 | np.int64], NDArray[np.uint8]]:
    """Highest neighbour of each point (or itself), and which neighbours are higher, a bit each."""
    rows, columns = heights.shape
    kind = np.int32 if heights.size < 2**31 else np.int64
    uphill = np.empty(heights.shape, dtype=kind)
    codes = np.empty(heights.shape, dtype=np.uint8)
    step = max(1, _BLOCK // columns)
    for first in range(0, rows, step):
        last = min(first + step, rows)
        here = np.full((last - first + 2, columns + 2), -np.inf)
        low, high = max(first - 1, 0), min(last + 1, rows)
        inner = here[low - first + 1 : high - first + 1, 1:-1]
        inner[:] = heights[low:high]
        inner[np.isnan(inner)] = -np.inf
        count = last - first
        centre = here[1:-1, 1:-1]
        best = centre.copy()
        shift = np.zeros(centre.shape, dtype=kind)
        code = np.zeros(centre.shape, dtype=np.uint8)
        for k, (down, right) in enumerate(_AROUND):
            other = here[1 + down : 1 + down + count, 1 + right : 1 + right + columns]
            # Of equal heights the later place counts as the higher one.
            higher = other > centre if k < 4 else other >= centre
            code |= higher.astype(np.uint8) << np.uint8(k)
            # Those before the point, if equal to it, must not win over it.
            wins = (other >= best) & higher
            np.copyto(best, other, where=wins)
            np.copyto(shift, kind(down * columns + right), where=wins)
        none = np.isneginf(centre)
        shift[none] = 0
        code[none] = 0
        place = np.arange(first * columns, last * columns, dtype=kind).reshape(centre.shape)
        uphill[first:last] = place + shift
        codes[first:last] = code
    return uphill.reshape(-1), codes.reshape(-1)


def _hills(
    uphill: NDArray[np.int32 | np.int64], peaks: NDArray[np.intp]
) -> NDArray[np.int32 | np.int64]:
    """Number of the hill that each point is on; each pass doubles the length of the climb."""
    # Only points that are not there yet are looked at again.
    top = uphill.copy()
    going = np.flatnonzero(top[top] != top)
    while going.size:
        top[going] = top[top[going]]
        further = top[going]
        going = going[top[further] != further]
    number = np.zeros(uphill.size, dtype=uphill.dtype)
    number[peaks] = np.arange(peaks.size, dtype=uphill.dtype)
    return number[top]


def _meetings(
    flat: Floats,
    codes: NDArray[np.uint8],
    hill: NDArray[np.int32 | np.int64],
    saddles: NDArray[np.intp],
    columns: int,
) -> tuple[NDArray[np.intp], NDArray[np.intp], Floats]:
    """Pairs of hills and the highest saddle between them, from the highest down."""
    offsets = np.array([down * columns + right for down, right in _AROUND])
    members = _MEMBERS[codes[saddles]]
    first = hill[saddles + offsets[members[:, 0]]].astype(np.intp)
    ones, others, at = [], [], []
    for k in range(1, 4):
        there = np.flatnonzero(members[:, k] >= 0)
        other = hill[saddles[there] + offsets[members[there, k]]].astype(np.intp)
        apart = other != first[there]
        there, other = there[apart], other[apart]
        ones.append(np.minimum(first[there], other))
        others.append(np.maximum(first[there], other))
        at.append(saddles[there])
    one, two, place = (np.concatenate(part) for part in (ones, others, at))
    order = np.lexsort((place, flat[place]))[::-1]
    one, two, place = one[order], two[order], place[order]
    # A pair that meets again lower down is joined already.
    _, new = np.unique(one * np.intp(hill.max() + 1) + two, return_index=True)
    new.sort()
    return one[new], two[new], flat[place[new]]


def _merge(count: int, one: NDArray[np.intp], two: NDArray[np.intp], saddle: Floats) -> Floats:
    """Height of the saddle at which each hill ends; -inf for those that never do."""
    end = [-np.inf] * count
    parent = list(range(count))
    # Hills are numbered from the highest peak down: of two the larger number ends.
    for a, b, height in zip(one.tolist(), two.tolist(), saddle.tolist(), strict=True):
        while parent[a] != a:
            parent[a] = a = parent[parent[a]]
        while parent[b] != b:
            parent[b] = b = parent[parent[b]]
        if a < b:
            parent[b] = a
            end[b] = height
        elif b < a:
            parent[a] = b
            end[a] = height
    return np.array(end)
