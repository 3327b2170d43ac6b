"""Summits found on a scan, and surfaces and statistics derived from them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from microslip._core.checks import Floats, show
from microslip._core.errors import InputError
from microslip._core.frozen import Locked, lock
from microslip._core.units import engineering
from microslip._core.verdicts import Verdict
from microslip.contact import AsperityPopulation, GreenwoodWilliamson
from microslip.contact.materials import MaterialPair
from microslip.figures.plot import Plot
from microslip.figures.plottable import Plottable
from microslip.friction import Interface
from microslip.surfaces.checks import area_of
from microslip.surfaces.height_map import HeightMap
from microslip.surfaces.moments import SummitStatistics, lost_to_pixel
from microslip.surfaces.scan_rules import LOST_TO_PIXEL, judged, radius_in_pixels


@dataclass(frozen=True, eq=False)
class Summits(Locked, Plottable):
    """Summits of a scan, as returned by :func:`find_summits`."""

    positions: Floats
    """Positions along x and y [m] from the centre of the first point of the scan, shape (n, 2)."""
    heights: Floats
    """Heights above the mean of the scan [m]."""
    radii: Floats
    """Equivalent radii [m], 1/sqrt(k1 k2)."""
    curvatures: Floats
    """Principal curvatures [1/m], the larger first, shape (n, 2)."""
    prominences: Floats
    """Rise above the saddle to a higher summit [m]; for the highest, above the lowest point."""
    scan: HeightMap
    """Levelled and filtered scan."""
    cutoff: float | None
    """Short-wave cut-off [m] of the scan; None if the pixel limits it."""
    area: float
    """Searched area [m^2], without edges and missing points."""
    threshold: float
    """Smallest accepted prominence [m]."""
    dropped: int
    """Number of prominent points that are not round according to their fit."""
    peaks: int
    """Number of points above their eight neighbours, prominent or not."""
    notes: tuple[str, ...]
    """Conditioning of the scan and the search for summits."""

    def __post_init__(self) -> None:
        count = np.size(self.heights)
        rows = {len(v) for v in (self.positions, self.radii, self.curvatures, self.prominences)}
        if count == 0 or rows != {count}:
            raise InputError(
                f"`summits` must be one or more with arrays of equal length, got {count}"
            )
        for name in ("positions", "heights", "radii", "curvatures", "prominences"):
            lock(getattr(self, name))

    def __repr__(self) -> str:
        cut = "none" if self.cutoff is None else engineering(self.cutoff, "m", trim=True)
        return f"Summits({self.count} of {self.scan.name[:60]!r}, cut-off {cut})"

    def _figure(self) -> Plot:
        from microslip.surfaces.figures import summit_figure

        return summit_figure(self)

    @property
    def count(self) -> int:
        """Number of summits."""
        return self.heights.size

    @property
    def density(self) -> float:
        """Summits per unit area [1/m^2]."""
        return self.count / self.area

    @property
    def mean_height(self) -> float:
        """Mean height of the summits above the mean height of the scan [m]."""
        return float(self.heights.mean())

    @property
    def std(self) -> float:
        """Standard deviation of the summit heights [m]."""
        return float(self.heights.std())

    @property
    def mean_radius(self) -> float:
        """Inverse of the mean summit curvature [m]; McCool (1987), DOI 10.1115/1.3261349."""
        return 1.0 / float(self.curvatures.mean())

    @property
    def equivalent_radius(self) -> float:
        """Radius of equal spheres with the same load at equal indentation [m].

        The load on a summit is proportional to the square root of its radius, so this radius is the
        squared mean of the square roots.
        """
        return float(np.sqrt(self.radii).mean()) ** 2

    def statistics(self) -> SummitStatistics:
        """Return density, radius and spread of the summits.

        Returns
        -------
        SummitStatistics
            The parameters of Greenwood and Williamson (1966), DOI 10.1098/rspa.1966.0242; the
            radius is :attr:`equivalent_radius`.
        """
        return SummitStatistics(self.density, self.equivalent_radius, self.std, self.mean_height)

    def to_surface(
        self,
        pair: MaterialPair,
        area: float | str | None = None,
        *,
        heights: Literal["gaussian", "population"] = "gaussian",
    ) -> GreenwoodWilliamson | AsperityPopulation:
        """Make a rough surface with these summits, against a rigid plane.

        Parameters
        ----------
        pair : MaterialPair
            The two materials.
        area : float or str, optional
            Apparent area of the joint [m^2], or text such as "2 cm^2"; by default that of the scan.
        heights : {"gaussian", "population"}
            Gaussian heights with the mean and the standard deviation of the summits and one radius,
            or each summit with its own height and radius.

        Returns
        -------
        GreenwoodWilliamson or AsperityPopulation
            Heights are measured from the mean plane of the scan.

        Notes
        -----
        In a population each summit stands for as many equal summits as there are scanned areas in
        the apparent area. It has no summits higher than those of the scan, although a larger area
        would.
        """
        area = self.scan.area if area is None else area_of(area)
        if heights == "gaussian":
            return self.statistics().to_surface(pair, area)
        if heights != "population":
            raise InputError(
                f'`heights` must be "gaussian" or "population", got {show(heights)}; for other '
                "distributions use ms.GreenwoodWilliamson with the numbers of `statistics()`"
            )
        count = self.density * area
        if count < 0.5:
            raise InputError(
                f"`area` must hold at least one summit, {1.0 / self.density:.3g} m^2, got "
                f"{area:g} m^2"
            )
        return AsperityPopulation(pair, self.heights, self.radii, count / self.count, area)

    def validity(self, joint: Interface | None = None) -> tuple[Verdict, ...]:
        """Return the verdicts on the assumptions about the summits and, if given, about a joint."""
        if joint is not None and not isinstance(joint, Interface):
            raise InputError(f"`joint` must be an Interface, got {show(joint)}")
        pixel = math.sqrt(math.prod(self.scan.pixel))
        spacing = 1.0 / math.sqrt(self.density)
        values = radius_in_pixels(self.statistics().radius, self.scan.pixel)
        values["summit spacing in pixels"] = spacing / pixel
        if self.cutoff is not None:
            values["summit spacing over cut-off"] = spacing / self.cutoff
        values |= {
            LOST_TO_PIXEL: lost_to_pixel(self.scan.heights, self.scan.pixel),
            "summits": float(self.count),
            "kurtosis of the heights": float(self.scan.statistics().kurtosis),
            "radius by load over radius by curvature": self.equivalent_radius / self.mean_radius,
        }
        if self.threshold > 0.0:
            below = 1.0 - (self.count + self.dropped) / self.peaks
            values["fraction of peaks below the prominence"] = max(below, 0.0)
            values["peaks dropped for noise that is roughness"] = (
                max(below, 0.0) * self.scan.unfiltered.rough_share_of_noise
            )
        values["fraction of fits dropped"] = self.dropped / (self.dropped + self.count)
        return (*judged(values), *(joint.validity if joint is not None else ()))
