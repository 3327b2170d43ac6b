"""An identification against the laws that made its records, differences, and another method."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import microslip as ms
from microslip.identification import fold, run
from microslip.identification.coordinates import RIG, Coordinate, coordinate_of
from microslip.identification.models import MODELS, Model
from microslip.identification.problem import Problem

Floats = NDArray[np.float64]

JOINT = ms.Interface.examples()[0]
CELL = ms.Jenkins(stiffness=5e7, force_limit=100.0)
REAL = Path(__file__).parents[3] / "shared/data/reciprocating/test_data_2.txt"


def record_of(
    law: Any,
    amplitude: float,
    *,
    seed: int = 0,
    force: float = 0.0,
    displacement: float = 0.0,
    samples: int = 128,
    cycles: int = 6,
    rig: float | None = None,
    load: float | None = None,
) -> ms.Record:
    """Cycles of any law from rest, with noise of both channels."""
    angle = 2.0 * math.pi * np.arange(int((cycles + 0.25) * samples) + 1) / samples
    x = amplitude * np.sin(angle)
    if rig is not None:
        answer = ms.VirtualTribometer(law, rig_stiffness=rig).series.force(x)
    else:
        answer = law.force(x)
    rng = np.random.default_rng(seed)
    return ms.Record(
        x + displacement * rng.standard_normal(x.size),
        np.asarray(answer) + force * rng.standard_normal(x.size),
        normal_load=load,
        sample_rate=float(samples),
        name=f"amplitude {amplitude:g} m",
    )


# -- what made the records comes back -------------------------------------------------------------


def interfaces() -> list[ms.Record]:
    """Two loads and two amplitudes behind a rig, without noise."""
    return [
        record_of(JOINT.at(normal_load=load), amplitude, rig=1e9, load=load)
        for load in (300.0, 3000.0)
        for amplitude in (1e-6, 5e-6)
    ]


def test_an_interface_comes_back() -> None:
    """Without noise every parameter to 1e-6, the rig's too."""
    found = ms.identify(interfaces(), pair=JOINT.surface.pair, area=2e-4, summits=np.inf)
    assert found.status == "converged"
    one = {name: value.value for name, value in found.parameters.items()}
    reference = JOINT.at(normal_load=math.sqrt(300.0 * 3000.0))
    assert one["friction_coefficient"] == pytest.approx(0.55, rel=1e-6)
    assert one["slip_scale"] == pytest.approx(JOINT.slip_per_indentation * 0.5e-6, rel=1e-6)
    assert one["standardised_separation"] == pytest.approx(reference.separation / 0.5e-6, abs=1e-6)
    assert one["rig_stiffness"] == pytest.approx(1e9, rel=1e-6)
    assert found.derived["std"].value == pytest.approx(0.5e-6, rel=1e-6)
    product = found.derived["density_root_radius"].value
    assert product == pytest.approx(1e8 * math.sqrt(1e-3), rel=1e-5)
    made = found.joint(1000.0)
    there = JOINT.at(normal_load=1000.0)
    assert made.tangential_stiffness == pytest.approx(there.tangential_stiffness, rel=1e-6)
    assert made.dissipated_energy(1e-6) == pytest.approx(there.dissipated_energy(1e-6), rel=1e-6)


OTHERS: dict[str, tuple[Any, tuple[float, ...], dict[str, float]]] = {
    "jenkins": (CELL, (1e-6, 8e-6), {"stiffness": 5e7, "force_limit": 100.0}),
    "segalman": (
        ms.SegalmanIwan(force_limit=4000.0, stiffness=1.5e8, chi=-0.5, beta=0.6),
        (1.5e-5, 1.5e-4),
        {"force_limit": 4000.0, "stiffness": 1.5e8, "chi": -0.5, "beta": 0.6},
    ),
}


@pytest.mark.parametrize("name", [model.name for model in MODELS if model.name in OTHERS])
def test_other_laws_come_back(name: str) -> None:
    """Without noise every parameter to 1e-6."""
    law, amplitudes, wanted = OTHERS[name]
    records = [record_of(law, amplitude) for amplitude in amplitudes]
    found = ms.identify(records, name, rig_stiffness=None, held_back=0)
    for parameter, value in wanted.items():
        assert found.parameters[parameter].value == pytest.approx(value, rel=1e-6), parameter


