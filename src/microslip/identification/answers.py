"""Answers of a law to the motion of all records: forces, stiffness, derivatives."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from microslip._core import kernels
from microslip._core.checks import Floats
from microslip.friction.memory import Memory
from microslip.identification.caveats import Caveat
from microslip.identification.coordinates import (
    GAIN,
    RIG,
    Answer,
    Coordinate,
    behind_spring,
    stiffness_after_reversal,
)
from microslip.identification.models.base import UNKNOWN, Materials, Model
from microslip.laboratory.folding import Folded
from microslip.laboratory.motion import later

Rise = Callable[[Floats, dict[str, float], float | None], Floats]
"""Change of the backbone (rows) at displacements, values of the law and a load."""


class Group(NamedTuple):
    """Places of all records that answer with the same parameters."""

    places: slice
    columns: tuple[int, ...]
    """Coordinates of the law's parameters."""
    rig: int | None
    load: float | None


@dataclass(eq=False, repr=False)
class Answers:
    """Forces of a law and its rigs at the places of all records, by the free coordinates."""

    folded: Sequence[Folded]
    model: Model
    coordinates: Sequence[Coordinate]
    columns: Sequence[tuple[int, ...]]
    """For each record: which of the coordinates are the law's parameters."""
    rigs: Sequence[int | None]
    """For each record: which of them is its rig."""
    free_delay: bool = False
    lags: Sequence[float] = ()
    """Phases [rad] by which the force of each record is taken to lag behind."""
    summits: float | None = None
    """Number of summits, whose heights are random; None for a continuum."""
    gains: Mapping[str, float] = field(default_factory=dict)
    """Relative standard deviations of the sensors' gains, common to all cycles of all records,
    by "force", "displacement" and "normal_load"."""
    effects: tuple[str, ...] = ()
    """Names of forces beside the law, their sizes free in each record."""
    materials: Materials = UNKNOWN

    def __post_init__(self) -> None:
        folded, coordinates = self.folded, self.coordinates
        self.free = np.array([i for i, c in enumerate(coordinates) if not c.fixed], dtype=np.int64)
        self.row = {int(j): row for row, j in enumerate(self.free)}
        """Rows of the free coordinates, by their index among all."""
        self.lags = list(self.lags) or [0.0] * len(folded)
        self._gain = next((j for j, c in enumerate(coordinates) if c.parameter == GAIN), None)
        self.evaluations, self.evaluation_limit = 0, math.inf
        loads = [load if self.model.scales_with_load else None for load in self.loads]
        keys = list(zip(self.columns, self.rigs, loads, strict=True))
        # Records that answer alike lie side by side, so that one call answers for all of them.
        first: dict[tuple[object, ...], int] = {}
        for key in keys:
            first.setdefault(key, len(first))
        self.order = sorted(range(len(folded)), key=lambda i: first[keys[i]])
        self.cycles = [cycle_of(delayed(folded[i], self.lags[i])) for i in self.order]
        sizes = [cycle.half.size for cycle in self.cycles]
        starts = self.starts = np.concatenate(([0], np.cumsum(sizes))).astype(np.int64)
        begins = list(zip(self.cycles, starts[:-1], strict=True))
        self.half = np.concatenate([c.half for c in self.cycles])
        self.sign = np.concatenate([c.sign for c in self.cycles])
        self.parent = np.concatenate(
            [np.where(c.parent < 0, c.parent, c.parent + s) for c, s in begins]
        )
        self.first = np.concatenate([c.first + s for c, s in begins])
        self.second = np.concatenate([c.second + s for c, s in begins])
        bins = [folded[i].phase.size for i in self.order]
        ends = np.concatenate(([0], np.cumsum(bins))).astype(np.int64)
        self.bins = [slice(int(a), int(b)) for a, b in pairwise(ends)]
        self.groups: list[Group] = []
        for at, i in enumerate(self.order):
            places = slice(int(starts[at]), int(starts[at + 1]))
            if self.groups and keys[i] == keys[self.order[at - 1]]:
                last = self.groups.pop()
                places = slice(last.places.start, places.stop)
            self.groups.append(Group(places, *keys[i]))
        self.guess = [np.zeros(0) for _ in self.groups]
        self.forget_answers()

    def copy(self) -> Self:
        """The same, whose weights change by themselves."""
        return copy.copy(self)

    def with_coordinates(self, changes: Mapping[int, Mapping[str, Any]]) -> Self:
        """The same with changes of some coordinates, by their numbers."""
        changed = self.copy()
        changed.coordinates = tuple(
            replace(c, **changes.get(j, {})) for j, c in enumerate(self.coordinates)
        )
        return changed

    # -- coordinates ----------------------------------------------------------------------------

    @property
    def free_coordinates(self) -> list[Coordinate]:
        """Coordinates that are not fixed."""
        return [self.coordinates[j] for j in self.row]

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper bounds of the free coordinates, as they are fitted."""
        limits = [coordinate.limits for coordinate in self.free_coordinates]
        low, high = (np.array([end[k] for end in limits]) for k in (0, 1))
        return low, high

    @property
    def loads(self) -> list[float | None]:
        """Normal load of each record [N]."""
        return [record.normal_load for record in self.folded]

    def full(self, q: Floats) -> Floats:
        """Fitted coordinates with the fixed ones in their places."""
        values = np.array([c.inner(c.start) for c in self.coordinates])
        values[self.free] = q
        return values

    def physical(self, q: Floats) -> list[float]:
        """Physical values of all coordinates."""
        pairs = zip(self.coordinates, self.full(q), strict=True)
        return [c.start if c.fixed else c.outer(float(v)) for c, v in pairs]

    def values_of(self, record: int, q: Floats) -> dict[str, float]:
        """Physical values of the law's parameters for a record, by their names."""
        return self.named(self.columns[record], self.physical(q))

    def named(self, columns: tuple[int, ...], outer: Sequence[float]) -> dict[str, float]:
        """Values of the law's parameters, by their names, of those of all coordinates."""
        return {n: outer[j] for n, j in zip(self.model.names, columns, strict=True)}

    def forget_answers(self) -> None:
        """Have every group answer anew, as its displacement has changed."""
        self._answers: list[tuple[tuple[float, ...], Answer] | None] = [None] * len(self.groups)
        self._last: tuple[bytes, Floats, Floats] | None = None

    def answered(self, q: Floats) -> Iterator[tuple[Group, dict[str, float], float, Answer]]:
        """Each group with values of the law, compliance of its rig [m/N] and what it answers."""
        outer = self.physical(q)
        gain = self.gain_of(outer)
        for number, group in enumerate(self.groups):
            compliance = 0.0 if group.rig is None else 1.0 / outer[group.rig]
            values = self.named(group.columns, outer)
            key = (gain, compliance, *values.values())
            cached = self._answers[number]
            if cached is None or cached[0] != key:
                answer = self._answer(number, group, values, compliance, gain)
                cached = self._answers[number] = key, answer
            yield group, values, compliance, cached[1]

    def _answer(
        self, number: int, group: Group, values: dict[str, float], compliance: float, gain: float
    ) -> Answer:
        # The solution behind the rig is sought from the last one.
        y, guess = gain * self.half[group.places], self.guess[number]
        answer, self.guess[number] = behind_spring(
            self.model, y, values, group.load, compliance, guess
        )
        return answer

    def respond(self, q: Floats) -> tuple[Floats, Floats, Floats]:
        """Force, tangent stiffness and derivatives by the free coordinates at all places."""
        self.evaluations += 1
        row, inner = self.row, self.full(q)
        slopes = [c.slope(float(v)) for c, v in zip(self.coordinates, inner, strict=True)]
        force, stiffness = np.empty_like(self.half), np.empty_like(self.half)
        by = np.zeros((self.free.size, self.half.size))
        for group, _, _, answer in self.answered(q):
            force[group.places], stiffness[group.places], by_values, by_compliance = answer
            for j, derivative in zip(group.columns, by_values, strict=True):
                if j in row:
                    by[row[j], group.places] = slopes[j] * derivative
            if group.rig is not None and group.rig in row:
                by[row[group.rig], group.places] = slopes[group.rig] * by_compliance
        if self._gain is not None:
            by[row[self._gain]] = slopes[self._gain] * stiffness * self.half
        self._summed((force, *by))
        return force, stiffness, by

    def _summed(self, rows: Iterable[Floats]) -> None:
        """Forces along the branches of all cycles, of branch functions (rows), in their place."""
        for row in rows:
            row *= self.sign
            kernels.compiled.accumulate(self.parent, row, np.zeros(1))

    def gain_of(self, outer: Sequence[float]) -> float:
        """The true factor on the measured displacement, of the physical values of all."""
        return 1.0 if self._gain is None else outer[self._gain]

    def to_bins(self, rows: Floats) -> Floats:
        """Means over the bins of rows of answers at all places."""
        return 0.5 * (rows[..., self.first] + rows[..., self.second])

    # -- what moves the answers -----------------------------------------------------------------

    def by_change(self, q: Floats, rise: Rise) -> Floats:
        """Change of forces where the backbone does (rows) [N]; behind a rig over 1 + c T0'(v)."""
        self.evaluations += 1
        gain, parts = self.gain_of(self.physical(q)), []
        for group, values, compliance, (force, stiffness, _, _) in self.answered(q):
            v = np.maximum(gain * self.half[group.places] - compliance * force, 0.0)
            # The stiffness is that of both in series: 1/(1 + c T0') is what it lets through.
            parts.append(rise(v, values, group.load) * (1.0 - compliance * stiffness))
        rows = np.ascontiguousarray(np.hstack(parts))
        self._summed(rows)
        return np.asarray(self.to_bins(rows))

    def by_compliance(self, q: Floats) -> Floats:
        """Change of the forces in all bins by the compliance of the rig of each record."""
        by = np.zeros_like(self.half)
        for group, _, _, answer in self.answered(q):
            by[group.places] = answer[3]
        self._summed((by,))
        return self.to_bins(by)

    def by_move(self, at: int, q: Floats, stiffness: Floats, moves: Floats) -> Floats:
        """Change of the forces in the bins by moves (rows) of the displacement of a record."""
        cycle = self.cycles[at]
        above = np.where(cycle.parent < 0, 0, cycle.parent)
        local = stiffness[self.starts[at] : self.starts[at + 1]]
        rise = local * (moves - moves[:, above])
        for row in rise:
            kernels.compiled.accumulate(cycle.parent, row, np.zeros(1))
        return np.asarray(0.5 * (rise[:, cycle.first] + rise[:, cycle.second]))

    def rig_of(self, record: int, q: Floats) -> float | None:
        """Stiffness of the rig of a record [N/m]; None for a rigid one."""
        number = self.rigs[record]
        if number is None:
            return None
        stiffness = self.physical(q)[number]
        return None if math.isinf(stiffness) else stiffness

    def soft_rig(self, times: float = 1.0) -> Caveat | None:
        """The caveat that loops are ``times`` stiffer than the rig given for them."""
        for j, coordinate in enumerate(self.coordinates):
            if coordinate.parameter != RIG or not (
                coordinate.fixed or (coordinate.prior is not None and times == 1.0)
            ):
                continue
            own_records = (f for f, rig in zip(self.folded, self.rigs, strict=True) if rig == j)
            # Over half of the force noise counts little, and the rig gives way by all of it.
            stiffest = max(
                (stiffness_after_reversal(f.loop, 0.5) for f in own_records), default=0.0
            )
            if stiffest > times * coordinate.start:
                data = {"stiffness": stiffest, "rig": coordinate.name, "given": coordinate.start}
                return Caveat("soft rig", data)
        return None


