"""Floor 6: two rough surfaces as one rough surface against a flat one."""

from __future__ import annotations

import math
from typing import overload

from microslip._core.checks import show
from microslip.errors import InputError
from microslip.scans.moments import SUMMIT_SHARE, Moments
from microslip.scans.summit_statistics import BY_LOAD, RadiusBy, SummitStatistics


def moments_from(summits: SummitStatistics) -> Moments:
    """The moments of the isotropic Gaussian surface that has these summits."""
    m4 = (0.375 / summits.mean_radius) ** 2 * math.pi
    m2 = m4 / (6.0 * math.pi * math.sqrt(3.0) * summits.density)
    return Moments(summits.std**2 + SUMMIT_SHARE * m2 * m2 / m4, m2, m4)


@overload
def combine(a: Moments, b: Moments) -> Moments: ...
@overload
def combine(a: SummitStatistics, b: SummitStatistics) -> SummitStatistics: ...
def combine(
    a: Moments | SummitStatistics, b: Moments | SummitStatistics
) -> Moments | SummitStatistics:
    """The rough surface that meets a flat one as two rough surfaces meet each other.

    The gap of two surfaces that know nothing of each other has the sum of their spectra, so their
    moments add (Greenwood 1984, DOI 10.1098/rspa.1984.0042). The distance of the mean planes stays
    the same.

    Parameters
    ----------
    a, b : Moments or SummitStatistics
        Both of one kind. Summit statistics are turned into moments by McCool's formulas and back,
        which takes both surfaces as isotropic and Gaussian: so the mean height of the sum is
        theirs, whatever the mean heights given are.

    Returns
    -------
    Moments or SummitStatistics
        Those of the sum; a radius is by load if one of the two is. Axes are as laid on each other:
        x on x and y on y. The joint of both is ``combine(a, b).to_surface(pair, area)``; of
        moments, ``combine(a, b).mccool().to_surface(pair, area)``.

    Raises
    ------
    InputError
        Two of different kinds, or of another.
    """
    if isinstance(a, Moments) and isinstance(b, Moments):
        both = len(a.m2_axes) == len(b.m2_axes)
        return Moments(
            a.m0 + b.m0,
            a.m2 + b.m2,
            a.m4 + b.m4,
            _add(a.m2_axes, b.m2_axes) if both else (),
            _add(a.m4_axes, b.m4_axes) if both else (),
            a.m11 + b.m11 if both else 0.0,
        )
    if isinstance(a, SummitStatistics) and isinstance(b, SummitStatistics):
        found = combine(moments_from(a), moments_from(b)).mccool()
        label = a.estimate if a.estimate == b.estimate else f"{a.estimate} and {b.estimate}"
        by: RadiusBy = "load" if "load" in (a.radius_by, b.radius_by) else "curvature"
        radius = found.radius * (BY_LOAD if by == "load" else 1.0)
        return SummitStatistics(
            found.density, radius, found.std, found.mean_height, f"combined {label}", by
        )
    raise InputError(
        "combine wants two Moments or two SummitStatistics, as scan.moments() and "
        f"summits.statistics() are, got {show(type(a).__name__)} and {show(type(b).__name__)}"
    )


def _add(a: tuple[float, ...], b: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(x + y for x, y in zip(a, b, strict=True))
