"""Frequency and damping of a mode against its amplitude, and what follows from them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core.checks import Floats, floats, whole_number
from microslip._core.frozen import LockedArrays
from microslip.errors import InputError
from microslip.report.plot import Plot
from microslip.report.plottable import Plottable


@dataclass(frozen=True, eq=False, repr=False)
class ModalCurve(LockedArrays, Plottable):
    """A nonlinear mode along amplitudes; made by ``structure.modes(...)``.

    Amplitudes that the solver did not reach hold NaN; ``message`` says where and why.
    """

    method: str
    """``harmonic-balance`` or ``quasi-static``."""
    index: int
    """Which elastic mode, counted from 0."""
    amplitude: Floats
    """Amplitudes as they were asked for: modal [m kg^(1/2)], or at the sensor."""
    modal_amplitude: Floats
    """a = sqrt(x1^H M x1) of the fundamental harmonic [m kg^(1/2)]."""
    frequency: Floats
    """Frequencies [Hz]."""
    damping_ratio: Floats
    """Damping ratios [-], base damping included."""
    shape: NDArray[np.complex128]
    """Fundamental harmonics over their modal amplitude (amplitudes, n) [kg^(-1/2)].

    The motion is the real part of shape * modal_amplitude * exp(i omega t).
    """
    loss: Floats
    """Energy lost a cycle by each joint or node (amplitudes, joints) [J]."""
    linear_frequency: float
    """Frequency of the mode whose joints stick [Hz]."""
    base_damping: float
    """The damping ratio that was given as an input [-]."""
    converged: NDArray[np.bool_]
    """Which amplitudes were solved."""
    iterations: int
    """Iterations of Newton's method in all."""
    message: str
    """What came of it in a sentence; where and why it stopped, and what to try."""
    _solve_by_other: Callable[[], ModalCurve] | None

    def _figure(self) -> Plot:
        from microslip.structures.figures import modal_figure

        return modal_figure(self)

    @property
    def status(self) -> str:
        """``solved``, or ``stopped`` where some amplitudes were not reached."""
        return "solved" if bool(self.converged.all()) else "stopped"

    @cached_property
    def other_method(self) -> ModalCurve:
        """The same by the other method; solved when first asked for."""
        if self._solve_by_other is None:
            raise InputError("other_method is not kept in a curve that was read or copied")
        return self._solve_by_other()

    @property
    def frequency_difference(self) -> Floats:
        """Quasi-static over balanced frequency, less one [-]."""
        return self._difference("frequency")

    @property
    def damping_difference(self) -> Floats:
        """Quasi-static over balanced damping ratio, less one [-]; base damping counts in both."""
        return self._difference("damping_ratio")

    def _difference(self, name: str) -> Floats:
        curves = (self, self.other_method)
        quick, exact = curves if self.method == "quasi-static" else curves[::-1]
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(getattr(quick, name) / getattr(exact, name) - 1.0)

    @property
    def loss_share(self) -> Floats:
        """Share of each joint in the loss of a cycle (amplitudes, joints) [-]."""
        total = self.loss.sum(axis=1, keepdims=True)
        share = np.zeros_like(self.loss)
        return np.asarray(np.divide(self.loss, total, out=share, where=total > 0.0))

    def forced_response(self, force: ArrayLike, *, samples: int = 400) -> tuple[Floats, Floats]:
        """Response near the resonance in closed form, from this curve alone.

        Parameters
        ----------
        force : array_like
            Amplitudes (n,) of a harmonic force in phase everywhere [N], one a degree of freedom.
        samples : int, optional
            Amplitudes on each side of the peak.

        Returns
        -------
        frequency : ndarray
            Frequencies [Hz]: up the left side of the resonance, down the right.
        modal_amplitude : ndarray
            Amplitudes there.

        Notes
        -----
        At the modal amplitude a the mode answers like a linear one of frequency omega(a) and
        damping zeta(a): (omega^2 - W^2)^2 + (2 zeta omega W)^2 = (p/a)^2 with p = |shape^H force|
        (Szemplinska-Stupnicka 1979, DOI 10.1016/S0022-460X(79)80003-1; Schwarz et al. 2020,
        DOI 10.1007/s11071-019-05211-7). Other modes are left out.
        """
        f = floats("force", force)
        if f.shape != (self.shape.shape[1],):
            raise InputError(
                f"force must be one for each of the {self.shape.shape[1]} degrees of freedom, "
                f"got shape {f.shape}"
            )
        samples = whole_number("samples", samples, 2, 1_000_000)
        good = np.flatnonzero(self.converged)
        good = good[np.argsort(self.modal_amplitude[good])]
        a = self.modal_amplitude[good]
        if a.size < 2:
            raise InputError("force needs a curve of at least two solved amplitudes")
        push = np.abs(self.shape[good].conj() @ f)
        grid = np.geomspace(a[0], a[-1], samples)
        at = np.log(grid)

        def along(values: Floats) -> Floats:
            return np.asarray(np.interp(at, np.log(a), values))

        omega = 2.0 * math.pi * along(self.frequency[good])
        zeta, p = along(self.damping_ratio[good]), along(push)
        middle = omega**2 * (1.0 - 2.0 * zeta**2)
        inside = (p / grid) ** 2 - 4.0 * zeta**2 * omega**4 * (1.0 - zeta**2)
        there = inside >= 0.0
        if there.all():
            raise InputError(
                f"force must be one whose peak lies on the curve, which ends at the modal "
                f"amplitude {a[-1]:g}; solve for larger amplitudes, or push less"
            )
        end = int(np.argmin(there))
        half = np.sqrt(inside[:end])
        below, above = middle[:end] - half, middle[:end] + half
        swings = below > 0.0
        squares = np.concatenate([below[swings], above[::-1]])
        amplitudes = np.concatenate([grid[:end][swings], grid[:end][::-1]])
        return np.sqrt(squares) / (2.0 * math.pi), amplitudes

    def __repr__(self) -> str:
        solved = self.converged
        if not solved.any():
            return f"ModalCurve(mode {self.index}, {self.method}, nothing solved: {self.message})"
        f, z = self.frequency[solved], self.damping_ratio[solved]
        return (
            f"ModalCurve(mode {self.index}, {self.method}, {int(solved.sum())} of {solved.size} "
            f"amplitudes, {f.min():.4g} to {f.max():.4g} Hz, "
            f"damping {z.min():.3g} to {z.max():.3g})"
        )

    def __getstate__(self) -> dict[str, Any]:
        return {**super().__getstate__(), "_solve_by_other": None}
