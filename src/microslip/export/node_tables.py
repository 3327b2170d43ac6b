"""Tables of patches: the nodes of a mesh that each lies between, its area and its load."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from microslip._core.checks import Floats
from microslip._core.errors import InputError
from microslip.readers.files import usable

_LINE_FORMAT = "lines of two numbers of nodes, or of these with an area [m^2] and a load [N]"


def read_nodes(file: str | Path) -> Floats:
    """Rows of two or four numbers, separated by blanks or commas; # begins a comment."""
    path = Path(file)
    try:
        with usable(path, "a table of nodes"):
            text = path.read_text(encoding="utf-8-sig")
    except ValueError as error:
        problem = (
            f"wanted {_LINE_FORMAT}, got no text" if isinstance(error, UnicodeError) else error
        )
        raise InputError(f"{path}: {problem}") from None
    rows: list[list[float]] = []
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split("#")[0].replace(",", " ").split()
        if not words:
            continue
        try:
            row = [float(word) for word in words]
        except ValueError:
            raise InputError(
                f"{path}: line {number}: wanted {_LINE_FORMAT}, got {line!r}"
            ) from None
        if len(row) not in (2, 4) or (rows and len(row) != len(rows[0])):
            raise InputError(
                f"{path}: line {number}: wanted {_LINE_FORMAT}, got {len(row)} numbers"
            )
        rows.append(row)
    if not rows:
        raise InputError(f"{path}: wanted {_LINE_FORMAT}, got none")
    return np.array(rows)
