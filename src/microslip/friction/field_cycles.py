"""Settled cycles of all nodes of a field at once, with their derivatives."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip import kernels
from microslip._core.checks import Floats, floats, is_whole, rising_orders, show
from microslip._core.frozen import Locked, lock
from microslip.errors import InputError
from microslip.friction.field_nodes import FieldNodes
from microslip.kernels import twin_field_cycles


@dataclass(frozen=True, eq=False)
class FieldCycle(Locked):
    """The settled cycles of the nodes of a field, made by :meth:`microslip.JointField.periodic`.

    After Jaeger (1998), DOI 10.1115/1.2833765, carried along the cycle (DOI
    10.3389/fmech.2020.00030).
    """

    force: Floats
    """Tangential forces T [N], shape (nodes, samples)."""
    load: Floats
    """Normal loads N [N], shape (nodes, samples)."""
    stiffness: Floats
    """Tangent stiffnesses dT/d(displacement) of each sample's step [N/m], (nodes, samples)."""
    _field: FieldNodes
    _places: Floats
    _steps: Floats | None
    _from_mean: bool

    def derivative(
        self, displacements: ArrayLike, separations: ArrayLike | None = None
    ) -> tuple[Floats, Floats]:
        """Derivatives of forces and loads [N a unit] along directions, down the tree.

        How displacements and separations [m a unit] change with each parameter is of the shape
        (samples, directions) for all nodes alike, or (nodes, samples, directions), which both
        answers have; without separations these do not change.
        """
        nodes, samples = self.force.shape
        by_place = self._directions("displacements", displacements)
        if separations is None:
            by_step = np.zeros((1, samples, 0))
        elif self._steps is None:
            raise InputError(
                "separations stayed at rest in this cycle: give periodic the separations, too"
            )
        else:
            by_step = self._directions("separations", separations)
            if by_step.shape != by_place.shape:
                raise InputError(
                    "separations must have the shape of displacements, got "
                    f"{np.shape(separations)} and {np.shape(displacements)}"
                )
        if self._from_mean:
            by_place = by_place - by_place.mean(axis=1, keepdims=True)
        places, steps = by_place.shape[2], by_step.shape[2]
        slopes = np.empty((nodes, samples, places + steps))
        load_slopes = np.empty((nodes, samples, steps))
        nothing = np.zeros(0)
        stride = int(by_place.shape[0] > 1)
        _slopes(
            self._field, self._places, self._steps, by_place, by_step, stride, nothing, 0,
            nothing, slopes, nothing, load_slopes,
        )  # fmt: skip
        weights = self._field._weights[:, None, None]
        force = weights / self._field._slip[:, None, None] * slopes[:, :, :places]
        if not steps:
            return force, np.zeros_like(force)
        force += weights * slopes[:, :, places:]
        return force, self._field._scale[:, None, None] * load_slopes

    def _directions(self, name: str, value: ArrayLike) -> Floats:
        nodes, samples = self.force.shape
        array = floats(name, value)
        fits = array.ndim in (2, 3) and array.shape[-2] == samples
        if not fits or (array.ndim == 3 and array.shape[0] != nodes):
            raise InputError(
                f"{name} must have the shape ({samples}, directions), or ({nodes}, {samples}, "
                f"directions), got {array.shape}"
            )
        return array.reshape(-1, *array.shape[-2:])


