"""Floor 10: quantities that are not known exactly, in one notation for every key."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from pydantic import GetCoreSchemaHandler
from pydantic_core import CoreSchema, core_schema

from microslip._core.checks import Floats
from microslip._core.wording import did_you_mean, quoted, show

_PAIRS = (("low", "high"), ("mean", "cv"))


class Spread(float):
    """A number with its scatter: as a float it is its middle.

    Between ``low`` and ``high`` every value is as likely as any other. With ``mean`` and the
    coefficient of variation ``cv`` it is lognormal, so that it keeps its sign.
    """

    low: float | None
    high: float | None
    cv: float | None

    @classmethod
    def between(cls, low: float, high: float) -> Spread:
        """Anything from low to high."""
        value = cls(0.5 * (low + high))
        value.low, value.high, value.cv = low, high, None
        return value

    @classmethod
    def about(cls, mean: float, cv: float) -> Spread:
        """About a mean, by a coefficient of variation."""
        value = cls(mean)
        value.low, value.high, value.cv = None, None, cv
        return value

    def quantiles(self, shares: Floats) -> Floats:
        """Values below which shares of it lie."""
        if self.low is not None and self.high is not None:
            return self.low + (self.high - self.low) * shares
        from scipy.special import ndtri

        width = math.log1p(float(self.cv or 0.0) ** 2)
        values: Floats = float(self) * np.exp(math.sqrt(width) * ndtri(shares) - 0.5 * width)
        return values

    @property
    def written(self) -> str:
        """In words."""
        if self.cv is None:
            return f"{self.low:g} to {self.high:g}"
        return f"{float(self):g} with a coefficient of variation of {self.cv:g}"


class Uncertain(NamedTuple):
    """Lets a table ``{ low, high }`` or ``{ mean, cv }`` stand where one quantity is wanted."""

    example: str

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_wrap_validator_function(self._read, handler(source))

    def _read(self, given: object, inner: Callable[[object], Any]) -> Any:
        if isinstance(given, Spread):
            return given
        if not isinstance(given, dict):
            return inner(given)
        for pair in _PAIRS:
            if set(given) == set(pair):
                return self._spread(given, inner)
        known = [key for pair in _PAIRS for key in pair]
        odd = next((key for key in given if key not in known), None)
        hint = did_you_mean(str(odd), known) if odd is not None else ""
        raise ValueError(
            f"wanted a value such as {self.example}, {{ low = …, high = … }} or "
            f"{{ mean = …, cv = … }}, got a table with {quoted(map(str, given), 'and')}{hint}"
            if given
            else f"wanted a value such as {self.example}, got an empty table"
        )

    def _spread(self, given: dict[str, object], inner: Callable[[object], Any]) -> Spread:
        if "mean" in given:
            cv = given["cv"]
            plain = isinstance(cv, (int, float)) and not isinstance(cv, bool)
            if not plain or not 0.0 < float(cv) <= 1.0:  # type: ignore[arg-type]
                raise ValueError(f"wanted cv above 0 and at most 1, such as 0.15, got {show(cv)}")
            return Spread.about(inner(given["mean"]), float(cv))  # type: ignore[arg-type]
        low, high = inner(given["low"]), inner(given["high"])
        if not low < high:
            raise ValueError(f"wanted low below high, got {show(given['low'])} and "
                             f"{show(given['high'])}")  # fmt: skip
        return Spread.between(low, high)

    def describe(self, inner: dict[str, Any]) -> dict[str, Any]:
        """The JSON Schema of what may stand here."""
        plain = {name: value for name, value in inner.items() if name != "description"}
        says = {
            "low": {**plain, "title": "Low", "description": "The smallest possible value."},
            "high": {**plain, "title": "High", "description": "The largest possible value."},
            "mean": {**plain, "title": "Mean", "description": "The expected value."},
            "cv": {
                "type": "number",
                "title": "Cv",
                "description": "Its standard deviation over the mean.",
                "exclusiveMinimum": 0,
                "maximum": 1,
            },
        }
        tables = [
            {
                "type": "object",
                "properties": {a: says[a], b: says[b]},
                "required": [a, b],
                "additionalProperties": False,
            }
            for a, b in _PAIRS
        ]
        return {"anyOf": [inner, *tables]}
