"""Outliers and missing points of a scan."""

from __future__ import annotations

import numpy as np

from microslip._core.checks import Floats
from microslip.scans.levelling import level

_PASSES = 40  # of conjugate gradients on each grid: bounds the time; a guess is there already
_TOLERANCE = 1e-5  # residual, beside that of the first guess


def outliers(heights: Floats, threshold: float) -> np.ndarray:
    """Outliers among neighbouring points."""
    from scipy.ndimage import median_filter

    gaps = np.isnan(heights)
    filled = fill(heights) if gaps.any() else heights
    filled = _untilted(filled)
    away = np.abs(filled - median_filter(filled, size=5, mode="mirror"))
    away[gaps] = 0.0
    usual = float(np.median(away[~gaps]))
    if usual == 0.0:  # few digits: most points are their neighbours' median
        steps = np.concatenate([np.diff(filled, axis=a).ravel() for a in range(filled.ndim)])
        steps = np.abs(steps[steps != 0.0])
        usual = float(np.median(steps)) if steps.size else 0.0
    return np.asarray(away > threshold * 1.4826 * usual)


def _untilted(heights: Floats) -> Floats:
    """Heights without their tilt, which mirrored edges would bend; outliers do not count."""
    result = heights
    for axis, count in enumerate(heights.shape):
        step = max(1, heights.size // 200_000)
        slope = float(np.median(np.diff(heights, axis=axis).ravel()[::step]))
        result = result - slope * np.expand_dims(
            np.arange(count, dtype=float), [a for a in range(heights.ndim) if a != axis]
        )
    return result


def fill(heights: Floats) -> Floats:
    """Heights with the gaps filled smoothly from around them.

    In the gaps the discrete Laplace equation is solved, nothing flowing over the edges of the
    scan: each point is the mean of its neighbours, so no filled point is higher or lower than all
    points around its gap, but for what is left of a plane of the whole scan, which is taken out
    before and put back after. A coarser grid gives the first guess, and so on down; on each the
    conjugate gradients are stopped after at most 40 passes.
    """
    grid = heights[None] if heights.ndim == 1 else heights
    gaps = np.isnan(grid)
    if not gaps.any():
        return np.array(heights)
    plane: Floats | float = 0.0
    try:
        flat, _ = level(heights, (1.0,) * heights.ndim, "plane")
        flat = flat.reshape(grid.shape)
        plane = _extended(grid, flat, gaps)
    except ValueError:  # too few points for a plane
        flat = np.array(grid)
    _fill(flat, gaps)
    flat += plane
    np.copyto(flat, grid, where=~gaps)
    return flat.reshape(heights.shape)


def _extended(grid: Floats, flat: Floats, gaps: np.ndarray) -> Floats:
    """The plane that was taken out, at every point."""
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
    """Fill the gaps of an array in place."""
    if not gaps.any():
        return
    coarse, coarse_gaps = _coarser(values, gaps)
    if coarse.shape != values.shape:
        _fill(coarse, coarse_gaps)
        np.copyto(values, _finer(coarse, values.shape), where=gaps)
    _relax(values, gaps)


def _coarser(values: Floats, gaps: np.ndarray) -> tuple[Floats, np.ndarray]:
    """Means of the points there are of each two by two."""
    sums, counts = np.where(gaps, 0.0, values), np.subtract(1.0, gaps)
    for axis in (0, 1):
        starts = np.arange(0, values.shape[axis], 2)
        sums, counts = (np.add.reduceat(part, starts, axis=axis) for part in (sums, counts))
    empty = counts == 0.0
    return np.where(empty, np.nan, sums / np.where(empty, 1.0, counts)), empty


def _finer(coarse: Floats, shape: tuple[int, ...]) -> Floats:
    """Linear interpolation between the centres of the blocks."""
    result = coarse
    for axis in (0, 1):
        place = np.clip(0.5 * np.arange(shape[axis]) - 0.25, 0.0, coarse.shape[axis] - 1)
        low = place.astype(int)
        high = np.minimum(low + 1, coarse.shape[axis] - 1)
        share = np.expand_dims(place - low, 1 - axis)
        result = result.take(low, axis) * (1.0 - share) + result.take(high, axis) * share
    return result


def _relax(values: Floats, gaps: np.ndarray) -> None:
    """Make each missing point the mean of its neighbours, by conjugate gradients."""
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
    # The parts are counted, not stored as numbers of eight bytes: a scan may have millions.
    links = coo_matrix((np.ones(rows.size, dtype=np.float32), (rows, columns)), (count, count))
    links = links.tocsr().astype(float)
    guess = values[gaps]
    residual = fixed - degree * guess + links @ guess
    # Those with the most known neighbours are the surest: scale each row to one.
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
