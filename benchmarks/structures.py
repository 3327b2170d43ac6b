"""Measure structures with joints: how their cost grows with patches and degrees of freedom.

    python benchmarks/structures.py         CPU times of one thread, as Markdown
    python benchmarks/structures.py --page  and between the markers in docs/timings.md

A bolted beam from its drawing with more and more patches, and a bar on springs, its patches in a
row on a rough base, with more and more degrees of freedom: the static state under load, one
residual with the Jacobian of all patches (3 harmonics and the mean, 64 samples), a step of Newton's
method without and with a damping matrix, a modal curve of 30 amplitudes by the balance of
harmonics, and a quasi-static one of 30. Then what the beam's reduction takes in memory, and 200
samples of friction and tension.
"""

from __future__ import annotations

import os

# Before NumPy loads: what is measured is one core.
os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import argparse
import resource
import time
import timeit
from collections.abc import Callable
from typing import Any

import numpy as np
from pages import write_section
from scipy import sparse

import microslip as ms
from microslip.structures.balance import Balance, ModePoint
from microslip.structures.mode_equations import ModeEquations
from microslip.structures.periodic_motion import AmplitudeMeasure, harmonic_basis

METAL = ms.Material(69e9, 0.33)
SURFACE = ms.GreenwoodWilliamson(
    ms.MaterialPair(METAL, METAL), ms.Gaussian(std=5e-7), radius=1e-3, density=1e8, area=2e-4
)
AMPLITUDES = np.geomspace(1e-7, 6e-5, 30)
COLUMNS = (
    "static state",
    "residual and Jacobian",
    "Newton step",
    "the same with damping",
    "modal curve",
    "quasi-static curve",
)
WANTED = "| wanted | 122 | | | ≤ 50 ms | | | ≤ 30 s | ≤ 1 s |"


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
    """The shortest CPU time of some runs [s]."""
    return min(timeit.repeat(run, timer=time.process_time, repeat=repeats, number=1))


def newton_step(state: ms.Preload) -> tuple[Callable[[], Any], Callable[[], Any]]:
    """The residual with the patches' Jacobians, and a step of Newton's method."""
    model = state.model
    line = np.zeros(model.size)
    line[0] = 1.0
    balance = Balance(model, model.joints(line), harmonic_basis([0, 1, 2, 3], 64))
    q = np.zeros((model.size, 7))
    q[0, 1] = 100.0 * AMPLITUDES[-1]  # where all patches slip, or open
    equations = ModeEquations(balance, 0, AmplitudeMeasure(None))
    point = ModePoint(q, float(np.sqrt(model.squares[0])), 0.01)
    current = equations._residual(point, q[0, 1])
    return (
        lambda: equations._residual(point, q[0, 1]),
        lambda: equations._newton_step(point, q[0, 1], current),
    )


def measure(
    structure: ms.Structure, force: np.ndarray, largest: float, repeats: int
) -> list[float]:
    """One row of the table [s]."""
    state = structure.preload(force)
    residual, step = newton_step(state)
    joints, size = structure.attachments[0], force.size
    damped = ms.Structure(structure.mass, structure.stiffness, 1e-7 * structure.stiffness)
    damped = damped.attach(joints.field, directions=joints.columns.reshape(size, -1, 3))
    _, damped_step = newton_step(damped.preload(force))
    return [
        best(lambda: structure.preload(force), repeats),
        best(residual, 5 * repeats),
        best(step, 2 * repeats),
        best(damped_step, repeats),
        best(lambda: solved(state, "harmonic-balance", largest), 1),
        best(lambda: solved(state, "quasi-static", largest), repeats),
    ]


def solved(state: ms.Preload, method: str, largest: float) -> None:
    """A modal curve, which must not end early."""
    amplitudes = largest / AMPLITUDES[-1] * AMPLITUDES
    curve = state.modes(0, amplitudes, harmonics=[1, 2, 3], method=method)
    if not curve.converged.all():
        raise SystemExit(f"{method}: {curve.message}")


