"""Conditioning of a scan: cropping, form, gaps, band of wavelengths."""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np

from microslip._core.checks import Floats
from microslip._core.errors import InputError
from microslip._core.frozen import lock
from microslip._core.units import engineering
from microslip._core.wording import did_you_mean, quote, quoted
from microslip.surfaces.checks import length_of
from microslip.surfaces.filters import smooth
from microslip.surfaces.height_map import HeightMap, Map, noise_std
from microslip.surfaces.levelling import level as without_form
from microslip.surfaces.options import LEVELS

_ROUNDING = 1e-14  # residual of an exact plane over the heights


def condition(
    scan: Map,
    *,
    level: Literal["plane", "quadratic", "mean"] | None = None,
    fill: Literal["interpolate"] | None = None,
    cutoff: float | str | None = None,
    long_cutoff: float | str | None = None,
    crop: Any = None,
) -> Map:
    """Crop, level, fill and filter a scan, in this order.

    Parameters
    ----------
    level : {"plane", "quadratic", "mean"}, optional
        Form to remove, fitted by least squares.
    fill : {"interpolate"}, optional
        Interpolate missing points (see Notes).
    cutoff : float or str, optional
        Short-wave cut-off [m], or text such as "10 um": shorter waves are removed.
    long_cutoff : float or str, optional
        Long-wave cut-off [m]: longer waves, including the mean, are removed.
    crop : float, str or pair of them, optional
        Length [m] to remove at each end, or lengths along x and y.

    Returns
    -------
    Scan
        The conditioned scan; its notes and cut-offs record the steps.

    Notes
    -----
    In terms of ISO 25178-3, ``cutoff`` is the nesting index of the S-filter, ``level`` the
    F-operation and ``long_cutoff`` the nesting index of the L-filter. The form is removed first, so
    that a tilt does not leak through the ends of the S-filter; away from the ends the order makes
    no difference. The Gaussian filters transmit half the amplitude at the cut-off (ISO
    16610-61:2015; for profiles ISO 16610-21:2011). At edges and gaps the weights are normalised to
    sum to one. Filling solves the discrete Laplace equation in the gaps approximately, from coarse
    to fine grids, in a time proportional to the number of points.
    """
    if crop is not None:
        scan = _cropped(scan, crop)
    _check_choice("level", level, LEVELS)
    _check_choice("fill", fill, ("interpolate",))
    short, long = band(scan, cutoff, long_cutoff)
    heights, notes = scan.heights, list(scan.notes)
    scan.measurable()
    if level is not None:
        before = float(np.nanmax(np.abs(heights)))
        heights, removed = without_form(heights, level)
        if float(np.nanmax(np.abs(heights))) <= _ROUNDING * before:
            raise InputError(
                f'{scan.name[:60]}: `level="{level}"` leaves only rounding '
                "errors: there is no roughness to measure"
            )
        notes.append(f"level: {level} removed, {engineering(removed, 'm')} high.")
    unfiltered = scan._unfiltered
    if unfiltered is None and (fill, short, long) != (None, None, None):
        unfiltered = scan.changed(lock(heights) if heights is not scan.heights else heights)
    if fill is not None:
        count = int(np.count_nonzero(np.isnan(heights)))
        if count:
            heights = filled(heights)
        notes.append(f"fill: {count} of {heights.size} points interpolated.")
    ends = {"cutoff": scan.cutoff, "long_cutoff": scan.long_cutoff}
    noise = scan._noise_before
    if short is not None:
        if scan.cutoff is None and not scan.is_profile:
            noise = scan.noise if heights is scan.heights else noise_std(heights)
        heights = smooth(heights, scan.pixel, short)
        # Cut-offs of successive Gaussian filters add in quadrature.
        both = ends["cutoff"] = math.hypot(scan.cutoff or 0.0, short)
        sum_ = "" if scan.cutoff is None else f", {engineering(both, 'm')} with the earlier filter"
        notes.append(
            f"cutoff: waves shorter than {engineering(short, 'm')} removed{sum_} (Gaussian filter, "
            "half the amplitude there)."
        )
    if long is not None:
        heights = heights - smooth(heights, scan.pixel, long)
        ends["long_cutoff"] = min(long, scan.long_cutoff or math.inf)
        notes.append(
            f"long_cutoff: waves longer than {engineering(long, 'm')} removed (Gaussian filter, "
            "half the amplitude there)."
        )
    if heights is not scan.heights:
        lock(heights)
    return scan.changed(
        heights, notes=tuple(notes), noise_before=noise, unfiltered=unfiltered, **ends
    )