def test_cells_of_iwan_come_back() -> None:
    """Its grid of yields is its own; on it the force and the stiffness of the law come back."""
    model = next(model for model in MODELS if model.name == "iwan")
    records = [record_of(JOINT, amplitude, load=2000.0) for amplitude in (1e-6, 4e-6)]
    found = ms.identify(records, "iwan", rig_stiffness=None, held_back=0)
    assert found.law == model.name
    made = found.joint()
    assert made.force_limit == pytest.approx(JOINT.force_limit, rel=2e-3)
    assert made.dissipated_energy(4e-6) == pytest.approx(JOINT.dissipated_energy(4e-6), rel=5e-3)


# -- the Jacobian ---------------------------------------------------------------------------------


def problem_of(model: Model, values: dict[str, float], rig: float | None) -> tuple[Problem, Floats]:
    """A problem of two records of some model, at values a little off."""
    load = 800.0 if model.scales_with_load else None
    records = [
        record_of(CELL, a, force=0.5, displacement=1e-8, load=load or 100.0, samples=48)
        for a in (1e-6, 5e-6)
    ]
    folded = [fold(record) for record in records]
    prepared = model.prepared([one.loop for one in folded], [one.normal_load for one in folded])
    coordinates = [coordinate_of(p, values[p.name]) for p in prepared.parameters]
    place = None
    if rig is not None:
        place = len(coordinates)
        coordinates.append(Coordinate(RIG, RIG, "N/m", 1e3, math.inf, "inverse", rig, scale=1e8))
    columns = tuple(range(len(prepared.parameters)))
    problem = Problem(folded, prepared, coordinates, [columns] * 2, [place] * 2)
    q = np.array([one.inner(one.start) for one in coordinates])
    low, high = np.array([one.limits for one in coordinates]).T
    q = np.clip(q, low + 1e-3, high - 1e-3)  # differences need both sides
    problem.update(q)
    return problem, q


EXAMPLES = [(model.name, at) for model in MODELS for at in range(len(model.examples()[:3]))]


@pytest.mark.parametrize(("name", "at"), EXAMPLES, ids=[f"{n}-{i}" for n, i in EXAMPLES])
def test_jacobian_of_the_whole_residual(name: str, at: int) -> None:
    """Through tree, rig, bins and nuisances it is that of central differences."""
    model = next(m for m in MODELS if m.name == name)
    one, values = model.examples()[at]
    problem, q = problem_of(one, dict(values), 3e8)
    _, by = problem.residuals(q)
    assert np.isfinite(by).all()
    for i in range(q.size):
        step = np.zeros(q.size)
        step[i] = 1e-6 * max(abs(q[i]), 1e-2)
        up, down = problem.residuals(q + step)[0], problem.residuals(q - step)[0]
        rise = (up - down) / (2.0 * step[i])
        rounding = 1e-12 * float(np.abs(up).max()) / step[i]
        # Differences lose half the digits; where a cell yields within a step, one force is off.
        size = float(np.abs(by[:, i]).max()) or 1.0
        off = np.abs(rise - by[:, i]) > 2e-4 * size + rounding
        assert np.count_nonzero(off) <= 0.05 * off.size, problem.coordinates[i].name


@pytest.mark.parametrize(("name", "at"), EXAMPLES, ids=[f"{n}-{i}" for n, i in EXAMPLES])
def test_errors_of_the_displacement_act_as_differences_do(name: str, at: int) -> None:
    """Through tree and memory, of every harmonic; the mean force is free in any case."""
    model = next(m for m in MODELS if m.name == name)
    one, values = model.examples()[at]
    problem, q = problem_of(one, dict(values), 3e8)
    problem.update(q)
    for number, folded in enumerate(problem.folded):
        where = problem.order.index(number)
        step = 1e-5 * folded.amplitude
        for k in range(1, folded.coefficients.size):
            forces = []
            for way in (1.0, -1.0):
                moved = folded.coefficients.copy()
                moved[k] += way * step
                others = list(problem.folded)
                others[number] = replace(folded, coefficients=moved)
                again = Problem(
                    others, problem.model, problem.coordinates, problem.columns, problem.rigs
                )
                forces.append(again.to_bins(again.respond(q)[0])[again.bins[where]])
            rise = (forces[0] - forces[1]) / (2.0 * step)
            felt = problem.nuisance_effects[where][k]
            miss = rise - felt
            miss -= np.median(miss)
            # Cells that yield within a step, and branches that begin as roots, are off.
            off = np.abs(miss) > 1e-3 * float(np.abs(rise).max())
            assert np.count_nonzero(off) <= 0.1 * off.size, (number, k)


