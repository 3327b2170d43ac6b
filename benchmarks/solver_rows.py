"""Rows of docs/timings.md for solvers: harmonics of each law, and the fixed cost of a field step.

All rows come from one process, each the best of many calls, beside the baseline of its table: the
harmonics of an Interface on Gaussian heights, and a step of a scalar state.

    PYTHONPATH=src python benchmarks/solver_rows.py
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

import microslip as ms

PAIR = ms.MaterialPair(ms.Material(69e9, 0.33), ms.Material(69e9, 0.33))


def best(call: Callable[[], object], calls: int = 400) -> float:
    """Shortest time of a call [us]."""
    times = []
    for _ in range(calls):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return 1e6 * min(times)


def main() -> None:
    """Print a line for each row."""
    surface = ms.GreenwoodWilliamson(PAIR, ms.Gaussian(5e-7), 1e-3, 1e8, 2e-4)
    joint = ms.Interface(surface, 0.5, normal_load=100.0)
    heights = np.random.default_rng(1).normal(size=500) * 5e-7
    summits = ms.AsperityPopulation(PAIR, heights, 1e-3)
    laws = {
        "Interface, Gaussian heights (baseline)": joint,
        "Jenkins": ms.Jenkins(1e7, 10.0),
        "Segalman": ms.SegalmanIwan.examples()[0],
        "Iwan of 50 cells": joint.to_iwan(50),
        "sphere": ms.Asperity.examples()[0],
        "Parallel": ms.Parallel.examples()[0],
        "500 listed summits": ms.Interface(summits, 0.5, normal_load=float(summits.load(0.0))),
    }
    for name, law in laws.items():
        reach = law.force_limit / law.tangential_stiffness
        for harmonics, shares in (
            ([0, 1], [0.1, 1.3, 0.4]),
            ([0, 1, 3], [0.1, 1.3, 0.4, 0.2, 0.3]),
        ):
            c = reach * np.array(shares)
            law.harmonics(c, harmonics)
            taken = best(lambda law=law, c=c, h=harmonics: law.harmonics(c, h))
            print(f"harmonics {harmonics} of {name}: {taken:.0f} us")
    state = joint.start()
    field = ms.JointField(surface, 0.5, areas=[1e-5], loads=[100.0]).start()
    place = np.array([1e-7])

    def scalar_step() -> None:
        state.try_(1e-7)
        state.commit()

    def field_step() -> None:
        field.try_(place)
        field.commit()

    print(f"step of a scalar state (baseline): {best(scalar_step, 3000):.1f} us")
    print(f"step of a field of one node: {best(field_step, 3000):.1f} us")


if __name__ == "__main__":
    main()
