"""Laws, surfaces and heights are equal where their fields are; a copy equals its original."""

from __future__ import annotations

import copy
import pickle

import numpy as np

import microslip as ms
from microslip.contact.heights import HEIGHTS
from microslip.contact.laws import NORMAL_LAWS
from microslip.friction.laws import LAWS

STATED = [item for kind in (*HEIGHTS, *NORMAL_LAWS, *LAWS) for item in kind.examples()]


def test_a_copy_equals_its_original() -> None:
    for item in STATED:
        for other in (copy.deepcopy(item), pickle.loads(pickle.dumps(item))):
            assert other == item
            assert hash(other) == hash(item)
        assert all((item == other) == (item is other) for other in STATED)


def test_one_other_number_makes_another_law() -> None:
    loads = np.array([3.0, 1.0, 0.0])
    pair = ms.MaterialPair(ms.Material(69e9, 0.33), ms.Material(69e9, 0.33))
    one = ms.TabulatedNormalLaw(pair, [0.0, 1e-6, 2e-6], loads)
    other = ms.TabulatedNormalLaw(pair, [0.0, 1e-6, 2e-6], loads * (1.0 + 1e-15))
    assert one == ms.TabulatedNormalLaw(pair, [0.0, 1e-6, 2e-6], loads)
    assert one != other
    assert one != "a law"
    assert ms.Interface(one, 0.3, 1.0) != ms.Interface(other, 0.3, 1.0)
    field = ms.JointField(one, 0.3, areas=[1e-5, 2e-5], loads=[0.1, 0.15], surface_area=1e-4)
    assert copy.deepcopy(field) == field
    assert (
        ms.JointField(one, 0.3, areas=[1e-5, 2e-5], loads=[0.1, 0.16], surface_area=1e-4) != field
    )
