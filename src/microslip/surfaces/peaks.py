"""The peaks of a height map and how far each rises above the saddle to a higher one.

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

from microslip._core.checks import Floats

Codes = NDArray[np.uint8]
Places = NDArray[np.intp]
Indices = NDArray[np.int32 | np.int64]  # of a whole map: the shorter ones where they do

_BLOCK = 1 << 18  # points a pass, as many as a cache holds
_ROUNDS = 6
_FEW_MEETINGS = 2000  # meetings that are as quick one by one

# The neighbours in the order of their places.
_NEIGHBOURS = ((-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1))


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
    """Rise above the saddle to a higher peak [m]; of the highest, above the lowest point."""


def find_peaks(heights: Floats) -> Peaks:
    """Peaks of a map and their prominences.

    Only the climbs from saddles are followed, not those from every point: they alone decide which
    hills meet where.
    """
    codes = _higher(heights)
    flat = heights.reshape(-1)
    peaks = np.flatnonzero(codes == 0)
    peaks = peaks[~np.isnan(flat[peaks])]
    order = np.lexsort((peaks, flat[peaks]))[::-1]  # from the highest down, as ties are ordered
    peaks = peaks[order]
    saddles = np.flatnonzero(_SADDLES[codes])
    ends = _merge(peaks.size, *_meetings(flat, codes, peaks, saddles, heights.shape[1]))
    lowest = np.where(np.isneginf(ends), np.nanmin(flat), ends)
    return Peaks(peaks, flat[peaks] - lowest)


def _higher(heights: Floats) -> Codes:
    """Higher ones of the eight neighbours of each point, a bit each; none if missing."""
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
            # Of equal heights the later place counts as the higher one.
            later = (far >= near).view(np.uint8)
            code |= later[1 : 1 + count, 1 - start : 1 - start + columns] << np.uint8(k)
            # The same pair as the other point has it: what is not higher than it is lower.
            place = 1 - start - right
            lower = later[1 - down : 1 - down + count, place : place + columns] ^ np.uint8(1)
            code |= lower << np.uint8(7 - k)
        code[np.isneginf(here[1:-1, 1:-1])] = 0
        codes[first:last] = code
    return codes.reshape(-1)


def _meetings(
    flat: Floats, codes: Codes, peaks: Places, saddles: Places, columns: int
) -> tuple[Places, Places, Floats]:
    """Pairs of hills and the highest saddle between them, from the highest down."""
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
    # A pair that meets again lower down is joined already.
    _, new = np.unique(high * np.intp(max(peaks.size, 1)) + two, return_index=True)
    new.sort()
    return high[new], two[new], flat[place[new]]


def _hills(flat: Floats, codes: Codes, peaks: Places, feet: Places, offsets: Places) -> Places:
    """Number of the hill that each of some points is on."""
    # The highest neighbour of each point on a climb; of the others it is never looked at.
    top: Indices = np.full(flat.size, -1, dtype=np.int32 if flat.size < 2**31 else np.int64)
    top[peaks] = peaks
    climbed = []
    at = feet
    while (at := _distinct(at[top[at] < 0], top)).size:
        climbed.append(at)
        further = _uphill(flat, codes, at, offsets)
        top[at] = further
        at = further
    # Each pass doubles the length of the climb; only points that are not there yet go on.
    going = np.concatenate([*climbed, feet[:0]])
    while going.size:
        further = top[top[going]]
        top[going] = further
        going = going[top[further] != further]
    number: Indices = np.empty_like(top)
    number[peaks] = np.arange(peaks.size, dtype=top.dtype)
    return np.asarray(number[top[feet]], dtype=np.intp)


def _distinct(places: Places, scratch: Indices) -> Places:
    """Each place once; what stands there in the other array is overwritten."""
    number = np.arange(-1 - places.size, -1, dtype=scratch.dtype)
    scratch[places] = number  # of those for one place the last one stays
    last: Places = places[scratch[places] == number]
    return last


def _uphill(flat: Floats, codes: Codes, places: Places, offsets: Places) -> Places:
    """The highest neighbour of points that have a higher one."""
    result = np.empty_like(places)
    bits = np.uint8(1) << np.arange(7, -1, -1, dtype=np.uint8)  # of equal ones the later wins
    for start in range(0, places.size, _BLOCK // 8):
        at = places[start : start + _BLOCK // 8]
        higher = (codes[at, None] & bits) != 0
        around = np.where(higher, at[:, None] + offsets[::-1], at[:, None])
        values = np.where(higher, flat[around], -np.inf)
        result[start : start + at.size] = around[np.arange(at.size), values.argmax(axis=1)]
    return result


def _merge(count: int, high: Places, two: Places, saddle: Floats) -> Floats:
    """Height of the saddle at which each hill ends; -inf for those that never do.

    Hills are numbered from the highest peak down: of two that meet the larger number ends.
    """
    ends = np.full(count, -np.inf)
    parent = np.arange(count)
    # Most hills end at their own first meeting, with a higher hill, whatever happens elsewhere:
    # those all at once, then the same with the larger hills that are left.
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


def _at_first_meeting(count: int, high: Places, two: Places) -> Places:
    """Meetings, ordered from the highest down, that are the first of the lower of the two hills."""
    numbers = np.arange(high.size)
    firsts = np.full((2, count), high.size)
    for first, hills in zip(firsts, (high, two), strict=True):
        first[hills[::-1]] = numbers[::-1]  # of several the last one stays, the highest
    first_of = firsts.min(axis=0)
    return np.flatnonzero(first_of[two] == numbers)


# -- the shape of their tops -----------------------------------------------------------------------

_A_PASS = 1 << 16  # summits a pass


class Tops(NamedTuple):
    """Fitted summits, one row each."""

    curvatures: Floats
    """Principal curvatures (n, 2) [1/m], the larger first; above zero for a summit."""
    shifts: Floats
    """From the highest point to the top, (n, 2) along x and y [pixels]."""
    rises: Floats
    """Height of the top above that of the highest point [m]."""
    inside: NDArray[np.bool_]
    """Whether the top is within the points that were fitted; where not, no shift and no rise."""


def fitted(
    heights: Floats, places: NDArray[np.intp], pixel: tuple[float, ...], window: int
) -> Tops:
    """Quadric through the points around each summit, by least squares.

    z = z0 + gx x + gy y + (hxx x^2 + 2 hxy x y + hyy y^2)/2 over window x window points. Exact for
    a paraboloid. Already with three points a side white noise reaches the second derivatives with a
    third of the variance that it has in the differences of three points along an axis.
    """
    reach = window // 2
    side = np.arange(-reach, reach + 1)
    y, x = (part.reshape(-1) for part in np.meshgrid(side, side, indexing="ij"))
    design = np.stack([np.ones(x.size), x, y, 0.5 * x * x, x * y, 0.5 * y * y], axis=1)
    solve = np.linalg.pinv(design).T
    offsets = y * heights.shape[1] + x
    flat = heights.reshape(-1)
    terms = np.empty((places.size, 6))
    for start in range(0, places.size, _A_PASS):
        part = places[start : start + _A_PASS]
        # From the summit's own height: a high mean costs no digits.
        terms[start : start + _A_PASS] = (flat[part[:, None] + offsets] - flat[part, None]) @ solve
    z0, gx, gy, hxx, hxy, hyy = terms.T
    det = hxx * hyy - hxy * hxy
    with np.errstate(divide="ignore", invalid="ignore"):
        right, down = (hxy * gy - hyy * gx) / det, (hxy * gx - hxx * gy) / det
    inside = (hxx < 0.0) & (det > 0.0) & (np.abs(right) <= reach) & (np.abs(down) <= reach)
    shifts = np.where(inside[:, None], np.stack([right, down], axis=1), 0.0)
    rises = np.where(inside, z0 + 0.5 * (gx * shifts[:, 0] + gy * shifts[:, 1]), 0.0)
    dx, dy = pixel
    return Tops(_principal(-hxx / dx**2, -hxy / (dx * dy), -hyy / dy**2), shifts, rises, inside)


def equivalent_radii(curvatures: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Radii 1/sqrt(k1 k2) [m], and which summits are round: curved down in every direction."""
    large, small = curvatures.T
    # So flat along one direction that rounding decides counts as flat.
    good = (large > 0.0) & (small > 1e-9 * large)
    product = np.where(good, large * small, 1.0)
    return 1.0 / np.sqrt(product), good


def _principal(a: Floats, b: Floats, c: Floats) -> Floats:
    """Eigenvalues of the matrices ((a, b), (b, c)), the larger first."""
    middle, half = 0.5 * (a + c), np.hypot(0.5 * (a - c), b)
    large = middle + half
    # The product of both is the determinant: no difference of almost equal numbers.
    with np.errstate(divide="ignore", invalid="ignore"):
        small = np.where(middle > 0.0, (a * c - b * b) / large, middle - half)
    return np.stack([large, small], axis=1)
