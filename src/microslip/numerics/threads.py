"""One BLAS thread for small systems, where a second one costs many times what it saves."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from functools import cache, partial, wraps
from threading import Lock
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")

# The limit is one of the process. Who sets it takes it back, and who comes meanwhile, from within
# or in another thread, leaves it alone: else calls that overlap would take each other's limit for
# what was before, and leave it behind.
_LIMITING = Lock()


@cache
def _limit() -> Callable[[], Any]:
    from scipy import linalg  # brings the BLAS that is to be limited

    del linalg
    try:
        from threadpoolctl import ThreadpoolController
    except ModuleNotFoundError:  # then it takes as long as it takes: the numbers are the same
        return nullcontext
    return partial(ThreadpoolController().limit, limits=1, user_api="blas")


def single_threaded(function: Callable[P, R]) -> Callable[P, R]:
    """The function, with BLAS held to one thread while it runs."""

    @wraps(function)
    def limited(*args: P.args, **kwargs: P.kwargs) -> R:
        if not _LIMITING.acquire(blocking=False):
            return function(*args, **kwargs)
        try:
            with _limit()():
                return function(*args, **kwargs)
        finally:
            _LIMITING.release()

    return limited
