"""Frequency and damping of a mode against amplitude, as a test of a structure gives them."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import positive, record, show, whole_number
from microslip._core.frozen import Locked, assign, lock
from microslip.errors import InputError


@dataclass(frozen=True, eq=False)
class ModalTest(Locked):
    """Frequency and damping of one mode against amplitude, from a ring-down or a stepped sine.

    Parameters
    ----------
    amplitude : array_like
        Displacement amplitudes at the sensor [m], above zero, one-dimensional.
    frequency : array_like
        Frequencies [Hz], of the same shape.
    damping_ratio : array_like
        Damping ratios [-], of the same shape.
    mode : int
        Which mode of the structure, from 0.
    sensor : str
        Name of the sensor in the reduced joint.
    frequency_error, damping_error : float
        Standard uncertainties relative to the values [-]: those of the test and of the model.
    name : str
        What it is called in reports.
    notes : tuple of str
        How it was read.

    Notes
    -----
    A finite-element model is seldom better than 0.3 % in frequency, damping in tests scatters by
    5 % and more from assembly to assembly. Porter and Brake (2023, DOI 10.1016/j.ymssp.2023.110210)
    hold a model of a bolted beam to such tests.
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

    def __post_init__(self) -> None:
        for name, unit in (("amplitude", "m"), ("frequency", "Hz"), ("damping_ratio", "")):
            values = np.atleast_1d(record(name, getattr(self, name))).copy()
            for value in values:
                positive(name, float(value), unit)
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
        """Read a test from the ring-down after a hammer's blow or a release.

        Parameters
        ----------
        time : array_like
            Times [s] in even steps, one-dimensional.
        signal : array_like
            What the sensor showed [m, m/s or m/s^2], of the same shape.
        points : int
            Amplitudes to keep, about evenly on a log axis; each is a mean over its neighbours.
        quantity : {"displacement", "velocity", "acceleration"}
            What the signal is; amplitudes are those of the displacement in any case.
        band : (float, float), optional
            Frequencies [Hz] between which the mode lies, where others ring with it: a Butterworth
            filter of fourth order, forth and back.
        **attributes : object
            ``mode``, ``sensor``, ``frequency_error``, ``damping_error``, ``name``, ``notes``.

        Returns
        -------
        ModalTest
            Frequency and damping against amplitude.
        """
        from microslip.structures.modal_readings import ring_down

        return cls(*ring_down(time, signal, points, quantity, band), **attributes)

    @classmethod
    def from_stepped_sine(
        cls,
        frequency: ArrayLike,
        amplitude: ArrayLike,
        phase: ArrayLike,
        force: ArrayLike = 1.0,
        *,
        points: int = 12,
        quantity: str = "displacement",
        **attributes: Any,
    ) -> ModalTest:
        """Read a test from settled answers to a sine, stepped through a resonance.

        Parameters
        ----------
        frequency : array_like
            Frequencies of the sine [Hz], one-dimensional.
        amplitude : array_like
            Amplitudes at the sensor [m, m/s or m/s^2], of the same shape.
        phase : array_like
            Phase of the sensor's signal ahead of the force [rad], of the same shape.
        force : array_like
            Amplitudes of the force [N], of the same shape or one for all.
        points, quantity, **attributes : optional
            As for :meth:`from_ring_down`.

        Returns
        -------
        ModalTest
            Frequency and damping against amplitude.

        Notes
        -----
        One mode of frequency omega(a) and damping zeta(a), driven by the force F at W, obeys
        (omega^2 - W^2 + 2 i zeta omega W) a exp(-i psi) = p F. That omega depends on the
        amplitude alone, wherever on the two sides of the resonance it was met, tells p by linear
        least squares; each value then tells its own omega and zeta. After Szemplinska-Stupnicka
        (1979), DOI 10.1016/S0022-460X(79)80003-1; other modes are left out.
        """
        from microslip.structures.modal_readings import stepped_sine

        return cls(
            *stepped_sine(frequency, amplitude, phase, force, points, quantity), **attributes
        )

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
        """Read a test from a file: a curve, a ring-down or a stepped sine, by its columns.

        Parameters
        ----------
        path : str or path
            CSV or other text, MAT, TDMS, HDF5 or NumPy's; units in the headers.
        band, points : optional
            As for :meth:`from_ring_down` [Hz]; a band is of a ring-down alone.
        columns : mapping, optional
            Names of columns that are not found by themselves, by what they are: "amplitude",
            "frequency", "damping_ratio"; "time", "displacement", "velocity", "acceleration";
            "phase", "force".
        **attributes : object
            ``mode``, ``sensor``, ``frequency_error`` and ``damping_error``.

        Returns
        -------
        ModalTest
            With notes that say how it was read.
        """
        from microslip.structures.modal_test_files import read

        name, notes, values = read(path, band, points, columns or {})
        return cls(*values, **{"name": name, "notes": notes, **attributes})
