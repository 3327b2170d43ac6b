"""Asperity and its fields as objects: what they take, what they refuse, what they show."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import microslip as ms

AL = ms.Material(69e9, 0.33)
PAIR = ms.MaterialPair(AL, AL)
BALL = ms.Asperity(PAIR, radius=5e-3, friction_coefficient=0.55, normal_load=10.0)


def make(**given: Any) -> ms.Asperity:
    return ms.Asperity(**({"pair": PAIR, "radius": 5e-3, "friction_coefficient": 0.5} | given))


# -- made ------------------------------------------------------------------------------------------


def test_load_or_indentation() -> None:
    by_load = make(normal_load=10.0)
    by_depth = make(indentation=by_load.indentation)
    assert by_depth.normal_load == pytest.approx(10.0, rel=1e-15, abs=0)
    assert by_depth.indentation == by_load.indentation == -by_load.separation
    assert by_load.surface == ms.SphereOnFlat(PAIR, 5e-3)
    assert (by_load.pair, by_load.radius) == (PAIR, 5e-3)
    positional = ms.Asperity(PAIR, 5e-3, 0.5, 10.0)
    assert positional.force_limit == by_load.force_limit == 5.0


# -- shown -----------------------------------------------------------------------------------------


def test_turning_points_will_do() -> None:
    turns = BALL.slip_limit * np.array([0.0, 0.7, -0.2, 0.3])
    record = np.concatenate([np.linspace(a, b, 50) for a, b in pairwise(turns)])
    r = np.linspace(0.0, BALL.contact_radius, 30)
    np.testing.assert_array_equal(BALL.fields(record).traction(r), BALL.fields(turns).traction(r))


def test_force_control() -> None:
    record = BALL.slip_limit * np.array([0.7, -0.2, 0.3])
    fields = BALL.fields(force=BALL.force(record))
    assert fields.displacement == pytest.approx(record[-1], rel=1e-13, abs=0)
    r = np.linspace(0.0, BALL.contact_radius, 30)
    expected = BALL.fields(record).traction(r)
    np.testing.assert_allclose(fields.traction(r), expected, rtol=0, atol=1e-6 * expected.max())
    np.testing.assert_allclose(fields.traction(r[:20]), expected[:20], rtol=1e-11)
