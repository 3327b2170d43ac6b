"""The table of docs/equations.md: each equation is there once, and each name beside it exists."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from cases import folded

import microslip as ms

PAGE = (Path(__file__).parents[2] / "docs" / "equations.md").read_text(encoding="utf-8")
CLASSES: dict[str, type] = {
    "asperity": ms.Asperity,
    "fields": ms.AsperityFields,
    "joint": ms.Interface,
    "surface": ms.NormalLaw,
}
ROWS = [
    [cell.strip() for cell in line.strip("|").split("|")]
    for line in PAGE.splitlines()
    if line.startswith(("| (19.", "| Fig", "| section"))
]
NAMES = sorted({name for row in ROWS for name in re.findall(r"`([^`]+)`", row[2])})


def test_every_equation_has_one_row() -> None:
    numbers = [int(n) for row in ROWS for n in re.findall(r"\(19\.(\d+)\)", row[0])]
    assert numbers == list(range(1, 31))


@folded("row", {row[0]: row for row in ROWS}, whole=True)
def test_every_row_names_something(row: list[str]) -> None:
    assert len(row) == 3
    assert re.search(r"`\w+\.\w+`", row[2])


@folded("name", {name: name for name in NAMES}, whole=True)
def test_names_are_there(name: str) -> None:
    owner, _, member = name.partition(".")
    item: Any = CLASSES[owner] if owner in CLASSES else getattr(ms, owner)
    known = hasattr(item, member) or member in getattr(item, "__dataclass_fields__", {})
    assert known, name
    assert not member.startswith("_")
