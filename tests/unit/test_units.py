"""Units: those that are read without pint are the same ones."""

from __future__ import annotations

import pytest

import microslip as ms
from microslip._core import units


@pytest.mark.parametrize("prefix", list(units._PREFIX))
@pytest.mark.parametrize("base", list(units._SIMPLE))
def test_common_units_are_what_pint_makes_of_them(
    prefix: str, base: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    texts = [f"{prefix}{base}{end}" for end in ("", "^2", "/um", "/mm^2", "^3/s")]
    quick = [units._simple(text) for text in texts]
    assert None not in quick
    monkeypatch.setattr(units, "_simple", lambda unit: None)
    assert quick == [units._parse.__wrapped__(text) for text in texts]


def test_units_in_python() -> None:
    assert ms.units("69 GPa") == 69e9
    assert ms.units("100 1/mm^2") == 1e8
    assert ms.units("-0.3 um") == -3e-7
