"""The residuals of a fit, with their exact Jacobian and what the nuisances take."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip import kernels
from microslip._core.checks import Floats
from microslip.identification.coordinates import GAIN, Coordinate, Datum
from microslip.identification.cycle_branches import cycle_of, delayed
from microslip.identification.models.base import BackboneModel, CycleModel, Model
from microslip.identification.rigs import Answer, behind_spring
from microslip.identification.whitening import Metric, metric_of
from microslip.tribometer.folding import Folded
from microslip.tribometer.motion import phase_derivative

Rise = Callable[[Floats, dict[str, float], float | None], Floats]
"""Change of the backbone (rows) at displacements, values of the law and a load."""

_LOAD_STEP = 1e-4  # of the load, for differences


class Group(NamedTuple):
    """Places of all records that answer with the same parameters."""

    places: slice
    columns: tuple[int, ...]
    """Coordinates of the law's parameters."""
    rig: int | None
    load: float | None


class Problem:
    """Residuals of all records, in units of their noise, by the free coordinates.

    The force offset of each record is free; the errors of its displacement's Fourier coefficients,
    of its drift and of its load have the variances of their noise. All are linear nuisances, which
    are projected out (generalised least squares). The metric stays as it is until :meth:`update`.
    """

    def __init__(
        self,
        folded: Sequence[Folded],
        model: Model,
        coordinates: Sequence[Coordinate],
        columns: Sequence[tuple[int, ...]],
        rigs: Sequence[int | None],
        *,
        free_delay: bool = False,
        lags: Sequence[float] | None = None,
        summits: float | None = None,
        gains: Mapping[str, float] | None = None,
        effects: tuple[str, ...] = (),
        beside: Sequence[Floats] | None = None,
    ) -> None:
        self.model, self.coordinates = model, tuple(coordinates)
        self.folded, self.rigs, self.columns = tuple(folded), tuple(rigs), tuple(columns)
        self.free = np.array([i for i, c in enumerate(coordinates) if not c.fixed], dtype=np.int64)
        self.free_delay = free_delay
        self.lags = [0.0] * len(folded) if lags is None else list(lags)
        self.effects = effects
        self.beside = beside
        """Courses of forces beside the law, their sizes free in each record (bins, effects)."""
        self.summits = summits
        """Number of summits, whose heights are random; None for a continuum."""
        self.gains = dict(gains or {})
        """Relative standard deviations of the sensors' gains, common to all cycles of all records,
        by "force", "displacement" and "normal_load"."""
        places_of_gain = [j for j, c in enumerate(self.coordinates) if c.parameter == GAIN]
        self._gain = places_of_gain[0] if places_of_gain else None
        self.shared: Metric | None = None
        """Of what all records have in common and is not certain."""
        self.data: list[Datum] = []
        self.evaluations, self.evaluation_limit = 0, math.inf
        loads = [f.normal_load if model.scales_with_load else None for f in folded]
        keys = [(columns[i], rigs[i], loads[i]) for i in range(len(folded))]
        # Records that answer alike lie side by side, so that one call answers for all of them.
        first: dict[tuple[object, ...], int] = {}
        for key in keys:
            first.setdefault(key, len(first))
        self.order = sorted(range(len(folded)), key=lambda i: first[keys[i]])
        self.cycles = [cycle_of(delayed(folded[i], self.lags[i])) for i in self.order]
        sizes = [cycle.half.size for cycle in self.cycles]
        starts = np.concatenate(([0], np.cumsum(sizes))).astype(np.int64)
        self.starts = starts
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
        self.force = np.concatenate([folded[i].force for i in self.order])
        self._own_weight = np.concatenate(
            [np.sqrt(folded[i].count) / folded[i].force_noise for i in self.order]
        )
        self.weight = self._own_weight
        self.groups: list[Group] = []
        backbone = isinstance(model, BackboneModel)
        for at, i in enumerate(self.order):
            places = slice(int(starts[at]), int(starts[at + 1]))
            if self.groups and keys[i] == keys[self.order[at - 1]] and backbone:
                last = self.groups.pop()
                places = slice(last.places.start, places.stop)
            self.groups.append(Group(places, columns[i], rigs[i], loads[i]))
        self.guess = [np.zeros(0) for _ in self.groups]
        self._answers: list[tuple[tuple[float, ...], Answer] | None] = []
        self.forget_answers()
        self.metrics: list[Metric] = []
        self.forget()

    def like(self, **changes: Any) -> Problem:
        """The same problem with other arguments, and the evaluations that went before."""
        names = ("folded", "model", "coordinates", "columns", "rigs", "free_delay", "lags")
        arguments = {
            key: getattr(self, key) for key in (*names, "summits", "gains", "effects", "beside")
        }
        problem = Problem(**(arguments | changes))
        problem.data, problem.evaluations = self.data, self.evaluations
        return problem

    def copy(self) -> Problem:
        """The same problem, whose weights change by themselves."""
        problem = copy.copy(self)
        problem.metrics = list(self.metrics)
        return problem

    # -- the model ------------------------------------------------------------------------------

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
        self._answers = [None] * len(self.groups)
        self._last: tuple[bytes, Floats, Floats] | None = None

    def respond(self, q: Floats) -> tuple[Floats, Floats, Floats]:
        """Force, tangent stiffness and derivatives by the free coordinates at all places."""
        self.evaluations += 1
        inner = self.full(q)
        outer = self.physical(q)
        slopes = [c.slope(float(v)) for c, v in zip(self.coordinates, inner, strict=True)]
        row = {int(j): r for r, j in enumerate(self.free)}
        force, stiffness = np.empty_like(self.half), np.empty_like(self.half)
        by = np.zeros((self.free.size, self.half.size))
        gain = self.gain_of(outer)
        for number, group in enumerate(self.groups):
            compliance = 0.0 if group.rig is None else 1.0 / outer[group.rig]
            key = (gain, compliance, *(outer[j] for j in group.columns))
            cached = self._answers[number]
            if cached is None or cached[0] != key:
                values = self.named(group.columns, outer)
                cached = self._answers[number] = (
                    key,
                    self._answer(number, group, values, compliance, gain),
                )
            force[group.places], stiffness[group.places], by_values, by_compliance = cached[1]
            for j, derivative in zip(group.columns, by_values, strict=True):
                if j in row:
                    by[row[j], group.places] = slopes[j] * derivative
            if group.rig is not None and group.rig in row:
                by[row[group.rig], group.places] = slopes[group.rig] * by_compliance
        if self._gain is not None:
            by[row[self._gain]] = slopes[self._gain] * stiffness * self.half
        if isinstance(self.model, BackboneModel):
            for row in (force, *by):
                row *= self.sign
                kernels.compiled.accumulate(self.parent, row, np.zeros(1))
        return force, stiffness, by

    def gain_of(self, outer: Sequence[float]) -> float:
        """The true factor on the measured displacement, of the physical values of all."""
        return 1.0 if self._gain is None else outer[self._gain]

    def _answer(
        self, number: int, group: Group, values: dict[str, float], compliance: float, gain: float
    ) -> Answer:
        model = self.model
        if isinstance(model, BackboneModel):
            return self.in_series(model, number, group, values, compliance, gain)
        if isinstance(model, CycleModel):  # without Masing's rules; its rig is rigid
            at = int(np.searchsorted(self.starts, group.places.start))
            force, stiffness, by = model.cycle(self.cycles[at].displacement, values)
            return force, stiffness, by, np.zeros_like(force)
        raise TypeError(f"{type(model).__name__} must be a BackboneModel or a CycleModel")

    def in_series(
        self,
        model: BackboneModel,
        number: int,
        group: Group,
        values: dict[str, float],
        compliance: float,
        gain: float,
    ) -> Answer:
        """Branch function of the law behind a spring, from where it was last."""
        y, guess = gain * self.half[group.places], self.guess[number]
        answer, self.guess[number] = behind_spring(model, y, values, group.load, compliance, guess)
        return answer

    @property
    def parts(self) -> list[NDArray[np.int64]]:
        """Free coordinates in parts of which no record has two; one part beside data of all."""
        row = {int(j): r for r, j in enumerate(self.free)}
        if self.data or self.gains or self.summits is not None:
            return [np.arange(self.free.size)]
        label = np.arange(self.free.size)
        for column, rig in zip(self.columns, self.rigs, strict=True):
            of_record = [row[j] for j in (*column, *(() if rig is None else (rig,))) if j in row]
            if of_record:
                label[np.isin(label, label[of_record])] = label[of_record].min()
        return [np.flatnonzero(label == value) for value in np.unique(label)]

    # -- residuals ------------------------------------------------------------------------------

    def to_bins(self, rows: Floats) -> Floats:
        """Means over the bins of rows of answers at all places."""
        return 0.5 * (rows[..., self.first] + rows[..., self.second])

    def residuals(self, q: Floats) -> tuple[Floats, Floats]:
        """Whitened residuals (model minus measured) and their derivatives (residuals, free)."""
        key = q.tobytes()
        if self._last is not None and self._last[0] == key:
            return self._last[1], self._last[2]
        force, _, by = self.respond(q)
        rows = np.vstack((self.to_bins(force) - self.force, self.to_bins(by))) * self.weight
        rows = self.whitened(rows)
        extra = self._extra(q)
        rows = np.hstack((rows, extra)) if extra.size else rows
        self._last = key, rows[0], np.ascontiguousarray(rows[1:].T)
        return self._last[1], self._last[2]

    def whitened(self, rows: Floats) -> Floats:
        """Weighted rows over all bins, less what the nuisances take of them."""
        rows = rows.copy()
        for span, metric in zip(self.bins, self.metrics, strict=True):
            rows[:, span] = metric.apply(rows[:, span])
        return rows if self.shared is None else self.shared.apply(rows)

    def _extra(self, q: Floats) -> Floats:
        """Residuals of data from elsewhere, and their derivatives."""
        rows = []
        for i, j in enumerate(self.free):
            c = self.coordinates[int(j)]
            if c.prior is not None:
                outer = 1.0 / c.outer(float(q[i])) if c.kind == "inverse" else c.outer(float(q[i]))
                row = np.zeros(q.size + 1)
                row[0], row[1 + i] = outer - c.prior[0], c.slope(float(q[i]))
                rows.append(row / c.prior[1])
        for datum in self.data:
            value, gradient = datum.function(q)
            rows.append(np.concatenate(([value - datum.value], gradient)) / datum.error)
        return np.array(rows).T if rows else np.zeros((q.size + 1, 0))

    @property
    def extra_count(self) -> int:
        """Number of data from elsewhere."""
        priors = sum(self.coordinates[int(j)].prior is not None for j in self.free)
        return priors + len(self.data)

    def standardised(self, q: Floats) -> Floats:
        """Residuals over the noise of their bins, nuisances where they fit best."""
        forces = self.model_force(q)
        residual = [
            (f.force - forces[i]) * np.sqrt(f.count) / f.force_noise
            for i, f in enumerate(self.folded)
        ]
        return np.concatenate([residual[i] for i in self.order])

    def weigh(self, share: Floats) -> None:
        """Give each force a share of the weight that its noise gives it."""
        self.weight = share * self._own_weight
        self._last = None

    def take_weights(self, source: Problem) -> None:
        """Weights of a problem of the same records and bins, if they have as many."""
        if source.weight.size == self.weight.size:
            self.weight = self.weight * (source.weight / source._own_weight)
            self._last = None

    # -- nuisances ------------------------------------------------------------------------------

    def forget(self) -> None:
        """Weigh the residuals by the force's noise alone, as before any :meth:`update`."""
        flat = [self._flat(at) for at in range(len(self.bins))]
        self.metrics = [metric_of(column, np.zeros((column.shape[0], 0))) for column in flat]
        self.nuisance_effects: list[Floats] = []
        self._lost: list[Floats | None] = []
        self.shared = None
        self._last = None

    def update(self, q: Floats, share: float = 1.0, before: Sequence[Floats] = ()) -> None:
        """Weigh the residuals by the tangents of this answer: errors of the displacement act so.

        What an error of each coefficient of the displacement, and of the logarithm of a load that
        is not certain, does to the forces is kept as ``nuisance_effects``. A ``share`` below 1
        mixes them with those ``before``, so that weights which swing to and fro come to rest.
        """
        _, stiffness, _ = self.respond(q)
        self.nuisance_effects = []
        self._lost = [
            self._rise(at, q, stiffness, -self.cycles[at].sign[None])
            if self.folded[i].play_error
            else None
            for at, i in enumerate(self.order)
        ]
        uncertain = [self.has_load_error(i) for i in self.order]
        by = self._by_load(q) if any(uncertain) else np.zeros(0)
        for at, span in enumerate(self.bins):
            effects = self._rise(at, q, stiffness, self.cycles[at].basis)
            if uncertain[at]:
                effects = np.vstack((effects, by[span]))
            if before:
                effects = share * effects + (1.0 - share) * before[at]
            self.nuisance_effects.append(effects)
            self.metrics[at] = self.metric_of(at)
        self.shared = None
        if self.summits is not None or self.gains:
            common = np.vstack((self._by_summits(q), self._by_gains(q)))
            self.shared = metric_of(np.zeros((self.weight.size, 0)), common.T)
        self._last = None

    def metric_of(self, at: int, *, loads: bool = True) -> Metric:
        """The metric of a record by what was last felt; as if its load were certain, if wanted."""
        flat = self._flat(at)
        if self.free_delay:
            flat = np.hstack((flat, self.late(at)[:, None]))
        return metric_of(flat, self.nuisances_of(at, loads=loads))

    def _flat(self, at: int) -> Floats:
        """Unlimited directions in a record, weighted: its offset, and forces beside the law."""
        weight = self.weight[self.bins[at], None]
        if self.beside is None:
            return weight
        return np.hstack((weight, weight * self.beside[self.order[at]]))

    def has_load_error(self, record: int) -> bool:
        """Whether the load of a record counts and is not certain."""
        return self.model.scales_with_load and self.folded[record].load_error > 0.0

    def nuisances_of(self, at: int, *, loads: bool = True) -> Floats:
        """Effects of unit-variance nuisances on a record: displacement, drift, play and load."""
        folded, effects = self.folded[self.order[at]], self.nuisance_effects[at]
        size = folded.coefficients.size
        root = np.linalg.cholesky(folded.covariance)
        rows = [root.T @ effects[:size]]
        rows += [np.atleast_2d(part) for part in (folded.drifted, folded.stepped) if part.size]
        lost = self._lost[at] if self._lost else None
        if lost is not None:
            rows.append(lost * folded.play_error)
        if loads and effects.shape[0] > size:
            assert folded.normal_load is not None
            rows.append(effects[size:] * (folded.load_error / folded.normal_load))
        return np.asarray((np.vstack(rows) * self.weight[self.bins[at]]).T)

    def _by_load(self, q: Floats) -> Floats:
        """Change of the force in all bins by the logarithm of the load of its record [N]."""
        model = self.model
        if not isinstance(model, BackboneModel):
            return np.zeros(self.weight.size)

        def rise(v: Floats, values: dict[str, float], load: float | None) -> Floats:
            if load is None:
                return np.zeros((1, v.size))
            lower, higher = (
                model.curve(v, values, load * (1.0 + way * _LOAD_STEP))[0] for way in (-1.0, 1.0)
            )
            return ((higher - lower) / (2 * _LOAD_STEP))[None]

        return np.asarray(self._by_change(q, rise)[0])

    def _by_summits(self, q: Floats) -> Floats:
        """Whitened change of the forces by the chance in the heights of summits (rows)."""
        model, count = self.model, self.summits
        if not isinstance(model, BackboneModel) or count is None:
            return np.zeros((0, self.weight.size))
        loads = list(dict.fromkeys(group.load for group in self.groups))
        root = math.sqrt(count)

        def rise(v: Floats, values: dict[str, float], load: float | None) -> Floats:
            return model.by_summits(v, values, load, loads) / root

        rows = self._by_change(q, rise) * self.weight
        for span, metric in zip(self.bins, self.metrics, strict=True):
            rows[:, span] = metric.apply(rows[:, span])
        return np.asarray(rows)

    def _by_gains(self, q: Floats) -> Floats:
        """Whitened change of the residuals by the errors of the sensors' gains (rows)."""
        rows = np.zeros((len(self.gains), self.weight.size))
        # Of the model: the error of a measured force would go with its noise, and draw values down.
        force = self.to_bins(self.respond(q)[0])
        for row, (role, error) in zip(rows, self.gains.items(), strict=True):
            if role == "normal_load":
                row[:] = error * self._by_load(q) if self.model.scales_with_load else 0.0
                continue
            if role == "displacement" and self._gain is not None:
                continue  # not linear over its error
            for at, span in enumerate(self.bins):
                folded = self.folded[self.order[at]]
                size = folded.coefficients.size
                moved = folded.coefficients @ self.nuisance_effects[at][:size]
                row[span] = error * (force[span] if role == "force" else moved)
        rows *= self.weight
        for span, metric in zip(self.bins, self.metrics, strict=True):
            rows[:, span] = metric.apply(rows[:, span])
        return rows

    def _by_change(self, q: Floats, rise: Rise) -> Floats:
        """Change of forces where the backbone does (rows) [N]; behind a rig over 1 + c T0'(v)."""
        self.respond(q)
        outer = self.physical(q)
        gain, parts = self.gain_of(outer), []
        for number, group in enumerate(self.groups):
            values = self.named(group.columns, outer)
            compliance = 0.0 if group.rig is None else 1.0 / outer[group.rig]
            answer = self._answers[number]
            assert answer is not None
            force, stiffness = answer[1][:2]
            v = np.maximum(gain * self.half[group.places] - compliance * force, 0.0)
            # The stiffness is that of both in series: 1/(1 + c T0') is what it lets through.
            parts.append(rise(v, values, group.load) * (1.0 - compliance * stiffness))
        rows = np.ascontiguousarray(np.hstack(parts)) * self.sign
        for row in rows:
            kernels.compiled.accumulate(self.parent, row, np.zeros(1))
        return np.asarray(self.to_bins(rows))

    @property
    def log_determinant(self) -> float:
        """Of the covariance behind the weights, over that of the forces' noise: a likelihood's."""
        shares = float(np.log(self.weight / self._own_weight).sum())
        shared = 0.0 if self.shared is None else self.shared.log_determinant
        return sum(metric.log_determinant for metric in self.metrics) + shared - 2.0 * shares

    def _turned(self, at: int) -> Floats:
        """Derivative of the displacement's coefficients by a phase."""
        folded = delayed(self.folded[self.order[at]], self.lags[self.order[at]])
        return phase_derivative(folded.coefficients, folded.harmonics)

    def late(self, at: int) -> Floats:
        """Derivative of the weighted residuals by a phase lead of the displacement."""
        turned = self._turned(at)
        effects = self.nuisance_effects[at][: turned.size]
        return np.asarray(turned @ effects * self.weight[self.bins[at]])

    def lags_at(self, q: Floats) -> list[float]:
        """Phases [rad] by which the force of each record lags, as this answer would have them."""
        force, stiffness, _ = self.respond(q)
        residual = (self.force - self.to_bins(force)) * self.weight
        lags = list(self.lags)
        for at, i in enumerate(self.order):
            span = self.bins[at]
            effects = self._rise(at, q, stiffness, self._turned(at)[None] @ self.cycles[at].basis)
            flat = np.column_stack((self._flat(at), effects[0] * self.weight[span]))
            lags[i] -= float(np.linalg.lstsq(flat, residual[span], rcond=None)[0][-1])
        return lags

    def _rise(self, at: int, q: Floats, stiffness: Floats, moves: Floats) -> Floats:
        """Change of the forces in the bins by moves (rows) of the displacement of a record."""
        model, cycle = self.model, self.cycles[at]
        if isinstance(model, CycleModel):
            values = self.values_of(self.order[at], q)
            return self.to_own_bins(at, model.moved(cycle.displacement, values, moves))
        above = np.where(cycle.parent < 0, 0, cycle.parent)
        local = stiffness[self.starts[at] : self.starts[at + 1]]
        rise = local * (moves - moves[:, above])
        for row in rise:
            kernels.compiled.accumulate(cycle.parent, row, np.zeros(1))
        return self.to_own_bins(at, rise)

    def to_own_bins(self, at: int, rows: Floats) -> Floats:
        """Means over the bins of one record of rows at its own places."""
        cycle = self.cycles[at]
        return np.asarray(0.5 * (rows[:, cycle.first] + rows[:, cycle.second]))

    @property
    def flat(self) -> int:
        """Nuisances without limits: offsets, and delays that are free."""
        return len(self.folded) * (1 + self.free_delay + len(self.effects))

    # -- what users see -------------------------------------------------------------------------

    def model_force(self, q: Floats) -> list[Floats]:
        """Force of the model in the bins of each record, its nuisances where they fit best [N]."""
        force, _, _ = self.respond(q)
        residual = (self.to_bins(force) - self.force) * self.weight
        answers: list[Floats] = [np.zeros(0)] * len(self.folded)
        for at, i in enumerate(self.order):
            span, metric = self.bins[at], self.metrics[at]
            # Best linear unbiased: a nuisance of variance s^2 takes s^2/(1 + s^2) of its share.
            keep = 1.0 - (1.0 - metric.shrink) ** 2
            nuisance = metric.directions @ (keep * (metric.directions.T @ residual[span]))
            answers[i] = self.force[span] + (residual[span] - nuisance) / self.weight[span]
        return answers

    def rig_of(self, record: int, q: Floats) -> float | None:
        """Stiffness of the rig of a record [N/m]; None for a rigid one."""
        number = self.rigs[record]
        if number is None:
            return None
        stiffness = self.physical(q)[number]
        return None if math.isinf(stiffness) else stiffness
