"""Measure the rows for solvers of docs/timings.md, each beside its baseline in the same process.

    python benchmarks/solver_rows.py                      print the table
    python benchmarks/solver_rows.py --page               and write it into docs/timings.md
    python benchmarks/solver_rows.py --tmdsimpy FOLDER    with VectorJenkins of TMDSimPy as a row

Baselines: `scalar_joints.c`, compiled here by `cc`; an Iwan model of 50 sliders by Numba, or by the
same C file where Numba is not installed; a scalar `State`; an `Interface` on Gaussian heights; and
TMDSimPy's `VectorJenkins`, from a folder that holds the package `tmdsimpy`, which is on no package
index. Times are CPU seconds of the thread, the least of many calls, which other work on the machine
changes little.
"""

from __future__ import annotations

import os

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import argparse
import ctypes
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from pages import write_section

import microslip as ms

PAIR = ms.MaterialPair(ms.Material(69e9, 0.33), ms.Material(69e9, 0.33))
SURFACE = ms.GreenwoodWilliamson(PAIR, ms.Gaussian(5e-7), 1e-3, 1e8, 2e-4)
JOINT = ms.Interface(SURFACE, 0.5, normal_load=100.0)
NODES, STEPS, CELLS = 1000, 128, 50
HEAD = ("row", "measured", "baseline", "measured / baseline", "wanted")
Row = tuple[str, float, float | None, str]


def best(call: Callable[[], object], calls: int = 400, repeats: int = 1) -> float:
    """Return the shortest CPU time of a call [s]."""
    times = []
    for _ in range(calls):
        start = time.thread_time()
        for _ in range(repeats):
            call()
        times.append(time.thread_time() - start)
    return min(times) / repeats


# -- baselines ------------------------------------------------------------------------------------


