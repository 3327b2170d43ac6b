"""Test of Masing's rules; causes of a misfit by their patterns (signatures) in the residual."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag
from scipy.special import chdtri

from microslip._core.checks import Floats
from microslip._core.frozen import Locked
from microslip._core.units import significant
from microslip.identification.free_form import FreeForm
from microslip.identification.loads import backbone_of, stiffness_of
from microslip.identification.nonnegative import cone_of, minimum
from microslip.identification.rows import DesignRows
from microslip.laboratory.motion import phase_derivative

NAMED = 0.9
"""Fraction of the misfit that a signature must remove for its cause to be named."""
UNDETERMINED = "not determined"
_TIE = 12.0
"""Difference of sums of squares below which two signatures describe the misfit equally well."""
_ROUNDS, _LESS = 4, 0.9
"""Largest number of rounds in which signature and density are computed in turn, and the ratio of
successive sums of squares above which the rounds end."""
_NEAR_ZERO, _LEAST = 0.1, 0.005
"""Force over its amplitude beside a clearance, and smallest clearance over the displacement."""
_TAIL = 0.005
"""Probability on each side of the interval of chi-squared."""


@dataclass(frozen=True)
class Masing(Locked):
    """Test of Masing's rules: whether the residual of the free-form fit is noise."""

    reduced_chi_squared: float
    """Sum of squares over degrees of freedom [-]."""
    low: float
    high: float
    """Ends of the 99 % interval of reduced chi-squared for noise alone [-]."""
    even: float
    """Fraction of the residual that is equal in both half cycles [-]; NaN if no loop is whole."""
    odd: float
    """Fraction of the residual that changes its sign in the other half cycle [-]."""
    cause: str
    """Cause of the misfit, several joined by "or" if they describe it equally well; "not
    determined", or empty where the residual is noise."""
    removed: Mapping[str, float]
    """Fraction of the misfit that each signature removes [-]; empty where the residual is noise."""

    @property
    def holds(self) -> bool:
        """Whether the residual is no larger than noise, so that the loops obey Masing's rules."""
        return self.reduced_chi_squared <= self.high

    @property
    def text(self) -> str:
        """Result of the test as a sentence for the user."""
        value = significant(self.reduced_chi_squared, 3)
        limit = significant(self.high, 3)
        size = f"reduced chi-squared is {value}, with noise alone at most {limit}"
        if self.holds:
            return f"the loops obey Masing's rules within noise: {size}"
        words = f"the loops do not obey Masing's rules: {size}"
        if not math.isnan(self.even):
            half = "even" if self.even > 0.5 else "odd"
            share = f"{100.0 * max(self.even, self.odd):.0f} %"
            words += f"; the residual is {half} in the two half cycles ({share})"
        if self.cause == UNDETERMINED:
            return f"{words}; detected, cause not determined"
        removed = 100.0 * max(self.removed.values())
        return f"{words}; with {self.cause}, the misfit is {removed:.0f} % smaller"


def _centred(values: Floats) -> Floats:
    return np.asarray(values - 0.5 * (values.max() + values.min()))


def _delay(fit: FreeForm, rows: DesignRows, size: float) -> Floats:
    cycle = rows.cycle
    moves = phase_derivative(rows.folded.motion) @ cycle.basis
    above = np.where(cycle.parent < 0, 0, cycle.parent)
    y = fit.y + fit.shifts[fit.level[rows.load]]
    return rows.sums((stiffness_of(y, fit.k, rows.cycle.half) * (moves - moves[above]))[:, None])


def _clearance(fit: FreeForm, rows: DesignRows, size: float) -> Floats:
    """Return the change of force per metre of clearance [N/m] (bins, 1).

    It is evaluated at a clearance of ``size`` [m]. While the force is zero, the displacement runs
    free over twice the clearance. The middle of this range is midway between the displacements at
    which the force is plus and minus _NEAR_ZERO times its amplitude.
    """
    cycle, phase, size = rows.cycle, rows.folded.phase, max(size, _LEAST * rows.amplitude)
    force = _centred(rows.folded.force)
    force = force / (_NEAR_ZERO * force.max())
    beyond = np.flatnonzero(np.abs(force) > 1.0)
    changes = force[beyond] * force[np.roll(beyond, -1)] < 0.0
    places = []
    for at, step in ((beyond[changes], 1), (np.roll(beyond, -1)[changes], -1)):
        inner = (at + step) % force.size
        way = (phase[inner] - phase[at] + math.pi) % (2.0 * math.pi) - math.pi
        places.append(
            phase[at] + way * (force[at] - np.sign(force[at])) / (force[at] - force[inner])
        )
    middle = places[0] + 0.5 * ((places[1] - places[0]) % (2.0 * math.pi))
    centre = 0.5 * (rows.folded.displacement(places[0]) + rows.folded.displacement(places[1]))
    away = np.abs((cycle.phase[:, None] - middle + math.pi) % (2.0 * math.pi) - math.pi)
    lost = cycle.basis.T @ rows.folded.motion.coefficients - centre[away.argmin(axis=1)]
    lost = np.clip(lost, -size, size)
    above = np.where(cycle.parent < 0, 0, cycle.parent)
    return _shortened(fit, rows, 0.5 * np.abs(lost - lost[above]), size)


def _lost_motion(fit: FreeForm, rows: DesignRows, size: float) -> Floats:
    """Return the change of force per metre of lost motion [N/m] (bins, 1), about ``size`` [m].

    The joint rests over twice the lost motion after each reversal.
    """
    if size > 0.0:
        return _shortened(fit, rows, np.full(rows.cycle.half.size, size), size)
    y = fit.y + fit.shifts[fit.level[rows.load]]
    return rows.sums((-stiffness_of(y, fit.k, rows.cycle.half) * rows.cycle.sign)[:, None])


