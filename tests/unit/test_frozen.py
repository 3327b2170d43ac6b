"""Everything is frozen, holds arrays of its own, and equals its copies, pickled ones included."""

from __future__ import annotations

import copy
import dataclasses
import pickle
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from cases import folded, reach_of
from own_laws import HEIGHTS, LAWS
from usual import JOINT, PAIR, rough

import microslip as ms
from microslip.contact import NORMAL_LAWS

LOOP = ms.Loop([1.0, 0.0, -1.0, 0.0, 1.0], [1.0, -0.5, -1.0, 0.5, 1.0])
THINGS: dict[str, Any] = {
    f"{law.__name__}{i}": example
    for law in (*LAWS, *NORMAL_LAWS, *HEIGHTS)
    for i, example in enumerate(law.examples())
}
# One joint for each surface will do.
for _name in [name for name in THINGS if name.startswith("Interface")]:
    if int(_name[9:]) % 3 > 0:
        del THINGS[_name]
THINGS |= {
    "Loop": LOOP,
    "joint loop": JOINT.loop(1e-7, 32),
    "coupled response": JOINT.coupled_response([1e-7, 0.0], normal_load=[10.0, 20.0]),
    "ring-down": ms.Oscillator(1.0, 1e6, JOINT).ring_down(1e-7, cycles=1),
}


def arrays(thing: Any) -> Iterator[tuple[str, np.ndarray]]:
    """Every array that a thing shows, cached ones included."""
    names = [n for n in dir(type(thing)) if not n.startswith("_")]
    names += [n for n in vars(thing) if not n.startswith("_")]
    for name in sorted(set(names)):
        value = getattr(thing, name, None)
        if isinstance(value, np.ndarray):
            yield name, value


def numbers(thing: Any) -> bytes:
    """What a thing computes."""
    if isinstance(thing, ms.BackboneLaw):
        x = reach_of(thing) * np.array([0.5, -1.2, 0.1, 0.9, -3.0])
        loop = thing.loop(float(x[0]), 16)
        parts = (thing.force(x), thing.dissipated_energy(np.abs(x)), loop.force, x)
    elif isinstance(thing, ms.NormalLaw):
        d = np.linspace(*thing.separation(thing.load(thing._span[0]) * np.array([1.0, 1e-6])), 7)
        parts = (thing.load(d), thing.stiffness(d), thing.separation(thing.load(d[1:4])))
    elif isinstance(thing, ms.HeightDistribution):
        y = np.linspace(*thing.span, 7)
        parts = (thing.partial_moment(1.5, y), thing.cdf(y), np.array(thing.spread))
    else:
        parts = (thing.displacement, thing.force, np.array(thing.dissipated_energy))
    return b"".join(np.asarray(part).tobytes() for part in parts)


COPIERS: dict[str, Callable[[Any], Any]] = {
    "pickle": lambda thing: pickle.loads(pickle.dumps(thing)),
    "old pickle": lambda thing: pickle.loads(pickle.dumps(thing, protocol=2)),
    "deepcopy": copy.deepcopy,
    "copy": copy.copy,
}


@folded("thing", THINGS)
def test_nothing_can_be_set(thing: Any) -> None:
    names = [field.name for field in dataclasses.fields(thing)]
    names += [n for n in dir(type(thing)) if not n.startswith("_")]
    for name in {*names, "new"}:
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(thing, name, 1.0)
        with pytest.raises(dataclasses.FrozenInstanceError):
            delattr(thing, name)


@folded("thing", THINGS)
def test_arrays_are_locked(thing: Any) -> None:
    numbers(thing)
    for name, array in arrays(thing):
        assert not array.flags.writeable, name
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0.0


@folded("thing", THINGS)
def test_copies_give_the_same_numbers(thing: Any) -> None:
    new = [copier(thing) for copier in COPIERS.values()]
    expected = numbers(thing)  # from now on it keeps what it has computed
    used = [copier(thing) for copier in COPIERS.values()]
    for other in (*new, *used):
        assert type(other) is type(thing)
        if isinstance(thing, ms.BackboneLaw | ms.NormalLaw | ms.HeightDistribution):
            assert other == thing
            assert hash(other) == hash(thing)
            assert all((thing == one) == (thing is one) for one in THINGS.values())
        assert numbers(other) == expected
        assert repr(other).partition(" object at")[0] == repr(thing).partition(" object at")[0]


HEIGHT = np.array([0.0, 1e-7, 3e-7])
HELD: dict[str, tuple[Callable[[np.ndarray], Any], np.ndarray]] = {
    "discrete": (ms.Discrete, np.array([1e-7, 0.0, 3e-7])),
    "sorted discrete": (ms.Discrete, HEIGHT),
    "surface": (rough, HEIGHT),
    "population heights": (lambda a: ms.AsperityPopulation(PAIR, a, 1e-3), HEIGHT),
    "population radii": (
        lambda a: ms.AsperityPopulation(PAIR, HEIGHT, a),
        np.array([1e-3, 2e-3, 3e-3]),
    ),
    "table separation": (lambda a: ms.TabulatedNormalLaw(PAIR, a, [2.0, 1.0, 0.0]), HEIGHT),
    "table load": (lambda a: ms.TabulatedNormalLaw(PAIR, HEIGHT, a), np.array([2.0, 1.0, 0.0])),
    "loop displacement": (lambda a: ms.Loop(a, [0.0, 1.0, 1.0, 0.0]), np.array([0.0, 1, 2, 0])),
    "loop force": (lambda a: ms.Loop([0.0, 1.0, 2.0, 0.0], a), np.array([0.0, 1, -2, 0])),
}


@pytest.mark.parametrize("held", HELD)
def test_later_changes_of_an_array_do_not_reach_what_was_made(held: str) -> None:
    make, array = HELD[held]
    array = array.copy()
    thing, twin = make(array), make(array.copy())
    array[:] = array[::-1].copy()
    assert array.flags.writeable
    for (name, mine), (_, theirs) in zip(arrays(thing), arrays(twin), strict=True):
        assert not np.shares_memory(mine, array), name
        np.testing.assert_array_equal(mine, theirs)
    assert numbers(thing) == numbers(twin)
