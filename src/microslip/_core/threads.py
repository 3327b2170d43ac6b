"""Number of threads: one for BLAS on small systems, several for independent rows of kernels."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import nullcontext
from functools import cache, partial, wraps
from threading import Lock
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")

# The limit applies to the whole process. Only the outermost call sets and resets it: overlapping
# calls would otherwise save the limit of another call as the original value and leave it set.
_LIMITING = Lock()


@cache
def _limit() -> Callable[[], Any]:
    from scipy import linalg  # loads the BLAS library to be limited

    del linalg
    try:
        from threadpoolctl import ThreadpoolController
    except ModuleNotFoundError:  # slower, with the same results
        return nullcontext
    return partial(ThreadpoolController().limit, limits=1, user_api="blas")


def single_threaded(function: Callable[P, R]) -> Callable[P, R]:
    """Decorate a function so that BLAS uses a single thread while it runs."""

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


_LEAST = 32  # smallest number of rows worth a thread


def in_parts(size: int, work: Callable[[slice], object]) -> list[object]:
    """Run ``work(slice)`` in threads, on slices that cover ``size`` independent rows.

    Returns the results in the order of the slices. The number of threads is ``OMP_NUM_THREADS``, or
    the number of available processors, but at most one per 32 rows. Kernels release the global
    interpreter lock, and the results of a row do not depend on its slice.
    """
    count = min(_threads(), size // _LEAST)
    if count < 2:
        return [work(slice(0, size))]
    from concurrent.futures import ThreadPoolExecutor

    parts = min(4 * count, size // _LEAST)  # more parts than threads, since rows differ in cost
    ends = [size * k // parts for k in range(parts + 1)]
    with ThreadPoolExecutor(count) as pool:
        return list(pool.map(work, map(slice, ends[:-1], ends[1:])))


def _threads() -> int:
    setting = os.environ.get("OMP_NUM_THREADS", "")
    if setting.isdecimal() and int(setting):
        return int(setting)
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