# -- weights that follow the law ------------------------------------------------------------------


def problem_behind(
    monkeypatch: pytest.MonkeyPatch, records: list[ms.Record], law: str, **options: Any
) -> tuple[ms.Identification, Problem, Floats]:
    """An identification, and its problem with the fitted coordinates of the best values."""
    kept: list[Any] = []

    class Kept(run.Profiled):
        def __init__(self, *given: Any) -> None:
            super().__init__(*given)
            kept.append(self.best)

    monkeypatch.setattr(run, "Profiled", Kept)
    found = ms.identify(records, law, held_back=0, intervals="curvature", **options)
    return found, kept[0].problem, kept[0].q


def far_from_all() -> list[ms.Record]:
    """Records of an interface with much noise of the displacement, which no other law answers."""
    return [
        record_of(JOINT, a, load=2000.0, seed=i, force=1.0, displacement=2e-7, rig=1e9)
        for i, a in enumerate((1e-6, 5e-6))
    ]


@pytest.mark.parametrize("law", ["interface", "jenkins", "iwan"])
def test_the_sum_of_squares_is_that_of_its_own_weights(
    monkeypatch: pytest.MonkeyPatch, law: str
) -> None:
    """Or the fit does not count as converged: weights that swing settle no number."""
    found, problem, q = problem_behind(monkeypatch, far_from_all(), law, rig_stiffness="free")
    assert found.converged == (law != "jenkins")
    if not found.converged:
        assert "do not converge" in found.message
        return
    problem.update(q)
    rest, _ = problem.residuals(q)
    assert float(rest @ rest) == pytest.approx(found.chi_squared, rel=0.01)


@pytest.mark.parametrize("loss", ["linear", "cauchy"])
def test_criteria_hold_the_determinant_of_the_covariance(
    monkeypatch: pytest.MonkeyPatch, loss: str
) -> None:
    """Whole matrices say the same; each law has a covariance of its own."""
    found, problem, _ = problem_behind(monkeypatch, far_from_all(), "interface", loss=loss)
    whole = 0.0
    for at, (i, span) in enumerate(zip(problem.order, problem.bins, strict=True)):
        folded, weight = problem.folded[i], problem.weight[span]
        noise = np.sqrt(folded.count) / folded.force_noise
        offset = weight / np.linalg.norm(weight)
        felt = problem.nuisance_effects[at] * weight
        felt -= np.outer(felt @ offset, offset)
        drifted = folded.drifted * weight
        drifted -= (drifted @ offset) * offset
        matrix = np.eye(weight.size) + felt.T @ folded.covariance @ felt
        matrix += np.outer(drifted, drifted)
        whole += float(np.linalg.slogdet(matrix)[1]) - 2.0 * float(np.log(weight / noise).sum())
    assert whole > 10.0
    fitted = len(found.names) + len(found.records)
    # Directions that the force hardly feels, below 0.02 of its noise, are left out.
    assert found.aic - found.chi_squared - 2.0 * fitted == pytest.approx(whole, abs=0.05)


# -- invariances ----------------------------------------------------------------------------------


def noisy(seed: int = 0) -> list[ms.Record]:
    """Two loads with noise."""
    return [
        record_of(
            JOINT.at(normal_load=load),
            3e-6,
            seed=seed + i,
            force=0.003 * 0.55 * load,
            displacement=4e-9,
            load=load,
        )
        for i, load in enumerate((500.0, 2000.0))
    ]


def values_of(found: ms.Identification) -> dict[str, tuple[float, float, float]]:
    return {n: (one.low, one.value, one.high) for n, one in found.parameters.items()}


def same(a: ms.Identification, b: ms.Identification, rel: float = 2e-3) -> None:
    """Values to a share of their intervals; the ends are found to one per cent."""
    for name, (low, value, high) in values_of(a).items():
        other = values_of(b)[name]
        width = high - low
        assert abs(other[1] - value) <= rel * width, name
        assert abs(other[0] - low) <= 0.02 * width, name
        assert abs(other[2] - high) <= 0.02 * width, name


