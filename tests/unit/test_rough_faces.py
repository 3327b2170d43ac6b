"""Moments of two faces together."""

from __future__ import annotations

import pytest

import microslip as ms
from microslip.surfaces import random_surface


def test_the_gap_of_two_faces_has_the_moments() -> None:
    """Moments of the difference of two scans are the sums of theirs."""
    faces = [
        random_surface((512, 512), 1e-6, m0=m0, m2=1e-3, m4=m4, seed=seed)
        for seed, m0, m4 in ((3, 4e-14, 2e8), (4, 1e-13, 1e8))
    ]
    gap = ms.Scan(faces[0].heights - faces[1].heights, 1e-6).moments()
    for name in ("m0", "m2", "m4"):
        # Cross terms of two finite scans vanish like one over the root of the waves in them.
        both = sum(getattr(face.moments(), name) for face in faces)
        assert getattr(gap, name) == pytest.approx(both, rel=0.03)
