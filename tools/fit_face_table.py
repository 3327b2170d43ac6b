"""Fit of the table of rough faces to its solved nodes, used by `tools/make_face_table.py`.

The terms are those that `microslip.contact.face_table` evaluates.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from microslip.contact import face_table
from microslip.contact.face_table import _POWERS, _powers

Floats = NDArray[np.float64]

_SIZE = [_POWERS.index(power) for power in ((0, 0), (0, 1), (1, 0))]
"""Terms divided by the side of the solved face over the roll-off wavelength, see :func:`fit`."""
_PIXEL: dict[str, tuple[list[int], list[int]]] = {
    name: ([_POWERS.index(power) for power in powers], [])
    for name, powers in {
        "stiffness": [(1, 0), (2, 0)], "contact": [(0, 0), (0, 1), (1, 0)], "bends": [(2, 0)],
    }.items()
}  # fmt: skip
"""Terms of the correction for the pixel; for elastic faces it affects only the contact area."""


def basis(powers: Floats, breadth: Floats, terms: tuple[list[int], list[int]]) -> Floats:
    plain, multiplied = terms
    return np.concatenate([powers[plain], (np.log(breadth) + 0.2) * powers[multiplied]])


def fit(nodes: dict[str, NDArray[Any]]) -> dict[str, Floats]:
    """Fit polynomials to solved faces (nodes), which ``face_table.values`` evaluates.

    Parameters
    ----------
    nodes : dict of ndarray
        Arrays with one entry per node: the groups ``hardness`` h, ``pressure`` P and ``breadth``;
        ``weight`` in the fit; ``waves``, the side of the solved face over the roll-off wavelength
        of its spectrum; and the quantities of ``face_table.NodeValues``, where ``stiffness``,
        ``loading``, ``contact`` and ``bends`` are logarithms. Arrays with the prefix ``pixel_`` are
        corrections of quantities from the pixel of the nodes to an infinitely fine one, at the
        groups ``pixel_hardness`` and ``pixel_pressure``.

    Returns
    -------
    dict of ndarray
        Coefficients by property; those of terms in 1/``waves``, zero for a large face, are omitted.
    """
    weight = np.asarray(nodes["weight"], dtype=float)
    powers, rising = _powers(*face_table.groups(nodes["hardness"], nodes["pressure"]))
    fine, _ = _powers(*face_table.groups(nodes["pixel_hardness"], nodes["pixel_pressure"]))
    # Changes by the pixel are not continued to softer faces than those that show them.
    solved = np.asarray(nodes["pixel_hardness"])
    inside = np.maximum(nodes["hardness"], solved.min(initial=1.0))
    within = _powers(*face_table.groups(inside, nodes["pressure"]))[0]
    waves = np.asarray(nodes["waves"], dtype=float)[:, None]
    breadth, none = np.asarray(nodes["breadth"], dtype=float), np.ones(fine.shape[1])
    found: dict[str, Floats] = {}
    for name, terms in face_table._TERMS.items():
        y = np.asarray(nodes[name], dtype=float).reshape(weight.size, -1)
        change = np.asarray(nodes[f"pixel_{name}"], dtype=float)
        change = change.reshape(none.size, y.shape[1])
        rows, scale = basis(powers, breadth, terms).T, weight
        count = rows.shape[1]
        rows = np.concatenate([rows, powers[_SIZE].T / waves], axis=1)
        if name == "separation":
            # The stiffness of first loading is the slope of this separation.
            slopes = np.concatenate(
                [basis(rising, breadth, terms).T, rising[_SIZE].T / waves], axis=1
            )
            rows = np.concatenate([rows, 0.5 * slopes])
            scale = np.concatenate([weight, weight])
        columns = []
        for k in range(y.shape[1]):
            right = y[:, k]
            if name in _PIXEL and none.size:
                known = np.isfinite(change[:, k])
                here = basis(within, np.ones(weight.size), _PIXEL[name]).T
                there = basis(fine, none, _PIXEL[name]).T
                right = right + here @ _least_squares(there[known], change[known, k])
            if name == "separation":
                right = np.concatenate([right, -0.5 * np.exp(-np.asarray(nodes["loading"]))])
            known = np.isfinite(right)
            heavy = scale[known]
            terms_found = _least_squares(rows[known] * heavy[:, None], right[known] * heavy)
            columns.append(terms_found[:count])  # those of a large face
        found[name] = np.array(columns)
    return found


def _least_squares(rows: Floats, right: Floats) -> Floats:
    return np.asarray(np.linalg.lstsq(rows, right, rcond=1e-10)[0])
