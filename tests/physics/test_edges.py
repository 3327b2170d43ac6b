"""Patches at the edge of a lap: a plate in tension on nodes of a drawn face, beside fine chains."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from scipy.linalg import solveh_banded

import microslip as ms

LENGTH, WIDTH, LARGEST, FRICTION = 30e-3, 25e-3, 60e6, 0.3
STIFFNESS = 200e9 * WIDTH * 6.35e-3  # E A of the plate [N]
STEEL = ms.Material(200e9, 0.3, hardness=2.4e9)
FACES = {"ground": (0.4e-6, 0.1), "milled": (1.6e-6, 0.15)}
SHARES = np.geomspace(0.05, 0.7, 6)
"""Forces over that of gross slip [-]."""


def losses(face: str, power: float, edges: np.ndarray, share: float) -> np.ndarray:
    """Energies of a cycle [J] of patches between edges [m] under a pressure ~ x^power.

    The plate is pulled at x = 0; each patch moves as its middle and was tightened by its own
    pressure.
    """
    rms, slope = FACES[face]
    law = ms.DrawnFace(ms.MaterialPair(STEEL, STEEL), rms, slope, 1e-4, 1e4)
    x = edges / LENGTH
    loads = LARGEST * LENGTH * WIDTH * np.diff(x ** (power + 1.0)) / (power + 1.0)
    field = ms.JointField(law, FRICTION, areas=WIDTH * np.diff(edges), loads=loads)
    spring = STIFFNESS / np.diff(0.5 * (edges[1:] + edges[:-1]))
    u = np.zeros(loads.size)
    for _ in range(200):
        force, stiffness = field.start().try_(u)
        pull = spring * np.diff(u)
        rest = force - np.append(pull, 0.0) + np.append(0.0, pull)
        rest[0] -= share * FRICTION * loads.sum()
        band = np.zeros((2, u.size))
        band[1] = stiffness + np.append(spring, 1e-9 * spring[0]) + np.append(0.0, spring)
        band[0, 1:] = -spring
        step = solveh_banded(band, -rest)
        u = np.maximum(u + step, 0.0)
        if np.abs(step).max() < 1e-9 * u.max():
            return np.asarray(field.dissipated_energy(u))
    raise AssertionError("the plate is not in balance")


def graded(count: int) -> np.ndarray:
    """Return edges at cosines of equal angles [m]: short patches at both ends."""
    return 0.5 * LENGTH * (1.0 - np.cos(np.pi * np.arange(count + 1) / count))


@functools.cache
def energies(face: str, power: float, count: int) -> np.ndarray:
    edges = np.linspace(0.0, LENGTH, count + 1)
    return np.array([losses(face, power, edges, share).sum() for share in SHARES])


@pytest.mark.parametrize("face", FACES)
@pytest.mark.parametrize("power", [0.0, 1.0, 2.0])
def test_graded_patches_resolve_any_edge(face: str, power: float) -> None:
    """15 patches within 3 % and 30 within 0.6 % of a fine chain, of second order or better."""
    fine = energies(face, power, 600 if power else 1500)
    worst = []
    for count in (15, 30):
        found = [losses(face, power, graded(count), share).sum() for share in SHARES]
        worst.append(np.abs(found / fine - 1.0).max())
    assert worst[0] < 0.03
    assert worst[1] < 0.006


@pytest.mark.parametrize("face", FACES)
@pytest.mark.parametrize("power", [1.0, 2.0])
def test_fifteen_patches_resolve_a_pressure_that_falls_to_zero(face: str, power: float) -> None:
    """Within 5 %, as slip begins at zero load; exponents are between 2.4 and 3.7."""
    fine = energies(face, power, 600)
    assert energies(face, power, 15) == pytest.approx(fine, rel=0.05)
    exponents = np.diff(np.log(fine)) / np.diff(np.log(SHARES))
    assert (np.diff(exponents) < 0.0).all()
    assert 2.35 < exponents[-1] < 2.7 < 3.2 < exponents[0] < 3.8


@pytest.mark.parametrize("face", FACES)
def test_patches_that_lose_most_are_halved_twice_where_the_pressure_is_even(face: str) -> None:
    """Within 10 % by at most 30 patches, where 15 alike lose a third to all of the truth."""
    fine, even = energies(face, 0.0, 1500), energies(face, 0.0, 15)
    for share, wanted, coarse in zip(SHARES, fine, even, strict=True):
        edges = np.linspace(0.0, LENGTH, 16)
        for _ in range(2):
            lost = losses(face, 0.0, edges, share)
            order = np.argsort(-lost)
            most = order[: np.searchsorted(np.cumsum(lost[order]), 0.8 * lost.sum()) + 1]
            edges = np.sort(np.append(edges, 0.5 * (edges[most] + edges[most + 1])))
        assert edges.size - 1 <= 30
        found = losses(face, 0.0, edges, share).sum()
        assert found == pytest.approx(wanted, rel=0.1)
        assert abs(found - wanted) <= max(abs(coarse - wanted), 0.05 * wanted)
