"""Equality of frozen objects by their fields. NumPy is imported only for a comparison."""

from __future__ import annotations

from dataclasses import fields
from typing import Any


class ByValue:
    """Mixin for frozen dataclasses: equality by the values of public fields, arrays included."""

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if type(other) is not type(self):
            return NotImplemented
        return all(_equal(value, getattr(other, name)) for name, value in _fields(self))

    def __hash__(self) -> int:
        plain = (value for _, value in _fields(self) if isinstance(value, (int, float, str)))
        return hash((type(self), *plain))


def _fields(instance: Any) -> list[tuple[str, Any]]:
    # Private fields are derived from public ones.
    values = vars(instance)
    names = (item.name for item in fields(instance) if not item.name.startswith("_"))
    return [(name, values[name]) for name in names if name in values]


def _equal(one: Any, other: Any) -> bool:
    import numpy as np

    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return np.shape(one) == np.shape(other) and bool(np.all(np.asarray(one == other)))
    if isinstance(one, (tuple, list)) and type(one) is type(other):
        return len(one) == len(other) and all(map(_equal, one, other))
    return bool(one == other)