def _shortened(fit: FreeForm, rows: DesignRows, lost: Floats, size: float) -> Floats:
    """Return the change of force over ``size`` [N/m] if ``lost`` [m] shortens ``cycle.half``."""
    y, cycle = fit.thresholds(fit.level[rows.load]), rows.cycle
    less = np.maximum(cycle.half - lost, 0.0)
    rise = backbone_of(y, fit.k, less) - backbone_of(y, fit.k, cycle.half)
    return rows.sums((rise / size * cycle.sign)[:, None])


def _twice(fit: FreeForm, rows: DesignRows, size: float) -> Floats:
    force, phase = _centred(rows.folded.force), rows.folded.phase
    return np.column_stack((force * np.cos(2.0 * phase), force * np.sin(2.0 * phase)))


Signature = Callable[[FreeForm, DesignRows, float], Floats]
"""Function that returns the columns of a disturbance for a fit and a record, about a given size."""


def _of(shape: Callable[[DesignRows], Floats]) -> Signature:
    return lambda fit, rows, size: np.asarray(shape(rows))[:, None]


SIGNATURES: Mapping[str, Signature] = {
    "a delay of the force": _delay,
    "a viscous force": _of(lambda r: r.folded.displacement(r.folded.phase, 1)),
    "inertia": _of(lambda r: r.folded.displacement(r.folded.phase, 2)),
    "a parallel spring": _of(lambda r: r.folded.displacement(r.folded.phase)),
    "clearance at zero force": _clearance,
    "lost motion at reversals": _lost_motion,
    "tilted faces": _of(
        lambda r: _centred(r.folded.force) * _centred(r.folded.displacement(r.folded.phase))
    ),
    "friction that differs between the directions": _of(lambda r: np.abs(_centred(r.folded.force))),
    "a normal load at twice the frequency": _twice,
    "drift within the cycle": _of(lambda r: r.folded.phase - math.pi),
}
"""Changes of the force in the bins of a record by causes that break Masing's rules."""


def _with_columns(fit: FreeForm, signature: Signature) -> float:
    """Return the sum of squared residuals of a fit that includes a disturbance of each record.

    Some columns of a ``signature`` depend on the size of the disturbance and on the density of
    sliders, so they are computed again after each iteration.
    """
    current, least, sizes = fit, math.inf, [0.0] * len(fit.rows)
    for _ in range(_ROUNDS):
        parts = [
            rows.whitened(signature(current, rows, size))
            for rows, size in zip(fit.rows, sizes, strict=True)
        ]
        extra = block_diag(*parts)
        norm = np.linalg.norm(extra, axis=0)
        extra /= np.where(norm > 0.0, norm, 1.0)
        design = np.hstack((fit.design, extra))
        free = np.append(fit.free, np.ones(extra.shape[1], dtype=bool))
        gram = design.T @ design
        empty = np.diag(gram) == 0.0
        gram[empty, empty] = 1.0
        cone = cone_of(gram, free)
        start = np.append(fit.g, np.zeros(extra.shape[1]))
        h = cone.gram @ start + design.T @ fit.residual
        g = minimum(cone, h, start > 0.0)
        rest = fit.measured - design @ g
        before, least = least, min(least, float(rest @ rest))
        if least > _LESS * before:
            break
        current = copy(fit)
        current.k = g[: fit.y.size] / fit.scale[: fit.y.size]
        found = g[fit.g.size :] / np.where(norm > 0.0, norm, math.inf)
        sizes = [float(one[0]) for one in np.split(found, len(fit.rows))]
    return least


def _even(fits: Sequence[FreeForm]) -> float:
    """Return the fraction of the residual's power [-] that repeats every half cycle.

    It is NaN if no loop is whole.
    """
    even = total = 0.0
    for fit in fits:
        for rows in fit.rows:
            if rows.folded.completed.size:  # one half is made from the other
                continue
            residual = rows.folded.force - fit.force_of(rows)
            residual = residual - np.average(residual, weights=rows.folded.count)
            other = np.interp(
                rows.folded.phase + math.pi, rows.folded.phase, residual, period=2.0 * math.pi
            )
            even += float(np.sum((0.5 * (residual + other) * rows.weight) ** 2))
            total += float(np.sum((0.5 * (residual - other) * rows.weight) ** 2))
    total += even
    return even / total if total > 0.0 else math.nan


def masing_of(fits: Sequence[FreeForm]) -> Masing:
    """Return the test of Masing's rules for fits, with possible causes if it fails."""
    chi = sum(fit.chi_squared for fit in fits)
    freedom = sum(fit.freedom for fit in fits)
    low, high = (float(chdtri(freedom, p)) / freedom for p in (1.0 - _TAIL, _TAIL))
    even = _even(fits)
    removed: dict[str, float] = {}
    cause = ""
    if chi / freedom > high:
        misfit = chi - freedom
        left = {
            name: sum(_with_columns(fit, signature) for fit in fits)
            for name, signature in SIGNATURES.items()
        }
        removed = {name: min(max((chi - one) / misfit, 0.0), 1.0) for name, one in left.items()}
        least = min(left.values())
        # Signatures that leave as little as the best one, within noise, tie with it.
        ties = [
            name
            for name, one in left.items()
            if removed[name] >= NAMED and one - least <= _TIE * max(1.0, least / freedom)
        ]
        cause = " or ".join(ties) if ties else UNDETERMINED
    return Masing(chi / freedom, low, high, even, 1.0 - even, cause, removed)
