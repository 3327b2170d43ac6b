"""How fast many joints are: one call for all against one object after the other.

    python benchmarks/scatter.py [POINTS]

Every point is a joint of its own: its material, roughness, friction, load and amplitude. Times are
of the process on one core; the ratio is to a loop over `Interface` in the same run. Then sweeps of
a hundred thousand loads with heights by scipy.stats and with a thousand given summits.
"""

from __future__ import annotations

import os

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import sys
import time
import timeit
from collections.abc import Callable
from typing import Any

import numpy as np

import microslip as ms

OBJECTS = 300


def sampled(count: int) -> dict[str, Any]:
    """Arguments of so many different joints."""
    rng = np.random.default_rng(0)
    middles = {
        "young_modulus": (69e9, 0.03), "std": (5e-7, 0.15), "radius": (1e-3, 0.2),
        "density": (1e8, 0.2), "friction_coefficient": (0.55, 0.15), "normal_load": (2e3, 0.3),
    }  # fmt: skip
    values = {name: mean * rng.lognormal(0.0, cv, count) for name, (mean, cv) in middles.items()}
    values["poisson_ratio"] = rng.uniform(0.25, 0.35, count)
    values["amplitude"] = 10.0 ** rng.uniform(-8.5, -5.0, count)
    return {**values, "area": 2e-4}


def single_loss_factor(arguments: dict[str, Any], i: int) -> float:
    """The loss factor of one joint, by an object."""
    v = {name: float(x[i]) if np.ndim(x) else float(x) for name, x in arguments.items()}
    metal = ms.Material(v["young_modulus"], v["poisson_ratio"])
    surface = ms.GreenwoodWilliamson(
        ms.MaterialPair(metal, metal), ms.Gaussian(v["std"]), v["radius"], v["density"], v["area"]
    )
    joint = ms.Interface(surface, v["friction_coefficient"], v["normal_load"])
    return float(joint.loss_factor(v["amplitude"]))


def seconds(call: Callable[[], Any], times: int = 3) -> float:
    """CPU seconds, the least of some."""
    return min(timeit.repeat(call, timer=time.process_time, repeat=times, number=1))


def main() -> None:
    """Print the table."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    points = sampled(count)
    ms.evaluate(**sampled(10))
    objects = seconds(lambda: [single_loss_factor(points, i) for i in range(OBJECTS)], 1) / OBJECTS
    factors = ms.evaluate(**points)["loss_factor"]
    worst = max(abs(factors[i] / single_loss_factor(points, i) - 1.0) for i in range(OBJECTS))
    grid = {**sampled(1), "amplitude": np.geomspace(1e-9, 1e-5, 1000)}
    grid["normal_load"] = np.geomspace(100.0, 5e3, max(1, count // 1000))[:, None]
    cases: dict[str, tuple[dict[str, Any], Any]] = {
        "each point a joint, 14 results": (points, None),
        "each point a joint, loss factor": (points, ["loss_factor"]),
        "loads by 1000 amplitudes, loss factor": (grid, ["loss_factor"]),
    }
    print(f"{'one Interface after the other':40} {1e6 * objects:10.2f} us a point")
    for name, (arguments, quantities) in cases.items():
        a_point = seconds(lambda: ms.evaluate(**arguments, quantities=quantities)) / count  # noqa: B023
        print(f"{name:40} {1e6 * a_point:10.3f} us a point, {objects / a_point:6.0f} times faster, "
              f"{1e-6 / a_point:.1f} million a second")  # fmt: skip
    print(f"largest difference to Interface of {OBJECTS} loss factors: {worst:.1e}")
    sweeps()


def sweeps() -> None:
    """A hundred thousand loads of surfaces that have no closed form."""
    from scipy import stats

    metal = ms.Material(69e9, 0.33)
    pair, rng = ms.MaterialPair(metal, metal), np.random.default_rng(0)
    surfaces: dict[str, tuple[Any, float]] = {
        f"scipy.stats.{heights.dist.name}": (
            ms.GreenwoodWilliamson(pair, heights, 1e-3, 1e8, 2e-4),
            1.0,
        )
        for heights in (
            stats.weibull_min(3, scale=1e-6), stats.lognorm(0.5, scale=5e-7),
            stats.gamma(3, scale=3e-7), stats.skewnorm(-4, scale=5e-7), stats.t(5, scale=5e-7),
        )
    }  # fmt: skip
    summits = ms.AsperityPopulation(pair, heights=rng.normal(0.0, 5e-7, 1000), radii=1e-3)
    surfaces["1000 given summits"] = summits, 0.05
    for name, (surface, share) in surfaces.items():
        joints = {"surface": surface, "friction_coefficient": 0.55}
        joints["normal_load"] = share * np.geomspace(100.0, 5e3, 100_000)[:, None]
        for amplitudes in ([1e-7], np.geomspace(1e-9, 1e-5, 10)):
            start = time.process_time()
            ms.evaluate(**joints, amplitude=amplitudes)
            label = f"{name}, 1e5 loads by {len(amplitudes)}"
            print(f"{label:40} {time.process_time() - start:10.2f} s")


if __name__ == "__main__":
    main()
