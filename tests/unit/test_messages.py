"""Messages about wrong input: what was wrong, what was given, what is accepted, how to write it."""

from __future__ import annotations

import pytest
from studies import GAUSSIAN, LINE, LOADS, MATERIAL, wrong

from microslip._core.errors import InputError


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
