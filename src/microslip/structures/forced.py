"""Forced response by harmonic balance, followed past turning points."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core.checks import Floats, floats, positive, show
from microslip._core.errors import InputError
from microslip._core.files import atomic_file
from microslip._core.frozen import LockedArrays
from microslip.figures.plot import Plot
from microslip.figures.plottable import PlottableAtSensor
from microslip.structures.balance import Balance
from microslip.structures.forced_path import Drive, follow
from microslip.structures.modal_model import ModalModel, ModalResult
from microslip.structures.periodic_motion import (
    HarmonicBasis,
    MotionQuantity,
    harmonic_basis,
    power_of,
)
from microslip.structures.static import AtRest, solver_method

_OVER_FORCE = {"displacement": "m/N", "velocity": "m/(N s)", "acceleration": "m/(N s^2)"}
"""Unit of the frequency response, quantity over force."""


@dataclass(frozen=True, eq=False, repr=False)
class FrequencyResponse(LockedArrays):
    """Response of a sensor over the harmonic force, at one force amplitude.

    Result of :meth:`microslip.ForcedResponse.frequency_response`. With friction the ratio depends
    on the force amplitude. On harmonic balance see Krack and Gross (2019), DOI
    10.1007/978-3-030-14023-6.
    """

    frequency: Floats
    """Frequencies [Hz], increasing."""
    value: NDArray[np.complex128]
    """Complex amplitude of the fundamental harmonic over F, for the force Re(F exp(i w t))."""
    quantity: str
    """``displacement``, ``velocity`` or ``acceleration``: [m/N], [m/(N s)] or [m/(N s^2)]."""
    force: float
    """Amplitude of the force [N]."""

    @property
    def unit(self) -> str:
        """Unit of :attr:`value`."""
        return _OVER_FORCE[self.quantity]

    def save(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
        """Write the response as a CSV table.

        Parameters
        ----------
        path : str or path
            A file ending in ``.csv``.
        overwrite : bool, optional
            Replace an existing file.
        """
        file = Path(path)
        if file.suffix.lower() != ".csv":
            raise InputError(f"`path` must end in .csv, got {show(file.name)}")
        heads = ["force_amplitude [N]", "frequency [Hz]", f"frf_real [{self.unit}]"]
        heads.append(f"frf_imag [{self.unit}]")
        columns = np.full(self.frequency.size, self.force), self.frequency
        rows = np.column_stack([*columns, self.value.real, self.value.imag]).tolist()
        with atomic_file(file, overwrite) as stage:
            lines = [heads, *(map(repr, row) for row in rows)]
            stage.write_text("".join(",".join(line) + "\n" for line in lines), encoding="utf-8")

    def __repr__(self) -> str:
        f = self.frequency
        return (
            f"FrequencyResponse({f.size} points, {f[0]:.5g} to {f[-1]:.5g} Hz, {self.quantity} "
            f"over {self.force:g} N)"
        )


@dataclass(frozen=True, eq=False, repr=False)
class ForcedResponse(ModalResult, PlottableAtSensor):
    """Periodic motions along frequencies, the result of ``structure.forced_response(...)``.

    By harmonic balance and arc-length continuation, as in Krack and Gross (2019),
    DOI 10.1007/978-3-030-14023-6. Where the response folds over, a frequency has several motions.
    """

    frequency: Floats
    """Frequencies along the path [Hz]; they turn back where the response folds."""
    harmonics: tuple[int, ...]
    """Orders of the harmonics; 0 is the mean."""
    requested: NDArray[np.bool_]
    """True for points at a requested frequency."""
    stable: NDArray[np.bool_]
    """Whether each motion is stable; motions between turning points of the path are unstable.

    Determined from the sign of the determinant of the harmonic-balance Jacobian. It detects slow
    growth, but no instabilities at half the frequency of the motion or at a second frequency
    (Krack and Gross 2019, DOI 10.1007/978-3-030-14023-6).
    """
    iterations: int
    """Total number of Newton iterations."""
    message: str
    """Outcome: where and why the solver stopped, and what to try."""
    _coordinates: NDArray[np.complex128]
    """Modal amplitudes of each harmonic (points, modes, harmonics)."""
    _shapes: Floats
    """Shapes of the modes and of free motions (n, modes)."""

    @property
    def displacement(self) -> NDArray[np.complex128]:
        """Complex amplitudes x of each harmonic h, shape (points, n, harmonics) [m].

        The motion is the sum of Re(x exp(i h omega t)) over the harmonics. Computed at each access,
        since the array of a large structure is large.
        """
        return np.asarray(self._shapes @ self._coordinates)

    def _fundamental(self, at: ArrayLike) -> NDArray[np.complex128]:
        """Return the complex amplitudes [m] of the fundamental harmonic at a sensor, (points,)."""
        return np.asarray(self._coordinates[:, :, self.harmonics.index(1)] @ self._at(at))

    def _sizes(self, columns: Floats) -> Floats:
        relative = (columns.T @ self._shapes) @ self._coordinates
        return np.asarray(np.abs(relative).sum(axis=2))

    @property
    def turning_points(self) -> NDArray[np.int64]:
        """Indices of the points at which the frequency begins to increase or to decrease."""
        way = np.sign(np.diff(self.frequency))
        return np.asarray(1 + np.flatnonzero(way[1:] != way[:-1]))

    def amplitude(self, at: ArrayLike) -> Floats:
        """Return the displacement amplitude of the fundamental harmonic at a sensor.

        Parameters
        ----------
        at : array_like
            Direction of the sensor, shape (n,).

        Returns
        -------
        ndarray
            Amplitudes [m], one per point.
        """
        return np.asarray(np.abs(self._fundamental(at)))

    def frequency_response(
        self, at: ArrayLike, force: float, *, quantity: MotionQuantity = "displacement"
    ) -> FrequencyResponse:
        """Return the fundamental at a sensor over the force, as measured by a slow sweep.

        Where the response folds over, a sweep jumps: the motions that it passes over, and unstable
        motions, are left out.

        Parameters
        ----------
        at : array_like
            Direction of the sensor, shape (n,).
        force : float
            Amplitude of the force [N], by which the motion is divided, above zero.
        quantity : {"displacement", "velocity", "acceleration"}, optional
            Quantity that the sensor measures.

        Returns
        -------
        FrequencyResponse
            Frequencies [Hz] and complex values; ``save`` writes CSV.
        """
        motion = self._fundamental(at)
        amplitude, power = positive("force", force), power_of(quantity)
        if np.count_nonzero(self.stable) < 2:
            raise InputError(f"a frequency response needs two stable points; {self.message}")
        way = 1.0 if self.frequency[1] > self.frequency[0] else -1.0
        furthest = np.maximum.accumulate(way * self.frequency)
        ahead = np.append(True, furthest[1:] > furthest[:-1])
        swept = np.flatnonzero(ahead & self.stable)[:: int(way)]
        frequency = self.frequency[swept]
        value = np.asarray(motion[swept] * (2j * math.pi * frequency) ** power / amplitude, complex)
        return FrequencyResponse(frequency, value, quantity, amplitude)

    def _figure(self, at: ArrayLike | None) -> Plot:
        from microslip.structures.figures import response_figure

        return response_figure(self, None if at is None else floats("at", at))

    def __repr__(self) -> str:
        return f"ForcedResponse({self.frequency.size} points, {self.message})"


def checked_frequencies(frequencies: ArrayLike) -> Floats:
    """Validate the frequencies [Hz] of a response."""
    targets = floats("frequencies", frequencies, "Hz")
    ways = np.sign(np.diff(targets.reshape(-1)))
    if targets.ndim != 1 or targets.size < 2 or targets.min() <= 0.0 or abs(ways.sum()) < ways.size:
        raise InputError(
            "frequencies must be at least two above zero that increase or decrease [Hz], such as "
            "np.linspace(150.0, 200.0, 101)"
        )
    return targets


@solver_method
def forced_response(
    rest: AtRest,
    force: ArrayLike,
    frequencies: ArrayLike,
    *,
    harmonics: Sequence[int] | None = None,
    samples: int = 64,
) -> ForcedResponse:
    """Compute periodic motions under a harmonic force along frequencies.

    Parameters
    ----------
    force : array_like
        Amplitudes F (n,) [N] of the force Re(F exp(i omega t)), complex for other phases.
    frequencies : array_like
        Frequencies [Hz], one-dimensional, in increasing or decreasing order; the solver adds points
        between them.
    harmonics, samples : optional
        As for :meth:`modes`.

    Returns
    -------
    ForcedResponse
        Frequencies along the path, amplitudes of each harmonic, turning points.

    Notes
    -----
    Harmonic balance with arc-length continuation, which passes the turning points where the
    response folds over (Krack and Gross 2019, DOI 10.1007/978-3-030-14023-6). Damping is that of
    the joints and of C. :meth:`ModalCurve.forced_response` gives the response near one resonance
    in closed form.
    """
    model = rest._elastic
    push, size = complex_amplitudes("force", force), model.shapes.shape[0]
    if push.shape != (size,):
        raise InputError(f"force must have the shape ({size},), got {push.shape}")
    targets = checked_frequencies(frequencies)
    basis = harmonic_basis(rest._orders(harmonics), samples)
    forces = coefficients(model.shapes.T @ push, basis)
    line = line_of(model, forces, targets)
    if not np.any(line):
        raise InputError("force must excite an elastic mode, not only rigid motion")
    balance = Balance(model, model.joints(line), basis)
    drive = Drive(balance, {0: forces}, {}, -model.free.T @ push)
    return ForcedResponse(**follow(drive, targets)[1])


def complex_amplitudes(name: str, value: Any) -> NDArray[np.complex128]:
    """Validate real or complex amplitudes and return them as a complex array."""
    try:
        array = np.asarray(value)
        parts = np.stack([array.real, array.imag]) if np.iscomplexobj(array) else value
    except Exception:  # an object's own conversion may raise any error; reported below
        parts = value
    numbers = floats(name, parts)
    if parts is value:
        return numbers.astype(complex)
    return np.asarray(numbers[0] + 1j * numbers[1])


def coefficients(amplitudes: NDArray[Any], basis: HarmonicBasis) -> Floats:
    """Return the Fourier coefficients (count, size) of Re(amplitude exp(i omega t))."""
    result = np.zeros((amplitudes.size, basis.size))
    result[:, 1], result[:, 2] = amplitudes.real, -amplitudes.imag
    return result


def line_of(model: ModalModel, forces: Floats, targets: Floats) -> Floats:
    """Return an estimate of the modal motion (modes,), along which nodes of contact fields slide.

    It is the undamped linear response to the first harmonic of ``forces`` (modes, size), near the
    median of the frequencies ``targets`` [Hz], with all modes in phase.
    """
    middle = (2.0 * math.pi * float(np.median(targets))) ** 2
    gain = np.abs(model.squares - middle) + 1e-3 * middle
    column = 1 if np.any(forces[:, 1]) else 2
    return np.asarray(forces[:, column] / gain)
