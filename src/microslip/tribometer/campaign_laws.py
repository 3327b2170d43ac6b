"""Laws over several records: wear, running in, scatter of specimens, the rig, rate dependence.

Worn volume is taken against dissipated energy, with and without a threshold, and against Archard's
load times sliding distance (1953, DOI 10.1063/1.1721448); after Fouvry, Liskiewicz, Kapsa, Hannel
and Sauger (2003, DOI 10.1016/S0043-1648(03)00117-0).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from microslip._core.checks import Floats, show
from microslip.errors import InputError
from microslip.tribometer.estimates import Estimate, dependence_of, mean_of, quantile, trend
from microslip.tribometer.measurement import Measurement

_LEAST_WORK = 1e-3
"""Share of the work that is left of it at least, whatever its error."""
ENERGY, THRESHOLD, ARCHARD = "energy", "energy with a threshold", "Archard"


class Wear(NamedTuple):
    """A wear law: worn volume in proportion to something."""

    coefficient: Estimate
    """[m^3/J], or of Archard's law [m^3/(N m)], of a straight line."""
    records: tuple[str, ...]
    energy: Floats
    """Work of each record that wear is in proportion to [J] or [N m]."""
    volume: Floats
    """Worn volume [m^3]."""
    law: str = ENERGY
    threshold: Estimate | None = None
    """Below which nothing wears [J]."""
    scatter: float = math.nan
    """Standard deviation of the volumes beside the line [m^3]."""

    @property
    def is_archard(self) -> bool:
        """Whether the work is load times sliding distance."""
        return self.law == ARCHARD

    @property
    def has_threshold(self) -> bool:
        """Whether the threshold is above zero by its interval."""
        return self.threshold is not None and self.threshold.low > 0.0


def unlogged(
    law: Callable[[tuple[str, ...], Floats, Floats, float], Wear | None],
    names: tuple[str, ...],
    work: Floats,
    errors: Floats,
    volume: Floats,
    confidence: float,
) -> Wear | None:
    """A law whose coefficient also knows the errors of the work in cycles that were not logged.

    These are bounds, common to all records of a contact, so they are added and not squared.
    """
    wear = law(names, work, volume, confidence)
    if wear is None or not errors.any():
        return wear
    ends = (np.maximum(work - errors, _LEAST_WORK * work), work + errors)
    far = [law(names, end, volume, confidence) for end in ends]
    values = [wear.coefficient.value, *(w.coefficient.value for w in far if w is not None)]
    value, low, high, error, number = wear.coefficient
    below, above = value - min(values), max(values) - value
    if math.isnan(low):  # one volume: no scatter tells more
        low = high = value
    coefficient = Estimate(value, low - below, high + above, error, number)
    return wear._replace(coefficient=coefficient)


def proportional(names: tuple[str, ...], work: Floats, volume: Floats, confidence: float) -> Wear:
    """A straight line through zero by least squares."""
    if not np.all(work > 0.0):
        raise InputError(
            "an energy wear coefficient needs records that dissipate energy, got "
            f"{float(work.min()):.3g} J; is the sign of the force right?"
        )
    square = float(work @ work)
    slope = float(work @ volume) / square
    if work.size < 2:
        nothing = math.nan
        return Wear(Estimate(slope, nothing, nothing, nothing, 1), names, work, volume)
    residual = volume - slope * work
    scatter = math.sqrt(float(residual @ residual) / (work.size - 1))
    error = scatter / math.sqrt(square)
    half = quantile(confidence, work.size - 1) * error
    coefficient = Estimate(slope, slope - half, slope + half, error, int(work.size))
    return Wear(coefficient, names, work, volume, scatter=scatter)


def with_threshold(
    names: tuple[str, ...], work: Floats, volume: Floats, confidence: float
) -> Wear | None:
    """A straight line that begins at some energy; None where the records do not tell one.

    The interval of the threshold is Fieller's (1954), which is exact for straight lines.
    """
    if work.size < 3 or not np.ptp(work) > 0.0:
        return None
    middle, height = float(work.mean()), float(volume.mean())
    away = work - middle
    square = float(away @ away)
    slope = float(away @ volume) / square
    residual = volume - height - slope * away
    freedom = work.size - 2
    scatter = math.sqrt(float(residual @ residual) / freedom)
    reach = quantile(confidence, freedom) * scatter
    # Where the line may be zero: (height - slope d)^2 <= reach^2 (1/n + d^2/square).
    leading = slope**2 - reach**2 / square
    if leading <= 0.0 or slope <= 0.0:
        return None
    root = reach * math.sqrt(max(height**2 / square + leading / work.size, 0.0))
    low, high = (middle - (slope * height + sign * root) / leading for sign in (1.0, -1.0))
    error = scatter / math.sqrt(square)
    half = reach / math.sqrt(square)
    count = int(work.size)
    start = middle - height / slope
    of_start = (high - low) / (2.0 * quantile(confidence, freedom))
    return Wear(
        Estimate(slope, slope - half, slope + half, error, count),
        names,
        work,
        volume,
        THRESHOLD,
        Estimate(start, low, high, of_start, count),
        scatter,
    )


