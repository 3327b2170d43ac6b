"""Floor 8: the kinds of value in a study file and the check of each one."""

from __future__ import annotations

import math
import operator
from typing import Annotated, TypeVar

from pydantic import AfterValidator

from microslip._core import units
from microslip._core.parameters import option
from microslip._core.units import PER_LENGTH, SPECTRAL_DENSITY, Kind, Sign, to_si
from microslip._core.wording import did_you_mean, quoted, show
from microslip.study.columns import FromFile, text
from microslip.study.part import Check, JsonSchema
from microslip.study.uncertain import Uncertain

MAX_ITEMS = 1000
MAX_VALUES = 1_000_000

T = TypeVar("T")


def quantity(kind: Kind, example: str, sign: Sign = "positive") -> Check:
    """Text with a unit, such as `example`, into an SI float."""
    return Check(
        lambda raw_value: to_si(raw_value, kind, example, sign),
        lambda _: option("", "", kind, example=example, sign=sign).item_schema(),
    )


def angle(example: str) -> Check:
    """Text with a unit of angle, such as `example`, into radians; a turn at most."""

    def check(raw_value: object) -> float:
        value = to_si(raw_value, units.ANGLE, example, "any")
        if abs(value) > 2.0 * math.pi:
            message = f'wanted an angle such as "{example}", got {show(raw_value)}'
            raise ValueError(f"{message} (more than a turn)")
        return value

    described = option("", "", units.ANGLE, example=example, sign="any")
    return Check(check, lambda _: described.item_schema())


def array(
    example: str, max_items: int = MAX_ITEMS, *, single: bool = False, min_items: int = 1
) -> Check:
    """A list of `min_items` to `max_items` items; with `single`, one may stand without brackets."""

    def check(raw_value: object) -> object:
        if single and isinstance(raw_value, (str, int, float, dict)):
            return [raw_value]
        if not isinstance(raw_value, (list, tuple)) or not raw_value:
            raise ValueError(f"wanted a list such as {example}, got {show(raw_value)}")
        if len(raw_value) > max_items:
            raise ValueError(f"wanted at most {max_items} items, got {len(raw_value)}")
        if len(raw_value) < min_items:
            raise ValueError(f"wanted {min_items} items such as {example}, got {len(raw_value)}")
        return raw_value

    def describe(inner: JsonSchema) -> JsonSchema:
        schema = {
            "type": "array",
            "items": inner["items"],
            "minItems": min_items,
            "maxItems": max_items,
        }
        return {"anyOf": [inner["items"], schema]} if single else schema

    return Check(check, describe)


def different(items: tuple[T, ...]) -> tuple[T, ...]:
    """Items no two of which are equal."""
    places: dict[T, int] = {}
    for index, value in enumerate(items, start=1):
        if value in places:
            raise ValueError(
                f"wanted values that differ, got the same one as items {places[value]} and {index}"
            )
        places[value] = index
    return items


_BOUNDS = {
    "minimum": operator.ge, "maximum": operator.le,
    "exclusiveMinimum": operator.gt, "exclusiveMaximum": operator.lt,
}  # fmt: skip


def number(description: str, **bounds: float) -> Check:
    """A finite plain number within bounds, by their names in JSON Schema."""

    def check(raw_value: object) -> float:
        if isinstance(raw_value, (int, float)) and not isinstance(raw_value, bool):
            try:
                value = float(raw_value)
            except OverflowError:
                value = math.inf
            if math.isfinite(value) and all(_BOUNDS[n](value, x) for n, x in bounds.items()):
                return value
        raise ValueError(f"wanted {description}, got {show(raw_value)}")

    return Check(check, lambda _: {"type": "number", **bounds})


def integer(low: int, high: int, example: int | None = None, *, words: str = "") -> Check:
    """A whole number in [low, high]; ``words`` say what it is, where that is more."""
    such_as = "" if example is None else f", such as {example}"
    description = words or f"a whole number from {low} to {high}{such_as}"

    def check(raw_value: object) -> int:
        if type(raw_value) is not int or not low <= raw_value <= high:
            raise ValueError(f"wanted {description}, got {show(raw_value)}")
        return raw_value

    return Check(check, lambda _: {"type": "integer", "minimum": low, "maximum": high})


def one_of(*words: str) -> Check:
    """One of some words."""

    def check(raw_value: object) -> object:
        if raw_value not in words:
            hint = did_you_mean(raw_value, words) if isinstance(raw_value, str) else ""
            raise ValueError(f"wanted {quoted(words)}, got {show(raw_value)}{hint}")
        return raw_value

    return Check(check, lambda _: {"type": "string", "enum": list(words)})


def _yes_or_no(raw_value: object) -> bool:
    if not isinstance(raw_value, bool):
        raise ValueError(f"wanted true or false, got {show(raw_value)}")
    return raw_value


def _names(raw_value: object) -> object:
    if (
        not isinstance(raw_value, (list, tuple))
        or len(raw_value) != 2
        or not all(isinstance(n, str) for n in raw_value)
    ):
        raise ValueError(
            f'wanted the names of the two bodies such as ["steel", "steel"], got {show(raw_value)}'
        )
    return raw_value


