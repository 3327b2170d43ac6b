"""Messages about wrong input: what was wrong, what was given, what is accepted, how to write it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from studies import GAUSSIAN, LINE, LOADS, MATERIAL, wrong

import microslip as ms
from microslip._core.errors import InputError

JOINT = ms.Interface.examples()[0].at(normal_load=2000.0)
MESSAGES: dict[str, Callable[[], object]] = {
    "separation must be a finite number in m, got '5 um', for example separation=1": lambda: (
        JOINT.at(separation="5 um")
    ),
    "normal_load must be above zero [N], got -1": lambda: JOINT.at(normal_load=-1.0),
    "normal_load must be one number or one for each of the 2 samples, got shape (3,)": lambda: (
        JOINT.coupled_response(displacement=[1e-7, 2e-7], normal_load=[1.0, 2.0, 3.0])
    ),
    "exactly one of normal_load=... [N] or separation=... [m] must be given, got both": lambda: (
        JOINT.coupled_response(displacement=[1e-7], normal_load=1.0, separation=0.0)
    ),
    "displacement must be finite: 1 of 2 values are not, the first is nan at index 1": lambda: (
        JOINT.backbone([1e-7, np.nan])
    ),
    "largest_amplitude must be above the smallest, 1e-05 m, got 1e-06 m": lambda: JOINT.to_iwan(
        20, smallest_amplitude=1e-5, largest_amplitude=1e-6
    ),
    "commit needs a trial; call try_(displacement) first": lambda: JOINT.start().commit(),
    "poisson_ratio must be in (-1, 0.5], got 0.7": lambda: ms.Material(69e9, 0.7),
    'units needs a number with its unit, such as "69 GPa", got "3 frob" (no such unit)': lambda: (
        ms.units("3 frob")
    ),
    "cutoff must be above zero": lambda: ms.Scan(np.eye(9), 1e-6).condition(cutoff=0.0),
    "sample_rate must give at least 16 samples a cycle, 160 Hz at 10 Hz, got 100 Hz": lambda: (
        ms.VirtualTribometer(JOINT, sample_rate=100).record(amplitude=5e-6, frequency=10.0)
    ),
    "stiffness must be 3 x 3, as the mass matrix is, got 2 x 2": lambda: ms.Structure(
        np.eye(3), np.eye(2)
    ),
}


@pytest.mark.parametrize("message", MESSAGES)
def test_wrong_arguments(message: str) -> None:
    with pytest.raises(InputError) as caught:
        MESSAGES[message]()
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (("[joint]", "[Joint]"), 'Joint: unknown key; did you mean "joint"?'),
        ((MATERIAL, ""), "surface.materials, item 1: wanted a metal of the table (see"),
        (("poisson_ratio = 0.33", "rigid = true"), "material.al.young_modulus: unknown key; a"),
        (('"69 GPa"', "true"), 'wanted a pressure such as "69 GPa", got true'),
        (('"69 GPa"', '"69 N"'), 'such as "69 GPa", got "69 N" (a force)'),
        ((LOADS, '"2 KN"'), 'got "2 KN" (unknown unit "KN"; did you mean "kN"?)'),
        ((LOADS, "2"), 'wanted a force such as "2 kN", got 2 (a number without a unit)'),
        ((LOADS, '"-2 N"'), "joint.normal_load: wanted a positive force such as"),
        (("[joint]", "joint:"), "line 16, column 6: not TOML: "),
        (('["csv"]', '["cvs"]'), 'output.formats, item 1: wanted "netcdf"'),
        (('["al", "al"]', '["al"]'), 'wanted 2 items such as ["steel", "steel"], got 1'),
        ((LINE, 'history = { file = "x.csv", colunm = "x" }'), 'did you mean "column"?'),
        ((GAUSSIAN, '{ kind = "gaussian" }'), "heights.std: missing; write for example std = "),
        (("schema = 1", ""), "schema: missing"),
    ],
)
def test_wrong_studies(edit: tuple[str, str], message: str) -> None:
    assert message in wrong(*edit)


def test_an_error_names_its_argument() -> None:
    error = InputError('`cutoff` is short; write `valid=("-1 mm", "1 mm")`')
    assert (error.argument, error.statement[:9]) == ("cutoff", "is short;")
    assert str(error.within("file: ")) == 'file: cutoff is short; write valid=("-1 mm", "1 mm")'
    assert error.within("file: ").argument is None
