"""States as plain arrays: their format and their joint, and whether they are whole."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, without_unit
from microslip._core.errors import InputError

FORMAT = 1.0
"""First number of ``joint``; arrays of before have none."""
_TOLERANCE = 1e-9  # relative: what another machine makes of the same joint


def saved_array(arrays: Mapping[str, ArrayLike], key: str, *shape: int) -> Floats:
    """One of the arrays that a state was saved in, finite and of a shape; -1 is any length."""
    try:
        array = np.array(without_unit(key, arrays[key], ""), dtype=float)
    except (KeyError, TypeError, ValueError, IndexError):
        raise InputError(f"arrays must hold {key!r}, as to_arrays() of a state gives it") from None
    right = len(array.shape) == len(shape) and all(
        length in (-1, came) for length, came in zip(shape, array.shape, strict=True)
    )
    if not right or not np.all(np.isfinite(array)):
        text = ", ".join("n" if n < 0 else str(n) for n in shape) + "," * (len(shape) == 1)
        raise InputError(
            f"arrays must hold finite {key!r} of shape ({text}), got shape {array.shape}"
        )
    return array


def newer_array(arrays: Mapping[str, ArrayLike], key: str, *shape: int) -> Floats:
    """An array that states of before were saved without, which is an empty one then."""
    # Of what is no mapping "in" may search for ever; which arrays it lacks is said elsewhere.
    if isinstance(arrays, Mapping) and key in arrays:
        return saved_array(arrays, key, *shape)
    return np.zeros((0,) * len(shape))


def joint_array(*numbers: Floats) -> Floats:
    """The format and what a joint is known by, as one array."""
    return np.concatenate(([FORMAT], *numbers))


def check_joint(arrays: Mapping[str, ArrayLike], joint: Floats) -> None:
    """Refuse arrays of a later format or of another joint; those of before say neither."""
    saved = newer_array(arrays, "joint", -1)
    if not saved.size:
        return
    if saved[0] != FORMAT:
        raise InputError(
            f"arrays must be of format {FORMAT:g}, got {saved[0]:g}: a later version wrote it"
        )
    fits = saved.shape == joint.shape
    if not fits or not np.all(np.abs(saved - joint) <= _TOLERANCE * np.abs(joint)):
        raise InputError("arrays must be those of a state of this joint, got those of another one")


def check_whole(computed: Floats, saved: Floats, scale: float, message: str) -> None:
    """Refuse arrays in which numbers do not follow from each other."""
    if computed.shape != saved.shape or not np.all(np.abs(computed - saved) <= _TOLERANCE * scale):
        raise InputError(f"arrays must be those of a state: its {message}")