def _cropped(scan: Map, crop: Any) -> Map:
    lengths = tuple(crop) if isinstance(crop, (tuple, list)) else (crop,)
    if not 1 <= len(lengths) <= len(scan.pixel):
        raise InputError(f"`crop` must be a length, or one length per axis, got {quote(crop)}")
    ends = [length_of("crop", length, "0.4 mm") for length in lengths]
    ends = ends * len(scan.pixel) if len(ends) == 1 else ends
    counts = [math.ceil(end / step - 1e-9) for end, step in zip(ends, scan.pixel, strict=True)]
    if min(n - 2 * c for n, c in zip(scan.heights.shape[::-1], counts, strict=True)) < 4:
        raise InputError(
            f"`crop` must leave four points along each axis, got {quote(crop)} off each end of "
            f"{' x '.join(_readable(size) for size in scan.size)}"
        )
    middle = tuple(
        slice(c, n - c) for n, c in zip(scan.heights.shape, reversed(counts), strict=True)
    )
    note = f"crop: {' x '.join(_readable(end) for end in ends)} removed at each end."
    unfiltered = scan._unfiltered
    if unfiltered is not None:
        unfiltered = unfiltered.changed(lock(np.array(unfiltered.heights[middle])))
    heights = lock(np.array(scan.heights[middle]))
    return scan.changed(heights, notes=(*scan.notes, note), unfiltered=unfiltered)


def band(scan: HeightMap, cutoff: Any, long_cutoff: Any) -> tuple[float | None, float | None]:
    """Validate the short-wave and the long-wave cut-off [m] for a scan and return both."""
    shortest, longest = 2.0 * max(scan.pixel), min(scan.size)
    cutoffs: list[float | None] = []
    for name, value in (("cutoff", cutoff), ("long_cutoff", long_cutoff)):
        if value is None:
            cutoffs.append(None)
            continue
        length = length_of(name, value, "10 um")
        if not shortest < length < longest:
            where = _beside_bounds(length, shortest, longest)
            raise InputError(
                f"`{name}` must be between two pixels ({_readable(shortest)}) and the size of "
                f"the scan ({_readable(longest)}), got {_readable(length)}: {where}"
            )
        cutoffs.append(length)
    short, long = cutoffs
    if long is not None and (before := short or scan.cutoff) is not None and long <= before:
        raise InputError(
            f"`long_cutoff` must be longer than `cutoff`, got {_readable(long)} and "
            f"{_readable(before)}"
        )
    if short is not None and scan.long_cutoff is not None and short >= scan.long_cutoff:
        raise InputError(
            f"`cutoff` must be shorter than the `long_cutoff` {_readable(scan.long_cutoff)} "
            f"that was applied before, got {_readable(short)}"
        )
    return short, long


def remaining(scan: HeightMap, cutoff: float | None) -> float | None:
    """Return the cut-off [m] of the filter still needed to reach the total ``cutoff`` [m].

    Squares of the cut-offs of successive Gaussian filters add: the result is sqrt(cutoff^2 -
    before^2) with the cut-off ``before`` already applied, or None if no filter is needed.
    """
    before = scan.cutoff
    if cutoff is None or before is None:
        return cutoff
    if math.isclose(cutoff, before, rel_tol=1e-9):
        return None
    shortest = 2.0 * max(scan.pixel)
    length = math.sqrt(max(cutoff - before, 0.0) * (cutoff + before))
    if length > shortest:
        return length
    came, applied = (engineering(value, "m", 4, trim=True) for value in (cutoff, before))
    if cutoff < before:
        raise InputError(
            f"`cutoff` must not be shorter than the {applied} that was applied before, got "
            f"{came}: removed waves cannot be restored; write None, or filter the scan as read"
        )
    next_one = engineering(math.hypot(before, 1.01 * shortest), "m", 4, trim=True)
    raise InputError(
        f"`cutoff` must be the {applied} that was applied before, or at least "
        f"{next_one}, got {came}: the filter in between would need a cut-off below two pixels"
    )


def _readable(length: float) -> str:
    return engineering(length, "m", 5, trim=True)


def _beside_bounds(length: float, shortest: float, longest: float) -> str:
    if math.isclose(length, shortest, rel_tol=1e-12):
        return "exactly two pixels"
    if math.isclose(length, longest, rel_tol=1e-12):
        return "exactly the size of the scan"
    return "below two pixels" if length < shortest else "beyond the size of the scan"


def _check_choice(name: str, value: Any, words: tuple[str, ...]) -> None:
    if value is not None and (not isinstance(value, str) or value not in words):
        hint = did_you_mean(value, words) if isinstance(value, str) else ""
        raise InputError(f"`{name}` must be {quoted(words)} or None, got {quote(value)}{hint}")


_PASSES = 40  # conjugate gradient steps per grid, to bound the time
_TOLERANCE = 1e-5  # residual over that of the initial guess


