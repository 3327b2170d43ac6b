"""Floor 0: the inner loops, compiled where a C compiler was found at installation.

The names here are those of :mod:`microslip.kernels.twin`, whose docstrings say what they do. The
environment variable ``MICROSLIP_KERNEL=numpy`` chooses the twin.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType

import numpy as np

from microslip._core.kernel_choice import kernel_name
from microslip.kernels.layout import MOMENT_TERMS, PROFILE_TERMS, TERMS, Floats, Integers

__all__ = [
    "MOMENT_TERMS",
    "NAME",
    "PROFILE_TERMS",
    "TERMS",
    "Floats",
    "Integers",
    "active",
    "gaussian_moment",
    "gaussian_moment_at",
]

NAME = kernel_name()


def _choose() -> ModuleType:
    if NAME == "numpy":
        return import_module("microslip.kernels.twin")
    compiled = import_module("microslip.kernels._compiled")
    made_for = compiled.TERMS, getattr(compiled, "PROFILE_TERMS", None)
    if made_for != (TERMS, PROFILE_TERMS):
        raise ImportError("the compiled kernel is older than the package: install microslip again")
    return compiled


active: ModuleType = _choose()
"""The module that does the work; tests put the twin here to compare."""


@cache
def _moment_tables() -> Floats:
    """Series by (order, piece, term); made, and explained, by tools/make_gaussian_tables.py."""
    # By its path: importlib.resources would take longer to import than all of this.
    tables: Floats = np.load(Path(__file__).with_name("gaussian_moments.npy"), allow_pickle=False)
    return tables


@cache
def _moment_coefficients(twice_order: int) -> Floats:
    return np.ascontiguousarray(_moment_tables()[twice_order + 1].ravel())


def gaussian_moment(h: Floats, twice_order: int) -> Floats:
    """F_n(h), n = twice_order/2 in -1/2 ... 5/2, of the standard Gaussian; any shape."""
    flat = np.ascontiguousarray(h, dtype=float).reshape(-1)
    out = np.empty_like(flat)
    active.gaussian_moment(flat, out, _moment_coefficients(twice_order), twice_order)
    return out.reshape(np.shape(h))


def gaussian_moment_at(h: float, twice_order: int) -> float:
    """F_n(h) at one h."""
    value: float = active.gaussian_moment_at(h, _moment_coefficients(twice_order), twice_order)
    return value
