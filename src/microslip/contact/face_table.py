"""Dimensionless law of Gaussian faces that yield when they are tightened: fits of a table.

Three groups describe a face under a tightening pressure p, with R and h' the rms height and the rms
gradient of the gap, H the hardness and <q> the mean wavenumber of the spectrum:

- hardness h = H/(E* h'),
- tightening A = p/H, or pressure P = p/(E* h') = A h, named ``pi`` in the code,
- breadth R <q>/h', between 0.6 and 0.95; the faces have 0.73 to 0.93.

`tools/make_face_table.py` solves random faces for a grid of these groups and stores the mean
results at each grid point (node). The fits are linear least squares in powers of t = -ln(1 +
1/h^2)/2 and v = ln hypot(A, 2 P), which are finite for an elastic face (h infinite: t = 0, A = 0),
and of ln(breadth). The stiffness k_n is that per area.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core.checks import Floats
from microslip._core.frozen import lock

FRACTIONS = np.array([0.985, 0.95, 0.87, 0.72, 0.5, 0.3, 0.15, 0.06, 0.02, 0.005])
"""Loads of the unloading, over that of tightening, at which the law was fitted."""
HARDNESS_RANGE = (0.03, 1e9)
"""Range of h; the faces of h = 1e9 are elastic."""
TIGHTENED = (0.003, 0.5)
"""Range of A = p/H."""
PRESSURE_END = 0.32
"""Largest P = p/(E* h')."""
BREADTH = (0.60, 0.84, 0.95)
"""Smallest, usual and largest breadth R <q>/h' [-]."""
_NARROWEST = 0.73
"""Smallest breadth of the nodes; below it the unloading curve is not extrapolated."""

_FINE = np.concatenate([1.0 - np.geomspace(2e-3, 0.28, 48), np.geomspace(0.715, 0.005, 60)])


class NodeValues(NamedTuple):
    """Properties of faces of rms height R tightened to a pressure p, one entry per face."""

    stiffness: Floats
    """Unloading stiffness k_n R/p [-]."""
    separation: Floats
    """Distance of the mean planes over R [-]."""
    loading: Floats
    """First-loading stiffness k_n R/p [-]."""
    contact: Floats
    """Fraction of the apparent area in contact [-]."""
    bends: Floats
    """Bends (1 - k/k_1)/(1 - N/N_1) at the load fractions, shape (faces, fractions), with
    the stiffness k_1 and the load N_1 at tightening; a bend is a mean slope of k over N."""
    contacts: Floats
    """Logarithm of contact area over that at tightening [-], at FRACTIONS; (faces, fractions)."""


class CurveShape(NamedTuple):
    """Unloading curve of one face from its tightening pressure, relative to that state."""

    share: Floats
    """Load over the tightening load, decreasing from 1."""
    distance: Floats
    """Increase of the separation since tightening, over p/k_n at tightening."""
    stiffness: Floats
    """Stiffness over that at tightening."""


def groups(hardness: ArrayLike, pressure: ArrayLike) -> tuple[Floats, Floats]:
    """Return the fit variables t and v from the groups h and P; see the module docstring."""
    h = np.asarray(hardness, dtype=float)
    pi = np.asarray(pressure, dtype=float)
    return -0.5 * np.log1p(h**-2.0), np.log(np.hypot(pi / h, 2.0 * pi))


_DEGREE = 5
_POWERS = tuple((i, j) for i in range(_DEGREE + 1) for j in range(_DEGREE + 1 - i))


def _terms(degree: int, by_v: int, by_breadth: int) -> tuple[list[int], list[int]]:
    """Return the indices in _POWERS of the terms of a fit.

    They are t^i v^j with i + j <= degree and j <= by_v, then ln(breadth) t^i v^j with
    i + j <= by_breadth.
    """
    plain = [n for n, (i, j) in enumerate(_POWERS) if i + j <= degree and j <= by_v]
    return plain, [n for n, (i, j) in enumerate(_POWERS) if i + j <= by_breadth]


_TERMS = {
    "stiffness": _terms(5, 4, 2), "separation": _terms(4, 4, 1), "contact": _terms(4, 4, 1),
    "bends": _terms(3, 2, 1), "contacts": _terms(3, 2, 0),
}  # fmt: skip


def _powers(t: Floats, v: Floats) -> tuple[Floats, Floats]:
    """Return t^i w^j with w = (v + 3)/2 at the exponents _POWERS, and the derivatives in v."""
    ts, ws = (np.vander(x, _DEGREE + 1, increasing=True).T for x in (t, 0.5 * (v + 3.0)))
    i, j = np.array(_POWERS).T
    return ts[i] * ws[j], ts[i] * (0.5 * j[:, None] * ws[np.maximum(j - 1, 0)])


@lru_cache(maxsize=1)
def _matrices() -> dict[str, Floats]:
    """Return the stored coefficients of all powers, then of all times ln(breadth) + 0.2."""
    arrays, found = stored(), {}
    for name, (plain, multiplied) in _TERMS.items():
        rows = arrays[f"fitted_{name}"]
        matrix = np.zeros((len(rows), 2 * len(_POWERS)))
        matrix[:, plain + [len(_POWERS) + n for n in multiplied]] = rows
        found[name] = lock(matrix)
    return found


def stored() -> dict[str, NDArray[Any]]:
    """Return all arrays stored in the package: version, nodes and coefficients."""
    from importlib.resources import files

    path = files("microslip.contact").joinpath("face_table.npz")
    with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
        return dict(archive)


def values(hardness: ArrayLike, pressure: ArrayLike, breadth: ArrayLike = BREADTH[1]) -> NodeValues:
    """Return the properties of faces at their tightening pressure.

    Parameters
    ----------
    hardness, pressure, breadth : array_like
        Dimensionless groups h, P and breadth [-], scalars or one-dimensional.
    """
    t, v, b = np.broadcast_arrays(*groups(hardness, pressure), breadth)
    t, v, b = (np.atleast_1d(np.asarray(x, dtype=float)) for x in (t, v, b))
    slim = np.log(b) + 0.2
    plain, by_separation = _powers(t, v)
    powers, rising = (np.concatenate([x, slim * x]) for x in (plain, by_separation))
    found = {name: matrix @ powers for name, matrix in _matrices().items()}
    if (b < _NARROWEST).any():
        least = np.log(np.maximum(b, _NARROWEST)) + 0.2
        found["bends"] = _matrices()["bends"] @ np.concatenate([plain, least * plain])
    slope = _matrices()["separation"][0] @ rising
    stiffness = np.exp(found["stiffness"][0])
    return NodeValues(
        stiffness=stiffness,
        separation=found["separation"][0],
        # No face is stiffer as it is loaded than as it is unloaded, and an elastic one is equal.
        loading=np.minimum(1.0 / np.maximum(-slope, 1e-3), stiffness),
        contact=np.exp(found["contact"][0]),
        bends=np.exp(found["bends"]).T,
        contacts=found["contacts"].T,
    )


@lru_cache(maxsize=1)
def _interpolation() -> Floats:
    """Return the matrix from values at the load fractions to those at the finer _FINE.

    The interpolation is a natural cubic spline in the logarithm of the fraction.
    """
    from scipy.interpolate import CubicSpline

    x = np.log(FRACTIONS[::-1])
    at = np.clip(np.log(_FINE), x[0], x[-1])
    return np.asarray(CubicSpline(x, np.eye(x.size), bc_type="natural")(at))[:, ::-1]


def shape(bends: Floats, factor: float = 1.0) -> CurveShape:
    """Return the convex unloading curve, stiffness against load, of one tightened face.

    Parameters
    ----------
    bends : ndarray
        Values of (1 - k/k_1)/(1 - N/N_1) at the load fractions N/N_1 = FRACTIONS [-].
        N is the load, k the normal stiffness; N_1 and k_1 are their values at tightening.
    factor : float
        Factor by which the bends are multiplied near N_1; it tends to one towards zero load.
    """
    y = np.exp(_interpolation() @ np.log(bends))
    y = factor * y / (1.0 + (factor - 1.0) * y * (1.0 - _FINE))
    share = np.concatenate([[1.0], _FINE])
    stiffness = np.concatenate([[1.0], 1.0 - y * (1.0 - _FINE)])
    # A convex law has a stiffness that falls; no stiffness is as low as a straight line to zero.
    floor = 0.5 * share
    stiffness = np.minimum.accumulate(np.clip(stiffness, floor, 1.0))
    stiffness *= 1.0 - 1e-9 * np.arange(share.size)
    steps = -np.diff(share) * 2.0 / (stiffness[1:] + stiffness[:-1])
    return CurveShape(share, np.concatenate([[0.0], np.cumsum(steps)]), stiffness)


def continued(h: Floats, pi: Floats, breadth: float) -> NodeValues:
    """Return values of the table, extrapolated to smaller hardness and smaller pressure.

    ``h`` and ``pi`` are the groups h and P. Below the smallest h, at equal A, k_n R/p is
    proportional to 1/h. Below the smallest P, k_n R/p and the unloading curve are constant, the
    contact area is proportional to P, and ln P falls linearly with the separation. Upper ends are
    not checked.
    """
    inside = np.maximum(h, HARDNESS_RANGE[0])
    wanted = pi * inside / h  # the pressure with this tightening at the hardness inside
    pressure = np.maximum(wanted, TIGHTENED[0] * np.minimum(inside, 1.0))
    found = values(inside, pressure, breadth)
    lighter = pressure / wanted
    return found._replace(
        stiffness=found.stiffness * inside / h,
        separation=found.separation + np.log(lighter) / found.loading,
        contact=found.contact / lighter,
    )
