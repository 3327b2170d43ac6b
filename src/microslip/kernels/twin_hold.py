"""Force control in NumPy: part of :mod:`microslip.kernels.twin`."""

from __future__ import annotations

import math
from typing import Any, Protocol

from microslip.kernels.layout import Floats
from microslip.kernels.rows import push
from microslip.kernels.twin_diagram import coupled_step
from microslip.kernels.twin_profile import drop_at, load_at


class Curve(Protocol):
    """A load curve, asked one separation at a time."""

    def drop(self, base: float, width: float) -> float:
        """N(b) - N(b + w)."""

    def load(self, separation: float) -> tuple[float, float]:
        """N and -N'."""


class ProfileCurve:
    """The curve of a profile."""

    def __init__(self, *profile: Any) -> None:
        self._profile = profile

    def drop(self, base: float, width: float) -> float:
        """N(b) - N(b + w)."""
        return drop_at(base, width, *self._profile)

    def load(self, separation: float) -> tuple[float, float]:
        """N and -N'."""
        return load_at(separation, *self._profile)


def solve_front(curve: Curve, anchor: float, change: float, low: float, before: bool) -> float:
    """Separation q >= ``low`` whose load differs by ``change`` from that at ``anchor``.

    It lies before the anchor, where N is higher, or after it. Newton's method on log N, in
    brackets: log N is concave for every law but odd tables.
    """
    there, slope = curve.load(anchor)
    if not before:  # the caller's own N may be a last place above this one: all but that much slips
        change = min(change, there * (1.0 - 4.5e-16))
    target = there + change if before else there - change
    high = anchor if before else math.inf
    q = low
    if before and slope > 0.0:  # N is convex: the chord leads to what is not beyond
        q = max(low, anchor - change / slope)
    for _ in range(200):
        miss = (
            curve.drop(q, anchor - q) - change
            if before
            else change - curve.drop(anchor, q - anchor)
        )
        if miss == 0.0 or (miss < 0.0 and q == low):
            return q
        low, high = (q, high) if miss > 0.0 else (low, q)
        load, fall = target + miss, curve.load(q)[1]
        new, length = math.inf, 0.0
        if load > 0.0 and fall > 0.0 and target > 0.0:
            length = load / fall
            new = q + length * math.log1p(miss / target)
        newton = low <= new <= high and length > 0.0
        if not newton:
            new = 0.5 * (low + high) if high < math.inf else low + 2.0 * (abs(low - anchor) + 1e-30)
        step = new - q
        # The next step would be its square: below rounding.
        if newton and step * step <= 4e-17 * length * abs(new - anchor):
            return new
        if abs(step) <= 2e-16 * abs(new):
            return new
        q = new
    return q


def place_of(
    curve: Curve,
    separation: float,
    value: float,
    stack: Any,
    values: Any,
    depth: int,
    last_separation: float,
    last_place: float,
    last_value: float,
) -> float:
    """Place at which the value is the wanted one at a separation, one step from the last."""
    fall, change = last_separation - separation, value - last_value
    if fall >= 0.0:
        gain = curve.drop(separation, fall) if fall > 0.0 else 0.0
        if abs(change) <= gain:
            return last_place + (change / gain * fall if gain > 0.0 else 0.0)
        sign = 1.0 if change > 0.0 else -1.0
        begin = last_separation
    else:
        while depth and stack[depth - 1][0] <= separation:
            depth -= 1
        integral = place = 0.0
        if depth:
            end, density, beyond = (float(v) for v in stack[depth - 1])
            outer = float(values[depth - 2]) if depth > 1 else 0.0
            integral = density * curve.drop(separation, end - separation) + outer
            place = density * (end - separation) + beyond
        if value == integral:
            return place
        sign = 1.0 if value > integral else -1.0
        begin = separation
    # The front runs out to where sign N(q) and what lies beyond give the value.
    while depth:
        end, density, beyond = (float(v) for v in stack[depth - 1])
        outer = float(values[depth - 2]) if depth > 1 else 0.0
        surplus = curve.drop(separation, end - separation) + sign * (outer - value)
        if density != sign and surplus >= 0.0:
            # sign [N(separation) - N(q)] + density [N(q) - N(end)] + outer = value
            drop = surplus / (1.0 - sign * density)
            q = solve_front(curve, end, drop, max(begin, separation), True)
            return sign * (q - separation) + density * (end - q) + beyond
        begin = max(begin, end)
        depth -= 1
    q = solve_front(curve, separation, sign * value, begin, False)
    return sign * (q - separation)


def hold(
    separation: Floats,
    value: Floats,
    place: Floats,
    stack: Floats,
    values: Floats,
    depth: int,
    last_separation: float,
    last_place: float,
    last_value: float,
    *profile: Any,
) -> tuple[int, float, float, float]:
    """Places that hold values T/mu along a record, the inverse of :func:`coupled`.

    Returns the depth, and the last separation, place and value.
    """
    curve = ProfileCurve(*profile)
    for i, (d, target) in enumerate(zip(separation.tolist(), value.tolist(), strict=True)):
        x = place_of(
            curve, d, target, stack, values, depth, last_separation, last_place, last_value
        )
        remaining, front, density, kind, last_value, outer, _ = coupled_step(
            d, x, stack, values, depth, last_separation, last_place, *profile
        )
        depth = push(
            stack, values, remaining, d, front, density, kind, last_value, outer, last_place
        )
        place[i] = last_place = x
        last_separation = d
    return depth, last_separation, last_place, last_value
