"""Memory diagrams: the exact memory of a contact whose normal load varies too.

Under any history of separation d and displacement the shear of an interface is held by a function
D(eta) of the separations eta >= d, piecewise constant, |D| <= 1. With place = displacement/kappa

    T/mu = integral of D(eta) (-N'(eta)) over eta >= d,    place = integral of D(eta).

New contact that sticks takes D = move/fall; contact that is lost takes its D along; where these
do not lead to the place, slip spreads from d outwards, D = 1 or -1, until it does. This is the
superposition of Jaeger (1998), DOI 10.1115/1.2833765, and Ciavarella (1998, J. Appl. Mech. 65,
998) carried along a history, known as the method of memory diagrams (Aleshin and others 2020,
DOI 10.3389/fmech.2020.00030). Which D there is where is geometry: the surface enters once,
vectorised, with the falls of N over the rows of all diagrams.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from microslip import kernels
from microslip._checks import Floats
from microslip.kernels import Integers, twin

Drop = Callable[[Floats, Floats], Floats]
"""N(b) - N(b + w) for separations b and widths w."""


class Rows(NamedTuple):
    """The rows of the diagrams of a record, a tree: each lies before its parent.

    ``parent`` is the index of a row, -1 for none, or -2 - k for row k of the diagram before the
    record; ``top[j]`` is the row at the front of sample j, -1 where D is nowhere but 0.
    """

    base: Floats
    width: Floats
    density: Floats
    parent: Integers
    top: Integers


class Slips(NamedTuple):
    """Runs of the slip front over rows of a diagram, in the order of time.

    In step ``sample`` the front runs from ``start`` to ``end`` over a row of ``density``, to leave
    ``sign`` behind, while the separation goes from ``first`` to ``last``.
    """

    sample: Integers
    start: Floats
    end: Floats
    density: Floats
    sign: Floats
    first: Floats
    last: Floats


class Step(NamedTuple):
    """A trial step: the rows that stay, where the last begins, and what fills the rest."""

    separation: float
    place: float
    depth: int
    front: float
    density: float
    kind: int
    value: float
    outer: float  # share of the value that the rows which stay hold


class Diagram:
    """Rows of the diagram, outermost first, with the last separation, place and value T/mu.

    Separations are counted from the one at the start, so that no digits are lost where the load
    does not vary. What is stored grows with the rows only: those of open loops, and one for each
    step of new contact that has not slipped since.
    """

    __slots__ = ("depth", "place", "separation", "stack", "value", "values")

    def __init__(self) -> None:
        self.stack = np.empty((8, 3))  # end, density, integral of D beyond the end
        self.values = np.empty(8)  # integral of D (-N') from where the row begins
        self.depth = 0
        self.separation = 0.0
        self.place = 0.0
        self.value = 0.0

    def copy(self) -> Diagram:
        """An independent diagram with the same content."""
        other = Diagram()
        other.stack, other.values = self.stack.copy(), self.values.copy()
        other.depth, other.separation = self.depth, self.separation
        other.place, other.value = self.place, self.value
        return other

    def respond(self, separation: Floats, place: Floats, drop: Drop) -> Floats:
        """Values T/mu at the samples (one-dimensional), after which the diagram is updated."""
        rows, stack, codes, separation_, place_ = self._walk(separation, place)
        values = rows.density * drop(rows.base, rows.width)
        before = self.values[: max(self.depth, 1)]
        kernels.active.accumulate(rows.parent, values, before)
        whole = np.append(values, 0.0)  # so that -1 is the empty diagram
        old = np.where(codes < 0, -2 - codes, 0)
        self.values = np.where(codes >= 0, whole[np.maximum(codes, 0)], self.values[old])
        self.stack, self.depth = stack, codes.size
        self.separation, self.place = separation_, place_
        at_start = before[-2 - np.minimum(rows.top, -2)]
        result = np.where(rows.top >= -1, whole[np.maximum(rows.top, -1)], at_start)
        self.value = float(result[-1])
        if not self.depth:
            self.stack, self.values = np.empty((8, 3)), np.empty(8)
        return result

    def rows(self, separation: Floats, place: Floats) -> Rows:
        """The rows of a record from here on; the diagram stays as it is."""
        return self._walk(separation, place)[0]

    def _walk(
        self, separation: Floats, place: Floats
    ) -> tuple[Rows, Floats, Integers, float, float]:
        n = separation.size
        stack = np.empty((self.depth + n, 3))
        stack[: self.depth] = self.stack[: self.depth]
        codes = np.empty(self.depth + n, dtype=np.int64)
        codes[: self.depth] = -2 - np.arange(self.depth)
        base, width, density = np.empty(2 * n), np.empty(2 * n), np.empty(2 * n)
        parent, top = np.empty(2 * n, dtype=np.int64), np.empty(n, dtype=np.int64)
        depth, count, last_separation, last_place = kernels.active.diagram(
            np.ascontiguousarray(separation),
            np.ascontiguousarray(place),
            base,
            width,
            density,
            parent,
            top,
            stack,
            codes,
            self.depth,
            self.separation,
            self.place,
        )
        tree = Rows(base[:count], width[:count], density[:count], parent[:count], top)
        return tree, stack[:depth].copy(), codes[:depth].copy(), last_separation, last_place

    def front(self) -> float:
        """Separation up to which the front slips as it last did; the diagram's own where none does.

        A move in the same direction goes on from there.
        """
        if self.depth and abs(self.stack[self.depth - 1, 1]) == 1.0:
            return float(self.stack[self.depth - 1, 0])
        return self.separation

    # -- one step at a time -------------------------------------------------------------------

    def probe(self, separation: float, place: float, drop: Drop) -> Step:
        """Where a step would lead; the diagram stays as it is."""
        depth, front, density, kind = kernels.active.step_front(
            separation, place, self.stack, self.depth, self.separation, self.place
        )
        base, width, share = [separation], [front - separation], [density]
        outer = float(self.values[depth - 1]) if depth else 0.0
        if depth and kind:  # the last row that stays is cut
            end, old, _ = self.stack[depth - 1].tolist()
            base.append(front)
            width.append(end - front)
            share.append(old)
            outer = float(self.values[depth - 2]) if depth > 1 else 0.0
        falls = np.array(share) * drop(np.array(base), np.array(width))
        outer += float(falls[1:].sum())
        return Step(separation, place, depth, front, density, kind, outer + float(falls[0]), outer)

    def move(self, step: Step) -> None:
        """Go along a probed step."""
        depth, front = step.depth, step.front
        beyond = 0.0
        if depth:
            end, density, rest = self.stack[depth - 1].tolist()
            beyond = density * (end - front) + rest
            self.values[depth - 1] = step.outer
        if front > step.separation:
            if depth == len(self.values):
                self.stack = np.concatenate((self.stack, np.empty((depth + 8, 3))))
                self.values = np.concatenate((self.values, np.empty(depth + 8)))
            self.stack[depth] = front, step.density, self.place if step.kind == 0 else beyond
            self.values[depth] = step.value
            depth += 1
        self.depth, self.value = depth, step.value
        self.separation, self.place = step.separation, step.place

    # -- slip -----------------------------------------------------------------------------------

    def slips(self, separation: Floats, place: Floats) -> Slips:
        """The runs of the slip front along a record from here on; the diagram stays as it is."""
        stack = [tuple(row) for row in self.stack[: self.depth].tolist()]
        d0, x0 = self.separation, self.place
        runs: list[Run] = []
        for j, (d, x) in enumerate(zip(separation.tolist(), place.tolist(), strict=True)):
            depth, front, density, kind = twin.step_front(d, x, stack, len(stack), d0, x0)
            if kind:
                runs += [(j, *run) for run in _runs(stack, d0, d, x - x0)]
            beyond = x0
            if kind and depth:
                end, old, rest = stack[depth - 1]
                beyond = old * (end - front) + rest
            elif kind:
                beyond = 0.0
            del stack[depth:]
            if front > d:
                stack.append((front, density, beyond))
            d0, x0 = d, x
        columns = np.array(runs, dtype=float).reshape(-1, 7).T
        return Slips(columns[0].astype(np.int64), *columns[1:])


Run = tuple[int, float, float, float, float, float, float]


def _runs(
    stack: list[tuple[float, float, float]], first: float, last: float, move: float
) -> Iterator[tuple[float, float, float, float, float, float]]:
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
