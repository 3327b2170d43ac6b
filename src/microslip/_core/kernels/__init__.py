"""Compiled kernels and their Python interface.

Each kernel documents its arguments: ``help(kernels.compiled.coupled)``. Results are written to
arrays among the arguments, C-contiguous float64, or int64 for codes and parent indices. A load
curve is the normal load N [N] as a function of the separation d [m] of the faces.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats

Integers = NDArray[np.int64]

TERMS = 12
"""Number of coefficients of a panel of a table."""
PROFILE_TERMS = 14
"""Number of coefficients of a panel of a load curve."""
QUADRATURE_RULES = ((0.05, 4), (1.0, 8), (16.0, 16))
"""Quadrature of slip losses: (largest length in panels, number of nodes)."""

try:
    compiled: Any = import_module("microslip._core.kernels._compiled")
except ImportError as error:
    raise ImportError(
        f"the compiled kernel of microslip cannot be loaded ({error}): install microslip again; "
        "wheels need no C compiler"
    ) from error
if (compiled.TERMS, compiled.PROFILE_TERMS) != (TERMS, PROFILE_TERMS):
    raise ImportError("the compiled kernel is older than the package: install microslip again")

NAME = "compiled"
"""Name of the kernel written to results."""


def curve_arguments(curve: Any) -> tuple[Callable[[memoryview, memoryview], None]]:
    """Return the arguments of a kernel for a load curve that is evaluated in Python.

    They take the place of ``Profile.arguments``. The single argument is a function, which the
    kernel calls once, with all separations whose loads it needs. ``curve`` has the methods ``drop``
    and ``load`` of :class:`microslip.contact.load_curve.LoadCurve`.
    """

    def answer(drops: memoryview, loads: memoryview) -> None:
        rows = np.frombuffer(drops).reshape(-1, 3)
        if len(rows):
            rows[:, 2] = curve.drop(rows[:, 0].copy(), rows[:, 1].copy())
        rows = np.frombuffer(loads).reshape(-1, 3)
        if len(rows):
            rows[:, 1], rows[:, 2] = curve.load(rows[:, 0].copy())

    return (answer,)


@cache
def _moment_coefficients(twice_order: int) -> Floats:
    """Return polynomials of F_n on intervals of h, for :func:`gaussian_moment`."""
    # Load by path, since importing importlib.resources is slow.
    tables = np.load(Path(__file__).with_name("gaussian_moments.npy"), allow_pickle=False)
    return np.ascontiguousarray(tables[twice_order + 1].ravel())


def gaussian_moment(h: Floats, twice_order: int) -> Floats:
    """Compute F_n(h), the integral of (u - h)^n phi(u) over u > h, for n = twice_order/2.

    Here phi is the density of the standard normal distribution, h [-] a threshold in standard
    deviations above the mean, and ``twice_order`` an integer from -1 to 5.
    """
    flat = np.ascontiguousarray(h, dtype=float).reshape(-1)
    out = np.empty_like(flat)
    compiled.gaussian_moment(flat, out, _moment_coefficients(twice_order), twice_order)
    return out.reshape(np.shape(h))


def gaussian_moment_at(h: float, twice_order: int) -> float:
    """Compute F_n(h), n = twice_order/2, for a single h; see :func:`gaussian_moment`."""
    value: float = compiled.gaussian_moment_at(h, _moment_coefficients(twice_order), twice_order)
    return value
