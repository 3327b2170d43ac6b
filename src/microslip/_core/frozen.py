"""Read-only arrays in frozen objects, preserved by copies and pickles."""

from __future__ import annotations

from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray


def lock(array: NDArray[Any]) -> NDArray[Any]:
    """Make an array read-only and return it."""
    array.setflags(write=False)
    return array


def assign(instance: object, **values: Any) -> None:
    """Set fields of a frozen dataclass instance, which must only be done while it is created."""
    for name, value in values.items():
        object.__setattr__(instance, name, value)


class _Proxied(dict[Any, Any]):
    """Copy of a read-only mapping for pickles, which cannot contain a MappingProxyType."""


class Locked:
    """Frozen object whose arrays and mappings stay read-only in copies and pickles.

    NumPy does not pickle the write flag, and Python does not pickle read-only mappings.
    """

    def __getstate__(self) -> dict[str, Any]:
        return {key: _thawed(value) for key, value in self.__dict__.items()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        for value in state.values():
            if isinstance(value, np.ndarray):
                lock(value)
        self.__dict__.update({key: _refrozen(value) for key, value in state.items()})


class LockedArrays(Locked):
    """Frozen dataclass of results whose arrays are read-only."""

    def __post_init__(self) -> None:
        for value in vars(self).values():
            for item in value if isinstance(value, tuple) else (value,):
                if isinstance(item, np.ndarray):
                    lock(item)


def _thawed(value: Any) -> Any:
    if isinstance(value, MappingProxyType):
        return _Proxied(value)
    return tuple(map(_thawed, value)) if type(value) is tuple else value


def _refrozen(value: Any) -> Any:
    if isinstance(value, _Proxied):
        return MappingProxyType(dict(value))
    return tuple(map(_refrozen, value)) if type(value) is tuple else value
