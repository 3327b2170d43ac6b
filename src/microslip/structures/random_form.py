"""Random form of contact faces: waves of a given flatness, and raised rims around holes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from microslip._core.checks import Floats
from microslip.structures.reduction_model import ReducedJoint
from microslip.structures.reduction_patches import mean_over

_WAVES = 150
_RIM = (0.95, 1.67)
"""Outer radius of a raised rim over the diameter of its hole: 8 to 14 mm around 8.4 mm."""


def random_face(
    places: Floats, weights: Floats, flatness: float, correlation: float, rng: np.random.Generator
) -> Floats:
    """Return the heights of a random face at places [m], its best plane removed.

    The heights are Gaussian with a squared-exponential covariance, drawn as 150 random waves
    (Rahimi and Recht 2007). Faces shorter than the ``correlation`` length [m] have only bow and
    twist. ``places`` are along and across (points, 2) [m], ``weights`` the area that each point
    represents (points,) [m^2], ``flatness`` is peak to valley after the plane is removed [m].
    """
    numbers = rng.standard_normal((2, _WAVES)) / correlation
    phases = rng.uniform(0.0, 2.0 * np.pi, _WAVES)
    # Single precision suffices, and its cosine takes a quarter of the time.
    angles = (places @ numbers + phases).astype(np.float32)
    heights = np.cos(angles, out=angles).sum(axis=1, dtype=np.float64)
    plane = np.column_stack([np.ones(len(places)), places / np.ptp(places, axis=0).max()])
    root = np.sqrt(weights)[:, None]
    solved = np.linalg.lstsq(plane * root, heights * root[:, 0], rcond=None)[0]
    heights = heights - plane @ solved
    return np.asarray(heights * (flatness / np.ptp(heights)))


def random_gaps(
    joint: ReducedJoint, flatness: float, correlation: float, rng: np.random.Generator
) -> Floats:
    """Return the gap of each patch between two independent random faces (patches,) [m].

    Flatness and correlation length [m] are those of each face; faces are drawn for each contact.
    """
    samples = joint.samples
    contacts = joint.patch_contacts[samples.patches]
    gaps = np.zeros(len(contacts))
    for contact in np.unique(contacts):
        here = contacts == contact
        for _ in range(2):
            gaps[here] += random_face(
                samples.places[here], samples.weights[here], flatness, correlation, rng
            )
    return mean_over(samples, gaps, joint.patches)


def rim_gaps(
    joint: ReducedJoint,
    holes: Sequence[tuple[float, float, float, int]],
    height: float,
    reach: float = 0.5,
) -> Floats:
    """Return the change of the gap of each patch by raised rims around holes (patches,) [m].

    It is negative at the rims. A rim decreases linearly from ``height``, the sum over both faces
    [m], at the edge of the hole to zero at a radius of 0.95 + 0.72 ``reach`` hole diameters.
    Holes are positions along and across, diameter [m] and number of the contact.
    """
    samples = joint.samples
    contacts = joint.patch_contacts[samples.patches]
    gaps = np.zeros(len(contacts))
    for x, y, diameter, contact in holes:
        distance = np.hypot(samples.places[:, 0] - x, samples.places[:, 1] - y)
        end = (_RIM[0] + reach * (_RIM[1] - _RIM[0])) * diameter
        share = np.clip((end - distance) / (end - 0.5 * diameter), 0.0, 1.0)
        gaps = np.minimum(gaps, np.where(contacts == contact, -height * share, 0.0))
    return mean_over(samples, gaps, joint.patches)