def test_choices_without_effect() -> None:
    """Order of the records, zeros of both channels, which way is positive, when it began."""
    records = noisy()
    base = ms.identify(records, rig_stiffness=None, held_back=0, summits=np.inf)
    same(base, ms.identify(records[::-1], rig_stiffness=None, held_back=0, summits=np.inf))
    moved = [
        ms.Record(r.displacement + 3e-5, r.force - 200.0, r.normal_load, sample_rate=r.sample_rate)
        for r in records
    ]
    same(base, ms.identify(moved, rig_stiffness=None, held_back=0, summits=np.inf))
    turned = [
        ms.Record(-r.displacement, -r.force, r.normal_load, sample_rate=r.sample_rate)
        for r in records
    ]
    # Its cycles begin half a cycle later, with other samples left out: the same within the noise.
    other = values_of(ms.identify(turned, rig_stiffness=None, held_back=0, summits=np.inf))
    for name, (low, value, high) in values_of(base).items():
        assert abs(other[name][1] - value) < 0.5 * (high - low), name
    no_clock = [ms.Record(r.displacement, r.force, r.normal_load) for r in records]
    same(base, ms.identify(no_clock, rig_stiffness=None, held_back=0, summits=np.inf))


def test_units_scale() -> None:
    """Lengths and forces a thousand times as large: all values scale, nothing else changes."""
    small = [record_of(CELL, a, seed=i, force=0.3) for i, a in enumerate((3e-6, 8e-6))]
    large = [
        ms.Record(1e3 * r.displacement, 1e3 * r.force, sample_rate=r.sample_rate) for r in small
    ]
    one = ms.identify(small, "jenkins", rig_stiffness=None, held_back=0).parameters
    other = ms.identify(large, "jenkins", rig_stiffness=None, held_back=0).parameters
    assert other["stiffness"].value == pytest.approx(one["stiffness"].value, rel=1e-6)
    assert other["force_limit"].value == pytest.approx(1e3 * one["force_limit"].value, rel=1e-6)
    assert other["force_limit"].low == pytest.approx(1e3 * one["force_limit"].low, rel=1e-4)


def test_a_stiff_rig_is_a_rigid_one() -> None:
    """The limit of a large stiffness."""
    records = noisy()
    rigid = ms.identify(records, rig_stiffness=None, held_back=0, summits=np.inf)
    stiff = ms.identify(records, rig_stiffness=1e15, held_back=0, summits=np.inf)
    for name, one in rigid.parameters.items():
        assert stiff.parameters[name].value == pytest.approx(one.value, rel=1e-4), name


# -- statistics -----------------------------------------------------------------------------------


def test_intervals_are_those_of_minos(monkeypatch: pytest.MonkeyPatch) -> None:
    """Iminuit's MINOS, on the sum of squares and its gradient alone, finds the same ends.

    James and Roos (1975, DOI 10.1016/0010-4655(75)90039-9).
    """
    minuit = pytest.importorskip("iminuit", reason="MINOS is that of iminuit, which is not here")
    records = [*noisy(), *noisy(7)]
    own = ms.identify(records, rig_stiffness=None, held_back=0, summits=np.inf)
    _, problem, best = problem_behind(monkeypatch, records, "interface", rig_stiffness=None)
    residual, by = problem.residuals(best)
    least, unit = float(residual @ residual), np.linalg.norm(by, axis=0)

    def value(z: Floats) -> float:
        there, _ = problem.residuals(best + z / unit)
        return float(there @ there) - least

    def gradient(z: Floats) -> Floats:
        there, by = problem.residuals(best + z / unit)
        return np.asarray(2.0 * (by.T @ there) / unit)

    for row, (name, number) in enumerate(own.parameters.items()):
        assert number.verdict == "identified"
        names = [f"z{k}" for k in range(best.size)]
        search = minuit.Minuit(value, np.zeros(best.size), grad=gradient, name=names)
        search.errordef = 3.841458820694124 * own.widened[name] ** 2
        search.migrad()
        search.minos(names[row])
        errors = search.merrors[names[row]]
        coordinate = problem.coordinates[row]
        low, high = (
            coordinate.outer(best[row] + (search.values[row] + error) / unit[row])
            for error in (errors.lower, errors.upper)
        )
        width = number.high - number.low
        assert low == pytest.approx(number.low, abs=0.02 * width), name
        assert high == pytest.approx(number.high, abs=0.02 * width), name


