"""Test of a mode: frequency and damping against amplitude."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, positive, positives, record, show, whole_number
from microslip._core.errors import InputError
from microslip._core.frozen import Locked, assign, lock
from microslip._core.units import (
    ACCELERATION,
    FREQUENCY,
    LENGTH,
    RATIO,
    TIME,
    VELOCITY,
    factor_of,
)
from microslip._core.wording import did_you_mean, quoted, shorten
from microslip.readers.files import reading
from microslip.readers.roles import is_of_loop
from microslip.readers.table_files import read_table
from microslip.readers.tables import Named, RawTable, find, fits, understood
from microslip.structures.modal_curve import ModalCurve
from microslip.structures.modal_readings import ModeReadings, read_ring_down
from microslip.structures.periodic_motion import POWERS

MeasuredMotion = Literal["steady", "decay"]


@dataclass(frozen=True, eq=False)
class ModalTest(Locked):
    """Frequency and damping of one mode against amplitude, such as from a ring-down.

    Parameters
    ----------
    amplitude : array_like
        Displacement amplitudes at the sensor [m], above zero, one-dimensional.
    frequency : array_like
        Frequencies [Hz], of the same shape.
    damping_ratio : array_like
        Damping ratios [-], of the same shape.
    mode : int
        Index of the mode of the structure, from 0.
    sensor : str
        Name of the sensor in the reduced joint.
    frequency_error, damping_error : float
        Relative standard uncertainties of frequency and damping, of test and model together [-].
    name : str
        Name in reports.
    notes : tuple of str
        Notes on how the file was read.
    motion : {"steady", "decay"}
        Measured motion: steady responses, or a free decay as after a hammer impact, whose damping
        ratios differ from those of steady motion (:attr:`ModalCurve.decay_damping_ratio`).

    Notes
    -----
    A finite-element model is seldom better than 0.3 % in frequency, and damping in tests scatters
    by 5 % and more from assembly to assembly. Porter and Brake (2023, DOI
    10.1016/j.ymssp.2023.110210) compare a model of a bolted beam with such tests.
    """

    amplitude: Any
    frequency: Any
    damping_ratio: Any
    mode: int = 0
    sensor: str = "sensor"
    frequency_error: float = 0.003
    damping_error: float = 0.05
    name: str = "test"
    notes: tuple[str, ...] = ()
    motion: MeasuredMotion = "steady"

    def __post_init__(self) -> None:
        for name, unit in (("amplitude", "m"), ("frequency", "Hz"), ("damping_ratio", "")):
            values = np.atleast_1d(positives(name, record(name, getattr(self, name)), unit)).copy()
            assign(self, **{name: lock(values)})
        if not self.amplitude.shape == self.frequency.shape == self.damping_ratio.shape:
            raise InputError(
                "amplitude, frequency and damping_ratio must be of one length, got "
                f"{len(self.amplitude)}, {len(self.frequency)} and {len(self.damping_ratio)}"
            )
        for name in ("frequency_error", "damping_error"):
            assign(self, **{name: positive(name, getattr(self, name), "", 0.05)})
        whole_number("mode", self.mode, 0, 1000)
        if not isinstance(self.name, str):
            raise InputError(f"`name` must be text, got {show(self.name)}")
        if self.motion not in get_args(MeasuredMotion):
            raise InputError(
                f"motion must be {quoted(get_args(MeasuredMotion))}, got {show(self.motion)}"
            )

    def damping_of(self, curve: ModalCurve) -> Floats:
        """Return the damping ratio of a predicted mode as measured by this kind of test [-].

        Parameters
        ----------
        curve : ModalCurve
            Predicted mode.

        Returns
        -------
        ndarray
            Damping ratios at the amplitudes of the curve, those of a decay if the test is one.
        """
        if not isinstance(curve, ModalCurve):
            raise InputError(f"`curve` must be a ModalCurve of a mode, got {show(curve)}")
        if self.motion == "steady":
            return curve.damping_ratio
        decay = curve.decay_damping_ratio
        return np.where(np.isfinite(decay), decay, curve.damping_ratio)

    @classmethod
    def from_ring_down(
        cls,
        time: ArrayLike,
        signal: ArrayLike,
        *,
        points: int = 12,
        quantity: str = "displacement",
        band: tuple[float, float] | None = None,
        **attributes: Any,
    ) -> ModalTest:
        """Read a test from the ring-down after a hammer impact or a release.

        Parameters
        ----------
        time : array_like
            Evenly spaced times [s], one-dimensional.
        signal : array_like
            Sensor signal [m, m/s or m/s^2], of the same shape.
        points : int
            Number of amplitudes to return, about evenly spaced in their logarithm; each is a mean
            over several cycles.
        quantity : {"displacement", "velocity", "acceleration"}
            Quantity of the signal; amplitudes are those of the displacement in any case.
        band : (float, float), optional
            Pass band [Hz] around the mode, needed if other modes ring with it: zero-phase
            Butterworth filter of fourth order.
        **attributes : object
            Parameters of the class: ``mode``, ``sensor``, ``frequency_error`` and so on.

        Returns
        -------
        ModalTest
            Frequency and damping against amplitude.
        """
        values = read_ring_down(time, signal, points, quantity, band)
        return cls(*values, **{"motion": "decay", **attributes})

    @classmethod
    def read(
        cls,
        path: str | os.PathLike[str],
        *,
        band: tuple[float, float] | None = None,
        points: int = 12,
        columns: dict[str, str] | None = None,
        **attributes: Any,
    ) -> ModalTest:
        """Read a test from a file: a curve or a ring-down, by its columns.

        Parameters
        ----------
        path : str or path
            CSV or other text, MAT, TDMS, HDF5 or NumPy's; units in the headers.
        band, points : optional
            As for :meth:`from_ring_down` [Hz]; ``band`` is only for a ring-down.
        columns : mapping, optional
            Names of columns that are not recognised, by meaning: "amplitude",
            "frequency", "damping_ratio"; "time", "displacement", "velocity", "acceleration".
        **attributes : object
            ``mode``, ``sensor``, ``frequency_error``, ``damping_error``, and ``motion`` of a curve
            that was read from decays.

        Returns
        -------
        ModalTest
            Test with notes on how it was read.
        """
        try:
            place = Path(path)
        except TypeError:
            raise InputError(f"`path` must be a path, got {show(path)}") from None
        name, stated, accepted = shorten(place.name, 100), columns or {}, (*_COLUMNS, "amplitude")
        for role in stated:
            if role not in accepted:
                hint = did_you_mean(str(role), accepted)
                raise InputError(
                    f"columns must be among {quoted(accepted)}, got {show(role)}{hint}"
                )
        with reading(place, "a test of a mode", called=name):
            table = read_table(place, "a modal test")
            there = understood(table.columns)
            roles = _roles(there, stated)
            kind = _kind(roles, [] if stated else there)
            if kind is None:
                have = quoted(shorten(c.heading, 40) for c in there)
                raise InputError(
                    "wanted columns of amplitude, frequency and damping ratio, or of time and "
                    "displacement, velocity or acceleration, with units such as "
                    f'"amplitude [um]"; got {have}'
                )
            if kind != "ring-down" and band is not None:
                raise InputError(f"`band` is for a ring-down, this is a {kind}")
            values = _values(kind, table, roles, band, points)
        used = ", ".join(f'{role} "{shorten(c.heading, 40)}"' for role, c in roles.items())
        notes = [f"{name}: {kind}, {len(values[0])} amplitudes; {used}."]
        if band is not None:
            notes.append(f"filtered to {band[0]:g} … {band[1]:g} Hz, without a shift in time.")
        motion = "decay" if kind == "ring-down" else "steady"
        return cls(*values, **{"name": name, "notes": tuple(notes), "motion": motion, **attributes})


_COLUMNS = {
    "time": (TIME, r"time|t"),
    "frequency": (FREQUENCY, r"(natural |excitation |drive )?freq(uency)?|f"),
    "damping_ratio": (RATIO, r"damping( ratio)?|zeta|ζ|d"),
    "displacement": (LENGTH, r"disp(l|lacement)?( amplitude)?|x"),
    "velocity": (VELOCITY, r"vel(ocity)?( amplitude)?|v"),
    "acceleration": (ACCELERATION, r"acc(el|eleration)?( amplitude)?"),
}
"""Quantities of columns, and their usual names."""
_AMPLITUDE = r"(response|amp|sensor).*|a"
"""Names of an amplitude of the displacement, velocity or acceleration, identified by its unit."""


def modal_kind(path: str | os.PathLike[str]) -> str | None:
    """Return the kind of a modal test in a file: curve or ring-down; else None."""
    try:
        there = understood(read_table(Path(path), "a modal test").columns)
        return _kind(_roles(there, {}), there)
    except (InputError, ValueError, OSError):
        return None  # whoever reads it says what is wrong with it


def _roles(columns: list[Named], stated: Mapping[str, str]) -> dict[str, Named]:
    roles = {role: find(columns, text, role) for role, text in stated.items()}
    for role, (kind, words) in _COLUMNS.items():
        for column in columns:
            called = column.name.casefold().replace("_", " ").strip()
            if role in roles or column in roles.values() or not re.fullmatch(words, called):
                continue
            if column.unit is None or role == "damping_ratio" or fits(_unit(column, role), kind):
                roles[role] = column
    amplitudes = [c for c in columns if re.fullmatch(_AMPLITUDE, c.name.casefold())]
    usual = None
    if "amplitude" in roles:
        amplitudes, usual = [roles.pop("amplitude")], "displacement"
    for column in amplitudes:
        fitting = (role for role in POWERS if fits(_unit(column, role), _COLUMNS[role][0]))
        quantity = next(fitting, usual)
        if quantity is not None and quantity not in roles and column not in roles.values():
            roles[quantity] = column
    return roles


def _unit(column: Named, role: str) -> str | None:
    of_gravity = role == "acceleration" and column.unit in ("g", "gn", "g_n")
    return "g_0" if of_gravity else column.unit


def _kind(roles: Mapping[str, Named], columns: Sequence[Named]) -> str | None:
    moved = any(role in roles for role in POWERS)
    if {"frequency", "damping_ratio"} <= set(roles) and moved:
        return "curve"
    # A force beside a displacement is a loop of a joint, whatever it is called; a hammer's has an
    # accelerometer beside it.
    of_loop = "displacement" in roles and any(map(is_of_loop, columns))
    if "time" in roles and moved and not of_loop:
        return "ring-down"
    return None


def _values(
    kind: str, table: RawTable, roles: dict[str, Named], band: Any, points: Any
) -> ModeReadings:
    signals = [role for role in POWERS if role in roles]
    if len(signals) > 1:
        raise InputError(
            f"wanted one signal of the sensor, got {quoted(signals, 'and')}; take the others out"
        )
    (quantity,) = signals
    signal = _column(table, roles, quantity)
    if kind == "ring-down":
        return read_ring_down(_column(table, roles, "time"), signal, points, quantity, band)
    frequency = _column(table, roles, "frequency")
    amplitude = signal / (2.0 * math.pi * frequency) ** POWERS[quantity]
    return amplitude, frequency, _column(table, roles, "damping_ratio")


def _column(table: RawTable, roles: Mapping[str, Named], role: str) -> Floats:
    column, kind = roles[role], _COLUMNS[role][0]
    (values,) = table.load([column.place])
    heading = f'column "{shorten(column.heading, 40)}"'
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        raise InputError(
            f"{table.where(int(bad[0]))}, {heading}: wanted a number, got {values[bad[0]]}"
        )
    unit = _unit(column, role)
    if role == "damping_ratio":
        percent = unit is not None and unit.lower() in ("%", "percent")
        return np.asarray(values * 0.01 if percent else values)
    if unit is None:
        raise InputError(
            f"{heading}: no unit; write it in the header, such as "
            f'"{shorten(column.heading, 40)} [{kind.usual[0]}]"'
        )
    where = f'{heading}: wanted a unit such as "{kind.usual[0]}", got '
    return np.asarray(values * float(factor_of(unit, kind, where + show(column.unit))))
