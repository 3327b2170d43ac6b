"""Heights of one's own on surfaces and in the second step of an identification."""

from __future__ import annotations

import numpy as np
import pytest
from own_laws import Ramp

import microslip as ms
from microslip.identification.models.interface import InterfaceModel, Materials


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
