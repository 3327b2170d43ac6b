"""Floor 6: what is asked of a scan again and again, reckoned once: a scan does not change."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from microslip._frozen import Locked
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
