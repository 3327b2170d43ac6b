"""Work done on a joint is what it stores and what it dissipates."""

from itertools import pairwise

import numpy as np
import pytest
from usual import SURFACE

import microslip as ms

JOINT = ms.Interface(SURFACE, 0.5, normal_load=100.0)
LAWS = {
    "interface": JOINT,
    "cells": JOINT.to_iwan(50),
    "slider": ms.Jenkins(1e7, 10.0),
    "segalman": ms.SegalmanIwan.examples()[0],
    "sphere": ms.Asperity.examples()[0],
}


def noise(law: ms.BackboneLaw, size: int) -> np.ndarray:
    reach = law.force_limit / law.tangential_stiffness
    return np.cumsum(np.random.default_rng(0).normal(size=size)) * 0.3 * reach


@pytest.mark.parametrize("name", LAWS)
def test_stored_and_dissipated_energy_are_the_work(name: str) -> None:
    law, parts = LAWS[name], 400
    state, work, force, last = law.start(), 0.0, 0.0, 0.0
    for end in noise(law, 60):
        path = np.linspace(last, end, parts + 1)
        forces = np.append(force, state.advance(path[1:]))
        work += float((0.5 * (forces[1:] + forces[:-1]) * np.diff(path)).sum())
        last, force = float(end), float(forces[-1])
        stored = state.stored_energy
        assert stored >= 0.0
        # Trapezoids miss the curvature of the branches by the square of their width.
        assert stored + state.dissipated_energy == pytest.approx(work, rel=1e-5)


@pytest.mark.parametrize("name", ["interface", "sphere"])
def test_energies_of_both_memories_agree(name: str) -> None:
    law = LAWS[name]
    held, varying = law.start(), law.start()
    for x in noise(law, 60):
        held.try_(x)
        held.commit()
        varying.try_(x, separation=law.separation)
        varying.commit()
        assert varying.stored_energy == pytest.approx(held.stored_energy, rel=1e-11)
        assert varying.dissipated_energy == pytest.approx(held.dissipated_energy, rel=1e-11)


def test_energies_of_a_field_are_those_of_its_nodes() -> None:
    """Under varying separations, and with the work done at constant ones."""
    surface, rng = SURFACE, np.random.default_rng(45)
    field = ms.JointField(surface, 0.5, areas=[1e-5, 3e-5, 1e-4], loads=[50.0, 100.0, 900.0])
    states = [
        ms.JointField(surface, 0.5, areas=[area], loads=[load]).start()
        for area, load in ((1e-5, 50.0), (3e-5, 100.0), (1e-4, 900.0))
    ]
    state = field.start()
    for _ in range(60):
        u, d = rng.normal(0.0, 1e-7, 3), field.separations + rng.normal(0.0, 1e-7, 3)
        state.try_(u, separations=d)
        state.commit()
        for i, one in enumerate(states):
            one.try_(u[i : i + 1], separations=d[i : i + 1])
            one.commit()
    np.testing.assert_allclose(
        state.stored_energy, [one.stored_energy[0] for one in states], rtol=1e-12
    )
    state, work, force = field.start(energies=True), np.zeros(3), np.zeros(3)
    path = np.concatenate([np.linspace(0.0, 3e-7, 2000), np.linspace(3e-7, -2e-7, 2000)])
    for before, x in pairwise(path):
        new, _ = state.try_(np.full(3, x))
        state.commit()
        work += 0.5 * (force + new) * (x - before)
        force = new
    np.testing.assert_allclose(state.stored_energy + state.dissipated_energy, work, rtol=1e-6)


@pytest.mark.parametrize("name", LAWS)
def test_energy_of_a_settled_cycle_is_the_rise_of_a_state(name: str) -> None:
    law = LAWS[name]
    t = np.arange(64) * 2 * np.pi / 64
    x = (0.3 + 1.3 * np.cos(t) + 0.6 * np.sin(3 * t)) * law.force_limit / law.tangential_stiffness
    state = law.start()
    state.advance(np.tile(x, 2))
    before = state.dissipated_energy
    state.advance(x)
    rise = state.dissipated_energy - before
    assert law.periodic(x).dissipated_energy == pytest.approx(rise, rel=1e-10)
