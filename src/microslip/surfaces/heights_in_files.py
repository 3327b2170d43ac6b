"""Search for the heights of a scan in a file, with the units and pixel that the file states."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from microslip._core.errors import InputError
from microslip._core.units import LENGTH, QuantityError, is_unit, to_si
from microslip._core.wording import quote, shorten
from microslip.readers.arrays import Arrays, leaves, single_array, values_of_leaf
from microslip.readers.dialect import is_comment, split_line
from microslip.readers.files import file_kind, head_of, refuse_beyond
from microslip.readers.instruments import RawHeights, evenly_spaced, on_grid, read_channel
from microslip.readers.table_files import ARRAY_FILES
from microslip.readers.tables import fits, name_and_unit
from microslip.readers.text import TextFile, open_text

TEXTS = ("text", "matrix", "xyz", "profile")
"""Text formats: detected, or by the content of the columns."""

_ENDINGS_OF_TEXT = {".txt", ".csv", ".tsv", ".dat", ".xyz", ".asc", ".prf", ".prn", ".hfm", ""}
_NAMES_OF_HEIGHTS = {"height", "heights", "topography", "z"}
# Header lines of Gwyddion above a matrix.
_STATED = re.compile(r"[#%/\s]*(width|height|value units)\s*:\s*(.+?)\s*", re.IGNORECASE)
_FACTOR = re.compile(
    r"\b(?:height|z)\s+(?:conversion|scale|scaling)\s+factor\b[^\d+.-]*([+-]?[\d.]+(?:e[+-]?\d+)?)"
    r"[\s,;\"(\[]*([^\W\d_]{1,12})",
    re.IGNORECASE,
)
_BY_SLASH = re.compile(r"(.+?)\s*/\s*([^\W\d_]{1,12})")


def read_heights(path: Path, format_name: Any, channel: Any, has_pixel: bool) -> RawHeights:
    """Read the heights from a file of any format; error messages do not contain the file name.

    ``has_pixel`` is True if the user gives a pixel; points with coordinates must not have one.
    """
    for name, value, kinds in (("format", format_name, str), ("channel", channel, (str, int))):
        if value is not None and not isinstance(value, kinds):
            raise InputError(f"`{name}` must be text, got {quote(value)}")
    head = head_of(path)
    if not head:
        raise ValueError("wanted a scan, got an empty file")
    form = format_name or _form(head, path.suffix.lower())
    if channel is not None and form in ("npy", *TEXTS):
        raise InputError("`channel` does not apply to this kind of file; omit it")
    if form is not None and form in ARRAY_FILES:
        return _of_arrays(ARRAY_FILES[form](path), channel)
    if form in TEXTS:
        return _of_text(open_text(path), form, has_pixel)
    return read_channel(path, form, channel)


def _form(head: bytes, suffix: str) -> str | None:
    """Return the format of a file; None for formats that are read by SurfaceTopography."""
    form = file_kind(head, suffix)
    if form in ("npy", "npz", "mat"):
        return form
    if form == "text" and suffix == ".mat":
        return "mat"  # whose reader reports the problem
    if form == "text" and suffix in _ENDINGS_OF_TEXT:
        return form  # instrument text formats have other suffixes
    if suffix in (".npy", ".npz"):
        raise InputError(
            f"the suffix is {suffix}, but the first bytes are not of that format; if the file is "
            "of another kind, write `format=...`"
        )
    return None


def _of_arrays(arrays: Arrays, channel: str | int | None) -> RawHeights:
    named = leaves(arrays)
    alone = arrays.kind == "NumPy's npy file"
    name = next(iter(named)) if alone else single_array(named, channel, arrays.kind)
    leaf = named[name]
    refuse_beyond(*leaf.shape)
    values = values_of_leaf(name, leaf)
    if arrays.kind.startswith("MAT") and 1 in values.shape:  # MATLAB has no vectors
        values = values.ravel()
    if leaf.unit is not None and is_unit(leaf.unit) and not fits(leaf.unit, LENGTH):
        raise ValueError(f'array "{name}" is in "{shorten(leaf.unit, 20)}": wanted a length')
    kind = arrays.kind if alone else f'{arrays.kind}, array "{name}"'
    return RawHeights(kind, values, leaf.unit if fits(leaf.unit, LENGTH) else None)


def _of_text(file: TextFile, form: str, has_pixel: bool) -> RawHeights:
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
    notes = () if header is None else (f'skipped header: "{shorten(header, 60)}".',)
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
    if has_pixel:
        raise InputError(
            "the coordinates determine the pixel; omit `pixel`, or, for a matrix of heights, "
            'write `format="matrix"`'
        )
    *places, values = file.load(order)
    if len(places) == 1:
        heights, steps, resampled = evenly_spaced(places[0], values)
        return RawHeights(kind, heights, steps=steps, columns=columns, notes=(*notes, *resampled))
    try:
        heights, steps = on_grid(places, values)
    except ValueError as error:
        if count <= 3:
            raise
        raise InputError(
            f"the first three of {count} columns were read as x, y and z: {error}; for a matrix "
            'of heights, write `format="matrix"`'
        ) from None
    if count > 3:
        ignored = "1 column" if count == 4 else f"{count - 3} columns"
        notes = (*notes, f"not read: {ignored} beyond x, y and z.")
    return RawHeights(kind, heights, steps=steps, columns=columns, notes=notes)


def _order(called: list[str], count: int) -> tuple[list[int], tuple[str, ...]]:
    """Return the indices of the columns x, y and z, or x and z, by name or else by position."""
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
    name, heading_unit = name_and_unit(heading)
    unit = unit or heading_unit
    if unit is not None and is_unit(unit) and not fits(unit, LENGTH):
        raise ValueError(
            f'column "{shorten(name, 40)}" is in "{shorten(unit, 20)}": wanted a length such as '
            '"um"'
        )


def _refuse_ragged(file: TextFile) -> None:
    """Raise a ValueError if rows of numbers above the detected table would be skipped."""
    layout = file.layout
    for line in file.above:
        cells = split_line(line.text, layout.separator)
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
    name, heading_unit = name_and_unit(heading)
    unit = unit or heading_unit
    if unit is None and (match := _BY_SLASH.fullmatch(heading.strip())):
        name, unit = match[1], match[2]
    return (name, unit) if fits(unit, LENGTH) else (heading, None)


def _units(units: tuple[str | None, ...]) -> tuple[str | None, str | None]:
    across = list(dict.fromkeys(unit for unit in units[:-1] if unit))
    if len({to_si(f"1 {unit}", LENGTH, "1 um") for unit in across}) > 1:
        raise ValueError(f'x is in "{across[0]}", y in "{across[1]}": wanted one unit for both')
    return across[0] if across else None, units[-1]


def _matrix(table: np.ndarray, above: list[str], notes: tuple[str, ...]) -> RawHeights:
    for line in above:
        if (match := _FACTOR.search(line)) and is_unit(match[2]) and fits(match[2], LENGTH):
            table, words = float(match[1]) * table, f"{match[1]} {match[2]}"
            note = f"heights: multiplied by the height conversion factor {words} of the header."
            return RawHeights("text, a matrix", table, match[2], notes=(*notes, note))
    stated = {match[1].lower(): match[2] for line in above if (match := _STATED.fullmatch(line))}
    unit = stated.get("value units")
    pixel = None
    try:
        if {"width", "height"} <= stated.keys():
            sizes = [to_si(stated[key], LENGTH, "1 mm") for key in ("width", "height")]
            pixel = sizes[0] / table.shape[1], sizes[1] / table.shape[0]
    except QuantityError:  # other text after these words
        pixel = None
    unit = unit if unit and is_unit(unit) else None
    return RawHeights("text, a matrix", table, unit, pixel, notes=notes)
