"""Floor 8: the table of metals on the terminal."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TextIO

from microslip._core.units import engineering
from microslip.report.printer import Printer

if TYPE_CHECKING:
    from microslip.materials import Metal

_KEYS = {"young_modulus": "E", "poisson_ratio": "ν", "hardness": "hardness"}
# Document and year, without the place in it: "EN 1993-1-1:2005, 3.2.6".
_DOCUMENT = re.compile(r".*?(?::|, )(?:19|20)\d\d\b")


def as_dict(metal: Metal) -> dict[str, Any]:
    """What is known of a metal, in plain values."""
    values = {key: getattr(metal, key) for key in _KEYS}
    return {
        "description": metal.description,
        "aliases": list(metal.aliases),
        **values,
        "sources": dict(metal.sources),
    }


def show_all(metals: Sequence[Metal], stream: TextIO) -> None:
    """Print the whole table."""
    out = Printer(stream)
    documents = [_document(source) for metal in metals for source in metal.sources.values()]
    numbers = {document: n for n, document in enumerate(dict.fromkeys(documents), start=1)}
    out.table(
        "",
        ["metal", *_KEYS.values(), "sources", "description"],
        [
            [
                metal.name,
                *(_value(metal, key) for key in _KEYS),
                " ".join(dict.fromkeys(str(numbers[_document(s)]) for s in metal.sources.values())),
                metal.description,
            ]
            for metal in metals
        ],
        text=(0, 5),
    )
    for document, n in numbers.items():
        out.hanging(f"  {n}", document, 5)
    out.line()
    out.line("`microslip materials NAME` gives the page or table of each value.")
    out.line('In a study: materials = ["steel", "al2017"]. Keys of a [material.NAME] there win.')


def show_one(metal: Metal, stream: TextIO) -> None:
    """Print one metal with the source of each value."""
    out = Printer(stream)
    out.line(f"{metal.name}: {metal.description}", style="bold")
    out.line()
    for key in _KEYS:
        source = metal.sources.get(key, "not in the documents; give your own")
        out.hanging(f"  {key:<13}  {_value(metal, key):>9}", source, 28)
    out.line()
    if metal.aliases:
        out.hanging("  also", ", ".join(metal.aliases), 8)
        out.line()
    out.line(f'In a study: materials = ["{metal.name}", "{metal.name}"]')
    out.line(f'In Python:  microslip.Material.named("{metal.name}")')


def _value(metal: Metal, key: str) -> str:
    value = getattr(metal, key)
    if key == "poisson_ratio":
        return f"{value:g}"
    return engineering(value, "Pa", 4, trim=True)


def _document(source: str) -> str:
    match = _DOCUMENT.match(source)
    return match[0] if match else source
