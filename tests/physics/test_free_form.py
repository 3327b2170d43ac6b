"""The convex fit of a density of sliders against explicit sums, quadrature and memory diagrams."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import minimize, nnls

import microslip as ms
from microslip.identification.free_form import FreeForm
from microslip.identification.loads import backbone_of
from microslip.identification.nonnegative import Path, cone_of, minimum
from microslip.identification.rows import DesignRows
from microslip.laboratory.folding import Folded, fold, load_basis

Floats = NDArray[np.float64]

JOINT = ms.Interface.examples()[0]


def record(
    law: Any, amplitude: float, samples: float = 128.0, noise: float = 0.002, seed: int = 0
) -> ms.Record:
    """Cycles from rest, exact at every turning point, with noise of both channels."""
    steps = np.arange(int(6.25 * samples) + 1) / samples
    turns = np.arange(0.25, steps[-1], 0.5)
    both = np.union1d(steps, turns)
    u = amplitude * np.sin(2.0 * np.pi * both)
    force = np.asarray(law.force(u))
    at = np.searchsorted(both, steps)
    rng = np.random.default_rng(seed)
    u, force = u[at], force[at]
    return ms.Record(
        u + noise / 3.0 * amplitude * rng.standard_normal(u.size),
        force + noise * force.max() * rng.standard_normal(u.size),
        sample_rate=samples,
    )


# -- the convex problem ---------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(5))
def test_minimum_is_that_of_scipy(seed: int) -> None:
    """Lawson and Hanson's method on rows, with coefficients of both signs as two columns."""
    rng = np.random.default_rng(seed)
    rows, b = rng.normal(size=(30, 8)), rng.normal(size=30)
    free = np.arange(8) >= 6
    g = minimum(cone_of(rows.T @ rows, free), rows.T @ b)
    wanted, _ = nnls(np.hstack((rows, -rows[:, 6:])), b)
    np.testing.assert_allclose(g[:6], wanted[:6], atol=1e-7)
    np.testing.assert_allclose(g[6:], wanted[6:8] - wanted[8:], atol=1e-7)


@pytest.mark.parametrize("seed", range(5))
def test_path_ends_where_a_general_method_does(seed: int) -> None:
    """The least c.g with a rise of 3 over the minimum, by sequential quadratic programming."""
    rng = np.random.default_rng(seed)
    rows, b, c = rng.normal(size=(20, 6)), rng.normal(size=20), rng.uniform(size=6)
    gram, h = rows.T @ rows, rows.T @ b
    cone = cone_of(gram, np.zeros(6, dtype=bool))
    g = minimum(cone, h)
    value, rise = Path(cone, h, g, c).until(level=3.0)
    least = g @ gram @ g - 2.0 * h @ g
    found = minimize(
        lambda x: c @ x,
        g + 0.01,
        method="SLSQP",
        bounds=[(0.0, None)] * 6,
        constraints={"type": "ineq", "fun": lambda x: least + 3.0 - x @ gram @ x + 2.0 * h @ x},
        options={"ftol": 1e-12, "maxiter": 500},
    )
    assert value == pytest.approx(float(found.fun), abs=1e-5)
    if value > 0.0:
        assert rise == pytest.approx(3.0, rel=1e-6)
        # The way back: the rise at this value is the level again.
        assert Path(cone, h, g, c).until(value=value)[1] == pytest.approx(3.0, rel=1e-6)


# -- columns of stop elements ---------------------------------------------------------------------


@pytest.mark.parametrize(("samples", "is_even"), [(96.0, True), (96.37, True), (96.37, False)])
def test_columns_are_means_of_explicit_stop_elements(samples: float, is_even: bool) -> None:
    """Each stop element stepped along a fine cycle, averaged over the phases of a bin.

    The phases of a few samples are known one by one; those of many are even over the bin.
    """
    folded = fold(record(JOINT, 1e-6, samples, 1e-7))
    if is_even:
        folded = replace(folded, samples=np.zeros((3, 0)))
    rows = DesignRows(folded, 0)
    y = np.array([2e-8, 1.7e-7, 4.1e-7, 8e-7, 3e-6])
    fine = 40_000
    angle = 2.0 * np.pi * np.arange(fine) / fine
    u = folded.displacement(angle)
    u = u - 0.5 * (u.max() + u.min())
    state, explicit = np.zeros(y.size), np.empty((fine, y.size))
    for turn in range(2):
        for i in range(fine):
            state = np.clip(state + (u[i] - u[i - 1] if turn or i else 0.0), -y, y)
            explicit[i] = state
    sums = np.vstack((np.zeros(y.size), np.cumsum(np.vstack((explicit, explicit)), axis=0)))
    width = math.sqrt(3.0) * folded.spread
    low, high = ((folded.phase + way * width) * fine / (2.0 * np.pi) for way in (-1.0, 1.0))
    first = np.round(low).astype(int) % fine
    count = np.maximum(np.round(high - low).astype(int), 1)
    wanted = (sums[first + count] - sums[first]) / count[:, None]
    if not is_even:
        phase, column = folded.samples[0], folded.samples[1].astype(int)
        at = np.round(phase * fine / (2.0 * np.pi)).astype(int) % fine
        wanted = np.array([explicit[at[column == i]].mean(axis=0) for i in range(len(wanted))])
    # A slider that has not slipped has an offset of its own, as each record has.
    away = rows.columns(y) - wanted
    away -= away.mean(axis=0)
    assert np.abs(away).max() < 2e-4 * 1e-6


