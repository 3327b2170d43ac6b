"""One thread at a time in a state, which several may share by mistake or on purpose."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar

Method = TypeVar("Method", bound=Callable[..., Any])


class Turn(type(threading.RLock())):  # type: ignore[misc]  # a type that only C names
    """A lock that copies and pickles as a new one, so that what holds it does too."""

    def __reduce__(self) -> tuple[type[Turn], tuple[()]]:
        return Turn, ()


def one_at_a_time(method: Method) -> Method:
    """Let a method wait until no other thread is in one of the same object."""

    @wraps(method)
    def waiting(self: Any, *args: Any, **named: Any) -> Any:
        with self._turn:
            return method(self, *args, **named)

    return waiting  # type: ignore[return-value]
