"""Rigs in series with the joint: their stiffness, and the joint behind one."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from microslip._core.checks import Floats, positive, show
from microslip._core.wording import did_you_mean, plural
from microslip.errors import InputError
from microslip.identification.coordinates import RIG, Coordinate, limits_of, option_mapping
from microslip.identification.models.base import BackboneModel
from microslip.loops import Loop

FAR_SOFTER = 3.0
"""Ratio of the stiffness of loops to that of a rig which no noise and no delay explain."""

Answer = tuple[Floats, Floats, Floats, Floats]
"""Force, stiffness, derivatives by the law's parameters and by the compliance in series."""

_STEPS = 60
_NEAR, _THERE = 1e-5, 1e-8


def behind_spring(
    model: BackboneModel,
    y: Floats,
    values: Mapping[str, float],
    load: float | None,
    compliance: float,
    guess: Floats,
) -> tuple[Answer, Floats]:
    """Branch function behind a spring, v + c T0(v) = y, and v, of which ``guess`` was the last."""
    if compliance == 0.0:
        force, stiffness, by = model.branch(y, values, load)
        return (force, stiffness, by, -stiffness * force), guess
    v = guess if guess.size == y.size else np.zeros_like(y)
    scale = float(y.max())
    # The sum is concave and rising: after one step Newton's method climbs, never past it.
    for _ in range(_STEPS):
        force, stiffness = model.curve(v, values, load)
        new = v + (y - v - compliance * force) / (1.0 + compliance * stiffness)
        new = np.clip(new, 0.0, y)
        moved = float(np.max(np.abs(new - v)))
        v = new
        if moved <= _NEAR * scale:
            # The last of its steps with all derivatives; beyond a kink it is not the last.
            force, stiffness, by = model.branch(v, values, load)
            step = (y - v - compliance * force) / (1.0 + compliance * stiffness)
            if float(np.max(np.abs(step))) <= _THERE * scale:
                break
            v = np.clip(v + step, 0.0, y)
    else:
        force, stiffness, by = model.branch(v, values, load)
        step = np.zeros_like(v)
    force = force + stiffness * step
    share = 1.0 / (1.0 + compliance * stiffness)
    answer = force, stiffness * share, by * share, -stiffness * share * force
    return answer, np.clip(v + step, 0.0, y)


def is_rigid(stiffness: Any) -> bool:
    """Whether a rig is given as rigid."""
    if isinstance(stiffness, str):
        return stiffness.strip().casefold() == "rigid"
    if isinstance(stiffness, (int, float, np.number)):
        return float(stiffness) == math.inf
    return stiffness is None


def of_each_rig(option: Any, labels: Sequence[str], named: bool) -> dict[str, Any]:
    """The given stiffness of each rig, by its label."""
    if not isinstance(option, Mapping):
        return dict.fromkeys(labels, option)
    have = ", ".join(show(label) for label in labels)
    if not named:
        raise InputError(
            "`rig_stiffness` must be one for all records, which have no rigs by name, got a "
            "table; name the rig of each record: rigs=[one label a record]"
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
                "`rig_stiffness` must be 'free', a stiffness [N/m], (value, uncertainty), or "
                f"'rigid', got {show(stiffness)}"
            )
        return coordinate
    if isinstance(stiffness, (tuple, list)):
        if len(stiffness) != 2:
            raise InputError(f"`rig_stiffness` must be (value, uncertainty), got {show(stiffness)}")
        value = positive(RIG, stiffness[0], "N/m", 1e8)
        error = positive(f"uncertainty of {RIG}", stiffness[1], "N/m", 1e6)
        prior = (1.0 / value, error / value**2)
        return replace(coordinate, start=value, prior=prior, low=min(coordinate.low, 0.1 * value))
    value = positive(RIG, stiffness, "N/m", 1e8)
    return replace(coordinate, start=value, fixed=True, low=min(coordinate.low, value))


def stiffness_after_reversal(loop: Loop, share: float = 0.2) -> float:
    """Largest secant stiffness [N/m] over the first ``share`` of the force after a reversal."""
    x, force = loop.displacement[:-1], loop.force[:-1]
    span = float(np.ptp(force))
    best = 0.0
    for turn, sign in ((int(np.argmax(x)), -1.0), (int(np.argmin(x)), 1.0)):
        after = np.roll(x, -turn), np.roll(force, -turn)
        moved, gone = sign * (after[0] - after[0][0]), sign * (after[1] - after[1][0])
        far = np.flatnonzero((gone > share * span) & (moved > 0.0))
        if far.size:
            best = max(best, float(gone[far[0]] / moved[far[0]]))
    return best or 2.0 * span / float(np.ptp(x))


def rig_coordinates(
    stiffness: Any, rigs: Any, loops: Sequence[Loop], bounds: Any
) -> tuple[list[Coordinate], list[int | None]]:
    """Coordinates of the rigs' stiffnesses, and which of them each record has (from 0)."""
    if rigs is None:
        labels = ["rig"] * len(loops)
    else:
        if isinstance(rigs, np.ndarray):
            rigs = rigs.ravel().tolist()
        if isinstance(rigs, str) or not isinstance(rigs, Sequence) or len(rigs) != len(loops):
            raise InputError(
                f"`rigs` must hold a label for each of the {plural(len(loops), 'record')}, got "
                f"{show(rigs)}"
            )
        labels = [str(label) for label in rigs]
    rig_labels = list(dict.fromkeys(labels))
    given_stiffness = of_each_rig(stiffness, rig_labels, rigs is not None)
    place: dict[str, int] = {}
    coordinates: list[Coordinate] = []
    for label, own_stiffness in given_stiffness.items():
        if is_rigid(own_stiffness):
            continue
        place[label] = len(coordinates)
        rig_loops = [loops[i] for i in range(len(loops)) if labels[i] == label]
        scale = max(stiffness_after_reversal(loop) for loop in rig_loops)
        name = RIG if len(rig_labels) == 1 else f"{RIG} of {label}"
        low, high = 1e-3 * scale, math.inf
        limits = option_mapping("bounds", bounds).get(RIG)
        if limits is not None:
            low, high = limits_of(RIG, limits)
            positive(f"lowest {RIG}", low, "N/m")
        coordinate = Coordinate(name, RIG, "N/m", low, high, "inverse", 1.1 * scale, scale=scale)
        coordinates.append(rig_coordinate(coordinate, own_stiffness))
    return coordinates, [place.get(label) for label in labels]
