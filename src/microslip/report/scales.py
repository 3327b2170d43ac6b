"""Common prefix of numbers shown together, and selection of those shown."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.units import prefix


def evenly(count: int, limit: int) -> list[int]:
    """Indices of at most `limit` of `count` things, evenly, the first and the last among them."""
    size = min(count, limit)
    if size < 2:
        return list(range(size))
    return sorted({round(i * (count - 1) / (size - 1)) for i in range(size)})


def length_prefix(largest: float, smallest: float = 0.0) -> tuple[float, str]:
    """Micrometres wherever they suit lengths [m], since those of joints are read in them."""
    return (1e-6, "µ") if largest > 1e-7 and (smallest or largest) < 1e-3 else prefix(largest)


def force_prefix(values: ArrayLike) -> tuple[float, str]:
    """Prefix for values that may all be zero."""
    largest = float(np.abs(values).max(initial=0.0))
    return prefix(largest) if largest > 0.0 else (1.0, "")


def common_prefix(values: Sequence[float]) -> tuple[float, str]:
    """Prefix of the largest value, or none where the others are too far below it."""
    return (1.0, "") if far_apart(values, 1e4) else prefix(max(values))


def far_apart(values: Sequence[float], factor: float = 20.0) -> bool:
    """Whether positive values are too far apart for one linear axis."""
    return max(values) > factor * min(values)


_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_MINUS = str.maketrans("-", "−")


class Ticks(NamedTuple):
    """Places along an axis."""

    major: tuple[tuple[float, str], ...]
    """Ticks with a grid line, and their labels."""
    minor: tuple[tuple[float, str], ...] = ()
    """Ticks between them; most have no label."""
    offset: str = ""
    """The power of ten that all labels leave out."""


def linear(low: float, high: float, limit: int, integer: bool = False) -> Ticks:
    """At most `limit` round numbers between two ends, which may be in either order."""
    low, high = min(low, high), max(low, high)
    rough = (high - low) / max(limit, 1)
    power = math.floor(math.log10(rough))
    step = next(
        (n * 10.0**power for n in (1, 2, 2.5, 5) if n * 10.0**power >= rough * (1.0 - 1e-9)),
        10.0 ** (power + 1),
    )
    if integer:
        step = float(max(round(step), 1))
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    values = [i * step for i in range(first, last + 1)]
    largest = max(abs(low), abs(high))
    scale = math.floor(math.log10(largest)) if largest > 0.0 else 0
    exponent = 0 if -3 <= scale <= 4 else scale
    texts = [_decimal(value / 10.0**exponent, step / 10.0**exponent) for value in values]
    offset = f"×10{str(exponent).translate(_SUPERSCRIPTS)}" if exponent else ""
    return Ticks(tuple(zip(values, texts, strict=True)), (), offset)


def logarithmic(low: float, high: float, limit: int) -> Ticks:
    """Powers of ten between two ends, at most `limit` of them labelled, and what lies between."""
    first, last = math.floor(math.log10(low) - 1e-9), math.ceil(math.log10(high) + 1e-9)
    inside = [n for n in range(first, last + 1) if 0.999999 * low <= 10.0**n <= 1.000001 * high]
    every = max(1, math.ceil(len(inside) / max(limit, 1)))
    powers = [n for n in inside if n % every == 0]
    major = tuple((10.0**n, log_label(10.0**n, low, high)) for n in powers)
    if every > 1:
        return Ticks(major, tuple((10.0**n, "") for n in inside if n % every))
    minor = [
        (k * 10.0**n, log_label(k * 10.0**n, low, high))
        for n in range(first, last + 1)
        for k in range(2, 10)
        if low < k * 10.0**n < high
    ]
    labelled = sum(bool(text) for _, text in (*major, *minor))
    if labelled < 2 or labelled > 2 * limit:  # within a decade round numbers are enough
        return linear(low, high, min(limit, 4))
    return Ticks(major, tuple(minor))


def log_label(x: float, low: float, high: float) -> str:
    """Label of a place on a log axis: 0.1, 1, 10 where these are short, else 10⁻⁶; never mixed.

    Empty for a place that needs none.
    """
    power = math.floor(math.log10(x) + 1e-9)
    factor = float(f"{x / 10.0**power:.5g}")
    decades = math.log10(high / low)
    if factor not in ((1,) if decades > 1.6 else (1, 2, 5) if decades > 0.5 else (factor,)):
        return ""
    if low >= 0.9e-4 and high <= 1.2e5:
        return f"{x:.6g}"
    exponent = str(power).translate(_SUPERSCRIPTS)
    return f"10{exponent}" if factor == 1 else f"{factor:g}·10{exponent}"


def _decimal(value: float, step: float) -> str:
    """A number with the decimals that tell it from its neighbours."""
    digits = max(0, -math.floor(math.log10(step) + 1e-9))
    if abs(step * 10**digits - round(step * 10**digits)) > 1e-6:  # steps of 2.5
        digits += 1
    text = f"{value:.{digits}f}"
    return "0" if float(text) == 0.0 and digits == 0 else text.translate(_MINUS)
