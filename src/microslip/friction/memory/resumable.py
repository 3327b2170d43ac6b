"""Base class of hysteresis states whose trial steps are committed or discarded, in any thread."""

from __future__ import annotations

import copy
import threading
from collections.abc import Callable
from functools import wraps
from typing import Any, ClassVar, Self, TypeVar

from microslip._core.checks import Floats
from microslip._core.errors import InputError

_Method = TypeVar("_Method", bound=Callable[..., Any])


class StateLock(type(threading.RLock())):  # type: ignore[misc]  # no public name in Python
    """Reentrant lock that is replaced by a new one when copied or pickled."""

    def __reduce__(self) -> tuple[type[StateLock], tuple[()]]:
        return StateLock, ()


def synchronized(method: _Method) -> _Method:
    """Decorate a method so that only one thread at a time uses its object."""

    @wraps(method)
    def waiting(self: Any, *args: Any, **named: Any) -> Any:
        with self._lock:
            return method(self, *args, **named)

    return waiting  # type: ignore[return-value]


class Resumable:
    """Hysteresis state with trial steps, usable from several threads.

    A subclass computes a trial, stores it in ``_trial`` and applies it in :meth:`_apply`.
    """

    __slots__ = ("_lock", "_trial")

    _changing: ClassVar[tuple[str, ...]] = ()
    """Slots whose content changes in place, which must be copied."""

    _trial: Any

    def __init__(self) -> None:
        self._lock, self._trial = StateLock(), None

    def _apply(self, trial: Any) -> None:
        raise NotImplementedError

    @synchronized
    def commit(self) -> None:
        """Make the last trial the new state. Without a trial, InputError is raised."""
        if self._trial is None:
            raise InputError("commit needs a trial; call try_(displacement) first")
        self._apply(self._trial)
        self._trial = None

    @synchronized
    def rollback(self) -> None:
        """Discard the last trial, if there is one."""
        self._trial = None

    @synchronized
    def copy(self) -> Self:
        """Return an independent copy, including an open trial."""
        state = object.__new__(type(self))
        for name in (*type(self).__slots__, *Resumable.__slots__):
            value = getattr(self, name)
            setattr(state, name, copy.copy(value) if name in self._changing else value)
        state._lock = StateLock()
        return state

    __copy__ = copy


def accumulated(losses: Floats | None) -> Floats:
    """Return dissipated energies; raise InputError if they were not accumulated."""
    if losses is None:
        raise InputError(
            "dissipated_energy is not accumulated; start the state with start(energies=True)"
        )
    return losses