def test_reduced_chi_squared_is_near_one() -> None:
    """The noise is that of the cycles, the displacement's counted: mean over 12 seeds."""
    found = [
        ms.identify(noisy(100 * seed), rig_stiffness=None, held_back=0.25, summits=np.inf)
        for seed in range(12)
    ]
    each = [one.reduced_chi_squared for one in found]
    # 12 times 250 degrees of freedom: standard deviation 2.6 %, that of the noise 1.2 %.
    assert np.mean(each) == pytest.approx(1.0, abs=0.08)
    predicted = [one.held_back for one in found]
    assert np.mean([p for p in predicted if p is not None]) == pytest.approx(1.0, abs=0.06)


def test_noise_of_the_displacement_counts() -> None:
    """Were it left out, the residuals would exceed the noise of the force by far."""
    record = record_of(CELL, 1.5e-6, displacement=5e-9, force=0.02, cycles=8)
    found = ms.identify(
        record, "jenkins", rig_stiffness=None, fixed={"force_limit": 1e3}, held_back=0
    )
    assert found.reduced_chi_squared < 1.4
    low, value, high = values_of(found)["stiffness"]
    assert low < 5e7 < high
    # It sticks: the amplitude is known to 5e-9 sqrt(2/896), and the stiffness to its share.
    share = 5e-9 * math.sqrt(2.0 / 896.0) / 1.5e-6
    assert (high - low) / value == pytest.approx(2.0 * 1.96 * share, rel=0.15)


def test_cycles_need_not_be_whole_samples() -> None:
    """A rig with a clock of its own: the phase is that of the whole record."""
    rig = ms.VirtualTribometer(
        JOINT, rig_stiffness=2e8, noise={"force": 5.0, "displacement": 2e-8}, sample_rate=517.3
    )
    found = ms.identify(
        rig.record(amplitude=2e-5, frequency=1.0, cycles=60), held_back=0, summits=np.inf
    )
    assert found.reduced_chi_squared == pytest.approx(1.0, abs=0.2)
    for name, value in (
        ("slip_scale", JOINT.slip_per_indentation * 0.5e-6),
        ("rig_stiffness", 2e8),
        ("standardised_separation", JOINT.separation / 0.5e-6),
    ):
        one = found.parameters[name]
        # Three standard errors; the sampled record turns 1e-5 of its amplitude early.
        assert abs(one.value - value) < 3.0 * one.standard_error, name


def test_plateaus_ask_for_many_harmonics() -> None:
    """A rounded trapezoid, as of a rig that waits at its ends."""
    rng = np.random.default_rng(2)
    angle = 2.0 * math.pi * np.arange(40 * 256 + 1) / 256
    x = 8e-6 * np.tanh(2.5 * np.sin(angle)) / math.tanh(2.5)
    force = np.asarray(CELL.force(x)) + 0.3 * rng.standard_normal(x.size)
    record = ms.Record(x + 1e-8 * rng.standard_normal(x.size), force, sample_rate=256.0)
    found = ms.identify(record, "jenkins", rig_stiffness=None, held_back=0)
    harmonics = found.records[0].folded.harmonics
    assert np.all(harmonics % 2 == 1)
    assert harmonics.size >= 4
    assert found.reduced_chi_squared == pytest.approx(1.0, abs=0.3)
    for name, value in (("stiffness", 5e7), ("force_limit", 100.0)):
        one = found.parameters[name]
        assert abs(one.value - value) < 3.5 * one.standard_error, name


def test_cycles_that_scatter_widen_the_intervals() -> None:
    """A friction that changes from cycle to cycle is no white noise: whole cycles count."""
    rng = np.random.default_rng(3)
    angle = 2.0 * math.pi * np.arange(64) / 64
    x = 8e-6 * np.cos(angle)
    forces = []
    for _ in range(24):
        limit = 100.0 * (1.0 + 0.02 * rng.standard_normal())
        forces.append(ms.Jenkins(5e7, limit).periodic(x).force)
    force = np.concatenate(forces) + 0.2 * rng.standard_normal(24 * 64)
    record = ms.Record(np.tile(x, 24), force, sample_rate=64.0)
    found = ms.identify(record, "jenkins", rig_stiffness=None, held_back=0)
    assert found.widened["force_limit"] > 2.0
    one = found.parameters["force_limit"]
    # The mean of 23 cycles of 2 % each.
    assert one.standard_error == pytest.approx(100.0 * 0.02 / math.sqrt(23.0), rel=0.4)
    assert any("scatter" in note for note in found.notes)


