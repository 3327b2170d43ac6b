"""What an attack is and how its inputs are counted: tried, refused, wrong."""

from __future__ import annotations

import contextlib
import os
import signal
import time
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from microslip._core.errors import InputError

Random = np.random.Generator

LONGEST_ANSWER = 30.0
"""Seconds of computing after which an answer counts as a hang; the slowest honest one takes a
tenth of it. A machine that has other things to do may take ten times as long."""
LONGEST_MESSAGE = 600


class Hang(BaseException):
    """An input that was not answered in time; no handler of the library may swallow it."""


class Wrong(AssertionError):
    """An answer that is not right."""


@dataclass
class Tally:
    """What became of the inputs of one attack."""

    tried: int = 0
    refused: int = 0
    slowest: float = 0.0
    wrong: list[str] = field(default_factory=list)

    def add(self, other: Tally) -> None:
        """Count those of another worker, too."""
        self.tried += other.tried
        self.refused += other.refused
        self.slowest = max(self.slowest, other.slowest)
        self.wrong += other.wrong

    def attempt(self, label: str | Callable[[], str], call: Callable[[], Any]) -> Any:
        """Make one input: its answer, or None where it was refused or went wrong.

        ``call`` raises Wrong for an answer that is not right. All else but an InputError of one
        line is of a wrong kind: other errors, warnings, hangs.
        """
        self.tried += 1
        begun = _spent()
        try:
            with _alarm(LONGEST_ANSWER), warnings.catch_warnings():
                warnings.simplefilter("error")
                warnings.filterwarnings("ignore", "young_modulus is .* as soft as a gel")
                return call()
        except InputError as error:
            self.refused += 1
            message = str(error)
            if "\n" in message or not message.strip() or len(message) > LONGEST_MESSAGE:
                self._wrong(label, f"refused by {message[:200]!r}")
        except Wrong as error:
            self._wrong(label, str(error))
        except Hang:
            self._wrong(label, f"no answer within {LONGEST_ANSWER:g} s")
        except Exception as error:
            self._wrong(label, f"{type(error).__name__}: {str(error)[:200]}")
        finally:
            self.slowest = max(self.slowest, _spent() - begun)
        return None

    def _wrong(self, label: str | Callable[[], str], what: str) -> None:
        """Keep what went wrong; a label that costs is written only now."""
        self.wrong.append(f"{label if isinstance(label, str) else label()}: {what}")


def _spent() -> float:
    """Seconds that this process and those it waited for have computed."""
    return sum(os.times()[:4])


Attack = Callable[[Random, Tally], None]
"""Makes some inputs (usually one to a hundred) and counts them."""


def demand(holds: bool | np.bool_, what: str, *values: Any) -> None:
    """An answer that is not right, said with its numbers, which are written only then."""
    if not holds:
        raise Wrong(" ".join([what, *map(str, values)]))


def run(
    attack: Attack, inputs: int, seed: int, progress: Callable[[int], None] | None = None
) -> Tally:
    """Make about so many inputs; the same seed makes the same ones."""
    tally, round_ = Tally(), 0
    while tally.tried < inputs:
        attack(np.random.default_rng([seed, round_]), tally)
        round_ += 1
        if progress is not None:
            progress(tally.tried)
    return tally


@contextlib.contextmanager
def _alarm(seconds: float) -> Iterator[None]:
    """Raise Hang when the time is up, where the platform can."""
    if not hasattr(signal, "setitimer"):
        yield
        return

    begun, end = _spent(), time.perf_counter() + 10.0 * seconds

    def ring(_signal: int, _frame: Any) -> None:
        if _spent() - begun >= seconds or time.perf_counter() >= end:
            raise Hang
        signal.setitimer(signal.ITIMER_REAL, seconds)

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
