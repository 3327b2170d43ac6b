"""Frequency and damping of two assemblies of equal flat parts, bolted by their pads.

C1 has both arms in line (first elastic mode), C2 is an L (second elastic mode). Ranges of the
inputs are dated 2026-11-23: frequencies and amplitudes of the tests were known then, and damping
was not. The forces of four bolts have a common mean after a torque of 20 N m and a scatter of
their own. Summits follow Nayak's alpha after McCool; the slope of 0.1 has no effect on an elastic
face. Modal amplitude is taken as that of mass-normalised shapes.
"""

import importlib.util
import math
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.stats import norm, qmc

import microslip as ms

HERE = Path(__file__).parent
ASSEMBLIES = {  # angle of the upper part, turned over, number of the mode, modal amplitudes
    "C1": (0.0, True, 0, [7.8677, 10.3165, 15.5509, 23.081, 30.3514, 45.4404, 68.0398, 101.9406]),
    "C2": (-math.pi / 2, True, 1, [0.44513, 0.57313, 0.83725, 1.21104, 1.55625, 2.25937, 3.26273, 4.78663]),
}  # fmt: skip
YOUNG, DENSITY, POISSON = (190e9, 203e9), (7900.0, 8000.0), 0.29  # stainless steel 304
FRICTION = (0.2, 0.8)  # uniform
TENSION, COMMON, EACH = 11580.0, 0.15, 0.13  # N, coefficients of variation
FORM = (-10e-6, 10e-6)  # m at the edge of the pad, parabola along and across
ROUGHNESS = (0.4e-6, 3.2e-6)  # m, Ra of each face, log-uniform
NAYAK = (2.0, 50.0)  # log-uniform
BASE_DAMPING = (1e-4, 6e-4)  # log-uniform: strings and air, steel
SLOPE, HALF = 0.1, 31.75e-3
PATCHES, SAMPLES = (6, 6), 64


def uniform(limits, u):
    """Quantile of a uniform distribution."""
    return limits[0] + u * (limits[1] - limits[0])


def log_uniform(limits, u):
    """Quantile of a log-uniform distribution."""
    return limits[0] * (limits[1] / limits[0]) ** u


def log_normal(mean, variation, u):
    """Quantile of a log-normal distribution by its mean and coefficient of variation."""
    spread = math.sqrt(math.log1p(variation**2))
    return mean * math.exp(spread * norm.ppf(u) - 0.5 * spread**2)


def surface(young, roughness, nayak):
    """Summits of both faces together, heights of Gaussian faces with these Ra."""
    m0 = 0.5 * math.pi * sum(ra**2 for ra in roughness)
    m2 = SLOPE**2
    m4 = nayak * m2**2 / m0
    steel = ms.Material(young, POISSON)
    return ms.GreenwoodWilliamson(
        ms.MaterialPair(steel, steel),
        ms.Gaussian(std=math.sqrt((1.0 - 0.8968 / nayak) * m0)),
        radius=0.375 * math.sqrt(math.pi / m4),
        density=m4 / m2 / (6.0 * math.pi * math.sqrt(3.0)),
        area=1e-4,
    )


def reduced(angle, mirrored):
    """The reduced assembly with nominal steel."""
    spec = importlib.util.spec_from_file_location("assembly", HERE / "assembly.py")
    mesher = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(mesher)
    steel = (ms.Material(np.mean(YOUNG), POISSON), np.mean(DENSITY))
    shanks = [f"shank {number}" for number in range(1, 5)]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "assembly.inp"
        mesher.write(path, angle, mirrored)
        joint = ms.MeshedJoint.read(
            path,
            bodies=dict.fromkeys(["part 1", "part 2", "heads", *shanks], steel),
            contacts=[("face 1", "face 2")],
            bolts=dict.fromkeys(shanks, TENSION),
        )
    return joint.reduce(PATCHES, along=[1.0, 0.0, 0.0])


def predict():
    """Return frequency and damping at eight amplitudes of each assembly."""
    answers = {}
    for name, (angle, mirrored, mode, amplitudes) in ASSEMBLIES.items():
        nominal, curves = reduced(angle, mirrored), []
        for u in qmc.Sobol(14, seed=1).random(SAMPLES):
            young, density = uniform(YOUNG, u[0]), uniform(DENSITY, u[1])
            stiffer, heavier = young / np.mean(YOUNG), density / np.mean(DENSITY)
            joint = replace(
                nominal,
                mass=heavier * nominal.mass,
                stiffness=stiffer * nominal.stiffness,
                bolt_stiffness=stiffer * nominal.bolt_stiffness,
            )
            common = log_normal(TENSION, COMMON, u[2])
            along, across = uniform(FORM, u[7]), uniform(FORM, u[8])
            joint = joint.with_tension(
                [common * log_normal(1.0, EACH, v) for v in u[3:7]]
            ).with_form(lambda x, y, a=along, b=across: a * (x / HALF) ** 2 + b * (y / HALF) ** 2)
            law = surface(
                young, [log_uniform(ROUGHNESS, v) for v in u[9:11]], log_uniform(NAYAK, u[11])
            )
            curve = joint.tightened(law, uniform(FRICTION, u[12])).modes(
                mode, 1e-6 * np.array(amplitudes), damping_ratio=log_uniform(BASE_DAMPING, u[13])
            )
            if curve.converged.all():
                curves.append((curve.frequency, curve.damping_ratio))
        if len(curves) < 0.9 * SAMPLES:
            raise ValueError(f"{name}: only {len(curves)} of {SAMPLES} samples converged")
        for number, words in enumerate(("frequency", "damping ratio")):
            bands = np.quantile([curve[number] for curve in curves], (0.05, 0.5, 0.95), axis=0).T
            for amplitude, band in zip(amplitudes, bands, strict=True):
                answers[f"{name}, {words} at {amplitude:.3g}e-6 m kg^0.5"] = tuple(map(float, band))
    return answers