# -- branches of a record, which depend on its displacement alone ---------------------------------

_COINCIDENT = 1e-7  # rad


class Cycle(NamedTuple):
    """The branch tree of a folded record, from its largest displacement on: made once."""

    half: Floats
    sign: Floats
    parent: NDArray[np.int64]
    basis: Floats
    """Terms of the displacement (rows) at each place."""
    first: NDArray[np.int64]
    """Index of the first of the two nodes of each bin."""
    second: NDArray[np.int64]


def cycle_of(folded: Folded) -> Cycle:
    """The tree of a record: two places a bin, which integrate it, and the turning points."""
    low, high = folded.phase - folded.spread, folded.phase + folded.spread
    is_wide = bool(np.any(folded.spread > 0.0))
    corners = low[0] + np.mod(folded.corners - low[0], 2.0 * math.pi)
    nodes = np.concatenate((low, high, corners) if is_wide else (low, corners))
    turns = low[0] + np.mod(_turning_points(folded) - low[0], 2.0 * math.pi)
    # One that a bin meets is not doubled: there would be a cycle of rounding's size.
    away = np.abs((turns[:, None] - nodes + math.pi) % (2.0 * math.pi) - math.pi)
    phase = np.concatenate((nodes, turns[away.min(axis=1) > _COINCIDENT]))
    order = np.argsort(phase, kind="stable")
    phase = phase[order]
    basis = folded.basis(phase)
    x = basis @ folded.coefficients
    x -= 0.5 * (float(x.min()) + float(x.max()))
    root = int(np.argmax(x))
    place = np.empty(order.size, dtype=np.int64)
    place[order] = (np.arange(order.size) - root) % order.size
    x = np.ascontiguousarray(np.roll(x, -root))
    tree = Memory().tree(x)
    count = folded.phase.size
    return Cycle(
        np.maximum(tree.half - folded.play, 0.0) if folded.play else tree.half,
        tree.sign,
        tree.parent,
        np.ascontiguousarray(np.roll(basis, -root, axis=0).T),
        place[:count],
        place[count : 2 * count] if is_wide else place[:count],
    )


