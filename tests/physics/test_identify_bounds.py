"""Identified numbers are those of the records: neither of the search's ends nor of the channels."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest

import microslip as ms

JOINT = ms.Interface.examples()[0]
PAIR = JOINT.surface.pair
CELL = ms.Jenkins(stiffness=5e7, force_limit=100.0)
STD = 8e-7
RATE = 2560.0


def loops(
    joint: Any, load: float | None, amplitude: float, seed: int, rate: float = RATE
) -> ms.Record:
    """Ten noisy cycles at 10 Hz behind a rig of 500 MN/m."""
    law = joint if load is None else joint.at(normal_load=load)
    rig = ms.VirtualTribometer(law, rig_stiffness=5e8, noise=0.003, seed=seed, sample_rate=rate)
    return rig.record(amplitude=amplitude, frequency=10.0, cycles=10)


def exponential() -> list[ms.Record]:
    """Two loads of a joint whose heights are exponential."""
    surface = ms.GreenwoodWilliamson(PAIR, ms.Exponential(STD), radius=1e-3, density=1e8, area=2e-4)
    joint = ms.Interface(surface, friction_coefficient=0.4, normal_load=300.0)
    return [
        loops(joint, load, amplitude, seed)
        for seed, (load, amplitude) in enumerate(((300.0, 3e-6), (1000.0, 6e-6)))
    ]


@cache
def gaussian(end: float | None = None) -> ms.Identification:
    """These records under Gaussian heights, which want to be searched without end."""
    bounds = None if end is None else {"standardised_separation": (-4.0, end)}
    return ms.identify(
        exponential(), pair=PAIR, area=2e-4, bounds=bounds, held_back=0, summits=np.inf
    )


# -- ends of a search ----------------------------------------------------------------------------


@pytest.mark.slow
def test_no_number_that_leans_on_the_end_of_a_search_is_identified() -> None:
    """Far out in a Gaussian tail sigma goes with h: nothing but the search holds either."""
    found = gaussian()
    assert found.status == "at a bound"
    h = found.parameters["standardised_separation"]
    assert h.verdict == "not identified"
    assert "take other heights" in h.remedy
    for one in (found.parameters["slip_scale"], found.derived["std"]):
        assert one.verdict == "bounded below"
        assert one.high == math.inf
    # The rig and the friction hardly move with that end, and yet by more than their intervals.
    for one in (found.parameters["rig_stiffness"], found.derived["force_limit at 300 N"]):
        assert one.verdict == "in doubt"
        assert "depends on the limit of the search of standardised_separation" in one.reason
    assert "slip_scale" not in found.message
    further = gaussian(16.0)
    assert further.derived["std"].value > 1.5 * found.derived["std"].value
    rig, there = (fit.parameters["rig_stiffness"] for fit in (found, further))
    said = float(rig.reason.split()[-3]) / 100.0
    # As far out again is 20 and not 16.
    assert (rig.value - there.value) / rig.value == pytest.approx(said, rel=0.5)
    assert rig.reason.endswith("lower")


@pytest.mark.slow
def test_what_is_identified_at_one_end_holds_at_another() -> None:
    """However far is searched, intervals of what is identified have something in common."""
    fits = [gaussian(end) for end in (6.0, 8.0, 16.0)]
    for one in fits:
        for other in fits:
            for kind in ("parameters", "derived"):
                for name, number in getattr(one, kind).items():
                    twin = getattr(other, kind)[name]
                    if number.verdict == twin.verdict == "identified":
                        assert number.low <= twin.high, name
                        assert twin.low <= number.high, name


def test_a_separation_at_a_load_is_known_as_well_as_that_of_all() -> None:
    """It is the same number elsewhere."""
    found = gaussian()
    for load in (300, 1000):
        one = found.derived[f"standardised_separation at {load} N"]
        assert one.verdict == found.parameters["standardised_separation"].verdict
        assert one.high == math.inf
        assert one.reason


def test_what_an_open_end_does_not_move_stays_identified() -> None:
    """Under its own heights h is open, and sigma, which does not go with it, is right."""
    heights = ms.Exponential(STD)
    found = ms.identify(
        exponential(), pair=PAIR, area=2e-4, heights=heights, held_back=0, summits=np.inf
    )
    assert found.parameters["standardised_separation"].verdict == "not identified"
    for one, truth in (
        (found.parameters["friction_coefficient"], 0.4),
        (found.parameters["rig_stiffness"], 5e8),
        (found.derived["std"], STD),
    ):
        assert one.verdict == "identified"
        # At four standard errors; two would miss one in twenty.
        assert abs(one.value - truth) < 4.0 * one.standard_error


def test_empty_cells_are_no_failure() -> None:
    """Of a grid of cells a joint of two uses few."""
    law = ms.Iwan([2e7, 3e7], [20.0, 60.0])
    record = ms.VirtualTribometer(law, sample_rate=128.0, noise=0.003).record(
        amplitude=8e-6, frequency=1.0, cycles=6
    )
    found = ms.identify(record, "iwan", rig_stiffness=None, held_back=0, intervals="curvature")
    empty = [one for one in found.parameters.values() if one.at_bound]
    assert len(empty) >= 3
    assert found.status == "converged"
    for one in empty:
        assert one.verdict == "bounded above"
        assert one.remedy == ""
    assert found.derived["force_limit"].value == pytest.approx(80.0, rel=0.02)


# -- one separation for each load ----------------------------------------------------------------


def test_a_separation_for_each_load_is_that_at_its_load() -> None:
    """One name, one value: the truth of each load, and the joint of that load."""
    records = [loops(JOINT, load, 6e-6, seed) for seed, load in enumerate((500.0, 2000.0))]
    found = ms.identify(
        records,
        pair=PAIR,
        area=2e-4,
        per_load=["standardised_separation"],
        held_back=0,
        summits=np.inf,
    )
    assert not any(name.startswith("standardised_separation") for name in found.derived)
    for load in (500.0, 2000.0):
        one = found.parameters[f"standardised_separation at {load:g} N"]
        truth = JOINT.at(normal_load=load).separation / 5e-7
        assert one.load == pytest.approx(load, rel=1e-3)
        assert abs(one.value - truth) < 4.0 * one.standard_error
        made = found.joint(load)
        assert made.separation / made.surface.heights.std == pytest.approx(one.value, abs=1e-3)
    # Between the loads it is the nearest one's, taken to the load by the law.
    shared = ms.identify(records, pair=PAIR, area=2e-4, held_back=0, summits=np.inf)
    for load in (700.0, 990.0, 1010.0, 1500.0):
        one, other = found.joint(load), shared.joint(load)
        assert one.tangential_stiffness == pytest.approx(other.tangential_stiffness, rel=0.02)


def test_what_belongs_to_a_load_uses_the_separation_of_the_nearest() -> None:
    """A contact area too, whichever record comes first."""
    records = [loops(JOINT, load, 6e-6, seed) for seed, load in enumerate((500.0, 2000.0))]
    area = JOINT.contact_area
    assert area is not None
    for given in (records, records[::-1]):
        found = ms.identify(
            given,
            pair=PAIR,
            area=2e-4,
            per_load=["standardised_separation"],
            contact_area=(area, 0.02 * area, 2000.0),
            held_back=0,
            intervals="curvature",
            summits=np.inf,
        )
        assert found.derived["radius"].value == pytest.approx(1e-3, rel=0.3)


# -- delays --------------------------------------------------------------------------------------


def late(record: ms.Record, samples: int) -> ms.Record:
    """The record with its force some samples later."""
    return ms.Record(
        record.displacement[samples:],
        record.force[:-samples],
        normal_load=2000.0,
        sample_rate=record.sample_rate,
    )


@pytest.mark.slow
def test_a_delay_that_would_explain_a_misfit_is_named() -> None:
    """And fitted it comes out, with all others right."""
    rate, samples = 25600.0, 8
    record = late(loops(JOINT, None, 6e-6, 1, rate), samples)
    found = ms.identify(record, pair=PAIR, held_back=0, summits=np.inf)
    assert found.parameters["slip_scale"].verdict != "identified"
    (note,) = (text for text in found.notes if "would explain" in text)
    assert "behind the displacement" in note
    assert 'write `delay="free"`' in note
    # 8 samples at 25.6 kHz are 312 us; the score is a linear estimate.
    assert float(note.split()[2]) == pytest.approx(312.5, rel=0.1)
    right = ms.identify(record, pair=PAIR, held_back=0, delay="free", summits=np.inf)
    (one,) = right.delays.values()
    assert one.verdict == "identified"
    assert abs(one.value - samples / rate) < 4.0 * one.standard_error
    assert right.parameters["slip_scale"].verdict == "identified"
    assert not any("would explain" in text for text in right.notes)
    assert right.records[0].delay == pytest.approx(one.value, rel=1e-12)


def test_another_law_is_not_taken_for_a_delay() -> None:
    """Jenkins' cell leaves much of an interface's loops, whose corners no delay explains."""
    found = ms.identify(loops(JOINT, None, 6e-6, 1), "jenkins", held_back=0, intervals="curvature")
    assert found.reduced_chi_squared > 25.0
    assert not any("delay" in text for text in found.notes)


@pytest.mark.slow
def test_intervals_of_a_delay_hold_it() -> None:
    """Of 80 delays 95 % should; less than 84 % would come of that once in ten thousand."""
    values, errors, held = [], [], 0
    for trial in range(40):
        records = [
            ms.VirtualTribometer(
                CELL,
                noise={"force": 2.0, "displacement": 2e-8},
                seed=2 * trial + number,
                sample_rate=64.0,
            ).record(amplitude=amplitude, frequency=1.0, cycles=6)
            for number, amplitude in enumerate((6e-6, 3e-6))
        ]
        found = ms.identify(
            records,
            "jenkins",
            rig_stiffness=None,
            delay="free",
            held_back=0,
            intervals="curvature",
        )
        assert len(found.delays) == 2
        for one in found.delays.values():
            values.append(one.value)
            errors.append(one.standard_error)
            held += one.low < 0.0 < one.high
    assert held >= 0.84 * len(values)
    # 80 values tell their spread to 8 %.
    assert np.std(values) == pytest.approx(float(np.median(errors)), rel=0.3)


# -- a rig that cannot be ------------------------------------------------------------------------


def test_a_rig_a_little_too_soft_is_reported_beside_the_misfit() -> None:
    """There a fit comes out, which leaves much."""
    found = ms.identify(
        loops(JOINT, None, 6e-6, 1),
        rig_stiffness=3.5e8,
        held_back=0,
        intervals="curvature",
        summits=np.inf,
    )
    assert found.reduced_chi_squared > 25.0
    assert any("the loops are stiffer" in text for text in found.notes)
