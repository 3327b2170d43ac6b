"""Threads that share a joint: the same answers as alone; a state in two threads stays whole."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np

import microslip as ms

from .campaign import Random, Tally, demand
from .histories import random_law, reach_of


def attack_threads(rng: Random, tally: Tally) -> None:
    """A joint whose tables are not built yet, asked by four threads at once."""
    law = random_law(rng)
    tally.attempt(lambda: f"{law!r:.120} in threads", lambda: answers_as_alone(law, rng))


def answers_as_alone(law: ms.BackboneLaw, rng: Random) -> None:
    """Forces and energies of four threads, and a state that all of them advance."""
    x = reach_of(law) * rng.uniform(-2.0, 2.0, 400)
    amplitudes = np.abs(x[:50])

    def ask(_: int) -> tuple[np.ndarray, np.ndarray]:
        return law.force(x), law.dissipated_energy(amplitudes)

    shared = law.start()

    def advance(part: np.ndarray) -> bool:
        try:
            return bool(np.isfinite(shared.advance(part)).all())
        except ms.InputError:  # in use by another thread
            return True

    with ThreadPoolExecutor(4) as pool:
        answers = list(pool.map(ask, range(4)))
        whole = list(pool.map(advance, np.split(x, 20)))
    wanted = ask(0)
    for answer in answers:
        demand(np.array_equal(answer[0], wanted[0]), "forces differ between threads")
        demand(np.array_equal(answer[1], wanted[1]), "energies differ between threads")
    demand(all(whole), "a shared state gave what is not finite")
    after = shared.advance(50.0 * reach_of(law))
    limit = law.force_limit * (1.0 + 1e-12)
    demand(abs(float(after)) <= limit, f"a shared state went to {after}, over {limit}")
