"""Coordinates of a fit: the law's parameters, the rig's stiffness and measured data."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from microslip._core.checks import Floats, number, show
from microslip._core.parameters import Parameter
from microslip.errors import InputError

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


def coordinate_of(parameter: Parameter, start: float, load: float | None = None) -> Coordinate:
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
