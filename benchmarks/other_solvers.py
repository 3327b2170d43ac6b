"""Pressures of one rough face by microslip, tamaas and ContactMechanics: seconds and digits.

`OMP_NUM_THREADS=1 python benchmarks/other_solvers.py [POINTS ...]` presses generated faces, 128 and
256 points square unless told otherwise, mirrored at their sides, to an elastic half space under a
mean pressure of 0.02 E* h'. What is not installed is left out and said (`pip install tamaas
ContactMechanics SurfaceTopography`, in an environment of its own: tamaas is AGPL, a program apart).
Seconds are the least of three runs, from a start at nothing. The others press under a load and on
the grid of twice the side, this project at a separation and with cosines on the grid itself; the
load is what it found. A difference is the largest of any point over the largest pressure. With a
hardness there is nothing to compare with: tamaas's saturated solver (`KatoSaturated`) was not at
the pressures of least energy after 10 000 steps.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import math
import sys
import time
from collections.abc import Callable
from functools import partial

import numpy as np
from rough_faces import rough

from microslip.contact.boundary_elements import HalfSpace, press

RUNS = 3
RELATIVE = 0.02  # mean pressure over E* h'
TOLERANCE = 1e-9  # of the rms height


def face(points: int) -> np.ndarray:
    """Heights of a generated face [pixels] about their mean."""
    z = rough(points, 2e-6, 5e-7, longest=6e-5, shortest=1.77e-5, seed=3) / 2e-6
    return np.asarray(z - z.mean())


def mirrored(z: np.ndarray) -> np.ndarray:
    """The face with its mirror images, which repeats."""
    return np.block([[z, z[:, ::-1]], [z[::-1], z[::-1, ::-1]]])


def separation_of(z: np.ndarray, pressure: float) -> float:
    """Separation [pixels] that bears about a mean pressure [E*]."""
    space, low, high = HalfSpace(z.shape), 0.0, float(z.max())
    for _ in range(14):
        d = 0.5 * (low + high)
        p = press(space, z, d, tolerance=1e-3 * z.std())
        low, high = (d, high) if p.mean() > pressure else (low, d)
    return high


def by_microslip(z: np.ndarray, separation: float) -> np.ndarray:
    """Pressures [E*] at a separation [pixels]."""
    return press(HalfSpace(z.shape), z, separation, tolerance=TOLERANCE * z.std())


def by_tamaas(z: np.ndarray, pressure: float) -> np.ndarray:
    """The same under a mean pressure [E*]."""
    import tamaas

    tamaas.set_log_level(tamaas.LogLevel.error)
    both = mirrored(z)
    model = tamaas.Model(tamaas.model_type.basic_2d, [float(n) for n in both.shape], both.shape)
    model.E, model.nu = 1.0, 0.0
    tamaas.PolonskyKeerRey(model, both, 1e-11).solve(pressure)
    return np.array(model.traction)[: z.shape[0], : z.shape[1]]


def by_contact_mechanics(z: np.ndarray, pressure: float) -> np.ndarray:
    """The same."""
    from ContactMechanics import PeriodicFFTElasticHalfSpace, make_system
    from SurfaceTopography import Topography

    both = mirrored(z)
    size = tuple(float(n) for n in both.shape)
    system = make_system(
        interact="hardwall",
        substrate=PeriodicFFTElasticHalfSpace(both.shape, 1.0, size),
        surface=Topography(both, size, periodic=True),
    )
    found = system.minimize_proxy(
        external_force=pressure * both.size, pentol=TOLERANCE * z.std(), maxiter=20_000
    )
    return np.asarray(found.jac)[: z.shape[0], : z.shape[1]]


def timed(solve: Callable[[], np.ndarray]) -> tuple[np.ndarray, float]:
    """What it finds, and the least seconds of a few runs."""
    seconds = []
    for _ in range(RUNS):
        start = time.perf_counter()
        found = solve()
        seconds.append(time.perf_counter() - start)
    return found, min(seconds)


def main(arguments: list[str] | None = None) -> int:
    """Print the table; the exit status is 1 where digits are missing, 2 where nothing compares."""
    parser = argparse.ArgumentParser(description="Pressures by three programs: seconds and digits.")
    parser.add_argument("points", nargs="*", type=int, default=[128, 256])
    others = {"tamaas": by_tamaas, "ContactMechanics": by_contact_mechanics}
    compared, worst = 0, 0.0
    print("| points | program | seconds | largest difference |")
    print("| --- | --- | --- | --- |")
    for points in parser.parse_args(arguments).points:
        z = face(points)
        slope = math.sqrt(sum(float(np.mean(np.diff(z, axis=k) ** 2)) for k in (0, 1)))
        d = separation_of(z, RELATIVE * slope)
        mine, seconds = timed(partial(by_microslip, z, d))
        print(f"| {points}² | microslip | {seconds:.2f} | |", flush=True)
        for name, solve in others.items():
            try:
                version = importlib.metadata.version(name)
                theirs, seconds = timed(partial(solve, z, float(mine.mean())))
            except (ImportError, RuntimeError) as error:
                print(f"{name}: left out: {error or type(error).__name__}", file=sys.stderr)
                continue
            off = float(np.abs(theirs - mine).max() / mine.max())
            compared, worst = compared + 1, max(worst, off)
            print(f"| {points}² | {name} {version} | {seconds:.2f} | {off:.1e} |", flush=True)
    if not compared:
        print("nothing to compare with is installed", file=sys.stderr)
        return 2
    return int(worst > 1e-6)


if __name__ == "__main__":
    sys.exit(main())
