"""Floor 6: summits that were found on a scan, and what follows from them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from microslip._core.checks import Floats, show
from microslip._core.frozen import Locked, lock
from microslip._core.units import engineering
from microslip._core.wording import quoted
from microslip.errors import InputError
from microslip.scans.parameters import SummitStatistics
from microslip.scans.scan import Scan

if TYPE_CHECKING:
    from microslip.friction import Interface, Verdict
    from microslip.heights import HeightDistribution
    from microslip.materials import MaterialPair
    from microslip.normal import AsperityPopulation, GreenwoodWilliamson

Method = Literal["watershed", "neighbours"]
Estimate = Literal["counted", "neighbours", "mccool", "nayak"]
METHODS = ("watershed", "neighbours")
ESTIMATES = ("counted", "neighbours", "mccool", "nayak")


@dataclass(frozen=True, eq=False)
class Summits(Locked):
    """Summits of a scan.

    Made by :func:`find_summits`, not by hand.

    Parameters
    ----------
    positions : ndarray
        Where they are (n, 2) along x and y [m], from the centre of the first point of the scan.
    heights : ndarray
        Heights above the mean of the scan [m].
    radii : ndarray
        Equivalent radii [m]: 1/sqrt(k1 k2) of fitted summits, 2/(kx + ky) by differences.
    curvatures : ndarray
        Curvatures (n, 2) [1/m]: principal ones, the larger first; by differences along x and y.
    prominences : ndarray
        Rise above the saddle to a higher summit [m]; of the highest, above the lowest point.
    scan : Scan
        The scan in which they were found, levelled and filtered.
    cutoff : float or None
        Short-wave cut-off [m] of that scan; None where the pixel decides.
    area : float
        Area in which a summit could be found [m^2]: without edges and missing points.
    method : {"watershed", "neighbours"}
        How they were found.
    threshold : float
        Prominence [m] that they have at least.
    dropped : int
        How many more were prominent enough, but are no summits by their fit.
    neighbours : SummitStatistics
        Of every point above its eight neighbours, curvatures by differences: what other programs
        count, and what spectral moments go with.
    notes : tuple of str
        How the scan was conditioned and the summits were found.

    Raises
    ------
    InputError
        No summit, or arrays that do not belong together.
    """

    positions: Floats
    heights: Floats
    radii: Floats
    curvatures: Floats
    prominences: Floats
    scan: Scan
    cutoff: float | None
    area: float
    method: Method
    threshold: float
    dropped: int
    neighbours: SummitStatistics
    notes: tuple[str, ...]

    def __post_init__(self) -> None:
        count = np.size(self.heights)
        rows = {len(v) for v in (self.positions, self.radii, self.curvatures, self.prominences)}
        if count == 0 or rows != {count}:
            raise InputError(f"summits must be one or more, each with all it has, got {count}")
        for value in (
            self.positions,
            self.heights,
            self.radii,
            self.curvatures,
            self.prominences,
        ):
            lock(value)

    def __repr__(self) -> str:
        cut = "none" if self.cutoff is None else engineering(self.cutoff, "m", trim=True)
        return f"Summits({self.count} of {self.scan.name[:60]!r}, cut-off {cut})"

    @property
    def count(self) -> int:
        """How many there are."""
        return self.heights.size

    @property
    def density(self) -> float:
        """Summits per area [1/m^2]."""
        return self.count / self.area

    @property
    def mean_height(self) -> float:
        """Mean height above the mean of the scan [m]."""
        return float(self.heights.mean())

    @property
    def std(self) -> float:
        """Standard deviation of the heights [m]."""
        return float(self.heights.std())

    @property
    def mean_radius(self) -> float:
        """One over the mean curvature [m], as McCool's (1987) radius is; DOI 10.1115/1.3261349."""
        return 1.0 / float(self.curvatures.mean())

    @property
    def equivalent_radius(self) -> float:
        """Radius of equal spheres that carry at equal indentation what the summits carry [m].

        The load of a summit goes with the root of its radius, so it is the square of the mean root.
        """
        return float(np.sqrt(self.radii).mean()) ** 2

    def statistics(self, estimate: Estimate = "counted") -> SummitStatistics:
        """Density, radius and spread of the summits, by one of four estimates.

        Parameters
        ----------
        estimate : {"counted", "neighbours", "mccool", "nayak"}
            "counted": these summits; their radius is :attr:`equivalent_radius` of fitted ones and
            :attr:`mean_radius` by differences. "neighbours": every point above its eight
            neighbours. "mccool" and "nayak": from the spectral moments of the same scan.

        Returns
        -------
        SummitStatistics
            The parameters of Greenwood and Williamson (1966), DOI 10.1098/rspa.1966.0242.

        Raises
        ------
        InputError
            Another word; moments that no isotropic Gaussian surface has.
        """
        if estimate == "counted":
            by_fit = self.method == "watershed"
            radius = self.equivalent_radius if by_fit else self.mean_radius
            return SummitStatistics(
                self.density,
                radius,
                self.std,
                self.mean_height,
                "counted",
                "load" if by_fit else "curvature",
            )
        if estimate == "neighbours":
            return self.neighbours
        if estimate == "mccool":
            return self.scan.moments().mccool()
        if estimate == "nayak":
            return self.scan.moments().nayak_summits().statistics()
        raise InputError(f"estimate must be one of {quoted(ESTIMATES)}, got {show(estimate)}")

    def to_surface(
        self,
        pair: MaterialPair,
        area: float | str | None = None,
        *,
        estimate: Estimate | Literal["population"] = "counted",
        heights: Literal["gaussian", "discrete", "table"] | HeightDistribution = "gaussian",
    ) -> GreenwoodWilliamson | AsperityPopulation:
        """A rough surface with these summits, against a rigid plane.

        Parameters
        ----------
        pair : MaterialPair
            The two materials.
        area : float or str, optional
            Apparent area of the joint [m^2], or such as "2 cm^2"; by default that of the scan.
        estimate : {"counted", "neighbours", "mccool", "nayak", "population"}
            One of :meth:`statistics` for Greenwood and Williamson's law with one radius, or the
            summits themselves, each with its own height and radius, as many as the area has.
        heights : {"gaussian", "discrete", "table"} or HeightDistribution
            Law of the summit heights: Gaussian with the mean and the standard deviation of the
            estimate; the counted heights one by one; the density of the counted heights as a
            table; or another one. A population has its own.

        Returns
        -------
        GreenwoodWilliamson or AsperityPopulation
            Heights are measured from the mean plane of the scan.

        Raises
        ------
        InputError
            A word or an area that is not understood; too many summits for a population.

        Notes
        -----
        For a population the summits are ranked by height; each is taken as often as the apparent
        area holds the scanned one, and the remainder is drawn at even steps of rank. So the number
        is right to half a summit, and the distribution of heights is that of the scan to 1/n. The
        highest summit is then there several times: one scan knows nothing of higher ones.

        Of Gaussian heights the load is smooth in the separation, and a joint under a changing
        normal load tabulates it. Of a table, heights one by one or a population it is not: each
        step then asks the law itself, and takes some hundred times as long.
        """
        from microslip.scans.joint import surface_of

        return surface_of(self, pair, area, estimate, heights)

    def validity(self, joint: Interface | None = None) -> tuple[Verdict, ...]:
        """How far the summits bear a joint, a verdict for each assumption.

        Parameters
        ----------
        joint : Interface, optional
            A joint on the surface made of them, for the verdicts at its load.

        Returns
        -------
        tuple of Verdict
            Verdicts on the summits, then those on the joint.

        Raises
        ------
        InputError
            No joint.
        """
        from microslip.scans.joint import verdicts

        return verdicts(self, joint)
