"""What slip loses along a record, in NumPy: part of :mod:`microslip.kernels.twin`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from microslip.kernels.layout import RULES, Floats
from microslip.kernels.twin_diagram import step_front
from microslip.kernels.twin_profile import Panels, excesses

Run = tuple[float, float, float, float, float, float, float]


def runs(
    stack: list[tuple[float, float, float]], first: float, last: float, move: float
) -> Iterator[Run]:
    """Runs of one step that slips: length, gap from and to, density, sign, separations meanwhile.

    The front covers the integral of 1 - sign D at a constant pace. While contact is lost, the
    separation may catch up with it, and slip then begins anew in the other direction. What is
    followed is the gap between the two, whose growth cancels no digits where the step goes along
    a row's own D: proportional loading, the commonest of all.
    """
    rows = [(math.inf, 0.0, 0.0), *stack]
    rise = last - first
    here, gap, time, sign = first, 0.0, 0.0, 0.0
    while time < 1.0:
        end, density, _ = rows[-1]
        if end <= here + gap:
            rows.pop()
            continue
        drive = move + density * rise
        if gap == 0.0:
            if drive == 0.0:  # what is lost takes just its share along
                time = min((end - first) / rise, 1.0) if rise > 0.0 else 1.0
                here = end
                rows.pop()
                continue
            sign = 1.0 if (drive if rise > 0.0 else move) > 0.0 else -1.0
        rate = 1.0 - sign * density
        if rate <= 0.0:  # slips already
            gap = end - here
            rows.pop()
            continue
        growth = max(sign * drive / rate, -rise)  # the front never goes back
        speed = growth + rise
        until = time + (end - here - gap) / speed if speed > 0.0 else math.inf
        # The separation is the quicker one: the front may be caught.
        catches = growth < 0.0 and time - gap / growth <= min(1.0, until)
        later = min(1.0, time - gap / growth if catches else until)
        there = first + rise * later if later < 1.0 else last
        ahead = min(end - here - gap, speed * (later - time))
        wide = 0.0 if catches else max(gap + growth * (later - time), 0.0)
        if (
            not catches and until <= 1.0
        ):  # to where the row ends: how quickly may be rounding over rounding
            rows.pop()
            ahead, wide = end - here - gap, max(end - there, 0.0)
        if ahead > 0.0:
            yield ahead, gap, wide, density, sign, here, there
        time, gap, here = later, wide, there


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
    slips: list[tuple[float, ...]] = []
    for j, (d, x) in enumerate(zip(separation.tolist(), place.tolist(), strict=True)):
        depth, front, density, kind = step_front(d, x, rows, len(rows), d0, x0)
        if kind:
            slips += [(float(j), *run) for run in runs(rows, d0, d, x - x0)]
        beyond = x0
        if kind and depth:
            end, old, outer_integral = rows[depth - 1]
            beyond = old * (end - front) + outer_integral
        elif kind:
            beyond = 0.0
        del rows[depth:]
        if front > d:
            rows.append((front, density, beyond))
        d0, x0 = d, x
    return np.array(slips, dtype=float).reshape(-1, 8).T


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
    sample, ahead, gap, until, density, sign, first, last = columns
    panels = Panels(*profile)
    top = panels.anchor + (panels.count - panels.first) / panels.inverse_width
    # Where the separation is past the end there is no load, and however far it goes no loss.
    rise = last - first
    share = np.divide(top - first, rise, out=np.ones_like(rise), where=rise != 0.0)
    share = np.clip(share, 0.0, 1.0)
    middle = gap + share * (until - gap)
    late, early = (first > top) & (last < top), (first <= top) & (last > top)
    ahead = np.where(late, (1.0 - share) * ahead, np.where(early, share * ahead, ahead))
    ahead = np.where((first > top) & ~late, 0.0, ahead)
    gap, first = np.where(late, middle, gap), np.where(late, top, first)
    until, last = np.where(early, middle, until), np.where(early, top, last)
    # Past the end of the curve nothing depends on the front any more.
    start, end = first + gap, last + until
    share = np.divide(top - start, end - start, out=np.ones_like(end), where=end > top)
    share = np.where(start >= top, 0.0, share)
    full = share == 1.0
    meanwhile = np.where(full, last, first + share * (last - first))
    between = np.where(full, until, np.where(share == 0.0, gap, np.maximum(top - meanwhile, 0.0)))
    result = _pieces(share * ahead, gap, between, first, meanwhile, False, rules, panels, profile)
    result += _pieces(
        (1.0 - share) * ahead, between, until, meanwhile, last, True, rules, panels, profile
    )
    loss += np.bincount(
        sample.astype(np.int64), (1.0 - sign * density) * result, minlength=loss.size
    )


def _pieces(
    ahead: Floats,
    gap: Floats,
    until: Floats,
    first: Floats,
    last: Floats,
    past: bool,
    rules: Floats,
    panels: Panels,
    profile: tuple[Any, ...],
) -> Floats:
    rise = last - first
    length = np.zeros(ahead.size) if past else ahead
    length = np.maximum(length, np.minimum(np.abs(rise), 1e300)) * panels.inverse_width
    result = np.zeros(ahead.size)
    offset, lower = 0, -1.0
    for upper, count in RULES:
        nodes, weights = rules[offset : offset + count], rules[offset + count : offset + 2 * count]
        offset += 2 * count
        final = count == RULES[-1][1]
        rows = np.flatnonzero((length > lower) & (final | (length <= upper)) & (ahead > 0.0))
        lower = upper
        if not rows.size:
            continue
        parts = np.maximum(np.ceil(length[rows] / upper), 1.0) if final else np.ones(rows.size)
        owner = np.repeat(rows, parts.astype(np.int64))
        total = np.repeat(parts, parts.astype(np.int64))
        begins = np.repeat(np.cumsum(parts) - parts, parts.astype(np.int64))
        index = np.arange(owner.size) - begins
        sums = np.zeros(owner.size)
        value = np.empty(owner.size)
        for node, weight in zip(nodes.tolist(), weights.tolist(), strict=True):
            t = (index + node) / total
            d = first[owner] + t * rise[owner]
            excesses(d, gap[owner] + t * (until[owner] - gap[owner]), value, *profile)
            sums += weight * value
        result += np.bincount(owner, sums / total, minlength=ahead.size)
    return ahead * result
