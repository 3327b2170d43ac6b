"""Energy dissipated along a history: against sliders one by one, exactly, and by its laws."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
from cases import invertible_laws, reach_of, records
from hypothesis import given

import microslip as ms
from microslip.friction.energies import dissipated_along

YIELDS = [Fraction(k, 8) for k in (1, 2, 3, 5, 8, 13, 21)]
STIFFNESSES = [Fraction(7 - k, 4) for k in range(7)]


def polygon() -> ms.Iwan:
    k, y = (np.array([float(v) for v in values]) for values in (STIFFNESSES, YIELDS))
    return ms.Iwan(k, k * y)


def one_by_one(record: list[Fraction]) -> list[Fraction]:
    """The definition: each slider is dragged by what is beyond its yield displacement."""
    stretch, last, total = [Fraction(0)] * len(YIELDS), Fraction(0), Fraction(0)
    energies = []
    for x in record:
        for i, (k, y) in enumerate(zip(STIFFNESSES, YIELDS, strict=True)):
            moved = stretch[i] + x - last
            stretch[i] = min(max(moved, -y), y)
            total += k * y * abs(moved - stretch[i])
        last = x
        energies.append(total)
    return energies


@given(records(max_size=60))
def test_it_is_what_the_sliders_dissipate(record: Any) -> None:
    """In exact numbers: eighths are doubles, so nothing is rounded on the way in."""
    wanted = [float(e) for e in one_by_one([Fraction(x) for x in record.tolist()])]
    got = dissipated_along(polygon(), record, record)
    np.testing.assert_allclose(got, wanted, rtol=0.0, atol=1e-14 * max(wanted) + 1e-300)


@invertible_laws
def test_closed_cycles_dissipate_their_energy(law: ms.BackboneLaw) -> None:
    """First loading a quarter of it, to the other end a half, and then a whole in each cycle."""
    a = 1.7 * reach_of(law)
    record = a * np.array([1.0, -1.0, 1.0, -1.0, 1.0])
    cycle = law.dissipated_energy(a)
    got = dissipated_along(law, record, record)
    np.testing.assert_allclose(got, cycle * np.array([0.25, 0.75, 1.25, 1.75, 2.25]), rtol=1e-13)


@invertible_laws
def test_it_never_falls_and_has_no_sign(law: ms.BackboneLaw) -> None:
    moves = np.random.default_rng(5).standard_normal(2000)
    record = 0.3 * reach_of(law) * np.cumsum(moves - 0.02 * np.cumsum(moves) / 10.0)
    got = dissipated_along(law, record, record)
    assert np.diff(got, prepend=0.0).min() >= -1e-13 * got[-1]
    np.testing.assert_array_equal(dissipated_along(law, -record, -record), got)


@invertible_laws
def test_samples_on_the_way_change_nothing(law: ms.BackboneLaw) -> None:
    """A path is a path, however finely it is sampled."""
    record = reach_of(law) * np.array([0.7, -0.4, 0.2, -0.1, 0.9, -1.3, 2.0, 0.5, 0.6])
    fine = np.interp(np.linspace(0.0, 8.0, 801), np.arange(9.0), record)
    fine[::100] = record
    got = dissipated_along(law, record, record)
    np.testing.assert_allclose(
        dissipated_along(law, fine, fine)[::100], got, rtol=0.0, atol=1e-12 * got[-1]
    )


def test_a_force_record_says_where_loops_close() -> None:
    """Displacements that forces lead to are rounded; the loops they close are not."""
    joint = ms.Interface.examples()[0]
    forces = joint.force_limit * np.array([0.9, 0.2, 0.7, 0.2, 0.7, 0.2, 0.9, -0.9, 0.95])
    displacement = joint.displacement(forces)
    got = dissipated_along(joint, displacement, forces)
    inner = joint.dissipated_energy(0.5 * (displacement[2] - displacement[1]))
    np.testing.assert_allclose(np.diff(got)[2:4].sum(), inner, rtol=1e-9)
    np.testing.assert_allclose(np.diff(got)[3:5].sum(), inner, rtol=1e-9)
