"""Uncertain quantities, in one notation for every key."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip._core.parameters import JsonSchema
from microslip._core.units import engineering
from microslip._core.wording import did_you_mean, quote, quoted
from microslip.study.part import Part
from microslip.study.readers import KeyedError, Place, Plain

_FORMS = (
    ("low", "high"), ("low", "high", "distribution"), ("mean", "cv"),
    ("mean", "cv", "distribution"), ("values",),
)  # fmt: skip
_KINDS = ("lognormal", "normal")
_RANGES = ("uniform", "log-uniform")
_MOST_VALUES = 100_000
_MOST_LIST = 1000  # items; longer lists are data
_LOST = 1e-3
"""Share of a normal distribution that may lie outside what is possible, and is cut off."""


class Spread(float):
    """A number with its scatter: as a float it is its middle.

    Between ``low`` and ``high`` every value is as likely as any other, or every logarithm.
    With ``mean`` and the coefficient of variation ``cv`` it is lognormal, so that it keeps its
    sign, or normal and cut off at zero. Of ``values`` each is as likely as any other.
    """

    low: float | None = None
    high: float | None = None
    cv: float | None = None
    normal: bool = False
    log: bool = False
    """Whether the logarithm is uniform between low and high."""
    values: tuple[float, ...] = ()
    of: str | None = None
    """Key of the number that it follows, and by which factor."""
    factor: float = 1.0
    unit: str = ""

    @classmethod
    def between(cls, low: float, high: float, log: bool = False) -> Spread:
        """Anything from low to high, uniform or log-uniform."""
        value = cls(math.sqrt(low * high) if log else 0.5 * (low + high))
        value.low, value.high, value.log = low, high, log
        return value

    @classmethod
    def about(cls, mean: float, cv: float, normal: bool = False) -> Spread:
        """About a mean, by a coefficient of variation."""
        value = cls(mean)
        value.cv, value.normal = cv, normal
        return value

    @classmethod
    def among(cls, values: Sequence[float]) -> Spread:
        """Return a spread over given values; the middle is their mean."""
        value = cls(sum(values) / len(values))
        value.values = tuple(sorted(values))
        return value

    def following(self, key: str, factor: float) -> Spread:
        """A number that is always so many times this one, which stands at a key."""
        value = type(self)(factor * float(self))
        value.of, value.factor, value.unit = key, factor, self.unit
        return value

    def quantiles(self, shares: Floats) -> Floats:
        """Values below which shares of it lie."""
        if self.values:
            places = np.minimum((shares * len(self.values)).astype(int), len(self.values) - 1)
            return np.asarray(np.array(self.values)[places])
        if self.low is not None and self.high is not None:
            if self.log:
                return np.asarray(self.low * (self.high / self.low) ** shares)
            return np.asarray(self.low + (self.high - self.low) * shares)
        from scipy.special import ndtr, ndtri

        cv = float(self.cv or 0.0)
        if self.normal:
            lost = float(ndtr(-1.0 / cv))  # below zero: cut off, and the rest takes its place
            return np.asarray(float(self) * (1.0 + cv * ndtri(lost + (1.0 - lost) * shares)))
        width = math.log1p(cv**2)
        return np.asarray(float(self) * np.exp(math.sqrt(width) * ndtri(shares) - 0.5 * width))

    def measure(self, value: float) -> float:
        """A value in the number's own measure: its logarithm where that is what is normal."""
        return math.log(value) if self.log or (self.cv is not None and not self.normal) else value

    @property
    def deviation(self) -> float:
        """Standard deviation of the spread, of the logarithm if it is log-distributed."""
        if self.values:
            return float(np.std(self.values))
        if self.low is not None and self.high is not None:
            width = math.log(self.high / self.low) if self.log else self.high - self.low
            return width / math.sqrt(12.0)
        cv = float(self.cv or 0.0)
        return cv * float(self) if self.normal else math.sqrt(math.log1p(cv**2))

    def _text(self, value: float | None) -> str:
        if not self.unit or "^" in self.unit:  # prefixes would be of the power
            return f"{value:g} {self.unit}".rstrip()
        return engineering(value, self.unit, 6, trim=True)

    @property
    def written(self) -> str:
        """Description of the spread in words."""
        if self.values:
            low, high = map(self._text, (self.values[0], self.values[-1]))
            return f"one of {len(self.values)} values, {low} to {high}"
        if self.cv is None:
            return f"{self._text(self.low)} to {self._text(self.high)}{', log-uniform' * self.log}"
        kind = "; normal, cut off at zero" if self.normal else ""
        return f"{self._text(float(self))} with a coefficient of variation of {self.cv:g}{kind}"