Line = Annotated[str, text("one line of at most 200 characters", 200)]
YesOrNo = Annotated[bool, Check(_yes_or_no, lambda _: {"type": "boolean"})]
TwoNames = Annotated[
    tuple[str, str],
    Check(
        _names,
        lambda _: {"type": "array", "items": {"type": "string"}, "minItems": 2, "maxItems": 2},
    ),
]

Modulus = Annotated[float, quantity(units.PRESSURE, "69 GPa"), Uncertain('"69 GPa"')]
Hardness = Annotated[float, quantity(units.HARDNESS, "1.2 GPa"), Uncertain('"1.2 GPa"')]
YieldStress = Annotated[float, quantity(units.PRESSURE, "355 MPa"), Uncertain('"355 MPa"')]
PoissonRatio = Annotated[
    float,
    number("a number above -1 and at most 0.5", exclusiveMinimum=-1, maximum=0.5),
    Uncertain("0.33"),
]
Friction = Annotated[
    float, number("a positive number such as 0.55", exclusiveMinimum=0, maximum=1e6)
]
UncertainFriction = Annotated[Friction, Uncertain("0.55")]
ViscousRatio = Annotated[
    float,
    number("a number from 0 to below 1 such as 0.01", minimum=0, exclusiveMaximum=1),
    Uncertain("0.01"),
]
Share = Annotated[
    float,
    number("a number above 0 and at most 1 such as 0.2", exclusiveMinimum=0, maximum=1),
]
LoadShare = Annotated[Share, Uncertain("0.2")]
ShapeParameter = Annotated[float, number("a finite number")]

Roughness = Annotated[float, quantity(units.LENGTH, "0.5 um"), Uncertain('"0.5 um"')]
Height = Annotated[float, quantity(units.LENGTH, "0.5 um", "any")]
Radius = Annotated[float, quantity(units.LENGTH, "1 mm")]
Density = Annotated[float, quantity(units.DENSITY, "100 1/mm^2")]
Area = Annotated[float, quantity(units.AREA, "2 cm^2")]
Load = Annotated[float, quantity(units.FORCE, "2 kN")]
UncertainLoad = Annotated[Load, Uncertain('"2 kN"')]
AnyLoad = Annotated[float, quantity(units.FORCE, "2 kN", "any")]
Amplitude = Annotated[float, quantity(units.LENGTH, "1 um")]
ForceAmplitude = Annotated[float, quantity(units.FORCE, "100 N")]
Phase = Annotated[float, angle("90 deg"), Uncertain('"90 deg"')]
Mass = Annotated[float, quantity(units.MASS, "2 kg"), Uncertain('"2 kg"')]
Stiffness = Annotated[float, quantity(units.STIFFNESS, "1e6 N/m"), Uncertain('"1e6 N/m"')]

Heights = Annotated[
    tuple[Height, ...],
    array('["0.4 um", "0.7 um"]', MAX_VALUES),
    FromFile(units.LENGTH, "surface.heights"),
]
Radii = Annotated[
    tuple[Radius, ...],
    array('["1 mm", "2 mm"]', MAX_VALUES, single=True),
    FromFile(units.LENGTH, "surface.radius", "positive"),
]
Separations = Annotated[
    tuple[Height, ...],
    array('["0 um", "1 um", "2 um"]', MAX_VALUES),
    FromFile(units.LENGTH, "surface.separation"),
]
TabulatedLoads = Annotated[
    tuple[AnyLoad, ...],
    array('["2 kN", "0.5 kN", "0 N"]', MAX_VALUES),
    FromFile(units.FORCE, "surface.load"),
]
Wavenumbers = Annotated[
    tuple[Annotated[float, quantity(PER_LENGTH, "10 1/mm")], ...],
    array('["10 1/mm", "100 1/mm", "1000 1/mm"]', MAX_VALUES),
    FromFile(PER_LENGTH, "surface.wavenumber", "positive"),
]
SpectralDensities = Annotated[
    tuple[Annotated[float, quantity(SPECTRAL_DENSITY, "10 um^4", "any")], ...],
    array('["10 um^4", "2 um^4", "0.003 um^4"]', MAX_VALUES),
    FromFile(SPECTRAL_DENSITY, "surface.spectrum"),
]
TabulatedDensity = Annotated[
    tuple[Annotated[float, quantity(PER_LENGTH, "0.5 1/um", "any")], ...],
    array('["0 1/um", "0.5 1/um", "0 1/um"]', MAX_VALUES),
    FromFile(PER_LENGTH, "surface.heights.density"),
]
RisingHeights = Annotated[
    tuple[Height, ...],
    array('["-1 um", "0 um", "1 um"]', MAX_VALUES),
    FromFile(units.LENGTH, "surface.heights.height"),
]
Loads = Annotated[
    tuple[UncertainLoad, ...], array('["500 N", "2 kN"]', single=True), AfterValidator(different)
]
Amplitudes = Annotated[
    tuple[Annotated[Amplitude, Uncertain('"1 um"')], ...],
    array('["0.1 um", "1 um"]'),
    AfterValidator(different),
]
ForceAmplitudes = Annotated[
    tuple[Annotated[ForceAmplitude, Uncertain('"100 N"')], ...],
    array('["50 N", "200 N"]'),
    AfterValidator(different),
]
