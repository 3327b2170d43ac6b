"""Exponent of the dissipated energy in the force of a bolted lap.

A lap of 30 mm, 25.4 mm wide and 6.35 mm thick, is a bar on springs and sliders whose pressure falls
to zero at the loaded edge as x^n. Each place is tightened by its own pressure, so that its force is
that of one face times its share of the load. The exponent is the slope of a straight line through
ln E against ln F between 5 and 50 % of the force of gross slip.
"""

import numpy as np
from scipy.linalg import solveh_banded
from scipy.stats import qmc

import microslip as ms

LENGTH, WIDTH, STIFFNESS = 30e-3, 25.4e-3, 200e9 * 25.4e-3 * 6.35e-3
PRESSURE = (20e6, 100e6)  # Pa, the largest, log-uniform
EXPONENT = (1.0, 2.0)  # n of the pressure at the edge, uniform
FRICTION = (0.2, 0.6)  # uniform
RMS = (4e-7, 1.6e-6)  # m, Rq of one face, log-uniform: ground to milled
SLOPE = (0.1, 0.25)  # Rdq of one face, log-uniform
NODES = 400
SHARES = np.geomspace(0.05, 0.5, 7)  # of the force of gross slip


def exponent(pressure: float, n: float, friction: float, rms: float, slope: float) -> float:
    """Slope of ln E against ln F."""
    steel = ms.Material(200e9, 0.3, hardness=2.4e9)
    face = ms.DrawnFace(
        ms.MaterialPair(steel, steel), rms=rms, slope=slope, area=1e-4, tightening_pressure=pressure
    )
    joint = ms.Interface(face, friction, normal_load=pressure * 1e-4)
    edges = np.linspace(0.0, 1.0, NODES + 1)
    loads = pressure * LENGTH * WIDTH * np.diff(edges ** (n + 1.0)) / (n + 1.0)
    shares = loads / joint.normal_load
    spring = STIFFNESS / (LENGTH / NODES)
    energies = []
    for force in SHARES * friction * loads.sum():
        u = np.zeros(NODES)
        for _ in range(200):
            rest = shares * joint.backbone(u)
            rest[:-1] += spring * (u[:-1] - u[1:])
            rest[1:] += spring * (u[1:] - u[:-1])
            rest[0] -= force
            band = np.zeros((2, NODES))
            band[1] = shares * joint.backbone_stiffness(u) + 1e-12 * spring
            band[1, :-1] += spring
            band[1, 1:] += spring
            band[0, 1:] = -spring
            step = solveh_banded(band, -rest)
            u = np.maximum(u + step, 0.0)
            if np.abs(step).max() < 1e-9 * u.max():
                break
        else:
            raise ValueError("the lap did not come to rest")
        energies.append(float((shares * joint.dissipated_energy(np.maximum(u, 1e-15))).sum()))
    return float(np.polyfit(np.log(SHARES), np.log(energies), 1)[0])


def predict() -> dict[str, tuple[float, float, float]]:
    """Return the exponent."""
    found = []
    for row in qmc.Sobol(5, seed=1).random(64):
        found.append(
            exponent(
                PRESSURE[0] * (PRESSURE[1] / PRESSURE[0]) ** row[0],
                EXPONENT[0] + row[1] * (EXPONENT[1] - EXPONENT[0]),
                FRICTION[0] + row[2] * (FRICTION[1] - FRICTION[0]),
                np.sqrt(2.0) * RMS[0] * (RMS[1] / RMS[0]) ** row[3],
                np.sqrt(2.0) * SLOPE[0] * (SLOPE[1] / SLOPE[0]) ** row[4],
            )
        )
    low, middle, high = map(float, np.quantile(found, (0.05, 0.5, 0.95)))
    return {"exponent of the energy in the force": (low, middle, high)}
