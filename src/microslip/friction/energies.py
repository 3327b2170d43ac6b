"""Where the work of a record goes: what the joint stores, and what it dissipates."""

from __future__ import annotations

import numpy as np

from microslip import kernels
from microslip._checks import Floats
from microslip.friction.base import BackboneLaw
from microslip.memory import Memory


def energies_along(joint: BackboneLaw, x: Floats, force: Floats) -> tuple[Floats, Floats]:
    """Energy that a joint has stored, and that it has dissipated, along a record from rest [J].

    ``x`` and ``force`` are displacements and the joint's forces there, one-dimensional. The sum of
    both answers is the work done on the joint, exactly, however far apart the samples lie.

    First loading to u dissipates E_d(u)/4 and stores u T0(u)/2 - E_d(u)/8; a branch of the length
    2h dissipates E_d(h)/2, and what it stores changes by the work of the force it began with plus
    2 h T0(h). Both follow each branch from its reversal; a loop that closes leaves E_d behind.
    """
    half, sign, parent = Memory().tree(x)
    virgin = parent < 0
    energy, backbone = joint._energy(half), joint._backbone(half)
    above = np.maximum(parent, 0)
    stored = np.where(
        virgin,
        0.5 * half * backbone - 0.125 * energy,
        force[above] * (x - x[above]) + 2.0 * half * backbone,
    )
    lost = np.where(virgin, 0.25, 0.5) * energy
    for rise in (stored, lost):
        kernels.active.accumulate(parent, rise, np.zeros(1))
    # Where a sample neither goes on along a branch nor begins one at a reversal, loops have closed.
    tips = np.where(np.diff(x) * sign[:-1] < 0.0, np.arange(x.size - 1), parent[:-1])
    closed = np.zeros(x.size)
    for i in np.flatnonzero(tips != parent[1:]).tolist():
        tip = int(tips[i])
        while tip >= 0 and tip != parent[i + 1]:
            if parent[tip] < 0:  # from one end of the first loading to the other
                closed[i + 1] += 0.5 * energy[tip]
                break
            closed[i + 1] += energy[tip]
            tip = int(parent[parent[tip]])
    return stored, lost + np.cumsum(closed)
