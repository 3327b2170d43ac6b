"""Coverage of the intervals of half a loop: ``python -m laboratory.half_loops SETS [FIRST]``."""

from __future__ import annotations

import sys
from collections import Counter

import numpy as np

import microslip as ms

from .free_form import LAWS, QUANTITIES, sliders_of


def half_loop(seed: int, law: str) -> Counter[tuple[str, bool]]:
    """Identify one branch between two turning points, and count the intervals with the truth."""
    rng = np.random.default_rng([1342, seed, LAWS.index(law)])
    sliders = sliders_of(law, rng, float(rng.uniform(0.2e-6, 2e-6)), float(rng.uniform(200, 1500)))
    size = sliders.amplitude_at(0.98) * float(rng.uniform(1.2, 2.5))
    count, noise = int(rng.integers(40, 220)), float(rng.choice([0.003, 0.01]))
    part = np.linspace(0.0, 1.0, 20 * (count - 1) + 1)
    branch = -np.cos(np.pi * part) if rng.random() < 0.5 else 2.0 * part - 1.0
    up, down = np.linspace(0.0, 1.0, 200), np.linspace(1.0, -1.0, 400)
    u = size * np.concatenate((up, down[1:], branch[1:]))
    x, force = u[598::20], sliders._steps(u)[598::20]
    errors = noise * float(np.abs(force).max()), noise / 3.0 * size
    x = x + 0.2 * size + errors[1] * rng.normal(size=x.size)
    force = force + errors[0] * rng.normal(size=x.size)
    force = force + float(rng.uniform(-0.3, 0.3)) * sliders.force_limit
    found = ms.identify(ms.Record(x, force, normal_load=500.0), noise=errors)
    counts: Counter[tuple[str, bool]] = Counter()
    for name in QUANTITIES:
        for a in (0.5 * size, 0.95 * size) if name in QUANTITIES[:3] else (None,):
            one, truth = getattr(found, name), getattr(sliders, name)
            one, truth = (one, truth) if a is None else (one(a), truth(a))
            counts[name, bool(one.low <= truth <= one.high)] += 1
    return counts


def main() -> None:
    """Print how many intervals hold the true value, for each law and each quantity."""
    sets, first = (int(text) for text in (*sys.argv[1:], "0")[:2])
    by_law = {
        law: sum((half_loop(seed, law) for seed in range(first, first + sets)), Counter())
        for law in LAWS
    }
    total: Counter[tuple[str, bool]] = sum(by_law.values(), Counter())
    for law, counts in by_law.items():
        held = sum(number for (_, holds), number in counts.items() if holds)
        print(f"{law}: {held}/{counts.total()}")
    for name in QUANTITIES:
        print(f"{name}: {total[name, True]}/{total[name, True] + total[name, False]}")
    held = sum(number for (_, holds), number in total.items() if holds)
    print(f"all: {held}/{total.total()} ({100.0 * held / total.total():.1f} %)")


if __name__ == "__main__":
    main()
