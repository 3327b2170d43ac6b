"""What is known of the rigs beforehand."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from microslip._core.checks import positive, show
from microslip._core.wording import did_you_mean
from microslip.errors import Argument, InputError
from microslip.identification.coordinates import RIG, Coordinate


def is_rigid(stiffness: Any) -> bool:
    """Whether what is said of a rig is that it does not give way."""
    if isinstance(stiffness, str):
        return stiffness.strip().casefold() == "rigid"
    if isinstance(stiffness, (int, float, np.number)):
        return float(stiffness) == math.inf
    return stiffness is None


def of_each_rig(option: Any, labels: Sequence[str], named: bool) -> dict[str, Any]:
    """What is said of each rig, by its label."""
    if not isinstance(option, Mapping):
        return dict.fromkeys(labels, option)
    have = ", ".join(show(label) for label in labels)
    if not named:
        raise InputError(
            Argument("rig_stiffness"),
            " must be one for all records, which have no rigs by name, got a table; "
            "name the rig of each record: rigs=[one label a record]",
        )
    by_label = {str(label): stiffness for label, stiffness in option.items()}
    for label in labels:
        if label not in by_label:
            raise InputError(f"rig_stiffness has nothing for rig {show(label)}; write 'free'")
    for label in by_label:
        if label not in labels:
            raise InputError(
                f"rig_stiffness: {show(label)} is the rig of no record; the rigs are {have}"
                f"{did_you_mean(label, labels)}"
            )
    return {label: by_label[label] for label in labels}


def rig_coordinate(coordinate: Coordinate, stiffness: Any) -> Coordinate:
    """The coordinate of a rig with what is known of its stiffness."""
    if isinstance(stiffness, str):
        if stiffness != "free":
            raise InputError(
                Argument("rig_stiffness"),
                " must be 'free', a stiffness [N/m], (value, uncertainty), or "
                f"'rigid', got {show(stiffness)}",
            )
        return coordinate
    if isinstance(stiffness, (tuple, list)):
        if len(stiffness) != 2:
            raise InputError(
                Argument("rig_stiffness"), f" must be (value, uncertainty), got {show(stiffness)}"
            )
        value = positive(RIG, stiffness[0], "N/m", 1e8)
        error = positive(f"uncertainty of {RIG}", stiffness[1], "N/m", 1e6)
        prior = (1.0 / value, error / value**2)
        return replace(coordinate, start=value, prior=prior, low=min(coordinate.low, 0.1 * value))
    value = positive(RIG, stiffness, "N/m", 1e8)
    return replace(coordinate, start=value, fixed=True, low=min(coordinate.low, value))
