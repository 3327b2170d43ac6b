"""Record of a test rig in SI units, with the source of each channel."""

from __future__ import annotations

import functools
import numbers
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import Any, TypeVar
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core.checks import Floats, positive, show, without_unit
from microslip._core.checks import record as checked
from microslip._core.errors import InputError
from microslip._core.files import atomic_file
from microslip._core.frozen import Locked, assign, lock
from microslip._core.wording import one_line
from microslip.figures.plot import Plot
from microslip.figures.plottable import Plottable
from microslip.laboratory.reading import check_time, read_channels
from microslip.readers.files import POINTS, reading

Answer = TypeVar("Answer")

CHANNEL_UNITS = {
    "time": "s",
    "displacement": "m",
    "force": "N",
    "normal_load": "N",
    "cycle_number": "-",
}


@dataclass(frozen=True, eq=False, repr=False)
class Record(Locked, Plottable):
    """Displacement and force of a contact at each sample, as measured on a test rig.

    The force T is positive if it acts in the direction of positive displacement, so that the loops
    of (19.29) in chapter 19 run clockwise and dissipate energy; the normal load is positive in
    compression.

    Parameters
    ----------
    displacement : array_like
        Displacement [m], one-dimensional, at least two samples.
    force : array_like
        Tangential force [N], one for each displacement.
    normal_load : array_like or float, optional
        Normal load [N], positive in compression: one for each sample, or a number above zero.
    time : array_like, optional
        Time [s] of each sample, strictly increasing.
    sample_rate : float, optional
        Sampling rate [Hz], as an alternative to `time`.
    cycle_number : array_like, optional
        Cycle counter of the rig [-], one for each sample, never decreasing. It identifies the
        cycles if only some were logged.
    name : str
        Name of the record in messages and figures.
    notes : tuple of str
        Notes on the source: file, columns, units, signs, zeros.
    """

    displacement: NDArray[np.float64]
    force: NDArray[np.float64]
    normal_load: NDArray[np.float64] | float | None
    time: NDArray[np.float64] | None
    sample_rate: float | None
    cycle_number: NDArray[np.float64] | None
    name: str
    notes: tuple[str, ...]

    def __init__(
        self,
        displacement: ArrayLike,
        force: ArrayLike,
        normal_load: ArrayLike | None = None,
        time: ArrayLike | None = None,
        sample_rate: float | None = None,
        *,
        cycle_number: ArrayLike | None = None,
        name: str = "record",
        notes: tuple[str, ...] = (),
    ) -> None:
        arrays = {"displacement": _locked_series("displacement", displacement)}
        size = arrays["displacement"].size
        if size < 2:
            raise InputError(f"`displacement` must hold at least two samples, got {size}")
        load: Any = None
        normal_load = without_unit("normal_load", normal_load, "N")
        alone = isinstance(normal_load, np.ndarray) and normal_load.ndim == 0
        if alone or isinstance(normal_load, (numbers.Real, str)):
            load = positive("normal_load", normal_load, "N", 100.0)
        elif normal_load is not None:
            arrays["normal_load"] = load = _locked_series("normal_load", normal_load)
        for key, raw_values in (
            ("force", force),
            ("time", time),
            ("cycle_number", cycle_number),
        ):
            if raw_values is not None or key == "force":
                arrays[key] = _locked_series(key, raw_values)
        for key, values in arrays.items():
            if values.size != size:
                raise InputError(
                    f"{key} must hold a value for each of the {size} displacements, "
                    f"got {values.size}"
                )
        if "normal_load" in arrays and (mean := float(load.mean())) < 0.0:
            raise InputError(
                f"`normal_load` must be positive in compression [N], got {mean:g} N on average; "
                "reverse its sign"
            )
        if time is not None:
            if sample_rate is not None:
                raise InputError("`time` and `sample_rate` are redundant; give one of them")
            check_time(arrays["time"], lambda i: f"sample {i}", "give `sample_rate` instead")
        counter = arrays.get("cycle_number")
        if counter is not None and (counter[0] < 0.0 or float(np.diff(counter).min()) < 0.0):
            raise InputError(
                "`cycle_number` must not decrease, nor be negative; give the rig's counter"
            )
        if not isinstance(name, str):
            raise InputError(f"`name` must be text, got {show(name)}")
        if isinstance(notes, str) or not all(isinstance(note, str) for note in notes):
            raise InputError(f"`notes` must be a tuple of texts, got {show(notes)}")
        fields: dict[str, Any] = dict.fromkeys(CHANNEL_UNITS) | arrays
        fields |= {"normal_load": load, "name": name, "notes": tuple(notes)}
        fields["sample_rate"] = _frequency(sample_rate)
        assign(self, **fields)

    @property
    def channels(self) -> dict[str, Floats]:
        """Values of each sample by quantity, in SI units."""
        values = ((key, getattr(self, key)) for key in CHANNEL_UNITS)
        return {key: samples for key, samples in values if isinstance(samples, np.ndarray)}

    def _taken(self, rows: Any, **changed: Any) -> Record:
        """Return a record of some samples (a slice, mask or indices), with other changes."""
        channels = {key: values[rows] for key, values in self.channels.items()}
        return replace(self, **{**channels, **changed})

    @property
    def seconds(self) -> Floats | None:
        """Time of each sample [s], from 0 if only the sampling rate is known; None without both."""
        if self.time is not None or self.sample_rate is None:
            return self.time
        return np.arange(float(len(self))) / self.sample_rate

    def _figure(self) -> Plot:
        from microslip.laboratory.figures import record_figure

        return record_figure(self)

    def __len__(self) -> int:
        return int(self.displacement.size)

    def __repr__(self) -> str:
        parts = [f"{self.name[:60]!r}", f"{len(self)} samples"]
        if self.sample_rate is not None:
            parts.append(f"sample_rate={self.sample_rate:g}")
        return f"Record({', '.join(parts)})"

    @classmethod
    def read(
        cls,
        path: str | os.PathLike[str],
        *,
        displacement: str | None = None,
        force: str | None = None,
        normal_load: str | float | None = None,
        time: str | bool | None = None,
        cycle_number: str | bool | None = None,
        sample_rate: float | None = None,
        units: Mapping[str, str] | None = None,
        calibration: Mapping[str, str | float] | None = None,
        sign: int | Mapping[str, int] | None = None,
        zero: Mapping[str, str | float] | None = None,
        rows: slice | None = None,
        name: str | None = None,
        limit: int = POINTS,
    ) -> Record:
        """Read a record from text (CSV, TSV, TXT), Excel, MATLAB, TDMS, HDF5 or NumPy files.

        The format is detected from the first bytes. Columns and units that are not given are
        detected from their names and units; ambiguous ones raise an error. `notes` of the record
        state from which column and unit each channel was read. The file is not changed.

        Parameters
        ----------
        path : str or path
            File to read.
        displacement, force : str, optional
            Names of the columns, with or without their unit, or "#2" for the second column.
        cycle_number : str or False, optional
            Column of the rig's cycle counter; False for none.
        normal_load : str or float, optional
            Name of the column, or a load [N] for all samples, as number or text ("500 N"); False
            for none.
        time : str or False, optional
            Name of the column; False for none.
        sample_rate : float, optional
            Sampling rate [Hz], as an alternative to a column of time.
        units : mapping, optional
            Units of columns by quantity, such as ``{"force": "mN"}``. They take precedence over
            those in the file.
        calibration : mapping, optional
            Factors of sensors by quantity, such as ``{"force": "12.5 N/V"}``; a plain number is
            [m], [N] or [s] per unit of the numbers in the file.
        sign : int or mapping, optional
            -1 reverses the sign of the force; a mapping, such as ``{"displacement": -1}``, that of
            other quantities.
        zero : mapping, optional
            Value to subtract by quantity, before the sign is applied: a number [m], [N] or [s],
            text ("0.3 N"), or "mean", "middle" (of minimum and maximum) or "first".
        rows : slice, optional
            Rows to read, counted from 0.
        name : str, optional
            Name of the record; by default the name of the file.
        limit : int
            Largest number of values in the file's columns, checked before they are read.

        Returns
        -------
        Record
            One-dimensional arrays in SI units. Rows at the end without numbers are left out.
        """
        path = checked_path(path)
        stated: dict[str, Any] = {
            "displacement": displacement,
            "force": force,
            "normal_load": normal_load,
            "time": time,
            "cycle_number": cycle_number,
            "units": units,
            "sign": sign,
            "sample_rate": _frequency(sample_rate),
            "calibration": calibration,
            "zero": zero,
            "rows": rows,
        }
        with reading(path, "a record", limit, path_text(path)):
            parts = read_channels(path, stated)
            return cls(**parts, name=path.stem if name is None else name)

    def to_csv(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
        """Write the record as CSV in SI units; :meth:`read` returns exactly the same numbers.

        Parameters
        ----------
        path : str or path
            File to write.
        overwrite : bool
            Whether an existing file may be replaced.
        """
        target = checked_path(path)
        columns = {key: values.tolist() for key, values in self.channels.items()}
        numbers = {"sample_rate": "Hz"}
        if isinstance(self.normal_load, float):
            numbers["normal_load"] = "N"
        head = [
            f"# {key} = {value!r} {unit}\n"
            for key, unit in numbers.items()
            if (value := getattr(self, key)) is not None
        ]
        head += [f"# note: {one_line(note)}\n" for note in self.notes]
        head.append(",".join(f"{key} [{CHANNEL_UNITS[key]}]" for key in columns) + "\n")
        rows = zip(*(map(repr, values) for values in columns.values()), strict=True)
        lines = chain(head, (",".join(row) + "\n" for row in rows))
        with (
            atomic_file(target, overwrite) as stage,
            stage.open("w", encoding="utf-8", newline="") as file,
        ):
            file.writelines(lines)


def once_a_record(function: Callable[[Record], Answer]) -> Callable[[Record], Answer]:
    """Cache the result of a function of a record for as long as the record exists."""
    answers: WeakKeyDictionary[Record, Answer] = WeakKeyDictionary()

    @functools.wraps(function)
    def answer(record: Record) -> Answer:
        if record not in answers:
            answers[record] = function(record)
        return answers[record]

    return answer


def _locked_series(key: str, raw_values: Any) -> Floats:
    values = checked(key, raw_values, CHANNEL_UNITS[key].strip("-"))
    # Readers hand over arrays that are locked already; a long record is not copied again.
    is_locked = values.base is None and values.ndim == 1 and not values.flags.writeable
    return values if is_locked and values is raw_values else lock(np.array(values).reshape(-1))


def _frequency(raw_value: Any) -> float | None:
    return None if raw_value is None else positive("sample_rate", raw_value, "Hz", 1000.0)


def checked_path(path: Any) -> Path:
    """Validate a file name and return it as a path."""
    if not isinstance(path, (str, os.PathLike)):
        raise InputError(f"`path` must be the name of a file, got {show(path)}")
    return Path(path)


def path_text(path: str | os.PathLike[str]) -> str:
    """Format a path for a message: one line, the last 200 characters."""
    return one_line(os.fspath(path))[-200:]
