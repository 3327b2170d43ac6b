"""Units: those that are read without pint are the same ones."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import microslip as ms
from microslip._core import units
from microslip._core.units import CLAMPING, FORCE, QuantityError, interval_digits, to_si


def test_common_units_are_what_pint_makes_of_them(monkeypatch: pytest.MonkeyPatch) -> None:
    texts = [
        f"{prefix}{base}{end}"
        for prefix in units._PREFIX
        for base in units._SIMPLE
        for end in ("", "^2", "/um", "/mm^2", "^3/s")
    ]
    quick = [units._simple(text) for text in texts]
    assert None not in quick
    monkeypatch.setattr(units, "_simple", lambda unit: None)
    assert quick == [units._parse.__wrapped__(text) for text in texts]


def test_units_in_python() -> None:
    assert ms.units("69 GPa") == 69e9
    assert ms.units("100 1/mm^2") == 1e8
    assert ms.units("-0.3 um") == -3e-7


def test_a_load_by_the_torque_of_bolts(tmp_path: Path) -> None:
    """N M/(K d) by hand, of commands and records alone; what is missing is said in one line."""
    for text, load in (("20 N m on 4 M8, K 0.2", 5e4), ("30 Nm on M10, K=.15", 2e4)):
        assert to_si(text, CLAMPING, "500 N") == pytest.approx(load, rel=1e-12)
        with pytest.raises(QuantityError, match="wanted a force"):
            to_si(text, FORCE, "500 N")
    for text in ("20 N m", "20 N m on M8", "20 N m on 4 M8, K 0.0", "20 N m on bolts, K 0.2"):
        with pytest.raises(QuantityError, match="a torque needs its bolts and their nut factor K"):
            to_si(text, CLAMPING, "500 N")
    with pytest.raises(QuantityError, match="wanted a torque"):
        to_si("20 mm on M8, K 0.2", CLAMPING, "500 N")
    (tmp_path / "cycles.csv").write_text(
        "displacement [um],force [N]\n" + "".join(f"{i % 7},{i % 5}\n" for i in range(40))
    )
    record = ms.Record.read(tmp_path / "cycles.csv", normal_load="20 N m on M8, K 0.2")
    assert record.normal_load == pytest.approx(12500.0)


@pytest.mark.parametrize(
    ("low", "high", "value", "digits"),
    [(3.28e-7, 3.32e-7, 3.3e-7, 3), (0.5499, 0.5501, 0.55, 5), (1.0, 2.0, 1.5, 3),
     (1.0, math.inf, 2.0, 4), (None, 1.0, 0.5, 4), (-1.0, 1.0, 0.0, 4)],
)  # fmt: skip
def test_an_estimate_and_its_interval_have_the_same_digits(low, high, value, digits) -> None:
    assert interval_digits(low, high, value) == digits
