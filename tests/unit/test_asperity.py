"""Asperity and its fields as objects: what they take, what they refuse, what they show."""

from __future__ import annotations

import copy
import dataclasses
import pickle
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import microslip as ms
from microslip.friction import Zone

AL = ms.Material(69e9, 0.33)
PAIR = ms.MaterialPair(AL, AL)
BALL = ms.Asperity(PAIR, radius=5e-3, friction_coefficient=0.55, normal_load=10.0)
FIELDS = BALL.fields(BALL.slip_limit * np.array([0.7, -0.2]))


def refusal(call: Callable[..., Any], *args: object, **kwargs: object) -> str:
    with pytest.raises(ms.InputError) as caught:
        call(*args, **kwargs)
    return str(caught.value)


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


def test_at() -> None:
    for other in (BALL.at(normal_load=20.0), BALL.at(indentation=1e-6), BALL.at(separation=-1e-6)):
        assert type(other) is ms.Asperity
        assert (other.pair, other.radius, other.friction_coefficient) == (PAIR, 5e-3, 0.55)
    assert BALL.at(normal_load=20.0).normal_load == 20.0
    assert BALL.at(indentation=1e-6).indentation == 1e-6
    assert BALL.at(separation=-1e-6).indentation == 1e-6


# -- asked -----------------------------------------------------------------------------------------


SHAPED: dict[str, Callable[[Any], Any]] = {
    "pressure": BALL.pressure,
    "normal_displacement": BALL.normal_displacement,
    "traction": FIELDS.traction,
    "slip": FIELDS.slip,
    "u_x": lambda v: FIELDS.surface_displacement(v, 1e-5)[0],
    "u_y": lambda v: FIELDS.surface_displacement(1e-5, v)[1],
    "stick_radius": BALL.stick_radius,
    "stick_radius of a force": lambda v: BALL.stick_radius(force=v),
    "reversed_slip_radius": lambda v: BALL.reversed_slip_radius(3.0, v),
}


@pytest.mark.parametrize("name", SHAPED)
def test_shapes(name: str) -> None:
    call = SHAPED[name]
    values = np.array([[0.0, 2e-5, 5e-5], [9e-5, 1e-4, 3e-4]])
    whole = call(values)
    assert whole.shape == values.shape
    single = [call(float(v)) for v in values.ravel()]
    assert all(type(v) is float for v in single)
    np.testing.assert_allclose(whole.ravel(), single, rtol=1e-13, atol=1e-20)
    assert call(values[:, :1]).shape == (2, 1)


@pytest.mark.parametrize("name", SHAPED)
@pytest.mark.parametrize("bad", [np.nan, np.inf, [], [0.0, np.nan], "1 um", None], ids=str)
def test_bad_numbers(name: str, bad: Any) -> None:
    message = refusal(SHAPED[name], bad)
    assert "must" in message
    assert "\n" not in message


# -- shown -----------------------------------------------------------------------------------------


def test_zones_are_named() -> None:
    zone = FIELDS.zones[-1]
    assert isinstance(zone, Zone)
    assert zone._fields == ("kind", "inner", "outer", "direction")
    assert (zone.kind, zone.outer, zone.direction) == ("slip", BALL.contact_radius, -1)
    (rest,) = BALL.fields(0.0).zones
    assert rest == ("stick", 0.0, BALL.contact_radius, 0)
    (sliding,) = BALL.fields(-2.0 * BALL.slip_limit).zones
    assert sliding == ("slip", 0.0, BALL.contact_radius, -1)


def test_a_number_is_first_loading() -> None:
    one, same = BALL.fields(1e-7), BALL.fields([1e-7])
    assert one.force == same.force == BALL.backbone(1e-7)
    assert one.reversed_slip_radius == BALL.contact_radius


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


@pytest.mark.parametrize("thing", [BALL, FIELDS], ids=["asperity", "fields"])
def test_frozen_and_copied(thing: Any) -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        thing.force = 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        thing.new = 1.0
    for other in (pickle.loads(pickle.dumps(thing)), copy.deepcopy(thing), copy.copy(thing)):
        fields = other if thing is FIELDS else other.fields(BALL.slip_limit * np.array([0.7, -0.2]))
        assert fields.force == FIELDS.force
        assert fields.zones == FIELDS.zones
        assert not fields._factors.flags.writeable


def test_the_fields_keep_their_record() -> None:
    record = BALL.slip_limit * np.array([0.7, -0.2])
    fields = BALL.fields(record)
    before = fields.traction(2e-5)
    record[:] = 0.0
    assert fields.traction(2e-5) == before
