"""The residuals of a fit, with their exact Jacobian and the part that nuisances remove."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats, show
from microslip._core.errors import InputError
from microslip.identification.answers import Answers, delayed
from microslip.identification.coordinates import Datum, Quantity
from microslip.identification.options import NUISANCES
from microslip.laboratory.folding import Folded
from microslip.laboratory.motion import phase_derivative

_LOAD_STEP = 1e-4  # of the load, for differences


class Problem(Answers):
    """Residuals of all records, in units of their noise, by the free coordinates.

    The force offset of each record is free; the errors of its displacement's Fourier coefficients,
    of its drift and of its load have the variances of their noise. All are linear nuisances, which
    are projected out (generalised least squares). The metric stays as it is until :meth:`update`.
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        self.beside = [columns_of(record, self.effects) for record in self.folded]
        """Courses of the forces beside the law (bins, effects)."""
        self.shared: Metric | None = None
        """Metric of the uncertain data that all records share."""
        self.quantities: list[Quantity] = []
        """Derived quantities."""
        self.data: list[Datum] = []
        """Data on the parameters or on these from elsewhere."""
        records = [self.folded[i] for i in self.order]
        self.force = np.concatenate([record.force for record in records])
        self._own_weight = np.concatenate([np.sqrt(r.count) / r.force_noise for r in records])
        self.weight = self._own_weight
        self.metrics: list[Metric] = []
        self.forget()

    def like(self, **changes: Any) -> Self:
        """The same problem with other arguments, and the evaluations that went before."""
        problem = replace(self, **changes)
        problem.data, problem.quantities = self.data, self.quantities
        problem.evaluations = self.evaluations
        return problem

    def copy(self) -> Self:
        """The same problem, whose weights change by themselves."""
        problem = super().copy()
        problem.metrics, problem._last = list(self.metrics), None
        return problem

    @property
    def freedom(self) -> int:
        """Number of forces and data less what is fitted."""
        return self.count - self.flat - self.free.size

    @property
    def count(self) -> int:
        """Number of forces and data."""
        priors = sum(coordinate.prior is not None for coordinate in self.free_coordinates)
        return self.weight.size + priors + len(self.data)

    @property
    def parts(self) -> list[NDArray[np.int64]]:
        """Free coordinates in parts of which no record has two; one part beside data of all."""
        row = self.row
        if self.data or self.gains or self.summits is not None:
            return [np.arange(self.free.size)]
        label = np.arange(self.free.size)
        for column, rig in zip(self.columns, self.rigs, strict=True):
            of_record = [row[j] for j in (*column, *(() if rig is None else (rig,))) if j in row]
            if of_record:
                label[np.isin(label, label[of_record])] = label[of_record].min()
        return [np.flatnonzero(label == value) for value in np.unique(label)]

    # -- residuals ------------------------------------------------------------------------------

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
        rows = self.in_metrics(rows)
        return rows if self.shared is None else self.shared.apply(rows)

    def in_metrics(self, rows: Floats) -> Floats:
        """The same by the nuisances of each record alone."""
        rows = rows.copy()
        for span, metric in zip(self.bins, self.metrics, strict=True):
            rows[:, span] = metric.apply(rows[:, span])
        return rows

    def _extra(self, q: Floats) -> Floats:
        """Residuals of data from elsewhere, and their derivatives."""
        rows = []
        for i, c in enumerate(self.free_coordinates):
            if c.prior is not None:
                outer = 1.0 / c.outer(float(q[i])) if c.kind == "inverse" else c.outer(float(q[i]))
                row = np.zeros(q.size + 1)
                row[0], row[1 + i] = outer - c.prior[0], c.slope(float(q[i]))
                rows.append(row / c.prior[1])
        for datum in self.data:
            value, gradient = datum.function(q)
            rows.append(np.concatenate(([value - datum.value], gradient)) / datum.error)
        return np.array(rows).T if rows else np.zeros((q.size + 1, 0))

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
            self.by_move(at, q, stiffness, -self.cycles[at].sign[None])
            if self.folded[i].play_error
            else None
            for at, i in enumerate(self.order)
        ]
        uncertain = [self.has_load_error(i) for i in self.order]
        by = self._by_load(q) if any(uncertain) else np.zeros(0)
        for at, span in enumerate(self.bins):
            effects = self.by_move(at, q, stiffness, self.cycles[at].basis)
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

        def rise(v: Floats, values: dict[str, float], load: float | None) -> Floats:
            if load is None:
                return np.zeros((1, v.size))
            lower, higher = (
                model.curve(v, values, load * (1.0 + way * _LOAD_STEP))[0] for way in (-1.0, 1.0)
            )
            return ((higher - lower) / (2 * _LOAD_STEP))[None]

        return np.asarray(self.by_change(q, rise)[0])

    def _by_summits(self, q: Floats) -> Floats:
        """Whitened change of the forces by the chance in the heights of summits (rows)."""
        model, count = self.model, self.summits
        if count is None:
            return np.zeros((0, self.weight.size))
        loads = list(dict.fromkeys(group.load for group in self.groups))
        root = math.sqrt(count)

        def rise(v: Floats, values: dict[str, float], load: float | None) -> Floats:
            return model.by_summits(v, values, load, loads) / root

        return self.in_metrics(self.by_change(q, rise) * self.weight)

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
        return self.in_metrics(rows * self.weight)

    @property
    def log_determinant(self) -> float:
        """Log-determinant of the covariance behind the weights, over that of the forces' noise."""
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
            effects = self.by_move(at, q, stiffness, self._turned(at)[None] @ self.cycles[at].basis)
            flat = np.column_stack((self._flat(at), effects[0] * self.weight[span]))
            lags[i] -= float(np.linalg.lstsq(flat, residual[span], rcond=None)[0][-1])
        return lags

    @property
    def flat(self) -> int:
        """Nuisances without limits: offsets, and delays that are free."""
        return len(self.folded) * (1 + self.free_delay + len(self.effects))

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


