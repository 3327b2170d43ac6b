"""Conversion of a file to a record: columns, units, calibration, zero, sign, and notes."""

from __future__ import annotations

import numbers
import re
from collections.abc import Callable, Mapping
from decimal import Decimal
from pathlib import Path
from typing import Any, Self

import numpy as np

from microslip._core.checks import Floats, exact
from microslip._core.errors import InputError
from microslip._core.frozen import lock
from microslip._core.units import FORCE, QuantityError, engineering, interval_digits, to_si
from microslip._core.verdicts import Remark
from microslip._core.wording import plural, quote, shorten
from microslip.laboratory.cuts import runs_of
from microslip.readers.roles import (
    CYCLE_NUMBER,
    NEEDED,
    ROLE_KINDS,
    ROLES,
    Scale,
    by_role,
    guess,
    is_coefficient,
    scale_of,
    sign_of,
    with_unit_of_other_force,
    zero_of,
)
from microslip.readers.table_files import read_table
from microslip.readers.tables import (
    NO_UNITS,
    Named,
    RawTable,
    find,
    listed,
    name_and_unit,
    scale,
    spelt,
    understood,
)

_BY_COEFFICIENT = "by its name, times the normal load"
_MOST_LONE, _LONGEST_LONE = 0.01, 3
"""Largest fraction of rows without numbers that are interpolated, and of consecutive ones."""


class ChannelNote(Remark):
    """Note on the column from which a channel of a record was read."""

    heading: str
    """Name of the column in the file."""
    is_turned: bool
    """Whether the sign was reversed."""
    _how: str

    def __new__(cls, role: str, heading: str, words: str, is_turned: bool = False) -> Self:
        """Format ``'role: column "heading" words'``; ``is_turned`` if the sign was reversed."""
        self = super().__new__(cls, role, f'column "{heading}" {words}')
        self.heading, self.is_turned, self._how = heading, is_turned, words
        return self

    def __getnewargs__(self) -> tuple[str, str, str, bool]:  # type: ignore[override]
        return self.kind, self.heading, self._how, self.is_turned


def read_channels(path: Path, stated: Mapping[str, Any]) -> dict[str, Any]:
    """Read a file; return the arguments of :class:`Record` by name.

    ``stated`` has the arguments of :meth:`Record.read`: names of columns by role, and "sample_rate"
    [Hz], "units", "calibration", "sign", "zero" and "rows"; None where nothing is given.
    """
    table = read_table(path, "a record")
    columns = understood(table.columns)
    load = _one_load(columns, stated["normal_load"])
    by_part, how = _columns_by_part(columns, stated, skip_load=load is not None)
    if {"force", "normal_load"} <= by_part.keys():
        force, across = by_part["force"], by_part["normal_load"]
        by_part["force"] = with_unit_of_other_force(force, across)
        by_part["normal_load"] = with_unit_of_other_force(across, force)
    sign = stated["sign"]
    if isinstance(sign, int) and not isinstance(sign, bool):
        sign = {"force": sign}
    by_name = {
        "units": by_role("units", stated["units"], '{"force": "mN"}'),
        "calibration": by_role("calibration", stated["calibration"], '{"force": "12.5 N/V"}'),
        "zero": by_role("zero", stated["zero"], '{"force": "mean"}'),
        "sign": by_role("sign", sign, '{"force": -1}'),
    }
    for name, mapping in by_name.items():
        for role in mapping:
            if role not in by_part:
                raise InputError(f"`{name}`: no column is read as {role}; write `{role}=...`")
    is_ratio = how["force"] == _BY_COEFFICIENT
    if is_ratio and load is None and "normal_load" not in by_part:
        raise InputError(
            "a coefficient of friction is a force with the normal load only; write "
            '`normal_load="500 N"`'
        )
    scales = {
        role: Scale(Decimal("0.01" if column.unit else "1"), "a coefficient of friction")
        if role == "force" and is_ratio
        else scale_of(column, role, by_name["units"].get(role), by_name["calibration"].get(role))
        for role, column in by_part.items()
        if role != CYCLE_NUMBER
    }
    signs = {role: sign_of(by_name["sign"].get(role, 1), role) for role in by_part}
    arrays, first, notes = _arrays(table, by_part, stated["rows"])
    notes = [f"{shorten(path.name, 100)}: {table.kind}.", *notes]
    is_stated = any("normal_load" in by_name[name] for name in ("sign", "zero", "calibration"))
    if "normal_load" in arrays and not is_stated:
        # Some rigs count compression as negative.
        signs["normal_load"] = -1 if float(arrays["normal_load"].mean()) < 0.0 else 1
    counter = by_part.pop(CYCLE_NUMBER, None)
    texts = {}
    for role in sorted(by_part, key=lambda role: is_ratio and role == "force"):
        if is_ratio and role == "force":
            arrays[role] *= arrays["normal_load"] if load is None else load
        words = _to_si(arrays[role], role, scales[role], by_name["zero"].get(role), signs[role])
        heading = shorten(by_part[role].heading, 60)
        texts[role] = ChannelNote(role, heading, f"{how[role]}, {words}.", signs[role] < 0)
    notes += [texts[role] for role in by_part]
    if counter is not None:
        notes.append(_counted(arrays, counter, how[CYCLE_NUMBER]))
    if "time" in by_part:
        advice = "write `time=False` and `sample_rate=...`"
        check_time(arrays["time"], lambda row: table.where(row + first), advice)
    parts: dict[str, Any] = dict.fromkeys(ROLES) | {k: lock(v) for k, v in arrays.items()}
    parts["sample_rate"] = stated["sample_rate"]
    if load is not None:
        parts["normal_load"] = load
        notes.append(f"normal_load: {engineering(load, 'N')} throughout, as stated.")
    _add_values_of_file(parts, table, by_part, stated, notes)
    if "time" not in by_part and parts["sample_rate"] is None:
        notes.append("time: none; frequencies are not known.")
    read_places = {c.place for c in (*by_part.values(), counter) if c is not None}
    unread = [c.heading for c in columns if c.place not in read_places]
    if unread:
        remainder = f" and {len(unread) - 20} more" if len(unread) > 20 else ""
        headings = ", ".join(f'"{shorten(text, 40)}"' for text in unread[:20])
        notes.append(f"not read: {headings}{remainder}.")
    return parts | {"notes": tuple(notes)}


