"""What a class says of its parameters is what it checks, and what others may read of it."""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest
from own_laws import HEIGHTS, LAWS

import microslip as ms
from microslip._core.parameters import (
    Number,
    Parametric,
    key_of,
    parameter,
    parameters_of,
    rescaled,
    values_of,
)
from microslip.contact import NORMAL_LAWS


@dataclass(frozen=True)
class Spring(Parametric):
    """A stand-in for a law, one parameter of each kind."""

    stiffness: float = field(metadata=parameter("k", "N/m", "stiffness at rest", above=0.0))
    share: float = field(default=0.5, metadata=parameter("s", least=0.0, below=1.0))
    power: float = field(default=1.0, metadata=parameter("n", least=1.0, most=9.0))
    steps: tuple[float, ...] = field(
        default=(1.0,), metadata=parameter("d_i", "m", above=0.0, many=True)
    )


def test_a_class_lists_its_parameters() -> None:
    stiffness, share, power, steps = parameters_of(Spring)
    assert (stiffness.name, stiffness.symbol, stiffness.unit) == ("stiffness", "k", "N/m")
    assert stiffness.is_positive
    assert stiffness.required
    assert share.default == 0.5
    assert (share.least, share.below) == (0.0, 1.0)
    assert (power.least, power.most) == (1.0, 9.0)
    assert steps.many
    assert steps.dimension == (0, 1)
    assert parameters_of(int) == ()


@pytest.mark.parametrize("kind", [*LAWS, *NORMAL_LAWS, *HEIGHTS])
def test_every_parameter_is_said_in_full(kind: type) -> None:
    for said in parameters_of(kind):
        assert said.symbol
        assert said.meaning
        assert said.unit == "" or said.dimension is not None


def test_names_of_classes() -> None:
    names = [key_of(kind) for kind in (ms.Jenkins, ms.SegalmanIwan, Spring)]
    assert names == ["jenkins", "segalman", "spring"]


def test_units_say_how_a_value_scales() -> None:
    units = ("N/m", "N", "", "1/m^2", "N*m^-1.5", "Pa", "m^2", "N/m^2")
    dimensions = [(1, -1), (1, 0), (0, 0), (0, -2), None, None, (0, 2), (1, -2)]
    assert [Number("", unit=unit).dimension for unit in units] == dimensions
    cell = ms.Jenkins(stiffness=4.0, force_limit=6.0)
    assert rescaled(ms.Jenkins, values_of(cell), 2.0, 10.0) == {
        "stiffness": pytest.approx(0.8, rel=1e-15),
        "force_limit": 12.0,
    }
