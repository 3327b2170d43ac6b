"""An identification: what it refuses, what it says, and what can be asked of it."""

from __future__ import annotations

import copy
import json
import math
import pickle
import tracemalloc
from functools import cache
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest

import microslip as ms
from microslip.identification import fold
from microslip.identification.coordinates import levels_of, stiffness_after_reversal
from microslip.identification.fit_quality import _held_back_rows
from microslip.identification.models.interface import InterfaceModel

CELL = ms.Jenkins(stiffness=5e7, force_limit=100.0)
JOINT = ms.Interface.examples()[0]


def record(law: Any = CELL, amplitude: float = 6e-6, **more: Any) -> ms.Record:
    """A virtual record, six cycles of 64 samples."""
    cycles = more.pop("cycles", 6)
    more.setdefault("noise", 0.005)
    rig = ms.VirtualTribometer(law, sample_rate=64.0, **more)
    return rig.record(amplitude=amplitude, frequency=1.0, cycles=cycles)


@cache
def cell() -> ms.Identification:
    """A cell on a rigid rig."""
    return ms.identify([record(), record(amplitude=3e-6, seed=1)], "jenkins", rig_stiffness=None)


@cache
def joint() -> ms.Identification:
    """An interface at two loads, its pair known."""
    records = [
        record(JOINT.at(normal_load=load), amplitude, seed=i, noise=0.002)
        for i, (load, amplitude) in enumerate(
            (load, amplitude) for load in (300.0, 3000.0) for amplitude in (1e-6, 3e-6)
        )
    ]
    return ms.identify(
        records, pair=JOINT.surface.pair, area=2e-4, rig_stiffness=None, summits=np.inf
    )


# -- what is said ---------------------------------------------------------------------------------


def test_a_cell() -> None:
    """Values, statuses and their plain form."""
    found = cell()
    assert found.status == "converged"
    assert found.converged
    assert set(found.parameters) == {"stiffness", "force_limit"}
    for one in found.parameters.values():
        assert one.verdict == "identified"
        assert one.identified
        assert one.low < one.value < one.high
        assert one.reason == one.remedy == ""
        assert not one.at_bound
    assert found.directions == ()
    assert found.not_identified == ()
    law = found.joint()
    assert isinstance(law, ms.Jenkins)
    assert law.stiffness == found.parameters["stiffness"].value
    assert 0.8 < found.reduced_chi_squared < 1.2
    assert 0.8 < (found.held_back or 0.0) < 1.2
    assert np.allclose(np.diag(found.correlation), 1.0)
    assert found.names == ("stiffness", "force_limit")
    plain = found.summary()
    assert json.loads(json.dumps(plain, allow_nan=False)) == plain


def test_what_is_fixed_stays() -> None:
    """And has a verdict of its own."""
    found = ms.identify(
        record(), "jenkins", rig_stiffness=None, fixed={"stiffness": 5e7}, held_back=0
    )
    assert found.parameters["stiffness"].verdict == "fixed"
    assert found.parameters["stiffness"].value == 5e7
    assert found.names == ("force_limit",)
    assert found.held_back is None


def test_bounds_are_kept_and_said() -> None:
    """A bound that the data press against is a status."""
    found = ms.identify(
        record(), "jenkins", rig_stiffness=None, bounds={"force_limit": (50.0, 90.0)}, held_back=0
    )
    assert found.status == "at a bound"
    assert "force_limit" in found.message
    assert found.parameters["force_limit"].at_bound
    assert found.parameters["force_limit"].value == pytest.approx(90.0, rel=1e-6)
    assert not found.parameters["force_limit"].identified