# -- forces beside the law ------------------------------------------------------------------------


class Effect(NamedTuple):
    """A force beside that of the law, of unknown size in each record."""

    words: str
    shape: Callable[[Folded], Floats]
    """Its course over the bins of a record, of any size."""


def _centred(values: Floats) -> Floats:
    return np.asarray(values - 0.5 * (values.max() + values.min()))


EFFECTS: Mapping[str, Effect] = {
    "parallel": Effect("a spring beside the joint", lambda f: _centred(f.displacement(f.phase))),
    "viscous": Effect("a force proportional to velocity", lambda f: f.displacement(f.phase, 1)),
    "inertia": Effect("a mass behind the force sensor", lambda f: f.displacement(f.phase, 2)),
    "tilt": Effect(
        "friction that changes along the displacement, as of tilted faces (to first order)",
        lambda f: np.asarray(_centred(f.force) * _centred(f.displacement(f.phase))),
    ),
}
"""Forces that may be asked for, by name."""


def checked_effects(names: Sequence[str] | None) -> tuple[str, ...]:
    """The names of effects that were asked for."""
    if names is None:
        return ()
    if isinstance(names, str) or not isinstance(names, Sequence):
        raise InputError(f"`nuisances` must be a list of {', '.join(NUISANCES)}, got {show(names)}")
    for name in names:
        if name not in NUISANCES:
            raise InputError(f"`nuisances` must be among {', '.join(NUISANCES)}, got {show(name)}")
    return tuple(dict.fromkeys(names))


def columns_of(folded: Folded, names: Sequence[str]) -> Floats:
    """Courses of the effects in a record, a column each of the norm 1."""
    columns = []
    for name in names:
        column = EFFECTS[name].shape(folded)
        size = float(np.linalg.norm(column))
        columns.append(column / (size or 1.0))
    return np.array(columns).T.reshape(folded.phase.size, len(names))


# -- weights without what nuisances take ----------------------------------------------------------

_SMALL = 0.02  # of the noise: a nuisance that moves the answer less is left where it is


@dataclass(frozen=True, eq=False)
class Metric:
    """Weights of the residuals of a record once its nuisances are taken out."""

    directions: Floats
    shrink: Floats

    def apply(self, rows: Floats) -> Floats:
        """Rows (..., bins) of weighted residuals or derivatives, whitened."""
        return rows - ((rows @ self.directions) * self.shrink) @ self.directions.T

    @property
    def log_determinant(self) -> float:
        """Log-determinant of the covariance, over that of the force's noise alone."""
        limited = self.shrink[self.shrink < 1.0]
        return float(-2.0 * np.log1p(-limited).sum())


def metric_of(flat: Floats, uncertain: Floats) -> Metric:
    """The metric of nuisances without limits and of variance 1 (bins, nuisances)."""
    basis, _ = np.linalg.qr(flat)
    uncertain = uncertain - basis @ (basis.T @ uncertain)
    square, turned = np.linalg.eigh(uncertain.T @ uncertain)
    matters = square > _SMALL**2
    basis_uncertain = (uncertain @ turned[:, matters]) / np.sqrt(square[matters])
    shrink = 1.0 - 1.0 / np.sqrt(1.0 + square[matters])
    return Metric(
        np.hstack((basis, basis_uncertain)), np.concatenate((np.ones(basis.shape[1]), shrink))
    )
