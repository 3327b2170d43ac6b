"""Floor 8: the kinds of value in a study file and the check of each one."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import AfterValidator, BeforeValidator

from microslip.study.units import AREA, DENSITY, FORCE, LENGTH, PRESSURE, Kind, Sign, to_si
from microslip.study.wording import did_you_mean, quoted, show

MAX_ITEMS = 1000
MAX_VALUES = 1_000_000


def quantity(kind: Kind, example: str, sign: Sign = "positive") -> BeforeValidator:
    """Text with a unit, such as `example`, into an SI float."""
    return BeforeValidator(lambda given: to_si(given, kind, example, sign))


def array(example: str, most: int = MAX_ITEMS, *, single: bool = False) -> BeforeValidator:
    """A list of 1 to `most` items; with `single`, one item may stand without brackets."""

    def check(given: object) -> object:
        if single and isinstance(given, (str, int, float)):
            return [given]
        if not isinstance(given, list) or not given:
            raise ValueError(f"wanted a list such as {example}, got {show(given)}")
        if len(given) > most:
            raise ValueError(f"wanted at most {most} items, got {len(given)}")
        return given

    return BeforeValidator(check)


def _all_different(given: tuple[float, ...]) -> tuple[float, ...]:
    seen: dict[float, int] = {}
    for index, value in enumerate(given, start=1):
        if value in seen:
            raise ValueError(
                f"wanted values that differ, got the same one as items {seen[value]} and {index}"
            )
        seen[value] = index
    return given


def number(wanted: str, low: float, high: float) -> BeforeValidator:
    """A finite plain number in (low, high]."""

    def check(given: object) -> float:
        if isinstance(given, (int, float)) and not isinstance(given, bool):
            try:
                value = float(given)
            except OverflowError:
                value = math.inf
            if low < value <= high and math.isfinite(value):
                return value
        raise ValueError(f"wanted {wanted}, got {show(given)}")

    return BeforeValidator(check)


def whole(wanted: str, low: int, high: int) -> BeforeValidator:
    """A whole number in [low, high]."""

    def check(given: object) -> int:
        if isinstance(given, bool) or not isinstance(given, int) or not low <= given <= high:
            raise ValueError(f"wanted {wanted}, got {show(given)}")
        return given

    return BeforeValidator(check)


def one_of(*words: str) -> BeforeValidator:
    """One of some words."""

    def check(given: object) -> object:
        if given not in words:
            hint = did_you_mean(given, words) if isinstance(given, str) else ""
            raise ValueError(f"wanted {quoted(words)}, got {show(given)}{hint}")
        return given

    return BeforeValidator(check)


def _line(given: object) -> str:
    if not isinstance(given, str) or not given.isprintable() or not 0 < len(given) <= 200:
        raise ValueError(f"wanted one line of at most 200 characters, got {show(given)}")
    return given


def _names(given: object) -> object:
    if not isinstance(given, list) or len(given) != 2 or not all(isinstance(n, str) for n in given):
        raise ValueError(
            f'wanted the names of the two bodies such as ["steel", "steel"], got {show(given)}'
        )
    return given


Line = Annotated[str, BeforeValidator(_line)]
TwoNames = Annotated[tuple[str, str], BeforeValidator(_names)]

Modulus = Annotated[float, quantity(PRESSURE, "69 GPa")]
Hardness = Annotated[float, quantity(PRESSURE, "1.2 GPa")]
PoissonRatio = Annotated[float, number("a number above -1 and at most 0.5", -1.0, 0.5)]
Friction = Annotated[float, number("a positive number such as 0.55", 0.0, 1e6)]

Roughness = Annotated[float, quantity(LENGTH, "0.5 um")]
Height = Annotated[float, quantity(LENGTH, "0.5 um", "any")]
Radius = Annotated[float, quantity(LENGTH, "1 mm")]
Density = Annotated[float, quantity(DENSITY, "100 1/mm^2")]
Area = Annotated[float, quantity(AREA, "2 cm^2")]
Load = Annotated[float, quantity(FORCE, "2 kN")]
AnyLoad = Annotated[float, quantity(FORCE, "2 kN", "any")]
Amplitude = Annotated[float, quantity(LENGTH, "1 um")]

Heights = Annotated[tuple[Height, ...], array('["0.4 um", "0.7 um"]', MAX_VALUES)]
Radii = Annotated[tuple[Radius, ...], array('["1 mm", "2 mm"]', MAX_VALUES, single=True)]
TabulatedLoads = Annotated[tuple[AnyLoad, ...], array('["2 kN", "1 kN", "0 N"]', MAX_VALUES)]
Loads = Annotated[
    tuple[Load, ...], array('["500 N", "2 kN"]', single=True), AfterValidator(_all_different)
]
Amplitudes = Annotated[
    tuple[Amplitude, ...], array('["0.1 um", "1 um"]'), AfterValidator(_all_different)
]
