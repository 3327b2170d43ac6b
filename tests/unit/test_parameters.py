"""What a class says of its parameters is what it checks, and what others may read of it."""

from __future__ import annotations

import pytest
from own_laws import HEIGHTS, LAWS

from microslip._core.parameters import parameters_of
from microslip.contact import NORMAL_LAWS


@pytest.mark.parametrize("kind", [*LAWS, *NORMAL_LAWS, *HEIGHTS])
def test_every_parameter_is_said_in_full(kind: type) -> None:
    for said in parameters_of(kind):
        assert said.symbol
        assert said.meaning
