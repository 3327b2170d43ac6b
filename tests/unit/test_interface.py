"""Interfaces: how they are made, what is shared, and the values that follow at once."""

from __future__ import annotations

import math

import numpy as np
import pytest
from own_laws import LAWS

import microslip as ms
from microslip.contact import NORMAL_LAWS

AL = ms.Material(69e9, 0.33)
PAIR = ms.MaterialPair(AL, AL)
S = 5e-7
SURFACE = ms.GreenwoodWilliamson(PAIR, ms.Gaussian(S), radius=1e-3, density=1e8, area=2e-4)
D = np.linspace(0.0, 1e-6, 11)
TABLE = ms.TabulatedNormalLaw(PAIR, D, 1e3 * (1.0 - D / 1e-6) ** 2)
SPHERE = ms.SphereOnFlat(PAIR, 5e-3)
POPULATION = ms.AsperityPopulation(PAIR, [0.0, 1e-7, 3e-7], 1e-3)


# -- made by a load or by a separation -------------------------------------------------------------


def test_values_at_rest() -> None:
    for joint in ms.Interface.examples():
        for name in ("dissipated_energy", "energy_ratio", "loss_factor", "damping_ratio"):
            value = getattr(joint, name)(0.0)
            assert value == 0.0
            assert math.copysign(1.0, getattr(joint, name)(-0.0)) == 1.0, name
        assert joint.secant_stiffness(0.0) == pytest.approx(
            joint.tangential_stiffness, rel=1e-12, abs=0
        )
        assert joint.force(0.0) == joint.displacement(0.0) == 0.0
        # Cubic microslip, but for a table of straight runs, which sticks.
        assert joint.dissipation_exponent(0.0) == 3.0


# -- what is refused -------------------------------------------------------------------------------


@pytest.mark.parametrize("surface", [SPHERE, POPULATION, SURFACE, TABLE])
@pytest.mark.parametrize("load", [1e-3, 1e-9, 1e-15, 1e-25, 1e-39, 1e-100, 1e-300, 5e-324])
def test_light_joints_hold_together(surface: ms.NormalLaw, load: float) -> None:
    """The load that was asked for and the one that its backbone is made of are the same."""
    try:
        joint = ms.Interface(surface, 0.55, load)
    except ms.InputError as error:
        refused = str(error)
    else:
        refused = ""
    if refused:
        assert "load must be" in refused
        return
    assert surface.load(joint.separation) == pytest.approx(load, rel=1e-9, abs=0)
    slip = 10.0 * joint.slip_per_indentation * 1e-6
    assert joint.backbone(slip) == pytest.approx(joint.force_limit, rel=1e-9, abs=0)
    assert joint.tangential_stiffness > 0.0
    loop = joint.loop(slip)
    assert loop.force_amplitude == pytest.approx(joint.force_limit, rel=1e-9, abs=0)


# -- laws of one's own -----------------------------------------------------------------------------


@pytest.mark.parametrize("law", LAWS)
def test_examples_reach_every_surface(law: type[ms.BackboneLaw]) -> None:
    if law is ms.Interface:
        kinds = {type(joint.surface) for joint in law.examples()}  # type: ignore[attr-defined]
        assert kinds == set(NORMAL_LAWS)
