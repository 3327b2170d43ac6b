"""Uncertain quantities of a study."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip._core.parameters import JsonSchema
from microslip._core.units import engineering
from microslip._core.wording import did_you_mean, quote, quoted
from microslip.study.part import Part
from microslip.study.readers import DeclaredValue, Place

_FORMS = (("low", "high"), ("low", "high", "distribution"), ("mean", "cv"), ("values",))
_RANGES = ("uniform", "log-uniform")
_MOST_VALUES = 100_000


class Spread(float):
    """An uncertain number; as a float it is the centre of its distribution.

    The distribution is uniform or log-uniform between ``low`` and ``high``; or lognormal with a
    mean and the coefficient of variation ``cv``; or discrete with equally likely ``values``.
    """

    low: float | None = None
    high: float | None = None
    cv: float | None = None
    log: bool = False
    """Whether the distribution between low and high is log-uniform."""
    values: tuple[float, ...] = ()
    unit: str = ""

    @classmethod
    def between(cls, low: float, high: float, log: bool = False) -> Spread:
        """Return an uncertain number, uniform or log-uniform from ``low`` to ``high``."""
        value = cls(math.sqrt(low * high) if log else 0.5 * (low + high))
        value.low, value.high, value.log = low, high, log
        return value

    @classmethod
    def about(cls, mean: float, cv: float) -> Spread:
        """Return a lognormal number with a mean and a coefficient of variation."""
        value = cls(mean)
        value.cv = cv
        return value

    @classmethod
    def among(cls, values: Sequence[float]) -> Spread:
        """Return an uncertain number with equally likely values."""
        value = cls(sum(values) / len(values))
        value.values = tuple(sorted(values))
        return value

    def quantiles(self, shares: Floats) -> Floats:
        """Return the quantiles at cumulative probabilities ``shares``."""
        if self.values:
            places = np.minimum((shares * len(self.values)).astype(int), len(self.values) - 1)
            return np.asarray(np.array(self.values)[places])
        if self.low is not None and self.high is not None:
            if self.log:
                return np.asarray(self.low * (self.high / self.low) ** shares)
            return np.asarray(self.low + (self.high - self.low) * shares)
        from scipy.special import ndtri

        width = math.log1p(float(self.cv or 0.0) ** 2)
        return np.asarray(float(self) * np.exp(math.sqrt(width) * ndtri(shares) - 0.5 * width))

    def _text(self, value: float | None) -> str:
        if not self.unit or "^" in self.unit:  # prefixes of powers would be ambiguous
            return f"{value:g} {self.unit}".rstrip()
        return engineering(value, self.unit, 6, trim=True)

    @property
    def written(self) -> str:
        """Description of the distribution in words, such as "0.1 to 0.8, log-uniform"."""
        if self.values:
            low, high = map(self._text, (self.values[0], self.values[-1]))
            return f"one of {len(self.values)} values, {low} to {high}"
        if self.cv is None:
            return f"{self._text(self.low)} to {self._text(self.high)}{', log-uniform' * self.log}"
        return f"{self._text(float(self))} with a coefficient of variation of {self.cv:g}"


class Uncertain(DeclaredValue):
    """Reader of a declared number that may be uncertain, such as ``{ low, high }``."""

    def read(self, raw_value: object, place: Place) -> Any:
        """Return the number, or its :class:`Spread`."""
        if not isinstance(raw_value, dict):
            return super().read(raw_value, place)
        for form in _FORMS:
            if set(raw_value) == set(form):
                spread = self._spread(raw_value)
                spread.unit = self.declared.unit or ""
                return spread
        if {*raw_value} == {"mean", "cv", "distribution"}:
            raise ValueError("distribution with mean and cv was removed in 0.3; leave it out: the "
                             "distribution is lognormal")  # fmt: skip
        if "of" in raw_value:
            raise ValueError("{ of = … } was removed in 0.3; write the value, or use ms.evaluate")
        odd = next((key for key in raw_value if key not in _MEANINGS), None)
        hint = did_you_mean(str(odd), _MEANINGS) if odd is not None else ""
        raise ValueError(
            f"wanted a value such as {self.example} or {{low = …, high = …}}, "
            "{mean = …, cv = …} or {values = […]}; got a table with "
            f"{quoted(map(str, raw_value), 'and')}{hint}"
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
        cv = table["cv"]
        plain = isinstance(cv, (int, float)) and not isinstance(cv, bool)
        if not plain or not 0.0 < float(cv) <= 1.0:  # type: ignore[arg-type]
            raise ValueError(f"wanted cv above 0 and at most 1, such as 0.15, got {quote(cv)}")
        mean = self.declared.read(table["mean"])
        if mean == 0.0:
            raise ValueError("wanted a mean other than zero with cv; write low and high instead")
        return Spread.about(mean, float(cv))  # type: ignore[arg-type]

    def schema(self) -> JsonSchema:
        """Return the JSON Schema of a number or a table."""
        inner = super().schema()
        plain = {name: value for name, value in inner.items() if name != "description"}
        types = {
            "low": plain, "high": plain, "mean": plain,
            "cv": {"type": "number", "exclusiveMinimum": 0, "maximum": 1},
            "values": {"type": "array", "items": plain, "minItems": 2},
            "distribution": {"enum": list(_RANGES)},
        }  # fmt: skip
        tables = [
            {
                "type": "object",
                "properties": {
                    key: {**types[key], "title": key.capitalize(), "description": _MEANINGS[key]}
                    for key in form
                },
                "required": [key for key in form if key != "distribution"],
                "additionalProperties": False,
            }
            for form in _FORMS[1:]
        ]
        return {"anyOf": [inner, *tables]}


_MEANINGS = {
    "low": "The smallest possible value.",
    "high": "The largest possible value.",
    "mean": "The expected value.",
    "cv": "Coefficient of variation: standard deviation over mean.",
    "values": "Equally likely values.",
    "distribution": '"uniform" (the default) or "log-uniform".',
}


def spreads_of(part: object, path: str = "") -> Iterator[tuple[str, Spread]]:
    """Yield the uncertain numbers of a table and its subtables, by key."""
    if isinstance(part, Spread):
        yield path, part
    for _, key, value in _entries(part, path):
        yield from spreads_of(value, key)


def _entries(part: Any, path: str) -> Iterator[tuple[Any, str, Any]]:
    """Yield, for each entry of a table or list, its name or index, full dotted key, and value."""
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
    """Return a table with uncertain numbers replaced by values, given by key."""
    if isinstance(part, Spread):
        return float(values.get(path, float(part)))
    copy = changed(part, lambda value, key: with_values(value, values, key), path)
    if copy is not part and hasattr(copy, "settle"):  # derive values again from the drawn ones
        copy.settle()
    return copy


def at_central_values(part: Any) -> Any:
    """Return a study or table with each uncertain number replaced by its central value."""
    return with_values(part, {})


def changed(part: Any, change: Callable[[Any, str], Any], path: str = "") -> Any:
    """Return a table with a function applied to all its values; the table itself if unchanged."""
    before = {name: (value, key) for name, key, value in _entries(part, path)}
    after = {name: change(value, key) for name, (value, key) in before.items()}
    changes = {name: new for name, new in after.items() if new is not before[name][0]}
    if not changes:
        return part
    if isinstance(part, Part):
        return part.copy(**changes)
    return after if isinstance(part, dict) else tuple(after.values())


def value_at(part: Any, key: str) -> float | None:
    """Return the number at a key; None if there is no such key, or it holds a list."""
    for name in key.split("."):
        if isinstance(part, Part):
            part = getattr(part, part.attributes[name]) if name in part.keys else None
        else:
            part = part.get(name) if isinstance(part, dict) else None
    if isinstance(part, tuple) and len(part) == 1:
        part = part[0]
    return float(part) if isinstance(part, float) else None
