"""Two rough surfaces as one against a flat one, and several scans of one face."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, overload

import numpy as np

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
    """
    if isinstance(a, Moments) and isinstance(b, Moments):
        same_axes = len(a.m2_axes) == len(b.m2_axes)
        return Moments(
            a.m0 + b.m0,
            a.m2 + b.m2,
            a.m4 + b.m4,
            _add(a.m2_axes, b.m2_axes) if same_axes else (),
            _add(a.m4_axes, b.m4_axes) if same_axes else (),
            a.m11 + b.m11 if same_axes else 0.0,
        )
    if isinstance(a, SummitStatistics) and isinstance(b, SummitStatistics):
        sums = combine(moments_from(a), moments_from(b)).mccool()
        label = a.estimate if a.estimate == b.estimate else f"{a.estimate} and {b.estimate}"
        by: RadiusBy = "load" if "load" in (a.radius_by, b.radius_by) else "curvature"
        radius = sums.radius * (BY_LOAD if by == "load" else 1.0)
        return SummitStatistics(
            sums.density, radius, sums.std, sums.mean_height, f"combined {label}", by
        )
    raise InputError(
        "combine wants two Moments or two SummitStatistics, as scan.moments() and "
        f"summits.statistics() are, got {show(type(a).__name__)} and {show(type(b).__name__)}"
    )


class Spread(NamedTuple):
    """Scatter of estimates of one face: standard deviations over the mean [-]."""

    density: float
    radius: float
    std: float


def average(faces: Sequence[SummitStatistics]) -> tuple[SummitStatistics, Spread]:
    """Summits of several scans of one face as those of one, and how much the scans differ.

    Parameters
    ----------
    faces : sequence of SummitStatistics
        One for each scan, at least one, their radii of one kind.

    Returns
    -------
    SummitStatistics
        All summits together, as if the scans, equally large, were one: the mean density; curvature
        and mean square height weighted by it.
    Spread
        Standard deviation from scan to scan over the mean, of density, radius and std; not a
        number for one scan.
    """
    for item in faces:
        if not isinstance(item, SummitStatistics):
            raise InputError(
                f"average wants SummitStatistics, as summits.statistics() is, got {show(item)}"
            )
    kinds = {item.radius_by for item in faces}
    if len(kinds) != 1:
        came = "none" if not faces else "radii by load and by curvature"
        raise InputError(f"average wants one or more SummitStatistics of one kind, got {came}")
    table = np.array([(item.density, item.radius, item.std) for item in faces])
    weights = table[:, 0] / table[:, 0].sum()
    means = np.array([item.mean_height for item in faces])
    mean = float(weights @ means)
    # Each scan has its own mean plane: what these differ by is no roughness.
    pooled = SummitStatistics(
        float(table[:, 0].mean()),
        1.0 / float(weights @ (1.0 / table[:, 1])),
        math.sqrt(float(weights @ table[:, 2] ** 2)),
        mean,
        faces[0].estimate,
        faces[0].radius_by,
    )
    if len(faces) == 1:
        return pooled, Spread(math.nan, math.nan, math.nan)
    scatter = table.std(axis=0, ddof=1) / table.mean(axis=0)
    return pooled, Spread(*map(float, scatter))


def _add(a: tuple[float, ...], b: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(x + y for x, y in zip(a, b, strict=True))
