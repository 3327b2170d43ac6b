"""Second step of an identification: parameters of a physical law from the free-form fit."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.special import chdtri

from microslip._core.checks import Floats, positive
from microslip._core.errors import InputError
from microslip._core.frozen import Locked
from microslip._core.units import engineering, interval_digits, significant
from microslip.friction import Interface
from microslip.identification.bands import QUANTILE, Bands
from microslip.identification.free_form import FreeForm
from microslip.identification.interface_model import InterfaceModel, Materials, Values
from microslip.identification.loads import carried

IDENTIFIED, BOUNDED, NOT, ASSUMED = "identified", "bounded", "not determined", "assumed"
RIG_PARAMETER = "rig_stiffness"
_NARROW = 0.3
"""Largest relative half-width of the interval of an identified parameter."""
_FINE = 1500
"""Number of points of a curve in series with a rig."""
_KEPT = 1e-10
"""Eigenvalues of the Gram matrix, over the largest one, that carry information."""
_FAR = 12.0
"""Largest change of a logarithm in the search of an end of an interval."""
_STEP = 1e-4
_CLEAR = 10.0
"""Displacement of the secant stiffness, over the smallest threshold, large compared with noise."""

_PASSES, _SAME = 3, 2e-3
"""Further passes, and the relative change of shifts or friction at their end."""

Scatter = Callable[[FreeForm, Values], Floats]
"""Changes of the scaled coefficients of a fit by random heights (columns)."""


class Unknown(NamedTuple):
    """Free parameter: name, unit, initial guess, and whether its logarithm is fitted."""

    name: str
    unit: str
    start: float
    is_log: bool = True
    low: float = -math.inf
    high: float = math.inf


class Law(NamedTuple):
    """Parametric law: first-loading force at displacements, from parameter values and a load."""

    unknowns: Sequence[Unknown]
    backbone: Callable[[Floats, Values, float | None], Floats]


class Datum(NamedTuple):
    """Measured value of a function of the parameters, with its standard error."""

    value: float
    error: float
    function: Callable[[Values], float]


@dataclass(frozen=True)
class Parameter(Locked):
    """Parameter of a physical law with its 95 % confidence interval and a verdict."""

    name: str
    unit: str
    value: float
    """Best value; not a number where it is not determined."""
    low: float
    high: float
    verdict: str
    """"identified", "bounded", "not determined" or "assumed"."""

    def __str__(self) -> str:
        if self.verdict == NOT:
            return f"{self.name}: {NOT}"
        digits = interval_digits(self.low, self.high, self.value)
        value, low, high = (
            # A power of a length has no prefix.
            engineering(number, self.unit, digits)
            if self.unit in ("N", "m", "N/m")
            else f"{significant(number, digits)} {self.unit}".rstrip()
            for number in (self.value, self.low, self.high)
        )
        return f"{self.name}: {value} ({low} to {high}), {self.verdict}"


@dataclass(frozen=True, eq=False, repr=False)
class InterfaceStep(Locked):
    """Greenwood interface fitted to the sufficient statistics of a free-form fit."""

    parameters: Mapping[str, Parameter]
    """Parameters and quantities derived from them, by name."""
    misfit: float
    """Rise of the sum of squares over that of the free form [-]."""
    misfit_limit: float
    """Rise that noise alone exceeds with a probability of 1 % [-]."""
    values: Mapping[str, float]
    """Best values of the free parameters."""
    rig_from_shape: Parameter | None
    """Stiffness of the rig [N/m] if the normal law has the assumed shape, and as it was given.

    None without a rig, with one of exactly known stiffness, or if the law does not fit.
    """
    _model: InterfaceModel
    _materials: Materials
    _loads: tuple[float, ...]

    @property
    def fits(self) -> bool:
        """Whether the law fits the loops as well as the free form does, within the noise."""
        return self.misfit <= self.misfit_limit

    def joint(self, normal_load: float | None = None) -> Interface:
        """Return the interface with the fitted parameters, without the rig.

        Parameters
        ----------
        normal_load : float, optional
            Normal load [N]; by default the highest measured one.

        Raises
        ------
        InputError
            If the rig is unknown, because the stiffness of the joint is then not determined.
        """
        undetermined = [one.name for one in self.parameters.values() if one.verdict == NOT]
        if undetermined:
            raise InputError(
                f"the loops do not determine {', '.join(undetermined)}: they cannot separate the "
                "joint from the rig; give `rig_stiffness=(value, error)`"
            )
        load = max(self._loads)
        if normal_load is not None:
            load = positive("normal_load", normal_load, "N", 500.0)
        materials = self._materials
        if "radius" in self.parameters:
            materials = materials._replace(radius=self.parameters["radius"].value)
        return self._model.build(self.values, load, materials)

    def table(self) -> str:
        """Return the parameters as text, with one parameter in each line."""
        words = "fits" if self.fits else "does not fit"
        head = (
            f"interface {words}: chi-squared rises by {self.misfit:.3g} over the free form "
            f"(noise alone: at most {self.misfit_limit:.3g})"
        )
        lines = [head, *(str(one) for one in self.parameters.values())]
        if self.rig_from_shape is not None:
            lines.append(f"with the assumed shape of the normal law: {self.rig_from_shape}")
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"InterfaceStep({'fits' if self.fits else 'does not fit'})"


class SufficientStatistics:
    """Sufficient statistics of a free-form fit: matrix R (``root``) and vector r (``target``).

    A law with coefficients g has the residuals R g - r. The coefficients are the scaled stiffnesses
    of the sliders whose backbone interpolates that of the law at the thresholds of the fit, then
    the changes of the threshold shifts (or of the friction coefficient) from those of the fit.
    """

    def __init__(
        self, fit: FreeForm, bands: Bands, rig: tuple[float, float] | None, free_rig: bool
    ) -> None:
        self.fit, self.rig, self.free_rig = fit, rig, free_rig
        gram = fit.design.T @ fit.design
        value, vector = np.linalg.eigh(gram)
        keep = value > _KEPT * value[-1]
        root = np.sqrt(value[keep])
        self.root = root[:, None] * vector[:, keep].T
        h = gram @ fit.g + fit.design.T @ fit.residual
        self.target = (vector[:, keep].T @ h) / root
        best = self.root @ fit.g - self.target
        self.least = float(best @ best)
        self.level = QUANTILE * bands.excess
        self.bands = bands

    @property
    def least_stiffness(self) -> float:
        """Lower bound of the rig stiffness [N/m]: secant stiffness of joint and rig in series.

        The secant ends at a displacement at which the force is well above the noise.
        """
        u = _CLEAR * self.fit.finest
        return float(self.fit.backbone(np.array([u]))[0]) / u

    def sliders(self, curve: Callable[[Floats, float | None], Floats], compliance: float) -> Floats:
        """Return the scaled coefficients of the sliders that approximate a law.

        The law is in series with a ``compliance`` [m/N].
        """
        fit = self.fit
        y = fit.y[:-1]
        reach = np.append(y, [y[-1] * 1.001, y[-1]])
        nodes = np.append(0.0, reach[:-1])
        force, shifts, nodes = self._series(curve, compliance, nodes)
        width = np.diff(nodes)
        slope = np.diff(force) / width
        # The polygon closest in the mean square lies h^2/12 T'' beside the curve at its nodes.
        bend = (slope[:-1] - slope[1:]) * 0.5 * (width[:-1] + width[1:])
        force[1:-2] += bend[:-1] / 12.0
        slope = np.diff(force) / width
        k = np.append(slope[:-1] - slope[1:], slope[-1])
        return np.concatenate((k, shifts)) * np.where(np.isfinite(fit.scale), fit.scale, 0.0)

    def _series(
        self, curve: Callable[[Floats, float | None], Floats], compliance: float, nodes: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Compute the force of the law ``curve`` in series with a spring of given compliance [m/N].

        Return the forces [N] at total displacements ``nodes`` [m]; the changes of the threshold
        shifts [m], or of the friction coefficient, from those of the fit; and the nodes. If the
        load varies within the cycle, ``nodes`` are first converted to the friction coefficient of
        the law (see :func:`carried`), and the converted nodes are returned.
        """
        fit = self.fit
        load = fit.reference
        if not compliance and not fit.extra:
            return curve(nodes, load), np.zeros(0), nodes
        end = nodes[-1] * 1.01
        beyond = np.geomspace(1.05 * end, 10.0 * end, 100)  # where a shift may lie
        x = np.concatenate(([0.0], np.geomspace(1e-5 * end, end, _FINE), beyond))
        force = curve(x, load)
        u = x + compliance * force
        far = np.array([1e3 * end])
        if fit.friction is not None:
            assert load is not None
            fall = float((curve(far, load) - curve(far, 0.5 * load))[0])
            # A law that knows no load moves with it as the free form does.
            friction = (
                fall / (0.5 * load)
                if fall > 0.0
                else max(fit.friction + float(fit.moved[0]), 0.2 * fit.friction)
            )
            drop = friction * (load - (fit.loads[0] or 0.0))
            nodes = carried(nodes, fit.fall, float(np.interp(drop, force, u)))
            return np.interp(nodes, u, force), np.array([friction - fit.friction]), nodes
        # B_high(u*) is what the limit falls by: mu (N_high - N_low).
        falls = [curve(far, load) - curve(far, low) for low in fit.loads[1:]]
        shifts = -np.interp(np.ravel(falls), force, u)
        return np.interp(nodes, u, force), shifts - fit.shifts[1:], nodes

    def misfit_limit(self, unknowns: int) -> float:
        """Return the rise [-] over the least sum of squares that noise exceeds in 1 % of fits."""
        count = max(self.target.size - unknowns, 1)
        return max(float(chdtri(count, 0.01)) * self.level / QUANTILE - self.least, 0.0)

    def residuals(self, g: Floats) -> Floats:
        """Return the residuals R g - r over their noise [-] of scaled coefficients g."""
        return np.asarray(self.root @ g - self.target)


