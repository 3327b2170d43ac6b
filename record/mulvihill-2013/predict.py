"""Stiffness of unloading (ultrasound) over that of first loading (load-deflection) at 70 MPa.

The roughness of the specimens is not published with the ratio, so that priors are those of ground
and turned faces. Hardness: Ti-6Al-4V, 330 to 360 HV.
"""

import numpy as np
from scipy.stats import qmc

import microslip as ms

SLOPE = (0.05, 0.3)  # Rdq of one face, log-uniform: ground to turned
RMS = (2e-7, 2e-6)  # m, Rq of one face, log-uniform
HARDNESS = (3.2e9, 3.6e9)  # Pa, uniform
PRESSURE = 70e6  # Pa


def between(low: float, high: float, share: float) -> float:
    """Quantile of a log-uniform range."""
    return float(low * (high / low) ** share)


def predict() -> dict[str, tuple[float, float, float]]:
    """Return the ratio of the stiffnesses."""
    ratios = []
    for u, v, w in qmc.Sobol(3, seed=1).random(128):
        hardness = HARDNESS[0] + w * (HARDNESS[1] - HARDNESS[0])
        titanium = ms.Material(119e9, 0.286, hardness=hardness)
        face = ms.DrawnFace(
            ms.MaterialPair(titanium, titanium),
            rms=np.sqrt(2.0) * between(*RMS, v),
            slope=np.sqrt(2.0) * between(*SLOPE, u),
            area=1e-4,
            tightening_pressure=PRESSURE,
        )
        unloading = face.stiffness(face.separation(PRESSURE * face.area))
        ratios.append(float(unloading / face.first_loading.stiffness[-1]))
    low, middle, high = map(float, np.quantile(ratios, (0.05, 0.5, 0.95)))
    return {"stiffness by ultrasound over stiffness by load-deflection": (low, middle, high)}
