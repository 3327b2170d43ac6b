"""From a file to the parts of a record: columns, units, calibration, zero, sign, and the notes."""

from __future__ import annotations

import math
import numbers
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip._core.frozen import lock
from microslip._core.units import FORCE, QuantityError, engineering, to_si
from microslip._core.wording import quoted, shorten, show
from microslip.errors import UNSAID, Argument, InputError
from microslip.readers import (
    arrays,
    hdf5,
    json_files,
    matlab,
    numpy_files,
    parquet,
    tdms,
    text,
    uff,
)
from microslip.readers.files import head_of, kind_of, stranger, usable
from microslip.readers.tables import Named, Table, find, listed, scale, understood
from microslip.tribometer.roles import KINDS, NEEDED, guess
from microslip.tribometer.scaling import Scale, by_role, scale_of, sign_of, zero_of

READERS: Mapping[str, Callable[[Path], Table]] = {
    "tdms": tdms.table,
    "mat": lambda path: arrays.table(matlab.read_arrays(path)),
    "hdf5": lambda path: arrays.table(hdf5.read_arrays(path)),
    "npy": lambda path: arrays.table(numpy_files.read_npy(path)),
    "npz": lambda path: arrays.table(numpy_files.read_npz(path)),
    "json": lambda path: arrays.table(json_files.read_arrays(path)),
    "parquet": parquet.table,
    "uff": uff.table,
    "text": text.table,
}
"""How the columns of a file are had, by its format."""

_WANTED = "wanted text, MAT, TDMS, HDF5, Parquet, JSON, UFF or NumPy's"
_MOST_LONE, _LONGEST_LONE = 0.01, 3
"""Share of rows that may lack a number, and how many of them in a row."""


@dataclass(frozen=True)
class Wishes:
    """What the user states of a file; None where nothing."""

    columns: Mapping[str, Any]
    sample_rate: float | None
    frequency: float | None
    units: Any
    calibration: Any
    sign: Any
    zero: Any
    rows: Any
    format: Any


def read(path: Path, wishes: Wishes) -> dict[str, Any]:
    """The parts of a record, by their names."""
    table = _open(path, wishes.format)
    columns = understood(table.columns)
    loads = wishes.columns["normal_load"]
    load = _one_load(columns, loads)
    taken, how = _chosen(columns, wishes, skip_load=load is not None)
    stated = {
        "units": by_role("units", wishes.units, {"force": "mN"}),
        "calibration": by_role("calibration", wishes.calibration, {"force": "12.5 N/V"}),
        "zero": by_role("zero", wishes.zero, {"force": "mean"}),
        "sign": by_role("sign", _signs(wishes.sign), {"force": -1}),
    }
    for name, mapping in stated.items():
        for role in mapping:
            if role not in taken:
                raise InputError(
                    *(Argument(name), f": no column is read as {role}; write "),
                    Argument(role, UNSAID),
                )
    scales = {
        role: scale_of(column, role, stated["units"].get(role), stated["calibration"].get(role))
        for role, column in taken.items()
    }
    signs = {role: sign_of(stated["sign"].get(role, 1), role) for role in taken}
    arrays, first, notes = _arrays(table, taken, wishes.rows)
    notes = [f"{shorten(path.name, 100)}: {table.kind}.", *notes]
    for role, column in taken.items():
        note = _finish(arrays[role], role, scales[role], stated["zero"].get(role), signs[role])
        notes.append(f'{role}: column "{shorten(column.heading, 60)}" {how[role]}, {note}.')
    if "time" in taken:
        _check_time(table, arrays["time"], first)
    found: dict[str, Any] = dict.fromkeys(KINDS) | {k: lock(v) for k, v in arrays.items()}
    found["sample_rate"], found["frequency"] = wishes.sample_rate, wishes.frequency
    if load is not None:
        found["normal_load"] = load
        notes.append(f"normal_load: {engineering(load, 'N')} throughout, as stated.")
    _state(found, table, taken, wishes, notes)
    if "time" not in taken and found["sample_rate"] is None:
        notes.append("time: none; the record says nothing of frequencies.")
    others = [column.heading for column in columns if column not in taken.values()]
    if others:
        more = f" and {len(others) - 20} more" if len(others) > 20 else ""
        shown = ", ".join(f'"{shorten(text, 40)}"' for text in others[:20])
        notes.append(f"not read: {shown}{more}.")
    return found | {"notes": tuple(notes)}


def _open(path: Path, wanted: Any) -> Table:
    with usable(path, "a record"):
        head = head_of(path)
        if wanted is not None:
            if wanted not in READERS:
                raise ValueError(f"wanted format {quoted(sorted(READERS))}, got {show(wanted)}")
            return READERS[wanted](path)
        if not head:
            raise ValueError("wanted a record, got an empty file")
        kind = kind_of(head, path.suffix.lower())
        if kind is None:
            raise ValueError(f"{_WANTED}, got {stranger(head)}; save the record as CSV")
        return READERS[kind](path)