class Unsure(Plain):
    """A declared number, in whose place a table ``{ low, high }`` or ``{ mean, cv }`` may stand."""

    def read(self, raw_value: object, place: Place) -> Any:
        """The number, or its :class:`Spread`."""
        if isinstance(raw_value, Spread):
            return raw_value
        if isinstance(raw_value, Followed):
            value = self.read(raw_value.source, place)
            if isinstance(value, Spread):
                return value.following(raw_value.key, raw_value.factor)
            return raw_value.factor * value
        if not isinstance(raw_value, dict):
            return super().read(raw_value, place)
        for form in _FORMS:
            if set(raw_value) == set(form):
                spread = self._spread(raw_value)
                spread.unit = self.declared.unit or ""
                return spread
        odd = next((key for key in raw_value if key not in _MEANINGS), None)
        hint = did_you_mean(str(odd), _MEANINGS) if odd is not None else ""
        raise ValueError(
            f"wanted a value such as {self.example}, {{ low = …, high = … }}, "
            f'{{ mean = …, cv = … }}, {{ values = [ … ] }} or {{ of = "key", factor = … }}, '
            f"got a table with {quoted(map(str, raw_value), 'and')}{hint}"
            if raw_value
            else f"wanted a value such as {self.example}, got an empty table"
        )

    def _spread(self, table: dict[str, object]) -> Spread:
        inner = self.declared.read
        if "values" in table:
            values = table["values"]
            if not isinstance(values, list) or not 2 <= len(values) <= _MOST_VALUES:
                raise ValueError(f"wanted two values or more in a list, got {quote(values)}")
            return Spread.among([inner(value) for value in values])
        if "mean" in table:
            return self._about(table)
        low, high = inner(table["low"]), inner(table["high"])
        if not low < high:
            raise ValueError(f"wanted low below high, got {quote(table['low'])} and "
                             f"{quote(table['high'])}")  # fmt: skip
        kind = table.get("distribution", _RANGES[0])
        if kind not in _RANGES:
            raise ValueError(f"wanted distribution {quoted(_RANGES)}, got {quote(kind)}")
        if kind == _RANGES[1] and not low > 0.0:
            raise ValueError(f"wanted low above zero for log-uniform, got {quote(table['low'])}")
        return Spread.between(low, high, kind == _RANGES[1])

    def _about(self, table: dict[str, object]) -> Spread:
        cv, kind = table["cv"], table.get("distribution", _KINDS[0])
        plain = isinstance(cv, (int, float)) and not isinstance(cv, bool)
        if not plain or not 0.0 < float(cv) <= 1.0:  # type: ignore[arg-type]
            raise ValueError(f"wanted cv above 0 and at most 1, such as 0.15, got {quote(cv)}")
        if kind not in _KINDS:
            raise ValueError(f"wanted distribution {quoted(_KINDS)}, got {quote(kind)}")
        from scipy.special import ndtr

        lost = float(ndtr(-1.0 / float(cv)))  # type: ignore[arg-type]
        if kind == "normal" and lost > _LOST:
            raise ValueError(
                f"wanted a cv of at most 0.32 for a normal distribution, got {quote(cv)}: "
                f"{lost:.2g} of it would lie below zero; leave distribution out, and it is "
                "lognormal"
            )
        mean = self.declared.read(table["mean"])
        if mean == 0.0:
            raise ValueError("wanted a mean other than zero, of which cv is a share; write low and "
                             "high")  # fmt: skip
        return Spread.about(mean, float(cv), kind == "normal")  # type: ignore[arg-type]

    def schema(self) -> JsonSchema:
        """The JSON Schema of what may stand here."""
        inner = super().schema()
        plain = {name: value for name, value in inner.items() if name != "description"}
        types = {
            "low": plain, "high": plain, "mean": plain,
            "cv": {"type": "number", "exclusiveMinimum": 0, "maximum": 1},
            "values": {"type": "array", "items": plain, "minItems": 2},
            "distribution": {"enum": list(_KINDS)},
            "range": {"enum": list(_RANGES)},
            "of": {"type": "string", "examples": ["joint.normal_load"]},
            "factor": {"type": "number", "exclusiveMinimum": 0, "examples": [2.0]},
        }  # fmt: skip
        tables = [
            {
                "type": "object",
                "properties": {
                    key: {
                        **types["range" if key == "distribution" and "low" in form else key],
                        "title": key.capitalize(),
                        "description": _MEANINGS[key],
                    }
                    for key in form
                },
                "required": [key for key in form if key not in ("distribution", "factor")],
                "additionalProperties": False,
            }
            for form in (_FORMS[1], _FORMS[3], _FORMS[4], ("of", "factor"))
        ]
        return {"anyOf": [inner, *tables]}


_MEANINGS = {
    "low": "The smallest possible value.",
    "high": "The largest possible value.",
    "mean": "The expected value.",
    "cv": "Its standard deviation over the mean.",
    "values": "Each as likely as any other.",
    "distribution": "Of low and high: uniform unless given, or log-uniform. Of a mean: lognormal "
    "unless given; a normal one is cut off at zero.",
    "of": "Key of another quantity, which this one follows.",
    "factor": "How many times the other one it is.",
}


