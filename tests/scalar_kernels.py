"""What the kernels compute, said plainly: one number at a time, and nothing made quick.

Nothing is shared with the compiled loops but the layout of tables and profiles. Memories are lists,
diagrams are pieces of D(eta), a front is found by trying the ends of the pieces in turn, a slider
is dragged along in many small steps.
"""

from __future__ import annotations

import math
from typing import Any

from numpy.polynomial import polynomial

from microslip._core import kernels

Piece = tuple[float, float, float]
"""From eta, to eta, D there."""


def table_at(
    u: float, coefficients: Any, inverse_width: float, power: int, limit: float, rate: float
):
    """Value and slope of a table."""
    panels = coefficients.reshape(-1, kernels.TERMS)
    if u * inverse_width >= len(panels):
        return limit + rate * (u - len(panels) / inverse_width), rate
    panel = int(u * inverse_width)
    s = 2.0 * (u * inverse_width - panel) - 1.0
    shape = polynomial.polyval(s, panels[panel])
    grade = 2.0 * inverse_width * polynomial.polyval(s, polynomial.polyder(panels[panel]))
    slope = power * u ** (power - 1) * shape if power else 0.0
    return u**power * shape, slope + u**power * grade


class Curve:
    """The load curve of a profile."""

    def __init__(self, coefficients: Any, anchor: float, inverse_width: float, first: int) -> None:
        self.panels = coefficients.reshape(-1, kernels.PROFILE_TERMS)
        self.anchor, self.inverse_width, self.first = anchor, inverse_width, first

    def load(self, separation: float) -> tuple[float, float]:
        """N and -N'."""
        z = (separation - self.anchor) * self.inverse_width
        panel = math.floor(z) + self.first
        if panel >= len(self.panels):
            return 0.0, 0.0
        s, c = 2.0 * (z - math.floor(z)) - 1.0, self.panels[panel]
        grade = polynomial.polyval(s, polynomial.polyder(c))
        return float(polynomial.polyval(s, c)), float(-2.0 * self.inverse_width * grade)

    def drop(self, base: float, width: float) -> float:
        """N(b) - N(b + w)."""
        return self.load(base)[0] - self.load(base + width)[0]


def masing(x: list[float], backbone: Any) -> tuple[list[float], list[float], list[float]]:
    """Values along a record by Masing's rules, open reversals, amplitudes of closed loops.

    A list of turning points, taken up anew from the rules, branch by branch. Half a loop, where
    first loading goes on beyond its mirror, is a negative amplitude.
    """
    turns: list[tuple[float, float]] = []
    here, value, way = 0.0, 0.0, 0
    values: list[float] = []
    closed: list[float] = []
    for v in x:
        step = (v > here) - (v < here)
        if step and way and step != way:
            turns.append((here, value))
        if step:
            way = step
            # A small loop is closed where its own beginning is reached again: forget both ends.
            while len(turns) >= 2 and (v - turns[-2][0]) * way >= 0:
                closed.append(0.5 * abs(turns[-1][0] - turns[-2][0]))
                del turns[-2:]
            # The first loading curve is met again opposite to where it was left.
            if len(turns) == 1 and abs(v) >= abs(turns[0][0]):
                closed.append(-abs(turns[0][0]))
                turns.clear()
        if turns:
            place, start = turns[-1]
            value = start + math.copysign(2.0 * backbone(abs(v - place) / 2.0), v - place)
        else:
            value = math.copysign(backbone(abs(v)), v)
        here = v
        values.append(value)
    return values, [place for place, _ in turns], closed


def step_diagram(
    pieces: list[Piece], before: tuple[float, float], d: float, x: float
) -> list[Piece]:
    """The diagram after a straight step from (separation, place); pieces go outwards from d.

    New contact that sticks takes D = move/fall. Where that does not lead to the place, slip spreads
    from d outwards, D = 1 or -1, until it does.
    """
    fall, move = before[0] - d, x - before[1]
    if abs(move) <= fall:
        return [(d, before[0], move / fall), *pieces] if fall else pieces
    lost = [(max(low, d), high, D) for low, high, D in pieces if high > d]
    held = sum(D * (high - low) for low, high, D in lost)
    if held == x:
        return lost
    sign = 1.0 if (move > 0.0 if fall >= 0.0 else x > held) else -1.0

    def rest(q: float) -> list[Piece]:
        return [(max(low, q), high, D) for low, high, D in lost if high > q]

    def place(q: float) -> float:
        return sign * (q - d) + sum(D * (high - low) for low, high, D in rest(q))

    front = max(d, before[0]) if fall >= 0.0 else d
    for end in [high for _, high, _ in lost]:
        there = place(end)
        if sign * (there - x) >= 0.0:
            near = place(front)
            share = 0.0 if there == near else (x - near) / (there - near)
            front += share * (end - front)
            return [(d, front, sign), *rest(front)]
        front = end
    return [(d, max(front, d + sign * x), sign)]


def value_of(pieces: list[Piece], curve: Curve) -> float:
    """T/mu: the integral of D (-N')."""
    return sum(D * curve.drop(low, high - low) for low, high, D in pieces)


def coupled(d: Any, x: Any, curve: Curve) -> list[float]:
    """Values T/mu along a record from rest."""
    pieces: list[Piece] = []
    before, values = (0.0, 0.0), []
    for step, place in zip(d, x, strict=True):
        pieces = step_diagram(pieces, before, float(step), float(place))
        values.append(value_of(pieces, curve))
        before = float(step), float(place)
    return values


def drag(
    held: tuple[float, float],
    step: tuple[float, float],
    first: float,
    last: float,
    parts: int,
    stiffness: tuple[float, float, float] = (1.0, 0.0, 1.0),
) -> tuple[tuple[float, float], float]:
    """Where a slider goes along a step while its radius changes evenly, and what it loses.

    A place is the displacement times a stiffness (xx, xy, yy); slip is along what is held.
    """
    xx, xy, yy = stiffness
    x, y = held
    lost = 0.0
    for k in range(1, parts + 1):
        radius = first + (last - first) * k / parts
        x, y = x + step[0] / parts, y + step[1] / parts
        size = math.hypot(x, y)
        if size > radius:
            radius = max(radius, 0.0)
            back = xx * x * x + 2.0 * xy * x * y + yy * y * y
            slip = size * (size - radius) / back if back > 0.0 else 0.0
            lost += slip * radius * size
            x, y = x - slip * (xx * x + xy * y), y - slip * (xy * x + yy * y)
            size = math.hypot(x, y) or 1.0
            x, y = radius * x / size, radius * y / size
    return (x, y), lost
