"""The form of contact faces: how far they stand apart where nothing presses them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from microslip._core.checks import Floats, floats, show
from microslip.errors import InputError

Gap = Callable[[Floats, Floats], Any]


def gaps_at(form: Any, places: Floats) -> Floats:
    """Gaps [m] at places along and across (points, 2) [m]; NaN where nothing is known.

    ``form`` is a function of x and y, arrays, or a table with the columns x, y and gap [m], at any
    places, NaN where nothing was measured.
    """
    if callable(form):
        try:
            values = np.asarray(form(places[:, 0], places[:, 1]), dtype=float)
        except Exception as error:
            raise InputError(
                "form must be a function of arrays x and y [m] that gives gaps [m]; it failed: "
                f"{type(error).__name__}: {error}"
            ) from None
        if values.ndim == 0:
            values = np.full(len(places), float(values))
        if values.shape != (len(places),):
            raise InputError(
                "form must be a function that gives one gap [m] a place, got shape "
                f"{values.shape} for {len(places)} places"
            )
        return values
    table = floats("form", form, missing=True)
    if table.ndim != 2 or table.shape[1] != 3:
        raise InputError(
            "form must be a function of x and y, or a table with the columns x, y and gap [m], got "
            f"{show(form) if table.ndim != 2 else f'shape {table.shape}'}"
        )
    measured = table[np.isfinite(table).all(axis=1)]
    if len(measured) < 4:
        raise InputError(f"form must know at least 4 places, got {len(measured)}")
    floats("form", measured)
    return _interpolated(measured, places)


def _interpolated(table: Floats, places: Floats) -> Floats:
    """Linear between the places of the table, and the nearest value just outside of them."""
    from scipy.interpolate import LinearNDInterpolator
    from scipy.spatial import Delaunay, cKDTree

    scale = np.ptp(table[:, :2], axis=0)
    if not (scale > 0.0).all():
        raise InputError("form must know places that differ along and across the faces")
    flat = table[:, :2] / scale
    values = np.asarray(LinearNDInterpolator(Delaunay(flat), table[:, 2])(places / scale))
    missing = np.flatnonzero(np.isnan(values))
    if missing.size:
        distance, nearest = cKDTree(flat).query(places[missing] / scale)
        close = distance < 0.05
        values[missing[close]] = table[nearest[close], 2]
    return values
