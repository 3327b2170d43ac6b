"""Intervals of what campaigns say hold the truth as often as they claim."""

from __future__ import annotations

import numpy as np
import pytest

from microslip.laboratory.campaign import proportional
from microslip.laboratory.regimes import borders_of


def test_the_wear_coefficient_is_a_line_through_zero() -> None:
    exact = proportional(("a", "b"), np.array([1.0, 2.0]), np.array([3e-12, 6e-12]), 0.95)
    assert exact.coefficient.value == pytest.approx(3e-12, rel=1e-12)


def test_borders_of_a_sphere() -> None:
    """All of a sphere slides from its slip limit, which grows with the load to 2/3."""
    import microslip as ms

    steel = ms.Material(210e9, 0.3)
    sphere = ms.SphereOnFlat(ms.MaterialPair(steel, steel), radius=5e-3)
    joint = ms.Interface(sphere, 0.4, normal_load=10.0)
    borders = borders_of(lambda load: joint.at(normal_load=load), [10.0, 1000.0], 1e8)
    assert borders is not None
    contact = borders.gross - 0.4 * borders.normal_load / 1e8
    slope = np.polyfit(np.log(borders.normal_load), np.log(contact), 1)[0]
    assert slope == pytest.approx(2.0 / 3.0, abs=1e-6)
    limits = [joint.at(normal_load=float(load)) for load in borders.normal_load[::12]]
    slip = [-law.slip_per_indentation * law.separation for law in limits]
    assert np.allclose(contact[::12], slip, rtol=1e-6)
    assert borders_of(lambda load: joint, [], None) is None
