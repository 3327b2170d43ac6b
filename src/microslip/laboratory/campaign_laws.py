"""Laws over several records: the energy wear coefficient and the stiffness of the rig.

Worn volume is proportional to dissipated energy, after Fouvry, Liskiewicz, Kapsa, Hannel and Sauger
(2003, DOI 10.1016/S0043-1648(03)00117-0).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats, members
from microslip._core.errors import InputError
from microslip.laboratory.estimates import Estimate, checked_confidence, quantile
from microslip.laboratory.measurement import Measurement

_LEAST_WORK = 1e-3
"""Smallest share of the work that is assumed, whatever its error."""


class Wear(NamedTuple):
    """The energy wear coefficient: worn volume in proportion to dissipated energy."""

    coefficient: Estimate
    """Slope of a straight line through zero [m^3/J]."""
    records: tuple[str, ...]
    energy: Floats
    """Energy that the contact of each record has dissipated [J]."""
    volume: Floats
    """Worn volumes [m^3]."""
    scatter: float = math.nan
    """Standard deviation of the volumes about the line [m^3]."""


def with_unlogged_cycles(
    names: tuple[str, ...], work: Floats, errors: Floats, volume: Floats, confidence: float
) -> Wear:
    """Fit :func:`proportional` and widen its interval by the error of cycles not logged.

    The errors [J] are bounds that all records of a contact share, so they are added to the ends of
    the interval and not squared.
    """
    wear = proportional(names, work, volume, confidence)
    if not errors.any():
        return wear
    ends = (np.maximum(work - errors, _LEAST_WORK * work), work + errors)
    values = [proportional(names, end, volume, confidence).coefficient.value for end in ends]
    value, low, high, error, number = wear.coefficient
    below, above = value - min(*values, value), max(*values, value) - value
    if math.isnan(low):  # a single volume has no scatter
        low = high = value
    return wear._replace(coefficient=Estimate(value, low - below, high + above, error, number))


def proportional(names: tuple[str, ...], work: Floats, volume: Floats, confidence: float) -> Wear:
    """Fit a straight line through zero by least squares."""
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


# -- several loads ---------------------------------------------------------------------------------


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
    rows = members("measurements", measurements, Measurement, "Measurements")
    confidence = checked_confidence(confidence)
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
    softness = np.array([1.0 / measured.mean["chord_stiffness"].value for measured in rows])
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
