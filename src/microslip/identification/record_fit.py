"""Folded record with the force of the fitted law."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from microslip._core.frozen import Locked, lock
from microslip.laboratory.folding import Folded


@dataclass(frozen=True, eq=False)
class RecordFit(Locked):
    """Folded record and the force of the fitted law in its bins."""

    folded: Folded
    """Measured: displacement as a series, force in bins of the phase."""
    model: NDArray[np.float64]
    """Force of the law [N] in the bins, with the offset of the record."""

    @property
    def name(self) -> str:
        """Name of the record."""
        return self.folded.name

    @property
    def normal_load(self) -> float | None:
        """Mean normal load [N]."""
        return self.folded.normal_load

    @property
    def phase(self) -> NDArray[np.float64]:
        """Phases of the bins [rad]."""
        return self.folded.phase

    @cached_property
    def displacement(self) -> NDArray[np.float64]:
        """Measured displacement [m] at the mean phases of the bins."""
        return lock(self.folded.displacement(self.folded.phase))

    @property
    def measured(self) -> NDArray[np.float64]:
        """Mean force [N] of each bin."""
        return self.folded.force

    @cached_property
    def residual(self) -> NDArray[np.float64]:
        """Measured minus fitted force [N]."""
        return lock(self.folded.force - self.model)

    @cached_property
    def error(self) -> NDArray[np.float64]:
        """Standard deviation of the noise of the mean force in each bin [N]."""
        return lock(self.folded.force_noise / np.sqrt(self.folded.count))

    @property
    def measured_energy(self) -> float:
        """Energy dissipated in the mean cycle [J], the area of the loop."""
        return float(self.folded.force @ self.folded.way)
