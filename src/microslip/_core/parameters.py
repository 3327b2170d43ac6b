"""Parameters said once, on the class that has them: what is checked, fitted, read and explained.

A field of a frozen dataclass brings its symbol, unit, range and meaning as metadata::

    stiffness: float = field(metadata=parameter("k", "N/m", "stiffness at rest", above=0.0))

Checks when it is made, `guess`, the fit, the key of a study, its schema and the help follow.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from microslip._core.checks import LARGEST, SMALLEST, exact, number, record
from microslip._core.frozen import lock
from microslip.errors import InputError

_KEY = "microslip"
# Where a fit looks for a value above zero of a unit, unless the parameter says where.
_SEARCHED = {"N": (1e-12, 1e12), "N/m": (1e-6, 1e15), "m": (1e-13, 1e-1)}


@dataclass(frozen=True)
class Parameter:
    """One number of a law, of heights or of a surface."""

    name: str  # its name, as the class writes it
    symbol: str = ""  # its sign in formulas and tables, such as "k"
    unit: str = ""  # its SI unit, "" for none
    meaning: str = ""  # what it is, in a few words that begin small
    # What it may be: more than ``above``, at least ``least``, at most ``most``, less than
    # ``below``.
    above: float = -math.inf
    least: float = -math.inf
    most: float = math.inf
    below: float = math.inf
    search: tuple[float, float] | None = None
    """Between which values a fit looks; without it all that is allowed."""
    log: bool | None = None
    """Whether it is fitted as its logarithm; without it, whether zero lies below all it may be."""
    beyond: bool = False
    """Whether joints go on beyond ``search``, which only says how far is searched."""
    natural: bool = False
    """Whether its lower end is a value that joints have, so that a fit may well end there."""
    why: str = ""  # why it must be above ``above``, for the message
    default: float | None = None  # its value where none is given; None for one that has to be
    many: bool = False  # whether it is a list of such numbers
    example: float = 1.0  # a value in SI for a message that shows how to write one

    @property
    def is_positive(self) -> bool:
        """Whether it must be above zero."""
        return max(self.above, self.least) >= 0.0 and self.least != 0.0

    @property
    def is_log(self) -> bool:
        """Whether it is fitted as its logarithm."""
        return self.is_positive and self.unit != "" if self.log is None else self.log

    @property
    def low(self) -> float:
        """Lower end of the search."""
        return self._searched[0]

    @property
    def high(self) -> float:
        """Upper end of the search."""
        return self._searched[1]

    @property
    def _searched(self) -> tuple[float, float]:
        if self.search is not None:
            return self.search
        if self.is_positive and self.unit in _SEARCHED:
            low, high = _SEARCHED[self.unit]
        elif self.is_positive:
            low, high = 1e-6, 1e6 if self.unit == "" else 1e30
        else:
            low, high = -1e6, 1e6
        # Just inside a range that is open.
        step = 1e-6 * max(1.0, abs(self.above)) if math.isfinite(self.above) else 0.0
        low = max(low, self.least, self.above + step if not self.is_positive else low)
        last = 1e-6 * max(1.0, abs(self.below)) if math.isfinite(self.below) else 0.0
        return low, min(high, self.most, self.below - last)

    def checked(self, value: Any) -> Any:
        """The value as a float, of many as a locked array; or an error that says what may be."""
        if self.many:
            values = record(self.name, value).reshape(-1).copy()
            for end in (int(values.argmin()), int(values.argmax())):
                if expected := self._allowed_instead(float(values[end])):
                    worst = f"{exact(float(values[end]))} at index {end}"
                    raise InputError(f"`{self.name}` must be {expected}, got {worst}")
            return lock(values)
        result = number(self.name, value, self.unit, self.example)
        if expected := self._allowed_instead(result):
            raise InputError(f"`{self.name}` must be {expected}, got {exact(result)}")
        return result

    def _allowed_instead(self, value: float) -> str:
        """What would have been allowed in place of a value; nothing for one that is."""
        if not (self.above < value < self.below and self.least <= value <= self.most):
            return self.allowed + (f" ({self.why})" if self.why else "")
        if abs(value) > LARGEST or (self.is_positive and value < SMALLEST):
            if self.is_positive:
                return f"between {SMALLEST:g} and {LARGEST:g}{self._in_unit}"
            end = "at most " if value > 0.0 else "at least -"
            return f"{end}{LARGEST:g}{self._in_unit}"
        return ""

    @property
    def _in_unit(self) -> str:
        return f" [{self.unit}]" if self.unit else ""

    @property
    def allowed(self) -> str:
        """What it may be, in words: "above zero [N/m]", "in [0, 1)"."""
        in_unit = self._in_unit
        low, high = max(self.above, self.least), min(self.most, self.below)
        if math.isfinite(low) and math.isfinite(high):
            opening = "(" if self.above >= self.least else "["
            right = ")" if self.below <= self.most else "]"
            return f"in {opening}{low:g}, {high:g}{right}{in_unit}"
        if math.isfinite(low):
            if self.above >= self.least:
                return f"above {'zero' if low == 0.0 else f'{low:g}'}{in_unit}"
            return f"at least {low:g}{in_unit}" if low else f"zero or more{in_unit}"
        if math.isfinite(high):
            word = "below" if self.below <= self.most else "at most"
            return f"{word} {high:g}{in_unit}"
        return f"a finite number{in_unit}"

    @property
    def dimension(self) -> tuple[int, int] | None:
        """Powers of newton and metre in its unit; None where there is something else in it."""
        return dimension_of(self.unit)


def parameter(
    symbol: str = "", unit: str = "", meaning: str = "", **settings: Any
) -> dict[str, Any]:
    """Metadata of a field, ``field(metadata=parameter(...))``; see :class:`Parameter`."""
    # Checked at once, so that a mistake shows where the class is written.
    return {_KEY: Parameter("", symbol, unit, meaning, **settings)}


def parameters_of(kind: type) -> tuple[Parameter, ...]:
    """The parameters of a class, in the order in which it takes them; none if it says none."""
    return _parameters_of(kind)


@lru_cache(maxsize=256)
def _parameters_of(kind: Any) -> tuple[Parameter, ...]:
    if not dataclasses.is_dataclass(kind):
        return ()
    parameters = []
    for item in dataclasses.fields(kind):
        stated = item.metadata.get(_KEY, _USUAL.get(item.name))
        if isinstance(stated, Parameter) and item.init:
            default = None if item.default is dataclasses.MISSING else item.default
            parameters.append(dataclasses.replace(stated, name=item.name, default=default))
    return tuple(parameters)


# Fields of these names need no words of their own.
_USUAL = {
    "stiffness": Parameter("stiffness", "k", "N/m", "stiffness at rest", above=0.0),
    "force_limit": Parameter("force_limit", "F", "N", "force of gross slip", above=0.0),
}


def says_all(kind: type) -> bool:
    """Whether the parameters of a class are all that it takes."""
    if not dataclasses.is_dataclass(kind):
        return False
    names = {item.name for item in dataclasses.fields(kind) if item.init}
    return bool(names) and names == {item.name for item in parameters_of(kind)}


class Parametric:
    """A frozen dataclass whose numbers are checked when it is made, by what their fields say."""

    key: ClassVar[str] = ""
    """Its name in studies and commands; without it that of the class in small letters."""

    def __post_init__(self) -> None:
        self._check_parameters()

    def _check_parameters(self) -> None:
        for item in parameters_of(type(self)):
            object.__setattr__(self, item.name, item.checked(getattr(self, item.name)))


def key_of(kind: type) -> str:
    """Name of a class in studies and commands: "smooth-step" for ``SmoothStep``."""
    stated: str = vars(kind).get("key", "")
    return stated or re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "-", kind.__name__).lower()


def values_of(item: Any) -> dict[str, Any]:
    """Values of all parameters of an instance, by their names."""
    return {entry.name: getattr(item, entry.name) for entry in parameters_of(type(item))}


def dimension_of(unit: str) -> tuple[int, int] | None:
    """Powers of newton and metre in an SI unit such as "N/m^2"; None for another one."""
    above, _, under = unit.partition("/")
    powers = {"N": 0, "m": 0}
    for part, sign in ((above, 1), (under, -1)):
        for word in part.replace("*", " ").split():
            base, _, power = word.partition("^")
            if base in ("1", "rad"):
                continue
            if base not in powers or not re.fullmatch(r"-?\d*", power):
                return None
            powers[base] += sign * int(power or 1)
    return powers["N"], powers["m"]


def rescaled(kind: type, values: Mapping[str, Any], force: float, length: float) -> dict[str, Any]:
    """Values of a class in units of force [N] and length [m] that are so many times as large."""
    result = {}
    for item in parameters_of(kind):
        dimension = item.dimension
        if dimension is None:
            raise InputError(
                f"{kind.__name__}.{item.name} must have a unit of newtons and metres to be "
                f"scaled, got {item.unit!r}"
            )
        factor = force ** dimension[0] * length ** dimension[1]
        result[item.name] = (
            np.asarray(values[item.name]) * factor if item.many else (values[item.name] * factor)
        )
    return result
