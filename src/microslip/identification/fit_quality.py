"""Tests of a fit: cycles held back, energies, and compliances of one rig."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from microslip._core.frozen import Locked, lock
from microslip.identification.caveats import Caveat
from microslip.identification.fit import Fit
from microslip.laboratory.folding import Folded

_CERTAIN = 1e-4
_LARGE = 0.1
"""Spread of the rigs' compliances over their mean from which on they are told to be different."""
_EXPLAINED, _MOST_OF = 2.0, 0.1
"""Reduced chi-squared up to which rigs apart are all that the records want; share of the sum of
squares that they may leave to be worth a word."""


@dataclass(frozen=True, eq=False)
class RecordFit(Locked):
    """One record as it was folded, and what the law answers."""

    folded: Folded
    """Measured: displacement as a series, force in bins of the phase."""
    model: NDArray[np.float64]
    """Force [N] of the law, its offset that of the record."""
    rig_stiffness: float | None
    """Stiffness of its rig [N/m]; None for a rigid one."""
    delay: float | None
    """Time [s] by which its force was taken to lag behind; None without a time base."""
    slip_share: float
    """Share of the force limit that the cycle reaches [-], by the fall of its stiffness."""

    @property
    def phase(self) -> NDArray[np.float64]:
        """Phases of the bins [rad]."""
        return self.folded.phase

    @cached_property
    def displacement(self) -> NDArray[np.float64]:
        """Displacement [m] at the phases."""
        return lock(self.folded.displacement(self.folded.phase))

    @property
    def measured(self) -> NDArray[np.float64]:
        """Mean force [N] of each bin."""
        return self.folded.force

    @cached_property
    def residual(self) -> NDArray[np.float64]:
        """Measured minus model [N]."""
        return lock(self.folded.force - self.model)

    @cached_property
    def error(self) -> NDArray[np.float64]:
        """Standard deviation of the noise in each bin [N]."""
        return lock(self.folded.force_noise / np.sqrt(self.folded.count))

    @property
    def measured_energy(self) -> float:
        """Energy dissipated in the mean cycle [J]; white noise has no bias on it."""
        return float(self.folded.force @ self.folded.way)

    @property
    def model_energy(self) -> float:
        """Energy of the model [J]."""
        return float(self.model @ self.folded.way)

    @property
    def energy_residual(self) -> float:
        """Measured minus model over measured energy [-]."""
        measured = self.measured_energy
        return (measured - self.model_energy) / (abs(measured) or 1.0)

    @property
    def energy_error(self) -> float:
        """Standard deviation of that by the noise [-]."""
        noise = float(np.linalg.norm(self.error * self.folded.way))
        return noise / (abs(self.measured_energy) or 1.0)

    @property
    def name(self) -> str:
        """Name of the record."""
        return self.folded.name

    @property
    def normal_load(self) -> float | None:
        """Mean normal load [N]."""
        return self.folded.normal_load


def record_fits(best: Fit) -> tuple[RecordFit, ...]:
    """Each record beside the answer of the law."""
    problem, q = best.problem, best.q
    forces, shares = problem.model_force(q), slip_shares(best)
    fits = []
    for i, (folded, force) in enumerate(zip(problem.folded, forces, strict=True)):
        rate, lag = folded.frequency, problem.lags[i]
        delay = None if rate is None else lag / (2.0 * math.pi * rate)
        fits.append(RecordFit(folded, lock(force), problem.rig_of(i, q), delay, shares[i]))
    return tuple(fits)


def slip_shares(best: Fit) -> list[float]:
    """Share of the force limit that each record reaches, by the fall of the joint's stiffness."""
    problem, q = best.problem, best.q
    _, stiffness, _ = problem.respond(q)
    shares = [0.0] * len(problem.folded)
    for at, i in enumerate(problem.order):
        local = stiffness[problem.starts[at] : problem.starts[at + 1]]
        rig = problem.rig_of(i, q)
        compliance = 0.0 if rig is None else 1.0 / rig
        low, high = (float(end) for end in (local.min(), local.max()))
        compliance_ratio = max(1.0 - compliance * high, 1e-12) / max(1.0 - compliance * low, 1e-12)
        shares[i] = 1.0 - low / high * compliance_ratio if high > 0.0 else 1.0
    return shares


def _held_back_rows(cycles: int, share: float) -> NDArray[np.bool_]:
    """Cycles held back: as even as the share allows; at least one, and two stay."""
    steps = np.floor(np.arange(cycles + 1) * share + 1e-9)
    rows = np.diff(steps) > 0.0
    if not rows.any():
        rows[-1] = True
    rows[np.flatnonzero(rows)[cycles - 2 :]] = False
    return np.asarray(rows)


def held_back_error(best: Fit, share: float) -> float | None:
    """RMS error over noise with which a fit of the other cycles predicts those held back [-]."""
    problem = best.problem
    fitted_rows = [~_held_back_rows(folded.cycles, share) for folded in problem.folded]
    parts = [folded.part(rows) for folded, rows in zip(problem.folded, fitted_rows, strict=True)]
    held_problem = problem.like(folded=parts)
    held_problem.take_weights(problem)
    held_problem.update(best.q)
    fit = Fit(held_problem, best.q).settled_near()
    if fit is None:
        return None
    total, number = 0.0, 0
    for folded, rows, part, force in zip(
        problem.folded, fitted_rows, parts, held_problem.model_force(fit.q), strict=True
    ):
        full = folded.cycle_count[rows].sum(axis=0) > 0.0
        count = folded.cycle_count[~rows].sum(axis=0)[full]
        sums = folded.cycle_force[~rows].sum(axis=0)[full]
        has_samples = count > 0.0
        miss = (
            (sums[has_samples] / count[has_samples] - force[has_samples])
            * np.sqrt(count[has_samples])
            / part.force_noise
        )
        total, number = total + float(miss @ miss), number + int(miss.size)
    return math.sqrt(total / number) if number else None


