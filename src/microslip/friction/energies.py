"""Energy balance of a record: stored and dissipated energy.

Let E(a) be the energy that a closed cycle of amplitude a dissipates. First loading to a
displacement u dissipates E(u)/4 and stores u T0(u)/2 - E(u)/8. A branch that ends at a distance 2h
from its reversal dissipates E(h)/2, because a slider with yield displacement y (Iwan 1966, DOI
10.1115/1.3625199) slips by 4 (a - y) in a cycle, u - y on first loading and 2 (h - y) on a branch.
The stored energy changes on the branch by F (x - x_r) + 2h T0(h), where F and x_r are the force and
the displacement at the reversal, and x is the displacement at the end of the branch.

A reversal is open until the hysteresis loop that begins at it closes. Both energies of a sample are
sums over its open reversals, from the oldest to the newest. A loop closes where their number
decreases; a closed loop of width 2h has dissipated E(h).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from microslip._core import kernels
from microslip._core.checks import Floats
from microslip._core.kernels import Integers
from microslip.friction.memory import Memory


def energies_along(joint: Any, displacement: Floats, force: Floats) -> tuple[Floats, Floats]:
    """Return stored and dissipated energy [J] at each sample of a record [m, N] from rest."""
    half, sign, parent = Memory().tree(displacement)
    energy, backbone = joint._energy(half), joint._backbone(half)
    above = np.maximum(parent, 0)
    stored = np.where(
        parent < 0,
        0.5 * half * backbone - 0.125 * energy,
        force[above] * (displacement - displacement[above]) + 2.0 * half * backbone,
    )
    kernels.compiled.accumulate(parent, stored, np.zeros(1))
    return stored, _dissipated(energy, sign, parent)


def dissipated_along(joint: Any, displacement: Floats, record: Floats) -> Floats:
    """Return the energy dissipated up to each sample [J] of a displacement record [m] from rest.

    Reversals are found in ``record``, the displacements or forces that were prescribed.
    """
    _, sign, parent = Memory().tree(record)
    first = parent < 0
    half = 0.5 * np.abs(displacement - displacement[np.maximum(parent, 0)])
    half[first] = np.abs(displacement[first])
    return _dissipated(joint._energy(half), sign, parent)


def _dissipated(energy: Floats, sign: Floats, parent: Integers) -> Floats:
    """Return the energy dissipated up to each sample [J].

    ``sign`` and ``parent`` are those of :class:`microslip.friction.memory.record.Tree`. For each
    sample, ``energy`` [J] is that of a cycle whose amplitude is its distance from rest on first
    loading, and else half its distance from the reversal where its branch begins.
    """
    first = parent < 0
    branch = np.where(first, 0.25, 0.5) * energy
    # Two branches make one loop, so a chain of reversals is summed over every other reversal.
    loops, above = 2.0 * branch, np.where(first, -1, parent[np.maximum(parent, 0)])
    kernels.compiled.accumulate(above, loops, np.zeros(1))
    turned = np.append(False, (sign[1:] > 0.0) != (sign[:-1] > 0.0))
    before = np.append(-1, parent[:-1])
    before = np.where(turned, np.arange(parent.size) - 1, before)
    loops = np.append(loops, 0.0)  # at index -1, the origin
    closed = loops[before] - loops[parent]
    kernels.compiled.accumulate(parent, branch, np.zeros(1))
    return np.asarray(branch + np.cumsum(closed))