def filled(heights: Floats) -> Floats:
    """Return the heights with missing points interpolated smoothly.

    The discrete Laplace equation is solved in the gaps with no flux over the edges of the scan:
    each filled point is the mean of its neighbours and lies between the heights around its gap,
    relative to the mean plane, which is removed first and added afterwards. Coarser grids give the
    initial guess; on each grid the conjugate gradients stop after at most 40 steps.
    """
    grid = heights[None] if heights.ndim == 1 else heights
    gaps = np.isnan(grid)
    if not gaps.any():
        return np.array(heights)
    plane: Floats | float = 0.0
    try:
        flat, _ = without_form(heights, "plane")
        flat = flat.reshape(grid.shape)
        plane = _extended(grid, flat, gaps)
    except ValueError:  # too few points for a plane
        flat = np.array(grid)
    _fill(flat, gaps)
    flat += plane
    np.copyto(flat, grid, where=~gaps)
    return flat.reshape(heights.shape)


def _extended(grid: Floats, flat: Floats, gaps: np.ndarray) -> Floats:
    rows, columns = (np.linspace(-1.0, 1.0, n) if n > 1 else np.zeros(1) for n in grid.shape)
    there = np.flatnonzero(~gaps.ravel())
    if there.size > 10_000:
        there = there[:: there.size // 10_000]
    row, column = np.divmod(there, grid.shape[1])
    removed = grid.ravel()[there] - flat.ravel()[there]
    basis = np.stack([np.ones(there.size), columns[column], rows[row]], axis=1)
    a, b, c = np.linalg.lstsq(basis, removed, rcond=1e-12)[0]
    return np.asarray(a + b * columns[None, :] + c * rows[:, None])


def _fill(values: Floats, gaps: np.ndarray) -> None:
    if not gaps.any():
        return
    coarse, coarse_gaps = _coarser(values, gaps)
    if coarse.shape != values.shape:
        _fill(coarse, coarse_gaps)
        np.copyto(values, _finer(coarse, values.shape), where=gaps)
    _relax(values, gaps)


def _coarser(values: Floats, gaps: np.ndarray) -> tuple[Floats, np.ndarray]:
    """Return means of the points present in blocks of 2 x 2 points, and the new gaps."""
    sums, counts = np.where(gaps, 0.0, values), np.subtract(1.0, gaps)
    for axis in (0, 1):
        starts = np.arange(0, values.shape[axis], 2)
        sums, counts = (np.add.reduceat(part, starts, axis=axis) for part in (sums, counts))
    empty = counts == 0.0
    return np.where(empty, np.nan, sums / np.where(empty, 1.0, counts)), empty


def _finer(coarse: Floats, shape: tuple[int, ...]) -> Floats:
    """Interpolate linearly from the centres of 2 x 2 blocks to the points in them."""
    result = coarse
    for axis in (0, 1):
        place = np.clip(0.5 * np.arange(shape[axis]) - 0.25, 0.0, coarse.shape[axis] - 1)
        low = place.astype(int)
        high = np.minimum(low + 1, coarse.shape[axis] - 1)
        share = np.expand_dims(place - low, 1 - axis)
        result = result.take(low, axis) * (1.0 - share) + result.take(high, axis) * share
    return result


def _relax(values: Floats, gaps: np.ndarray) -> None:
    """Solve for missing points that equal the mean of their neighbours, by conjugate gradients."""
    from scipy.sparse import coo_matrix

    count = int(np.count_nonzero(gaps))
    number = np.full(gaps.shape, -1, dtype=np.int32)
    number[gaps] = np.arange(count, dtype=np.int32)
    degree, fixed = np.zeros(count), np.zeros(count)
    entries = []
    for axis in (0, 1):
        for ours, theirs in ((slice(1, None), slice(None, -1)), (slice(None, -1), slice(1, None))):
            here = (ours, slice(None)) if axis == 0 else (slice(None), ours)
            there = (theirs, slice(None)) if axis == 0 else (slice(None), theirs)
            mine = gaps[here]
            row, neighbour = number[here][mine], number[there][mine]
            degree[row] += 1.0  # each point has at most one neighbour on each side
            inside = neighbour >= 0
            fixed[row[~inside]] += values[there][mine][~inside]
            entries.append((row[inside], neighbour[inside]))
    rows, columns = (np.concatenate(part) for part in zip(*entries, strict=True))
    # Single precision for the counts, since a scan may have millions of gaps.
    links = coo_matrix((np.ones(rows.size, dtype=np.float32), (rows, columns)), (count, count))
    links = links.tocsr().astype(float)
    guess = values[gaps]
    residual = fixed - degree * guess + links @ guess
    # Jacobi preconditioner: scale each row by its number of neighbours.
    step = residual / degree
    size = first = float(residual @ step)
    for _ in range(_PASSES):
        if size <= _TOLERANCE**2 * first:
            break
        image = degree * step - links @ step
        share = size / float(step @ image)
        guess += share * step
        residual -= share * image
        scaled = residual / degree
        size, before = float(residual @ scaled), size
        step = scaled + (size / before) * step
    values[gaps] = guess
