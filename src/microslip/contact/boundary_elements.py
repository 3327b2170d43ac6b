"""Contact of rough faces by boundary elements: an elastic half-space on a grid, with a hardness.

Lengths are in units of the point spacing along x, written [pixels along x], and pressures in units
of E*, written [E*]. The two bodies are replaced by a rigid face with the heights z of the gap,
pressed on a half-space of modulus E*. The normal displacement is
2/|q| times the pressure for a wave of wavenumber q, and zero for the mean pressure, so that a
separation is the distance of the mean planes (Johnson 1985, DOI 10.1017/CBO9781139171731; Stanley
and Kato 1997, DOI 10.1115/1.2833523). The waves are cosines: the face is mirrored at its edges,
which avoids steps there and needs only one real transform.

At a separation d the pressures P minimise 1/2 P.KP - P.(z - d) with 0 <= P <= H/E*, where K P is
the displacement and H the hardness (Almqvist et al. 2007, DOI 10.1016/j.triboint.2005.11.008, for
the bound).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip._core.errors import InputError

Mask = NDArray[np.bool_]

_ROUNDS = 300
"""Largest number of active-set iterations; four to twelve are usual."""
_CAUTIOUS = 14
"""Iteration from which only the points with the largest residuals are released from their bounds.

No points are released while others leave the bounds. Otherwise the sets would alternate for ever
on a smooth face with deep scratches, on which nearly all points touch.
"""
_STEPS = 3000  # of conjugate gradients for one set


class HalfSpace:
    """Surface of an elastic half-space on a grid of points.

    Parameters
    ----------
    shape : tuple of int
        Rows (along y) and columns (along x).
    aspect : float
        Distance of points along y over that along x [-].
    mirrored : bool
        Whether the face is continued by its mirror images; otherwise it is periodic.
    """

    def __init__(
        self, shape: tuple[int, int], aspect: float = 1.0, *, mirrored: bool = True
    ) -> None:
        self.shape, self.mirrored = shape, mirrored
        rows, columns = shape
        if mirrored:
            qx: Floats = np.pi * np.arange(columns) / columns
            qy: Floats = np.pi * np.arange(rows) / rows / aspect
        else:
            qx = 2.0 * np.pi * np.fft.rfftfreq(columns).astype(float)
            qy = 2.0 * np.pi * np.fft.fftfreq(rows).astype(float) / aspect
        q = np.hypot(qy[:, None], qx)
        q[0, 0] = np.inf
        self._kernel = 2.0 / q
        self._directions = qx / q, qy[:, None] / q  # of the waves, by axis

    def displacement(self, pressure: Floats) -> Floats:
        """Return the normal displacement under pressures, shape (rows, columns), with zero mean."""
        from scipy import fft

        if self.mirrored:
            waves = fft.dctn(pressure)
            waves *= self._kernel
            return np.asarray(fft.idctn(waves, overwrite_x=True))
        return self._back(self._kernel * self._waves(pressure))

    def sheared(self, tractions: Floats, stiffness_ratio: float) -> Floats:
        """Return tangential displacements under tangential tractions, (2, rows, columns).

        Kernel of Cerruti for a wave of wavenumber q in direction n: 2/|q| (a I - (a - 1) n n^T), a
        = 2 lambda - 1, with the ratio lambda of normal to tangential stiffness of a round contact.
        The grid must be periodic: mirror images would reverse tractions normal to a mirror.
        """
        across = 2.0 * stiffness_ratio - 1.0
        x, y = (self._kernel * self._waves(part) for part in tractions)
        along = (across - 1.0) * (self._directions[0] * x + self._directions[1] * y)
        return np.stack([
            self._back(across * part - along * direction)
            for part, direction in zip((x, y), self._directions, strict=True)
        ])  # fmt: skip

    def _waves(self, values: Floats) -> NDArray[np.complex128]:
        from scipy import fft

        return np.asarray(fft.rfft2(values))

    def _back(self, waves: NDArray[np.complex128]) -> Floats:
        from scipy import fft

        return np.asarray(fft.irfft2(waves, s=self.shape, overwrite_x=True))


def press(
    space: HalfSpace,
    heights: Floats,
    separation: float,
    start: Floats | None = None,
    *,
    hardness: float = np.inf,
    tolerance: float,
) -> Floats:
    """Compute the contact pressures of a rough face at a given separation.

    Where the faces touch, a pressure lies between zero and the hardness; elsewhere it is zero.

    Parameters
    ----------
    space : HalfSpace
        Half-space with the grid of the heights.
    heights : ndarray
        Heights z of the gap [pixels along x], summits upwards, shape (rows, columns).
    separation : float
        Distance d of the plane z = 0 from the other face [pixels along x].
    start : ndarray, optional
        Initial guess of the pressures, such as those at another separation.
    hardness : float
        Upper bound of the pressures [E*].
    tolerance : float
        Largest residual [pixels along x]: gap at points with pressure, overlap at points without.

    Returns
    -------
    ndarray
        Pressures [E*], shape (rows, columns).

    Notes
    -----
    A primal-dual active set method (Hintermueller, Ito and Kunisch 2002, DOI
    10.1137/S1052623401383558). Points with a pressure between the bounds are free. Their pressures
    are found by conjugate gradients; then points that violate a condition change sets. These two
    steps are repeated until no point changes, usually four to twelve times.
    """
    target = heights - separation
    pressure = np.zeros_like(heights) if start is None else np.clip(start, 0.0, hardness)
    low, high = pressure <= 0.0, pressure >= hardness
    if low.all():
        low = target <= 0.0
    residual = target - space.displacement(pressure)
    for turn in range(_ROUNDS):
        free = ~(low | high)
        wrong = max(float(residual[low].max(initial=0.0)), -float(residual[high].min(initial=0.0)))
        error = float(np.abs(residual[free]).max(initial=0.0))
        goal = max(0.3 * max(error, wrong), 0.3 * tolerance)
        pressure, residual = _relax(space, free, pressure, residual, goal)
        below, above = free & (pressure < 0.0), free & (pressure > hardness)
        outside = bool(below.any() or above.any())
        if outside:
            np.clip(pressure, 0.0, hardness, out=pressure)
            residual = target - space.displacement(pressure)
        # Points that shall touch again.
        least = tolerance
        if turn >= _CAUTIOUS:
            least = max(least, 0.5 * max(
                float(residual[low].max(initial=0.0)), -float(residual[high].min(initial=0.0))
            ))  # fmt: skip
        up, down = low & (residual > least), high & (residual < -least)
        if outside and turn >= _CAUTIOUS:
            up = down = np.zeros_like(low)
        left = float(np.abs(residual[free]).max(initial=0.0))
        if left <= tolerance and not (outside or up.any() or down.any()):
            return pressure
        low, high = (low & ~up) | below, (high & ~down) | above
    raise InputError(
        f"the pressures at a separation of {separation:g} pixels did not converge in {_ROUNDS} "
        "iterations; the separation is nearly zero, or the heights are in a wrong unit"
    )


def _relax(
    space: HalfSpace, free: Mask, pressure: Floats, residual: Floats, goal: float
) -> tuple[Floats, Floats]:
    """Solve K P = z - d on the free points by conjugate gradients, ignoring the bounds of P.

    Iterate until no residual z - d - K P of a free point exceeds ``goal`` [pixels along x]. Return
    the new pressures [E*] and residuals of all points; the arguments are not changed.
    """
    here = residual * free
    direction, square = here, float(np.vdot(here, here))
    for _ in range(_STEPS):
        if float(np.abs(here).max(initial=0.0)) <= goal:
            break
        moved = space.displacement(direction)
        curvature = float(np.vdot(direction, moved))
        if not curvature > 0.0:  # a uniform pressure moves nothing
            break
        step = square / curvature
        pressure = pressure + step * direction
        residual = residual - step * moved
        here = residual * free
        new = float(np.vdot(here, here))
        direction, square = here + (new / square) * direction, new
    return pressure, residual


def closing(
    space: HalfSpace, contact: Mask, start: Floats | None = None, tolerance: float = 1e-5
) -> Floats:
    """Return s = -dP/dd, the increase of the pressures P per decrease of the separation d.

    It solves K s = 1 on the points in contact. They are held constant, since the change of the
    contact with d changes P only to second order; the mean of s is -dp/dd of the mean pressure p.
    The relative error of the mean is the square of the tolerance.
    """
    touching = contact.astype(float)
    first = np.zeros(contact.shape) if start is None else start * touching
    return _solve(lambda s: space.displacement(s) * touching, touching, first, tolerance)


def sliding(space: HalfSpace, contact: Mask, stiffness_ratio: float) -> Floats:
    """Return the ratio of tangential to normal stiffness of the contact [-], a (2, 2) tensor.

    The tangential stiffness is the mean traction when all points in contact move by one unit along
    x or y. Normal over tangential stiffness along a unit vector e is 1/(e . tensor . e).
    """
    touching = contact.astype(float)
    normal = float(closing(space, contact, tolerance=1e-3).mean())
    if normal <= 0.0:
        return np.zeros((2, 2))
    tensor = np.zeros((2, 2))
    for axis in (0, 1):
        unit = np.zeros((2, *contact.shape))
        unit[axis] = touching
        tractions = _solve(
            lambda t: space.sheared(t, stiffness_ratio) * touching,
            unit,
            np.zeros_like(unit),
            1e-3,
        )
        tensor[axis] = tractions.mean(axis=(1, 2)) / normal
    return 0.5 * (tensor + tensor.T)


def _solve(operator: Any, right: Floats, start: Floats, tolerance: float) -> Floats:
    """Solve operator(x) = right by conjugate gradients to the relative residual ``tolerance``."""
    solution = start
    here = right - operator(solution) if solution.any() else right.copy()
    direction, square = here, float(np.vdot(here, here))
    least = tolerance**2 * float(np.vdot(right, right))
    for _ in range(_STEPS):
        if square <= least:
            break
        moved = operator(direction)
        curvature = float(np.vdot(direction, moved))
        if not curvature > 0.0:
            raise InputError(
                "all points are in contact: lower the `tightening_pressure`, or check that heights "
                "and pixel are in metres"
            )
        step = square / curvature
        solution = solution + step * direction
        here = here - step * moved
        new = float(np.vdot(here, here))
        direction, square = here + (new / square) * direction, new
    return solution
