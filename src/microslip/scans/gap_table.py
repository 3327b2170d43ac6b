"""A joint from a table of gaps, as for the Brake-Reuss beam.

Where two rough surfaces were scanned and their summits paired, what is known is the density of the
gaps between facing summits when the highest pair just touches. A pair with gap z is a summit of
height -z: the rigid plane at the separation d = -u, closed by u since the first touch, indents it
by u - z.
"""

from __future__ import annotations

import csv
import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats, positive, show
from microslip._core.frozen import assign
from microslip._core.wording import did_you_mean, shorten
from microslip.errors import InputError
from microslip.heights import TabulatedHeights
from microslip.materials import MaterialPair
from microslip.normal import GreenwoodWilliamson
from microslip.readers.array_files import archived
from microslip.readers.files import POINTS, reading
from microslip.readers.matlab import whole_variables

MOST_BYTES = 100_000_000
"""Size of a file, and of a table in it once unpacked, beyond which it is refused."""


@dataclass(frozen=True)
class GapTable:
    """Summits of two surfaces in contact, by a table of the gaps between them.

    As Porter and Brake (2023) describe them, DOI 10.1016/j.ymssp.2023.110210.

    Parameters
    ----------
    radius : float
        Radius of the equivalent spheres [m].
    density : float
        Pairs of summits per area [1/m^2].
    heights : TabulatedHeights
        Heights [m]: minus the gaps, so that zero is where the first pair touches.
    notes : tuple of str
        Notes on reading and processing.
    """

    radius: float
    density: float
    heights: TabulatedHeights
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        radius = positive("radius", self.radius, "m", 1e-3)
        assign(self, radius=radius, density=positive("density", self.density, "1/m^2", 1e6))
        if not isinstance(self.heights, TabulatedHeights):
            raise InputError(f"`heights` must be TabulatedHeights, got {show(self.heights)}")

    def to_surface(self, pair: MaterialPair, area: float) -> GreenwoodWilliamson:
        """The joint of the two surfaces as a rough one against a plane, of an apparent area [m^2].

        The separation counts from the first touch: -u when closed by u.
        """
        return GreenwoodWilliamson(pair, self.heights, self.radius, self.density, area)


def read_gap_table(
    path: str | os.PathLike[str],
    *,
    gap: str = "normzinterp",
    probability: str = "pzinterp",
    scale: str | float | None = "z_max",
    radius: str | float = "Re",
    density: str | float = "area_density",
    limit: int = POINTS,
) -> GapTable:
    """Read a table of gaps from a ``.mat``, ``.npz`` or ``.csv`` file.

    The names are those of the data of the Brake-Reuss beam by Porter and Brake (2023),
    DOI 10.1016/j.ymssp.2023.110210; others can be given.

    Parameters
    ----------
    path : str or path
        The file: MATLAB's up to version 7, NumPy's, or text with a row of names over columns.
    gap : str
        Array of the gaps between facing summits, from the first touch on, in rising order.
    probability : str
        Array of their density, of any scale.
    scale : str, float or None
        Factor from gaps to metres: a number of the file by its name, or here.
    radius : str or float
        Radius of the equivalent spheres [m], by name or here.
    density : str or float
        Pairs of summits per area [1/m^2], by name or here.
    limit : int, optional
        Numbers that a file may hold.

    Returns
    -------
    GapTable
        Radius, density and heights.
    """
    file = Path(path)
    names = [v for v in (gap, probability, scale, radius, density) if isinstance(v, str)]
    with reading(file, "a table of gaps", limit):
        arrays = _arrays(file, names)
    factor = 1.0 if scale is None else positive("scale", _value(arrays, scale, file), "m", 1e-5)
    gaps = arrays[gap].reshape(-1) * factor
    share = arrays[probability].reshape(-1)
    if gaps.size != share.size:
        raise InputError(
            f'{file.name}: "{gap}" and "{probability}" must be of one length, got {gaps.size} and '
            f"{share.size}"
        )
    # Not minus zero.
    heights = TabulatedHeights(0.0 - gaps[::-1], share[::-1])
    integral = heights.integral / factor
    notes = (
        f"gaps: {gaps.size} from {gaps[0]:.4g} m to {gaps[-1]:.4g} m, of {shorten(file.name, 60)}; "
        "a gap z is a summit of height -z.",
        f"gaps: the density over gaps in the file's unit has the integral {integral:.7g}; divided "
        "by it.",
    )
    return GapTable(_value(arrays, radius, file), _value(arrays, density, file), heights, notes)


def _value(arrays: dict[str, Floats], name_or_value: str | float, file: Path) -> float:
    """A number by its name, or as it is."""
    if not isinstance(name_or_value, str):
        return name_or_value
    array = arrays[name_or_value]
    # A column of a text repeats its number.
    if array.size == 0 or np.any(array != array.flat[0]):
        raise InputError(f'{file.name}: "{name_or_value}" must be one number, got {array.size}')
    return float(array.flat[0])


def _arrays(file: Path, names: list[str]) -> dict[str, Floats]:
    """The arrays of these names."""
    if (size := file.stat().st_size) > MOST_BYTES:
        raise ValueError(f"must be of at most {MOST_BYTES} bytes, got {size}")
    suffix = file.suffix.lower()
    read = {".mat": _named, ".npz": _named, ".csv": _text, ".txt": _text}.get(suffix)
    if read is None:
        raise ValueError(f"wanted a .mat, .npz, .csv or .txt file, got {show(suffix)}")
    result = {}
    for name, array in read(file, names).items():
        array = np.asarray(array)
        if array.dtype.kind not in "iuf":
            raise ValueError(f'"{name}" must hold numbers')
        if not np.isfinite(array).all() or array.size == 0:
            raise ValueError(f'"{name}" must hold finite numbers')
        result[name] = array.astype(float)
    return result


def _named(file: Path, names: list[str]) -> dict[str, Any]:
    """Arrays of an archive, MATLAB's or NumPy's."""
    content = (whole_variables if file.suffix.lower() == ".mat" else archived)(file)
    _check(names, content)
    return {name: content[name] for name in names}


def _text(file: Path, names: list[str]) -> dict[str, NDArray[np.float64]]:
    with file.open(encoding="utf-8-sig", errors="replace", newline="") as lines:
        head = lines.readline()
        delimiter = next((d for d in (",", ";", "\t") if d in head), " ")
        titles = [t.strip() for t in next(csv.reader([head], delimiter=delimiter), [])]
        _check(names, titles)
        columns = [titles.index(name) for name in names]
        rows = []
        for number, row in enumerate(
            csv.reader(lines, delimiter=delimiter, skipinitialspace=True), start=2
        ):
            if not any(cell.strip() for cell in row):
                continue
            try:
                rows.append([float(row[c]) for c in columns])
            except (ValueError, IndexError):
                raise ValueError(
                    f"line {number} must have numbers under {', '.join(names)}"
                ) from None
    table = np.array(rows, dtype=float).reshape(-1, len(names))
    return {name: table[:, k] for k, name in enumerate(names)}


def _check(names: list[str], available: Iterable[str]) -> None:
    available = list(available)
    for name in names:
        if name not in available:
            listed = ", ".join(shorten(h, 30) for h in available[:12]) or "nothing"
            raise ValueError(
                f'has no "{shorten(name, 40)}"{did_you_mean(name, available)}; it has {listed}'
            )
