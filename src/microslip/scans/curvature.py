"""The shape of summits: curvatures, place and height of the top."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats

_BLOCK = 1 << 16  # summits a pass


class Tops(NamedTuple):
    """Fitted summits, one row each."""

    curvatures: Floats
    """Principal curvatures (n, 2) [1/m], the larger first; above zero for a summit."""
    shifts: Floats
    """From the highest point to the top, (n, 2) along x and y [pixels]."""
    rises: Floats
    """Height of the top above that of the highest point [m]."""
    inside: NDArray[np.bool_]
    """Whether the top is within the points that were fitted; where not, no shift and no rise."""


def fitted(
    heights: Floats, places: NDArray[np.intp], pixel: tuple[float, ...], window: int
) -> Tops:
    """Quadric through the points around each summit, by least squares.

    z = z0 + gx x + gy y + (hxx x^2 + 2 hxy x y + hyy y^2)/2 over window x window points. Exact for
    a paraboloid. Already with three points a side white noise reaches the second derivatives with a
    third of the variance that it has in the differences of three points along an axis.
    """
    reach = window // 2
    side = np.arange(-reach, reach + 1)
    y, x = (part.reshape(-1) for part in np.meshgrid(side, side, indexing="ij"))
    design = np.stack([np.ones(x.size), x, y, 0.5 * x * x, x * y, 0.5 * y * y], axis=1)
    solve = np.linalg.pinv(design).T
    offsets = y * heights.shape[1] + x
    flat = heights.reshape(-1)
    terms = np.empty((places.size, 6))
    for start in range(0, places.size, _BLOCK):
        part = places[start : start + _BLOCK]
        # From the summit's own height: a high mean costs no digits.
        terms[start : start + _BLOCK] = (flat[part[:, None] + offsets] - flat[part, None]) @ solve
    z0, gx, gy, hxx, hxy, hyy = terms.T
    det = hxx * hyy - hxy * hxy
    with np.errstate(divide="ignore", invalid="ignore"):
        right, down = (hxy * gy - hyy * gx) / det, (hxy * gx - hxx * gy) / det
    inside = (hxx < 0.0) & (det > 0.0) & (np.abs(right) <= reach) & (np.abs(down) <= reach)
    shifts = np.where(inside[:, None], np.stack([right, down], axis=1), 0.0)
    rises = np.where(inside, z0 + 0.5 * (gx * shifts[:, 0] + gy * shifts[:, 1]), 0.0)
    dx, dy = pixel
    return Tops(_principal(-hxx / dx**2, -hxy / (dx * dy), -hyy / dy**2), shifts, rises, inside)


def by_differences(heights: Floats, places: NDArray[np.intp], pixel: tuple[float, ...]) -> Floats:
    """Curvatures [1/m] (n, 2) along x and along y, from each summit and its two neighbours there.

    The curvature of profiles across the summit, as they are in spectral moments.
    """
    flat, columns = heights.reshape(-1), heights.shape[1]
    dx, dy = pixel
    top = flat[places]
    along = ((top - flat[places - 1]) + (top - flat[places + 1])) / dx**2
    across = ((top - flat[places - columns]) + (top - flat[places + columns])) / dy**2
    return np.stack([along, across], axis=1)


def equivalent_radii(curvatures: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Radii 1/sqrt(k1 k2) [m], and which summits are round: curved down in every direction."""
    large, small = curvatures.T
    # So flat along one direction that rounding decides counts as flat.
    good = (large > 0.0) & (small > 1e-9 * large)
    product = np.where(good, large * small, 1.0)
    return 1.0 / np.sqrt(product), good


def _principal(a: Floats, b: Floats, c: Floats) -> Floats:
    """Eigenvalues of the matrices ((a, b), (b, c)), the larger first."""
    middle, half = 0.5 * (a + c), np.hypot(0.5 * (a - c), b)
    large = middle + half
    # The product of both is the determinant: no difference of almost equal numbers.
    with np.errstate(divide="ignore", invalid="ignore"):
        small = np.where(middle > 0.0, (a * c - b * b) / large, middle - half)
    return np.stack([large, small], axis=1)
