"""Read-only arrays in frozen objects."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from types import MappingProxyType
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

_Function = TypeVar("_Function", bound=Callable[..., Any])


def made_once(function: _Function) -> _Function:
    """A function that makes frozen objects, made at its first call: costly examples, for one."""
    return cast("_Function", cache(function))


def lock(array: NDArray[Any]) -> NDArray[Any]:
    """The array, from now on read-only."""
    array.setflags(write=False)
    return array


def assign(instance: object, **values: Any) -> None:
    """Set fields of a frozen object while it is made."""
    for name, value in values.items():
        object.__setattr__(instance, name, value)


class _Proxied(dict[Any, Any]):
    """Content of a read-only mapping while it is pickled: Python cannot pickle the view."""


class Locked:
    """A frozen object whose arrays and mappings stay read-only in its copies.

    NumPy forgets to pickle that, and Python does not pickle read-only mappings at all.
    """

    def __getstate__(self) -> dict[str, Any]:
        return {key: _thawed(value) for key, value in self.__dict__.items()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        for value in state.values():
            if isinstance(value, np.ndarray):
                lock(value)
        self.__dict__.update({key: _refrozen(value) for key, value in state.items()})


class LockedArrays(Locked):
    """A frozen dataclass of results, whose arrays are read-only from the beginning."""

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
