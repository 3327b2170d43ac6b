"""Frequency and damping of a mode against its amplitude, and quantities derived from them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip._core.verdicts import Rule, Verdict
from microslip.figures.plot import Plot
from microslip.figures.plottable import Plottable
from microslip.structures.modal_model import SolverResult


class Resonance(NamedTuple):
    """Multiple of a mode's frequency close to the frequency of another mode."""

    amplitude: float
    """Amplitude of the curve at which the two frequencies are closest."""
    multiple: int
    mode: int
    """Index of the other mode, from 0."""
    distance: float
    """Other frequency over the multiple, minus one [-]."""


@dataclass(frozen=True, eq=False, repr=False)
class ModalCurve(SolverResult, Plottable):
    """Nonlinear mode at a number of amplitudes, the result of ``structure.modes(...)``.

    Values at amplitudes that were not reached are NaN; ``message`` gives the reason.
    """

    method: str
    """``harmonic-balance`` or ``quasi-static``."""
    index: int
    """Index of the elastic mode, counted from 0."""
    amplitude: Floats
    """Requested amplitudes: modal [m kg^(1/2)], or at the sensor."""
    modal_amplitude: Floats
    """a = sqrt(x1^H M x1) of the fundamental harmonic [m kg^(1/2)]."""
    frequency: Floats
    """Frequencies [Hz]."""
    damping_ratio: Floats
    """Damping ratios of steady motion [-], including ``base_damping``; for a free decay see
    :attr:`decay_damping_ratio`."""
    shape: NDArray[np.complex128]
    """Complex fundamental harmonic x1 over its modal amplitude, (amplitudes, n) [kg^(-1/2)].

    The motion is the real part of shape * modal_amplitude * exp(i omega t).
    """
    loss: Floats
    """Energy dissipated per cycle in each joint or node (amplitudes, joints) [J]."""
    mac: Floats
    """Modal assurance criterion of the shape and that with sticking joints [-]."""
    near: tuple[Resonance, ...]
    """Multiples of the frequency close to that of another mode, each at its closest amplitude."""
    linear_frequency: float
    """Frequency of the mode with sticking joints [Hz]."""
    base_damping: float
    """Base damping ratio, an input [-]."""
    converged: NDArray[np.bool_]
    """Whether each amplitude was solved."""
    iterations: int
    """Total number of Newton iterations."""
    message: str
    """Outcome: where and why the solver stopped, and what to try."""
    _with_more_harmonics: Callable[[], Floats] | None

    def _figure(self) -> Plot:
        from microslip.structures.figures import modal_figure

        return modal_figure(self)

    def _sizes(self, columns: Floats) -> Floats:
        return np.abs(self.shape.real @ columns) * self.modal_amplitude[:, None]

    @property
    def harmonic_error(self) -> Floats:
        """Relative change of the joints' damping ratio by harmonics that were left out [-].

        Estimated by one Newton step at each amplitude with orders up to two above the highest;
        computed at the first access. NaN at amplitudes without a solution, and for curves that were
        read, copied or computed quasi-statically. If it exceeds some percent, add ``harmonics``.
        """
        return self.harmonic_changes[:, 1]

    @cached_property
    def harmonic_changes(self) -> Floats:
        """Relative changes of frequency and damping by further harmonics [-], (amplitudes, 2)."""
        if self._with_more_harmonics is None:
            return np.full((self.frequency.size, 2), np.nan)
        return self._with_more_harmonics()

    @cached_property
    def decay_damping_ratio(self) -> Floats:
        """Damping ratio of a free decay at these amplitudes [-].

        In one cycle the modal amplitude a decreases by E_d/(dE/da), with the energy E of the mode
        and its loss E_d per cycle. A linear mode has dE/da = omega^2 a; here it is
        omega^2 a (1 + g/2 - (dE_d/da)/(4 omega^2 a)). The change of frequency g = d ln omega/d ln a
        is that of the nonlinear elastic part alone; the last term is due to slip, which makes the
        tangent stiffness of a joint smaller than its secant stiffness (Caughey 1960,
        DOI 10.1115/1.3644075). NaN for fewer than two amplitudes.
        """
        result = np.full(self.frequency.shape, np.nan)
        a, first, back = np.unique(
            self.modal_amplitude[self.converged], return_index=True, return_inverse=True
        )
        if a.size < 2:
            return result
        by = np.log(a)
        order: Literal[1, 2] = 2 if a.size > 2 else 1
        omega = 2.0 * math.pi * self.frequency[self.converged][first]
        lost = self.loss[self.converged][first].sum(axis=1)
        shift = np.gradient(np.log(omega), by, edge_order=order)
        steep = np.gradient(np.log(np.maximum(lost, 1e-300)), by, edge_order=order)
        slip = steep * lost / (2.0 * omega * a) ** 2
        # Joints that slip lower the frequency by a quarter of it.
        ratio = 1.0 + 0.5 * (shift + 0.5 * slip) - slip
        result[self.converged] = self.damping_ratio[self.converged] / ratio[back]
        return result

    @property
    def loss_share(self) -> Floats:
        """Fraction of the loss per cycle in each joint (amplitudes, joints) [-]."""
        total = self.loss.sum(axis=1, keepdims=True)
        share = np.zeros_like(self.loss)
        return np.asarray(np.divide(self.loss, total, out=share, where=total > 0.0))

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
        return {**super().__getstate__(), "_with_more_harmonics": None}