def test_a_fit_that_does_not_converge_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its values are there to look at, not to build with."""
    from microslip.identification import fit

    for limit in ("_MOST_STEPS", "_MOST_EVALUATIONS"):
        monkeypatch.setattr(fit, limit, 1)
    found = ms.identify(
        *(record(), "jenkins"),
        rig_stiffness=None,
        start={"stiffness": 1e9},
        held_back=0,
        delay="free",
    )
    assert found.status == "not converged"
    assert {number.verdict for number in found.delays.values()} == {"in doubt"}
    assert not found.converged
    with pytest.raises(ms.InputError, match="did not converge"):
        found.joint()
    with pytest.raises(ms.InputError, match="did not converge"):
        found.study()
    assert isinstance(found.joint(even_if=("not converged",)), ms.Jenkins)


def test_records_that_come_once_are_fitted_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without its end by the summits of the surface a fit begins again without their number."""
    from microslip.identification import fit

    for limit in ("_MOST_STEPS", "_MOST_EVALUATIONS"):
        monkeypatch.setattr(fit, limit, 1)
    found = ms.identify(iter(three_loads()), JOINT, held_back=0, intervals="curvature")
    assert found.status == "not converged"
    assert "continuum" in {caveat.kind for caveat in found.caveats}
    assert {number.verdict for number in found.parameters.values()} == {"in doubt"}


def test_a_cell_behind_a_free_rig() -> None:
    """Two springs in series: neither is told, and the direction says how they trade."""
    found = ms.identify(record(), "jenkins", held_back=0)
    assert found.parameters["force_limit"].verdict == "identified"
    assert found.parameters["stiffness"].verdict != "identified"
    assert found.parameters["rig_stiffness"].verdict != "identified"
    assert "give it with its uncertainty" in found.parameters["stiffness"].remedy
    texts = " ".join(way.text for way in found.directions)
    assert "rig_stiffness" in texts
    assert "by less than the noise" in texts
    assert json.dumps(found.summary(), allow_nan=False)


def test_a_rig_measured_apart_settles_it() -> None:
    """With (value, uncertainty) the stiffness comes out."""
    soft = record(rig_stiffness=1e8, amplitude=8e-6)
    found = ms.identify(soft, "jenkins", rig_stiffness=(1e8, 1e6), held_back=0)
    one = found.parameters["stiffness"]
    assert one.verdict == "identified"
    assert one.low < 5e7 < one.high
    # The stiffness in series is 1/(1/5e7 + 1/1e8): 1 % of the rig's is 0.5 % of the cell's.
    assert one.standard_error == pytest.approx(0.005 * 5e7, rel=0.3)


def test_each_load_its_own_or_shared() -> None:
    """A law without load has values for each; what is shared is one number."""
    records = [
        ms.Record(r.displacement, r.force, load, sample_rate=64.0)
        for r, load in ((record(), 100.0), (record(seed=1), 100.5), (record(seed=2), 300.0))
    ]
    own = ms.identify(records, "jenkins", rig_stiffness=None, held_back=0)
    assert "stiffness at 100.2 N" in own.parameters
    assert "force_limit at 300 N" in own.parameters
    assert own.joint(300.0).stiffness == own.parameters["stiffness at 300 N"].value
    with pytest.raises(ms.InputError, match="one of those measured"):
        own.joint(1000.0)
    one = ms.identify(records, "jenkins", rig_stiffness=None, shared=["stiffness"], held_back=0)
    assert set(one.parameters) == {"stiffness", "force_limit at 100.2 N", "force_limit at 300 N"}


def test_loads_have_short_names() -> None:
    """A channel's mean is no number that anybody chose; one that was given has four digits."""
    noisy = [
        record(JOINT.at(normal_load=load), 3e-6, seed=i, noise=0.01)
        for i, load in enumerate((500.0, 2000.0))
    ]
    assert all(one.normal_load.mean() not in (500.0, 2000.0) for one in noisy)
    found = ms.identify(noisy, "jenkins", rig_stiffness=None, intervals="curvature", held_back=0)
    assert {"stiffness at 500 N", "stiffness at 2000 N"} <= set(found.parameters)
    given = [
        ms.Record(one.displacement, one.force, load, sample_rate=64.0)
        for one, load in zip(noisy, (500.24, 2003.0), strict=True)
    ]
    found = ms.identify(given, "jenkins", rig_stiffness=None, intervals="curvature", held_back=0)
    assert {"stiffness at 500.2 N", "stiffness at 2003 N"} <= set(found.parameters)


