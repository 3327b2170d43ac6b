"""Surface from a drawing as summits, with the limits of its validity."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from types import MappingProxyType
from typing import NamedTuple

from microslip._core.checks import show
from microslip._core.errors import InputError
from microslip._core.frozen import assign
from microslip._core.wording import did_you_mean, quoted
from microslip.contact import GreenwoodWilliamson
from microslip.contact.materials import MaterialPair
from microslip.surfaces.moments import Moments
from microslip.surfaces.options import BREADTH, RA, RQ, RSM, RZ
from microslip.surfaces.summit_statistics import SummitStatistics

GAUSSIAN_RQ = math.sqrt(0.5 * math.pi)
"""Rq over Ra of Gaussian heights [-]."""
BREADTHS = (2.0, 10.0, 50.0)
"""Nayak's alpha [-] where it was not measured it: lowest, middle, highest."""


class Range(NamedTuple):
    """A number that is known between two others."""

    low: float
    middle: float
    high: float

    def times(self, low: float, middle: float, high: float) -> Range:
        """The range of a product of two that know nothing of each other, all above zero."""
        return Range(self.low * low, self.middle * middle, self.high * high)


@dataclass(frozen=True)
class Process:
    """Roughness average Ra [m] that a process commonly leaves, and where that is from."""

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
_ALIASES = {"edm": "eroded", "spark-eroded": "eroded", "sandblasted": "blasted"}