# -- running in ------------------------------------------------------------------------------------

_FEWEST_CYCLES = 12
_GRID = 240
_CERTAIN = 5.0
"""Standard errors from which on there is something that runs in."""


class RunningIn(NamedTuple):
    """y = settled + change exp(-(n - first)/constant), n being the number of the cycle."""

    label: str
    column: str
    settled: Estimate
    """Asymptote, in the unit of the column."""
    change: float
    """Excess over it at the first cycle."""
    constant: Estimate
    """Cycles in which what is left falls to 1/e."""
    first: float
    """Number of the first cycle."""
    numbers: Floats
    """Numbers of the cycles, and their values."""
    values: Floats

    def at(self, numbers: Floats) -> Floats:
        """The law at some cycles."""
        return self.settled.value + self.change * np.exp(
            -(numbers - self.first) / self.constant.value
        )


def running_in(
    label: str, column: str, numbers: Floats, values: Floats, confidence: float
) -> RunningIn | None:
    """The law of one contact; None where nothing runs in, or its constant is not told.

    Least squares, by the profile over the constant; neighbouring cycles that are alike widen it.
    """
    fine = np.isfinite(numbers) & np.isfinite(values)
    n, y = numbers[fine], values[fine]
    if n.size < _FEWEST_CYCLES or not n[-1] > n[0]:
        return None
    first = float(n[0])
    away = n - first
    reach = float(away[-1])
    step = float(np.diff(n).min())
    constants = np.geomspace(0.3 * max(step, 1e-3 * reach / n.size), 3.0 * reach, _GRID)
    fits = [_line(np.exp(-away / constant), y) for constant in constants]
    squares = np.array([fit[0] for fit in fits])
    best = int(squares.argmin())
    if best in (0, _GRID - 1):
        return None
    freedom = n.size - 3
    constant = float(constants[best])
    square, settled, change, error, of_settled = _line(np.exp(-away / constant), y)
    residual = y - settled - change * np.exp(-away / constant)
    dependence = dependence_of(residual, 3)
    freedom = min(freedom, max(dependence.freedom, 1))
    noise = square / max(n.size - 3, 1) * dependence.factor
    if not abs(change) > _CERTAIN * error * math.sqrt(noise):
        return None
    edge = square + quantile(confidence, freedom) ** 2 * noise
    inside = np.flatnonzero(squares <= edge)
    low, high = int(inside[0]), int(inside[-1])
    # Beyond a third of what was seen the settled value is an extrapolation.
    if low == 0 or high == _GRID - 1 or constants[high] > 0.5 * reach:
        return None
    t = quantile(confidence, freedom)
    ends = [float(constants[low - 1]), float(constants[high + 1])]
    settles = [fits[at][1] for at in inside]
    half = t * of_settled * math.sqrt(noise)
    span = Estimate(constant, ends[0], ends[1], (ends[1] - ends[0]) / (2.0 * t), int(n.size))
    limit = Estimate(
        settled,
        settled - math.hypot(half, settled - min(settles)),
        settled + math.hypot(half, max(settles) - settled),
        half / t,
        int(n.size),
    )
    return RunningIn(label, column, limit, change, span, first, n, y)


def _line(x: Floats, y: Floats) -> tuple[float, float, float, float, float]:
    """Squares beside a line, its value at zero, its slope, and errors of both of unit noise."""
    middle = float(x.mean())
    away = x - middle
    square = max(float(away @ away), 1e-300)
    slope = float(away @ y) / square
    at_zero = float(y.mean()) - slope * middle
    left = y - at_zero - slope * x
    error = 1.0 / math.sqrt(square)
    return float(left @ left), at_zero, slope, error, math.sqrt(1.0 / x.size + middle**2 / square)


# -- specimens -------------------------------------------------------------------------------------


class Pooled(NamedTuple):
    """A quantity over several specimens, or runs."""

    quantity: str
    of_each: tuple[tuple[str, Estimate], ...]
    """By their labels."""
    mean: Estimate
    """Mean of all that could be made: its interval includes the scatter between specimens and the
    error of each. Not a number for a single one."""
    between: float
    """Standard deviation between them that their own errors do not explain; 0 where none shows."""


def of_one(means: Sequence[Estimate], confidence: float) -> Estimate:
    """Mean of the records of one specimen, with the error by scatter or by their own errors."""
    values = np.array([mean.value for mean in means])
    errors = np.array([mean.standard_error for mean in means])
    if values.size == 1:
        return means[0]
    own_error = math.sqrt(float(np.nansum(errors**2))) / values.size
    scatter = float(values.std(ddof=1)) / math.sqrt(values.size)
    error = max(own_error, scatter)
    half = quantile(confidence, values.size - 1) * error
    value = float(values.mean())
    return Estimate(value, value - half, value + half, error, int(values.size))


