"""Damping and frequency of the first bending mode of the half-thickness Brake-Reuss beam.

Ranges of the inputs are dated 2026-11-23, before damping was compared. The statistics of the faces
and their form are those of a full-thickness beam (brb_surface_data.mat of tmdsimpy, MIT). Base
damping is a single number.
"""

from pathlib import Path

import numpy as np
from scipy import io
from scipy.stats import lognorm, qmc

import microslip as ms

STEEL = ms.Material(192.31e9, 0.3)
DENSITY = 7784.3  # kg/m^3
FRICTION = (0.1, 0.6)  # uniform: nothing is known of oil and wear
TENSION, VARIATION = 12250.0, 0.3  # N, coefficient of variation of bolts tightened by torque
FORM = (-1.0, 1.0)  # uniform share of the form of another beam: its sign is unknown
BASE_DAMPING = 0.00139
AMPLITUDES = np.array([19.5497, 79.1865, 116.942, 158.304, 197.549, 236.394, 275.623, 314.706])
SAMPLES = 32
DATA = Path(__file__).parents[3] / "shared" / "data" / "scans" / "brb_surface_data.mat"


def surface() -> ms.GreenwoodWilliamson:
    """Summits with the published densities of gaps."""
    table = {name: np.ravel(value) for name, value in io.loadmat(DATA).items()}
    gaps = table["normzinterp"] * table["z_max"].item()
    heights = ms.TabulatedHeights(0.0 - gaps[::-1], table["pzinterp"][::-1])
    density, radius = table["area_density"].item(), table["Re"].item()
    return ms.GreenwoodWilliamson(ms.MaterialPair(STEEL, STEEL), heights, radius, density, 1.0)


def predict() -> dict[str, tuple[float, float, float]]:
    """Return frequency and damping at the eight levels."""
    law, form = surface(), io.loadmat(DATA)["mesoscale_xygap"]
    bolts = ms.Bolts(
        [-0.03, 0.0, 0.03], shank=0.00794, hole=0.0084, washer=0.01746, tension=TENSION
    )
    beam = ms.LapJoint(length=0.72, width=0.0254, thickness=0.0127, lap=0.12, bolts=bolts)
    joint = beam.reduce(STEEL, DENSITY, sensors={"end": ((-0.285, 0.0, 0.0), "z")})
    spread = np.sqrt(np.log1p(VARIATION**2))
    tensions = lognorm(spread, scale=TENSION * np.exp(-(spread**2) / 2.0))
    frequencies, dampings = [], []
    for u, v, w in qmc.Sobol(3, seed=1).random(SAMPLES):
        friction = FRICTION[0] + u * (FRICTION[1] - FRICTION[0])
        factor = FORM[0] + w * (FORM[1] - FORM[0])
        sample = joint.with_tension(float(tensions.ppf(v))).with_form(form, factor)
        curve = sample.tightened(law, friction).modes(
            0, 1e-6 * AMPLITUDES, at=sample.sensor("end"), damping_ratio=BASE_DAMPING
        )
        if curve.converged.all():
            frequencies.append(curve.frequency)
            dampings.append(curve.damping_ratio)
    if len(dampings) < 0.9 * SAMPLES:
        raise ValueError(f"only {len(dampings)} of {SAMPLES} samples converged")
    answers = {}
    for words, values in (("frequency", frequencies), ("damping ratio", dampings)):
        bands = np.quantile(np.array(values), (0.05, 0.5, 0.95), axis=0).T
        for amplitude, band in zip(AMPLITUDES, bands, strict=True):
            low, median, high = map(float, band)
            answers[f"{words} at {amplitude:.1f} µm"] = (low, median, high)
    return answers
