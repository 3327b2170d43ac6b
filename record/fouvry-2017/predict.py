"""Energy of gross slip under a normal load that swings in phase with the slip.

The slip is held at 75 µm in the tests, so that nothing but friction and the load enters: a thin
elastic layer stands for the cylinder, whose slip length (0.6 nm) is nothing beside 75 µm.
"""

import numpy as np

import microslip as ms

FRICTION = (0.60, 0.65)  # of the paper; uniform
LARGEST = 1066.0 * 8.0  # N: 1066 N/mm over 8 mm
SLIP = 75e-6  # m
RATIOS = (1.0, 0.75, 0.5, 0.25, 0.1)
TITANIUM = ms.Material(young_modulus=119e9, poisson_ratio=0.286)


def energy(ratio: float, friction: float) -> float:
    """Energy of one settled cycle [J]."""
    separation = np.linspace(0.0, 2e-9, 41)
    load = 2.0 * LARGEST * (1.0 - separation / 2e-9)
    surface = ms.TabulatedNormalLaw(ms.MaterialPair(TITANIUM, TITANIUM), separation, load)
    joint = ms.Interface(surface, friction, normal_load=LARGEST * (1.0 + ratio) / 2.0)
    phase = np.linspace(0.0, 4.0 * np.pi, 8001)
    slip = SLIP * np.sin(phase)
    swing = LARGEST * ((1.0 + ratio) + (1.0 - ratio) * np.sin(phase)) / 2.0
    force = joint.coupled_force(slip, normal_load=swing)
    cycle = slice(4000, 8001)
    return float(np.trapezoid(force[cycle], slip[cycle]))


def predict() -> dict[str, tuple[float, float, float]]:
    """Return 5, 50, 95 % of the energy of each test."""
    low, high = FRICTION
    quantiles = [low + share * (high - low) for share in (0.05, 0.5, 0.95)]
    bands = {ratio: tuple(energy(ratio, mu) for mu in quantiles) for ratio in RATIOS}
    tests = {1.0: 7, 0.75: 3, 0.5: 7, 0.25: 3, 0.1: 7}
    return {
        f"energy of a cycle, Pmin/Pmax = {ratio:g}, test {k + 1}": bands[ratio]
        for ratio, count in tests.items()
        for k in range(count)
    }