def test_a_law_that_does_not_fit_says_so() -> None:
    """An interface is no cell: intervals widen, and the comparison prefers the interface."""
    records = noisy()
    found = ms.identify(records, "jenkins", rig_stiffness=None, held_back=0)
    assert found.reduced_chi_squared > 3.0
    assert any("misfit is larger than the noise" in note for note in found.notes)
    both = ms.compare(records, ["jenkins", "interface"], rig_stiffness=None)
    assert both.best == "interface"
    errors = {row["law"]: row["held_back"] for row in both.rows()}
    assert errors["interface"] < 1.2 < errors["jenkins"]


@pytest.mark.slow
def test_a_wrong_value_that_is_fixed_leaves_nothing_identified() -> None:
    """Forty per cent of the force is left: the message says so, and no bound of the search counts.

    Within 1 of its logarithm a length that is searched between 100 fm and 100 mm is at a bound.
    """
    record = record_of(JOINT, 5e-6, load=2000.0, force=2.0, displacement=2e-9, rig=1e9)
    for rig in ("free", None):
        found = ms.identify(
            record,
            fixed={"friction_coefficient": 0.3},
            rig_stiffness=rig,
            held_back=0,
            summits=np.inf,
        )
        assert "the law does not fit the records" in found.message
        assert any("% of the force" in note for note in found.notes)
        assert all(one.verdict != "identified" for one in found.parameters.values())
        assert all(one.verdict != "identified" for one in found.derived.values())
        scale = found.parameters["slip_scale"]
        assert scale.low_open or scale.low > 1e-12
        assert scale.high_open or scale.high < 1e-2
    right = ms.identify(record, fixed={"friction_coefficient": 0.55}, held_back=0, summits=np.inf)
    assert "does not answer" not in right.message


def test_an_end_at_the_bound_of_another_is_open() -> None:
    """With the separation at the end of its search the length kappa sigma has no end there."""
    surface = ms.GreenwoodWilliamson(JOINT.surface.pair, ms.Gaussian(4e-9), 1e-4, 1e10, 2e-4)
    joint = ms.Interface(surface, 0.55, 2000.0)
    scale = joint.slip_per_indentation * 4e-9
    noise = 2e-3 * joint.force_limit
    record = record_of(joint, 2.0 * scale, load=2000.0, seed=3, force=noise)
    found = ms.identify(
        record, pair=JOINT.surface.pair, rig_stiffness=None, held_back=0, summits=np.inf
    )
    assert found.parameters["standardised_separation"].low_open
    for one, truth in ((found.parameters["slip_scale"], scale), (found.derived["std"], 4e-9)):
        assert one.verdict == "bounded above", one.name
        assert one.low <= truth <= one.high
    # What the bound hardly moves is told all the same.
    friction = found.parameters["friction_coefficient"]
    assert friction.verdict == "extrapolated"
    assert friction.low <= 0.55 <= friction.high
    assert found.derived["tangential_stiffness"].verdict == "identified"


def test_the_rig_that_differs_is_named() -> None:
    """Two rigs in the records "a", one behind "b" that is nearly rigid; the order is no matter."""
    odd = [
        record_of(JOINT, 4e-6, load=2000.0, seed=i, force=2.0, rig=rig)
        for i, rig in enumerate((1e9, 5e8))
    ]
    even = [record_of(JOINT, a, load=2000.0, seed=9, force=2.0) for a in (6e-6, 7e-6)]
    said = []
    for records, rigs in ((odd + even, "aabb"), (even + odd, "bbaa")):
        found = ms.identify(
            records, rigs=list(rigs), held_back=0, intervals="curvature", summits=np.inf
        )
        assert found.status == "records differ: rigs"
        assert "'amplitude 4e-06 m" in found.message
        said.append(found.message.split("(")[0])
    assert said[0] == said[1]


