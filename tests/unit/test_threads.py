"""BLAS is held to one thread in small fits, and set free again after them."""

from __future__ import annotations

from collections.abc import Iterator
from threading import Barrier, Thread
from typing import Any

import numpy as np
import pytest
from scipy import linalg
from threadpoolctl import ThreadpoolController

import microslip as ms
from microslip._core.threads import single_threaded
from microslip.identification import run

del linalg  # imported for its BLAS
BLAS = ThreadpoolController().select(user_api="blas")


def threads() -> list[int]:
    return [library["num_threads"] for library in BLAS.info()]


def set_threads(number: int) -> None:
    """Set it from a thread that is gone then: while it lived no other could change it."""
    thread = Thread(target=BLAS.limit, kwargs={"limits": number})
    thread.start()
    thread.join()


@pytest.fixture
def two_threads() -> Iterator[list[int]]:
    """BLAS with two threads, whatever the machine and its settings."""
    usual = max(threads(), default=1)
    set_threads(2)
    before = threads()
    if max(before, default=1) == 1:
        pytest.skip("the BLAS here has no threads to limit")
    yield before
    set_threads(usual)


def test_a_fit_has_one_thread_and_gives_them_back(
    two_threads: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    wave = np.sin(2.0 * np.pi * np.arange(5 * 64 + 1) / 64)
    noise = 0.1 * np.random.default_rng(1).normal(size=wave.size)
    force = ms.Jenkins(1e7, 30.0).force(5e-6 * wave) + noise
    record = ms.Record(5e-6 * wave, force)
    within: list[list[int]] = []
    fold = run.fold

    def folded(*arguments: Any) -> Any:
        within.append(threads())
        return fold(*arguments)

    monkeypatch.setattr(run, "fold", folded)
    ms.identify(record)
    assert within
    assert all(set(seen) == {1} for seen in within)
    assert threads() == two_threads
    with pytest.raises(ms.InputError):
        ms.identify(record, law="interface")  # no normal load
    assert threads() == two_threads


def test_calls_that_overlap_leave_no_limit_behind(two_threads: list[int]) -> None:
    first_is_in, second_is_in = Barrier(2), Barrier(2)

    @single_threaded
    def first() -> None:
        first_is_in.wait(10.0)
        second_is_in.wait(10.0)

    @single_threaded
    def second(other: Thread) -> None:
        second_is_in.wait(10.0)
        other.join(10.0)

    thread = Thread(target=first)
    thread.start()
    first_is_in.wait(10.0)
    second(thread)
    assert threads() == two_threads
    single_threaded(lambda: None)()
    assert threads() == two_threads


def test_rows_are_the_same_in_any_number_of_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    """Held, with separations and in two directions, to the last bit."""
    from exported import JOINT

    rng = np.random.default_rng(0)
    field = ms.JointField(JOINT.surface, 0.4, areas=1e-6, loads=rng.uniform(1.0, 20.0, 130))
    shape = np.array([0.5, 1.0, 1.0, 0.4, 0.4])
    x, d = 4e-7 * shape * rng.normal(size=(130, 5)), 1e-7 * shape * rng.normal(size=(130, 5))
    d[:, 0] += field.separations
    flat, h = field.two_directions(16), (0, 1, 2)
    found = []
    for count in ("1", "3", ""):
        monkeypatch.setenv("OMP_NUM_THREADS", count)
        both = np.stack((x, 0.5 * x[::-1]), axis=1)
        found.append([
            *field.harmonics(x, h), *field.harmonics(x, h, separations=d),
            *flat.harmonics(both, h, samples=16),
        ])  # fmt: skip
    for other in found[1:]:
        for mine, its in zip(found[0], other, strict=True):
            np.testing.assert_array_equal(mine, its)
