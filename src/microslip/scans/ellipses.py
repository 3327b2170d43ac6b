"""Ellipticity and direction of the summits of a scan."""

from __future__ import annotations

import math

import numpy as np

from microslip._core.checks import number, show
from microslip.errors import InputError
from microslip.heights import Gaussian
from microslip.materials import MaterialPair
from microslip.normal import EllipticSummits
from microslip.normal.elliptic import hertz_ellipse
from microslip.scans.checks import area_of
from microslip.scans.summit_set import Summits

_GRID = np.linspace(math.log(1e-8), 0.0, 129)


def elliptic_surface(
    summits: Summits, pair: MaterialPair, area: float | str, *, direction: float
) -> EllipticSummits:
    """A surface of elliptic summits, by the principal curvatures of those of a scan.

    Parameters
    ----------
    summits : Summits
        Of a scan, by their fit (the method "watershed").
    pair : MaterialPair
        The two materials.
    area : float or str
        Apparent area of the joint [m^2], or such as "2 cm^2".
    direction : float
        Direction of motion [rad], from the x of the scan towards its y.

    Returns
    -------
    EllipticSummits
        With the counted density, spread and radius by load, the geometric mean of the ratios of
        curvatures, and the angle to the lay at which the ratio of normal and tangential stiffness
        is the mean over the summits. Where the summits lie in all directions that is the ratio of a
        circle.

    Notes
    -----
    The mean is weighted by the root of the radii, as stiffnesses are at equal indentation. The
    directions come from differences over three points about each summit.
    """
    if not isinstance(summits, Summits) or summits.method != "watershed":
        came = getattr(summits, "method", None) or show(summits)
        raise InputError(f"elliptic_surface wants summits of the method watershed, got {came}")
    motion = number("direction", direction, "rad")
    z, (dx, dy) = summits.scan.heights, summits.scan.pixel
    column = np.clip(np.rint(summits.positions[:, 0] / dx).astype(int), 1, z.shape[1] - 2)
    row = np.clip(np.rint(summits.positions[:, 1] / dy).astype(int), 1, z.shape[0] - 2)
    middle = 2.0 * z[row, column]
    along_x = (middle - z[row, column - 1] - z[row, column + 1]) / dx**2
    along_y = (middle - z[row - 1, column] - z[row + 1, column]) / dy**2
    mixed = z[row + 1, column - 1] + z[row - 1, column + 1]
    mixed = (mixed - z[row + 1, column + 1] - z[row - 1, column - 1]) / (4.0 * dx * dy)
    lay = 0.5 * np.arctan2(2.0 * mixed, along_x - along_y) + 0.5 * math.pi
    logs = np.log(np.clip(summits.curvatures[:, 1] / summits.curvatures[:, 0], 1e-8, 1.0))
    means = [hertz_ellipse(math.exp(value)).along for value in _GRID]
    along = np.interp(logs, _GRID, means)
    cos2 = np.cos(motion - lay) ** 2
    weights = np.sqrt(summits.radii) / np.sqrt(summits.radii).sum()
    good = np.isfinite(cos2)
    mean = float(weights[good] @ (along * cos2 + (1.0 - along) * (1.0 - cos2))[good])
    mean /= float(weights[good].sum())
    ratio = math.exp(float(weights @ logs))
    aligned = hertz_ellipse(ratio).along
    share = 0.5 if aligned <= 0.5 else (mean - (1.0 - aligned)) / (2.0 * aligned - 1.0)
    return EllipticSummits(
        pair,
        Gaussian(summits.std, summits.mean_height),
        summits.equivalent_radius,
        summits.density,
        area_of(area),
        ratio,
        math.acos(math.sqrt(min(max(share, 0.0), 1.0))),
    )
