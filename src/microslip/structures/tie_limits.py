"""Frequencies of a joint with open and with tied faces, which bound those of any contact."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip.structures.reduction_model import ReducedJoint

_RIGID = 1e-6  # of the largest square of an angular frequency
_CANDIDATES = 24
_COVERED = 0.25  # share of a patch under a washer from which it counts as tied


class TieLimits(NamedTuple):
    """Frequencies of one mode for limiting conditions of the lap [Hz]."""

    open: float
    """Frequency [Hz] without contact: only the bolts connect the parts."""
    washers: float
    """Frequency [Hz] with the patches under the washers tied, all others open."""
    tied: float
    """Frequency [Hz] with all patches tied."""


def tie_limits(
    joint: ReducedJoint,
    circles: Sequence[tuple[float, float, float, int]],
    shapes: Floats,
) -> list[TieLimits]:
    """Return the frequencies of modes with the lap open, tied under washers, and tied wholly.

    Parameters
    ----------
    joint : ReducedJoint
        The joint without its contact.
    circles : sequence
        Position along and across [m], diameter [m] and number of the contact of each washer.
    shapes : ndarray
        Mode shapes (degrees of freedom, modes). For each shape and limit the frequency of the most
        similar mode (by the mass-weighted product) is returned.

    Notes
    -----
    Tied patches have zero mean relative displacements, so the limits have the resolution of the
    patches. A patch counts as tied by a washer if the washer covers a quarter of its area, and in
    any case if it is the patch with the largest area under this washer.
    """
    samples = joint.samples
    contacts = joint.patch_contacts[samples.patches]
    pressed = np.zeros(joint.patches, dtype=bool)
    areas = np.bincount(samples.patches, samples.weights, minlength=joint.patches)
    for x, y, diameter, contact in circles:
        near = np.hypot(samples.places[:, 0] - x, samples.places[:, 1] - y) < 0.5 * diameter
        near &= contacts == contact
        covered = np.bincount(samples.patches, samples.weights * near, minlength=joint.patches)
        pressed |= covered >= _COVERED * areas
        pressed[np.argmax(covered)] |= bool(near.any())
    found = []
    for held in (np.zeros_like(pressed), pressed, np.ones_like(pressed)):
        fixed = (3 * np.flatnonzero(held)[:, None] + np.arange(3)).ravel()
        found.append(_alike(joint, np.setdiff1d(np.arange(joint.size), fixed), shapes))
    return [TieLimits(*limits) for limits in np.transpose(found).tolist()]


def _alike(joint: ReducedJoint, free: Floats, shapes: Floats) -> Floats:
    """Return the frequency [Hz] of the mode most similar to each column of ``shapes``.

    The modes are those of the joint in which only the coordinates ``free`` (indices) can move.
    """
    from scipy.linalg import eigh

    grid = np.ix_(free, free)
    squares, modes = eigh(joint.stiffness[grid], joint.mass[grid])
    elastic = squares > _RIGID * squares[-1] * 1e-6
    squares, modes = squares[elastic][:_CANDIDATES], modes[:, elastic][:, :_CANDIDATES]
    overlap = (modes.T @ joint.mass[free] @ shapes) ** 2
    return np.asarray(np.sqrt(squares[np.argmax(overlap, axis=0)]) / (2.0 * np.pi))
