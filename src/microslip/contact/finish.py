"""Rms height and slope of a machined face from its drawing, with their uncertainty."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from types import MappingProxyType
from typing import NamedTuple

from microslip._core.checks import positive, show
from microslip._core.errors import InputError
from microslip._core.frozen import assign
from microslip._core.wording import did_you_mean, quoted

HIGHEST = 2e-4
"""Largest rms height of a machined face [m]."""
STEEPEST = 1.0
"""Largest rms slope of profiles [-]."""
GAUSSIAN_RQ = math.sqrt(0.5 * math.pi)
"""Rq over Ra of Gaussian heights [-]."""


class Estimated(NamedTuple):
    """Positive quantity with a log-normal distribution."""

    middle: float
    spread: float
    """Standard deviation of the logarithm [-]."""

    @classmethod
    def of_range(cls, low: float, high: float) -> Estimated:
        """Return the estimate whose 5 % and 95 % quantiles are the given ends."""
        return cls(math.sqrt(low * high), math.log(high / low) / (2.0 * 1.6449))

    def times(self, middle: float, low: float, high: float) -> Estimated:
        """Return the product with an independent factor of given median and 90 % interval."""
        return Estimated(self.middle * middle, math.hypot(self.spread, self.of_range(low, high)[1]))


@dataclass(frozen=True)
class Process:
    """Range of the roughness average Ra [m] that a process usually gives, and its source."""

    low: float
    high: float
    source: str


_CHART = "ASME B46.1, common production methods"
PROCESSES: Mapping[str, Process] = MappingProxyType(
    {
        "milled": Process(0.8e-6, 6.3e-6, _CHART),
        "turned": Process(0.4e-6, 6.3e-6, _CHART),
        "ground": Process(0.1e-6, 1.6e-6, _CHART),
        "honed": Process(0.1e-6, 0.8e-6, _CHART),
        "lapped": Process(0.05e-6, 0.4e-6, _CHART),
        "polished": Process(0.1e-6, 0.4e-6, _CHART),
        "eroded": Process(1.6e-6, 4.75e-6, f"{_CHART} (electrical discharge machining)"),
        "blasted": Process(
            1.0e-6, 12.5e-6, "Greenwood and Williamson 1966 (beads) to ISO 8503-1, medium (grit)"
        ),
    }
)
"""Finishes of machining processes, by name."""


@dataclass(frozen=True)
class Finish:
    """Roughness of one machined face as specified on a drawing.

    Parameters
    ----------
    ra, rq, rz : float, optional
        Roughness average, root mean square or mean peak-to-valley height of a profile [m] (ISO
        21920-2). Give at most one of them; without a process, exactly one.
    rdq : float, optional
        Root mean square slope of profiles Rdq [-].
    rsm : float, optional
        Mean width of the profile elements RSm [m], from which Rdq is estimated if it is not given.
    process : str, optional
        "milled", "turned", "ground", "honed", "lapped", "polished", "eroded" (EDM) or "blasted".

    Notes
    -----
    From Ra, Rq is 1.25 Ra (Gaussian heights), from 1.11 Ra (sine) to 1.5 Ra (plateaus with
    scratches). From Rz, Rq is Rz over the expected peak-to-valley height of a Gaussian profile of
    unit rms in a sampling length, from Rz/8 to Rz/3.5. A process alone determines Rq within a
    factor of two to four.

    From RSm, Rdq is 2 pi Rq/RSm (Rice), times a factor from 0.7 to 1.5, since RSm omits small
    elements. Without Rdq and RSm, Rdq follows from two correlations reviewed by Lambert and
    Fletcher (1997), DOI 10.2514/2.6221, for the mean slope: 0.076 Rq^0.52 and 0.124 Rq^0.743 (Rq in
    um); it lies between the smaller divided by 1.5 and the larger times 1.5. All these limits
    are 5 % and 95 % quantiles. The slope is the largest uncertainty of a joint from a drawing;
    measure it.
    """

    ra: float | None = None
    rq: float | None = None
    rz: float | None = None
    rdq: float | None = None
    rsm: float | None = None
    process: str | None = None

    def __post_init__(self) -> None:
        units = {"ra": "m", "rq": "m", "rz": "m", "rdq": "", "rsm": "m"}
        for item in fields(self):
            value = getattr(self, item.name)
            if value is not None and item.name != "process":
                assign(self, **{item.name: positive(item.name, value, units[item.name])})
        if self.process is not None and str(self.process) not in PROCESSES:
            hint = did_you_mean(str(self.process), PROCESSES)
            raise InputError(
                f"`process` must be one of {quoted(PROCESSES)}, got {show(self.process)}{hint}"
            )
        heights = [name for name in ("ra", "rq", "rz") if getattr(self, name) is not None]
        if len(heights) > 1 or (not heights and self.process is None):
            came = quoted(heights, "and") if heights else "none of them"
            raise InputError(
                f"one of ra, rq and rz must be given, or a process such as ground, got {came}"
            )
        if self.rdq is not None and self.rsm is not None:
            raise InputError("one of rdq and rsm must be given, got both; remove rsm")
        if heights and self.rms.middle > HIGHEST:
            raise InputError(
                f"`{heights[0]}` must give an Rq of at most {HIGHEST:g} m, more than any machined "
                f"face has, got {self.rms.middle:.3g} m; check its unit"
            )
        name = "rsm" if self.rdq is None else "rdq"
        if getattr(self, name) is not None and self.slope.middle > STEEPEST:
            raise InputError(
                f"`{name}` must give an rms slope of at most {STEEPEST:g}, the tangent of 45 "
                f"degrees, got {self.slope.middle:.3g}; check its unit"
            )

    @cached_property
    def rms(self) -> Estimated:
        """Root mean square height Rq [m]."""
        if self.rq is not None:
            return Estimated(self.rq, 0.0)
        if self.rz is not None:
            return Estimated(self.rz, 0.0).times(1.0 / self._range_over_rms, 1 / 8.0, 1 / 3.5)
        average = Estimated(self.ra or 1.0, 0.0)
        if self.ra is None:
            process = PROCESSES[str(self.process)]
            average = Estimated.of_range(process.low, process.high)
        return average.times(GAUSSIAN_RQ, 1.11, 1.5)

    @property
    def _range_over_rms(self) -> float:
        """Expected peak-to-valley height of a Gaussian profile in a sampling length, over its rms.

        The extremes of n waves lie at sqrt(2 ln n) + 0.577/sqrt(2 ln n) times the rms on either
        side of the mean. Without RSm, a sampling length is assumed to contain ten waves.
        """
        assert self.rz is not None
        ra = 0.2 * self.rz
        sampling = next((length for most, length in _SAMPLING if ra <= most), _SAMPLING[-1][1])
        waves = 10.0 if self.rsm is None else max(sampling / self.rsm, 2.0)
        root = math.sqrt(2.0 * math.log(waves))
        return 2.0 * (root + 0.5772 / root)

    @cached_property
    def slope(self) -> Estimated:
        """Root mean square slope Rdq of profiles [-]."""
        rms = self.rms.middle
        if self.rdq is not None:
            return Estimated(self.rdq, 0.0)
        if self.rsm is not None:
            return Estimated(2.0 * math.pi * rms / self.rsm, self.rms.spread).times(1.0, 0.7, 1.5)
        # Mean absolute slopes, as of Gaussian ones: of a profile sqrt(2/pi) of its rms.
        um = 1e6 * rms
        slopes = [GAUSSIAN_RQ * slope for slope in (0.076 * um**0.52, 0.124 * um**0.743)]
        return Estimated.of_range(min(slopes) / 1.5, max(slopes) * 1.5)


def combined(first: Estimated, second: Estimated) -> Estimated:
    """Return the estimate of sqrt(x^2 + y^2) for two independent estimates x and y."""
    total = math.hypot(first.middle, second.middle)
    parts = [(item.middle / total) ** 2 * item.spread for item in (first, second)]
    return Estimated(total, math.hypot(*parts))


_SAMPLING = (
    (0.02e-6, 0.08e-3),
    (0.1e-6, 0.25e-3),
    (2e-6, 0.8e-3),
    (10e-6, 2.5e-3),
    (80e-6, 8e-3),
)
"""Largest Ra [m] and the corresponding sampling length [m] that ISO 4288 prescribes."""
