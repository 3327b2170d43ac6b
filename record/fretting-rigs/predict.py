"""Tangential stiffness of a small fretting contact: the faces in series with the bodies behind.

Steel on steel, 1 mm2 under 60 N. The half spaces behind a square contact have about 102 N/um.
"""

import numpy as np
from scipy.stats import qmc

import microslip as ms

AREA, LOAD = 1e-6, 60.0  # m^2, N
RMS = (2e-7, 1e-6)  # m, Rq of one face, log-uniform: ground to fine turned
SLOPE = (0.05, 0.2)  # Rdq of one face, log-uniform
HARDNESS = (2e9, 4e9)  # Pa, log-uniform
BODIES = 102e6  # N/m


def predict() -> dict[str, tuple[float, float, float]]:
    """Return the stiffness that a rig with stiff sensors measures."""
    found = []
    for u, v, w in qmc.Sobol(3, seed=1).random(128):
        steel = ms.Material(210e9, 0.3, hardness=HARDNESS[0] * (HARDNESS[1] / HARDNESS[0]) ** w)
        face = ms.DrawnFace(
            ms.MaterialPair(steel, steel),
            rms=np.sqrt(2.0) * RMS[0] * (RMS[1] / RMS[0]) ** u,
            slope=np.sqrt(2.0) * SLOPE[0] * (SLOPE[1] / SLOPE[0]) ** v,
            area=AREA,
            tightening_pressure=LOAD / AREA,
        )
        joint = ms.Interface(face, 0.3, normal_load=LOAD)
        found.append(1.0 / (1.0 / joint.tangential_stiffness + 1.0 / BODIES))
    low, middle, high = map(float, np.quantile(found, (0.05, 0.5, 0.95)))
    return {"tangential stiffness": (low, middle, high)}
