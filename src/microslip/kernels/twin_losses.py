"""What slip loses along a record, in NumPy: part of :mod:`microslip.kernels.twin`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from microslip.kernels.layout import RULES, Floats
from microslip.kernels.twin_diagram import step_front
from microslip.kernels.twin_profile import Panels, excesses

Run = tuple[float, float, float, float, float, float]


def runs(
    stack: list[tuple[float, float, float]], first: float, last: float, move: float
) -> Iterator[Run]:
    """Runs of one step that slips: start, end, density, sign, and the separations meanwhile.

    The front covers the integral of 1 - sign D at a constant pace. While contact is lost, the
    separation may catch up with it, and slip then begins anew in the other direction.
    """
    rows = [*reversed(stack), (math.inf, 0.0, 0.0)]
    rise = last - first
    q, time, row = first, 0.0, 0
    while time < 1.0:
        while rows[row][0] <= q:
            row += 1
        end, density, _ = rows[row]
        drive = move + density * max(rise, 0.0)
        if abs(drive) <= 4e-16 * (abs(move) + abs(rise)):  # what is lost takes just its share along
            time = min((end - first) / rise, 1.0) if rise > 0.0 else 1.0
            q = end
            continue
        sign = 1.0 if drive > 0.0 else -1.0
        pace = sign * move + rise
        begun, origin = time, q
        while time < 1.0:
            end, density, _ = rows[row]
            here = first + rise * time
            rate = 1.0 - sign * density
            if rate == 0.0:  # slips already
                q = end
                row += 1
                continue
            speed = pace / rate
            until = min(time + (end - q) / speed, 1.0)
            # Slower than the separation, the front is caught.
            if speed < rise and (caught := time + (q - here) / (rise - speed)) < until:
                until = caught
            ahead = until == caught if speed < rise else False
            stop = end if until < 1.0 and not ahead else min(q + speed * (until - time), end)
            if stop > q:
                yield q, stop, density, sign, here, first + rise * until
            q, time = stop, until
            if ahead:
                break
            if q >= end:
                row += 1
        if time <= begun and q <= origin:  # rounding: neither moves, so that neither slips
            time = min((end - first) / rise, 1.0) if rise > 0.0 else 1.0
            q = end


def slip_runs(
    separation: Floats,
    place: Floats,
    stack: Floats,
    depth: int,
    last_separation: float,
    last_place: float,
) -> Floats:
    """Runs of the slip front along a record: columns of the sample and what :func:`runs` gives."""
    rows: list[tuple[float, float, float]] = [tuple(row) for row in stack[:depth].tolist()]
    d0, x0 = last_separation, last_place
    found: list[tuple[float, ...]] = []
    for j, (d, x) in enumerate(zip(separation.tolist(), place.tolist(), strict=True)):
        depth, front, density, kind = step_front(d, x, rows, len(rows), d0, x0)
        if kind:
            found += [(float(j), *run) for run in runs(rows, d0, d, x - x0)]
        beyond = x0
        if kind and depth:
            end, old, rest = rows[depth - 1]
            beyond = old * (end - front) + rest
        elif kind:
            beyond = 0.0
        del rows[depth:]
        if front > d:
            rows.append((front, density, beyond))
        d0, x0 = d, x
    return np.array(found, dtype=float).reshape(-1, 7).T


def losses(
    separation: Floats,
    place: Floats,
    loss: Floats,
    stack: Floats,
    depth: int,
    last_separation: float,
    last_place: float,
    rules: Floats,
    *profile: Any,
) -> None:
    """What each step loses, over mu kappa; ``stack`` (capacity, 3) is used up.

    While the front runs by dq over D, with s behind it, (1 - s D) [N(d) - N(q) + N'(q) (q - d)] dq
    is lost. ``rules`` holds nodes and weights on [0, 1] of each of RULES in turn.
    """
    columns = slip_runs(separation, place, stack, depth, last_separation, last_place)
    loss[:] = 0.0
    if not columns.size:
        return
    sample, start, end, density, sign, first, last = columns
    panels = Panels(*profile)
    top = panels.anchor + (panels.count - panels.first) / panels.inverse_width
    # Where the separation is past the end there is no load, and however far it goes no loss.
    rise, ahead = last - first, end - start
    share = np.divide(top - first, rise, out=np.ones_like(rise), where=rise != 0.0)
    cut = start + np.clip(share, 0.0, 1.0) * ahead
    late, early = (first > top) & (last < top), (first <= top) & (last > top)
    start, first = np.where(late, cut, start), np.where(late, top, first)
    end, last = np.where(early, cut, end), np.where(early, top, last)
    end = np.where(first > top, start, end)
    last = np.where(first > top, first, last)
    # Past the end of the curve nothing depends on the front any more.
    stop = np.clip(top, start, end)
    share = np.divide(stop - start, end - start, out=np.zeros_like(end), where=end > start)
    meanwhile = first + share * (last - first)
    result = np.zeros(sample.size)
    for part in (
        (start, stop, first, meanwhile),
        (stop, end, meanwhile, last),
    ):
        result += _pieces(*part, rules, panels, profile, top)
    loss += np.bincount(
        sample.astype(np.int64), (1.0 - sign * density) * result, minlength=loss.size
    )


def _pieces(
    start: Floats,
    end: Floats,
    first: Floats,
    last: Floats,
    rules: Floats,
    panels: Panels,
    profile: tuple[Any, ...],
    top: float,
) -> Floats:
    ahead, rise = end - start, last - first
    beyond = start >= top
    length = np.where(beyond, 0.0, ahead)
    length = np.maximum(length, np.minimum(np.abs(rise), 1e300)) * panels.inverse_width
    result = np.zeros(start.size)
    offset, least = 0, -1.0
    for most, count in RULES:
        nodes, weights = rules[offset : offset + count], rules[offset + count : offset + 2 * count]
        offset += 2 * count
        final = count == RULES[-1][1]
        which = np.flatnonzero((length > least) & (final | (length <= most)) & (ahead > 0.0))
        least = most
        if not which.size:
            continue
        parts = np.maximum(np.ceil(length[which] / most), 1.0) if final else np.ones(which.size)
        owner = np.repeat(which, parts.astype(np.int64))
        total = np.repeat(parts, parts.astype(np.int64))
        begins = np.repeat(np.cumsum(parts) - parts, parts.astype(np.int64))
        index = np.arange(owner.size) - begins
        sums = np.zeros(owner.size)
        value = np.empty(owner.size)
        for node, weight in zip(nodes.tolist(), weights.tolist(), strict=True):
            t = (index + node) / total
            d = first[owner] + t * rise[owner]
            gap = np.maximum((start[owner] - first[owner]) + t * (ahead[owner] - rise[owner]), 0.0)
            excesses(d, gap, value, *profile)
            sums += weight * value
        result += np.bincount(owner, sums / total, minlength=start.size)
    return ahead * result