def _counted(arrays: dict[str, Floats], counter: Named, how: str) -> ChannelNote:
    values, heading = arrays[CYCLE_NUMBER], shorten(counter.heading, 60)
    if float(np.diff(values).min()) < 0.0 or float(values[0]) < 0.0:
        if how == "as stated":
            text = ChannelNote(CYCLE_NUMBER, heading, how)
            raise InputError(f"`cycle_number` must not decrease, nor be negative; {text}")
        del arrays[CYCLE_NUMBER]
        return ChannelNote(CYCLE_NUMBER, heading, f"{how}, not used, since it decreases.")
    ends = f"from {values[0]:.12g} to {values[-1]:.12g}"
    return ChannelNote(CYCLE_NUMBER, heading, f"{how}: {ends}.")


def _one_load(columns: list[Named], stated: Any) -> float | None:
    if isinstance(stated, bool) or stated is None:
        return None
    if isinstance(stated, numbers.Real):
        return float(stated)
    if isinstance(stated, str) and re.match(r"\s*[+-]?[\d.]", stated):
        if any(stated.strip() in (c.heading, c.name, c.short) for c in columns):
            return None
        try:
            return to_si(stated, FORCE, "500 N")
        except QuantityError as error:
            raise InputError(f"`normal_load`: {error}") from None
    return None


def _columns_by_part(
    columns: list[Named], stated: Mapping[str, Any], skip_load: bool
) -> tuple[dict[str, Named], dict[str, str]]:
    by_part: dict[str, Named] = {}
    how: dict[str, str] = {}
    skipped = {"normal_load"} if skip_load else set[str]()
    if stated["time"] is None and stated["sample_rate"] is not None:
        skipped.add("time")
    for role in ROLES:
        name = stated[role]
        if name is False and role not in NEEDED:
            skipped.add(role)
        elif name is not None and role not in skipped:
            column = find(columns, name, role)
            same_column = next((r for r, c in by_part.items() if c.place == column.place), None)
            if same_column:
                raise InputError(
                    f'`{role}`: column "{shorten(column.heading, 40)}" is the {same_column} already'
                )
            unit = name_and_unit(str(name))[1]
            if unit and column.heading != str(name).strip() and unit not in NO_UNITS:
                column = column._replace(unit=spelt(unit), where="as stated")
            by_part[role], how[role] = column, "as stated"
    for role in ROLES:
        if role in by_part or role in skipped:
            continue
        try:
            by_part[role], how[role] = guess(columns, role, by_part)
        except LookupError:
            ratios = [c for c in columns if is_coefficient(c) and c not in by_part.values()]
            if role == "force" and len(ratios) == 1:
                by_part[role], how[role] = ratios[0], _BY_COEFFICIENT
            elif role in NEEDED:
                raise InputError(
                    f"`{role}`: no column is named like it; {listed(columns)}; write "
                    f'`{role}="NAME"`, or "#2" for the second'
                ) from None
    return {role: by_part[role] for role in ROLES if role in by_part}, how