def growth(repeats: int, structures: list[tuple[str, ms.Structure, np.ndarray]]) -> list[str]:
    """The table of structures."""
    rows = [f"| | patches | degrees of freedom | {' | '.join(COLUMNS)} |"]
    rows += ["| --- |" + " ---: |" * (2 + len(COLUMNS)), WANTED]
    largest = {"beam": AMPLITUDES[-1], "bar": 5e-6}  # further up, modes of the bars meet
    for name, structure, force in structures:
        cells = [text(seconds) for seconds in measure(structure, force, largest[name], repeats)]
        patches = structure.attachments[0].columns.shape[1] // 3
        rows.append(f"| {name} | {patches} | {force.size} | {' | '.join(cells)} |")
        print(rows[-1], flush=True)
    return rows


def text(seconds: float) -> str:
    """A time with its unit."""
    return f"{seconds:.3g} s" if seconds >= 1.0 else f"{1e3 * seconds:.3g} ms"


def bolted_beam() -> tuple[list[str], list[tuple[str, ms.Structure, np.ndarray]]]:
    """The beam of Brake and Reuß from its drawing, DOI 10.1016/j.ymssp.2023.110210."""
    steel = ms.Material(192.31e9, 0.3)
    bolts = ms.Bolts(
        [-0.03, 0.0, 0.03], shank=0.00794, hole=0.0084, washer=0.01746, tension=12.25e3
    )
    lap = ms.LapJoint(length=0.72, width=0.0254, thickness=0.0254, lap=0.12, bolts=bolts)
    surface = ms.GreenwoodWilliamson(
        ms.MaterialPair(steel, steel), ms.Gaussian(4e-6), radius=1.4e-3, density=1.4e6, area=1e-4
    )
    begin = time.process_time()
    joint = lap.reduce(steel, 7784.3)
    reduced = time.process_time() - begin
    # Kilobytes on Linux; of the whole process, its imports included.
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024.0
    rng = np.random.default_rng(0)
    scatter = np.stack([rng.uniform(0.1, 0.6, 200), rng.lognormal(np.log(12.25e3), 0.15, 200)], 1)

    def samples() -> None:
        for friction, tension in scatter:
            pressed = joint.with_tension(tension).tightened(surface, friction)
            pressed.modes(0, AMPLITUDES[::3])

    rows = [
        "| the beam with 30 patches | wanted | measured |",
        "| --- | ---: | ---: |",
        f"| reduced from {joint.full_size} degrees of freedom | | {text(reduced)} |",
        f"| memory at its peak | ≤ 1 GB | {memory / 1e9:.2f} GB |",
        f"| 200 samples of friction and tension | ≤ 10 s | {text(best(samples, 1))} |",
    ]
    print("\n".join(rows), flush=True)
    finer = (joint, *(lap.reduce(steel, 7784.3, patches) for patches in ((30, 2), (41, 3))))
    structures = [
        (
            "beam",
            ms.Structure(model.mass, model.stiffness).attach(
                model.field(surface, 0.3), directions=model.directions
            ),
            model.tightened(surface, 0.3).static_force,
        )
        for model in finer
    ]
    return rows, structures


def main() -> None:
    """Measure, print, and write into the page what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--repeats", type=int, default=2, help="runs, the best of which counts")
    parser.add_argument("--quick", action="store_true", help="two small bars, and no beam")
    parser.add_argument("--page", action="store_true")
    options = parser.parse_args()
    # The beam first: memory is told at its peak.
    beam, structures = ([], []) if options.quick else bolted_beam()
    sizes = [(60, 15), (60, 30), *([] if options.quick else [(120, 30), (240, 30), (380, 30)])]
    structures += [("bar", *bar(*size)) for size in sizes]
    rows = growth(options.repeats, structures)
    if options.page:
        write_section("timings.md", "structures", "structures.py", "\n".join([*rows, "", *beam]))


if __name__ == "__main__":
    main()
