"""Threads: one of BLAS for small systems, where a second one costs; many for rows of kernels."""

from __future__ import annotations

import os
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


_LEAST = 32  # rows of a part: fewer are done before a thread has begun


def in_parts(size: int, work: Callable[[slice], object]) -> list[object]:
    """Results of ``work`` for slices of independent rows, in threads.

    There are as many threads as ``OMP_NUM_THREADS`` says, or as the process may run on, and no more
    than are worth it. Kernels let other threads run, and a row's numbers do not depend on the part
    that it is in.
    """
    count = min(_threads(), size // _LEAST)
    if count < 2:
        return [work(slice(0, size))]
    from concurrent.futures import ThreadPoolExecutor

    parts = min(4 * count, size // _LEAST)  # rows differ in what they take
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