def pooled(quantity: str, of_each: Sequence[tuple[str, Estimate]], confidence: float) -> Pooled:
    """The specimens together, at random from all that could be.

    The plain mean with Student's interval by the scatter of the specimens, one less than these
    being its degrees of freedom: it holds at any ratio of that scatter to their own errors, also
    where these are unlike, which weighted means do not (0.89 of 0.95 in simulations). It is not
    narrower than the errors of each allow.
    """
    values = np.array([estimate.value for _, estimate in of_each])
    mean = mean_of(values, confidence)
    if values.size < 2:
        return Pooled(quantity, tuple(of_each), mean, math.nan)
    # The error of a single cycle is unknown: it counts as scatter between them.
    errors = np.nan_to_num([estimate.standard_error for _, estimate in of_each], nan=0.0)
    own_variance = float(np.mean(errors**2))
    between = float(values.var(ddof=1)) - own_variance
    # Values that lie closer together than their errors are so by chance, or share an error.
    error = max(mean.standard_error, math.sqrt(own_variance / values.size))
    half = quantile(confidence, values.size - 1) * error
    mean = Estimate(mean.value, mean.value - half, mean.value + half, error, values.size)
    return Pooled(quantity, tuple(of_each), mean, math.sqrt(max(between, 0.0)))


# -- several loads ---------------------------------------------------------------------------------


def _checked(measurements: Iterable[Any]) -> list[Measurement]:
    rows = list(measurements)
    for measured in rows:
        if not isinstance(measured, Measurement):
            raise InputError(f"`measurements` must hold Measurements, got {show(measured)}")
    return rows


def rig_stiffness_of(measurements: Sequence[Measurement], *, confidence: float = 0.95) -> Estimate:
    """Stiffness of the rig in series, from the stiffness after reversals at several loads.

    Parameters
    ----------
    measurements : sequence of Measurement
        Measurements of one contact, nothing subtracted, at three normal loads or more.
    confidence : float, optional
        Level of the interval [-].

    Returns
    -------
    Estimate
        Stiffness [N/m]; the upper end is infinite where the data allow a rigid rig.

    Notes
    -----
    Compliances add up, 1/k = 1/k_rig + c/N, with a contact as stiff as it is loaded: exact for
    exponential heights, nearly so for others. The straight line over 1/N ends at 1/k_rig; a single
    load cannot tell rig and contact apart.
    """
    rows = _checked(measurements)
    for measured in rows:
        if "normal_load" not in measured.mean:
            raise InputError(f"{measured.name}: has no normal load")
        if measured.rig_stiffness is not None:
            raise InputError(f"{measured.name}: the rig is subtracted already; measure without")
    loads = np.array([measured.mean["normal_load"].value for measured in rows])
    if loads.size < 3 or np.ptp(loads) < 0.05 * loads.mean():
        raise InputError(
            f"rig_stiffness_of needs three different normal loads or more, got {loads.size} "
            "records that span "
            f"{float(np.ptp(loads)) if loads.size else 0.0:.3g} N"
        )
    softness = np.array([1.0 / measured.mean["reversal_stiffness"].value for measured in rows])
    away = 1.0 / loads - (1.0 / loads).mean()
    square = float(np.dot(away, away))
    slope = float(np.dot(away, softness)) / square
    residual = softness - softness.mean() - slope * away
    at_end = (1.0 / loads).mean()
    value = float(softness.mean() - slope * at_end)
    variance = float(np.dot(residual, residual)) / (loads.size - 2)
    error = math.sqrt(variance * (1.0 / loads.size + at_end**2 / square))
    if value <= 0.0:
        raise InputError(
            f"no compliance is left for the rig: the line ends at {value:.3g} m/N; "
            "contact and rig cannot be told apart here"
        )
    half = quantile(confidence, loads.size - 2) * error
    high = 1.0 / (value - half) if value > half else math.inf
    return Estimate(1.0 / value, 1.0 / (value + half), high, error / value**2, int(loads.size))


def rate_dependence(
    measurements: Sequence[Measurement],
    column: str = "dissipated_energy",
    *,
    confidence: float = 0.95,
) -> Estimate:
    """Relative change of a column with each decade of frequency.

    Parameters
    ----------
    measurements : sequence of Measurement
        Measurements of one contact at one amplitude and load, at three frequencies or more.
    column : str
        Column to evaluate.
    confidence : float, optional
        Level of the interval [-].

    Returns
    -------
    Estimate
        d ln(column) / d lg(frequency) [-]: rate independent, as friction is taken to be, where the
        interval holds 0.
    """
    rows = _checked(measurements)
    values, rates = [], []
    for measured in rows:
        if measured.frequency is None:
            raise InputError(f"{measured.name}: has no frequency; give time or sample_rate")
        if column not in measured.mean:
            raise InputError(
                f"`column` must be one of {', '.join(measured.mean)}, got {show(column)}"
            )
        values.append(measured.mean[column].value)
        rates.append(math.log10(measured.frequency))
    if len(rows) < 3 or max(rates) - min(rates) < 0.01:
        raise InputError(
            f"rate_dependence needs three records or more at different frequencies, got {len(rows)}"
        )
    return trend(np.array(rates), np.log(np.array(values)), confidence)
