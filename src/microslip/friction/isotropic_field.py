"""Nodes that move in two tangential directions while their separation varies."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, floats
from microslip._core.frozen import Locked, lock
from microslip.errors import InputError
from microslip.friction.field_cycles import _coefficients, _orders, _samples, _transform
from microslip.friction.field_nodes import FieldNodes
from microslip.friction.vector_cycles import SETTLED, VectorCycle, settle, transform_slopes
from microslip.memory.vector_state import VectorState

_GRID = 4000  # places at which the load curve is looked at
_LIGHTEST_SHARE = 1e-3  # of the lightest node's load: knots are laid evenly down to it


@dataclass(frozen=True, eq=False)
class IsotropicField(Locked):
    """The nodes of a field in two directions, made by :meth:`microslip.JointField.two_directions`.

    Notes
    -----
    The memory of a varying load is, on a line, that of sliders over the separations eta: one holds
    g = integral of D from d to eta, of size eta - d at most, and T = mu times the integral of
    N''(eta) g over eta (the method of memory diagrams, DOI 10.3389/fmech.2020.00030, by parts).
    Here g is a vector that follows every step and slips along itself where its radius eta - d would
    be left. Assumed is what :class:`microslip.IsotropicJoint` assumes, and that a slider whose
    radius shrinks as contact is lost slips along what it holds. Along a line it is the coupled
    joint, at held separations the isotropic one, both with the load curve drawn as a polygon.
    """

    field: FieldNodes
    knots: Floats
    """Separations [m] between which the load curve is straight."""

    @cached_property
    def load_error(self) -> float:
        """Largest relative error of the polygon, which lies above the load curve [-].

        From the nearest separation to that of the lightest node at rest; forces err by no more
        than that of mu N at both ends of slip.
        """
        last = float(self.field.separations[self.field.normal_loads > 0.0].max())
        inner = self.knots[:-1][self.knots[1:] <= last]
        if not inner.size:
            inner = self.knots[:1]
        width = np.diff(self.knots)[: inner.size]
        middle = inner + 0.5 * width
        curve, origin = self.field._curve, self.field._curve.origin
        load = curve.load(middle - origin)[0]
        ends = curve.load(self.knots[: inner.size + 1] - origin)[0]
        return float(np.max(0.5 * (ends[:-1] + ends[1:]) / load - 1.0))

    @cached_property
    def resolution(self) -> Floats:
        """Amplitudes [m] below which a node dissipates next to nothing: kappa times a knot's step.

        Small cycles need more sliders: a cycle is met well from ten times that on.
        """
        at = np.clip(np.searchsorted(self.knots, self.field.separations), 1, self.knots.size - 1)
        return lock((self.knots[at] - self.knots[at - 1]) * self.field._slip)

    # What the state of sliders asks for.

    @cached_property
    def _tops(self) -> Floats:
        return lock(self.knots[1:] - self.field._curve.origin)

    @cached_property
    def _weights(self) -> Floats:
        """Bends of the polygon: what each slider adds to N of a separation before it."""
        loads = self.field._curve.load(self.knots - self.field._curve.origin)[0]
        slopes = -np.diff(np.append(loads[:-1], 0.0)) / np.diff(self.knots)
        return lock(slopes - np.append(slopes[1:], 0.0))

    @cached_property
    def _scales(self) -> Floats:
        return self.field._weights

    @property
    def _slips(self) -> Floats:
        return self.field._slip

    @property
    def _rests(self) -> Floats:
        return self.field._steps

    def _loads(self, step: Floats) -> tuple[Floats, Floats]:
        load, fall = self.field._curve.load(step.reshape(-1))
        scale = self.field._scale.reshape(-1, *[1] * (step.ndim - 1))
        return scale * load.reshape(step.shape), -scale * fall.reshape(step.shape)

    def _step_array(self, separations: ArrayLike) -> Floats:
        steps = self.field._step_array(separations)
        self._check_reach(steps)
        return steps

    def _check_reach(self, steps: Floats) -> None:
        nearest = float(self.knots[0]) - self.field._curve.origin
        if steps.min() < nearest:
            node = int(np.unravel_index(np.argmin(steps), steps.shape)[0])
            raise InputError(
                f"separations must not go below the nearest one that the sliders reach, "
                f"{self.knots[0]:g} m, got {steps.min() + self.field._curve.origin:g} at node "
                f"{node}; write two_directions(nearest=...)"
            )

    def start(self, *, energies: bool = False) -> VectorState:
        """A state of all nodes at rest, which may count ``energies`` at held separations."""
        return VectorState(self, False, bool(energies))

    def periodic(
        self,
        displacements: ArrayLike,
        separations: ArrayLike | None = None,
        *,
        tolerance: float = SETTLED,
    ) -> VectorCycle:
        """The settled cycles of all nodes, as one is of :meth:`microslip.IsotropicJoint.periodic`.

        Parameters
        ----------
        displacements : array_like
            One period of displacements [m], shape (nodes, samples, 2), its first sample not
            repeated.
        separations : array_like, optional
            Separations [m] at the same samples, shape (nodes, samples).
        tolerance : float, optional
            Share of the force limit [-], see there.

        Returns
        -------
        VectorCycle
            ``force`` and ``load`` [N], and ``derivative``, see there.
        """
        x = floats("displacements", displacements)
        size = self.field.size
        if x.ndim != 3 or x.shape[::2] != (size, 2):
            raise InputError(
                f"displacements must have the shape ({size}, samples, 2), got {x.shape}"
            )
        steps = np.repeat(self._rests[:, None], x.shape[1], axis=1)
        if separations is not None:
            d = floats("separations", separations)
            if d.shape != x.shape[:2]:
                raise InputError(f"separations must have the shape {x.shape[:2]}, got {d.shape}")
            steps = self.field._check_separations(d) - self.field._curve.origin
            self._check_reach(steps)
        places = x / self._slips[:, None, None]
        nothing = np.zeros((x.shape[1], 0))
        force, _, passes = settle(self, places, steps, nothing, nothing, tolerance)
        load = self._loads(steps)[0]
        return VectorCycle(lock(force), lock(load), passes, self, places, steps, tolerance)

    def harmonics(
        self,
        coefficients: ArrayLike,
        harmonics: Any = (0, 1),
        *,
        separations: ArrayLike | None = None,
        samples: int = 64,
        tolerance: float = SETTLED,
    ) -> tuple[Floats, ...]:
        """Fourier coefficients of the settled forces with their Jacobians.

        Parameters
        ----------
        coefficients : array_like
            Coefficients of both displacements [m], shape (nodes, 2, coefficients), in the order of
            ``harmonics``: [mean,] cos 1, sin 1, cos 3, sin 3 for (0, 1, 3).
        separations : array_like, optional
            Coefficients of the separations [m], shape (nodes, coefficients).
        harmonics, samples, tolerance : optional
            As those of :meth:`microslip.IsotropicJoint.harmonics`.

        Returns
        -------
        force : ndarray
            Coefficients of both forces [N], shape (nodes, 2, coefficients).
        load : ndarray
            Those of the normal loads [N], (nodes, coefficients), only with ``separations``.
        jacobian : ndarray
            Derivatives [N/m], shape (nodes, 2, 2, coefficients, coefficients); with
            ``separations`` (nodes, 3, 3, ...), of (T1, T2, N) by both displacements and the
            separation.
        """
        numbers = _orders(harmonics)
        basis, analysis = _transform(numbers, _samples(samples, numbers))
        count, size = basis.shape[1], self.field.size
        values = floats("coefficients", coefficients)
        if values.shape != (size, 2, count):
            raise InputError(
                f"coefficients must have the shape ({size}, 2, {count}), got {values.shape}"
            )
        places = np.einsum("tc,nic->nti", basis, values) / self._slips[:, None, None]
        steps = np.repeat(self._rests[:, None], basis.shape[0], axis=1)
        by_step = np.zeros((basis.shape[0], 0))
        if separations is not None:
            d = _coefficients(self.field, "separations", separations, count) @ basis.T
            steps = self.field._check_separations(d) - self.field._curve.origin
            self._check_reach(steps)
            by_step = basis
        force, slopes, _ = settle(self, places, steps, basis, by_step, tolerance)
        by_places, turned = transform_slopes(slopes, analysis, count, by_step.shape[1])
        spectrum = np.einsum("tc,nti->nic", analysis, force)
        if separations is None:
            return spectrum, by_places
        load, fall = self._loads(steps)
        jacobian = np.zeros((size, 3, 3, count, count))
        jacobian[:, :2, :2] = by_places
        jacobian[:, :2, 2] = turned
        jacobian[:, 2, 2] = np.einsum("tc,nt,tk->nck", analysis, fall, basis)
        return spectrum, load @ analysis, jacobian

    def __repr__(self) -> str:
        return f"IsotropicField({self.field!r}, sliders={self._tops.size})"


def knots_of(field: FieldNodes, sliders: int, nearest: float) -> Floats:
    """Knots from the nearest separation to where nothing is left, even in relative error.

    A chord of width h lies above N by h^2 N''/8 at most: knots that part the integral of
    sqrt(N''/N) evenly make that one share of N, down to where next to no load is left; a last
    chord ends the load.
    """
    curve, origin = field._curve, field._curve.origin
    parting = curve.parting() + origin
    grid = np.linspace(nearest, parting, _GRID + 1)
    load, fall = curve.load(grid - origin)
    loaded = field.normal_loads > 0.0
    last = field.separations[loaded].max() if loaded.any() else nearest
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