def test_levels() -> None:
    """Loads within one per cent are one level; none is one of its own."""
    assert levels_of([100.0, 100.9, 200.0, None, 100.0]) == [0, 0, 1, 2, 0]


@pytest.mark.slow
def test_records_of_different_rigs_are_reported() -> None:
    """Unless the rigs have labels."""
    records = [
        record(JOINT, 12e-6, rig_stiffness=2e8, noise=0.001),
        record(JOINT, 12e-6, rig_stiffness=1e8, noise=0.001, seed=1),
    ]
    found = ms.identify(records, held_back=0, summits=np.inf)
    assert found.status == "records differ: rigs"
    assert "name the rig of each record" in found.message
    told = ms.identify(records, rigs=["old", "new"], held_back=0, summits=np.inf)
    assert told.status == "converged"
    old, new = (told.parameters[f"rig_stiffness of {label}"] for label in ("old", "new"))
    assert old.low < 2e8 < old.high
    assert new.low < 1e8 < new.high
    same = [record(JOINT, a, rig_stiffness=2e8, seed=i) for i, a in enumerate((8e-6, 12e-6))]
    assert ms.identify(same, held_back=0, summits=np.inf).status == "converged"


def test_an_interface() -> None:
    """With its pair it is a joint, and a study that can be run."""
    found = joint()
    assert found.status == "converged"
    assert found.parameters["standardised_separation"].verdict == "identified"
    std = found.derived["std"]
    assert std.low < 0.5e-6 < std.high
    made = found.joint(2000.0)
    assert made.normal_load == pytest.approx(2000.0, rel=1e-9)
    assert made.tangential_stiffness == pytest.approx(JOINT.tangential_stiffness, rel=0.05)
    study = ms.Study(**found.study())
    assert study.joint.normal_load == pytest.approx((300.0, 3000.0), rel=1e-3)
    bare = ms.identify(record(JOINT, 3e-6), rig_stiffness=None, held_back=0, summits=np.inf)
    assert "std" not in bare.derived
    assert any("one normal load" in note for note in bare.notes)


def test_a_contact_area_separates_radius_and_density() -> None:
    """Loops do not; and both carry the uncertainty of the area."""
    assert "radius" not in joint().derived
    records = [
        record(JOINT.at(normal_load=load), 3e-6, seed=i, noise=0.002)
        for i, load in enumerate((300.0, 3000.0))
    ]
    area = JOINT.contact_area
    assert area is not None
    found = ms.identify(
        records,
        pair=JOINT.surface.pair,
        area=2e-4,
        rig_stiffness=None,
        contact_area=(area, 0.05 * area, 2000.0),
        held_back=0,
        summits=np.inf,
    )
    radius, density = found.derived["radius"], found.derived["density"]
    assert radius.low < 1e-3 < radius.high
    assert density.low < 1e8 < density.high
    # The radius goes with the square of the area.
    assert radius.standard_error > 0.08 * radius.value
    assert found.joint(2000.0).contact_area == pytest.approx(area, rel=0.02)


def test_known_data_narrow() -> None:
    """A scan's sigma as a datum makes the interval of it no wider than its own."""
    records = [record(JOINT, 3e-6)]
    pair = JOINT.surface.pair
    free = ms.identify(records, pair=pair, rig_stiffness=None, held_back=0, summits=np.inf)
    told = ms.identify(
        records,
        pair=pair,
        rig_stiffness=None,
        known={"std": (0.5e-6, 5e-9)},
        held_back=0,
        summits=np.inf,
    )
    assert told.derived["std"].standard_error < min(5e-9, free.derived["std"].standard_error)
    assert told.degrees_of_freedom == free.degrees_of_freedom + 1