def test_laws_of_one_name_are_all_compared() -> None:
    """They are numbered."""
    cells = [next(m for m in MODELS if m.name == "iwan").create(cells=number) for number in (4, 8)]
    laws = [*cells, ms.Jenkins(5e7, 100.0), "jenkins"]
    both = ms.compare(noisy(), laws, rig_stiffness=(1e9, 1e8), held_back=0, cycles=slice(1, 5))
    assert sorted((*both.fits, *both.failed)) == ["iwan", "iwan 2", "jenkins", "jenkins 2"]
    assert not both.failed
    assert len(both.fits["iwan 2"].names) > len(both.fits["iwan"].names)
    least = {row["law"]: row["aic_over_best"] for row in both.rows()}
    assert least[both.best] == 0.0


def test_a_robust_loss_tolerates_an_outlier() -> None:
    """A knock on the table in every cycle at one phase."""
    record = record_of(CELL, 8e-6, force=0.3)
    force = record.force.copy()
    force[40::128] += 60.0
    knocked = ms.Record(record.displacement, force, sample_rate=128.0)
    plain = ms.identify(knocked, "jenkins", rig_stiffness=None, held_back=0)
    robust = ms.identify(knocked, "jenkins", rig_stiffness=None, loss="cauchy", held_back=0)
    miss = abs(robust.parameters["force_limit"].value - 100.0)
    assert miss < 0.2
    assert miss < abs(plain.parameters["force_limit"].value - 100.0)


def test_energy_is_in_the_residuals() -> None:
    """Energy per cycle of the model and of the record agree within the error given."""
    for one in ms.identify(noisy(), rig_stiffness=None, held_back=0, summits=np.inf).records:
        assert abs(one.energy_residual) < 4.0 * one.energy_error + 1e-4
        assert one.measured_energy > 0.0
        assert one.residual == pytest.approx(one.measured - one.model)


# -- a rig that is there --------------------------------------------------------------------------


@pytest.mark.skipif(not REAL.exists(), reason="the measured data are not here")
def test_real_record() -> None:
    """Friction and the rig's stiffness come out, of a force that moves; the separation does not."""
    found = ms.identify(ms.Record.read(REAL, sign=-1), summits=np.inf)
    assert found.converged
    friction = found.parameters["friction_coefficient"]
    assert friction.verdict == "in doubt"
    assert "drifting cycles" in friction.reason
    assert 0.45 < friction.low < friction.value < friction.high < 0.55
    rig = found.parameters["rig_stiffness"]
    assert rig.verdict == "in doubt"
    # By hand: the force turns by 4.8 N over 120 um or so after each reversal.
    assert 3e4 < rig.low < rig.high < 6e4
    separation = found.parameters["standardised_separation"]
    assert separation.verdict == "not identified"
    assert separation.high_open
    assert not separation.low_open
    assert "every value from -" in separation.reason
    assert "nothing is identified" in found.message
    assert "rig's stiffness" in separation.remedy
    assert "another normal load" in separation.remedy
    # The law leaves more than noise, so the intervals are wider than noise makes them.
    assert found.reduced_chi_squared > 10.0
    assert found.widened["friction_coefficient"] > 3.0


@pytest.mark.parametrize("seed", range(4))
def test_ends_behind_a_kink(seed: int) -> None:
    """In full stick the force limit counts only where it cuts the peaks: no derivative tells that.

    Against the lowest sum of squares on a grid of force limits. The weights of errors of the
    displacement move with the kink, which is good for a quarter of a standard error.
    """
    record = ms.VirtualTribometer(CELL, sample_rate=128.0, noise=0.01, seed=seed).record(
        amplitude=1.5e-6, frequency=1.0, cycles=8
    )
    options = {"rig_stiffness": None, "held_back": 0.0, "intervals": "curvature"}
    found = ms.identify(record, "jenkins", rig_stiffness=None, held_back=0.0)
    one = found.parameters["stiffness"]
    for end in (one.low, one.high):
        least = min(
            ms.identify(
                record, "jenkins", fixed={"stiffness": end, "force_limit": limit}, **options
            ).chi_squared
            for limit in np.linspace(74.2, 75.6, 29)
        )
        rise = (least - found.chi_squared) / found.widened["stiffness"] ** 2
        assert abs(math.sqrt(rise) - 1.96) < 0.25
