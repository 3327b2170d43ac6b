"""Memory diagrams: the exact memory of a contact whose normal load varies too.

Under any history of separation d and displacement the shear of an interface is held by a function
D(eta) of the separations eta >= d, piecewise constant, |D| <= 1. With place = displacement/kappa

    T/mu = integral of D(eta) (-N'(eta)) over eta >= d,    place = integral of D(eta).

New contact that sticks takes D = move/fall; contact that is lost takes its D along; where these
do not lead to the place, slip spreads from d outwards, D = 1 or -1, until it does. This is the
superposition of Jaeger (1998), DOI 10.1115/1.2833765, and Ciavarella (1998, J. Appl. Mech. 65,
998) carried along a history, known as the method of memory diagrams (Aleshin and others 2020,
DOI 10.3389/fmech.2020.00030). Which D there is where is geometry: the surface enters once,
vectorised, with the falls of N over the rows of all diagrams, or as a profile of N(d), with which
the kernel does it all in one pass.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from microslip import kernels
from microslip._core.checks import Floats
from microslip.kernels import Integers
from microslip.kernels.profile import LOSS_RULES, Profile
from microslip.kernels.rows import push, values_along

if TYPE_CHECKING:
    from microslip.kernels.twin_hold import Curve

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

    In step ``sample`` the front runs ``ahead`` over a row of ``density``, to leave ``sign`` behind,
    while the separation goes from ``first`` to ``last`` and the front's distance from it goes from
    ``gap`` to ``until``.
    """

    sample: Integers
    ahead: Floats
    gap: Floats
    until: Floats
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
    fall: float | None  # -N' where the front goes on; None where it was not asked for


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
        diagram = Diagram()
        diagram.stack, diagram.values = self.stack.copy(), self.values.copy()
        diagram.depth, diagram.separation = self.depth, self.separation
        diagram.place, diagram.value = self.place, self.value
        return diagram

    @property
    def _last(self) -> tuple[int, float, float]:
        """Depth, separation and place, as kernels take them."""
        return self.depth, self.separation, self.place

    def respond(
        self, separation: Floats, place: Floats, drop: Drop, profile: Profile | None = None
    ) -> Floats:
        """Values T/mu at the samples (one-dimensional), after which the diagram is updated.

        A profile of the load curve, if there is one, must reach down to all separations.
        """
        if profile is not None:
            return self._respond(separation, place, profile)
        if separation.size == 1:  # in constant time, however many rows there are
            self.move(self.probe(float(separation[0]), float(place[0]), drop))
            return np.array([self.value])
        rows, stack, codes, separation_, place_ = self._walk(separation, place)
        drops = drop(rows.base, rows.width)
        tree = rows.base, rows.width, rows.density, rows.parent
        result, values = values_along(
            tree, rows.top, codes, drops, self.values[: self.depth], kernels.active.accumulate
        )
        self._store(stack, values, codes.size)
        self.separation, self.place = separation_, place_
        self.value = float(result[-1])
        return result

    def _respond(self, separation: Floats, place: Floats, profile: Profile) -> Floats:
        result = np.empty(separation.size)
        stack, values = self._reserve(separation.size)
        depth, self.separation, self.place = kernels.active.coupled(
            np.ascontiguousarray(separation), np.ascontiguousarray(place), result, stack, values,
            *self._last, *profile.arguments,
        )  # fmt: skip
        self._store(stack, values, depth)
        self.value = float(result[-1])
        return result

    def hold(self, separation: Floats, value: Floats, curve: Profile | Curve) -> Floats:
        """Places at which the values T/mu are given ones, after which the diagram is updated."""
        if not isinstance(curve, Profile):
            from microslip.kernels.twin_hold import place_of

            places = np.empty(value.size)
            for i, (d, target) in enumerate(zip(separation.tolist(), value.tolist(), strict=True)):
                place = place_of(
                    curve, d, target, self.stack, self.values, self.depth, self.separation,
                    self.place, self.value,
                )  # fmt: skip
                places[i] = place
                self.move(self._probe(d, place, curve.drop))
            return places
        result = np.empty(value.size)
        stack, values = self._reserve(value.size)
        depth, self.separation, self.place, self.value = kernels.active.hold(
            np.ascontiguousarray(separation), np.ascontiguousarray(value), result, stack, values,
            *self._last, self.value, *curve.arguments,
        )  # fmt: skip
        self._store(stack, values, depth)
        return result

    def _reserve(self, extra: int) -> tuple[Floats, Floats]:
        """A stack and its values with room for ``extra`` more rows."""
        if len(self.values) >= self.depth + extra:
            return self.stack, self.values
        # Doubling keeps one-sample chunks at amortised constant cost.
        room = max(self.depth + extra, 2 * self.depth)
        stack, values = np.empty((room, 3)), np.empty(room)
        stack[: self.depth] = self.stack[: self.depth]
        values[: self.depth] = self.values[: self.depth]
        return stack, values

    def _store(self, stack: Floats, values: Floats, depth: int) -> None:
        if len(values) > 4 * depth + 64 or len(values) < 8:
            rows, copies = np.empty((2 * depth + 8, 3)), np.empty(2 * depth + 8)
            rows[:depth], copies[:depth] = stack[:depth], values[:depth]
            stack, values = rows, copies
        self.stack, self.values, self.depth = stack, values, depth

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
            np.ascontiguousarray(separation), np.ascontiguousarray(place), base, width, density,
            parent, top, stack, codes, *self._last,
        )  # fmt: skip
        tree = Rows(base[:count], width[:count], density[:count], parent[:count], top)
        return tree, stack[:depth].copy(), codes[:depth].copy(), last_separation, last_place

    # -- one step at a time -------------------------------------------------------------------

    def probe(
        self, separation: float, place: float, drop: Drop, profile: Profile | None = None
    ) -> Step:
        """Where a step would lead; the diagram stays as it is."""
        if profile is None:
            return self._probe(
                separation, place, lambda b, w: float(drop(np.array([b]), np.array([w]))[0])
            )
        outcome = kernels.active.coupled_step(
            separation, place, self.stack, self.values, self.depth, self.separation, self.place,
            *profile.arguments,
        )  # fmt: skip
        return Step(separation, place, *outcome)

    def _probe(
        self, separation: float, place: float, drop: Callable[[float, float], float]
    ) -> Step:
        depth, front, density, kind = kernels.active.step_front(
            separation, place, self.stack, self.depth, self.separation, self.place
        )
        outer = float(self.values[depth - 1]) if depth else 0.0
        if depth and kind:  # the last row that stays is cut
            end, old, _ = self.stack[depth - 1].tolist()
            outer = float(self.values[depth - 2]) if depth > 1 else 0.0
            outer += old * drop(front, end - front)
        value = outer
        if front > separation:
            value += density * drop(separation, front - separation)
        return Step(separation, place, depth, front, density, kind, value, outer, None)

    def front(self) -> float:
        """Separation up to which the front slips as it last did; the diagram's own where none does.

        A move in the same direction goes on from there.
        """
        if self.depth and abs(self.stack[self.depth - 1, 1]) == 1.0:
            return float(self.stack[self.depth - 1, 0])
        return self.separation

    def move(self, step: Step) -> None:
        """Go along a probed step."""
        stack, values = self._reserve(1)
        depth = push(
            stack, values, step.depth, step.separation, step.front, step.density, step.kind,
            step.value, step.outer, self.place,
        )  # fmt: skip
        self._store(stack, values, depth)
        self.value = step.value
        self.separation, self.place = step.separation, step.place

    # -- slip -----------------------------------------------------------------------------------

    def slips(self, separation: Floats, place: Floats) -> Slips:
        """The runs of the slip front along a record from here on; the diagram stays as it is."""
        from microslip.kernels.twin_losses import slip_runs

        columns = slip_runs(separation, place, self.stack, self.depth, self.separation, self.place)
        return Slips(columns[0].astype(np.int64), *columns[1:])

    def losses(self, separation: Floats, place: Floats, profile: Profile) -> Floats:
        """What slip loses in each step, over mu kappa; the diagram stays as it is."""
        stack = np.empty((self.depth + separation.size, 3))
        stack[: self.depth] = self.stack[: self.depth]
        result = np.empty(separation.size)
        kernels.active.losses(
            np.ascontiguousarray(separation), np.ascontiguousarray(place), result, stack,
            *self._last, LOSS_RULES, *profile.arguments,
        )  # fmt: skip
        return result
