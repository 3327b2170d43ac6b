"""The spellings that an identification takes for rigs, laws and records, and what it refuses."""

from __future__ import annotations

import math
from collections import deque
from functools import cache
from typing import Any

import numpy as np
import pytest

import microslip as ms
from microslip.identification import fit, nuisances, options
from microslip.identification.models import MODELS

CELL = ms.Jenkins(stiffness=5e7, force_limit=100.0)


@cache
def records() -> tuple[ms.Record, ...]:
    """Two virtual records of a cell."""
    return tuple(
        ms.VirtualTribometer(
            CELL, rig_stiffness=1e8, noise=0.005, sample_rate=64.0, seed=seed
        ).record(amplitude=amplitude, frequency=1.0, cycles=6)
        for seed, amplitude in enumerate((6e-6, 9e-6))
    )  # fmt: skip


def identified(given: Any = None, **options: Any) -> ms.Identification:
    """The cell."""
    return ms.identify(
        records() if given is None else given, "jenkins", held_back=0, intervals="curvature",
        **options,
    )  # fmt: skip


def values(found: ms.Identification) -> dict[str, float]:
    """Names and values of the parameters."""
    return {name: one.value for name, one in found.parameters.items()}


@pytest.mark.parametrize("rigid", [" Rigid ", np.float64(math.inf)])
def test_a_rigid_rig(rigid: Any) -> None:
    """By its name and as a number without end, for all records or for those of one rig."""
    assert values(identified(rig_stiffness=rigid)) == values(identified(rig_stiffness=None))
    one = identified(rigs=["a", "b"], rig_stiffness={"a": rigid, "b": 1e8})
    none = identified(rigs=["a", "b"], rig_stiffness={"a": None, "b": 1e8})
    assert values(one) == values(none)
    assert [record.rig_stiffness for record in one.records] == [None, 1e8]


def test_a_wrong_law_is_no_law_that_does_not_suit() -> None:
    """A comparison refuses it before any fit."""
    done: list[float] = []
    with pytest.raises(ms.InputError, match=r"law must be one of .*, got 'jenkin'"):
        ms.compare(records(), ["jenkins", "jenkin"], progress=done.append)
    assert not done


def test_records_of_any_kind() -> None:
    """A generator, a queue, an array, a view of a dict: whatever gives them one by one."""
    first = values(identified())
    array = np.empty(2, dtype=object)
    array[:] = records()
    for given in (iter(records()), deque(records()), array, dict(enumerate(records())).values()):
        assert values(identified(given)) == first
    labelled = (identified(rigs=rigs) for rigs in (["a", "b"], np.array(["a", "b"])))
    assert len({tuple(values(found).items()) for found in labelled}) == 1
    both = ms.compare((one for one in records()), ["jenkins", "segalman"], held_back=0)
    assert set(both.fits) == {"jenkins", "segalman"}


def test_choices_are_those_that_exist() -> None:
    assert (*nuisances.EFFECTS, nuisances.PLAY) == options.NUISANCES
    assert tuple(fit._LOSS_WEIGHTS) == options.LOSSES
    assert set(options.LAWS) <= {model.name for model in MODELS}


def test_the_number_of_summits_of_a_surface_or_a_density_counts() -> None:
    """Without it numbers are apparent; where a surface or a density tells it chance is in them."""
    pair = ms.MaterialPair(ms.Material(69e9, 0.33), ms.Material(69e9, 0.33))
    surface = ms.GreenwoodWilliamson(pair, ms.Gaussian(5e-7), 1e-3, 1e8, 2e-4)
    joint = ms.Interface(surface, 0.55, normal_load=2000.0)
    rig = ms.VirtualTribometer(joint, noise=0.003, seed=2)
    records = [rig.record(amplitude=a, frequency=10.0, cycles=8) for a in (1e-6, 5e-6)]
    keywords = {"rig_stiffness": None, "held_back": 0, "intervals": "curvature"}
    unknown = ms.identify(records, pair=pair, area=2e-4, **keywords)
    assert unknown.parameters["slip_scale"].verdict == "apparent"
    stated = ms.identify(records, joint, summits=2e4, **keywords)
    found = ms.identify(records, joint, **keywords)
    assert found.parameters["slip_scale"].low == stated.parameters["slip_scale"].low
    assert any("that of the surface given, 2e+04" in note for note in found.notes)
    by_density = ms.identify(
        records, pair=pair, area=2e-4, known={"density": (1e8, 1e6)}, **keywords
    )
    assert any("the density given and the area, 2e+04" in note for note in by_density.notes)
    assert by_density.parameters["slip_scale"].verdict != "apparent"
    again = ms.identify(records, joint, summits="unknown", **keywords)
    assert again.parameters["slip_scale"].verdict == "apparent"
