"""Amplitudes at and beyond their limits, and the argument that a message names.

Wrong kinds of input are given to every public callable by tests/attack/wrong_kinds.py.
"""

from __future__ import annotations

import numpy as np
import pytest
from cases import refusal
from usual import PAIR, SURFACE

import microslip as ms
from microslip._core.errors import InputError

POPULATION = ms.AsperityPopulation(PAIR, [0.0, 1e-7, 3e-7], 1e-3)
D = np.linspace(0.0, 1e-6, 11)
TABLE = ms.TabulatedNormalLaw(PAIR, D, 1e3 * (1.0 - D / 1e-6) ** 2)
JOINTS = {
    "gaussian": ms.Interface(SURFACE, 0.55, 2000.0),
    "population": ms.Interface(POPULATION, 0.55, 1.0),
    "sphere": ms.Interface(ms.SphereOnFlat(PAIR, 5e-3), 0.55, 10.0),
    "table": ms.Interface(TABLE, 0.55, 500.0),
}
MEASURES = (
    "dissipated_energy",
    "energy_ratio",
    "loss_factor",
    "damping_ratio",
    "secant_stiffness",
    "dissipation_exponent",
)


@pytest.mark.parametrize("joint", JOINTS.values(), ids=JOINTS)
@pytest.mark.parametrize("factor", [1.0, 1.0 + 2**-52, 2.0, 1e300])
def test_force_at_or_beyond_the_limit(joint: ms.Interface, factor: float) -> None:
    limit = joint.force_limit
    force = factor * limit
    ending = (
        f" must be below the force limit {limit:.10g} N in magnitude (at the limit slip "
        f"is unlimited), got {force:.10g} N"
    )
    for sign in (1.0, -1.0):
        for value in (sign * force, [0.0, sign * force], [[sign * force]]):
            assert refusal(joint.backbone_displacement, value) == "force" + ending
        for record in (sign * force, [0.5 * limit, sign * force, 0.0]):
            assert refusal(joint.displacement, record) == "force" + ending
    for name in MEASURES:
        message = refusal(getattr(joint, name), force_amplitude=[0.0, force])
        assert message == "force_amplitude" + ending


def test_an_error_names_its_argument() -> None:
    error = InputError('`cutoff` is short; write `valid=("-1 mm", "1 mm")`')
    assert (error.argument, error.statement[:9]) == ("cutoff", "is short;")
    assert str(error.within("file: ")) == 'file: cutoff is short; write valid=("-1 mm", "1 mm")'
    assert error.within("file: ").argument is None
