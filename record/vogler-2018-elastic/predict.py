"""Stiffness of rock fractures at 10.3 MPa: first loading, and unloading over it.

The standard deviation of the aperture was measured; the slope is a prior. The face is elastic: the
hardness of feldspar and quartz, 6 GPa and more, is above what such slopes can load at this modulus.
"""

import numpy as np
from scipy.stats import qmc

import microslip as ms

APERTURE = {"vd1": 0.095e-3, "vd2": 0.105e-3, "vd3": 0.080e-3}  # m, standard deviations
SLOPE = (0.1, 0.5)  # Rdq of the aperture at pixels of 0.1 mm, log-uniform
HARDNESS = 1e15  # Pa, elastic
MODULUS = (10e9, 12e9)  # Pa, of the paper, uniform
PRESSURE = 10.27e6  # Pa


def predict() -> dict[str, tuple[float, float, float]]:
    """Return both numbers of three fractures."""
    answers = {}
    for name, rms in APERTURE.items():
        loading, ratio = [], []
        for u, w in qmc.Sobol(2, seed=1).random(128):
            rock = ms.Material(
                MODULUS[0] + w * (MODULUS[1] - MODULUS[0]),
                0.25,
                hardness=HARDNESS,
            )
            face = ms.DrawnFace(
                ms.MaterialPair(rock, rock),
                rms=rms,
                slope=SLOPE[0] * (SLOPE[1] / SLOPE[0]) ** u,
                area=np.pi * 0.061**2,
                tightening_pressure=PRESSURE,
            )
            first = float(face.first_loading.stiffness[-1])
            unloading = float(face.stiffness(face.separation(PRESSURE * face.area)))
            loading.append(first / face.area)
            ratio.append(unloading / first)
        for words, values in (
            (f"stiffness of first loading, {name}", loading),
            (f"unloading over first loading, {name}", ratio),
        ):
            low, middle, high = map(float, np.quantile(values, (0.05, 0.5, 0.95)))
            answers[words] = (low, middle, high)
    return answers
