"""Saved states: format, identity of the joint and consistency checks."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, without_unit
from microslip._core.errors import InputError

STATE_FORMAT = 1.0
"""First number of ``joint``; arrays of earlier versions have none."""
_TOLERANCE = 1e-9  # relative difference of the same joint on another machine


def saved_array(arrays: Mapping[str, ArrayLike], key: str, *shape: int) -> Floats:
    """Return an array of a saved state, checked to be finite with ``shape`` (-1: any length)."""
    try:
        array = np.array(without_unit(key, arrays[key], ""), dtype=float)
    except (KeyError, TypeError, ValueError, IndexError):
        raise InputError(f"`arrays` must hold {key!r}, as returned by to_arrays()") from None
    right = len(array.shape) == len(shape) and all(
        length in (-1, came) for length, came in zip(shape, array.shape, strict=True)
    )
    if not right or not np.all(np.isfinite(array)):
        text = ", ".join("n" if n < 0 else str(n) for n in shape) + "," * (len(shape) == 1)
        raise InputError(
            f"`arrays` must hold finite {key!r} of shape ({text}), got shape {array.shape}"
        )
    return array


def optional_array(arrays: Mapping[str, ArrayLike], key: str, *shape: int) -> Floats:
    """Return an array of a saved state, empty if an earlier version did not save it."""
    # For other types than mappings "in" may not terminate; saved_array raises the error.
    if isinstance(arrays, Mapping) and key in arrays:
        return saved_array(arrays, key, *shape)
    return np.zeros((0,) * len(shape))


def joint_array(*numbers: Floats) -> Floats:
    """Concatenate the format number and numbers that identify a joint."""
    return np.concatenate(([STATE_FORMAT], *numbers))


def check_joint(arrays: Mapping[str, ArrayLike], joint: Floats) -> None:
    """Raise InputError if arrays are of a later format or were saved from another joint."""
    saved = optional_array(arrays, "joint", -1)
    if not saved.size:
        return
    if saved[0] != STATE_FORMAT:
        raise InputError(
            f"`arrays` must be of format {STATE_FORMAT:g}, got {saved[0]:g} of a later version"
        )
    fits = saved.shape == joint.shape
    if not fits or not np.all(np.abs(saved - joint) <= _TOLERANCE * np.abs(joint)):
        raise InputError("`arrays` must be saved from this joint, got those of another joint")


def check_consistent(computed: Floats, saved: Floats, scale: float, message: str) -> None:
    """Raise InputError if saved and computed numbers differ by over 1e-9 of ``scale``."""
    if computed.shape != saved.shape or not np.all(np.abs(computed - saved) <= _TOLERANCE * scale):
        raise InputError(f"`arrays` must be those of a state: its {message}")