class Problem:
    """Residuals of a law and of data as functions of parameters q, logarithms where ``is_log``."""

    def __init__(
        self,
        statistics: SufficientStatistics,
        law: Law,
        data: Sequence[Datum],
        scatter: Scatter | None = None,
    ) -> None:
        self.statistics, self.law, self.data, self.scatter = statistics, law, data, scatter
        unknowns = list(law.unknowns)
        if statistics.free_rig:
            stiff = statistics.least_stiffness
            unknowns.append(Unknown(RIG_PARAMETER, "N/m", 3.0 * stiff, low=1.001 * stiff))
        elif statistics.rig is not None and statistics.rig[1] > 0.0:
            unknowns.append(Unknown(RIG_PARAMETER, "N/m", statistics.rig[0]))
        self.unknowns = unknowns

    def values(self, q: Floats) -> dict[str, float]:
        """Return the parameters by name."""
        return {
            one.name: math.exp(v) if one.is_log else float(v)
            for one, v in zip(self.unknowns, q, strict=True)
        }

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper bounds of q."""

        def end(one: Unknown, value: float, far: float) -> float:
            if not one.is_log:
                return value
            return math.log(value) if 0.0 < value < math.inf else math.log(one.start) + far

        low = [end(one, one.low, -30.0) for one in self.unknowns]
        high = [end(one, one.high, 30.0) for one in self.unknowns]
        return np.array(low), np.array(high)

    def coefficients(self, values: Values) -> Floats:
        """Return the scaled coefficients of the sliders of the law."""
        rig = self.statistics.rig
        stiffness = values.get(RIG_PARAMETER, rig[0] if rig else math.inf)
        return self.statistics.sliders(
            lambda u, load: self.law.backbone(u, values, load), 1.0 / stiffness
        )

    def __call__(self, q: Floats) -> Floats:
        """Return the residuals of loops and data over their standard errors [-]."""
        values = self.values(q)
        rows = self.statistics.residuals(self.coefficients(values))
        if self._whitening is not None:
            directions, shrink = self._whitening
            rows = rows - directions @ (shrink * (directions.T @ rows))
        rig = self.statistics.rig
        extra = [(datum.function(values) - datum.value) / datum.error for datum in self.data]
        if RIG_PARAMETER in values and rig is not None and rig[1] > 0.0:
            extra.append((values[RIG_PARAMETER] - rig[0]) / rig[1])
        return np.asarray(np.nan_to_num(np.append(rows, extra), nan=1e6, posinf=1e6, neginf=-1e6))

    _whitening: tuple[Floats, Floats] | None = None

    def whiten(self, q: Floats) -> None:
        """Include the scatter from random summit heights at parameters q in the weights."""
        if self.scatter is None:
            return
        changes = self.statistics.root @ self.scatter(self.statistics.fit, self.values(q))
        square, turned = np.linalg.eigh(changes.T @ changes)
        keep = square > 1e-6
        directions = (changes @ turned[:, keep]) / np.sqrt(square[keep])
        self._whitening = directions, 1.0 - 1.0 / np.sqrt(1.0 + square[keep])


def fit_law(
    statistics: SufficientStatistics,
    law: Law,
    data: Sequence[Datum] = (),
    scatter: Scatter | None = None,
    starts: Sequence[Mapping[str, float]] = (),
) -> tuple[Problem, Floats, float, Floats]:
    """Fit a law; return problem, best parameters q, sum of squares and covariance of q.

    At several or varying loads the fit is repeated with the statistics about the law, whose shifts
    the loops determine better than those of the free form; the problem has the last statistics.
    """
    solved = _solved(statistics, law, data, scatter, starts)
    for _ in range(_PASSES):
        problem, q, *_ = solved
        fit, values = problem.statistics.fit, problem.values(q)
        if not fit.extra:
            break
        x = problem.coefficients(values) / fit.scale
        moved = x[fit.y.size :]
        at = fit.shifts[1:] if fit.friction is None else np.array([fit.friction])
        if np.any((at + moved) * at <= 0.0):
            break
        about = fit.about(moved, x[: fit.y.size])
        statistics = SufficientStatistics(
            about, statistics.bands, statistics.rig, statistics.free_rig
        )
        solved = _solved(statistics, law, data, scatter, [values])
        if np.all(np.abs(moved) < _SAME * np.abs(at)):
            break
    return solved


def _solved(
    statistics: SufficientStatistics,
    law: Law,
    data: Sequence[Datum],
    scatter: Scatter | None,
    starts: Sequence[Mapping[str, float]],
) -> tuple[Problem, Floats, float, Floats]:
    problem = Problem(statistics, law, data, scatter)
    low, high = problem.bounds

    def fit(q: Floats) -> Any:
        return least_squares(problem, q, bounds=(low, high), diff_step=_STEP, max_nfev=60)

    tries = []
    for start in ({}, *starts):
        values = [start.get(one.name, one.start) for one in problem.unknowns]
        q = [math.log(v) if u.is_log else v for u, v in zip(problem.unknowns, values, strict=True)]
        tries.append(fit(np.clip(q, low + 1e-9, high - 1e-9)))
    best = min(tries, key=lambda found: found.cost)
    if scatter is not None:
        for _ in range(2):
            problem.whiten(best.x)
            best = fit(best.x)
    best = least_squares(
        problem, best.x, bounds=(low, high), jac="3-point", diff_step=1e-3, max_nfev=20
    )
    covariance = np.linalg.pinv(best.jac.T @ best.jac, rcond=1e-14)
    return problem, np.asarray(best.x), 2.0 * float(best.cost), covariance


def profile(problem: Problem, q: Floats, least: float, i: int, error: float) -> tuple[float, float]:
    """Return the ends of the profile-likelihood interval of entry i of q; infinite if unbounded.

    ``least`` is the sum of squares at the minimum q, and ``error`` the standard error of entry i,
    which sets the first step of the search.
    """
    level = problem.statistics.level
    low, high = problem.bounds
    others = np.arange(q.size) != i
    ends = []
    for way in (-1.0, 1.0):
        reach = min(max(1.96 * error, 1e-6), _FAR)
        below, above, at, rest = 0.0, math.inf, reach, q[others].copy()
        end = way * math.inf
        for _ in range(14):
            place = q[i] + way * at
            if not low[i] < place < high[i] or at > _FAR:
                at = min(at, _FAR, (high[i] - q[i]) if way > 0 else (q[i] - low[i]))
                place = q[i] + way * at

            def part(p: Floats, place: float = place) -> Floats:
                whole = np.empty(q.size)
                whole[others], whole[i] = p, place
                return problem(whole)

            found = least_squares(
                part,
                np.clip(rest, low[others] + 1e-9, high[others] - 1e-9),
                bounds=(low[others], high[others]),
                diff_step=_STEP,
                max_nfev=25,
            )
            rise = 2.0 * float(found.cost) - least
            rest = np.asarray(found.x)
            if abs(rise / level - 1.0) < 0.03:
                end = place
                break
            if rise < level:
                below = at
                if at >= _FAR or place in (low[i], high[i]):
                    break
            else:
                above, end = at, place
            step = math.sqrt(level / max(rise, 1e-3 * level))
            at = at * min(max(step, 0.2), 4.0)
            if math.isfinite(above) and not below < at < above:
                at = 0.5 * (below + above)
        ends.append(end)
    return ends[0], ends[1]


def verdict_of(low: float, high: float, is_log: bool) -> str:
    """Return the verdict on a parameter with the interval ``low`` to ``high``.

    "identified": half the width of the interval (of the logarithm if ``is_log``) is at most 0.3;
    "bounded": it is wider, or only one end is finite; "not determined": neither end is finite.
    """
    if not (math.isfinite(low) and math.isfinite(high)) or (is_log and low <= 0.0):
        return BOUNDED if math.isfinite(low) or math.isfinite(high) else NOT
    half = 0.5 * math.log(high / low) if is_log else 0.5 * (high - low)
    return IDENTIFIED if half <= _NARROW else BOUNDED


def fitted_parameters(
    problem: Problem, q: Floats, least: float, covariance: Floats
) -> dict[str, Parameter]:
    """Return the free parameters of a law with profile-likelihood intervals and verdicts."""
    parameters = {}
    for i, one in enumerate(problem.unknowns):
        error = math.sqrt(max(float(covariance[i, i]), 0.0))
        low, high = profile(problem, q, least, i, error)
        value = float(q[i])
        if one.is_log:
            value, low, high = math.exp(value), math.exp(low), math.exp(min(high, 700.0))
            low = 0.0 if low < 1e-300 else low
            high = math.inf if high > 1e300 else high
        verdict = BOUNDED if one.name == RIG_PARAMETER else verdict_of(low, high, one.is_log)
        parameters[one.name] = Parameter(one.name, one.unit, value, low, high, verdict)
    return parameters
