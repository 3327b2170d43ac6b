"""Convex splines through tables of loads, and their differences and integrals."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip._core.kernels import Integers
from microslip._core.quadrature import gauss_legendre

_NODES, _WEIGHTS = gauss_legendre(20)
_TERMS = 2**13  # of pairs and pieces at once


class Spline(NamedTuple):
    """Convex quadratic spline, extrapolated beyond its last knot by an exponential or by zero."""

    knots: Floats
    slopes: Floats  # at each knot, on its right; at the last one on its left
    curvatures: Floats  # after each knot
    loads: Floats
    jumps: Floats  # of the slope at each knot: a corner between straight runs, or at the end
    ends: Floats  # slopes at the right end of each piece
    has_tail: bool

    @property
    def decay_length(self) -> float:
        """Decay length [m] of the exponential beyond the last knot."""
        return float(self.loads[-1] / -self.slopes[-1])


def convex_spline(d: Floats, n: Floats, has_tail: bool) -> Spline:
    """Return Schumaker's quadratic spline through convex loads ``n`` [N] at separations ``d`` [m].

    Slopes at nodes lie between those of the adjacent secants, so that the spline is convex. An
    interval has one parabola, or two that meet where the slope is that of the secant. ``has_tail``:
    the last slope is not zero, for the exponential beyond the last load.
    """
    steps = np.diff(d)
    secants = np.maximum.accumulate(np.diff(n) / steps)  # rising, up to rounding
    straight = np.zeros(steps.size, dtype=bool)
    level = np.diff(secants) <= 1e-12 * np.abs(secants[:-1])
    straight[:-1] |= level
    straight[1:] |= level
    # Slopes at nodes as of a parabola through three points; on straight runs their secant.
    inner = (secants[:-1] * steps[1:] + secants[1:] * steps[:-1]) / (steps[:-1] + steps[1:])
    inner = np.where(straight[1:], secants[1:], np.where(straight[:-1], secants[:-1], inner))
    first = 2.0 * secants[0] - inner[0]
    last = min(2.0 * secants[-1] - inner[-1], (0.5 * secants[-1]) if has_tail else 0.0)
    nodes = np.concatenate(([first], inner, [last]))
    left = np.where(straight, secants, nodes[:-1])
    right = np.where(straight, secants, nodes[1:])

    knots, slopes, curvatures, ends = [], [], [], []
    for x, h, m, start, end in zip(d[:-1], steps, secants, left, right, strict=True):
        if abs(start + end - 2.0 * m) <= 1e-14 * abs(m):
            parts = [(x, h, start, end)]
        else:
            share = (end - m) / (end - start)
            parts = [(x, share * h, start, m), (x + share * h, (1.0 - share) * h, m, end)]
        for at, width, low, high in parts:
            knots.append(at)
            slopes.append(low)
            ends.append(high)
            curvatures.append(max(high - low, 0.0) / width)
    k = np.array([*knots, d[-1]])
    s = np.array([*slopes, ends[-1]])
    # Loads from the end backwards, so that small ones near it keep their digits.
    drops = -np.diff(k) * 0.5 * (s[:-1] + np.array(ends))
    loads = np.append(np.cumsum(drops[::-1])[::-1] + n[-1], n[-1])
    after = np.append(s[1:-1], s[-1] if has_tail else 0.0)
    jump = after - np.array(ends)
    jumps = np.append(0.0, np.where(jump > -1e-12 * np.array(ends), jump, 0.0))  # not rounding
    return Spline(k, s, np.array([*curvatures, 0.0]), loads, jumps, np.array(ends), has_tail)


def decayed(x: Floats, power: int, other_power: int) -> Floats:
    """Return the integral of w^power (x - w)^other_power exp(-w) over [0, x], powers 0 or 1."""
    w = np.minimum(x, 1.0)[:, None] * _NODES
    near = np.minimum(x, 1.0) * (
        (w**power * (x[:, None] - w) ** other_power * np.exp(-w)) @ _WEIGHTS
    )
    gone = np.exp(-x)
    far = {
        (0, 0): 1.0 - gone,
        (1, 0): 1.0 - (1.0 + x) * gone,
        (0, 1): x - 1.0 + gone,
        (1, 1): x - 2.0 + (x + 2.0) * gone,
    }[power, other_power]
    return np.asarray(np.where(x <= 1.0, near, far))


def over_pairs(spline: Spline, kind: str, d: Floats, u: Floats) -> Floats:
    """Return drop, excess or excess slope (:mod:`.grids`) at pairs (d, u), without cancellation."""
    if kind == "drop":
        return _drops(spline, d, u)
    last = float(spline.knots[-1])
    total = np.zeros(d.size)
    # Only the pieces that some pair passes over.
    ends = (float(d.min(initial=last)), float((d + u).max(initial=-np.inf)))
    first, end = np.searchsorted(spline.knots, ends)
    passed = slice(max(int(first) - 1, 0), int(end))
    curved = passed.start + np.flatnonzero(spline.curvatures[:-1][passed])
    bent = passed.start + np.flatnonzero(spline.jumps[passed] > 0.0)
    left, right = spline.knots[curved], spline.knots[curved + 1]
    curves, places, jumps = spline.curvatures[curved], spline.knots[bent], spline.jumps[bent]
    rows = max(_TERMS // max(curved.size, 1), 1)
    for row in range(0, d.size, rows):
        part = slice(row, row + rows)
        near, step = d[part, None], u[part, None]
        low, high = np.maximum(left - near, 0.0), np.minimum(right - near, step)
        width, middle = np.maximum(high - low, 0.0), 0.5 * (low + high)
        inner = middle
        if kind == "excess":
            inner = middle * (step - middle) - width * width / 12.0
        total[part] = 0.5 * ((width * inner) @ curves)
        if bent.size:
            v = places - near
            inner = v * (step - v) if kind == "excess" else v
            total[part] += 0.5 * (np.where((v > 0.0) & (v <= step), inner, 0.0) @ jumps)
    if spline.has_tail:
        length = spline.decay_length
        begin = np.maximum(last - d, 0.0)
        past = np.flatnonzero(u > begin)
        v = begin[past]
        load = float(spline.loads[-1]) * np.exp(-np.maximum(d[past] - last, 0.0) / length)
        x = (u[past] - v) / length
        if kind == "excess":
            total[past] += 0.5 * load * (v * decayed(x, 0, 1) + length * decayed(x, 1, 1))
        else:
            total[past] += 0.5 * load * (v / length * decayed(x, 0, 0) + decayed(x, 1, 0))
    return total


def _drops(spline: Spline, d: Floats, u: Floats) -> Floats:
    knots, _, curvatures, _, _, ends, _ = spline
    i = np.clip(np.searchsorted(knots, d, side="right") - 1, 0, knots.size - 2)
    ahead = knots[i + 1] - d
    first = np.clip(ahead, 0.0, u)
    total = first * (curvatures[i] * (ahead - 0.5 * first) - ends[i])
    further = np.flatnonzero(u > ahead)
    if further.size:
        total[further] += _past_piece(spline, i[further], d[further], u[further])
    return np.asarray(total)


def _past_piece(spline: Spline, i: Integers, d: Floats, u: Floats) -> Floats:
    """Return N(e) - N(d + u) [N], where d is in piece ``i`` and e < d + u is the end of it."""
    knots, slopes, curvatures, loads, _, ends, has_tail = spline
    last = knots.size - 1
    j = np.maximum(np.searchsorted(knots, d + u, side="right") - 1, i + 1)
    h = np.maximum(u - np.maximum(knots[j] - d, 0.0), 0.0)
    drops = -0.5 * np.diff(knots) * (slopes[:-1] + ends)
    end = np.append(slopes[:-1], 0.0)  # past the last knot there is the tail, or nothing
    total = h * (-end[j] - 0.5 * curvatures[j] * h)
    between = np.flatnonzero(j > i + 1)
    if between.size:
        begin, stop = i[between] + 1, j[between]
        # One or two pieces by themselves; the loads at the ends of more differ by enough.
        two = drops[begin] + np.where(stop > begin + 1, drops[np.minimum(begin + 1, last - 1)], 0.0)
        total[between] += np.where(stop > begin + 2, loads[begin] - loads[stop], two)
    if has_tail:
        length = spline.decay_length
        past = np.flatnonzero(j == last)
        load = loads[-1] * np.exp(-np.maximum(d[past] - knots[-1], 0.0) / length)
        total[past] -= load * np.expm1(-h[past] / length)
    return np.asarray(total)
