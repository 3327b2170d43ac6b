"""Coordinates of a fit: parameters of the law at each load level, rigs in series, measured data."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from microslip._core.checks import Floats, number, positive, show
from microslip._core.errors import InputError
from microslip._core.wording import did_you_mean, plural
from microslip.friction.fit_parameters import FitParameter
from microslip.friction.loops import Loop
from microslip.identification.models.base import Model
from microslip.laboratory.folding import Folded

RIG = "rig_stiffness"
GAIN = "displacement_gain"
"""True factor on the measured displacement: all lengths of a law and its rig go with it."""
AREA, RADIUS, DENSITY = "contact_area", "radius", "density"
SUMMIT_DATA = (AREA, RADIUS, DENSITY)
"""Data that separate radius and density of summits, each a coordinate with its own error."""


Function = Callable[[Floats], tuple[float, Floats]]
"""A number and its derivatives by the free coordinates."""
_GAIN_REACH = 12.0  # standard deviations to which it is searched


@dataclass(frozen=True)
class Coordinate:
    """One number of a fit: a parameter of all records, or of those of one load or one rig.

    It is fitted as its logarithm, as it is, or (a stiffness in series, which may be infinite) as
    its inverse over a scale.
    """

    name: str
    """Name, with the load or the rig where there are several of them."""
    parameter: str
    """Name of the parameter as the law has it."""
    unit: str
    low: float
    high: float
    kind: str
    """"log", "linear" or "inverse"."""
    start: float
    fixed: bool = False
    prior: tuple[float, float] | None = None
    """Value and standard deviation from elsewhere; of an inverse one, of the inverse."""
    scale: float = 1.0
    load: float | None = None
    shape: bool = False
    """Whether it is a plain number that may be negative, such as a separation over sigma."""

    def inner(self, value: float) -> float:
        """The value as the fit sees it."""
        if self.kind == "log":
            return math.log(value)
        if self.kind == "inverse":
            return 0.0 if math.isinf(value) else self.scale / value
        return value / self.scale

    def outer(self, q: float) -> float:
        """The physical value."""
        if self.kind == "log":
            return math.exp(q)
        if self.kind == "inverse":
            return math.inf if q <= 0.0 else self.scale / q
        return q * self.scale

    def slope(self, q: float) -> float:
        """Derivative of the physical value by the fitted one; of an inverse one, of the inverse."""
        if self.kind == "log":
            return math.exp(q)
        if self.kind == "inverse":
            return 1.0 / self.scale
        return self.scale

    @property
    def limits(self) -> tuple[float, float]:
        """Bounds as the fit sees them, the lower one first."""
        ends = self.inner(self.low), self.inner(self.high)
        return min(ends), max(ends)


def coordinate_of(parameter: FitParameter, start: float, load: float | None = None) -> Coordinate:
    """The coordinate of a parameter of a law."""
    return Coordinate(
        name=parameter.name,
        parameter=parameter.name,
        unit=parameter.unit,
        low=parameter.low,
        high=parameter.high,
        kind="log" if parameter.is_log else "linear",
        start=min(max(start, parameter.low), parameter.high),
        load=load,
        shape=parameter.low < 0.0,
    )


def gain_coordinate(error: float) -> Coordinate:
    """The displacement's gain, of which a calibration knows the relative standard deviation."""
    reach = math.exp(_GAIN_REACH * error)
    return Coordinate(GAIN, GAIN, "", 1.0 / reach, reach, "log", 1.0, prior=(1.0, error))


def option_mapping(name: str, option: Any) -> dict[str, Any]:
    """An option by the names of parameters; empty without any."""
    if option is None:
        return {}
    if not isinstance(option, Mapping):
        raise InputError(
            f"`{name}` must be a dict by parameter names, such as {{'friction_coefficient': "
            f"0.5}}, got {show(option)}"
        )
    return dict(option)


def limits_of(key: str, limits: Any) -> tuple[float, float]:
    """Bounds of a parameter, the lower one first."""
    try:
        low, high = limits
    except (TypeError, ValueError):
        raise InputError(f"bounds of {key} must be (lowest, highest), got {show(limits)}") from None
    low, high = number(f"lowest {key}", low), number(f"highest {key}", high)
    if not low < high:
        raise InputError(f"bounds of {key} must be (lowest, highest), got ({low:g}, {high:g})")
    return low, high


@dataclass(frozen=True)
class Quantity:
    """A quantity that follows from the coordinates: its value, and derivatives by the free ones."""

    name: str
    unit: str
    load: float | None
    function: Function
    parent: str | None = None
    """The coordinate that it is at another load, whose verdict is its own."""
    shape: bool = False
    """Whether it is a plain number that may be negative, such as a separation over sigma."""


class Datum(NamedTuple):
    """A measured value of a coordinate, or of something that follows from them."""

    name: str
    unit: str
    value: float
    error: float
    function: Function
    coordinate: int | None = None
    """The coordinate that has it as its prior."""
    inverse: bool = False
    """Whether its errors are those of its inverse."""

    def residual(self, fitted: float) -> float:
        """Fitted value less the given one, in standard deviations."""
        if self.inverse:
            return (1.0 - self.value / fitted) * self.value / self.error
        return (fitted - self.value) / self.error


# -- rigs ------------------------------------------------------------------------------------------

FAR_SOFTER = 3.0
"""Ratio of the stiffness of loops to that of a rig which no noise and no delay explain."""

Answer = tuple[Floats, Floats, Floats, Floats]
"""Force, stiffness, derivatives by the law's parameters and by the compliance in series."""

_STEPS = 60
_NEAR, _THERE = 1e-5, 1e-8


def behind_spring(
    model: Model,
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


# -- load levels -----------------------------------------------------------------------------------

SAME_LOAD = 0.01
"""Loads that differ by no more than this share count as one."""
_DIGITS = 4
_CLOSE, _LARGEST = 1e-3, 4e-3
"""Shares of a load that came out of a channel which its name may leave out, by itself and by its
uncertainty; levels differ by more."""


def groups_of(values: Iterable[float]) -> list[list[float]]:
    """Rising values; those that differ from the first of a group by 1 % at most are in it."""
    groups: list[list[float]] = []
    for value in sorted(values):
        if groups and value <= groups[-1][0] * (1.0 + SAME_LOAD):
            groups[-1].append(value)
        else:
            groups.append([value])
    return groups


def levels_of(loads: Sequence[float | None]) -> list[int]:
    """Number of the load level of each record, from the lightest on; without a load the last."""
    groups = groups_of({load for load in loads if load is not None})
    level = {load: number for number, group in enumerate(groups) for load in group}
    return [len(groups) if load is None else level[load] for load in loads]


def labels_of(folded: Sequence[Folded], levels: Sequence[int]) -> dict[int, str]:
    """The load of each level [N], with as few digits as its uncertainty allows."""
    labels = {}
    for level in sorted(set(levels)):
        of_level = [folded[i] for i, number in enumerate(levels) if number == level]
        loads = [record.normal_load for record in of_level if record.normal_load is not None]
        if not loads:
            continue
        mean = float(np.mean(loads))
        error = max(record.load_error for record in of_level)
        room = min(max(3.0 * error, _CLOSE * abs(mean)), _LARGEST * abs(mean)) if error else 0.0
        texts = [f"{mean:.{digits}g}" for digits in range(1, _DIGITS + 1)]
        near = (text for text in texts if abs(float(text) - mean) <= room)
        labels[level] = f"{float(next(near, texts[-1])):g}"
    return labels