class ScalarJoints:
    """Joints of `scalar_joints.c` with the backbone of JOINT."""

    def __init__(self, folder: str) -> None:
        library = Path(folder) / "scalar_joints.so"
        source = Path(__file__).with_name("scalar_joints.c")
        command = ["cc", "-O3", "-ffp-contract=off", "-shared", "-fPIC", source, "-o", library]
        subprocess.run([*map(str, command), "-lm"], check=True)
        self.library = ctypes.CDLL(str(library))
        end, count = 4e-6, 4001
        u = np.linspace(0.0, end, count)
        spacing = u[1]
        self.samples = np.column_stack((JOINT.backbone(u), JOINT.backbone_stiffness(u) * spacing))
        self.samples = np.ascontiguousarray(self.samples)

        class Backbone(ctypes.Structure):
            _fields_ = (
                ("samples", ctypes.c_void_p), ("count", ctypes.c_int), ("inverse", ctypes.c_double),
            )  # fmt: skip

        self.backbone = Backbone(self.samples.ctypes.data, count, 1.0 / spacing)

    def _joints(self, count: int) -> np.ndarray:
        return np.zeros(count * self.library.joint_size() // 8)

    def step_time(self, moves: np.ndarray) -> float:
        """Return the time of a trial and a commit of a joint [s]."""
        force, stiffness, steps = np.empty(NODES), np.empty(NODES), np.empty(8 * NODES)
        shortest = np.full(len(moves), np.inf)
        for _ in range(20):
            joints = self._joints(NODES)
            for i, x in enumerate(moves):
                start = time.thread_time()
                self.library.node_steps(
                    _pointer(joints), _pointer(steps), NODES, ctypes.byref(self.backbone),
                    _pointer(x), _pointer(force), _pointer(stiffness),
                )  # fmt: skip
                shortest[i] = min(shortest[i], time.thread_time() - start)
        return float(shortest.sum()) / moves.size

    def record(self, x: np.ndarray) -> np.ndarray:
        """Return the forces along a record [N]."""
        force, joint = np.empty(x.size), self._joints(1)
        self.library.record(
            _pointer(joint), x.size, ctypes.byref(self.backbone), _pointer(x), _pointer(force)
        )
        return force

    def iwan_time(self, moves: np.ndarray) -> float:
        """Return the time of a step of an Iwan model of CELLS sliders [s]."""
        cells = JOINT.to_iwan(CELLS)
        stiffness, limit = (np.array(v, float) for v in (cells.stiffnesses, cells.force_limits))
        reach = limit / stiffness
        force, tangent = np.empty(NODES), np.empty(NODES)
        sliders = np.zeros((NODES, stiffness.size))

        def steps_in_c(x: np.ndarray) -> None:
            self.library.iwan_steps(
                NODES,
                stiffness.size,
                *map(_pointer, (stiffness, reach, sliders, x, force, tangent)),
            )

        step: Callable[[np.ndarray], Any] = steps_in_c
        compiled = _numba_iwan()
        if compiled is not None:

            def steps_by_numba(x: np.ndarray) -> None:
                compiled(stiffness, reach, sliders, x, force, tangent)

            step = steps_by_numba
        step(moves[0])
        return min(best(lambda x=x: step(x), 5) for x in moves) / NODES


def _pointer(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def _numba_iwan() -> Any:
    """Return a compiled step of Iwan models, None without Numba."""
    try:
        import numba
    except ImportError:
        return None

    @numba.njit(fastmath=True)  # type: ignore[untyped-decorator]
    def steps(k: Any, reach: Any, sliders: Any, x: Any, force: Any, tangent: Any) -> None:
        for i in range(x.size):
            total, slope = 0.0, 0.0
            for c in range(k.size):
                u = x[i] - sliders[i, c]
                slope += k[c] if abs(u) < reach[c] else 0.0
                u = min(max(u, -reach[c]), reach[c])
                sliders[i, c] = x[i] - u
                total += k[c] * u
            force[i], tangent[i] = total, slope

    return steps


# -- rows -----------------------------------------------------------------------------------------


def step_rows(baseline: ScalarJoints) -> list[Row]:
    """Return the rows of node steps and of the fixed cost of a step."""
    rng = np.random.default_rng(1)
    field = ms.JointField(SURFACE, 0.5, areas=1e-5, pressures=rng.uniform(1e5, 2e7, NODES))
    phases = rng.uniform(0.0, 6.0, NODES)
    motions = {
        "smooth": 2e-7 * np.sin(0.1 * np.arange(STEPS)[:, None] + phases),
        "noise": 2e-7 * rng.normal(size=(STEPS, NODES)),
    }
    wanted = {("held", "smooth"): 45, ("held", "noise"): 75, ("varying", "smooth"): 80,
              ("varying", "noise"): 130}  # fmt: skip
    scalar = {kind: baseline.step_time(moves) for kind, moves in motions.items()}
    rows: list[Row] = []
    for load in ("held", "varying"):
        for kind, moves in motions.items():
            paths = field.separations + 0.5 * np.roll(moves, 3, axis=0)
            shortest = np.full(STEPS, np.inf)
            for _ in range(20):
                state = field.start()
                for i, x in enumerate(moves):
                    start = time.thread_time()
                    state.try_(x, None if load == "held" else paths[i])
                    state.commit()
                    shortest[i] = min(shortest[i], time.thread_time() - start)
            name = f"node step, {load}, {kind} (scalar C, held)"
            seconds = float(shortest.sum()) / moves.size
            rows.append((name, seconds, scalar[kind], f"≤ {wanted[load, kind]} ns"))
    rows.append((
        f"node step, held, smooth (Iwan of {CELLS} sliders, "
        f"{'Numba' if _numba_iwan() else 'C'}, not exact)",
        rows[0][1], baseline.iwan_time(motions["smooth"]), "",
    ))  # fmt: skip
    state, place = JOINT.start(), np.array([1e-7])
    one = ms.JointField(SURFACE, 0.5, areas=[1e-5], loads=[100.0])
    nodes, gap = one.start(), one.separations

    def scalar_step() -> None:
        state.try_(1e-7)
        state.commit()

    def field_step(separations: Any = None) -> None:
        nodes.try_(place, separations)
        nodes.commit()

    fixed = best(scalar_step, 400, 20)
    rows.append(("step of a field of one node (scalar State)", best(field_step, 400, 20), fixed,
                 "≤ 6 µs"))  # fmt: skip
    seconds = best(lambda: field_step(gap), 400, 20)
    rows.append(("the same with a separation (scalar State)", seconds, fixed, ""))
    return rows


def record_rows(baseline: ScalarJoints) -> list[Row]:
    """Return the rows of records, per sample."""
    rows: list[Row] = []
    for power in (4, 5, 6):
        x = 3e-7 * np.sin(2.0 * np.pi / 1000 * np.arange(10**power))
        calls = 10 ** (7 - power)
        ours, theirs = (
            best(lambda f=f, x=x: f(x), calls) / x.size for f in (JOINT.force, baseline.record)
        )
        rows.append((f"record of 1e{power} samples, a sample (scalar C)", ours, theirs, "≤ 5 ns"))
    return rows


def state_rows() -> list[Row]:
    """Return the rows of trial and commit of one state of each law."""

    def seconds(law: Any) -> float:
        state = law.start()
        stiffness = law.tangential_stiffness
        scale = law.force_limit / stiffness if np.isfinite(stiffness) else 1e-6
        places = (1.2 * scale * np.sin(0.37 * np.arange(100))).tolist()

        def steps() -> None:
            for x in places:
                state.try_(x)
                state.commit()

        return best(steps, 10) / len(places)

    laws = {
        "Coulomb": ms.Coulomb(10.0), "Jenkins": ms.Jenkins(1e7, 10.0),
        "Segalman": ms.SegalmanIwan.examples()[0], "Iwan of 50 cells": JOINT.to_iwan(50),
        "sphere": ms.Asperity.examples()[0], "Parallel": ms.Parallel.examples()[0],
    }  # fmt: skip
    baseline = seconds(JOINT)
    return [
        (f"trial and commit of a State of {name} (Interface)", seconds(law), baseline, "")
        for name, law in laws.items()
    ]


def harmonics_rows() -> list[Row]:
    """Return the rows of harmonics."""
    heights = np.random.default_rng(1).normal(size=500) * 5e-7
    summits = ms.AsperityPopulation(PAIR, heights, 1e-3)
    laws = {
        "Jenkins": ms.Jenkins(1e7, 10.0), "Segalman": ms.SegalmanIwan.examples()[0],
        "Iwan of 50 cells": JOINT.to_iwan(50), "sphere": ms.Asperity.examples()[0],
        "Parallel": ms.Parallel.examples()[0],
        "500 listed summits": ms.Interface(summits, 0.5, normal_load=float(summits.load(0.0))),
    }  # fmt: skip
    rows: list[Row] = []
    for harmonics, shares in (
        ([0, 1], [0.1, 1.3, 0.4]),
        ([0, 1, 3], [0.1, 1.3, 0.4, 0.2, 0.3]),
    ):

        def seconds(law: Any, shares: Any = shares, harmonics: Any = harmonics) -> float:
            c = law.force_limit / law.tangential_stiffness * np.array(shares)
            return best(lambda: law.harmonics(c, harmonics), 200)

        baseline = seconds(JOINT)
        for name, law in laws.items():
            wanted = "" if len(harmonics) > 2 else "≤ 0.5 ms" if "500" in name else "≤ 60 µs"
            text = f"harmonics {harmonics} of {name} (Interface)"
            rows.append((text, seconds(law), baseline, wanted))
    c, square = 3e-7 * np.array([0.0, 1.0, 0.2, 0.3, 0.1]), ms.Coulomb(10.0)
    first = best(lambda: JOINT.harmonics(c[:3], [0, 1]), 200)
    own = best(lambda: square.harmonics(c[:3], [0, 1]), 200)
    rows.append(("harmonics [0, 1] of Coulomb (Interface)", own, first, ""))
    low = best(lambda: JOINT.harmonics(c, [0, 1, 25]), 50)
    for top in (50, 200, 400):
        own = best(lambda top=top: JOINT.harmonics(c, [0, 1, top]), 20)
        rows.append((f"harmonics [0, 1, {top}] of Interface ([0, 1, 25])", own, low, ""))
    return rows


def tmdsimpy_row(folder: str) -> Row:
    """Return the row of a Jenkins element in TMDSimPy, harmonics 0 to 3, 128 samples."""
    sys.path.insert(0, folder)
    from tmdsimpy.nlforces.vector_jenkins import VectorJenkins

    from microslip.export.hosts.tmdsimpy import JointForce

    one, harmonics = np.eye(1), np.arange(4)
    theirs = VectorJenkins(one, one, 2.0, 3.0)
    ours = JointForce(one, one, ms.Jenkins(2.0, 3.0))
    u = np.array([0.1, 1.3, 0.4, 0.1, 0.2, 0.2, 0.3]) * 2.0
    times = [best(lambda f=f: f.aft(u, 1.0, harmonics, 128), 200) for f in (ours, theirs)]
    return "JointForce(Jenkins) in TMDSimPy (its VectorJenkins)", times[0], times[1], "≤ 0.6 ms"


def text_of(seconds: float) -> str:
    units = ((1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns"))
    size, unit = next((u for u in units if seconds >= u[0]), units[-1])
    return f"{seconds / size:.3g} {unit}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--page", action="store_true", help="write the table to docs/timings.md")
    parser.add_argument("--tmdsimpy", metavar="FOLDER", help="folder of the package tmdsimpy")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        baseline = ScalarJoints(folder)
        rows = step_rows(baseline) + record_rows(baseline) + state_rows() + harmonics_rows()
    if options.tmdsimpy:
        rows.append(tmdsimpy_row(options.tmdsimpy))
    lines = [HEAD, ("---", "---:", "---:", "---:", "---:")]
    for name, seconds, beside, wanted in rows:
        ratio = f"{seconds / beside:.2g}" if beside else ""
        lines.append((name, text_of(seconds), text_of(beside) if beside else "", ratio, wanted))
    table = "\n".join(f"| {' | '.join(line)} |" for line in lines)
    print(table)
    if options.page:
        write_section("timings.md", "solver rows", "solver_rows.py", table)


if __name__ == "__main__":
    main()