@pytest.mark.parametrize("name", ["radius", "density"])
def test_a_known_radius_or_density_separates_both(name: str) -> None:
    """As a contact area does; the error of the one is the error of the other."""
    records = [
        record(JOINT.at(normal_load=load), 3e-6, seed=i, noise=0.002)
        for i, load in enumerate((300.0, 3000.0))
    ]
    truth = {"radius": 1e-3, "density": 1e8}
    value = truth[name]
    options: dict[str, Any] = {
        "pair": JOINT.surface.pair, "area": 2e-4, "rig_stiffness": None, "held_back": 0,
        "intervals": "curvature",
    }  # fmt: skip
    found = ms.identify(records, known={name: (value, 0.05 * value)}, **options)
    other = "density" if name == "radius" else "radius"
    given, derived = found.parameters[name], found.derived[other]
    assert given.value == pytest.approx(value, rel=0.01)
    assert given.standard_error == pytest.approx(0.05 * value, rel=0.05)
    assert derived.low < truth[other] < derived.high
    # density * sqrt(radius) is what loops know.
    share = 0.025 if name == "radius" else 0.1
    assert derived.standard_error > 0.9 * share * derived.value
    surface = found.joint(2000.0).surface
    assert (surface.radius, surface.density) == pytest.approx(
        (found.joint().surface.radius, found.joint().surface.density)
    )
    assert getattr(surface, name) == pytest.approx(value, rel=0.01)
    assert getattr(surface, other) == pytest.approx(derived.value, rel=1e-6)
    # Both, the second as what has a value and a standard error.
    both = ms.identify(records, known={name: (value, 0.05 * value), other: derived}, **options)
    assert both.degrees_of_freedom == found.degrees_of_freedom + 1
    with pytest.raises(ms.InputError, match=r"give pair=\.\.\., and the apparent area with it"):
        ms.identify(records, known={name: (value, 0.05 * value)}, rig_stiffness=None)


def test_the_separation_names_its_load() -> None:
    """That of the records: one load itself, of several the geometric mean."""
    one = joint().parameters["standardised_separation"]
    # The loads are means of noisy channels.
    assert one.load == pytest.approx(math.sqrt(300.0 * 3000.0), rel=1e-3)
    assert f"standardised_separation at {one.load:.4g} N" in joint().table()
    assert joint().summary()["parameters"]["standardised_separation"]["normal_load"] == one.load
    # An instance at another load starts the fit, and does not name what comes out.
    start = JOINT.at(normal_load=500.0)
    told = ms.identify(record(JOINT, 3e-6), start, rig_stiffness=None, held_back=0, summits=np.inf)
    bare = ms.identify(record(JOINT, 3e-6), rig_stiffness=None, held_back=0, summits=np.inf)
    h, free = (found.parameters["standardised_separation"] for found in (told, bare))
    assert h.load == free.load == pytest.approx(JOINT.normal_load, rel=1e-3)
    assert h.value == pytest.approx(free.value, abs=1e-3)
    assert "1 record," in told.table()
    model = InterfaceModel.of(start).prepared([0], [JOINT.normal_load])
    assert (model.start or {})["standardised_separation"] == pytest.approx(
        JOINT.separation / JOINT.surface.heights.std, rel=1e-9
    )


def test_an_identification_travels() -> None:
    """By pickle and as a deep copy, its mappings and arrays still read-only."""
    found = joint()
    for other in (pickle.loads(pickle.dumps(found)), copy.deepcopy(found)):
        assert other.summary() == found.summary()
        assert isinstance(other.parameters, MappingProxyType)
        assert isinstance(other.columns[0], MappingProxyType)
        assert not other.records[0].model.flags.writeable
        assert other.joint(2000.0).force_limit == found.joint(2000.0).force_limit


@pytest.mark.parametrize(
    ("cycles", "share", "held"),
    [(8, 0.25, 2), (20, 0.45, 9), (20, 0.6, 12), (20, 0.9, 18), (3, 0.25, 1), (3, 0.9, 1)],
)
def test_held_back_is_the_share_it_says(cycles: int, share: float, held: int) -> None:
    """One cycle at least, and two stay."""
    assert _held_back_rows(cycles, share).sum() == held


