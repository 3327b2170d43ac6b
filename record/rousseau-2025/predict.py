"""Energy and peak force of one measured loop from loops at other amplitudes of the same joint.

The loops were digitised from figure 10 of the paper (CC BY 4.0). Errors of digitising: 100 N and 1 µm
(a line's width). The free-form law that `identify` finds is used without a physical model behind it.
"""

from pathlib import Path

import numpy as np

import microslip as ms

FORCE_ERROR, DISPLACEMENT_ERROR = 100.0, 1e-6  # N, m
PRELOAD = 10e3  # N
AMPLITUDE = {"0p03": 28.2e-6, "0p05": 50.9e-6, "0p10": 140e-6}  # m, by hand
PREDICTED = (
    ("0p03", ("0p05", "0p10")),
    ("0p05", ("0p03", "0p10")),
    ("0p03", ("0p10",)),
    ("0p05", ("0p10",)),
)
HERE = Path(__file__).parent


def one_cycle(name: str) -> ms.Record:
    """The digitised loop from its first turning point to the next one of the same side."""
    table = np.loadtxt(HERE / f"rousseau2025_steel_{name}.csv", delimiter=",", skiprows=1)
    u, force = table[:, 0] * 1e-3, table[:, 1] * 1e3
    turns, current, sign = [], 0, np.sign(u[3] - u[0])
    for k in range(u.size):
        if sign * (u[k] - u[current]) > 0.0:
            current = k
        elif sign * (u[current] - u[k]) > 0.6 * np.ptp(u):
            turns.append(current)
            sign, current = -sign, k
    cycle = slice(turns[0], turns[2] + 1)
    return ms.Record(displacement=u[cycle], force=force[cycle])


def predict() -> dict[str, tuple[float, float, float]]:
    """Return energy and peak force of the loops that were held out."""
    loops = {name: one_cycle(name) for name in AMPLITUDE}
    answers = {}
    for name, others in PREDICTED:
        found = ms.identify(
            [loops[other] for other in others],
            normal_load=PRELOAD,
            noise=(FORCE_ERROR, DISPLACEMENT_ERROR),
        )
        source = " and ".join(f"{1e6 * AMPLITUDE[other]:.3g}" for other in others)
        for words, answer in (
            ("energy of a cycle", found.dissipated_energy(AMPLITUDE[name])),
            ("peak force", found.force(AMPLITUDE[name])),
        ):
            words = f"{words} at {1e6 * AMPLITUDE[name]:.3g} µm from {source} µm"
            answers[words] = (float(answer.low), float(answer.value), float(answer.high))
    return answers
