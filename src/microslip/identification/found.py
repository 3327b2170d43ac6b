"""Result of an identification: quantities that the loops determine, with intervals."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, plain, positive, positives
from microslip._core.errors import InputError
from microslip._core.frozen import Locked
from microslip.contact.materials import MaterialPair
from microslip.figures.plot import Plot
from microslip.figures.plottable import Plottable
from microslip.friction.slider_law import SliderLaw
from microslip.identification.bands import QUANTILE, Bands, Estimate, widened
from microslip.identification.free_form import FreeForm
from microslip.identification.interface_step import interface_step
from microslip.identification.loads import joint_alone
from microslip.identification.masing import Masing, masing_of
from microslip.identification.record_fit import RecordFit as RecordFit
from microslip.identification.second_step import InterfaceStep, Parameter, SufficientStatistics

_STEP = 0.02
"""Relative step of finite differences that approximate the polygon by a smooth curve."""
_BEYOND = 0.01
"""Tolerance by which an amplitude may exceed the largest one, relative to it."""
_NOTHING = 1e-9
"""Ratio to the upper end below which a lower end is set to zero."""
_NEAR = 8.0
"""Range of thresholds, over the smallest one, whose density is extrapolated below it."""
_STEEPEST, _LESS, _SPARE = 0.55, 0.5, 0.1
"""Stiffness below the smallest threshold over that within _NEAR of it, for a density y^-0.5; ratio
of the latter to that up to _NEAR times as far below which the density is less steep; and increase
of the stiffness that is reported without this test."""
_FLAT = 0.02
"""Relative increase of the force between amplitudes below which gross slip is assumed."""


class _At(NamedTuple):
    """Sliders of a fit at one normal load, at which all thresholds have a common fitted shift."""

    fit: FreeForm
    y: Floats
    """Thresholds [m]."""
    by_shift: Floats
    """Weights of the fitted shifts in the shift at this load [-]."""
    by_stiffness: Floats
    """Derivatives of the shift by the stiffnesses [m^2/N]."""


@dataclass(frozen=True, eq=False, repr=False)
class Identification(Locked, Plottable):
    """Friction law of free form identified from loops, with energies, forces and intervals.

    The law is a density of sliders (Iwan 1966, DOI 10.1115/1.3625199). Made by
    :func:`microslip.identify`. Without a measured stiffness of the rig all results are those of
    the joint and the rig in series.
    """

    fits: tuple[FreeForm, ...]
    """Fit of all normal loads, or one fit per load if no single density fits all loads."""
    records: tuple[RecordFit, ...]
    """Each record with the force of the fitted law."""
    rig_stiffness: tuple[float, float] | None
    """Stiffness of the rig that was given [N/m], and its standard error; None without one."""
    gain_errors: Mapping[str, float] = field(default_factory=dict)
    """Relative standard deviations of the gains of the sensors [-]."""
    notes: tuple[str, ...] = ()
    """Remarks on the fit, a sentence each."""
    step: InterfaceStep | None = None
    """Physical parameters, if materials or a law were given."""

    def _figure(self) -> Plot:
        from microslip.identification.figures import fitted_loops  # which reads this module

        return fitted_loops(self)

    # -- where it holds ---------------------------------------------------------------------------

    @property
    def series(self) -> str:
        """Object that the results describe: "joint", or "joint and rig in series"."""
        return "joint" if self.rig_stiffness else "joint and rig in series"

    @cached_property
    def loads(self) -> tuple[float, ...]:
        """Distinct normal loads [N] in decreasing order; empty if the records have none."""
        return tuple(load for fit in self.fits for load in fit.loads if load is not None)

    @cached_property
    def amplitudes(self) -> tuple[float, float]:
        """Smallest and largest amplitude of the records [m], less the deflection of a known rig."""
        sizes = []
        for fit in self.fits:
            for rows in fit.rows:
                force = fit.backbone(np.array([rows.amplitude]), fit.level[rows.load])[0]
                sizes.append(float(rows.amplitude - self._compliance * force))
        return min(sizes), max(sizes)

    @cached_property
    def _compliance(self) -> float:
        return 0.0 if self.rig_stiffness is None else 1.0 / self.rig_stiffness[0]

    @cached_property
    def _bands(self) -> dict[int, Bands]:
        return {id(fit): Bands(fit) for fit in self.fits}

    def _at(self, normal_load: float | None) -> _At:
        """Return the sliders at a normal load [N]; at the highest load if it is None."""
        if normal_load is None:
            return self._level(self.fits[0], 0)
        load = positive("normal_load", normal_load, "N", 500.0)
        for fit in self.fits:
            for level, measured in enumerate(fit.loads):
                if measured is not None and abs(load / measured - 1.0) <= 0.01:
                    return self._level(fit, level)
        return self._between(load)

    def _level(self, fit: FreeForm, level: int) -> _At:
        by_stiffness = fit.shift_by_stiffness(fit.loads[level])
        return _At(fit, fit.y + fit.shifts[level], fit.shift_gradient(level), by_stiffness)

    def _between(self, load: float) -> _At:
        """Return the sliders at a normal load [N] between two measured loads."""
        fit = self.fits[0]
        loads = [measured for measured in fit.loads if measured is not None]
        if len(self.fits) > 1 or len(loads) < 2 or not loads[-1] <= load <= loads[0]:
            texts = ", ".join(f"{measured:.4g}" for measured in self.loads) or "none"
            raise InputError(
                f"`normal_load` must be one of those measured ({texts} N)"
                + (" or between them" if len(self.fits) == 1 and len(loads) > 1 else "")
                + f", got {load:.4g} N; measure at this load"
            )
        if fit.friction is not None:
            slope = np.array([fit.friction_gradient(load)])
            return _At(fit, fit.y + fit.shift_at(load), slope, fit.shift_by_stiffness(load))
        # B(u*) = mu (N_high - N), with mu that of the two measured loads about this one.
        reach = fit.backbone(-fit.shifts)
        after = next(i for i, measured in enumerate(loads) if measured <= load)
        share = (loads[after - 1] - load) / (loads[after - 1] - loads[after])
        force = reach[after - 1] + share * (reach[after] - reach[after - 1])
        corners = np.append(0.0, fit.thresholds())
        shift = -float(np.interp(force, fit.backbone(corners), corners))
        weights = np.zeros(len(loads) - 1)
        weights[after - 1] = share
        if after > 1:
            weights[after - 2] = 1.0 - share
        return _At(fit, fit.y + shift, weights, np.zeros(fit.y.size))

    # -- functionals ------------------------------------------------------------------------------

    def _coefficients(self, at: _At, shape: Callable[[Floats], Floats]) -> Floats:
        """Return the derivatives of sum_i k_i shape(y_i) by all stiffnesses and shifts."""
        y = np.maximum(at.y, 0.0)
        c = np.append(shape(y), np.zeros(at.by_shift.size))
        if at.by_shift.any() or at.by_stiffness.any():
            step = _STEP * at.fit.largest
            more, less = (_total(at, shape, way * step) for way in (1.0, -1.0))
            slope = (more - less) / (2.0 * step)
            c[y.size :] = at.by_shift * slope
            c[: y.size] += at.by_stiffness * slope
        return c

    def _interval(self, at: _At, shape: Callable[[Floats], Floats]) -> Estimate:
        value = _total(at, shape)
        middle, low, high = self._bands[id(at.fit)].interval(self._coefficients(at, shape))
        return Estimate(value, value + low - middle, value + high - middle)

    def _force_of(self, at: _At, u: float) -> tuple[Floats, float, float]:
        """Return the force at u [m], rig included: derivatives, value [N], slope by u [N/m]."""
        c = self._coefficients(at, lambda y: np.minimum(u, y))
        low, here, high = _sum(at, u * np.array([1.0 - _STEP, 1.0, 1.0 + _STEP]))
        if (1.0 + _STEP) * u > at.y[-2]:  # beyond it nothing is measured
            high = 2.0 * here - low
        return c, float(here), float(high - low) / (2.0 * _STEP * u)

    def _in_series(self, at: _At, a: float, compliance: float) -> float:
        """Return the displacement [m] of joint and rig if that of the joint alone is ``a`` [m]."""
        if not compliance:
            return a
        y = np.append(0.0, np.sort(np.maximum(at.y, 0.0)))
        x = y - compliance * _sum(at, y)
        return float(np.interp(a, np.maximum.accumulate(x), y))

    def _measure(self, name: str, amplitude: ArrayLike, normal_load: float | None) -> Estimate:
        a = positives("amplitude", amplitude, "m")
        largest = self.amplitudes[1]
        if a.max() > largest * (1.0 + _BEYOND):
            raise InputError(
                f"`amplitude` must be at most the largest measured, {largest:.4g} m, got "
                f"{a.max():.4g} m; the loops contain no information beyond it"
            )
        at = self._at(normal_load)
        ends = np.array([self._one(name, at, float(one)) for one in a.reshape(-1)])
        value, low, high = (plain(ends[:, i].reshape(a.shape)) for i in range(3))
        return Estimate(value, low, high)

    def _one(self, name: str, at: _At, a: float) -> tuple[float, float, float]:
        u = self._in_series(at, a, self._compliance)
        c_force, force, slope = self._force_of(at, u)
        c_energy = self._coefficients(at, lambda y: 4.0 * y * np.maximum(u - y, 0.0))
        energy = _energy(at, u)
        energy_slope = 4.0 * max(force - u * slope, 0.0)
        # The joint's amplitude is given: u = a + c B(u).
        softer = 1.0 / max(1.0 - self._compliance * slope, 1e-3)
        c_energy = c_energy + energy_slope * self._compliance * softer * c_force
        c_force = c_force * softer
        value, by_force, by_energy = _quantity_of(name, force, energy, a)
        gain_f, gain_x = (self.gain_errors.get(key, 0.0) for key in ("force", "displacement"))
        moved = by_force * slope + by_energy * energy_slope
        # A gain g of the displacement makes T(a/g) of T(a) and g E(a/g) of E(a).
        by_gain = (
            gain_f * (by_force * force + by_energy * energy),
            gain_x * (by_energy * energy - a * softer * moved),
        )
        gradient = by_force * c_force + by_energy * c_energy
        middle, low, high = self._bands[id(at.fit)].interval(gradient)
        ends = widened(value, value + low - middle, value + high - middle, by_gain)
        low, high = self._with_rig(name, at, a, ends)
        # All quantities are sums of stiffnesses with factors that are not negative.
        return value, low if low > _NOTHING * abs(high) else 0.0, high

    def _with_rig(self, name: str, at: _At, a: float, ends: Estimate) -> tuple[float, float]:
        """Return the interval of a quantity, ``ends`` without the error of the rig, with it."""
        value, low, high = ends
        if self.rig_stiffness is None or not self.rig_stiffness[1]:
            return low, high
        part = math.sqrt(QUANTILE) * self.rig_stiffness[1] / self.rig_stiffness[0]
        others = []
        for compliance in (self._compliance * (1.0 - part), self._compliance * (1.0 + part)):
            u = self._in_series(at, a, max(compliance, 0.0))
            force = float(_sum(at, np.array([u]))[0])
            others.append(_quantity_of(name, force, _energy(at, u), a)[0])
        less, more = value - min(*others, value), max(*others, value) - value
        return value - math.hypot(value - low, less), value + math.hypot(high - value, more)

    def force(self, amplitude: ArrayLike, *, normal_load: float | None = None) -> Estimate:
        """Return the force T [N] at an amplitude.

        Parameters
        ----------
        amplitude : array_like
            Amplitude of the displacement [m], any shape, at most the largest measured.
        normal_load : float, optional
            Normal load [N], measured or between measured ones; without it the highest one.
        """
        return self._measure("force", amplitude, normal_load)

    def dissipated_energy(
        self, amplitude: ArrayLike, *, normal_load: float | None = None
    ) -> Estimate:
        """Return the energy E_d dissipated per cycle [J] at amplitudes [m] of any shape."""
        return self._measure("energy", amplitude, normal_load)

    def damping_ratio(self, amplitude: ArrayLike, *, normal_load: float | None = None) -> Estimate:
        """Return the equivalent viscous damping ratio E_d/(2 pi a T) [-].

        Amplitudes [m] of any shape and the normal load [N] are as for :meth:`force`.
        """
        return self._measure("damping", amplitude, normal_load)

    def loss_factor(self, amplitude: ArrayLike, *, normal_load: float | None = None) -> Estimate:
        """Return the loss factor E_d/(pi a T) [-] at amplitudes [m] of any shape."""
        return self._measure("loss", amplitude, normal_load)

    def secant_stiffness(
        self, amplitude: ArrayLike, *, normal_load: float | None = None
    ) -> Estimate:
        """Return the secant stiffness T/a [N/m] at amplitudes a [m] of any shape."""
        return self._measure("secant", amplitude, normal_load)

    @cached_property
    def stiffness(self) -> Estimate:
        """Tangential stiffness at rest [N/m], at the highest normal load."""
        return self.stiffness_at(None)

    def stiffness_at(self, normal_load: float | None) -> Estimate:
        """Return the tangential stiffness at rest [N/m] at a normal load [N]."""
        at = self._at(normal_load)
        near = at.fit.finest * _NEAR

        def rest(further: float) -> Estimate:
            return self._interval(at, lambda y: np.where(y > 0.0, 1.0 + further * (y <= near), 0.0))

        low = rest(0.0).low
        # Sliders below the finest threshold stand there with the same force, and so with about half
        # of their stiffness: their density is that of the thresholds next to it.
        value = rest(0.5 / (_NEAR - 0.5)).value
        high = rest(_STEEPEST).high
        if high > (1.0 + _SPARE) * value:
            # Open, unless the density of sliders demonstrably rises less steeply towards zero.
            rises = self._interval(
                at, lambda y: np.where(y <= near, 1.0 * (y > 0.0), -_LESS * (y <= _NEAR * near))
            )
            high = high if rises.high <= 0.0 else math.inf
        gains = [self.gain_errors.get(key, 0.0) * value for key in ("force", "displacement")]
        value, low, high = widened(value, low, high, gains)
        if self.rig_stiffness is None:
            return Estimate(value, low, high)
        rig, error = self.rig_stiffness
        # Compliances subtract, and so do their errors: a stiffness may be open above, not below.
        by_rig = math.sqrt(QUANTILE) * error / rig**2
        compliance = 1.0 / value - 1.0 / rig
        more = math.hypot(1.0 / low - 1.0 / value, by_rig)
        less = math.hypot(1.0 / value - 1.0 / high, by_rig)
        return Estimate(
            1.0 / compliance if compliance > 0.0 else math.nan,
            1.0 / max(compliance + more, 1e-300),
            1.0 / (compliance - less) if compliance > less else math.inf,
        )

    @cached_property
    def force_limit(self) -> Estimate:
        """Force at gross slip [N] at the highest load; a lower bound if no loop reaches it."""
        return self.force_limit_at(None)

    def force_limit_at(self, normal_load: float | None) -> Estimate:
        """Return the force at gross slip [N] at a normal load [N]."""
        at = self._at(normal_load)
        a = max(rows.amplitude for rows in at.fit.rows)
        force = self._interval(at, lambda y: np.minimum(a, y))
        inner = 0.9 * a
        slope = self._interval(at, lambda y: np.minimum(a, y) - np.minimum(inner, y))
        further = slope.high * a / (a - inner)
        value, low, high = widened(*force, [self.gain_errors.get("force", 0.0) * force.value])
        if further > _FLAT * force.value:
            return Estimate(math.nan, low, math.inf)
        return Estimate(value, low, high + further)

    # -- the law ----------------------------------------------------------------------------------

    @cached_property
    def law(self) -> SliderLaw:
        """Friction law of sliders at the highest normal load, a backbone law."""
        return self.law_at(None)

    def law_at(self, normal_load: float | None) -> SliderLaw:
        """Return the friction law at a normal load [N]; of the joint alone if the rig was given."""
        at = self._at(normal_load)
        used = (at.fit.k > 0.0) & (at.y > 0.0)
        y, k = at.y[used], at.fit.k[used]
        order = np.argsort(y)
        y, k = y[order], k[order]
        if self._compliance:
            y, k = joint_alone(y, k, self._compliance)
        return SliderLaw(y, k, *self.amplitudes)

    # -- the second step --------------------------------------------------------------------------

    def interface(
        self,
        pair: MaterialPair | None = None,
        *,
        area: float | None = None,
        heights: Any = None,
        known: Mapping[str, Any] | None = None,
        contact_area: tuple[float, float, float] | None = None,
    ) -> InterfaceStep:
        """Fit the Greenwood interface to the quantities that the loops determine.

        Parameters
        ----------
        pair : MaterialPair, optional
            The two materials, needed to convert the fitted length ``slip_scale`` [m] to the
            standard deviation of heights [m].
        area : float, optional
            Apparent area [m^2], for densities of summits.
        heights : optional
            Distribution of summit heights, or a surface that gives the shape of the normal law: a
            TabulatedNormalLaw, a MeasuredContact, or a SphereOnFlat, which adds the parameter
            "radius". By default Gaussian heights.
        known : mapping, optional
            Measured parameters as (value, standard deviation), by name. Loops determine only a
            product of radius and density of the summits: give "radius" or "density" to get both.
            "summits" is the total number of summits, whose random heights widen the intervals.
        contact_area : tuple, optional
            Measured real contact area (value [m^2], uncertainty [m^2], normal load [N]), from which
            radius and density of the summits are determined separately.

        Returns
        -------
        InterfaceStep
            Parameters with intervals and verdicts, and the joint that they describe.

        Raises
        ------
        InputError
            For records without a normal load, or invalid arguments.
        """
        fit = self.fits[0]
        stiff = self.stiffness.value
        return interface_step(
            SufficientStatistics(
                fit, self._bands[id(fit)], self.rig_stiffness, self.rig_stiffness is None
            ),
            float(fit.k @ np.minimum(fit.largest, fit.thresholds())),
            stiff if math.isfinite(stiff) else 2.0 * self.stiffness.low,
            fit.friction is None or math.isfinite(self.force_limit.high),
            pair=pair,
            area=area,
            heights=heights,
            known=known,
            contact_area=contact_area,
        )

    @property
    def parameters(self) -> Mapping[str, Parameter]:
        """Parameters of the interface by name; empty if no interface was fitted."""
        return {} if self.step is None else self.step.parameters

    # -- the rig ----------------------------------------------------------------------------------

    @cached_property
    def rig(self) -> Estimate:
        """Rig stiffness [N/m] as given, or a lower bound: the initial stiffness of the loops."""
        if self.rig_stiffness is not None:
            value, error = self.rig_stiffness
            if math.isinf(value):
                return Estimate(value, value, value)
            return widened(value, value, value, [error])
        return Estimate(math.nan, self.stiffness.low, math.inf)

    @cached_property
    def masing(self) -> Masing:
        """Test whether the loops obey Masing's rules, with the likely cause if they do not."""
        return masing_of(self.fits)

    # -- the fit ----------------------------------------------------------------------------------

    @property
    def chi_squared(self) -> float:
        """Sum of squared residuals, each divided by the standard deviation of its noise [-]."""
        return sum(fit.chi_squared for fit in self.fits)

    @property
    def degrees_of_freedom(self) -> int:
        """Number of measured forces minus the number of fitted coefficients."""
        return sum(fit.freedom for fit in self.fits)

    @property
    def reduced_chi_squared(self) -> float:
        """Sum of squares over degrees of freedom [-]; about 1 if loops obey Masing's rules."""
        return self.chi_squared / self.degrees_of_freedom

    def __repr__(self) -> str:
        count = len(self.records)
        return (
            f"Identification({count} record{'s' if count > 1 else ''}, {self.series}, "
            f"reduced_chi_squared={self.reduced_chi_squared:.3g})"
        )


def _quantity_of(name: str, force: float, energy: float, a: float) -> tuple[float, float, float]:
    """Return a quantity at amplitude a [m], and its derivatives d/d(force) and d/d(energy)."""
    if name == "force":
        return force, 1.0, 0.0
    if name == "energy":
        return energy, 0.0, 1.0
    if name == "secant":
        return force / a, 1.0 / a, 0.0
    factor = (1.0 if name == "loss" else 0.5) / (math.pi * a * force)
    return factor * energy, -factor * energy / force, factor


def _total(at: _At, shape: Callable[[Floats], Floats], shift: float = 0.0) -> float:
    return float(at.fit.k @ shape(np.maximum(at.y + shift, 0.0)))


def _energy(at: _At, u: float) -> float:
    return _total(at, lambda y: 4.0 * y * np.maximum(u - y, 0.0))


def _sum(at: _At, u: Floats) -> Floats:
    return np.minimum(u[:, None], np.maximum(at.y, 0.0)) @ at.fit.k
