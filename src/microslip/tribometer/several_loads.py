"""Several measurements of one contact together: the rig in series, and rate dependence."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from microslip._core.checks import show
from microslip.errors import InputError
from microslip.tribometer.estimates import Estimate, quantile, trend
from microslip.tribometer.measurement import Measurement


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