def _arrays(
    table: RawTable, by_part: Mapping[str, Named], rows: Any
) -> tuple[dict[str, Floats], int, list[str]]:
    """Load the requested rows of columns; return arrays by role, index of the first row, notes."""
    arrays = dict(
        zip(by_part, table.load([column.place for column in by_part.values()]), strict=True)
    )
    names = {role: f'"{shorten(column.heading, 40)}"' for role, column in by_part.items()}
    sizes = {role: values.size for role, values in arrays.items()}
    if len({*sizes.values()}) > 1:
        size_texts = ", ".join(f"{names[role]} {size}" for role, size in sizes.items())
        raise ValueError(f"columns must be of one length, got {size_texts} samples")
    first, notes = 0, []
    if rows is not None:
        if not isinstance(rows, slice) or rows.step not in (None, 1):
            raise InputError(f"wanted `rows=slice(first, end)`, got {quote(rows)}")
        first, end, _ = rows.indices(sizes["displacement"])
        arrays = {role: values[first:end].copy() for role, values in arrays.items()}
        notes.append(f"rows {first} to {max(end, first)} (without) of {sizes['displacement']}.")
    size = arrays["displacement"].size
    end_row = size
    # A sum is quick, and finite unless something is not.
    with np.errstate(all="ignore"):
        sound = all(np.isfinite(values.sum()) for values in arrays.values())
    if not sound:
        bad = np.zeros(size, dtype=bool)
        for values in arrays.values():
            bad |= ~np.isfinite(values)
        good = np.flatnonzero(~bad)
        end_row = int(good[-1]) + 1 if good.size else 0
        arrays = {role: values[:end_row].copy() for role, values in arrays.items()}
        if bad[:end_row].any():
            lengths = np.diff(runs_of(bad[:end_row]), axis=1)
            is_rare = float(bad[:end_row].mean()) <= _MOST_LONE
            if bad[0] or int(lengths.max()) > _LONGEST_LONE or not is_rare:
                _refuse_gaps(table, arrays, names, bad[:end_row], first)
            for values in arrays.values():
                lone, known = map(np.flatnonzero, (~np.isfinite(values), np.isfinite(values)))
                values[lone] = np.interp(lone, known, values[known])
            notes.append(
                f"interpolated linearly: {plural(int(bad[:end_row].sum()), 'row')} "
                f"without numbers, the first {table.where(int(bad.argmax()) + first)}."
            )
        if end_row < size:
            notes.append(f"left out: {plural(size - end_row, 'row')} without numbers at the end.")
    if end_row < 2:
        raise ValueError(f"wanted at least two rows of numbers, got {end_row}")
    return arrays, first, notes


def _refuse_gaps(
    table: RawTable, arrays: Mapping[str, Floats], names: Mapping[str, str], bad: Any, first: int
) -> None:
    row = int(np.flatnonzero(bad)[0])
    role = next(role for role, values in arrays.items() if not np.isfinite(values[row]))
    runs = runs_of(~bad)
    start, end = runs[int(np.argmax(runs[:, 1] - runs[:, 0]))] + first
    raise InputError(
        f"{table.where(row + first)}, column {names[role]}: wanted a number, got "
        f"{arrays[role][row]} ({plural(int(bad.sum()), 'row')} like this before the "
        f"end); the longest stretch of numbers is `rows=slice({start}, {end})`"
    )


def _to_si(values: Floats, role: str, taken_as: Scale, zero: Any, sign: int) -> str:
    kind = ROLE_KINDS[role]
    scale(values, taken_as.factor)
    origin, zero_note = zero_of(zero, role, values)
    if origin:
        values -= origin
    if sign < 0:
        np.negative(values, out=values)
    ends = float(values.min()), float(values.max())
    low, high = (engineering(end, kind.unit, interval_digits(*ends)) for end in ends)
    words = "sign reversed, zero as in the file" if sign < 0 else "sign and zero as in the file"
    if zero_note:
        words = f"{zero_note}, sign {'reversed' if sign < 0 else 'as in the file'}"
    return f"{taken_as.words}, {words}: from {low} to {high}"


def check_time(time: Floats, where: Callable[[int], str], advice: str) -> None:
    """Raise InputError unless the time [s] increases; ``where`` names the sample of an index."""
    steps = np.diff(time)
    if steps.min() > 0.0:
        return
    i = int(np.flatnonzero(steps <= 0.0)[0]) + 1
    rounded = f"; if it is rounded, {advice}" if steps[i - 1] == 0.0 else ""
    raise InputError(
        f"{where(i)}: `time` must increase, got {exact(time[i])} s after {exact(time[i - 1])} s"
        f"{rounded}"
    )


def _add_values_of_file(
    parts: dict[str, Any],
    table: RawTable,
    by_part: Mapping[str, Named],
    stated: Mapping[str, Any],
    notes: list[str],
) -> None:
    if parts["sample_rate"] is not None:
        notes.append(f"sample_rate: {parts['sample_rate']:g} Hz, as stated.")
    elif "time" not in by_part:
        rates = dict.fromkeys(table.columns[by_part[role].place].rate for role in NEEDED)
        if len(rates) > 1:
            rate_texts = " and ".join(f"{rate:g} Hz" if rate else "none" for rate in rates)
            raise ValueError(f"displacement and force differ in sample rate, got {rate_texts}")
        (rate,) = rates
        where = "their channels"
        if rate is None and (value := table.stated.get("sample_rate")):
            rate, where = value.value, value.where
        if rate is not None:
            parts["sample_rate"] = rate
            notes.append(f'sample_rate: {rate:g} Hz by "{where}" of the file.')
    load = table.stated.get("normal_load")
    if load and parts["normal_load"] is None and stated["normal_load"] is None:
        parts["normal_load"] = load.value
        notes.append(f'normal_load: {load.value:g} N by "{load.where}" of the file.')
