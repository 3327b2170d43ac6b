"""Bending frequencies of the Brake-Reuss beam with flat faces and with their measured form.

The form and the gap statistics of the faces are those that Porter and Brake published with their
code (brb_surface_data.mat of tmdsimpy, MIT). The error of 1.5 % is the difference of the
fixed-interface frequencies of two meshes of this beam.
"""

from pathlib import Path

import numpy as np
from scipy import io

import microslip as ms

STEEL = ms.Material(192.31e9, 0.3)
DENSITY = 7784.3  # kg/m^3
DATA = Path(__file__).parents[3] / "shared" / "data" / "scans" / "brb_surface_data.mat"
ERROR = 0.015


def surface() -> ms.GreenwoodWilliamson:
    """Summits with the published densities of gaps."""
    table = {name: np.ravel(value) for name, value in io.loadmat(DATA).items()}
    gaps = table["normzinterp"] * table["z_max"].item()
    heights = ms.TabulatedHeights(0.0 - gaps[::-1], table["pzinterp"][::-1])
    density, radius = table["area_density"].item(), table["Re"].item()
    return ms.GreenwoodWilliamson(ms.MaterialPair(STEEL, STEEL), heights, radius, density, 1.0)


def predict() -> dict[str, tuple[float, float, float]]:
    """Return the first three frequencies of bending up and down, flat and with the form."""
    law = surface()
    bolts = ms.Bolts(
        [-0.03, 0.0, 0.03], shank=0.00794, hole=0.0084, washer=0.01746, tension=12.25e3
    )
    beam = ms.LapJoint(length=0.72, width=0.0254, thickness=0.0254, lap=0.12, bolts=bolts)
    flat = beam.reduce(STEEL, DENSITY, sensors={"tip": ((0.36, 0.0, 0.0), "z")})
    form = io.loadmat(DATA)["mesoscale_xygap"]
    answers = {}
    for words, joint in (("flat", flat), ("measured form", flat.with_form(form))):
        state = joint.tightened(law, 0.3)
        curves = [state.modes(number, [1e-9]) for number in range(8)]
        motions = [abs(joint.sensor("tip") @ curve.shape[0]) for curve in curves]
        found = [
            curve.linear_frequency
            for curve, motion in zip(curves, motions, strict=True)
            if motion > 0.3 * max(motions)
        ]
        for count, frequency in enumerate(found[:3], 1):
            answers[f"bending mode {count}, {words}"] = (
                frequency * (1.0 - ERROR), frequency, frequency * (1.0 + ERROR)
            )  # fmt: skip
    return answers
