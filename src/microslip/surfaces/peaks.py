"""Peaks of a height map, and their prominence above the saddle to a higher peak.

Every point climbs to its highest neighbour and so belongs to the hill of one peak. Peaks meet at
saddles: points whose higher neighbours form more than one connected part. Proceeding down through
the saddles, the hill with the lower of two peaks ends at their saddle (Edelsbrunner, Letscher and
Zomorodian 2002, DOI 10.1007/s00454-002-2885-2); the height of its peak above the saddle is its
prominence. Removing hills below a threshold is the pruning of ISO 16610-85 and ISO 25178-3.

Each point has eight neighbours. Equal heights are ordered by their index, so that a plateau has one
peak; other points of the plateau have no prominence.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats

Codes = NDArray[np.uint8]
_Places = NDArray[np.intp]
_Indices = NDArray[np.int32 | np.int64]  # 32 bits if they suffice for the map

_BLOCK = 1 << 18  # points per pass, to fit in the cache
_ROUNDS = 6
_FEW_MEETINGS = 2000  # below this number a scalar loop is as fast

# Neighbours in index order.
_NEIGHBOURS = ((-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1))


def _parts_of_rings() -> tuple[NDArray[np.uint8], NDArray[np.int8]]:
    """Return the number of connected parts of each subset of the eight neighbours of a point.

    Also returns one member of each part, shape (256, 4), -1 beyond the number. Bit k of the index
    of a subset stands for neighbour k.
    """
    counts = np.zeros(256, dtype=np.uint8)
    members = np.full((256, 4), -1, dtype=np.int8)
    for code in range(256):
        higher = {k for k in range(8) if code >> k & 1}
        while higher:
            todo = [min(higher)]
            members[code, counts[code]] = todo[0]
            counts[code] += 1
            while todo:
                row, column = _NEIGHBOURS[todo.pop()]
                near = {
                    k
                    for k in higher
                    if abs(_NEIGHBOURS[k][0] - row) <= 1 and abs(_NEIGHBOURS[k][1] - column) <= 1
                }
                higher -= near
                todo += near
    return counts, members


_COUNTS, _MEMBERS = _parts_of_rings()
_SADDLES = _COUNTS > 1


class Peaks(NamedTuple):
    """Local maxima of a map, highest first."""

    places: NDArray[np.intp]
    """Flat indices into the map."""
    prominences: Floats
    """Rise above the saddle to a higher peak [m]; for the highest, above the lowest point."""


def find_peaks(heights: Floats) -> Peaks:
    """Return the peaks of a map and their prominences.

    Only the climbs from saddles are followed, not from every point: they determine which hills meet
    where.
    """
    codes = _higher(heights)
    flat = heights.reshape(-1)
    peaks = np.flatnonzero(codes == 0)
    peaks = peaks[~np.isnan(flat[peaks])]
    order = np.lexsort((peaks, flat[peaks]))[::-1]  # descending, ties by index
    peaks = peaks[order]
    saddles = np.flatnonzero(_SADDLES[codes])
    ends = _merge(peaks.size, *_meetings(flat, codes, peaks, saddles, heights.shape[1]))
    lowest = np.where(np.isneginf(ends), np.nanmin(flat), ends)
    return Peaks(peaks, flat[peaks] - lowest)


def _higher(heights: Floats) -> Codes:
    """Return a bit mask of the higher neighbours of each point; 0 for missing points."""
    rows, columns = heights.shape
    codes = np.empty(heights.shape, dtype=np.uint8)
    step = max(1, _BLOCK // columns)
    for first in range(0, rows, step):
        last = min(first + step, rows)
        count = last - first
        here = np.full((count + 2, columns + 2), -np.inf)
        low, high = max(first - 1, 0), min(last + 1, rows)
        here[low - first + 1 : high - first + 1, 1:-1] = heights[low:high]
        here[np.isnan(here)] = -np.inf
        code = np.zeros((count, columns), dtype=np.uint8)
        for k in range(4, 8):
            down, right = _NEIGHBOURS[k]
            start = max(0, -right)
            near = here[: count + 2 - down, start : columns + 2 - max(0, right)]
            far = here[down:, max(0, right) : columns + 2 - start]
            # Of equal heights the one with the larger index counts as higher.
            later = (far >= near).view(np.uint8)
            code |= later[1 : 1 + count, 1 - start : 1 - start + columns] << np.uint8(k)
            # The same pair seen from the other point: not higher means lower.
            place = 1 - start - right
            lower = later[1 - down : 1 - down + count, place : place + columns] ^ np.uint8(1)
            code |= lower << np.uint8(7 - k)
        code[np.isneginf(here[1:-1, 1:-1])] = 0
        codes[first:last] = code
    return codes.reshape(-1)


def _meetings(
    flat: Floats, codes: Codes, peaks: _Places, saddles: _Places, columns: int
) -> tuple[_Places, _Places, Floats]:
    """Return the meetings of hills: the higher and the lower hill, and the height of the saddle.

    For each pair of hills only the highest saddle counts; meetings are in descending order.
    ``codes`` are the bit masks of :func:`_higher`, and hills have the numbers of ``peaks``.
    """
    offsets = np.array([down * columns + right for down, right in _NEIGHBOURS])
    members = _MEMBERS[codes[saddles]]
    rows, parts = np.nonzero(members >= 0)
    feet = saddles[rows] + offsets[members[rows, parts]]
    hill = np.full(members.shape, -1, dtype=np.intp)
    hill[rows, parts] = _hills(flat, codes, peaks, feet, offsets)
    rows, parts = np.nonzero((hill != hill[:, :1]) & (hill >= 0))
    first, second, place = hill[rows, 0], hill[rows, parts], saddles[rows]
    high, two = np.minimum(first, second), np.maximum(first, second)
    order = np.lexsort((place, flat[place]))[::-1]
    high, two, place = high[order], two[order], place[order]
    # A pair that meets again at a lower saddle is already joined.
    _, new = np.unique(high * np.intp(max(peaks.size, 1)) + two, return_index=True)
    new.sort()
    return high[new], two[new], flat[place[new]]


def _hills(flat: Floats, codes: Codes, peaks: _Places, feet: _Places, offsets: _Places) -> _Places:
    # Highest neighbour of each point on a climb; other entries are never used.
    top: _Indices = np.full(flat.size, -1, dtype=np.int32 if flat.size < 2**31 else np.int64)
    top[peaks] = peaks
    climbed = []
    at = feet
    while (at := _distinct(at[top[at] < 0], top)).size:
        climbed.append(at)
        further = _uphill(flat, codes, at, offsets)
        top[at] = further
        at = further
    # Pointer doubling: each pass doubles the climb of the points that have not arrived.
    going = np.concatenate([*climbed, feet[:0]])
    while going.size:
        further = top[top[going]]
        top[going] = further
        going = going[top[further] != further]
    number: _Indices = np.empty_like(top)
    number[peaks] = np.arange(peaks.size, dtype=top.dtype)
    return np.asarray(number[top[feet]], dtype=np.intp)


def _distinct(places: _Places, scratch: _Indices) -> _Places:
    """Return the distinct values in ``places``; ``scratch`` is overwritten as working memory."""
    number = np.arange(-1 - places.size, -1, dtype=scratch.dtype)
    scratch[places] = number  # for repeated places the last one stays
    last: _Places = places[scratch[places] == number]
    return last


def _uphill(flat: Floats, codes: Codes, places: _Places, offsets: _Places) -> _Places:
    result = np.empty_like(places)
    bits = np.uint8(1) << np.arange(
        7, -1, -1, dtype=np.uint8
    )  # of equal neighbours the larger index wins
    for start in range(0, places.size, _BLOCK // 8):
        at = places[start : start + _BLOCK // 8]
        higher = (codes[at, None] & bits) != 0
        around = np.where(higher, at[:, None] + offsets[::-1], at[:, None])
        values = np.where(higher, flat[around], -np.inf)
        result[start : start + at.size] = around[np.arange(at.size), values.argmax(axis=1)]
    return result


def _merge(count: int, high: _Places, two: _Places, saddle: Floats) -> Floats:
    """Return the height [m] of the saddle at which each of ``count`` hills ends.

    It is -inf for a hill without a saddle to a higher hill. Meeting i joins hills ``high[i]`` and
    ``two[i]`` at height ``saddle[i]``. Hills are numbered in descending order of their peaks: where
    two hills meet, the one with the larger number ends.
    """
    ends = np.full(count, -np.inf)
    parent = np.arange(count)
    # Most hills end at their own first meeting with a higher hill, independently of all others:
    # merge those at once, then repeat with the remaining hills.
    for _ in range(_ROUNDS):
        if high.size < _FEW_MEETINGS:
            break
        ending = _at_first_meeting(count, high, two)
        ends[two[ending]] = saddle[ending]
        parent[two[ending]] = high[ending]
        while not np.array_equal(further := parent[parent], parent):
            parent = further
        high, two = parent[high], parent[two]
        separate = high != two
        high, two, saddle = high[separate], two[separate], saddle[separate]
        high, two = np.minimum(high, two), np.maximum(high, two)
    end, root = ends.tolist(), parent.tolist()
    for a, b, height in zip(high.tolist(), two.tolist(), saddle.tolist(), strict=True):
        while root[a] != a:
            root[a] = a = root[root[a]]
        while root[b] != b:
            root[b] = b = root[root[b]]
        if a < b:
            root[b] = a
            end[b] = height
        elif b < a:
            root[a] = b
            end[a] = height
    return np.array(end)


def _at_first_meeting(count: int, high: _Places, two: _Places) -> _Places:
    """Return the indices of the meetings that are the highest of all meetings of their lower hill.

    ``high`` and ``two`` are the numbers of the higher and the lower hill of each meeting, in
    descending order of their saddles; see :func:`_merge`.
    """
    numbers = np.arange(high.size)
    firsts = np.full((2, count), high.size)
    for first, hills in zip(firsts, (high, two), strict=True):
        first[hills[::-1]] = numbers[::-1]  # the last assignment stays: the highest meeting
    first_of = firsts.min(axis=0)
    return np.flatnonzero(first_of[two] == numbers)


# -- shape of the summits --------------------------------------------------------------------------

_A_PASS = 1 << 16  # summits per pass


class Tops(NamedTuple):
    """Quadrics fitted to summits, one row per summit; the top is the vertex of the quadric."""

    curvatures: Floats
    """Principal curvatures [1/m], the larger first, positive for a summit, shape (n, 2)."""
    shifts: Floats
    """Offset from the highest point to the top along x and y [pixels], shape (n, 2)."""
    rises: Floats
    """Height of the top above the highest point [m]."""
    inside: NDArray[np.bool_]
    """Whether the top lies within the fitted points; otherwise shift and rise are zero."""


def fitted(heights: Floats, places: NDArray[np.intp], pixel: tuple[float, ...]) -> Tops:
    """Fit a quadric to the points around each summit by least squares.

    z = z0 + gx x + gy y + (hxx x^2 + 2 hxy x y + hyy y^2)/2 over 3 x 3 points, exact for a
    paraboloid. The variance of the second derivatives due to white noise is a third of that of
    three-point differences along an axis.
    """
    side = np.arange(-1, 2)
    y, x = (part.reshape(-1) for part in np.meshgrid(side, side, indexing="ij"))
    design = np.stack([np.ones(x.size), x, y, 0.5 * x * x, x * y, 0.5 * y * y], axis=1)
    solve = np.linalg.pinv(design).T
    offsets = y * heights.shape[1] + x
    flat = heights.reshape(-1)
    terms = np.empty((places.size, 6))
    for start in range(0, places.size, _A_PASS):
        part = places[start : start + _A_PASS]
        # Heights relative to the summit, so that a large mean costs no digits.
        terms[start : start + _A_PASS] = (flat[part[:, None] + offsets] - flat[part, None]) @ solve
    z0, gx, gy, hxx, hxy, hyy = terms.T
    det = hxx * hyy - hxy * hxy
    with np.errstate(divide="ignore", invalid="ignore"):
        right, down = (hxy * gy - hyy * gx) / det, (hxy * gx - hxx * gy) / det
    inside = (hxx < 0.0) & (det > 0.0) & (np.abs(right) <= 1.0) & (np.abs(down) <= 1.0)
    shifts = np.where(inside[:, None], np.stack([right, down], axis=1), 0.0)
    rises = np.where(inside, z0 + 0.5 * (gx * shifts[:, 0] + gy * shifts[:, 1]), 0.0)
    dx, dy = pixel
    return Tops(_principal(-hxx / dx**2, -hxy / (dx * dy), -hyy / dy**2), shifts, rises, inside)


def equivalent_radii(curvatures: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Return radii 1/sqrt(k1 k2) [m] from principal curvatures, and a mask of true maxima."""
    large, small = curvatures.T
    # Curvatures at rounding level count as flat.
    good = (large > 0.0) & (small > 1e-9 * large)
    product = np.where(good, large * small, 1.0)
    return 1.0 / np.sqrt(product), good


def _principal(a: Floats, b: Floats, c: Floats) -> Floats:
    """Return the eigenvalues of the matrices ((a, b), (b, c)), the larger first."""
    middle, half = 0.5 * (a + c), np.hypot(0.5 * (a - c), b)
    large = middle + half
    # Use the determinant to avoid cancellation.
    with np.errstate(divide="ignore", invalid="ignore"):
        small = np.where(middle > 0.0, (a * c - b * b) / large, middle - half)
    return np.stack([large, small], axis=1)
