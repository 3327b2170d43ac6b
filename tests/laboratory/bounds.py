"""Smallest standard errors of the energy that any linear unbiased estimate without a law can have.

``python -m laboratory.bounds [SETS]`` prints their median for the sets of :mod:`.free_form`. The
model is linear in the stiffnesses of explicit sliders on a fine grid of thresholds, without signs
(Gauss and Markov). The shifts between the loads, the shape of the motion and the load within the
cycle count as known; the amplitude and the phase of the motion are as uncertain as the samples
make them. A given rig is not determined by loops, so its error adds to that of the joint.
"""

from __future__ import annotations

import sys

import numpy as np
from scipy.linalg import solve_triangular

from .free_form import RIG_ERROR, Floats, Loops, loops_of

_SAMPLES = 900
"""Most samples of a cycle that is computed."""


def stops(y: Floats, u: Floats) -> Floats:
    """Return the deflections of stop elements along a closed cycle, shape (steps, elements)."""
    state, out = np.minimum(y, u[0]), np.empty((u.size - 1, y.size))
    for _ in range(2):
        for i in range(1, u.size):
            state = np.clip(state + (u[i] - u[i - 1]), -y, y)
            out[i - 1] = state
    return out


def _motion(drive: str, size: float, turn: Floats) -> Floats:
    angle = 2.0 * np.pi * turn
    if drive == "triangle":
        return size * (4.0 * np.abs(turn % 1.0 - 0.5) - 1.0)
    return size * np.cos(angle)


class Bound:
    """Information of the records of a set on its sliders."""

    def __init__(self, loops: Loops) -> None:
        self.loops = loops
        noise = float(loops.sources["noise"][:-2]) / 100.0
        self.rig = loops.options["rig_stiffness"][0] if loops.options else np.inf
        self.series = [
            sliders.behind(self.rig) if loops.options else sliders
            for _, sliders, _, _ in loops.truth
        ]
        sizes = [
            [a + sliders.force(a) / self.rig for a in amplitudes]
            for _, sliders, amplitudes, _ in loops.truth
        ]
        least, most = min(map(min, sizes)), max(map(max, sizes))
        high = self.series[0]
        # B_low(u) = B_high(s + u) - B_high(s): the shift s of each load.
        corners = np.append(0.0, np.sort(high.y))
        forces = np.array([high.force(u) for u in corners])
        limits = np.array([sliders.force_limit for sliders in self.series])
        self.shifts = np.interp(high.force_limit - limits, forces, corners)
        grid = np.geomspace(least / 60.0, most, 70)
        self.y = np.unique(np.append((grid + self.shifts[:, None]).ravel(), 50.0 * most))
        # No slider has more than the whole force: a weak prior that keeps equal columns solvable.
        self.scale = high.force_limit / np.minimum(self.y, most)
        whole = []
        records = iter(loops.records)
        motions: list[Floats] = []
        for shift, sliders, amplitudes in zip(self.shifts, self.series, sizes, strict=True):
            for size in amplitudes:
                count = next(records).displacement.size
                steps = min(count, _SAMPLES)
                turn = (np.arange(-1, steps + 1) + 0.37) / steps

                def of(factor: float, lag: float, y: Floats, turn=turn, size=size) -> Floats:
                    u = _motion(loops.sources["drive"], size * factor, turn + lag)
                    return stops(y, np.append(size * factor, u))[2:]

                force = of(1.0, 0.0, sliders.y) @ sliders.k
                error = noise * np.abs(force).max() * np.sqrt(steps / count)
                part = noise / 3.0 * np.sqrt(2.0 / count)
                step = 1e-3
                moved = [
                    (of(1.0 + step, 0.0, sliders.y) @ sliders.k - force) / step * part,
                    (of(1.0, step, sliders.y) @ sliders.k - force) / step * part / (2.0 * np.pi),
                ]
                motions += [row / error for row in moved]
                whole.append(of(1.0, 0.0, np.maximum(self.y - shift, 0.0)) * self.scale / error)
        columns = self.y.size + len(motions)
        rows, at = [], self.y.size
        for design in whole:
            block = np.zeros((design.shape[0], columns))
            block[:, : self.y.size] = design
            block[:, at : at + 2] = np.column_stack(
                motions[at - self.y.size : at - self.y.size + 2]
            )
            at += 2
            rows.append(block - block.mean(axis=0))
        triangle = np.linalg.qr(np.vstack(rows), mode="r")
        self.root = np.linalg.qr(np.vstack((triangle, np.eye(columns))), mode="r")

    def of(self, level: int, a: float) -> float:
        """Return the relative standard error of the energy at an amplitude a [m] at a load."""
        joint, series = self.loops.truth[level][1], self.series[level]
        u, y = a + joint.force(a) / self.rig, np.maximum(self.y - self.shifts[level], 0.0)
        force, step = series.force(u), 1e-4 * u
        slope = (series.force(u + step) - series.force(u - step)) / (2.0 * step)
        by_u = 4.0 * max(force - u * slope, 0.0) / max(1.0 - slope / self.rig, 1e-3)
        c = np.zeros(self.root.shape[1])
        c[: y.size] = 4.0 * y * np.maximum(u - y, 0.0) + by_u / self.rig * np.minimum(u, y)
        c[: y.size] *= self.scale
        variance = float(np.sum(solve_triangular(self.root, c, trans="T") ** 2))
        by_rig = by_u * force / self.rig * RIG_ERROR if self.loops.options else 0.0
        return float(np.hypot(np.sqrt(variance), by_rig)) / joint.dissipated_energy(a)


def bounds(seed: int) -> tuple[list[float], list[float], bool]:
    """Return errors at the largest amplitude of each load and at half the smallest; and the rig."""
    loops = loops_of(seed)
    bound, share = Bound(loops), 0.98 if loops.options else 1.0
    truth = [(row[1], share * max(row[2]), 0.5 * min(row[2])) for row in loops.truth]
    large = [
        bound.of(i, a) for i, (one, a, _) in enumerate(truth) if one.dissipated_energy(a) > 0.0
    ]
    one, _, a = truth[0]
    small = [bound.of(0, a)] if one.dissipated_energy(a) > 0.0 else []
    return large, small, bool(loops.options)


def main() -> None:
    """Print the median absolute errors of normal estimates with these standard errors."""
    rng, found = np.random.default_rng(0), [bounds(seed) for seed in range(int(sys.argv[1]))]
    for name, at in (("largest amplitude", 0), ("half the smallest", 1)):
        for which, rigs in (("all", (True, False)), ("no given rig", (False,))):
            errors = np.array([e for row in found if row[2] in rigs for e in row[at]])
            median = np.median(np.abs(errors[:, None] * rng.normal(size=(errors.size, 2000))))
            print(f"E at {name}, {which}: {100.0 * median:.4f} % ({errors.size} estimates)")


if __name__ == "__main__":
    main()