class SettledField:
    """Settled cycles and harmonics of nodes, as :class:`microslip.JointField` has them."""

    def periodic(
        self: FieldNodes,
        displacements: ArrayLike,
        separations: ArrayLike | None = None,
        rest: ArrayLike | str = 0.0,
    ) -> FieldCycle:
        """The settled cycles of all nodes.

        Parameters
        ----------
        displacements : array_like
            One period of displacements [m], its first sample not repeated, shape (nodes, samples),
            or (samples,) for all nodes alike.
        separations : array_like, optional
            Separations [m] at the same samples; without them the nodes stay at their own. Contact
            may be lost and found again.
        rest : array_like or "mean", optional
            Displacements [m] at which the nodes rest without a force, one number or one a node,
            or the mean of each cycle. With a mean displacement the settled mean force depends on
            it.

        Returns
        -------
        FieldCycle
            ``force`` and ``load`` [N], ``stiffness`` [N/m] and ``derivative``, see there.

        Notes
        -----
        Each node goes from rest in a straight line of (separation, displacement) to the sample
        where separation + |displacement|/kappa is largest; there all other memory is gone, and the
        cycle that begins there has settled. Where that path pressed new contact down sticking, one
        more cycle follows. It does not matter with which sample a cycle begins.
        """
        x = _cycles(self, "displacements", displacements)
        start, from_mean = _rest(self, rest, x)
        # Beyond 1e200 slips there is no more to come, but numbers that overflow.
        with np.errstate(over="ignore"):
            places = np.clip((x - start[:, None]) / self._slip[:, None], -1e200, 1e200)
        steps = None
        if separations is not None:
            steps = _steps(self, _cycles(self, "separations", separations))
            if steps.shape != x.shape:
                raise InputError(
                    "displacements and separations must have as many samples, got "
                    f"{x.shape[1]} and {steps.shape[1]}"
                )
        force, load, slope = (np.empty(x.shape) for _ in range(3))
        arguments = places, steps, self._steps, x.shape[1], force, load, slope
        profile = _profile(self, steps)
        if profile is None:
            twin_field_cycles.field_cycle(*arguments, self._curve)
        else:
            kernels.active.field_cycle(*arguments, *profile.arguments)
        force *= self._weights[:, None]
        load *= self._scale[:, None]
        slope *= (self._weights / self._slip)[:, None]
        return FieldCycle(lock(force), lock(load), lock(slope), self, places, steps, from_mean)

    def harmonics(
        self: FieldNodes,
        coefficients: ArrayLike,
        harmonics: Any = (0, 1),
        *,
        separations: ArrayLike | None = None,
        rest: ArrayLike | str = 0.0,
        samples: int = 64,
    ) -> tuple[Floats, ...]:
        """Fourier coefficients of the settled forces with their Jacobians: balance of harmonics.

        Parameters
        ----------
        coefficients : array_like
            Coefficients of the displacements [m], shape (nodes, coefficients), or one row for all,
            in the order of ``harmonics``: [mean,] cos 1, sin 1, cos 3, sin 3 for (0, 1, 3).
        harmonics : sequence of int, optional
            Numbers of the harmonics, rising; 0 is the mean.
        separations : array_like, optional
            Coefficients of the separations [m], of the same shape; without them the nodes stay at
            their own. Their mean is the mean separation, not its change.
        rest : array_like or "mean", optional
            As for :meth:`periodic`.
        samples : int, optional
            Equidistant samples of the period [-].

        Returns
        -------
        force : ndarray
            Coefficients of the forces [N], shape (nodes, coefficients).
        load : ndarray
            Those of the normal loads [N], only with ``separations``.
        jacobian : ndarray
            Derivatives [N/m] of force coefficients (rows) by displacement coefficients (columns),
            shape (nodes, coefficients, coefficients). With ``separations`` the shape is (nodes,
            2, 2, coefficients, coefficients): those of (force, load) by (displacement, separation).

        Notes
        -----
        The derivative runs down the tree of reversals and is exactly that of the sampled cycle.
        Samples miss the true turning points by up to half a step, which is an error of second
        order.
        """
        numbers = _orders(harmonics)
        basis, analysis = _transform(numbers, _samples(samples, numbers))
        count = basis.shape[1]
        x = _coefficients(self, "coefficients", coefficients, count) @ basis.T
        start, from_mean = _rest(self, rest, x)
        places = (x - start[:, None]) / self._slip[:, None]
        by_place = basis
        if from_mean and numbers[0] == 0:  # it moves along
            by_place = basis.copy()
            by_place[:, 0] = 0.0
        steps, by_step = None, np.zeros((basis.shape[0], 0))
        if separations is not None:
            steps = _steps(self, _coefficients(self, "separations", separations, count) @ basis.T)
            by_step = basis
        columns, step_count = count + by_step.shape[1], by_step.shape[1]
        spectrum, load_spectrum = np.empty((self.size, count)), np.empty((self.size, count))
        jacobian = np.empty((self.size, count, columns))
        load_jacobian = np.empty((self.size, count, step_count))
        _slopes(
            self, places, steps, by_place[None], by_step[None], 0, analysis, count,
            spectrum, jacobian, load_spectrum, load_jacobian,
        )  # fmt: skip
        weights = self._weights[:, None, None]
        spectrum *= self._weights[:, None]
        jacobian[:, :, :count] *= weights / self._slip[:, None, None]
        if separations is None:
            return spectrum, jacobian
        load_spectrum *= self._scale[:, None]
        tangent = np.zeros((self.size, 2, 2, count, count))
        tangent[:, 0, 0] = jacobian[:, :, :count]
        tangent[:, 0, 1] = weights * jacobian[:, :, count:]
        tangent[:, 1, 1] = self._scale[:, None, None] * load_jacobian
        return spectrum, load_spectrum, tangent