def test_progress_is_a_share() -> None:
    """From none to all, never back."""
    shares: list[float] = []
    ms.identify(record(), "jenkins", progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_comparison() -> None:
    """The law that made the records wins, and what does not suit them is told."""
    found = ms.compare([record(), record(amplitude=3e-6, seed=1)], ["jenkins", "interface"])
    assert found.best == "jenkins"
    assert "needs the normal load" in found.failed["interface"]
    assert found.rows()[0]["aic_over_best"] == 0.0
    again = pickle.loads(pickle.dumps(found))
    assert again.rows() == found.rows()
    assert isinstance(again.fits, MappingProxyType)


# -- folding --------------------------------------------------------------------------------------


@pytest.mark.parametrize("rate", [64.0, 71.3])
def test_folding(rate: float) -> None:
    """Noise, harmonics, amplitude and frequency, also where cycles are no whole samples."""
    rig = ms.VirtualTribometer(
        CELL, noise={"force": 1.5, "displacement": 2e-8}, sample_rate=rate, third_harmonic=0.04
    )
    folded = fold(rig.record(amplitude=6e-6, frequency=1.0, cycles=60))
    assert folded.cycles == 59
    assert folded.left_out == 1
    assert folded.harmonics.tolist() == [1, 3]
    assert folded.amplitude == pytest.approx(6e-6, rel=1e-3)
    assert folded.frequency == pytest.approx(1.0, rel=1e-5)
    # 59 cycles of 64 samples: two standard deviations are 2.3 %; kinks add some.
    assert folded.force_noise == pytest.approx(1.5, rel=0.06)
    assert folded.displacement_noise == pytest.approx(2e-8, rel=0.025)
    assert folded.cycle_force.shape == (59, folded.phase.size)
    assert np.all(np.diff(folded.phase) > 0.0)
    loop = folded.loop
    assert loop.dissipated_energy == pytest.approx(CELL.dissipated_energy(6e-6), rel=0.01)
    assert stiffness_after_reversal(loop) == pytest.approx(5e7, rel=0.15)
    assert "Folded" in repr(folded)


def test_cycles_that_do_not_close_are_left_out() -> None:
    """Such as where the force jumps; and cycles can be chosen."""
    made = record(cycles=8, noise=0.001)
    force = made.force.copy()
    force[250:] += 150.0
    folded = fold(ms.Record(made.displacement, force, sample_rate=64.0))
    assert folded.left_out >= 2
    assert fold(made, slice(2, 6)).cycles == 4


@pytest.mark.parametrize("value", [1e4, 160.0])
def test_a_spike_costs_its_cycle_only(value: float) -> None:
    """One sample far off, of the record or only of what other cycles have at its phase."""
    made = record(cycles=8)
    force = made.force.copy()
    place = 64 * 3 + 40
    force[place] = -np.sign(force[place]) * value
    folded = fold(ms.Record(made.displacement, force, sample_rate=64.0))
    clean = fold(made)
    assert (folded.cycles, folded.left_out) == (clean.cycles - 1, 2)
    assert folded.force_noise == pytest.approx(clean.force_noise, rel=0.1)
    (note,) = folded.said
    assert f"at sample {place}" in note
    assert "left out of the means: 1 cycle" in note
    found = ms.identify(
        ms.Record(made.displacement, force, sample_rate=64.0), "jenkins", rig_stiffness=None
    )
    assert any(f"at sample {place}" in text for text in found.notes)
    assert found.parameters["force_limit"].value == pytest.approx(100.0, rel=2e-3)
    # Where too few cycles are left, a straight line stands in its place.
    short = fold(ms.Record(made.displacement, force, sample_rate=64.0), slice(2, 5))
    assert short.cycles == 3
    assert any("count all the same" in note for note in short.said)
    assert fold(made).said == ()


def test_the_load_is_that_of_the_evaluated_cycles() -> None:
    """Not of the way from rest; a load that changes is said, or refused."""
    made = record(cycles=8)
    load = np.full(len(made), 300.0)
    load[:64] = 0.0  # the cycle that is left out
    assert fold(_loaded(made, load)).normal_load == pytest.approx(300.0)
    load[64:] = np.linspace(300.0, 320.0, load.size - 64)
    folded = fold(_loaded(made, load))
    assert folded.normal_load == pytest.approx(310.0, rel=0.01)
    assert "the normal load is" in folded.said[0]
    load[64:] = np.linspace(300.0, 450.0, load.size - 64)
    with pytest.raises(ms.InputError, match="must be the same in all cycles"):
        fold(_loaded(made, load))


def _loaded(made: ms.Record, load: Any) -> ms.Record:
    return ms.Record(made.displacement, made.force, normal_load=load, sample_rate=64.0)


def test_a_free_delay_and_a_known_one() -> None:
    """A force that lags: told, or taken off, the values are those without."""
    rig = ms.VirtualTribometer(CELL, sample_rate=256.0, noise=0.002)
    made = rig.record(amplitude=6e-6, frequency=1.0, cycles=8)
    late = ms.Record(made.displacement[5:], made.force[:-5], sample_rate=256.0)
    for delay in ("free", 5.0 / 256.0):
        found = ms.identify(late, "jenkins", rig_stiffness=None, delay=delay, held_back=0)
        assert found.parameters["stiffness"].value == pytest.approx(5e7, rel=0.01)
        # 256 forces: the standard deviation is 9 %.
        assert found.reduced_chi_squared == pytest.approx(1.0, abs=0.3)
        assert found.records[0].delay == pytest.approx(5.0 / 256.0, rel=0.01)
        if delay != "free":
            assert not found.delays
            assert found.summary()["records"][0]["delay"] is None
            continue
        (one,) = found.delays.values()
        assert one.low < 5.0 / 256.0 < one.high
        plain = found.summary()["records"][0]["delay"]
        assert (plain["value"], plain["unit"]) == (one.value, "s")
        assert json.dumps(found.summary(), allow_nan=False)
        (line,) = (line for line in found.table().splitlines() if line.startswith("delay"))
        assert "19." in line
        assert "identified" in line


def test_a_delay_without_time_is_a_phase() -> None:
    """And each of several records has its own, by its name."""
    made = [record(seed=seed) for seed in range(2)]
    bare = [ms.Record(one.displacement, one.force, name=f"r{i}") for i, one in enumerate(made)]
    found = ms.identify(bare, "jenkins", rig_stiffness=None, delay="free", held_back=0)
    assert list(found.delays) == ["r0", "r1"]
    for name, one in found.delays.items():
        assert one.name == f"delay of {name}"
        assert one.unit == "rad"
        assert one.low < 0.0 < one.high
    again = pickle.loads(pickle.dumps(found))
    assert again.delays == found.delays
    assert isinstance(again.delays, MappingProxyType)


def test_a_delay_that_was_given_wrong_is_doubted() -> None:
    """A third of a period leaves nearly all of the force."""
    found = ms.identify(record(), "jenkins", rig_stiffness=None, delay=0.3, held_back=0)
    assert found.reduced_chi_squared > 25.0
    assert any('delay="free"' in text for text in found.notes)


# -- what is quick, and what is said of it --------------------------------------------------------


def three_loads() -> list[ms.Record]:
    """One amplitude at each of three loads."""
    return [
        record(JOINT.at(normal_load=load), 3e-6, seed=i, noise=0.002)
        for i, load in enumerate((300.0, 1000.0, 3000.0))
    ]


@pytest.mark.slow
def test_all_laws_on_three_loads() -> None:
    """Laws with free parameters at each load are fitted, too, and the right one is the best."""
    compared = ms.compare(three_loads())
    assert set(compared.fits) == {
        *("interface", "jenkins", "iwan", "segalman", "sphere"),
    }
    assert compared.best == "interface"
    for fit in compared.fits.values():
        assert fit.evaluations < 1500
        assert any("all intervals are from the curvature" in note for note in fit.notes)
        assert all(one.profile == () for one in fit.parameters.values())


def test_profiles_end_in_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beyond the limit the intervals are those of the curvature, and a note says so."""
    from microslip.identification import intervals

    whole = joint()
    monkeypatch.setattr(intervals, "_MOST_WORK", 0.0)
    found = ms.identify(three_loads(), summits=np.inf)
    assert any("from the curvature" in note for note in found.notes)
    assert not any("curvature" in note for note in whole.notes)


def test_curvature_is_near_the_profile() -> None:
    """Where a law is nearly linear both intervals are the same."""
    records = [record(), record(amplitude=3e-6, seed=1)]
    quick = ms.identify(records, "jenkins", rig_stiffness=None, intervals="curvature")
    for name, one in cell().parameters.items():
        other = quick.parameters[name]
        width = one.high - one.low
        assert abs(other.low - one.low) < 0.2 * width
        assert abs(other.high - one.high) < 0.2 * width


def test_loads_that_share_nothing_are_parts() -> None:
    """On a rigid rig the loads of a law without load have nothing in common, on a free one all."""
    from microslip.identification import fold, models
    from microslip.identification.coordinates import rig_coordinates
    from microslip.identification.parameter_choice import coordinates_for
    from microslip.identification.problem import Problem

    folded = [fold(one) for one in three_loads()]
    model = models.model_of("jenkins")
    nothing = dict.fromkeys(("fixed", "bounds", "start", "shared", "per_load"))
    coordinates, columns, _ = coordinates_for(model, folded, **nothing)
    problem = Problem(folded, model, coordinates, columns, [None] * 3)
    assert [part.size for part in problem.parts] == [2, 2, 2]
    more, rigs = rig_coordinates("free", None, [one.loop for one in folded], None)
    places = [None if rig is None else len(coordinates) + rig for rig in rigs]
    whole = Problem(folded, model, [*coordinates, *more], columns, places)
    assert [part.size for part in whole.parts] == [7]


def test_the_points_of_a_profile() -> None:
    """They begin at the best value, rise on both sides and reach the level."""
    for one in cell().parameters.values():
        values, rises = np.array(one.profile).T
        assert np.all(np.diff(values) > 0.0)
        assert rises.min() == 0.0
        assert values[rises.argmin()] == pytest.approx(one.value, rel=1e-12)
        assert rises[0] > 3.7  # 3.84 less the tolerance of an end
        assert rises[-1] > 3.7


# -- what is open ---------------------------------------------------------------------------------


def test_what_is_open_has_no_number() -> None:
    """In full stick neither force limit nor yield displacement have an upper end."""
    found = ms.identify(record(amplitude=1e-6), "jenkins", rig_stiffness=None)
    for one in (found.parameters["force_limit"], found.derived["yield_displacement"]):
        assert one.verdict == "bounded below"
        assert one.high == float("inf")
        assert one.high_open
        assert not one.low_open
    assert found.parameters["stiffness"].identified
    # 1 um of the cycle and no more than 2 % above or below it.
    assert found.derived["yield_displacement"].low == pytest.approx(1e-6, rel=0.02)
    line = next(line for line in found.table().splitlines() if line.startswith("yield"))
    assert "from 9" in line or "from 1.0" in line
    assert "…" not in line
    assert found.summary()["parameters"]["force_limit"]["high"] is None


def test_prefixes_have_the_power_one() -> None:
    """A millionth of a square metre is no square micrometre."""
    from microslip.identification.caveats import number_text

    assert number_text(5.58e-6, "m^2") == "5.58e-06 m²"
    assert number_text(2.5e6, "m^-1.5") == "2.50e+06 m⁻¹·⁵"
    assert number_text(5.58e-6, "m") == "5.58 µm"
    assert number_text(float("inf"), "N/m") == "infinite"


def test_a_study_has_the_joints_own_amplitudes() -> None:
    """Loads that differ by noise are one; the rig's part of the amplitude is not the joint's."""
    stiffness, top = 3e8, 6e-6
    records = [
        record(JOINT.at(normal_load=load), top, seed=i, noise=0.002, rig_stiffness=stiffness)
        for i, load in enumerate((1000.0, 1001.0, 3000.0))
    ]
    found = ms.identify(records, pair=JOINT.surface.pair, rig_stiffness=stiffness, summits=np.inf)
    study = found.study()
    assert len(study["joint"]["normal_load"]) == 2
    units = {"um": 1e-6, "nm": 1e-9}
    pairs = [text.split() for text in study["excitation"]["amplitudes"]]
    light, heavy = sorted((float(size) * units[unit] for size, unit in pairs), reverse=True)
    # In gross slip the rig takes mu N/k; a noisy peak is good to 2 %. Near it, a little less.
    wanted = [top - JOINT.friction_coefficient * load / stiffness for load in (1000.0, 3000.0)]
    assert light == pytest.approx(wanted[0], rel=0.02)
    assert wanted[1] < heavy < 1.5 * wanted[1]


# -- what the page shows of delays and of cells that are none -----------------------------------


def _number(**more: Any) -> dict[str, Any]:
    plain: dict[str, Any] = {
        "value": 312e-6, "low": 309e-6, "high": 315e-6, "unit": "s", "verdict": "identified",
        "at_bound": False, "remedy": "", "reason": "", "normal_load": None,
    }  # fmt: skip
    return {**plain, **more}


@pytest.mark.parametrize(
    ("number", "text"),
    [
        (_number(), "312.0 ± 3.0 µs"),
        (_number(value=-2e-9, low=-3.3e-6, high=3.3e-6), "0.0 ± 3.3 µs"),
        (_number(value=0.02, low=0.0199, high=0.0201, unit="rad"), "20.00 ± 0.10 mrad"),
        (_number(verdict="not identified"), "–"),
        (None, "–"),
    ],
    ids=["delay", "about-none", "phase", "open", "of-another-record"],
)
def test_a_delay_stands_beside_its_record(number: Any, text: str) -> None:
    """With half of its interval; a table without any has no such column."""
    from microslip.report.identified.document import _records
    from microslip.report.identified.numbers import delay_text

    plain = cell().summary()["records"]
    for record in plain:
        record["rms_residual"] = 0.1
    assert {row[-1] for row in _records(plain).rows} == {None}
    plain[0]["delay"], plain[1]["delay"] = number, _number()
    assert _records(plain).rows[0][-1] == delay_text(number) == text


def test_a_cell_that_is_none_is_not_listed_as_open() -> None:
    """There is nothing to settle about it; about what is only bounded there is."""
    from microslip.report.identified.numbers import open_parameters

    empty = _number(verdict="bounded above", at_bound=True, low=0.0, value=0.0)
    wanted = _number(verdict="bounded above", remedy="measure", reason="up to 3 N")
    found = {"parameters": {"stiffness_1": empty, "force_limit": wanted}}
    assert open_parameters(found) == [("force limit μN", wanted)]


def test_long_records_fold_in_little_memory() -> None:
    """Eleven numbers a sample beside the record, pieces of it included; not fifty."""
    count = 400_000
    turn = np.arange(count) / 150.37
    one = np.linspace(0.0, 1.0, 2001)
    cycle = CELL.force(np.tile(4e-6 * np.sin(2.0 * np.pi * one), 2))[2001:]
    rng = np.random.default_rng(5)
    long = ms.Record(
        4e-6 * np.sin(2.0 * np.pi * turn) + 1e-9 * rng.normal(size=count),
        np.interp(turn % 1.0, one, cycle) + rng.normal(size=count),
        normal_load=200.0,
        sample_rate=1500.0,
    )
    tracemalloc.start()
    folded = fold(long)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert folded.cycles > 2600
    assert folded.force_noise == pytest.approx(1.0, rel=0.01)
    assert peak < 8 * 11 * count + 40e6
