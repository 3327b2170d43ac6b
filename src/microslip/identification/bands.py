"""Confidence intervals of linear functionals of slider stiffnesses, calibrated by simulation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.special import chdtri

from microslip._core.checks import Floats
from microslip.identification.free_form import FreeForm
from microslip.identification.nonnegative import Path, minimum
from microslip.laboratory.estimates import dependence_of, quantile

QUANTILE = 3.841458820694124
"""Quantile of chi-squared with one degree of freedom at 95 %."""
_DRAWS, _DRAWS_OF_MANY, _MOST = 24, 8, 3.0
"""Simulated fits of the calibration where few and where many sliders carry the force, and the
largest factor on the quantile."""
_STANDS_OUT, _FEW = 3.0, 12
"""Smallest significant coefficient over its noise, and number of sliders that counts as few."""
_RUNS = (1, 8, 16, 32, 64)
"""Lengths of runs of residuals whose sums are compared with white noise."""
_UNLIKELY = 0.01
"""Probability below which residuals or cycles scatter more than noise."""


class Estimate(NamedTuple):
    """Value with its 95 % confidence interval; all fields are numbers, or arrays of one shape."""

    value: Any
    """Best estimate; not a number where only one end of the interval is known."""
    low: Any
    """Lower end."""
    high: Any
    """Upper end; infinite if the loops give no upper bound."""


class Bands:
    """Confidence intervals of linear functionals c.x of a fit.

    The vector x holds the stiffnesses of the sliders, then the changes, from their fitted values,
    of the shifts by which yield thresholds are smaller at lower loads. An interval is the range of
    c.x in which the sum of squares rises by at most a quantile over its minimum, with no stiffness
    negative. The quantile is that of chi-squared times two factors: one from fits to simulated
    noise (at a bound of the stiffnesses the statistic is a mixture of chi-squared distributions),
    the other the variance of correlated residuals and of the scatter between cycles, relative to
    that of white noise. Scaled functionals and coefficients refer to a design matrix whose columns
    are divided by their norms (``fit.scale``).
    """

    def __init__(self, fit: FreeForm) -> None:
        self.fit = fit

    @cached_property
    def excess(self) -> float:
        """Factor by which correlated residuals increase variances [-]; 1 for white noise."""
        fit, largest = self.fit, 1.0
        freedom = fit.freedom / fit.residual.size
        for run in _RUNS:
            count = fit.residual.size // run
            if count < 20:
                break
            sums = fit.residual[: count * run].reshape(count, run).sum(axis=1)
            total = float(sums @ sums) / run / (freedom if run == 1 else 1.0)
            if total > float(chdtri(count, _UNLIKELY)):
                largest = max(largest, total / count)
        return largest

    @cached_property
    def _cycles(self) -> list[Floats]:
        """Whitened force of each cycle minus the mean cycle, for each record (cycles, bins)."""
        scatter = []
        for rows in self.fit.rows:
            folded = rows.folded
            if folded.cycles < 3:
                scatter.append(np.zeros((0, np.count_nonzero(rows.weight))))
                continue
            apart = (folded.cycle_force - folded.cycle_count * folded.force) / folded.count
            scatter.append(rows.whitened(apart.T).T)
        return scatter

    def _by_cycles(self, direction: Floats) -> float:
        """Return the variance of a functional from cycle to cycle over that by noise [-]."""
        total, grown, freedom, at = 0.0, 0.0, 0, 0
        for rows, scatter in zip(self.fit.rows, self._cycles, strict=True):
            count, bins = scatter.shape
            along = direction[at : at + bins]
            if count:
                part = scatter @ along
                # Cycles that resemble their neighbours count as fewer.
                one = dependence_of(part, 0)
                wider = one.factor * (quantile(0.95, one.freedom) / quantile(0.95, count)) ** 2
                total += float(part @ part) * wider * count / (count - 1)
                freedom += count - 1
                if rows.folded.growth:  # the last cycles may be meant, half of the drift away
                    half = 0.5 * rows.folded.growth * rows.folded.force
                    grown += float(rows.whitened(half[:, None])[:, 0] @ along) ** 2
            at += bins
        norm = float(direction @ direction)
        if not freedom or norm <= 0.0:
            return 1.0
        ratio = total / norm
        ratio = ratio if ratio * freedom > float(chdtri(freedom, _UNLIKELY)) else 1.0
        return ratio + grown / norm

    @cached_property
    def _probes(self) -> Floats:
        """Scaled force and energy at the largest amplitude, energy at half the smallest, and k."""
        fit, y = self.fit, self.fit.thresholds()
        probes = np.zeros((4, fit.g.size))
        energies = (4.0 * y * np.maximum(a - y, 0.0) for a in (fit.largest, 0.5 * fit.smallest))
        probes[:, : y.size] = (np.minimum(fit.largest, y), *energies, np.ones(y.size))
        return np.asarray(probes / fit.scale)

    @cached_property
    def _truth(self) -> Floats:
        """Scaled coefficients of the simulated law: as fitted for significant sliders, else 0."""
        fit = self.fit
        truth = np.where((fit.g < _STANDS_OUT) & ~fit.free, 0.0, fit.g)
        # Nearly equal columns hide each other: leave out sliders that the sum of squares spares.
        at = np.flatnonzero(truth)
        while 1 < at.size <= _FEW:
            inverse = np.linalg.pinv(fit.cone.gram[np.ix_(at, at)])
            g = inverse @ fit.h[at]
            rise = np.where(fit.free[at], math.inf, g * np.abs(g) / np.diag(inverse))
            worst = int(np.argmin(rise))
            if rise[worst] >= _STANDS_OUT**2:
                truth[at] = g
                break
            truth[at[worst]] = 0.0
            at = np.delete(at, worst)
        return truth

    @property
    def _is_few(self) -> bool:
        return bool(np.count_nonzero(self._truth) <= _FEW)

    @cached_property
    def _simulated(self) -> list[tuple[Floats, Floats]]:
        """Vector h of the normal equations and solution g of each fit to simulated noisy forces."""
        fit, rng = self.fit, np.random.default_rng(0)
        base = fit.cone.gram @ self._truth
        fits = []
        for _ in range(_DRAWS if self._is_few else _DRAWS_OF_MANY):
            h = base + fit.design.T @ rng.standard_normal(fit.measured.size)
            fits.append((h, minimum(fit.cone, h, self._truth > 0.0)))
        return fits

    def _mean_statistic(self, c: Floats) -> float:
        """Return the mean rise of the sum of squares if c.x is constrained to its true value [-].

        The mean is over fits to simulated data. It is 1 for chi-squared with one degree of freedom.
        """
        truth = float(c @ self._truth)
        statistics = []
        for h, g in self._simulated:
            sign = 1.0 if float(c @ g) > truth else -1.0
            path = Path(self.fit.cone, h, g, sign * c)
            statistics.append(path.until(value=sign * truth)[1])
        return float(np.mean(np.clip(statistics, 0.0, 25.0)))

    @cached_property
    def _mean_of_probes(self) -> float:
        return float(np.mean([self._mean_statistic(c) for c in self._probes]))

    def calibration(self, c: Floats) -> float:
        """Return the factor on the chi-squared quantile for a scaled functional.

        The factor is the mean statistic of the simulated fits (:meth:`_mean_statistic`), limited to
        the range 1 to 3. If at most 12 sliders are significant, it is that of the functional
        itself, since the distribution then differs most from chi-squared; otherwise it is the mean
        for the four functionals of ``_probes``.
        """
        mean = self._mean_statistic(c) if self._is_few else self._mean_of_probes
        return min(max(mean, 1.0), _MOST)

    def interval(self, c: Floats) -> Estimate:
        """Return c.x with its interval for the coefficients ``c`` of a functional."""
        fit = self.fit
        scaled = np.zeros(fit.g.size)
        scaled[: c.size] = c
        scaled = scaled / fit.scale
        value = float(scaled @ fit.g)
        used = np.flatnonzero(fit.g != 0.0)
        direction = (
            fit.design[:, used]
            @ np.linalg.lstsq(fit.cone.gram[np.ix_(used, used)], scaled[used], rcond=None)[0]
        )
        excess = max(self.excess, self._by_cycles(direction))
        level = QUANTILE * self.calibration(scaled) * excess
        low, _ = Path(fit.cone, fit.h, fit.g, scaled).until(level=level)
        high, _ = Path(fit.cone, fit.h, fit.g, -scaled).until(level=level)
        return Estimate(value, min(low, value), max(-high, value))


def widened(value: float, low: float, high: float, errors: Sequence[float]) -> Estimate:
    """Return an estimate with standard errors added in quadrature to both half-widths."""
    extra = QUANTILE * sum(error * error for error in errors)
    below, above = (math.sqrt(half**2 + extra) for half in (value - low, high - value))
    return Estimate(value, value - below, value + above)