@dataclass(frozen=True)
class SurfaceFinish:
    """A rough face as a drawing describes it, turned into summits with stated assumptions.

    Parameters
    ----------
    ra, rq, rz : float, optional
        Roughness average, root mean square or mean peak-to-valley height of a profile [m], one of
        them (ISO 21920-2); without one a process must be given.
    rsm : float, optional
        Mean width of the profile elements RSm [m].
    process : str, optional
        "milled", "turned", "ground", "honed", "lapped", "polished", "eroded" (EDM) or "blasted".
    breadth : float, optional
        Nayak's alpha m0 m4/m2^2 [-], 1.5 or more, if it is known.

    Notes
    -----
    Heights are taken as Gaussian and isotropic; the three moments that McCool (1987),
    DOI 10.1115/1.3261349, turns into summits come from

    - m0 = Rq^2, with Rq = 1.25 Ra (1.11, a sine, to 1.5, plateaus with scratches), or from Rz as
      the expected range of a Gaussian profile over one sampling length (1/8 to 1/3.5 of Rz);
    - m2 = (2 pi Rq/RSm)^2, as the mean distance of crossings has it (Rice), the slope 0.7 (waves
      along one direction only) to 1.5 times that (RSm does not count small elements); without
      RSm the correlations of slope with roughness that Lambert and Fletcher (1997),
      DOI 10.2514/2.6221, review: 0.076 Rq^0.52, 0.124 Rq^0.743 (mean slopes, Rq in um), from the
      smaller over 1.5 to the larger times 1.5;
    - m4 = alpha m2^2/m0, alpha 10 (2 to 50) unless it is given. The product density * radius * std
      is 0.02 sqrt(alpha - 0.9), so Greenwood and Williamson's 0.03 to 0.05 are alphas of 3 to 7;
      longer and finer scans have larger ones (Yastrebov et al. 2017,
      DOI 10.1016/j.jmps.2017.07.016).
    """

    ra: float | None = None
    rq: float | None = None
    rz: float | None = None
    rsm: float | None = None
    process: str | None = None
    breadth: float | None = None

    def __post_init__(self) -> None:
        for declared in (RA, RQ, RZ, RSM, BREADTH):
            assign(self, **{declared.name: declared.checked(getattr(self, declared.name))})
        if self.process is not None:
            assign(self, process=process_named(self.process))
        heights = [name for name in ("ra", "rq", "rz") if getattr(self, name) is not None]
        if len(heights) > 1 or (not heights and self.process is None):
            came = quoted(heights, "and") if heights else "nothing of it"
            raise InputError(
                f"one of ra, rq and rz must be given, or a process such as ground, got {came}"
            )

    # -- what goes in -----------------------------------------------------------------------------

    @cached_property
    def rms(self) -> Range:
        """Root mean square height Rq [m]."""
        if self.rq is not None:
            return Range(self.rq, self.rq, self.rq)
        if self.rz is not None:
            return Range(self.rz, self.rz, self.rz).times(
                1 / 8.0, 1 / self._range_over_rms, 1 / 3.5
            )
        if self.ra is not None:
            average = Range(self.ra, self.ra, self.ra)
        else:
            process = PROCESSES[str(self.process)]
            average = Range(process.low, math.sqrt(process.low * process.high), process.high)
        return average.times(1.11, GAUSSIAN_RQ, 1.5)

    @property
    def _range_over_rms(self) -> float:
        """Expected range of a Gaussian profile over a sampling length, over its rms.

        Extremes of n waves lie at sqrt(2 ln n) + 0.577/sqrt(2 ln n) on either side. Without RSm
        there are ten of them, as sampling lengths are chosen.
        """
        assert self.rz is not None
        sampling = sampling_length(0.2 * self.rz)
        waves = 10.0 if self.rsm is None else max(sampling / self.rsm, 2.0)
        root = math.sqrt(2.0 * math.log(waves))
        return 2.0 * (root + 0.5772 / root)

    @cached_property
    def slope(self) -> Range:
        """Root mean square slope of profiles [-], the mean over all directions."""
        if self.rsm is not None:
            rms = self.rms.middle
            middle = 2.0 * math.pi * rms / self.rsm
            return Range(middle, middle, middle).times(0.7, 1.0, 1.5)
        rms = 1e6 * self.rms.middle
        # Mean absolute slopes, as of Gaussian ones: of a profile sqrt(2/pi) of its rms.
        slopes = [GAUSSIAN_RQ * slope for slope in (0.076 * rms**0.52, 0.124 * rms**0.743)]
        low, high = min(slopes), max(slopes)
        return Range(low / 1.5, math.sqrt(low * high), high * 1.5)

    @property
    def alpha(self) -> Range:
        """Nayak's breadth of the spectrum [-]."""
        if self.breadth is not None:
            return Range(self.breadth, self.breadth, self.breadth)
        return Range(*BREADTHS)

    # -- what comes out ---------------------------------------------------------------------------

    @cached_property
    def moments(self) -> Moments:
        """Spectral moments in the middle of the ranges [m^2, -, 1/m^2]."""
        return _moments(self.rms.middle, self.slope.middle, self.alpha.middle)

    @cached_property
    def statistics(self) -> SummitStatistics:
        """Summits in the middle of the ranges: density [1/m^2], radius [m], std [m]."""
        return self.moments.mccool()

    @cached_property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """Lowest and highest std [m], radius [m] and density [1/m^2] within the ranges.

        Slope and height rise together, so the slope is scaled with the height.
        """
        corners = [moments.mccool() for moments in self._corners()]
        return {
            name: (min(values), max(values))
            for name in ("std", "radius", "density")
            if (values := [getattr(item, name) for item in corners])
        }

    def _corners(self) -> Iterator[Moments]:
        slope = self.slope
        for rms, factor, alpha in product(
            self.rms, (slope.low / slope.middle, 1.0, slope.high / slope.middle), self.alpha
        ):
            # At a given RSm the slope goes with the height.
            middle = slope.middle * (rms / self.rms.middle if self.rsm is not None else 1.0)
            yield _moments(rms, middle * factor, alpha)

    def to_surface(self, pair: MaterialPair, area: float | str) -> GreenwoodWilliamson:
        """A rough surface with these summits against a smooth one, Gaussian from the mean plane.

        Parameters are those of :meth:`microslip.surfaces.SummitStatistics.to_surface`, areas in
        [m^2].
        """
        return self.statistics.to_surface(pair, area)


_SAMPLING = (
    (0.02e-6, 0.08e-3),
    (0.1e-6, 0.25e-3),
    (2e-6, 0.8e-3),
    (10e-6, 2.5e-3),
    (80e-6, 8e-3),
)
"""Largest Ra [m] and the sampling length [m] that ISO 4288 takes for it."""


def sampling_length(ra: float) -> float:
    """Sampling length [m] that ISO 4288 takes for Ra [m]: the cut-off of the filter."""
    return next((length for most, length in _SAMPLING if ra <= most), _SAMPLING[-1][1])


def process_named(name: object) -> str:
    """The process that a name stands for."""
    word = name.strip().casefold() if isinstance(name, str) else ""
    word = _ALIASES.get(word, word)
    if word not in PROCESSES:
        hint = did_you_mean(word, PROCESSES)
        raise InputError(f"`process` must be one of {quoted(PROCESSES)}, got {show(name)}{hint}")
    return word


def _moments(rms: float, slope: float, alpha: float) -> Moments:
    m0, m2 = rms * rms, slope * slope
    return Moments(m0, m2, alpha * m2 * m2 / m0)
