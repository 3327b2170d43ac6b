"""Measure structures with joints: how their cost grows with patches and degrees of freedom.

    python benchmarks/structures.py         a table of times [ms] of one thread, as Markdown

A bar on springs, its patches of a rough surface spread along it with three directions each: one
residual with its Jacobian (3 harmonics and the mean, 64 samples), a modal curve of 30 amplitudes by
the balance of harmonics, a quasi-static one of 30, and the static state that they begin with.
"""

from __future__ import annotations

import os

# Before NumPy loads: what is measured is one core.
os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import argparse
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy import sparse

import microslip as ms
from microslip.structures.balance import Balance
from microslip.structures.harmonic_basis import harmonic_basis

METAL = ms.Material(69e9, 0.33)
SURFACE = ms.GreenwoodWilliamson(
    ms.MaterialPair(METAL, METAL), ms.Gaussian(std=5e-7), radius=1e-3, density=1e8, area=2e-4
)
AMPLITUDES = np.geomspace(1e-7, 1e-4, 30)
COLUMNS = ("static state", "residual and Jacobian", "modal curve", "quasi-static curve")


def bar(nodes: int, patches: int) -> tuple[ms.Structure, np.ndarray]:
    """Nodes of three displacements in a row, and the static force that presses the patches."""
    spring = sparse.diags(
        [-np.ones(nodes - 1), np.full(nodes, 2.0), -np.ones(nodes - 1)], [-1, 0, 1]
    )
    stiffness = sparse.kron(1e9 * spring, sparse.diags([0.2, 0.3, 1.0])).tocsc()
    size = 3 * nodes
    directions = np.zeros((size, patches, 3))
    # Side by side, off the middle: everywhere or in it, modes would lie in pairs or closer.
    places = (nodes - patches) // 3 + np.arange(patches)
    for patch, place in enumerate(places):
        directions[3 * place : 3 * place + 3, patch] = np.eye(3)
    field = ms.JointField(SURFACE, 0.3, areas=np.full(patches, 1e-4), gaps=np.full(patches, 1e-6))
    force = np.zeros(size)
    force[3 * places + 2] = -500.0
    mass = sparse.diags(np.full(size, 0.01)).tocsc()
    return ms.Structure(mass, stiffness).attach(field, directions=directions), force


def best(run: Callable[[], Any], repeats: int) -> float:
    """The shortest of some runs [ms]."""
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        run()
        times.append(time.perf_counter() - begin)
    return 1e3 * min(times)


def measure(nodes: int, patches: int, repeats: int) -> list[float]:
    """One row of the table [ms]."""
    structure, force = bar(nodes, patches)
    state = structure.preload(force)
    model = state.model
    line = np.zeros(model.size)
    line[0] = 1.0
    balance = Balance(model, model.joints(line), harmonic_basis([0, 1, 2, 3], 64))
    q = np.zeros((model.size, 7))
    q[0, 1] = 1e-7

    def residual() -> None:
        balance.tangent_matrix(balance.joint_forces(q).answers)

    return [
        best(lambda: structure.preload(force), repeats),
        best(residual, 3 * repeats),
        best(lambda: state.modes(0, AMPLITUDES, harmonics=[1, 2, 3]), repeats),
        best(lambda: state.modes(0, AMPLITUDES, method="quasi-static"), repeats),
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--repeats", type=int, default=2, help="runs, the best of which counts")
    options = parser.parse_args()
    print(f"| patches | degrees of freedom | {' [ms] | '.join(COLUMNS)} [ms] |")
    print("|" + " --: |" * (2 + len(COLUMNS)))
    for nodes, patches in ((60, 15), (60, 30), (122, 60), (122, 122), (240, 30), (380, 30)):
        times = measure(nodes, patches, options.repeats)
        print(f"| {patches} | {3 * nodes} | {' | '.join(f'{t:.3g}' for t in times)} |", flush=True)


if __name__ == "__main__":
    main()
