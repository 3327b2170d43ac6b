"""Common base of all states: trials that move nothing until committed, one thread at a time."""

from __future__ import annotations

import copy
import threading
from collections.abc import Callable
from functools import wraps
from typing import Any, ClassVar, Self, TypeVar

from microslip._core.checks import Floats
from microslip._core.errors import InputError

Method = TypeVar("Method", bound=Callable[..., Any])


class StateLock(type(threading.RLock())):  # type: ignore[misc]  # a type that only C names
    """A lock that copies and pickles as a new one, so that what holds it does too."""

    def __reduce__(self) -> tuple[type[StateLock], tuple[()]]:
        return StateLock, ()


def one_at_a_time(method: Method) -> Method:
    """Let a method wait until no other thread is in one of the same object."""

    @wraps(method)
    def waiting(self: Any, *args: Any, **named: Any) -> Any:
        with self._turn:
            return method(self, *args, **named)

    return waiting  # type: ignore[return-value]


class Resumable:
    """A place on a hysteresis from which steps are tried; threads that share it take turns.

    A subclass tries steps, keeps the last in ``_trial`` and goes along it in :meth:`_take`.
    """

    __slots__ = ("_trial", "_turn")

    _changing: ClassVar[tuple[str, ...]] = ()
    """Slots whose content changes in place; that of the others is replaced."""

    _trial: Any

    def __init__(self) -> None:
        self._turn, self._trial = StateLock(), None

    def _take(self, trial: Any) -> None:
        """Go along a trial."""
        raise NotImplementedError

    @one_at_a_time
    def commit(self) -> None:
        """Make the last trial the state; without a trial it is an InputError."""
        if self._trial is None:
            raise InputError("commit needs a trial: call try_(displacement) first")
        self._take(self._trial)
        self._trial = None

    @one_at_a_time
    def rollback(self) -> None:
        """Forget the last trial, if there is one."""
        self._trial = None

    @one_at_a_time
    def copy(self) -> Self:
        """An independent state at the same place, an open trial included."""
        state = object.__new__(type(self))
        for name in (*type(self).__slots__, *Resumable.__slots__):
            value = getattr(self, name)
            setattr(state, name, copy.copy(value) if name in self._changing else value)
        state._turn = StateLock()
        return state

    __copy__ = copy


def counted(losses: Floats | None) -> Floats:
    """Dissipated energy, where it is counted."""
    if losses is None:
        raise InputError(
            "dissipated_energy is not counted: start the state with start(energies=True)"
        )
    return losses
