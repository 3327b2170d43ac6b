"""Finding the heights of a scan in a file, with what the file says of them."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from microslip._core.errors import InputError
from microslip._core.units import LENGTH, QuantityError, is_unit, to_si
from microslip._core.wording import shorten
from microslip.readers import array_files, hdf5, matlab
from microslip.readers.arrays import Arrays, leaves, single_array, values_of
from microslip.readers.dialect import is_comment, split
from microslip.readers.files import head_of, kind_of, refuse_beyond
from microslip.readers.instruments import on_grid, read_channel
from microslip.readers.tables import fits, name_and_unit
from microslip.readers.text import TextFile, open_text

ARRAY_FILES = {
    "npy": array_files.read_npy,
    "npz": array_files.read_npz,
    "mat": matlab.read_arrays,
    "hdf5": hdf5.read_arrays,
}
TEXTS = ("text", "matrix", "xyz", "profile")
"""Formats of text: by what is in the columns, and what can be in them."""

_ENDINGS_OF_TEXT = {".txt", ".csv", ".tsv", ".dat", ".xyz", ".asc", ".prf", ".prn", ""}
_NAMES_OF_HEIGHTS = {"height", "heights", "topography", "z"}
# What Gwyddion writes above a matrix.
_STATED = re.compile(r"[#%/\s]*(width|height|value units)\s*:\s*(.+?)\s*", re.IGNORECASE)
_BY_SLASH = re.compile(r"(.+?)\s*/\s*([^\W\d_]{1,12})")


@dataclass(frozen=True)
class Wishes:
    """The user's statements on a file; None where nothing."""

    format: Any = None
    unit: Any = None
    pixel: Any = None
    channel: Any = None
    valid: Any = None


@dataclass(frozen=True)
class RawHeights:
    """Heights as they are in a file."""

    kind: str
    """Kind of the file and how it was read, for the notes."""
    values: np.ndarray
    """In whatever unit; missing points are NaN or masked."""
    unit: str | None = None
    """Unit of the heights, as the file says; None if it does not."""
    pixel: tuple[float, ...] | None = None
    """Distance of neighbours [m], as the file says."""
    steps: tuple[float, ...] | None = None
    """The same in the unit of coordinates, which `columns` or the user has to say."""
    columns: tuple[str | None, str | None] = (None, None)
    """Units of the coordinates and of the heights, as the names of columns say."""
    notes: tuple[str, ...] = field(default=())
    """Further notes."""


def read_heights(path: Path, wishes: Wishes) -> RawHeights:
    """The heights of a file of any kind; a ValueError says what is wrong, and not the file."""
    head = head_of(path)
    if not head:
        raise ValueError("wanted a scan, got an empty file")
    form = wishes.format or _form(head, path.suffix.lower())
    if wishes.channel is not None and form in ("npy", *TEXTS):
        raise InputError("`channel` means nothing for this kind of file; leave it out")
    if form in ARRAY_FILES:
        return _of_arrays(ARRAY_FILES[form](path), wishes)
    if form in TEXTS:
        return _of_text(open_text(path), form, wishes)
    kind, values, unit, pixel, notes = read_channel(path, form, wishes.channel)
    return RawHeights(kind, values, unit, pixel, notes=notes)


def _form(head: bytes, suffix: str) -> str | None:
    """Format of a file; None where SurfaceTopography is asked."""
    form = kind_of(head, suffix)
    if form in ("npy", "npz", "mat"):
        return form
    if form == "text" and suffix == ".mat":
        return "mat"  # and an error that says what is wrong with it
    if form == "text" and suffix in _ENDINGS_OF_TEXT:
        return form  # some instruments write text of their own, which their endings tell
    if suffix in (".npy", ".npz"):
        raise InputError(
            f"its ending says {suffix}, its first bytes do not; if it is of another kind, "
            "write `format=...`"
        )
    return None


def _of_arrays(arrays: Arrays, wishes: Wishes) -> RawHeights:
    """The matrix that is meant."""
    named = leaves(arrays)
    alone = arrays.kind == "NumPy's npy file"
    name = next(iter(named)) if alone else single_array(named, wishes.channel, arrays.kind)
    leaf = named[name]
    refuse_beyond(*leaf.shape)
    values = values_of(name, leaf)
    if arrays.kind.startswith("MAT") and 1 in values.shape:  # MATLAB has no vectors
        values = values.ravel()
    if leaf.unit is not None and is_unit(leaf.unit) and not fits(leaf.unit, LENGTH):
        raise ValueError(f'array "{name}" is in "{shorten(leaf.unit, 20)}": wanted a length')
    kind = arrays.kind if alone else f'{arrays.kind}, array "{name}"'
    return RawHeights(kind, values, leaf.unit if fits(leaf.unit, LENGTH) else None)