_STEPS = 300
_BELOW = 1e-3  # of the smallest amplitude of a curve, below which the mode is linear


def sides(amplitude: Floats, omega: Floats, damping: Floats, push: Floats) -> tuple[Floats, Floats]:
    """Return squared excitation frequencies below and above the resonance [rad^2/s^2].

    They are the solutions W^2 of (omega^2 - W^2)^2 + (2 zeta omega W)^2 = (push/a)^2 at amplitudes
    a of the modal force ``push``; NaN above the peak (Szemplinska-Stupnicka 1979,
    DOI 10.1016/S0022-460X(79)80003-1).
    """
    middle = omega**2 * (1.0 - 2.0 * damping**2)
    inside = (push / amplitude) ** 2 - 4.0 * damping**2 * omega**4 * (1.0 - damping**2)
    half = np.sqrt(np.where(inside >= 0.0, inside, np.nan))
    return middle - half, middle + half


class Resonant(NamedTuple):
    """Steady responses of a mode to a harmonic force, for each random sample of its curves."""

    peak: Floats
    """Amplitude and frequency [Hz] of each peak (samples, 2), at most the end of the curve."""
    beyond: NDArray[np.bool_]
    """True for peaks beyond the end of the curve, with a larger amplitude than its last one."""
    amplitude: Floats
    """Largest stable amplitude at each frequency, (samples, frequencies)."""


def interpolate_in_amplitude(amplitude: Floats, logs: Floats) -> tuple[Floats, Floats]:
    """Interpolate curves over amplitude to a fine grid; return the grid and the values on it.

    ``logs``, shape (samples, curves, amplitudes), are the natural logarithms of the curves; the
    returned values are not logarithms. Interpolation is by monotone cubics in ln(amplitude); below
    the smallest given amplitude values are constant.
    """
    from scipy.interpolate import PchipInterpolator

    place = np.log(amplitude)
    grid = np.linspace(place[0] + math.log(_BELOW), place[-1], _STEPS)
    values = PchipInterpolator(place, logs, axis=2)(np.maximum(grid, place[0]))
    return np.exp(grid), np.exp(values)


