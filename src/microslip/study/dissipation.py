"""Floor 8: the energy that a joint has dissipated along a history, sample by sample."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from microslip import kernels
from microslip.memory import Memory

if TYPE_CHECKING:
    from microslip.friction import BackboneLaw
    from microslip.study.result import Floats


def dissipated_so_far(joint: BackboneLaw, displacement: Floats, record: Floats) -> Floats:
    """Energy dissipated from rest up to each sample.

    Parameters
    ----------
    joint : BackboneLaw
        Any law that obeys Masing's rules.
    displacement : ndarray
        Displacements [m] in the order of time.
    record : ndarray
        What was prescribed, displacements [m] or forces [N]: it says where loops close.

    Returns
    -------
    ndarray
        Energies [J], never falling but for rounding.

    Notes
    -----
    With E(a) for the energy of a closed cycle of amplitude a, the sliders of the law (Iwan 1966,
    DOI 10.1115/1.3625199) have dissipated E(u)/4 on the first loading to u, and E(h)/2 on a branch
    whose end is 2 h away from the reversal that it began at: each slider slips 4 (a - y) in a
    cycle, u - y at first, 2 (h - y) on a branch. What is dissipated is the sum over the branches
    that are open, which adds up down the tree of the record, and over all loops that have closed,
    E of half their width each. A loop closes where a sample hangs from another reversal than the
    one before it did; what closes is then every other reversal in between.
    """
    half, sign, parent = Memory().tree(record)
    first = parent < 0
    inner = np.where(first, 0, parent)
    half = 0.5 * np.abs(displacement - displacement[inner])
    half[first] = np.abs(displacement[first])
    branch = np.asarray(joint.dissipated_energy(half))
    branch *= np.where(first, 0.25, 0.5)
    del half
    # Two branches make a loop, so that it takes every other one of a chain of reversals.
    loops, above = 2.0 * branch, np.where(first, -1, parent[inner])
    kernels.active.accumulate(above, loops, np.zeros(1))
    turned = np.append(False, (sign[1:] > 0.0) != (sign[:-1] > 0.0))
    before = np.append(-1, parent[:-1])
    before = np.where(turned, np.arange(parent.size) - 1, before)
    loops = np.append(loops, 0.0)  # at index -1, the origin
    closed = loops[before] - loops[parent]
    kernels.active.accumulate(parent, branch, np.zeros(1))
    return np.asarray(branch + np.cumsum(closed))
