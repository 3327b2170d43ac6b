"""Universal file format, the data sets 58 of test laboratories, by pyuff."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip.readers.files import first_line
from microslip.readers.tables import Column, Table


def table(path: Path) -> Table:
    """Functions of time (data sets 58), with their names, units and sample rate."""
    pyuff = _library()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            file = pyuff.UFF(str(path))
            places = [i for i, kind in enumerate(file.get_set_types()) if int(kind) == 58]
            sets = [file.read_sets(i) for i in places]
    except MemoryError:
        raise
    except Exception as error:  # pyuff raises many kinds on what is damaged
        raise ValueError(f"not a usable UFF file: {first_line(error)}") from None
    real = [part for part in sets if np.isrealobj(part["data"]) and np.size(part["data"]) > 1]
    if not real:
        raise ValueError("wanted functions of time (data sets 58), got none in this UFF file")
    columns = tuple(_column(part) for part in real)

    def load(selection: Sequence[int]) -> list[Floats]:
        return [np.array(real[place]["data"], dtype=float) for place in selection]

    return Table("UFF file", columns, load)


def _column(part: dict[str, Any]) -> Column:
    step = float(part.get("abscissa_inc") or 0.0)
    rate = 1.0 / step if 0.0 < step < math.inf and part.get("abscissa_spacing", 1) == 1 else None
    names = (part.get("ordinate_axis_lab"), part.get("id1"), part.get("rsp_ent_name"))
    labels = (str(name).strip() for name in names if name)
    heading = next((name for name in labels if name and name.upper() != "NONE"), "")
    unit = str(part.get("ordinate_axis_units_lab") or "").strip()
    return Column(heading, None if unit.upper() in ("", "NONE") else unit, None, rate)


def _library() -> Any:
    try:
        import pyuff
    except ImportError:
        raise ValueError(
            'UFF files are read by pyuff, which is not installed: pip install "microslip[uff]"'
        ) from None
    return pyuff
