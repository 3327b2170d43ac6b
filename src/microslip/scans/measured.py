"""Floor 6: what is asked of a scan again and again, reckoned once: a scan does not change."""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from microslip._core.frozen import Locked
from microslip.errors import InputError
from microslip.scans.checks import objection

if TYPE_CHECKING:
    from microslip.scans.moments import Moments
    from microslip.scans.statistics import Statistics


class Measured(Locked):
    """Heights, and what a pass over all of them has found."""

    heights: NDArray[np.float64]
    pixel: tuple[float, ...]
    name: str
    cutoff: float | None

    def measurable(self) -> Self:
        """The scan itself, if its heights vary and no spike drowns the others.

        Returns
        -------
        Scan
            This one.

        Raises
        ------
        InputError
            Heights that are all the same; points a million times farther from the median than
            usual.
        """
        if self._objection:
            raise InputError(f"{self.name[:60]}: {self._objection}")
        return self

    _noise_before: float | None = None
    """Noise [m] before the short-wave cut-off, if conditioning applied it: behind a filter there
    are hardly any differences from point to point left to tell it by."""

    def noise_behind(self, cutoff: float | None) -> float:
        """Standard deviation [m] of the noise behind one more filter, and those applied before.

        Parameters
        ----------
        cutoff : float or None
            Cut-off [m] of that filter.

        Returns
        -------
        float
            Of white noise of the size that the scan had before any filter, if that is known.
        """
        from microslip.scans.noise import noise_passed

        if self._noise_before is None:
            return noise_passed(self.noise, self.pixel, cutoff)
        whole = math.hypot(self.cutoff or 0.0, cutoff or 0.0)
        return noise_passed(self._noise_before, self.pixel, whole or None)

    @cached_property
    def noise(self) -> float:
        """Standard deviation of the noise of an area from point to point [m]: an upper bound."""
        from microslip.scans.noise import noise_std

        return noise_std(self.heights)

    @cached_property
    def _objection(self) -> str:
        return objection(self.heights)

    @cached_property
    def _statistics(self) -> Statistics:
        from microslip.scans.statistics import statistics_of

        return statistics_of(self.heights)

    @cached_property
    def _moments(self) -> Moments:
        from microslip.scans.moments import moments_of

        return moments_of(self.heights, self.pixel)
