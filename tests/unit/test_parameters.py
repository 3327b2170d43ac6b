"""What a class says of its parameters is what it checks, and what others may read of it."""

from __future__ import annotations

import pytest
from own_laws import HEIGHTS, LAWS

import microslip as ms
from microslip._core.parameters import (
    Number,
    parameters_of,
    rescaled,
    values_of,
)
from microslip.contact import NORMAL_LAWS


@pytest.mark.parametrize("kind", [*LAWS, *NORMAL_LAWS, *HEIGHTS])
def test_every_parameter_is_said_in_full(kind: type) -> None:
    for said in parameters_of(kind):
        assert said.symbol
        assert said.meaning
        assert said.unit == "" or said.dimension is not None


def test_units_say_how_a_value_scales() -> None:
    units = ("N/m", "N", "", "1/m^2", "N*m^-1.5", "Pa", "m^2", "N/m^2")
    dimensions = [(1, -1), (1, 0), (0, 0), (0, -2), None, None, (0, 2), (1, -2)]
    assert [Number("", unit=unit).dimension for unit in units] == dimensions
    cell = ms.Jenkins(stiffness=4.0, force_limit=6.0)
    assert rescaled(ms.Jenkins, values_of(cell), 2.0, 10.0) == {
        "stiffness": pytest.approx(0.8, rel=1e-15),
        "force_limit": 12.0,
    }
