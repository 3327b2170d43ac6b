"""The benchmark of docs/timings.md compares like with like."""

from __future__ import annotations

import pytest
import run as bench

import microslip as ms


def test_the_benchmark_compares_like_with_like() -> None:
    """The three ways to the same forces give the same forces."""
    joint = ms.Interface(bench.make_surface(), friction_coefficient=0.55, normal_load=2000.0)
    for history in (bench.sine(300, 50), bench.gaussian_noise(300), bench.turning_noise(300)):
        forces = joint.force(history)
        assert bench.difference(bench.naive_force(joint, history), forces, joint) < 1e-14
    few = bench.turning_noise(20)
    population = bench.explicit_population(joint)
    assert bench.difference(population.force(few), joint.force(few), joint) < 1e-5
    assert bench.turning_share(bench.turning_noise(1000)) == pytest.approx(1.0, abs=2e-3)
    assert bench.turning_share(bench.sine(1000, 100)) == pytest.approx(0.02, abs=1e-3)
