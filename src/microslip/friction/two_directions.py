"""Joints in two tangential directions, at constant or varying separations."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import (
    LARGEST,
    Floats,
    exact,
    floats,
    number,
    show,
    whole_number,
)
from microslip._core.errors import InputError
from microslip._core.frozen import Locked, lock
from microslip.contact.base import NormalLaw
from microslip.friction.base import BackboneLaw
from microslip.friction.field_cycles import SettledField
from microslip.friction.field_harmonics import FieldHarmonics
from microslip.friction.iwan import Iwan
from microslip.friction.memory import SliderBank, VectorState
from microslip.friction.vector_cycles import (
    SETTLED,
    VectorCycle,
    settled_harmonics,
    settled_vectors,
)

_MOST_SLIDERS = 100_000
_GRID = 4000  # separations at which the load curve is evaluated
_LIGHTEST_SHARE = 1e-3  # smallest resolved load over that of the lightest node

# -- constant load --------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class IsotropicJoint(Locked):
    """Joint in two tangential directions, isotropic, at a constant normal load.

    Parameters
    ----------
    joint : BackboneLaw
        Law along any line, with finite stiffness at rest.
    sliders : int, optional
        Number of sliders [-] that approximate the slider density, 1 to 100 000.
    smallest_amplitude, largest_amplitude : float, optional
        Range of amplitudes [m] of the approximation, see :meth:`BackboneLaw.to_iwan`; by default
        0.01 to 10 times the displacement force_limit / tangential_stiffness.

    Notes
    -----
    No law in closed form is known for two directions: even for one sphere the force depends on the
    path (Mindlin and Deresiewicz 1953, DOI 10.1115/1.4010702). The model assumes that every slider
    of the law (Iwan 1966, DOI 10.1115/1.3625199) has the same limit in all directions, slips along
    its force, and is independent of other sliders. Along a line it equals the joint up to the error
    in ``line.fit``; the force limit is exact. A straight path gives the same result in one step as
    in many, and stiffnesses are derivatives of the force at the end of the step.
    """

    joint: BackboneLaw
    sliders: int = 64
    smallest_amplitude: float | None = field(default=None, kw_only=True)
    largest_amplitude: float | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        if not isinstance(self.joint, BackboneLaw):
            raise InputError(f"`joint` must be a backbone law, got {show(self.joint)}")
        whole_number("sliders", self.sliders, 1, _MOST_SLIDERS)
        _ = self.line  # raises InputError for an invalid joint or range

    @cached_property
    def line(self) -> Iwan:
        """Law for motion along any line: an Iwan model, whose ``fit`` holds its errors."""
        reach = self.joint.force_limit / self.joint.tangential_stiffness
        low = self.smallest_amplitude
        if low is None and self.largest_amplitude is None and math.isfinite(reach) and reach > 0.0:
            low = 0.01 * reach
        model: Iwan = self.joint.to_iwan(
            int(self.sliders), smallest_amplitude=low, largest_amplitude=self.largest_amplitude
        )
        return model

    @property
    def force_limit(self) -> float:
        """Force of gross slip in any direction [N]."""
        return self.line.force_limit

    @cached_property
    def _bank(self) -> SliderBank:
        sliders = self.line.sliders()
        tops, weights = np.array(sliders.yield_displacements), np.array(sliders.stiffnesses)
        return SliderBank(lock(tops), lock(weights), None)

    def start(self, *, energies: bool = False) -> VectorState:
        """Return a state at rest, whose arrays have no axis of nodes.

        If ``energies`` is true, it accumulates the dissipated energy.
        """
        return VectorState(self._bank, bool(energies))

    def force(self, displacement: ArrayLike) -> Floats:
        """Compute forces [N] for a path of displacements [m] from rest, both of shape (n, 2)."""
        x = _path("displacement", displacement)
        state, forces = self.start(), np.empty(x.shape)
        for i, row in enumerate(x):
            forces[i], _ = state.try_(row)
            state.commit()
        return forces

    def periodic(
        self, displacement_cycle: ArrayLike, *, tolerance: float = SETTLED, start: str = "farthest"
    ) -> VectorCycle:
        """Compute the settled cycle of a periodic path.

        Parameters
        ----------
        displacement_cycle : array_like
            One period of displacements [m], shape (samples, 2), its first sample not repeated.
        tolerance : float, optional
            Largest distance of the forces from the limit cycle over the force limit [-]. The cycle
            is repeated for up to 2000 periods; ``converged`` and ``residual`` of the result state
            whether the tolerance was reached.
        start : {"farthest", "first"}, optional
            Sample to which the joint goes from rest in a straight line before it follows the cycle:
            the one farthest from rest, or the first one, as for a state that starts at rest. If the
            cycle has a mean displacement, the mean force depends on it: by 0.5 % of the force limit
            (median), up to 18 %, over 60 random ellipses with amplitudes and means near 0.3 um.

        Returns
        -------
        VectorCycle
            ``force`` [N], shape (samples, 2), and the method ``derivative``.
        """
        x = _path("displacement_cycle", displacement_cycle)[None]
        return settled_vectors(self._bank, x, None, np.zeros(x.shape[:2]), tolerance, start)

    def harmonics(
        self,
        coefficients: ArrayLike,
        harmonics: Any = (0, 1),
        *,
        samples: int = 64,
        tolerance: float = SETTLED,
        start: str = "farthest",
    ) -> FieldHarmonics:
        """Compute Fourier coefficients of the settled force and their Jacobian.

        Parameters
        ----------
        coefficients : array_like
            Coefficients of both displacements [m], shape (2, coefficients), in the order of
            ``harmonics``: [mean,] cos 1, sin 1, cos 3, sin 3 for (0, 1, 3).
        harmonics : sequence of int, optional
            Orders of the harmonics, increasing; 0 is the mean.
        samples : int, optional
            Number of equidistant samples of the period [-]; the error is of second order in their
            spacing.
        tolerance : float, optional
            As for :meth:`periodic`.
        start : {"farthest", "first"}, optional
            As for :meth:`periodic`; the first sample is at time 0.

        Returns
        -------
        FieldHarmonics
            ``force`` [N], shape (2, coefficients), ``jacobian`` [N/m], shape (2, 2, coefficients,
            coefficients): ``jacobian[i, j, m, n]`` is the derivative of coefficient m of force i
            with respect to coefficient n of displacement j; ``converged`` and ``residual`` [N],
            shape (1,).
        """
        return settled_harmonics(
            self._bank, coefficients, harmonics, None, samples, tolerance, start
        )

    def __repr__(self) -> str:
        return f"IsotropicJoint({self.joint!r}, sliders={self._bank.tops.size})"


def _path(name: str, value: ArrayLike) -> Floats:
    array = floats(name, value, "m")
    if array.ndim != 2 or array.shape[1] != 2:
        raise InputError(f"`{name}` must have the shape (samples, 2), got {array.shape}")
    return array


# -- varying separations --------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class IsotropicField(Locked):
    """Nodes of a field in two directions; see :meth:`microslip.JointField.two_directions`.

    Notes
    -----
    In one direction, a memory diagram D (DOI 10.3389/fmech.2020.00030) at separation d is
    equivalent to sliders at all separations eta > d. The spring of a slider is deflected by g, the
    integral of D from d to eta, |g| <= eta - d, and T is mu times the integral of N''(eta) g over
    eta. Here g is a vector that follows every step; if it becomes longer than the radius eta - d,
    it is shortened to it. The assumptions are those of :class:`microslip.IsotropicJoint`; in
    addition a slider whose radius shrinks as contact is lost slips along its force. Along a line
    the model equals a :class:`microslip.Interface` under varying load, at constant separations an
    IsotropicJoint, both with a piecewise linear load curve.

    For a :class:`microslip.MeasuredContact` with a ``direction``, which is that of the first
    displacement, the stiffness is a 2 x 2 tensor fixed by the lay (the direction of machining
    marks), and slip is along the force of the slider. Each step is then divided into eight
    substeps. Along a line this is exact; if a slider force changes direction within one long step,
    its error is up to 0.015 of its magnitude.
    """

    field: SettledField
    knots: Floats
    """Separations [m] on the load curve of the surface at the corners of its piecewise linear
    approximation."""

    @cached_property
    def load_error(self) -> float:
        """Largest relative error of the piecewise linear load curve [-].

        The largest value is taken over separations from the smallest one to that of the most
        lightly loaded node at rest. A force is mu times the difference of the loads N at the
        separation and at the slip front; each of these loads has at most this relative error.
        """
        last = float(_places_at_rest(self.field)[self.field.normal_loads > 0.0].max())
        inner = self.knots[:-1][self.knots[1:] <= last]
        if not inner.size:
            inner = self.knots[:1]
        width = np.diff(self.knots)[: inner.size]
        middle = inner + 0.5 * width
        curve = self.field._nodes.curve
        origin = curve.origin
        load = curve.load(middle - origin)[0]
        ends = curve.load(self.knots[: inner.size + 1] - origin)[0]
        return float(np.max(0.5 * (ends[:-1] + ends[1:]) / load - 1.0))

    @cached_property
    def resolution(self) -> Floats:
        """Amplitudes [m] below which nodes do not dissipate: kappa times the spacing of ``knots``.

        Energies are accurate above ten times this amplitude; smaller cycles need more sliders.
        """
        places = _places_at_rest(self.field)
        at = np.clip(np.searchsorted(self.knots, places), 1, self.knots.size - 1)
        return lock((self.knots[at] - self.knots[at - 1]) * self.field._nodes.slips)

    @cached_property
    def _bank(self) -> SliderBank:
        nodes = self.field._nodes
        steps = self.knots - nodes.curve.origin
        # Changes of slope of the polygon: the weight of each slider in N.
        loads = nodes.curve.load(steps)[0]
        slopes = -np.diff(np.append(loads[:-1], 0.0)) / np.diff(self.knots)
        bends = slopes - np.append(slopes[1:], 0.0)
        return SliderBank(
            lock(steps[1:].copy()), lock(bends), nodes, float(steps[0]),
            nodes.curve.surface._lay,
        )  # fmt: skip

    def start(self, *, energies: bool = False) -> VectorState:
        """Return a state of all nodes at rest.

        If ``energies`` is true, it accumulates the dissipated energy.
        """
        return VectorState(self._bank, bool(energies))

    def periodic(
        self,
        displacements: ArrayLike,
        separations: ArrayLike | None = None,
        *,
        tolerance: float = SETTLED,
        start: str = "farthest",
    ) -> VectorCycle:
        """Compute the settled cycles of all nodes.

        Parameters
        ----------
        displacements : array_like
            One period of displacements [m], shape (nodes, samples, 2), its first sample not
            repeated.
        separations : array_like, optional
            Separations [m] at the same samples, shape (nodes, samples), constant by default.
        tolerance : float, optional
            Tolerance over the force limit [-], see :meth:`microslip.IsotropicJoint.periodic`.
        start : {"farthest", "first"}, optional
            Path from rest to the cycle, see :meth:`microslip.IsotropicJoint.periodic`.

        Returns
        -------
        VectorCycle
            ``force`` and ``load`` [N] and the method ``derivative``.
        """
        x, bank = floats("displacements", displacements, "m"), self._bank
        if x.ndim != 3 or x.shape[::2] != (bank.size, 2):
            raise InputError(
                f"`displacements` must have the shape ({bank.size}, samples, 2), got {x.shape}"
            )
        steps = np.repeat(bank.rests[:, None], x.shape[1], axis=1)
        if separations is not None:
            d = floats("separations", separations, "m")
            if d.shape != x.shape[:2]:
                raise InputError(f"`separations` must have the shape {x.shape[:2]}, got {d.shape}")
            steps = bank.steps_at(d)
        return settled_vectors(bank, x, lock(bank.loads(steps)[0]), steps, tolerance, start)

    def harmonics(
        self,
        coefficients: ArrayLike,
        harmonics: Any = (0, 1),
        *,
        separations: ArrayLike | None = None,
        samples: int = 64,
        tolerance: float = SETTLED,
        start: str = "farthest",
    ) -> FieldHarmonics:
        """Compute Fourier coefficients of the settled forces and their Jacobians.

        Parameters
        ----------
        coefficients : array_like
            Coefficients of both displacements [m], shape (nodes, 2, coefficients), in the order of
            ``harmonics``: [mean,] cos 1, sin 1, cos 3, sin 3 for (0, 1, 3).
        separations : array_like, optional
            Coefficients of the separations [m], shape (nodes, coefficients).
        harmonics, samples, tolerance, start : optional
            As for :meth:`microslip.IsotropicJoint.harmonics`.

        Returns
        -------
        FieldHarmonics
            ``force`` [N], shape (nodes, 2, coefficients); ``load`` [N], (nodes, coefficients), with
            ``separations``; ``jacobian`` [N/m], shape (nodes, 2, 2, coefficients, coefficients),
            with ``separations`` (nodes, 3, 3, ...), derivatives of (T1, T2, N) with respect to both
            displacements and the separation; ``converged`` and ``residual`` [N], shape (nodes,).
            For a node that has not converged, all results are those of its last period.
        """
        return settled_harmonics(
            self._bank, coefficients, harmonics, separations, samples, tolerance, start
        )

    def __repr__(self) -> str:
        return f"IsotropicField({self.field!r}, sliders={self._bank.tops.size})"


def _places_at_rest(field: SettledField) -> Floats:
    return field._nodes.curve.origin + field._nodes.rests


def two_directions(field: SettledField, sliders: Any, nearest: Any) -> IsotropicField:
    """Return the field in two directions; see :meth:`microslip.JointField.two_directions`."""
    count = whole_number("sliders", sliders, 2, _MOST_SLIDERS)
    curve, surface = field._nodes.curve, field._nodes.curve.surface
    smallest = float(_places_at_rest(field).min())
    if nearest is None:
        load, fall = curve.load(np.zeros(1))
        near = min(smallest, curve.origin) - float(load[0] / fall[0])
        near = max(near, _smallest_separation(surface))
    else:
        near = number("nearest", nearest, "m")
        if near > smallest:
            raise InputError(
                f"`nearest` must not be above the smallest separation at rest, {smallest:g} m, "
                f"got {exact(near)}"
            )
        surface._separations(np.array([near]))
    return IsotropicField(field, _knots_of(field, count, near))


def _smallest_separation(surface: NormalLaw) -> float:
    """Return the smallest separation [m] for which the surface is defined."""
    lowest = float(surface._span[0])
    try:
        surface._separations(np.array([lowest - 1e-3 * abs(lowest) - 1e-12]))
    except InputError:
        return lowest
    return -LARGEST


def _knots_of(field: SettledField, sliders: int, nearest: float) -> Floats:
    """Return separations [m] of knots from ``nearest`` to zero load, for a uniform relative error.

    A chord of N(d) over a width h is above N by up to h^2 N''/8. Knots that divide the integral of
    sqrt(N''/N) evenly make this a constant fraction of N, down to a negligible load.
    """
    curve = field._nodes.curve
    origin = curve.origin
    parting = curve.parting() + origin
    grid = np.linspace(nearest, parting, _GRID + 1)
    load, fall = curve.load(grid - origin)
    loaded = field.normal_loads > 0.0
    last = _places_at_rest(field)[loaded].max() if loaded.any() else nearest
    lightest = _LIGHTEST_SHARE * float(curve.load(np.array([last - origin]))[0][0])
    loaded_places = np.flatnonzero(load > lightest)
    end = grid[min(loaded_places[-1] + 1, _GRID)] if loaded_places.size else parting
    grid = np.linspace(nearest, end, _GRID + 1)
    load, fall = curve.load(grid - origin)
    middle = np.maximum(0.5 * (load[:-1] + load[1:]), lightest)
    masses = np.sqrt(np.diff(grid) * np.maximum(fall[:-1] - fall[1:], 0.0) / middle)
    parts = np.append(0.0, np.cumsum(masses))
    count = sliders if end < parting else sliders + 1
    knots = np.interp(np.linspace(0.0, parts[-1], count), parts, grid)
    knots[0] = nearest
    return lock(np.append(knots, parting) if end < parting else knots)
