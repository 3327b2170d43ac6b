"""A bolted beam in TMDSimPy with microslip's contact, and in microslip: frequencies and damping.

`python benchmarks/tmdsimpy_beam.py FOLDER`, where `FOLDER` holds the package `tmdsimpy` (it is on
no package index), runs the steps of its bolted-beam example (`examples/structures/brb_epmc.py`) on
a beam of the same dimensions and the same 481 unknowns, made here: a preload without friction,
modes, then extended periodic motion with harmonics 0 to 3 and 128 samples. `FieldForce` is in place
of 120 `RoughContactFriction`. Each line: the amplitude (mass-normalised), frequency and damping by
TMDSimPy's system and by `Structure`, Newton steps, seconds of a residual with its Jacobian.
"""

from __future__ import annotations

import argparse
import sys
import time

import numpy as np
import scipy.linalg

import microslip as ms

SIZE = 481  # 3 x 120 patches, 3 bolts, 118 modes
PATCHES = (40, 3)
HARMONICS = np.arange(4)
SAMPLES = 128


def beam() -> tuple[ms.ReducedJoint, ms.NormalLaw]:
    """The beam without contact, and the surface of its faces."""
    steel = ms.Material(192.31e9, 0.3)
    surface = ms.GreenwoodWilliamson(
        ms.MaterialPair(steel, steel), ms.Gaussian(std=6e-6), radius=1.4e-3, density=3e6, area=1e-4
    )
    bolts = ms.Bolts([-0.03, 0.0, 0.03], shank=8e-3, hole=9e-3, washer=18e-3, tension=12249.0)
    lap = ms.LapJoint(length=0.72, width=0.0254, thickness=0.0254, lap=0.12, bolts=bolts)
    modes = SIZE - 3 * PATCHES[0] * PATCHES[1] - 3
    return lap.reduce(steel, 7800.0, PATCHES, kept_modes=modes, element_size=3e-3), surface


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", help="folder that holds the package tmdsimpy")
    parser.add_argument("--friction", type=float, default=0.3, help="friction coefficient [-]")
    parser.add_argument("--sliders", type=int, default=1024, help="sliders of a node")
    parser.add_argument("--steps", type=int, default=8, help="amplitudes from 1e-7 to 6e-5")
    options = parser.parse_args()
    sys.path.insert(0, options.folder)
    from tmdsimpy.vibration_system import VibrationSystem

    from microslip.export.hosts.tmdsimpy import FieldForce

    reduced, surface = beam()
    here = reduced.tightened(surface, options.friction)
    bolts, n = here.static_force, reduced.size
    # Of each patch: along, across, and the approach of its faces.
    local = reduced.directions.transpose(1, 2, 0) * np.array([1.0, 1.0, -1.0])[:, None]
    local = local.reshape(-1, n)
    system = VibrationSystem(reduced.mass, reduced.stiffness, ab=[0.0, 0.0])
    field = reduced.field(surface, options.friction)
    system.add_nl_force(FieldForce(local, local.T.copy(), field, sliders=options.sliders))

    system.set_prestress_mu()
    x = here.displacement.copy()
    for _ in range(20):
        force, tangent = system.static_res(x, bolts)[:2]
        step = np.linalg.solve(tangent, -force)
        x += step
        if np.abs(step).max() < 1e-14 * np.abs(x).max():
            break
    system.update_force_history(x)
    system.set_aft_initialize(x)
    system.reset_real_mu()
    tangent = system.static_res(x, bolts)[1]
    first = here.linear_modes(1)
    squares, shapes = scipy.linalg.eigh(
        0.5 * (tangent + tangent.T), reduced.mass, subset_by_index=[0, 9]
    )
    mode = int(np.abs(np.sqrt(np.abs(squares)) / 2.0 / np.pi - first.frequency[0]).argmin())
    moved = abs(x - here.displacement).max()
    print(f"{n} unknowns, {reduced.patches} patches; preloads differ by {moved:.1e} m")
    print(f"at rest: {np.sqrt(squares[mode]) / 2 / np.pi:.3f} Hz, here {first.frequency[0]:.3f} Hz")

    count = 2 * len(HARMONICS) - 1
    fixed = np.zeros(count * n)
    fixed[:n], fixed[n : 2 * n] = bolts, shapes[:, mode]  # no cosine along the mode
    u = np.zeros(count * n + 3)
    u[:n], u[2 * n : 3 * n], u[-3] = x, shapes[:, mode], np.sqrt(squares[mode])
    amplitudes = np.geomspace(1e-7, 6e-5, options.steps)
    curve = here.modes(0, amplitudes)
    for k, amplitude in enumerate(amplitudes):
        u[-1] = np.log10(amplitude)
        steps = 0
        while steps < 12:
            start = time.perf_counter()
            residual, jacobian = system.epmc_res(u, fixed, HARMONICS, Nt=SAMPLES)[:2]
            seconds = time.perf_counter() - start
            change = np.linalg.solve(jacobian, -residual)
            u[:-1] += change
            steps += 1
            if np.linalg.norm(change[n:-2]) < 1e-6 * np.linalg.norm(u[n:-3]):
                break
        print(
            f"{amplitude:.2e}  {u[-3] / 2 / np.pi:9.4f} Hz {50.0 * u[-2] / u[-3]:8.5f} %   "
            f"{curve.frequency[k]:9.4f} Hz {100.0 * curve.damping_ratio[k]:8.5f} %   "
            f"{steps}  {seconds:.2f} s",
            flush=True,
        )


if __name__ == "__main__":
    main()
