"""Energy wear coefficient of a campaign: worn volume over the energy dissipated since new.

Worn volume is proportional to dissipated energy, after Fouvry, Liskiewicz, Kapsa, Hannel and Sauger
(2003, DOI 10.1016/S0043-1648(03)00117-0).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip._core.errors import InputError
from microslip.laboratory.cycle_columns import gain_error
from microslip.laboratory.estimates import Estimate, checked_confidence, quantile, with_gain
from microslip.laboratory.measurement import Measurement

_NEW = 0.05
"""Largest fraction of the cycles of a specimen that may be missing before its first record."""
_FIRST_CYCLE = (
    "State in the manifest the number of the first cycle of each file in the life of the specimen, "
    'in a column "first cycle"'
)


class Wear(NamedTuple):
    """Energy wear coefficient of the records with a worn volume."""

    coefficient: Estimate | None
    """Slope [m^3/J] of the line through zero of worn volume over energy; None without records."""
    records: tuple[str, ...]
    """Names of these records."""
    energy: Floats
    """Energy that the specimen had dissipated at the end of each record [J]."""
    volume: Floats
    """Worn volumes [m^3]."""
    unknown: Mapping[str, str] = MappingProxyType({})
    """Names of records with a worn volume but without a known energy, with the reason."""


def wear_of(
    measurements: Sequence[Measurement],
    specimens: Sequence[str],
    volumes: Sequence[float | None],
    first_cycles: Sequence[float | None],
    confidence: float = 0.95,
) -> Wear | None:
    """Fit worn volumes as proportional to the energy dissipated since the specimen was new.

    ``volumes`` [m^3] are those after each record, ``first_cycles`` the numbers of the first cycle
    of each record in the life of its specimen [-]; None where unknown. Then the rig's counter of
    cycles is used, or 1 for the only record of a specimen that has no counter. Energies of cycles
    that were not logged are interpolated linearly in the cycle number. The coefficient's interval
    includes the largest error of this interpolation if the energy changes monotonically between the
    logged cycles. None if no volume was measured.
    """
    confidence = checked_confidence(confidence)
    if not any(volume is not None for volume in volumes):
        return None
    rows: list[tuple[str, float, float, float]] = []
    unknown: dict[str, str] = {}
    for i, volume in enumerate(volumes):
        if volume is None:
            continue
        members = [j for j, name in enumerate(specimens) if name == specimens[i]]
        try:
            numbers = [_numbers(measurements[j], first_cycles[j], len(members)) for j in members]
            energy, error = _energy_until(measurements, members, numbers, i)
        except InputError as reason:
            unknown[measurements[i].name] = str(reason)
            continue
        rows.append((measurements[i].name, energy, error, volume))
    work, errors, worn = np.array([row[1:] for row in rows]).reshape(-1, 3).T
    coefficient = None
    if rows:
        gain = gain_error("dissipated_energy", measurements[0].gain_errors)
        line = _line_through_zero(work, errors, worn, confidence)
        coefficient = with_gain(line, gain, confidence)
    names = tuple(row[0] for row in rows)
    return Wear(coefficient, names, work, worn, MappingProxyType(unknown))


def _numbers(measured: Measurement, first: float | None, records: int) -> Floats:
    """Number the cycles of a record in the life of its specimen, from 1."""
    counter = measured.cycles.get("cycle_number")
    if counter is not None and np.all(np.diff(counter) > 0.0):
        return counter if first is None else counter + (first - counter[0])
    if np.any(np.diff(measured.cycles["start"]) > measured.cycles["period"][:-1] + 0.5):
        raise InputError(
            "cycles between its blocks were not logged; name the column of the rig's counter of "
            'cycles ("cycle column" in a manifest, `cycle_number=...` in Python)'
        )
    if first is None and records > 1:
        raise InputError(f"its specimen has several records. {_FIRST_CYCLE}")
    return np.arange(float(len(measured))) + (1.0 if first is None else first)


def _energy_until(
    measurements: Sequence[Measurement], members: list[int], numbers: list[Floats], last: int
) -> tuple[float, float]:
    """Return the energy [J] of a specimen up to the end of a record, and the bound of its error."""
    ordered = sorted(zip(numbers, members, strict=True), key=lambda pair: float(pair[0][0]))
    if any(after[0] <= before[-1] for (before, _), (after, _) in pairwise(ordered)):
        raise InputError(
            "its specimen has several series whose cycles are counted from the same number. "
            f'{_FIRST_CYCLE}, or a "specimen" of its own for each series'
        )
    end = next(float(of_record[-1]) for of_record, j in ordered if j == last)
    number = np.concatenate([of_record for of_record, _ in ordered])
    energy = np.concatenate([measurements[j].cycles["dissipated_energy"] for _, j in ordered])
    known = (number <= end) & np.isfinite(energy)
    number, energy = number[known], energy[known]
    if number[0] - 1.0 > _NEW * end:
        raise InputError(
            f"its specimen's first record begins at cycle {number[0]:.12g}; the energy before is "
            "not known: give the records from the first cycle on"
        )
    skipped = np.diff(number) - 1.0
    between = 0.5 * (energy[:-1] + energy[1:])
    error = float(np.sum(skipped * 0.5 * np.abs(np.diff(energy))))
    before = (number[0] - 1.0) * energy[0]
    total = float(energy.sum() + np.sum(skipped * between) + before)
    if not total > 0.0:
        raise InputError(f"its energy is {total:.3g} J; check the sign of the force")
    return total, error + before


def _line_through_zero(work: Floats, errors: Floats, volume: Floats, confidence: float) -> Estimate:
    """Fit volume = slope * work; the interval includes the bounds ``errors`` of ``work`` [J]."""
    square = float(work @ work)
    slope = float(work @ volume) / square
    error, half = math.nan, 0.0
    if work.size > 1:
        residual = volume - slope * work
        error = math.sqrt(float(residual @ residual) / (work.size - 1) / square)
        half = quantile(confidence, work.size - 1) * error
    elif not errors.any():
        return Estimate(slope, math.nan, math.nan, math.nan, 1)
    # Errors of cycles that were not logged are bounds, and may have one sign in all records.
    ratio = float((errors / work).max())
    low, high = (slope - half) / (1.0 + ratio), (slope + half) / max(1.0 - ratio, 1e-3)
    return Estimate(slope, low, high, error, int(work.size))
