"""Force, energy and damping of an identified law against amplitude, with intervals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from microslip.friction.law_bands import LawBand
from microslip.identification.bands import Estimate
from microslip.identification.loads import groups_of

CONFIDENCE = 0.95
"""Confidence level of each single interval."""
SHOWN = ("force", "dissipated_energy", "damping_ratio")
"""Quantities against amplitude."""
_POINTS = 20  # geometrically spaced amplitudes, in addition to those of the records
_SAME_LOAD = 0.02
_BELOW = 0.5
"""Smallest amplitude of the curves over the smallest measured one."""


@dataclass(frozen=True, eq=False)
class AmplitudeTable:
    """Force, energy and damping ratio at one normal load against displacement amplitude."""

    load: float | None
    """Normal load [N]; None without one."""
    amplitude: NDArray[np.float64]
    """Amplitudes [m], rising, from half the smallest measured to the largest measured one."""
    measured: NDArray[np.float64]
    """Amplitudes of the records at this load [m], a subset of ``amplitude``."""
    estimates: Mapping[str, Estimate]
    """Force [N], dissipated energy [J] and damping ratio [-], arrays over the amplitudes."""

    def band(self) -> LawBand:
        """Return the confidence intervals as the band that is saved with a law in a law file."""
        ends = {name: np.array([e.low, e.high]) for name, e in self.estimates.items()}
        return LawBand(self.amplitude, ends, CONFIDENCE)


@lru_cache(maxsize=4)
def curves_of(found: Any) -> tuple[AmplitudeTable, ...]:
    """Return the estimates of an identification at each measured load, in increasing order."""
    tables = []
    loads: list[float | None] = [*sorted(found.loads)] or [None]
    for load in loads:
        measured = measured_amplitudes(found, load)
        first = _BELOW * float(measured[0])
        grid = np.geomspace(first, float(measured[-1]), _POINTS)
        inner = grid[np.abs(np.log(grid[:, None] / measured)).min(axis=1) > 1e-3]
        amplitude = np.union1d(inner, measured)
        estimates = {name: getattr(found, name)(amplitude, normal_load=load) for name in SHOWN}
        tables.append(AmplitudeTable(load, amplitude, measured, estimates))
    return tuple(tables)


def measured_amplitudes(found: Any, load: float | None) -> NDArray[np.float64]:
    """Return the distinct displacement amplitudes of the records at a normal load [m], increasing.

    With a given stiffness of the rig, the deflection of the rig is subtracted.
    """
    compliance = 0.0 if found.rig_stiffness is None else 1.0 / found.rig_stiffness[0]
    amplitudes = [
        record.folded.amplitude - 0.5 * compliance * float(np.ptp(record.model))
        for record in found.records
        if load is None or abs((record.normal_load or 0.0) / load - 1.0) <= _SAME_LOAD
    ]
    # Above the largest of the fit nothing is determined; both are the same but for rounding.
    means = [float(np.mean(group)) for group in groups_of(a for a in amplitudes if a > 0.0)]
    return np.asarray(np.minimum(np.array(means), found.amplitudes[1]))
