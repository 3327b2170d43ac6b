"""Checks of the arrays of a stored reduced joint."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from microslip._core.errors import InputError
from microslip.structures.matrices import check_mass, check_stiffness, symmetric_matrix

FILE_KIND: Final = "microslip-reduced-joint"
NEWER: Final = {"base_inertia": "mass", "sensor_base": "sensor_rows"}
"""Arrays missing in earlier files, and arrays with the same number of rows."""

# A letter for each size, the same wherever it stands: degrees of freedom n, patches p, bolts b,
# sensors s, samples m, points v and facets f of the outside with c corners.
_SHAPES: Final = {
    "mass": "nn", "stiffness": "nn", "patch_areas": "p", "patch_gaps": "p", "patch_boxes": "p4",
    "patch_contacts": "p", "bolt_stiffness": "b", "bolt_tension": "b", "sensor_names": "s",
    "sensor_rows": "sn", "samples_places": "m2", "samples_weights": "m", "samples_patches": "m",
    "surface_points": "v3", "surface_facets": "fc", "surface_motion": "v3n",
    "full_size": "", "left_out": "",
}  # fmt: skip
_NUMBERS_OF: Final = {"samples_patches": "p", "surface_facets": "v", "patch_contacts": "p"}
_POSITIVE: Final = ("patch_areas", "bolt_stiffness", "samples_weights")


def check_arrays(arrays: Mapping[str, Any]) -> None:
    """Raise InputError for missing or non-finite arrays, wrong shapes and invalid matrices."""
    if str(arrays.get("kind", "")) != FILE_KIND:
        raise InputError("holds no reduced joint; ReducedJoint.save writes such files")
    sizes: dict[str, int] = {str(count): count for count in (2, 3, 4)}
    for name, letters in _SHAPES.items():
        if name not in arrays:
            raise InputError(f'is damaged: "{name}" is missing')
        array = arrays[name]
        kinds = "U" if name == "sensor_names" else "iu" if name in _NUMBERS_OF else "iuf"
        fits = array.dtype.kind in kinds and array.ndim == len(letters)
        if not fits or any(
            sizes.setdefault(letter, count) != count
            for letter, count in zip(letters, array.shape, strict=True)
        ):
            raise InputError(
                f"is damaged: {name} has the shape {array.shape} and the type {array.dtype}"
            )
        if kinds != "U" and not np.isfinite(array).all():
            raise InputError(f"is damaged: {name} contains values that are not finite")
        if name in _POSITIVE and array.size and array.min() <= 0.0:
            raise InputError(f"is damaged: {name} must be above zero, got {array.min():.6g}")
    for name, letter in _NUMBERS_OF.items():
        array = arrays[name]
        if array.size and not 0 <= array.min() <= array.max() < sizes[letter]:
            raise InputError(f"is damaged: {name} must be from 0 to {sizes[letter] - 1}")
    if 3 * sizes["p"] + sizes["b"] > sizes["n"] or not sizes["p"]:
        raise InputError(f"is damaged: {sizes['p']} patches for {sizes['n']} degrees of freedom")
    mass = symmetric_matrix("mass", arrays["mass"])
    check_mass(mass)
    check_stiffness(symmetric_matrix("stiffness", arrays["stiffness"]), mass)
    for name, rows in NEWER.items():
        array = arrays.get(name, np.zeros((0, 3)))
        shapes = (0, 3), (len(arrays[rows]) + 3 * (rows == "mass"), 3)
        if array.dtype.kind not in "iuf" or array.shape not in shapes:
            raise InputError(f"is damaged: {name} has the shape {array.shape}")
        if not np.isfinite(array).all():
            raise InputError(f"is damaged: {name} contains values that are not finite")


def arrays_of(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of a joint as arrays by their names in a file."""
    arrays: dict[str, Any] = {"kind": np.array(FILE_KIND)}
    for name, value in values.items():
        if hasattr(value, "_asdict"):
            arrays |= {f"{name}_{part}": array for part, array in value._asdict().items()}
        else:
            arrays[name] = np.array(value, dtype=np.str_ if name == "sensor_names" else None)
    return arrays