def _slopes(
    field: FieldNodes,
    places: Floats,
    steps: Floats | None,
    by_place: Floats,
    by_step: Floats,
    stride: int,
    weights: Floats,
    rows: int,
    *results: Floats,
) -> None:
    """The kernel's derivatives, or its twin's for a law without a profile."""
    arguments = (
        np.ascontiguousarray(places), steps, field._steps, places.shape[1],
        np.ascontiguousarray(by_place), by_place.shape[2],
        np.ascontiguousarray(by_step), by_step.shape[2], stride, weights, rows, *results,
    )  # fmt: skip
    profile = _profile(field, steps)
    if profile is None:
        twin_field_cycles.field_slopes(*arguments, field._curve)
    else:
        kernels.active.field_slopes(*arguments, *profile.arguments)


def _profile(field: FieldNodes, steps: Floats | None) -> Any:
    low = float(field._steps.min())
    if steps is not None:
        low = min(low, float((steps + field._steps[:, None]).min()))
    return field._curve.profile(low)


# -- what comes in --------------------------------------------------------------------------------


def _cycles(field: FieldNodes, name: str, value: ArrayLike) -> Floats:
    """One cycle a node, or one for all, as (nodes, samples)."""
    array = floats(name, value)
    if array.ndim not in (1, 2) or (array.ndim == 2 and array.shape[0] != field.size):
        raise InputError(
            f"{name} must have the shape ({field.size}, samples), or (samples,) for all nodes "
            f"alike, got {array.shape}"
        )
    return np.ascontiguousarray(np.broadcast_to(array, (field.size, array.shape[-1])))


def _coefficients(field: FieldNodes, name: str, value: ArrayLike, count: int) -> Floats:
    array = floats(name, value)
    if array.shape not in ((count,), (field.size, count)):
        raise InputError(
            f"{name} must have the shape ({field.size}, {count}), a row a node in the order of the "
            f"harmonics, or ({count},) for all alike, got {array.shape}"
        )
    return np.broadcast_to(array, (field.size, count))


def _steps(field: FieldNodes, separations: Floats) -> Floats:
    """Separations from each node's own at rest."""
    field._check_separations(separations)
    return np.ascontiguousarray(separations - field.separations[:, None])


def _rest(field: FieldNodes, rest: Any, x: Floats) -> tuple[Floats, bool]:
    """Displacements at rest, and whether they are the means of the cycles."""
    if isinstance(rest, str):
        if rest != "mean":
            raise InputError(f'rest must be a displacement [m] or "mean", got {show(rest)}')
        return np.asarray(x.mean(axis=1)), True
    return field._per_node("rest", rest), False


def _orders(value: Any) -> tuple[int, ...]:
    orders = rising_orders("harmonics", value)
    if not orders:
        raise InputError("harmonics must be at least one, such as [0, 1, 3], got none")
    return orders


def _samples(samples: Any, orders: tuple[int, ...]) -> int:
    fewest = 2 * orders[-1] + 1
    if not is_whole(samples) or not fewest <= samples <= 1 << 20:
        raise InputError(
            f"samples must be a whole number, at least {fewest} for harmonic {orders[-1]}, "
            f"got {show(samples)}"
        )
    return int(samples)


@lru_cache(maxsize=32)
def _transform(orders: tuple[int, ...], samples: int) -> tuple[Floats, Floats]:
    """Columns [mean,] cos, sin ... at the samples, and what takes samples back to coefficients."""
    turns = np.arange(samples) / samples
    columns: list[Floats] = []
    factors: list[float] = []
    for n in orders:
        angle = 2.0 * math.pi * ((n * turns) % 1.0)
        columns += [np.ones(samples)] if n == 0 else [np.cos(angle), np.sin(angle)]
        factors += [1.0] if n == 0 else [2.0, 2.0]
    basis = np.ascontiguousarray(np.stack(columns, axis=1))
    return lock(basis), lock(np.ascontiguousarray(basis * (np.array(factors) / samples)))