def _of_text(file: TextFile, form: str, wishes: Wishes) -> RawHeights:
    """A matrix, or points put on their grid."""
    count = len(file.layout.names)
    _refuse_ragged(file)
    names, units = zip(
        *(_length_unit(column.heading, column.unit) for column in file.columns), strict=True
    )
    called = [name.strip(" \"'").lower() for name in names[:3]]
    called = ["z" if name in _NAMES_OF_HEIGHTS else name for name in called]
    are_points = sorted(called) == ["x", "y", "z"]
    if form == "text":
        form = "profile" if count < 3 else "xyz" if count == 3 else "matrix"
        if count > 3 and (file.path.suffix.lower() == ".xyz" or are_points):
            form = "xyz"
    columns_read = 1 if form == "matrix" else count
    refuse_beyond(file.most_rows, count // columns_read)
    above = [line.text.strip() for line in file.above]
    header = next((line for line in above if line and not is_comment(line)), None)
    notes = () if header is None else (f'skipped above: "{shorten(header, 60)}".',)
    if form == "matrix":
        return _matrix(file.matrix(), above, notes)
    fewest, limit, expected = (3, count, "3") if form == "xyz" else (1, 2, "1 or 2")
    if not fewest <= count <= limit:
        raise InputError(f'`format="{form}"`: wanted {expected} columns, got {count}')
    order, order_notes = _order(called, count)
    columns: tuple[str | None, str | None] = (None, None)
    for place in order:
        _refuse_other(file.columns[place].heading, file.columns[place].unit)
    if any(units):
        columns, notes = _units(tuple(units[place] for place in order)), ()
    notes = (*notes, *order_notes)
    kind = "text, columns x, y, z" if form == "xyz" else "text, a profile"
    if count == 1:
        return RawHeights(kind, file.matrix()[:, 0], columns=columns, notes=notes)
    if wishes.pixel is not None:
        raise InputError(
            "its coordinates say the distance of neighbours: leave out `pixel`, or, if it is "
            'a matrix of heights, write `format="matrix"`'
        )
    *places, values = file.load(order)
    try:
        heights, steps = on_grid(places, values)
    except ValueError as error:
        if count <= 3:
            raise
        raise InputError(
            f"of {count} columns the first three were taken for x, y and z: {error}; if it "
            'is a matrix of heights, write `format="matrix"`'
        ) from None
    if count > 3:
        ignored = "1 column" if count == 4 else f"{count - 3} columns"
        notes = (*notes, f"not read: {ignored} beyond x, y and z.")
    return RawHeights(kind, heights, steps=steps, columns=columns, notes=notes)


def _order(called: list[str], count: int) -> tuple[list[int], tuple[str, ...]]:
    """Columns of x, y and z, or x and z, by their names; without names by their places."""
    axes = ["x", "y", "z"] if count > 2 else ["x", "z"][2 - count :]
    places = list(range(len(axes)))
    if sorted(called) == axes:
        order = [called.index(name) for name in axes]
        if order != places:
            return order, (f"columns: {', '.join(called)}, by their names.",)
        return order, ()
    for place, name in enumerate(called):
        if count > 1 and name in ("x", "y", "z") and axes[place] != name:
            raise ValueError(
                f'column {place + 1} is named "{name}", where {axes[place]} is expected: wanted '
                f"columns {', '.join(axes)}, or names for all of them"
            )
    return places, ()


def _refuse_other(heading: str, unit: str | None) -> None:
    """Refuse a column whose unit is none of length."""
    name, heading_unit = name_and_unit(heading)
    unit = unit or heading_unit
    if unit is not None and is_unit(unit) and not fits(unit, LENGTH):
        raise ValueError(
            f'column "{shorten(name, 40)}" is in "{shorten(unit, 20)}": wanted a length such as '
            '"um"'
        )


def _refuse_ragged(file: TextFile) -> None:
    """Refuse rows of numbers above those of the layout: no heights are skipped in silence."""
    layout = file.layout
    for line in file.above:
        cells = split(line.text, layout.separator)
        while cells and not cells[-1]:
            cells.pop()
        if cells and all(map(_is_number, cells)):
            raise ValueError(
                f"wanted rows of {len(layout.names)} numbers as in line {layout.first + 1}: "
                f"line {line.above + 1}: got {len(cells)}"
            )


def _is_number(cell: str) -> bool:
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return False
    return True


def _length_unit(heading: str, unit: str | None) -> tuple[str, str | None]:
    """Name of a column, and its unit if that is one of length."""
    name, heading_unit = name_and_unit(heading)
    unit = unit or heading_unit
    if unit is None and (match := _BY_SLASH.fullmatch(heading.strip())):
        name, unit = match[1], match[2]
    return (name, unit) if fits(unit, LENGTH) else (heading, None)


def _units(units: tuple[str | None, ...]) -> tuple[str | None, str | None]:
    """Units of coordinates and of heights by the names of their columns."""
    across = list(dict.fromkeys(unit for unit in units[:-1] if unit))
    if len({to_si(f"1 {unit}", LENGTH, "1 um") for unit in across}) > 1:
        raise ValueError(f'x is in "{across[0]}", y in "{across[1]}": wanted one unit for both')
    return across[0] if across else None, units[-1]


def _matrix(table: np.ndarray, above: list[str], notes: tuple[str, ...]) -> RawHeights:
    stated = {match[1].lower(): match[2] for line in above if (match := _STATED.fullmatch(line))}
    unit = stated.get("value units")
    pixel = None
    try:
        if {"width", "height"} <= stated.keys():
            sizes = [to_si(stated[key], LENGTH, "1 mm") for key in ("width", "height")]
            pixel = sizes[0] / table.shape[1], sizes[1] / table.shape[0]
    except QuantityError:  # some other use of these words
        pixel = None
    unit = unit if unit and is_unit(unit) else None
    return RawHeights("text, a matrix", table, unit, pixel, notes=notes)
