"""Forced response by harmonic balance, followed around turning points."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core.checks import Floats, floats, positive
from microslip.errors import InputError
from microslip.report.plot import Plot
from microslip.report.plottable import PlottableAtSensor
from microslip.structures.answer import ModalAnswer
from microslip.structures.balance import Balance
from microslip.structures.forced_path import Drive, Excitation, follow
from microslip.structures.frequency_response import FrequencyResponse
from microslip.structures.modal_model import ModalModel
from microslip.structures.periodic_motion import (
    HarmonicBasis,
    Quantity,
    harmonic_basis,
    power_of,
)


@dataclass(frozen=True, eq=False, repr=False)
class ForcedResponse(ModalAnswer, PlottableAtSensor):
    """Periodic motions along a range of frequencies; made by ``structure.forced_response(...)``.

    By harmonic balance with arc length (Keller's continuation), as in Krack and Gross
    (2019), DOI 10.1007/978-3-030-14023-6: where the response folds over, a frequency has several.
    """

    frequency: Floats
    """Frequencies along the path [Hz]; they turn back where the response folds."""
    harmonics: tuple[int, ...]
    """Orders of the harmonics; 0 is the mean."""
    asked: NDArray[np.bool_]
    """Whether each point is at a frequency that was asked for."""
    stable: NDArray[np.bool_]
    """Whether each motion is stable: those between turning points are not.

    The sign of the determinant of the balance's Jacobian, which holds what settled cycles remember:
    right for growth that is slow beside the motion, not for motion at half its frequency or at a
    second one (Krack and Gross 2019, DOI 10.1007/978-3-030-14023-6).
    """
    iterations: int
    """Iterations of Newton's method in all."""
    message: str
    """Outcome in a sentence: where and why it stopped, and what to try."""
    _coordinates: NDArray[np.complex128]
    """Modal amplitudes of each harmonic (points, modes, harmonics)."""
    _shapes: Floats
    """Shapes of the modes and of free motions (n, modes)."""

    @property
    def displacement(self) -> NDArray[np.complex128]:
        """Amplitudes x of each harmonic, (points, n, harmonics), motion Re(x exp(i h w t)) [m].

        Made anew each time: of a large structure it is large.
        """
        return np.asarray(self._shapes @ self._coordinates)

    def _fundamental(self, at: ArrayLike) -> NDArray[np.complex128]:
        """Amplitudes of the fundamental harmonic at a sensor (points,) [m]."""
        return np.asarray(self._coordinates[:, :, self.harmonics.index(1)] @ self._at(at))

    def _sizes(self, columns: Floats) -> Floats:
        relative = (columns.T @ self._shapes) @ self._coordinates
        return np.asarray(np.abs(relative).sum(axis=2))

    @property
    def turning_points(self) -> NDArray[np.int64]:
        """Indices of the points at which the frequency turns back."""
        way = np.sign(np.diff(self.frequency))
        return np.asarray(1 + np.flatnonzero(way[1:] != way[:-1]))

    def amplitude(self, at: ArrayLike) -> Floats:
        """Displacement amplitude of the fundamental harmonic at a sensor.

        Parameters
        ----------
        at : array_like
            Direction of the sensor, shape (n,).

        Returns
        -------
        ndarray
            Amplitudes [m], one a point.
        """
        return np.asarray(np.abs(self._fundamental(at)))

    def frequency_response(
        self, at: ArrayLike, force: float, *, quantity: Quantity = "displacement"
    ) -> FrequencyResponse:
        """Fundamental at a sensor over the force, as a slow sweep along the frequencies meets it.

        Where the response folds over, a sweep jumps: motions that it does not meet, or that do not
        last, are left out.

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
            Frequencies [Hz] and complex values; ``save`` writes CSV and UFF 58.
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
    """Frequencies [Hz] along which a response can be followed, or an error."""
    targets = floats("frequencies", frequencies)
    ways = np.sign(np.diff(targets.reshape(-1)))
    if targets.ndim != 1 or targets.size < 2 or targets.min() <= 0.0 or abs(ways.sum()) < ways.size:
        raise InputError(
            "frequencies must be at least two above zero that rise or fall [Hz], such as "
            "np.linspace(150.0, 200.0, 101)"
        )
    return targets


def forced_response(
    model: ModalModel,
    force: ArrayLike,
    frequencies: ArrayLike,
    harmonics: Sequence[int],
    samples: int,
) -> ForcedResponse:
    """See :meth:`microslip.Preload.forced_response`."""
    push, size = complex_amplitudes("force", force), model.shapes.shape[0]
    if push.shape != (size,):
        raise InputError(f"force must have the shape ({size},), got {push.shape}")
    targets = checked_frequencies(frequencies)
    basis = harmonic_basis(harmonics, samples)
    forces = coefficients(model.shapes.T @ push, basis)
    line = line_of(model, forces, targets)
    if not np.any(line):
        raise InputError("force must push some elastic mode, not only move the structure")
    excitation = Excitation({0: forces}, {}, -model.free.T @ push)
    drive = Drive(Balance(model, model.joints(line), basis), excitation)
    return ForcedResponse(**follow(drive, targets).fields(drive))


def complex_amplitudes(name: str, value: Any) -> NDArray[np.complex128]:
    """Amplitudes of any phase, or an error."""
    try:
        array = np.asarray(value)
        parts = np.stack([array.real, array.imag]) if np.iscomplexobj(array) else value
    except Exception:  # an object's own conversion may raise anything; said below
        parts = value
    numbers = floats(name, parts)
    if parts is value:
        return numbers.astype(complex)
    return np.asarray(numbers[0] + 1j * numbers[1])


def coefficients(amplitudes: NDArray[Any], basis: HarmonicBasis) -> Floats:
    """Fourier coefficients (count, size) of Re(amplitude exp(i w t)) = Re cos - Im sin."""
    result = np.zeros((amplitudes.size, basis.size))
    result[:, 1], result[:, 2] = amplitudes.real, -amplitudes.imag
    return result


def line_of(model: ModalModel, forces: Floats, targets: Floats) -> Floats:
    """A motion along which the joints will move most; zeros where no mode is pushed."""
    middle = (2.0 * math.pi * float(np.median(targets))) ** 2
    gain = np.abs(model.squares - middle) + 1e-3 * middle
    column = 1 if np.any(forces[:, 1]) else 2
    return np.asarray(forces[:, column] / gain)
