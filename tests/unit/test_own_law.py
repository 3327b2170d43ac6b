"""A law and heights of one's own, one file each, in all that fits, guesses and compares."""

from __future__ import annotations

import numpy as np
import pytest
from own_laws import Hyperbola, Ramp

import microslip as ms
from microslip._core.parameters import parameters_of
from microslip.identification.models.interface import InterfaceModel, Materials

LAW = Hyperbola(stiffness=2e7, force_limit=300.0)
REACH = LAW.force_limit / LAW.stiffness
NAMES = [said.name for said in parameters_of(Hyperbola)]


def test_a_law_is_guessed_by_its_own_shape() -> None:
    loops = [LAW.loop(a * REACH, 400) for a in (1.0, 5.0)]
    guessed = Hyperbola.guess(loops)
    # Bins of a branch are as wide as they are, and samples of one are one place.
    assert guessed.stiffness == pytest.approx(LAW.stiffness, rel=0.05)
    assert guessed.force_limit == pytest.approx(LAW.force_limit, rel=0.05)


def test_heights_of_ones_own_stand_on_surfaces_and_in_fits() -> None:
    pair = ms.Interface.examples()[0].surface.pair
    surface = ms.GreenwoodWilliamson(pair, Ramp(2e-6), radius=1e-3, density=1e8, area=2e-4)
    joint = ms.Interface(surface, 0.5, normal_load=500.0)
    model = InterfaceModel.of_shape(Ramp(1e-3), [500.0])
    values = {
        "friction_coefficient": 0.5,
        "slip_scale": joint.slip_per_indentation * surface.heights.spread,
        "standardised_separation": joint.separation / surface.heights.spread,
    }
    again = model.build(values, 500.0, Materials(pair, 2e-4, 1e-3))
    assert again.surface.heights.highest == pytest.approx(2e-6, rel=1e-12)
    u = joint.force_limit / joint.tangential_stiffness * np.geomspace(1e-3, 30.0, 40)
    assert again.backbone(u) == pytest.approx(joint.backbone(u), rel=1e-9)
    assert model.curve(u, values, 500.0)[0] == pytest.approx(joint.backbone(u), rel=1e-9)
    guessed = ms.Interface.guess(
        joint.loop(5.0 * u[0] * 1e3), pair=pair, normal_load=500.0, heights=Ramp(1.0)
    )
    assert guessed.friction_coefficient == pytest.approx(0.5, rel=0.05)
    assert isinstance(guessed.surface.heights, Ramp)