def _one_load(columns: list[Named], given: Any) -> float | None:
    """Normal load [N] that is one for all samples, if that was stated."""
    if isinstance(given, bool) or given is None:
        return None
    if isinstance(given, numbers.Real):
        return float(given)
    if isinstance(given, str) and re.match(r"\s*[+-]?[\d.]", given):
        if any(given.strip() in (c.heading, c.name, c.short) for c in columns):
            return None
        try:
            return to_si(given, FORCE, "500 N")
        except QuantityError as error:
            raise InputError(Argument("normal_load"), f": {error}") from None
    return None


def _signs(given: Any) -> Any:
    return {"force": given} if isinstance(given, int) and not isinstance(given, bool) else given


def _chosen(
    columns: list[Named], wishes: Wishes, skip_load: bool
) -> tuple[dict[str, Named], dict[str, str]]:
    """Column of each part of the record, and how it was found."""
    taken: dict[str, Named] = {}
    how: dict[str, str] = {}
    skipped = {"normal_load"} if skip_load else set[str]()
    if wishes.columns["time"] is None and wishes.sample_rate is not None:
        skipped.add("time")
    for role, given in wishes.columns.items():
        if given is False and role not in NEEDED:
            skipped.add(role)
        elif given is not None and role not in skipped:
            column = find(columns, given, role)
            other = next((r for r, c in taken.items() if c == column), None)
            if other:
                raise InputError(
                    Argument(role),
                    f': column "{shorten(column.heading, 40)}" is the {other} already',
                )
            taken[role], how[role] = column, "as stated"
    for role in KINDS:
        if role in taken or role in skipped:
            continue
        try:
            taken[role], how[role] = guess(columns, role, taken)
        except LookupError:
            if role in NEEDED:
                raise InputError(
                    *(Argument(role), f": no column tells; {listed(columns)}; write "),
                    *(Argument(role, "NAME"), ', or "#2" for the second'),
                ) from None
    return {role: taken[role] for role in KINDS if role in taken}, how


def _arrays(
    table: Table, taken: Mapping[str, Named], rows: Any
) -> tuple[dict[str, Floats], int, list[str]]:
    """Numbers of the columns as they are in the file, the first row of them, and notes."""
    arrays = dict(zip(taken, table.load([column.place for column in taken.values()]), strict=True))
    names = {role: f'"{shorten(column.heading, 40)}"' for role, column in taken.items()}
    sizes = {role: values.size for role, values in arrays.items()}
    if len({*sizes.values()}) > 1:
        each = ", ".join(f"{names[role]} {size}" for role, size in sizes.items())
        raise ValueError(f"columns must be of one length, got {each} samples")
    first, notes = 0, []
    if rows is not None:
        if not isinstance(rows, slice) or rows.step not in (None, 1):
            wanted = Argument("rows", _Rows("first", "end"))
            raise InputError("wanted ", wanted, f", got {show(rows)}")
        first, end, _ = rows.indices(sizes["displacement"])
        arrays = {role: values[first:end].copy() for role, values in arrays.items()}
        notes.append(f"rows {first} to {max(end, first)} (without) of {sizes['displacement']}.")
    size = arrays["displacement"].size
    whole = size
    # A sum is quick, and finite unless something is not.
    with np.errstate(all="ignore"):
        sound = all(np.isfinite(values.sum()) for values in arrays.values())
    if not sound:
        bad = np.zeros(size, dtype=bool)
        for values in arrays.values():
            bad |= ~np.isfinite(values)
        good = np.flatnonzero(~bad)
        whole = int(good[-1]) + 1 if good.size else 0
        if bad[:whole].any():
            if not _is_lone(bad[:whole]):
                _complain(table, arrays, names, bad[:whole], first)
            arrays = {role: _filled(values[:whole]) for role, values in arrays.items()}
            notes.append(
                f"straight lines stand in the place of {_rows(int(bad[:whole].sum()))} without "
                f"numbers, the first {table.where(int(bad.argmax()) + first)}."
            )
        if whole < size:
            notes.append(f"left out: {_rows(size - whole)} without numbers at the end.")
            arrays = {role: values[:whole].copy() for role, values in arrays.items()}
    if whole < 2:
        raise ValueError(f"wanted at least two rows of numbers, got {whole}")
    return arrays, first, notes


