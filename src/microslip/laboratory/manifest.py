"""Manifest of a campaign: a table with specimen, load, stage and other data of each file."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from microslip._core.units import FORCE, LENGTH, VOLUME, Kind, QuantityError, engineering, to_si
from microslip._core.wording import quote, quoted
from microslip.laboratory.record import Record, checked_path, path_text
from microslip.readers.files import file_kind, head_of, reading
from microslip.readers.laboratory import read_rows
from microslip.readers.tables import name_and_unit, spelt

_WORDS = {
    "file": ("file", "record", "path", "filename", "file name", "datei", "dateiname", "fichier"),
    "specimen": ("specimen", "sample", "probe", "probekörper", "éprouvette", "eprouvette"),
    "run": ("run", "laboratory", "lab", "operator", "versuch", "essai"),
    "stage": ("stage", "step", "phase", "stufe", "étape", "etape"),
    "normal_load": ("load", "normal load", "normal force", "normalkraft", "normallast", "last"),
    "amplitude": ("amplitude", "displacement amplitude", "wegamplitude"),
    "worn_volume": ("worn volume", "wear volume", "wear", "verschleißvolumen", "volume usé"),
    "first_cycle": ("first cycle", "number of the first cycle", "cycle", "zyklus"),
    "displacement_column": ("displacement column", "column of displacement"),
    "force_column": ("force column", "column of force"),
    "load_column": ("load column", "normal load column", "column of load"),
    "time_column": ("time column", "column of time"),
    "cycle_column": ("cycle column", "column of cycles", "counter column"),
    "sample_rate": ("sample rate", "sampling rate", "abtastrate"),
    "temperature": ("temperature", "temperatur", "température", "temp"),
}
"""Names of columns in English, German and French; others keep their names."""
_KINDS: Mapping[str, Kind] = {"normal_load": FORCE, "amplitude": LENGTH, "worn_volume": VOLUME}
_EXAMPLES = {"normal_load": "500 N", "amplitude": "20 um", "worn_volume": "0.12 mm^3"}
_READING = {
    "displacement_column": "displacement",
    "force_column": "force",
    "load_column": "normal_load",
    "time_column": "time",
    "cycle_column": "cycle_number",
    "sample_rate": "sample_rate",
}
"""Columns with reading options, and the arguments of Record.read."""
_POSITIVE = {"sample_rate": "a number in Hz", "first_cycle": "a number"}
"""Columns of positive numbers, and their description."""
_FILE = "file"
_NONE = ("", "-", "–", "none", "nan", "n/a")

Cell = str | float | None


@dataclass(frozen=True)
class Manifest:
    """Files of a campaign with the data of each file."""

    paths: tuple[str, ...]
    """Files of the records; relative paths are relative to the manifest."""
    columns: Mapping[str, tuple[Cell, ...]]
    """A value for each file: numbers where all are, texts otherwise, None where there is none; by
    "specimen", "stage", "normal_load" [N], "amplitude" [m], "worn_volume" [m^3],
    "first_cycle", "temperature", "run", or the name in the file."""
    units: Mapping[str, str]
    """Units of the numeric columns."""

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Manifest:
        """Read a manifest from CSV or an Excel workbook with one row for each file.

        Parameters
        ----------
        path : str or path
            The manifest. The first row that contains the cell "file" has the column names, with
            units in brackets; values may also have their own unit, such as "500 N".

        Returns
        -------
        Manifest
            Paths and columns.
        """
        place = checked_path(path)
        with reading(place, "a manifest", called=path_text(place)):
            rows = read_rows(place, file_kind(head_of(place), place.suffix.lower()))
            return cls._of(rows, place.parent)

    @classmethod
    def _of(cls, rows: list[list[str]], folder: Path) -> Manifest:
        heads: list[tuple[str, str | None]] = []
        first = 0
        for at, row in enumerate(rows):
            heads = [_head(cell) for cell in row]
            if any(name == _FILE for name, _ in heads):
                first = at + 1
                break
        else:
            found = quoted([cell for row in rows[:1] for cell in row if cell] or ["nothing"])
            raise ValueError(f'wanted a row of names with a column "file", got {found}')
        names = [name for name, _ in heads]
        twice = next((name for name in names if name and names.count(name) > 1), None)
        if twice is not None:
            raise ValueError(f'row {first}: two columns are the "{twice}"; rename one')
        filled_rows = [(at, row) for at, row in enumerate(rows[first:], start=first) if any(row)]
        if not filled_rows:
            raise ValueError("wanted a row for each file, got none")
        texts: dict[str, list[str]] = {name: [] for name in names if name}
        seen: dict[str, int] = {}
        for at, row in filled_rows:
            if any(row[len(names) :]):
                raise ValueError(f"row {at + 1}: {len(row)} cells for {len(names)} columns")
            for name, cell in zip(names, [*row, *[""] * len(names)], strict=False):
                if name:
                    texts[name].append(cell)
            file = texts[_FILE][-1]
            if not file:
                raise ValueError(f'row {at + 1}: the column "file" is empty')
            place = os.path.normpath(folder / file)
            if place in seen:
                raise ValueError(f"row {at + 1}: {quote(file)} is in row {seen[place]} already")
            seen[place] = at + 1
        numbers = [at + 1 for at, _ in filled_rows]
        columns = {}
        units = {}
        for name, unit in heads:
            if name and name != _FILE:
                columns[name] = _column(name, unit, texts[name], numbers)
                units[name] = _KINDS[name].unit if name in _KINDS else unit or ""
        paths = tuple(str(folder / text) for text in texts[_FILE])
        return cls(paths, columns, units)

    def texts(self, name: str) -> tuple[str, ...]:
        """Return a column as labels; an empty tuple if the column does not exist."""
        return tuple(map(text_of, self.columns.get(name, ())))

    def _cell(self, name: str, row: int) -> Any:
        return self.columns[name][row] if name in self.columns else None

    def loaded(self, record: Record, row: int) -> Record:
        """Add the normal load [N] of a manifest row to a record without a load."""
        load = self._cell("normal_load", row)
        if load is None or record.normal_load is not None:
            return record
        note = f"normal_load: {engineering(load, 'N')} throughout, by the manifest."
        return replace(record, normal_load=load, notes=(*record.notes, note))

    def reading(self, row: int) -> dict[str, Any]:
        """Return the arguments of :meth:`Record.read` for a row: columns and sample rate [Hz].

        A cell "none" means that the file has no such column.
        """
        given: dict[str, Any] = {}
        for name, argument in _READING.items():
            value = self._cell(name, row)
            if value is not None and name != "sample_rate":
                value = text_of(value)
                given[argument] = False if value == "none" else value
            elif value is not None:
                given[argument] = value
        return given


def text_of(value: Cell) -> str:
    """Format the value of a manifest cell as a label."""
    if value is None:
        return "–"
    return f"{value:.12g}" if isinstance(value, float) else value


def _head(cell: str) -> tuple[str, str | None]:
    name, unit = name_and_unit(cell)
    plain = re.sub(r"[\s_-]+", " ", name).strip().casefold()
    known = (role for role, words in _WORDS.items() if plain in words or plain == role)
    return next(known, name.strip()), unit


def _column(name: str, unit: str | None, texts: list[str], rows: list[int]) -> tuple[Cell, ...]:
    if name in _KINDS:
        return tuple(
            None if text.casefold() in _NONE else _quantity(name, unit, text, row)
            for text, row in zip(texts, rows, strict=True)
        )
    numbers = [_number(text) for text in texts]
    if name in ("specimen", "run"):
        return tuple(text or None for text in texts)
    is_given = [text.casefold() not in _NONE for text in texts]
    if name in _POSITIVE:
        for row, text, number, here in zip(rows, texts, numbers, is_given, strict=True):
            if here and (number is None or not number > 0.0):
                raise ValueError(
                    f'row {row}, column "{name}": wanted {_POSITIVE[name]} above zero, got '
                    f"{quote(text)}"
                )
        return tuple(numbers)
    given = [number for number, here in zip(numbers, is_given, strict=True) if here]
    if given and None not in given:
        return tuple(numbers)
    return tuple(text or None for text in texts)


def _quantity(name: str, unit: str | None, text: str, row: int) -> float:
    kind, number = _KINDS[name], _number(text)
    if name == "worn_volume" and number == 0.0:
        return 0.0
    where = f'row {row}, column "{name}": '
    if number is not None and unit is None:
        example = _EXAMPLES[name]
        raise ValueError(
            f'{where}{quote(text)} has no unit; write "{example}", or '
            f'"{name} [{example.split()[1]}]" above the column'
        )
    if number is not None and not number > 0.0:
        raise ValueError(f"{where}wanted a value above zero, got {quote(text)}")
    written = text if number is None else f"{number!r} {spelt(unit or '')}"
    try:
        return to_si(written, kind, _EXAMPLES[name])
    except QuantityError as error:
        raise ValueError(f"{where}{error}") from None


def _number(text: str) -> float | None:
    plain = text.replace("\N{MINUS SIGN}", "-")
    if re.fullmatch(r"[+-]?\d+,\d+", plain):
        plain = plain.replace(",", ".")
    try:
        value = float(plain)
    except ValueError:
        return None
    return value if math.isfinite(value) else None
