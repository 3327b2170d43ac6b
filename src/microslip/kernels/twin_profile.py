"""Load curves N(d) as piecewise polynomials, in NumPy: part of :mod:`microslip.kernels.twin`.

A *profile* is passed as ``coefficients, anchor, inverse_width, first``: panels of equal width, each
with ``PROFILE_TERMS`` coefficients in s, -1 <= s <= 1; panel ``first`` begins at ``anchor``, and
past the last panel N is 0. What is a difference of N or of N' is taken from divided differences, so
that no digits are lost where it is small; between panels that are not neighbours it is not small.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from microslip.kernels.layout import PROFILE_TERMS, TERMS, Floats
from microslip.kernels.twin_table import _shape, evaluate


def _value(c: Any, s: Any) -> Any:
    q = s * s
    even = c[12]
    for k in (10, 8, 6, 4, 2, 0):
        even = even * q + c[k]
    odd = c[13]
    for k in (11, 9, 7, 5, 3, 1):
        odd = odd * q + c[k]
    return odd * s + even


def _slope(c: Any, s: Any) -> Any:
    q = s * s
    even = 13 * c[13]
    for k in (11, 9, 7, 5, 3, 1):
        even = even * q + k * c[k]
    odd = 12 * c[12]
    for k in (10, 8, 6, 4, 2):
        odd = odd * q + k * c[k]
    return odd * s + even


def _first_difference(c: Any, s0: Any, s1: Any) -> Any:
    """[P(s1) - P(s0)] / (s1 - s0)."""
    q0, q1 = s0 * s0, s1 * s1
    even, odd = c[12], c[13]
    even_rise, odd_rise = 0.0 * q0, 0.0 * q0
    for k in (10, 8, 6, 4, 2, 0):
        even_rise = even_rise * q1 + even
        odd_rise = odd_rise * q1 + odd
        even = even * q0 + c[k]
        odd = odd * q0 + c[k + 1]
    return (s0 + s1) * (even_rise + s1 * odd_rise) + odd


def _second_difference(c: Any, s0: Any, s1: Any) -> Any:
    """{P(s1) - P(s0) - P'(s0) (s1 - s0)} / (s1 - s0)^2."""
    value, rise, bend = c[13], 0.0 * s0, 0.0 * s0
    for k in range(12, -1, -1):
        bend = bend * s1 + rise
        rise = rise * s0 + value
        value = value * s0 + c[k]
    return bend


def _slope_difference(c: Any, s0: Any, s1: Any) -> Any:
    """[P'(s1) - P'(s0)] / (s1 - s0)."""
    slope, rise = 13 * c[13], 0.0 * s0
    for k in range(12, 0, -1):
        rise = rise * s1 + slope
        slope = slope * s0 + k * c[k]
    return rise


class Panels:
    """The panels, found for arrays of places."""

    def __init__(self, coefficients: Floats, anchor: float, inverse_width: float, first: int):
        self.columns = np.ascontiguousarray(coefficients.reshape(-1, PROFILE_TERMS).T)
        self.count = self.columns.shape[1]
        self.anchor, self.inverse_width, self.first = anchor, inverse_width, first

    def find(self, z: Floats) -> tuple[Any, Floats]:
        """Panel (``count`` past the last) and s, of places in widths from the anchor."""
        floor = np.floor(z)
        s = 2.0 * (z - floor) - 1.0
        return np.clip(floor + self.first, 0, self.count).astype(np.int64), s

    def at(self, panel: Any) -> list[Floats]:
        """The coefficients there, one array for each."""
        return [column.take(panel, mode="clip") for column in self.columns]

    def widths(self, x: Floats) -> Floats:
        """Places in widths from the anchor."""
        return (x - self.anchor) * self.inverse_width


def loads(x: Floats, value: Floats, fall: Floats | None, *profile: Any) -> None:
    """N and, if an array is given for it, -N' at separations ``x``."""
    panels = Panels(*profile)
    panel, s = panels.find(panels.widths(x))
    c = panels.at(panel)
    inside = panel < panels.count
    value[:] = np.where(inside, _value(c, s), 0.0)
    if fall is not None:
        fall[:] = np.where(inside, -2.0 * panels.inverse_width * _slope(c, s), 0.0)


def _steps(panels: Panels, base: Floats, width: Floats) -> tuple[Any, ...]:
    """Panels and places of both ends of steps, lengths, and how many panels apart the ends are."""
    z = panels.widths(base)
    low, s0 = panels.find(z)
    high, s1 = panels.find(z + width * panels.inverse_width)
    same_panel = (low == high) & (low < panels.count)
    next_ = (high == low + 1) & (high < panels.count)
    far = ~(same_panel | next_) & (low < panels.count)
    return low, s0, high, s1, 2.0 * width * panels.inverse_width, same_panel, next_, far


def drops(base: Floats, width: Floats, drop: Floats, *profile: Any) -> None:
    """N(b) - N(b + w)."""
    panels = Panels(*profile)
    low, s0, high, s1, step, same_panel, next_, far = _steps(panels, base, width)
    c0 = panels.at(low)
    drop[:] = 0.0
    if same_panel.any():
        c = [v[same_panel] for v in c0]
        drop[same_panel] = -step[same_panel] * _first_difference(c, s0[same_panel], s1[same_panel])
    if next_.any():
        c, d = [v[next_] for v in c0], panels.at(high[next_])
        left = 1.0 - s0[next_]
        right = step[next_] - left
        unity = np.ones_like(left)
        drop[next_] = -(
            left * _first_difference(c, s0[next_], unity)
            + right * _first_difference(d, -unity, right - 1.0)
        )
    if far.any():
        end = np.where(high[far] < panels.count, _value(panels.at(high[far]), s1[far]), 0.0)
        drop[far] = _value([v[far] for v in c0], s0[far]) - end


def excesses(base: Floats, width: Floats, excess: Floats, *profile: Any) -> None:
    """N(b) - N(q) + N'(q) (q - b) with q = b + w: the integral of (v - b) N''(v) over [b, q]."""
    panels = Panels(*profile)
    low, s0, high, s1, step, same_panel, next_, far = _steps(panels, base, width)
    c0, c1 = panels.at(low), panels.at(high)
    excess[:] = 0.0
    if same_panel.any():
        c = [v[same_panel] for v in c0]
        excess[same_panel] = (
            step[same_panel]
            * step[same_panel]
            * _second_difference(c, s1[same_panel], s0[same_panel])
        )
    if next_.any():
        c, d = [v[next_] for v in c0], [v[next_] for v in c1]
        left = 1.0 - s0[next_]
        right = step[next_] - left
        end, unity = right - 1.0, np.ones_like(left)
        excess[next_] = (
            left * left * _second_difference(c, unity, s0[next_])
            + right * right * _second_difference(d, end, -unity)
            + left * right * _slope_difference(d, -unity, end)
        )
    if far.any():
        c, d = [v[far] for v in c0], [v[far] for v in c1]
        there = step[far] * _slope(d, s1[far]) - _value(d, s1[far])
        excess[far] = _value(c, s0[far]) + np.where(high[far] < panels.count, there, 0.0)


def _integral(c: Any, s: Any) -> Any:
    q = s * s
    even, odd = c[12] / 13, c[13] / 14
    for k in (10, 8, 6, 4, 2, 0):
        even = even * q + c[k] / (k + 1)
    for k in (11, 9, 7, 5, 3, 1):
        odd = odd * q + c[k] / (k + 1)
    return s * (odd * s + even)


def cycle_energies(
    base: Floats,
    width: Floats,
    energy: Floats,
    bends: Floats,
    tails: Floats,
    rule: Floats,
    *profile: Any,
) -> None:
    """Half the integral of v (u - v) N''(b + v) over the step, 0 <= v <= u = w.

    ``bends`` are the panels of P'', of ``TERMS`` coefficients each, ``tails`` the integrals of N
    from the middles of the panels to infinity, ``rule`` the nodes and then the weights of a
    quadrature on [0, 1]. At small steps the rule sums what is positive; further out the area below
    the trapezoid does not cancel.
    """
    curved = bends.reshape(-1, TERMS)

    def bend(panel: Any, s: Any) -> Any:
        return np.asarray(_shape(curved[np.minimum(panel, len(curved) - 1)].T, s))

    panels = Panels(*profile)
    z, step = panels.widths(base), width * panels.inverse_width
    low, s0 = panels.find(z)
    c = panels.at(low)
    here = _value(c, s0)
    touching = low < panels.count
    fall = _slope(c, s0)
    with np.errstate(divide="ignore", invalid="ignore"):
        # One decay length of N = (-d)^(3/2), two of an exponential, which is smoother.
        reach = here * (0.5 + 1.5 * here * bend(low, s0) / (fall * fall))
    near = touching & (-2.0 * step * fall < reach)
    energy[:] = 0.0
    if near.any():
        total = np.zeros(int(near.sum()))
        for share, weight in zip(*rule.reshape(2, -1).tolist(), strict=True):
            panel, s = panels.find(z[near] + share * step[near])
            curve = np.where(panel < panels.count, bend(panel, s), 0.0)
            total += weight * share * (1.0 - share) * curve
        energy[near] = 2.0 * width[near] * step[near] * step[near] * total
    far = touching & ~near
    if far.any():
        half = 0.5 / panels.inverse_width
        high, s1 = panels.find(z[far] + step[far])
        d, inside = panels.at(high), high < panels.count
        area = tails[low[far]] - half * _integral([v[far] for v in c], s0[far])
        tail = tails.take(high, mode="clip") - half * _integral(d, s1)
        area -= np.where(inside, tail, 0.0)
        there = np.where(inside, _value(d, s1), 0.0)
        energy[far] = 0.5 * width[far] * (here[far] + there) - area


def load_at(x: float, *profile: Any) -> tuple[float, float]:
    """N and -N' at one separation."""
    coefficients, anchor, inverse_width, first = profile
    z = (x - anchor) * inverse_width
    floor = np.floor(z)
    panel = int(floor) + first
    if panel >= coefficients.size // PROFILE_TERMS:
        return 0.0, 0.0
    c = coefficients.reshape(-1, PROFILE_TERMS)[max(panel, 0)].tolist()
    s = float(2.0 * (z - floor) - 1.0)
    return _value(c, s), -2.0 * inverse_width * _slope(c, s)


def drop_at(base: float, width: float, *profile: Any) -> float:
    """N(b) - N(b + w) once, in the order of operations of :func:`drops`."""
    coefficients, anchor, inverse_width, first = profile
    rows = coefficients.reshape(-1, PROFILE_TERMS)
    z0 = (base - anchor) * inverse_width
    z1 = z0 + width * inverse_width
    low, high = float(np.floor(z0)), float(np.floor(z1))
    s0, s1 = 2.0 * (z0 - low) - 1.0, 2.0 * (z1 - high) - 1.0
    count = len(rows)
    i = int(min(max(low + first, 0), count))
    j = int(min(max(high + first, 0), count))
    if i >= count:
        return 0.0
    c = rows[i].tolist()
    step = 2.0 * width * inverse_width
    if i == j:
        return float(-step * _first_difference(c, s0, s1))
    if j == i + 1 and j < count:
        left = 1.0 - s0
        right = step - left
        return float(
            -(
                left * _first_difference(c, s0, 1.0)
                + right * _first_difference(rows[j].tolist(), -1.0, right - 1.0)
            )
        )
    end = _value(rows[j].tolist(), s1) if j < count else 0.0
    return float(_value(c, s0) - end)


def separations(
    load: Floats,
    separation: Floats,
    coefficients: Floats,
    anchor: float,
    inverse_width: float,
    first: int,
    inverse: Floats,
    inverse_step: float,
    start: float,
) -> None:
    """Separations of loads: a table of them over log N from ``start``, and a step of Newton's."""
    panels = inverse.size // TERMS
    x = np.clip(np.log(load) - start, 0.0, np.nextafter(panels / inverse_step, 0.0))
    evaluate(x, separation, None, inverse, inverse_step, 0, 0.0, 0.0)
    there, fall = np.empty(load.size), np.empty(load.size)
    loads(separation, there, fall, coefficients, anchor, inverse_width, first)
    separation += np.divide(there - load, fall, out=np.zeros_like(load), where=fall > 0.0)
