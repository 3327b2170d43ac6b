"""Figures of chapter 19 of *The Mechanics of Jointed Structures*, computed with this library.

"The chapter" in this package is chapter 19 of that book (Springer, 2018), on which the model is
based. Figures have the numbers of the chapter.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from microslip._core.errors import InputError
from microslip._version import __version__
from microslip.chapter import contact, joint, loops, rig, sketches, surface
from microslip.chapter.plate import Plate

__all__ = ["LEFT_OUT", "PLATES", "Plate", "select", "write_figures"]


_MODULES = (sketches, contact, loops, surface, joint, rig)
_ENTRIES = (entry for module in _MODULES for entry in vars(module).values())
PLATES = tuple(
    sorted(
        (entry for entry in _ENTRIES if isinstance(entry, Plate)),
        key=lambda plate: int(plate.number.removeprefix("19.")),
    )
)
"""All figures in chapter order."""

LEFT_OUT = MappingProxyType({"19.5": "a photograph of the sample"})
"""Figures of the chapter that are not reproduced, and why."""


def select(numbers: Iterable[str] = ()) -> tuple[Plate, ...]:
    """Return the figures with the given numbers; all figures by default."""
    selected = [number.strip() for text in numbers for number in text.split(",")]
    plates = {plate.number: plate for plate in PLATES}
    for number in selected:
        if number in LEFT_OUT:
            raise InputError(f"figure {number} is not available: {LEFT_OUT[number]}")
        if number not in plates:
            raise InputError(f'no figure "{number}" (figures: {", ".join(plates)})')
    return tuple(plate for plate in PLATES if not selected or plate.number in selected)


def write_figures(
    plates: Sequence[Plate], folder: Path, progress: Callable[[float], None] | None = None
) -> dict[str, Any]:
    """Draw figures and write them as SVG, PNG and CSV, with a common summary."""
    figures = []
    for index, plate in enumerate(plates):
        figures.append(
            {
                "number": plate.number,
                "title": plate.title,
                "caption": plate.caption,
                "parameters": plate.parameters,
                "command": plate.command,
                "files": plate.write(folder),
            }
        )
        if progress is not None:
            progress((index + 1) / len(plates))
    summary = {
        "kind": "microslip-figures",
        "version": __version__,
        "figures": figures,
        "left_out": dict(LEFT_OUT),
        "files": [*(name for figure in figures for name in figure["files"]), "summary.json"],
    }
    text = json.dumps(summary, indent=1, ensure_ascii=False)
    (folder / "summary.json").write_text(text + "\n", encoding="utf-8", newline="\n")
    return summary