def rigs_differ(best: Fit) -> Caveat | None:
    """The caveat that records of one rig want compliances of their own; None where they do not.

    First a score test: by how much the sum of squares would fall, in the linear approximation, if
    each record had its own. Where that is certain and large, a fit in which each has: a law that
    does not fit the records wants rigs that differ, too, but they do not mend it.
    """
    problem = best.problem
    stand_out = _wanted_compliances(best)
    if stand_out is None:
        return None
    label, members = stand_out
    separate = _fit_with_own_rigs(best)
    if separate is None:
        return None
    cost, compliances = separate
    reduced_apart = cost / max(problem.freedom - len(compliances) + len(set(problem.rigs)), 1)
    if reduced_apart > _EXPLAINED and cost > _MOST_OF * best.cost:
        return None
    member_compliances = np.array([compliances[i] for i in members])
    spread = (
        float(np.ptp(member_compliances) / member_compliances.mean())
        if member_compliances.mean() > 0.0
        else 0.0
    )
    # For nearly rigid rigs the share of a compliance is meaningless.
    data = {"spread": spread if 0.0 < spread < 1.0 else None, "record": label}
    return Caveat("one rig" if reduced_apart <= _EXPLAINED else "several rigs", data)


def _fit_with_own_rigs(best: Fit) -> tuple[float, dict[int, float]] | None:
    """Sum of squares and compliance [m/N] of each record where each has a rig of its own."""
    problem = best.problem
    coordinates = list(problem.coordinates)
    rigs: list[int | None] = []
    q = list(best.q)
    for i, rig in enumerate(problem.rigs):
        if rig is None or rig not in rigs:  # the first of each rig keeps it
            rigs.append(rig)
            continue
        coordinate = coordinates[rig]
        q.append(coordinate.inner(problem.physical(best.q)[rig]))
        name = f"{coordinate.name} of record {i + 1}"
        rigs.append(len(coordinates))
        coordinates.append(replace(coordinate, name=name, fixed=False, prior=None))
    separate = problem.like(coordinates=coordinates, rigs=rigs)
    separate.data = []
    separate.take_weights(problem)
    fit = Fit(separate, np.array(q))
    for _ in range(2):  # by the weights of one rig, then by their own
        separate.update(fit.q)
        near = fit.settled_near()
        if near is None:
            return None
        fit = near
    outer = separate.physical(fit.q)
    return fit.cost, {i: 1.0 / outer[rig] for i, rig in enumerate(rigs) if rig is not None}


def _wanted_compliances(best: Fit) -> tuple[str, list[int]] | None:
    """The record that stands out most and those of its rig, by the score test."""
    from scipy.special import chdtrc

    problem = best.problem
    with_rig = [i for i, rig in enumerate(problem.rigs) if rig is not None]
    if len(with_rig) < 2:
        return None
    names = list(dict.fromkeys(problem.rigs[i] for i in with_rig))
    # One record of each rig stands for what its free stiffness does already.
    free = set(problem.free.tolist())
    owners: list[int] = []
    for rig in names:
        members = [i for i in with_rig if problem.rigs[i] == rig]
        if len(members) > 1:
            owners += members[1:] if rig in free else members
    if not owners:
        return None
    by = problem.by_compliance(best.q) * problem.weight
    rows = np.zeros((len(owners), by.size))
    for row, owner in zip(rows, owners, strict=True):
        span = problem.bins[problem.order.index(owner)]
        row[span] = by[span]
    found = best.score(rows)
    if chdtrc(len(owners), found.fall / max(best.reduced, 1.0)) > _CERTAIN:
        return None
    change = np.zeros(len(problem.folded))
    change[owners] = found.sizes
    worst, label, worst_members = 0.0, "", list[int]()
    for rig in names:
        members = [i for i in with_rig if problem.rigs[i] == rig]
        coordinate = problem.coordinates[rig] if rig is not None else None
        if coordinate is None or len(members) < 2:
            continue
        compliance = 1.0 / max(problem.physical(best.q)[rig], 1e-300)  # type: ignore[index]
        # A nearly rigid rig has no compliance that could be compared.
        share = float(np.ptp(change[members])) / max(compliance, 1e-3 / coordinate.scale)
        if share > worst:
            worst, worst_members = share, members
            # The first record of a free rig stands still in the score, so it may be the odd one.
            middle = float(np.median(change[members]))
            far = max(reversed(members), key=lambda i: abs(change[i] - middle))
            label = problem.folded[far].name
    if worst < _LARGE:
        return None
    return label, worst_members


def misfit(records: Sequence[RecordFit], reduced: float) -> Caveat:
    """The caveat that the residual of a law exceeds the noise."""
    residual_square = sum(float(record.residual @ record.residual) for record in records)
    force_square = sum(
        float(np.square(record.measured - record.measured.mean()).sum()) for record in records
    )
    share = math.sqrt(residual_square / force_square) if force_square > 0.0 else math.inf
    return Caveat("misfit", {"over_noise": math.sqrt(reduced), "share": share})