def test_a_load_that_varies_is_that_of_memory_diagrams() -> None:
    """T of 3000 sliders with shifted thresholds against the exact response of the interface."""
    ripple, phase = 0.3, 0.7
    joint = JOINT
    high = joint.at(normal_load=joint.normal_load * (1.0 + ripple))
    edges = np.append(0.0, np.geomspace(1e-10, 4e-6, 3001))
    force = np.asarray(high.backbone(edges))
    slope = np.append(np.diff(force) / np.diff(edges), 0.0)
    y, k = edges[1:], slope[:-1] - slope[1:]
    folded = fold(record(joint, 6e-7, 400.0, 1e-7))
    load = joint.normal_load
    terms = ripple * load * np.array([math.cos(phase), math.sin(phase)])
    folded = replace(folded, normal_load=load, load_terms=terms)
    rows = DesignRows(folded, 0)
    assert rows.loads is not None
    shift, middle = (
        -np.interp(joint.friction_coefficient * (high.normal_load - loads), force, edges)
        for loads in (rows.loads, rows.middle_loads)
    )
    found = rows.varying_columns(y, shift, middle) @ k
    angle = 2.0 * np.pi * np.arange(8001) / 2000
    at = np.mod(folded.phase[0] + angle, 2.0 * np.pi)
    course = load + load_basis(at, 2) @ terms
    ramp = np.linspace(0.0, 1.0, 400)
    u = folded.displacement(at) - folded.motion.coefficients[0]
    wanted = np.asarray(
        joint.coupled_force(
            np.concatenate((ramp * u[0], u)),
            normal_load=np.concatenate((load + ramp * (course[0] - load), course)),
        )
    )[400:]
    wanted = np.interp(folded.phase - folded.phase[0], angle[:2001], wanted[6000:])
    away = found - wanted
    assert np.abs(away).max() < 1e-3 * joint.force_limit


# -- what the fit finds ---------------------------------------------------------------------------


def test_a_density_comes_back() -> None:
    """With little noise, energies from half the amplitude on to 1e-3 and forces to 3e-4."""
    fit = FreeForm([DesignRows(fold(record(JOINT, 1e-6, noise=1e-4)), 0)], [None])
    for a in (5e-7, 8e-7, 1e-6):
        energy = float(fit.k @ (4.0 * fit.y * np.maximum(a - fit.y, 0.0)))
        assert energy == pytest.approx(float(JOINT.dissipated_energy(a)), rel=1e-3)
        force = float(fit.backbone(np.array([a]))[0])
        assert force == pytest.approx(float(JOINT.backbone(a)), rel=3e-4)
    assert 0.7 < fit.chi_squared / fit.freedom < 1.4


def test_lower_loads_are_tails() -> None:
    """Shifts of two lower loads are kappa times the change of separation."""
    loads = [2000.0, 1000.0, 400.0]
    rows = [
        DesignRows(fold(record(JOINT.at(normal_load=load), a, seed=7 * n + m)), n)
        for n, load in enumerate(loads)
        for m, a in enumerate((4e-7, 1e-6))
    ]
    fit = FreeForm(rows, loads)
    high = JOINT.at(normal_load=2000.0)
    for load, shift in zip(loads[1:], fit.shifts[1:], strict=True):
        gap = JOINT.at(normal_load=load).separation - high.separation
        assert shift == pytest.approx(-JOINT.slip_per_indentation * gap, rel=5e-3)
    assert fit.chi_squared / fit.freedom < 1.2


def test_backbone_of_sliders_is_their_sum() -> None:
    rng = np.random.default_rng(3)
    y, k, u = rng.uniform(size=20), rng.uniform(size=20), np.linspace(0.0, 1.5, 31)
    np.testing.assert_allclose(backbone_of(y, k, u), np.minimum(u[:, None], y) @ k, rtol=1e-12)


def test_a_load_that_is_constant_has_no_course() -> None:
    """Noise of the load is no course; a ripple of 1 % is, with its size and phase."""
    made = record(JOINT, 1e-6)
    rng = np.random.default_rng(5)
    turn = 2.0 * np.pi * np.arange(made.displacement.size) / 128.0
    noise = 5.0 * rng.standard_normal(turn.size)
    still = fold(replace(made, normal_load=2000.0 + noise))
    assert still.load_terms.size == 0
    moving: Folded = fold(replace(made, normal_load=2000.0 + 20.0 * np.sin(turn) + noise))
    assert np.linalg.norm(moving.load_terms) == pytest.approx(20.0, rel=0.1)