def _turning_points(folded: Folded) -> Floats:
    """Phases [rad] at which the displacement turns."""
    size = max(512, 16 * int(folded.harmonics.max()))
    grid = np.linspace(0.0, 2.0 * math.pi, size + 1)
    slope = folded.displacement(grid, 1)
    at = np.flatnonzero((slope[1:] > 0.0) != (slope[:-1] > 0.0))
    low, high = grid[at], grid[at + 1]
    rising = slope[at + 1] > slope[at]
    place = 0.5 * (low + high)
    for _ in range(50):
        here, bend = folded.displacement(place, 1), folded.displacement(place, 2)
        above = (here > 0.0) == rising
        low, high = np.where(above, low, place), np.where(above, place, high)
        with np.errstate(divide="ignore", invalid="ignore"):
            step = here / bend
        new = place - step
        # Newton's step, where it stays in the bracket.
        new = np.where((new >= low) & (new <= high), new, 0.5 * (low + high))
        converged = np.abs(new - place) <= 1e-14 * math.pi
        place = new
        if converged.all():
            break
    return place


def delayed(folded: Folded, lag: float) -> Folded:
    """The record with its displacement later by a phase [rad]: the delay of its force."""
    if lag == 0.0:
        return folded
    terms, corners = later(folded.coefficients, folded.harmonics, folded.corners, lag)
    return Folded(**{**folded.__dict__, "coefficients": terms, "corners": corners})