def _is_lone(bad: Any) -> bool:
    """Whether missing numbers are few and apart, so that nothing is lost."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], bad.astype(np.int8), [0]])))
    runs = np.diff(edges.reshape(-1, 2), axis=1)
    return not bad[0] and int(runs.max()) <= _LONGEST_LONE and float(bad.mean()) <= _MOST_LONE


def _filled(values: Floats) -> Floats:
    """Numbers with straight lines where there are none."""
    bad = ~np.isfinite(values)
    if bad.any():
        place = np.arange(values.size)
        values = values.copy()
        values[bad] = np.interp(place[bad], place[~bad], values[~bad])
    return values


@dataclass(frozen=True, repr=False)
class _Rows:
    """Rows to take, as a message writes them."""

    first: object
    end: object

    def __repr__(self) -> str:
        return f"slice({self.first}, {self.end})"

    def __str__(self) -> str:
        first = self.first + 1 if isinstance(self.first, (int, np.integer)) else self.first
        return f"{first}..{self.end}"


def _rows(count: int) -> str:
    return f"{count} row{'s' if count > 1 else ''}"


def _complain(
    table: Table, arrays: Mapping[str, Floats], names: Mapping[str, str], bad: Any, first: int
) -> None:
    """Say where the first number is that is none, and which rows are sound."""
    row = int(np.flatnonzero(bad)[0])
    role = next(role for role, values in arrays.items() if not np.isfinite(values[row]))
    edges = np.flatnonzero(np.diff(np.concatenate([[1], bad.astype(np.int8), [1]])))
    runs = edges.reshape(-1, 2)
    start, end = runs[int(np.argmax(runs[:, 1] - runs[:, 0]))] + first
    raise InputError(
        f"{table.where(row + first)}, column {names[role]}: wanted a number, got "
        f"{arrays[role][row]} ({_rows(int(bad.sum()))} like this before the end); "
        "the longest stretch of numbers is ",
        Argument("rows", _Rows(start, end)),
    )


def _finish(values: Floats, role: str, taken_as: Scale, zero: Any, sign: int) -> str:
    """Turn numbers of a file into SI floats, in place, and say what was done."""
    kind = KINDS[role]
    scale(values, taken_as.factor)
    origin, said = zero_of(zero, role, values)
    if origin:
        values -= origin
    if sign < 0:
        np.negative(values, out=values)
    ends = float(values.min()), float(values.max())
    low, high = _range(*ends, kind.unit)
    if not said:
        said = "sign turned, zero as in the file" if sign < 0 else "sign and zero as in the file"
    else:
        said += ", sign turned" if sign < 0 else ", sign as in the file"
    return f"{taken_as.words}, {said}: from {low} to {high}"


def _range(low: float, high: float, unit: str) -> tuple[str, str]:
    """Both ends with as many digits as tell their distance."""
    size, distance = max(abs(low), abs(high)), high - low
    beyond = math.ceil(math.log10(size / distance)) if 0.0 < distance < size else 0
    digits = min(3 + beyond, 9)
    return engineering(low, unit, digits), engineering(high, unit, digits)


def _check_time(table: Table, time: Floats, first: int) -> None:
    steps = np.diff(time)
    if steps.min() > 0.0:
        return
    row = int(np.flatnonzero(steps <= 0.0)[0])
    why = "repeats; if it is rounded" if steps[row] == 0.0 else "goes backwards; if it is no time"
    rate = Argument("sample_rate", UNSAID)
    raise InputError(
        f"{table.where(row + 1 + first)}: time {why}, write ",
        *(Argument("time", False), " and ", rate),
        f", got {time[row + 1]:.9g} s after {time[row]:.9g} s",
    )


def _state(
    found: dict[str, Any],
    table: Table,
    taken: Mapping[str, Named],
    wishes: Wishes,
    notes: list[str],
) -> None:
    """What the file states for the whole record, where the user and the columns do not."""
    if found["sample_rate"] is not None:
        if "time" in taken:
            both = (Argument("time"), " and ", Argument("sample_rate"))
            raise InputError(*both, " say the same; write one of them")
        notes.append(f"sample_rate: {found['sample_rate']:g} Hz, as stated.")
    elif "time" not in taken:
        rates = dict.fromkeys(table.columns[taken[role].place].rate for role in NEEDED)
        if len(rates) > 1:
            shown = " and ".join(f"{rate:g} Hz" if rate else "none" for rate in rates)
            raise ValueError(f"displacement and force differ in sample rate, got {shown}")
        (rate,) = rates
        where = "their channels"
        if rate is None and (said := table.stated.get("sample_rate")):
            rate, where = said.value, said.where
        if rate is not None:
            found["sample_rate"] = rate
            notes.append(f'sample_rate: {rate:g} Hz by "{where}" of the file.')
    for key in ("frequency", "normal_load"):
        said = table.stated.get(key)
        if said and found[key] is None and wishes.columns.get(key) is None:
            found[key] = said.value
            unit = "N" if key == "normal_load" else "Hz"
            notes.append(f'{key}: {said.value:g} {unit} by "{said.where}" of the file.')