class Followed(NamedTuple):
    """Stand-in of a quantity that follows another: its key, its place, and a factor."""

    key: str
    source: object
    factor: float


def with_followers(tables: dict[str, Any]) -> dict[str, Any]:
    """The tables of a study; what stands at the other key in place of ``{ of, factor }``."""

    def follower(table: object) -> bool:
        return isinstance(table, dict) and "of" in table and table.keys() <= {"of", "factor"}

    def followed(table: dict[str, Any], where: str, passed: tuple[str, ...]) -> Followed:
        key, factor = table["of"], table.get("factor", 1.0)
        plain = isinstance(factor, (int, float)) and not isinstance(factor, bool)
        if not plain or not 0.0 < factor < math.inf:
            raise KeyedError(where, f"wanted a factor above zero such as 2.0, got {quote(factor)}")
        if key in passed:
            circle = " -> ".join((*passed[passed.index(key) :], key))
            raise KeyedError(where, f"wanted the key of a number, got keys in a circle, {circle}")
        source: Any = tables
        for name in key.split(".") if isinstance(key, str) else ():
            source = source.get(name) if isinstance(source, dict) else None
        if source is None or isinstance(source, list):
            raise KeyedError(
                where, f'wanted of = "the key of one number of this study", got {quote(key)}'
            )
        if follower(source):
            first = followed(source, where, (*passed, key))
            return first._replace(factor=first.factor * factor)
        return Followed(key, source, float(factor))

    def walked(part: Any, path: str) -> Any:
        if follower(part):
            return followed(part, path, (path,))
        if isinstance(part, dict):
            return {k: walked(v, f"{path}.{k}" if path else str(k)) for k, v in part.items()}
        if isinstance(part, list) and len(part) <= _MOST_LIST:
            return [walked(value, path) for value in part]
        return part

    return walked(tables, "")  # type: ignore[no-any-return]


def spreads_of(part: object) -> Iterator[tuple[str, Spread]]:
    """Quantities of a table and of those that it holds that are uncertain by themselves, by key."""
    return ((key, spread) for key, spread in _all_spreads(part, "") if spread.of is None)


def followers_of(part: object) -> set[str]:
    """Keys of what follows something uncertain."""
    return {key for key, spread in _all_spreads(part, "") if spread.of is not None}


def _all_spreads(part: object, path: str) -> Iterator[tuple[str, Spread]]:
    if isinstance(part, Spread):
        yield path, part
    for _, key, value in _entries(part, path):
        yield from _all_spreads(value, key)


def _entries(part: Any, path: str) -> Iterator[tuple[Any, str, Any]]:
    """Names, keys of the file and values in a table, or in a list with something uncertain."""
    if isinstance(part, Part):
        for key, name in part.attributes.items():
            yield name, f"{path}.{key}" if path else key, getattr(part, name)
    elif isinstance(part, dict):
        for key, value in part.items():
            yield key, f"{path}.{key}", value
    elif isinstance(part, tuple) and any(isinstance(value, (Spread, Part)) for value in part):
        for index, value in enumerate(part, start=1):
            yield index, path if len(part) == 1 else f"{path}, item {index}", value


def with_values(part: Any, values: Mapping[str, float], path: str = "") -> Any:
    """The same table with plain numbers in place of what is uncertain, by the keys of the file."""
    if isinstance(part, Spread):
        if part.of is not None:
            return part.factor * values.get(part.of, float(part) / part.factor)
        return float(values.get(path, float(part)))
    copy = changed(part, lambda value, key: with_values(value, values, key), path)
    if copy is not part and hasattr(copy, "settle"):  # what follows from keys, from what was drawn
        copy.settle()
    return copy


def changed(part: Any, change: Callable[[Any, str], Any], path: str = "") -> Any:
    """The same table with each value that it holds changed, given its key; itself if none is."""
    before = {name: (value, key) for name, key, value in _entries(part, path)}
    after = {name: change(value, key) for name, (value, key) in before.items()}
    changes = {name: new for name, new in after.items() if new is not before[name][0]}
    if not changes:
        return part
    if isinstance(part, Part):
        return part.copy(**changes)
    return after if isinstance(part, dict) else tuple(after.values())


def value_at(part: Any, key: str) -> float | None:
    """The number at a key of the file; None where there is none, or a list of several."""
    for name in key.split("."):
        if isinstance(part, Part):
            part = getattr(part, part.attributes[name]) if name in part.keys else None
        else:
            part = part.get(name) if isinstance(part, dict) else None
    if isinstance(part, tuple) and len(part) == 1:
        part = part[0]
    return float(part) if isinstance(part, float) else None