def resonant(
    amplitude: Floats, frequency: Floats, damping: Floats, push: Floats, at: Floats
) -> Resonant:
    """Return amplitudes of a mode under a harmonic force, for each sample of its curves.

    Frequency [Hz], damping ratio and ``push``, the modal force in units of amplitude/s^2, are given
    on a fine grid of amplitudes (samples, amplitudes). At the frequencies ``at`` [Hz], W = 2 pi at,
    the amplitude x solves x |omega^2 - W^2 + 2i zeta omega W| = push, with omega and zeta at x. The
    largest solution is returned.
    """
    peaks = np.empty((len(amplitude), 2))
    answers = np.empty((len(amplitude), at.size))
    ends_below = np.zeros(len(amplitude), dtype=bool)
    omegas = 2.0 * math.pi * at
    for row, (x, f, zeta, p) in enumerate(zip(amplitude, frequency, damping, push, strict=True)):
        grid, omega = np.log(x), 2.0 * math.pi * f
        # The peak: force over amplitude falls to what damping takes.
        excess = np.log(p / x) - np.log(2.0 * zeta * omega**2 * np.sqrt(1.0 - zeta**2))
        beyond = np.flatnonzero(excess < 0.0)
        ends_below[row] = not beyond.size
        if beyond.size and beyond[0] == 0:  # so small a force moves a linear mode
            o, z = omega[0], zeta[0]
            summit = o * math.sqrt(1.0 - 2.0 * z**2)
            peaks[row] = x[0] * math.exp(excess[0]), summit / (2.0 * math.pi)
            answers[row] = p[0] / np.hypot(o**2 - omegas**2, 2.0 * z * o * omegas)
            continue
        end = int(beyond[0]) if beyond.size else grid.size - 1
        share = excess[end - 1] / (excess[end - 1] - excess[end]) if beyond.size else 1.0
        top = grid[end - 1] + share * (grid[end] - grid[end - 1])
        at_top, ratio = (np.interp(top, grid, values) for values in (omega, zeta))
        summit = at_top * math.sqrt(max(1.0 - 2.0 * ratio**2, 0.0))
        below, above = sides(x[:end], omega[:end], zeta[:end], p[:end])
        # Down from the peak on both sides; a fold is stepped over where the motion jumps.
        left = np.minimum.accumulate(np.append(summit, np.sqrt(np.maximum(below[::-1], 0.0))))
        right = np.maximum.accumulate(np.append(summit, np.sqrt(above[::-1])))
        falling = np.append(top, grid[:end][::-1])
        path, heights = np.append(left[::-1], right), np.append(falling[::-1], falling)
        peaks[row] = math.exp(top), summit / (2.0 * math.pi)
        answers[row] = np.exp(np.interp(omegas, path, heights))
        far = (omegas < path[0]) | (omegas > path[-1])  # so little moves a linear mode
        o, z = omega[0], zeta[0]
        linear = p[0] / np.hypot(o**2 - omegas**2, 2.0 * z * o * omegas)
        answers[row, far] = linear[far]
    return Resonant(peaks, ends_below, answers)


_NOTHING = 5e-4  # of the frequency: a smaller shift says nothing

SHIFT = Rule(
    "frequency shift over that of friction",
    watch=2.5,
    outside=6.0,
    meaning=(
        "Friction explains the frequency shift: measured shift over the shift expected from the "
        "added damping (in microslip the added damping ratio is 0.424 times the relative shift)."
    ),
    reason=(
        "On a bolted beam in microslip the added damping was 0.93 to 1.08 times the expected one; "
        "a far larger or upward shift is caused by geometry (thin or curved parts) or by gaps."
    ),
    remedy="Add the geometric stiffness, with_geometry(...), or fit smaller amplitudes only.",
    missing="The frequency moves by less than 0.05 %, too little to judge.",
)


def added_damping(shift: float) -> float:
    """Return the damping ratio added by microslip if it lowers the frequency by ``shift`` [-]."""
    return 2.0 / math.pi * 2.0 * shift / 3.0


def judge_shift(name: str, amplitude: Floats, frequency: Floats, damping: Floats) -> Verdict:
    """Return a verdict on whether friction explains the decrease of frequency with amplitude."""
    rule, order = SHIFT, np.argsort(amplitude)
    third = max(1, amplitude.size // 3)
    low, high = order[:third], order[-third:]
    shift = float(frequency[low].mean() - frequency[high].mean()) / float(frequency[low].mean())
    gain = float(damping[high].mean() - damping[low].mean())
    value: float | None = None
    if amplitude.size > 1 and abs(shift) > _NOTHING:
        value = math.inf if shift < 0.0 or gain <= 0.0 else added_damping(shift) / gain
        value = min(value, 1e3)
    verdict = rule.judge(value)
    return verdict._replace(name=f"{rule.name}, {name}")
