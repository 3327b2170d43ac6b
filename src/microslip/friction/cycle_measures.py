"""Backbone of a law and measures of its closed cycles: energies, damping, secant stiffness."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, check_one_of, floats, plain, sized
from microslip._core.errors import InputError
from microslip._core.inversion import adaptive, invert
from microslip._core.kernels.table import PolynomialTable
from microslip.friction.loops import Loop, checked_cycle, halves_of


class CycleMeasures(ABC):
    """Backbone T0 of a law, its inverse and energies, and measures of closed cycles from them."""

    if TYPE_CHECKING:  # a law implements it as a field or as a property

        @property
        def force_limit(self) -> float:
            """Force of gross slip [N]."""

    @cached_property
    def tangential_stiffness(self) -> float:
        """Stiffness at rest T0'(0) [N/m]."""
        return float(self._slope(np.zeros(1))[0])

    @property
    def _slip_scale(self) -> tuple[float, str]:
        """Displacement scale [m] between sticking and sliding, and its definition in words."""
        if math.isinf(self.tangential_stiffness):  # no transition: any length is valid
            return 1e-6, "1 um, since the law is rigid at rest"
        return self.force_limit / self.tangential_stiffness, "force_limit / tangential_stiffness"

    @abstractmethod
    def _backbone(self, u: Floats) -> Floats:
        """Return the first loading curve T0 [N] at displacements u >= 0 [m], one-dimensional."""

    @abstractmethod
    def _slope(self, u: Floats) -> Floats:
        """Slope T0' [N/m] of the backbone at displacements u >= 0 [m], one-dimensional."""

    @property
    def _table(self) -> PolynomialTable | None:
        """Polynomials for T0 over the displacement, or None for a law that is cheap to evaluate."""
        return None

    def _backbone_and_slope(self, u: Floats) -> tuple[Floats, Floats]:
        """Return T0 [N] and T0' [N/m], the slope only accurate enough for Newton's method."""
        table = self._table
        if table is None:
            return self._backbone(u), self._slope(u)
        return table.value_and_slope(u)

    def _backbone_at(self, u: float) -> tuple[float, float]:
        place = np.array([u])
        return float(self._backbone(place)[0]), float(self._slope(place)[0])

    def _inverse(self, force: Floats) -> Floats:
        """Return displacements u >= 0 [m] with T0(u) = ``force`` [N], one-dimensional."""
        low = force / self.tangential_stiffness
        # T0 is concave and lies below its first tangent, so `low` is a lower bound of u.
        high = np.maximum(low, self.force_limit / self.tangential_stiffness)
        reached = np.zeros_like(high)
        for _ in range(1000):
            before, reached = reached, self._backbone(high)
            # The limit may be one rounding error below the requested force: stop if T0 stalls.
            short = (reached < force) & (reached > before)
            if not short.any():
                break
            low = np.where(short, high, low)
            high = np.where(short, 2.0 * high, high)
        return invert(self._backbone_and_slope, force, low, high)

    def _energy(self, amplitude: Floats) -> Floats:
        """Return the energy E_d of cycles [J], the integral of 4 (T0 - a T0') over amplitude a."""

        # Stop at the rounding error of T0 - a T0': small amplitudes would be bisected for ever.
        def noise(low: Floats, high: Floats) -> Floats:
            return 4e-15 * self._backbone(high) * (high - low)

        return adaptive(lambda a, _: self._energy_slope(a), amplitude, 1e-14, 60, noise)

    def _energy_slope(self, amplitude: Floats) -> Floats:
        """Return the derivative of :meth:`_energy` with respect to the amplitude [N]."""
        value, slope = self._backbone(amplitude), self._slope(amplitude)
        return 4.0 * np.maximum(value - amplitude * slope, 0.0)

    @property
    def _small_amplitude_exponent(self) -> float:
        """Limit of d ln E_d/d ln a for amplitude a towards 0 [-], NaN if there is none."""
        return math.nan

    def _below_limit(self, name: str, force: Floats) -> Floats:
        largest = float(np.abs(force).max())
        if largest >= self.force_limit:
            raise InputError(
                f"`{name}` must be below the force limit {self.force_limit:.10g} N in magnitude "
                f"(at the limit slip is unlimited), got {largest:.10g} N"
            )
        return force

    def _amplitudes(self, amplitude: Any, force_amplitude: Any) -> Floats:
        check_one_of("amplitude [m] or force_amplitude=... [N]", amplitude, force_amplitude)
        name = "amplitude" if force_amplitude is None else "force_amplitude"
        values = (
            sized("amplitude", amplitude)
            if force_amplitude is None
            else floats(name, force_amplitude, "N")
        )
        if values.min() < 0.0:
            raise InputError(f"`{name}` must not be negative, got {values.min():g}")
        values = np.abs(values)  # -0.0 becomes 0.0
        if force_amplitude is None:
            return values
        self._below_limit(name, values)
        return self._inverse(values.reshape(-1)).reshape(values.shape)

    def _measure(
        self, amplitude: Any, force_amplitude: Any, measure: Callable[[Floats], Floats]
    ) -> Any:
        a = self._amplitudes(amplitude, force_amplitude)
        like = force_amplitude if amplitude is None else amplitude
        return plain(measure(a.reshape(-1)).reshape(a.shape), like)

    def dissipated_energy(
        self, amplitude: ArrayLike | None = None, *, force_amplitude: ArrayLike | None = None
    ) -> Any:
        """Compute the energy dissipated in a cycle between -amplitude and +amplitude (19.29).

        Parameters
        ----------
        amplitude : array_like, optional
            Displacement amplitudes [m], not negative, any shape.
        force_amplitude : array_like, optional
            Force amplitudes [N], given instead: not negative and below the force limit. InputError
            is raised for other amplitudes.

        Returns
        -------
        float or ndarray
            Energies E_d [J], shape of the amplitudes.
        """
        return self._measure(amplitude, force_amplitude, self._energy)

    def energy_ratio(
        self, amplitude: ArrayLike | None = None, *, force_amplitude: ArrayLike | None = None
    ) -> Any:
        """Compute the energy ratio A = E_d/(4 delta_m T_m) [-]: 1 for rigid-plastic friction.

        delta_m and T_m are the amplitudes of displacement and force. Parameters, shapes and errors
        are as for :meth:`dissipated_energy`.
        """

        def ratio(a: Floats) -> Floats:
            box = 4.0 * a * self._backbone(a)
            return np.divide(self._energy(a), box, out=np.zeros_like(a), where=box > 0.0)

        return self._measure(amplitude, force_amplitude, ratio)

    def loss_factor(
        self, amplitude: ArrayLike | None = None, *, force_amplitude: ArrayLike | None = None
    ) -> Any:
        """Compute the loss factor eta = E_d/(2 pi U) = E_d/(pi delta_m T_m) [-].

        E_d is the energy per cycle, delta_m the displacement amplitude, T_m the force amplitude and
        U = delta_m T_m/2. Equation (19.30) calls this quantity the damping ratio xi; the equivalent
        viscous damping ratio is half of it. It is a property of the interface. A mode of a
        structure has the damping ratio (sum of E_d)/(4 pi U) instead, with the energy U of the
        whole structure. Parameters, shapes and errors are as for :meth:`dissipated_energy`.
        """
        ratio = self.energy_ratio(amplitude, force_amplitude=force_amplitude)
        return 4.0 / math.pi * ratio

    def damping_ratio(
        self, amplitude: ArrayLike | None = None, *, force_amplitude: ArrayLike | None = None
    ) -> Any:
        """Compute the equivalent viscous damping ratio zeta = eta/2 [-] of the interface.

        It is half of :meth:`loss_factor`, which (19.30) calls damping ratio. Parameters, shapes and
        errors are as for :meth:`dissipated_energy`.
        """
        return 0.5 * self.loss_factor(amplitude, force_amplitude=force_amplitude)

    def secant_stiffness(
        self, amplitude: ArrayLike | None = None, *, force_amplitude: ArrayLike | None = None
    ) -> Any:
        """Compute the secant stiffness T0(delta_m)/delta_m [N/m] at displacement amplitude delta_m.

        For amplitude 0 it is the stiffness at rest. Parameters, shapes and errors are as for
        :meth:`dissipated_energy`.
        """

        def secant(a: Floats) -> Floats:
            moved = a > 0.0
            stiffness = np.full_like(a, self.tangential_stiffness)
            with np.errstate(over="ignore"):  # a rigid law at a very small amplitude
                return np.divide(self._backbone(a), a, out=stiffness, where=moved)

        return self._measure(amplitude, force_amplitude, secant)

    def dissipation_exponent(
        self, amplitude: ArrayLike | None = None, *, force_amplitude: ArrayLike | None = None
    ) -> Any:
        """Compute the exponent d ln E_d / d ln delta_m [-]: 3 for small microslip, 1 in gross slip.

        If the energy underflows, the result is the limit for amplitude 0, or NaN for a law that is
        elastic at small amplitudes. Given force amplitudes are converted to displacement amplitudes
        delta_m first. Parameters, shapes and errors are as for :meth:`dissipated_energy`.
        """

        def exponent(a: Floats) -> Floats:
            energy = self._energy(a)
            nothing = np.full_like(a, self._small_amplitude_exponent)
            return np.divide(a * self._energy_slope(a), energy, out=nothing, where=energy > 0.0)

        return self._measure(amplitude, force_amplitude, exponent)

    def plot(
        self,
        ax: Any = None,
        quantity: str = "backbone",
        amplitudes: ArrayLike | None = None,
        *,
        color: str | None = None,
        label: str = "",
    ) -> Any:
        """Draw the backbone, or a measure of closed cycles over their amplitude.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw on, by default new ones. Laws drawn on the same axes share units.
        quantity : str, optional
            "backbone", "backbone_stiffness", "secant_stiffness", "dissipated_energy",
            "loss_factor", "damping_ratio" or "dissipation_exponent".
        amplitudes : array_like, optional
            Displacement amplitudes [m], by default from microslip to gross slip.
        color : str, optional
            Color of the line, by default the next color of the package.
        label : str, optional
            Label for ``ax.legend()``.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.
        """
        from microslip.figures import draw
        from microslip.friction.figures import law_figure

        return draw(law_figure(self, quantity, amplitudes), ax, color=color, label=label)

    def _repr_html_(self) -> str:
        from microslip.figures.plottable import notebook_view
        from microslip.friction.figures import law_figure

        return notebook_view(self, law_figure(self, "backbone", None))

    def loop(self, amplitude: float, samples: int = 512) -> Loop:
        """Compute the closed loop between +amplitude and -amplitude.

        Unloading follows (19.13), with sliding (19.16), and reloading (19.14), with sliding
        (19.17), with the misprints of chapter 19 corrected.

        Parameters
        ----------
        amplitude : float
            Displacement amplitude [m], above zero.
        samples : int, optional
            Number of samples, at least 5, denser at the turning points. The first and the last
            sample are at +amplitude, and one is at -amplitude.

        Returns
        -------
        Loop
            Samples from +amplitude to -amplitude and back.
        """
        a, shape, turn = checked_cycle(amplitude, samples)
        peak = self._backbone_at(a)[0]
        rise = 2.0 * self._backbone(a * halves_of(int(samples)))
        force = np.concatenate((peak - rise[: turn + 1], rise[turn + 1 :] - peak))
        force[-1] = peak
        return Loop(a * shape, force)
