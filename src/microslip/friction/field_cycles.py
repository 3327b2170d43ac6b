"""Settled cycles of all nodes of a field under periodic displacements and separations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core import kernels
from microslip._core.checks import Floats, floats
from microslip._core.errors import InputError
from microslip._core.frozen import Locked, lock
from microslip._core.kernels import Integers
from microslip._core.threads import in_parts
from microslip.friction.cycles import rest_of
from microslip.friction.field_harmonics import FieldHarmonics
from microslip.friction.harmonic_basis import (
    MOST_ORDERS,
    Basis,
    coefficients_of,
    tolerance_error,
)
from microslip.friction.harmonics import checked_tolerance
from microslip.friction.memory import Nodes

_EMPTY = np.zeros(0)


class NodeCycles:
    """Settled cycles of nodes under periodic displacements [m] and separations.

    Displacements and ``steps`` have shape (nodes, samples). Steps are separations relative to those
    at rest, or None if constant. Places are (displacement - rest displacement)/kappa, with the slip
    per indentation kappa; ``rest`` is the result of :func:`rest_of`.

    Each node goes from rest in a straight line to the sample with the largest step + |place|, its
    root, where slip wipes out all memory; the cycle from the root is settled. If new contact that
    formed on the line still sticks at the root, two periods are computed, and the second is used.
    """

    def __init__(
        self, nodes: Nodes, displacements: Floats, steps: Floats | None, rest: tuple[Any, bool]
    ) -> None:
        begin, self._rest_is_mean = rest
        self.nodes, self.steps = nodes, steps
        # Full slip long before the clipping limit, which avoids overflow.
        with np.errstate(over="ignore"):
            moved = displacements - np.reshape(begin, (-1, 1))
            places = np.clip(moved / nodes.slips[:, None], -1e200, 1e200)
        self.places = np.ascontiguousarray(places)
        self._reach = nodes.reach(steps)

    def forces(self) -> tuple[Floats, Floats, Floats]:
        """Return forces [N], normal loads [N] and tangent stiffnesses [N/m], (nodes, samples)."""
        nodes, shape = self.nodes, self.places.shape
        force, load, stiffness = (np.empty(shape) for _ in range(3))
        kernels.compiled.field_cycle(
            self.places, self.steps, nodes.rests, shape[1], force, load, stiffness,
            *nodes.curve.arguments(*self._reach),
        )  # fmt: skip
        force *= nodes.weights[:, None]
        load *= nodes.scales[:, None]
        stiffness *= (nodes.weights / nodes.slips)[:, None]
        return force, load, stiffness

    def slopes(
        self, by_displacement: Floats, by_separation: Floats | None = None
    ) -> tuple[Floats, Floats]:
        """Return derivatives of forces and loads with respect to parameters of the motion.

        Arguments are derivatives of displacements and separations [m per unit of the parameter],
        shape (nodes or 1, samples, parameters). Results [N per unit] have the shape (nodes,
        samples, parameters). Separations are constant by default.
        """
        nodes, samples = self.places.shape
        count = by_displacement.shape[2]
        by_step = np.zeros((1, samples, 0)) if by_separation is None else by_separation
        steps = by_step.shape[2]
        force, load = np.empty((nodes, samples, count + steps)), np.empty((nodes, samples, steps))
        self._derive(by_displacement, by_step, _EMPTY, _EMPTY, force, _EMPTY, load)
        force, load = self._scaled(force, count, load)
        if not steps:
            return force, np.zeros_like(force)
        return force[:, :, :count] + force[:, :, count:], load

    def spectra(
        self, by_displacement: Floats, by_separation: Floats, analysis: Floats
    ) -> tuple[Floats, Floats, Floats, Floats]:
        """Return Fourier coefficients of forces, those of loads, and the derivatives of both.

        ``analysis``, shape (samples, coefficients), converts samples to coefficients. Other
        arguments are as for :meth:`slopes`. The four results are the coefficients of forces and of
        loads [N], shape (nodes, coefficients), the derivatives of the force coefficients and those
        of the load coefficients, shape (nodes, coefficients, columns). Derivatives of forces have
        one column for each parameter of the displacements, followed by one for each of the
        separations; derivatives of loads have only the columns of the separations.
        """
        size, count = self.nodes.size, analysis.shape[1]
        directions = by_displacement.shape[2] + by_separation.shape[2]
        force, load = np.empty((size, count)), np.empty((size, count))
        by_force = np.empty((size, count, directions))
        by_load = np.empty((size, count, by_separation.shape[2]))
        self._derive(by_displacement, by_separation, analysis, force, by_force, load, by_load)
        force *= self.nodes.weights[:, None]
        load *= self.nodes.scales[:, None]
        return force, load, *self._scaled(by_force, by_displacement.shape[2], by_load)

    def _scaled(self, force: Floats, places: int, load: Floats) -> tuple[Floats, Floats]:
        nodes = self.nodes
        force[:, :, :places] *= (nodes.weights / nodes.slips)[:, None, None]
        force[:, :, places:] *= nodes.per_length(nodes.weights[:, None, None])
        load *= nodes.per_length(nodes.scales[:, None, None])
        return force, load

    def _derive(
        self, by_place: Floats, by_step: Floats, analysis: Floats, spectrum: Floats,
        jacobian: Floats, load_spectrum: Floats, load_jacobian: Floats,
    ) -> None:  # fmt: skip
        if self._rest_is_mean:
            by_place = by_place - by_place.mean(axis=1, keepdims=True)
        kernels.compiled.field_slopes(
            self.places, self.steps, self.nodes.rests, self.places.shape[1],
            np.ascontiguousarray(by_place), by_place.shape[2],
            np.ascontiguousarray(by_step), by_step.shape[2], int(len(by_place) > 1),
            analysis, analysis.shape[-1], spectrum, jacobian, load_spectrum, load_jacobian,
            *self.nodes.curve.arguments(*self._reach),
        )  # fmt: skip


def from_root(places: Floats, steps: Floats | None) -> Integers:
    """Return sample indices of two periods of each cycle from its root; the second is settled."""
    samples = places.shape[1]
    root = np.argmax(np.abs(places) if steps is None else steps + np.abs(places), axis=1)
    return np.asarray((root[:, None] + np.arange(2 * samples)) % samples)


@dataclass(frozen=True, eq=False)
class FieldCycle(Locked):
    """Settled cycles of the nodes of a field, the result of :meth:`microslip.JointField.periodic`.

    After Jaeger (1998), DOI 10.1115/1.2833765, by memory diagrams (DOI 10.3389/fmech.2020.00030).
    """

    force: Floats
    """Tangential forces T [N], shape (nodes, samples)."""
    load: Floats
    """Normal loads N [N], shape (nodes, samples)."""
    stiffness: Floats
    """Tangent stiffnesses dT/d(displacement) at the end of each step [N/m], (nodes, samples)."""
    _cycles: NodeCycles

    def derivative(
        self, displacements: ArrayLike, separations: ArrayLike | None = None
    ) -> tuple[Floats, Floats]:
        """Compute derivatives of forces and loads with respect to parameters of the motion.

        Arguments are derivatives of displacements and separations [m per unit of the parameter],
        shape (samples, parameters) if equal for all nodes, or (nodes, samples, parameters). Both
        results have the latter shape [N per unit]. Separations are constant by default.
        """
        by_place, by_step = self._directions("displacements", displacements), None
        if separations is not None:
            if self._cycles.steps is None:
                raise InputError(
                    "`separations` must be None for a cycle at constant separations; give them to "
                    "periodic first"
                )
            by_step = self._directions("separations", separations)
            if by_step.shape != by_place.shape:
                raise InputError(
                    "`separations` must have the shape of `displacements`, got "
                    f"{np.shape(separations)} and {np.shape(displacements)}"
                )
        return self._cycles.slopes(by_place, by_step)

    def _directions(self, name: str, value: ArrayLike) -> Floats:
        nodes, samples = self.force.shape
        array = floats(name, value)
        fits = array.ndim in (2, 3) and array.shape[-2] == samples
        if not fits or (array.ndim == 3 and array.shape[0] != nodes):
            raise InputError(
                f"`{name}` must have the shape ({samples}, directions), or ({nodes}, {samples}, "
                f"directions), got {array.shape}"
            )
        return array.reshape(-1, *array.shape[-2:])


class SettledField:
    """Settled cycles and harmonics of nodes, the base class of :class:`microslip.JointField`."""

    _nodes: Nodes
    separations: Floats
    normal_loads: Floats

    def periodic(
        self,
        displacements: ArrayLike,
        separations: ArrayLike | None = None,
        rest: ArrayLike | str = 0.0,
    ) -> FieldCycle:
        """Compute the settled cycles of all nodes.

        Parameters
        ----------
        displacements : array_like
            One period of displacements [m], its first sample not repeated, shape (nodes, samples),
            or (samples,) if equal for all nodes.
        separations : array_like, optional
            Separations [m] at the same samples, constant by default. Contact may be lost.
        rest : array_like or "mean", optional
            Displacements [m] at which the nodes were free of force before the cycle, a number or
            one per node, or "mean" for the mean of each cycle. The mean force depends on it.

        Returns
        -------
        FieldCycle
            ``force`` and ``load`` [N], ``stiffness`` [N/m] and the method ``derivative``.

        Notes
        -----
        Each node goes from rest in a straight line of (separation, displacement) to the sample with
        the largest separation + |displacement|/kappa, with the slip per indentation kappa. There
        slip wipes out all memory of earlier motion, so the cycle from there is settled. If new
        contact that formed on the line still sticks at that sample, two periods are computed, and
        the second is used. The result does not depend on the first sample.
        """
        nodes = self._nodes
        x, steps = _per_sample(nodes, "displacements", displacements), None
        begin = rest_of(rest, x, nodes)
        if separations is not None:
            steps = self._steps_from_rest(_per_sample(nodes, "separations", separations))
            if steps.shape != x.shape:
                raise InputError(
                    "`displacements` and `separations` must have the same number of samples, got "
                    f"{x.shape[1]} and {steps.shape[1]}"
                )
        cycles = NodeCycles(nodes, x, steps, begin)
        force, load, stiffness = map(lock, cycles.forces())
        return FieldCycle(force, load, stiffness, cycles)

    def harmonics(
        self,
        coefficients: ArrayLike,
        harmonics: Any = (0, 1),
        *,
        separations: ArrayLike | None = None,
        rest: ArrayLike | str = 0.0,
        samples: int | None = None,
        rtol: float = 1e-10,
    ) -> FieldHarmonics:
        """Compute Fourier coefficients of the forces in the settled cycles, with their Jacobians.

        Parameters
        ----------
        coefficients : array_like
            Coefficients of the displacements [m], shape (nodes, coefficients), or (coefficients,)
            if equal for all nodes, in the order of ``harmonics``: [mean,] cos 1, sin 1, cos 3, sin
            3 for (0, 1, 3).
        harmonics : sequence of int, optional
            Orders of the harmonics, increasing; 0 is the mean.
        separations : array_like, optional
            Coefficients of the separations [m], same shape; constant separations by default.
            Coefficient 0 is the mean separation itself, not its difference from that at rest.
        rest : array_like or "mean", optional
            As for :meth:`periodic`.
        samples : int, optional
            Number of equidistant samples of the period [-]. By default the cycle is not sampled but
            integrated between its turning points and the kinks of the load curve, as described in
            :meth:`microslip.Interface.harmonics`.
        rtol : float, optional
            Tolerance of the coefficients relative to the largest force [-], if not sampled. That of
            the Jacobian relative to the largest stiffness is a hundred times larger.

        Returns
        -------
        FieldHarmonics
            ``force`` and, with ``separations``, ``load`` [N], shape (nodes, coefficients), and
            ``jacobian``: derivatives [N/m] of force coefficients (rows) with respect to
            displacement coefficients (columns), shape (nodes, coefficients, coefficients). With
            ``separations`` its shape is (nodes, 2, 2, coefficients, coefficients): derivatives of
            (force, load) with respect to (displacement, separation). Unpacks as ``force, jacobian``
            or ``force, load, jacobian``.

        Raises
        ------
        InputError
            If harmonics are above 200 without samples (above 5000 for few harmonics at constant
            separations), or a load curve has too many kinks for the tolerance.

        Notes
        -----
        For the harmonic balance method. With ``samples``, a turning point is up to half a sampling
        interval from the nearest sample, which gives an error of second order: with 64 samples and
        a third harmonic some 3e-3 of the force limit, and 8 % of the Jacobian.
        """
        nodes, basis = self._nodes, Basis(harmonics)
        if samples is None and separations is None:
            return constant_separation_harmonics(
                nodes, coefficients, basis, rest, checked_tolerance(rtol)
            )
        # If not sampled, a few samples check the separations and are used for nodes at rest.
        few = max(64, 8 * basis.orders[-1])
        waves, analysis = basis.sampled(few if samples is None else samples)
        rows = coefficients_of("coefficients", coefficients, basis, nodes.size)
        x = rows @ waves.T
        begin, is_mean = rest_of(rest, x, nodes)
        if separations is None:
            cycles = NodeCycles(nodes, x, None, (begin, is_mean))
            force, _, by_force, _ = cycles.spectra(
                waves[None], np.zeros((1, len(waves), 0)), analysis
            )
            return FieldHarmonics(force, None, by_force, np.full(nodes.size, np.nan))
        paths = coefficients_of("separations", separations, basis, nodes.size)
        steps = self._steps_from_rest(paths @ waves.T)
        if samples is not None:
            return _sampled(nodes, x, steps, (begin, is_mean), waves, analysis)
        means = rows[:, 0] if is_mean and basis.has_mean else begin
        if is_mean and not basis.has_mean:
            means = np.zeros(nodes.size)
        found = varying_harmonics(
            nodes, rows, paths, self.separations, means, basis, checked_tolerance(rtol)
        )
        force, jacobian = found.force, found.jacobian
        if is_mean and basis.has_mean:
            jacobian[:, 0, 0, :, 0] = 0.0  # the rest displacement shifts with the mean
        resting = np.flatnonzero(np.isnan(force[:, 0]))
        if resting.size:
            still = _sampled(nodes, x, steps, (begin, is_mean), waves, analysis)
            for part, other in zip(found, still, strict=True):
                part[resting] = other[resting]
        return found

    def _steps_from_rest(self, separations: Floats) -> Floats:
        checked = self._nodes.checked(separations)
        return np.ascontiguousarray(self._nodes.per_length(checked - self.separations[:, None]))


def _per_sample(nodes: Nodes, name: str, value: ArrayLike) -> Floats:
    """Check cycles of shape (samples,) or (nodes, samples); return shape (nodes, samples)."""
    array = floats(name, value, "m")
    if array.ndim not in (1, 2) or (array.ndim == 2 and array.shape[0] != nodes.size):
        raise InputError(
            f"`{name}` must have the shape ({nodes.size}, samples), or (samples,) if equal for all "
            f"nodes, got {array.shape}"
        )
    return np.ascontiguousarray(np.broadcast_to(array, (nodes.size, array.shape[-1])))


def _sampled(
    nodes: Nodes, x: Floats, steps: Floats, rest: tuple[Any, bool], waves: Floats, analysis: Floats
) -> FieldHarmonics:
    cycles = NodeCycles(nodes, x, steps, rest)
    force, load, by_force, by_load = cycles.spectra(waves[None], waves[None], analysis)
    size = analysis.shape[1]
    jacobian = np.zeros((nodes.size, 2, 2, size, size))
    jacobian[:, 0, 0], jacobian[:, 0, 1] = np.split(by_force, 2, axis=2)
    jacobian[:, 1, 1] = by_load
    return FieldHarmonics(force, load, jacobian, np.full(nodes.size, np.nan))


def _order_error(basis: Basis) -> InputError:
    return InputError(
        f"`harmonics` must not be above {MOST_ORDERS} without samples, got {basis.orders[-1]}; "
        f"use JointField.harmonics with samples={8 * basis.orders[-1]}"
    )


def varying_harmonics(
    nodes: Nodes,
    rows: Floats,
    paths: Floats,
    rests: Floats,
    begin: Floats,
    basis: Basis,
    rtol: float,
) -> FieldHarmonics:
    """Return Fourier coefficients of forces and loads, integrated piece by piece.

    ``rows`` are coefficients of displacements and ``paths`` those of separations [m], shape (nodes,
    coefficients). ``begin`` are the displacements and ``rests`` the separations at rest [m], one
    per node. Results are NaN for nodes that do not move.
    """
    if basis.orders[-1] > MOST_ORDERS:
        raise _order_error(basis)
    places, columns = basis.dense(rows)
    steps, _ = basis.dense(paths)
    steps[:, 0] -= rests
    steps = nodes.per_length(steps)
    with np.errstate(over="ignore"):  # full slip long before the clipping limit
        places = np.clip(
            (places - begin[:, None] * np.eye(1, places.shape[1])) / nodes.slips[:, None],
            -1e100,
            1e100,
        )
    span = np.abs(steps[:, 1:]).sum(axis=1)
    curve = nodes.curve.smooth_parts(*nodes.reach(steps[:, 0] - span, steps[:, 0] + span))
    size, wide = places.shape
    force, load, errors = np.zeros(places.shape), np.zeros(places.shape), np.zeros((size, 2))
    by_force, by_load = np.zeros((size, wide, 2 * wide)), np.zeros((size, wide, wide))

    def settle(part: slice) -> Any:
        return kernels.compiled.varying_harmonics(
            places[part], steps[part], part.stop - part.start, wide, rtol, force[part],
            by_force[part], load[part], by_load[part], errors[part], nodes.rests[part],
            *curve.arguments,
        )  # fmt: skip

    if any(in_parts(size, settle)):
        raise tolerance_error(rtol)
    jacobian = np.zeros((size, 2, 2, basis.size, basis.size))
    pick = np.ix_(range(size), columns, columns) if wide > basis.size else ...
    weights, scales = nodes.weights[:, None, None], nodes.scales[:, None, None]
    slopes = weights / nodes.slips[:, None, None]
    np.multiply(by_force[:, :, :wide][pick], slopes, out=jacobian[:, 0, 0])
    np.multiply(by_force[:, :, wide:][pick], nodes.per_length(weights), out=jacobian[:, 0, 1])
    np.multiply(by_load[pick], nodes.per_length(scales), out=jacobian[:, 1, 1])
    converged = errors[:, 0] <= rtol * errors[:, 1]
    force, load = force[:, columns] * weights[:, 0], load[:, columns] * scales[:, 0]
    return FieldHarmonics(force, load, jacobian, errors[:, 0] * nodes.weights, converged)


def constant_separation_harmonics(
    nodes: Nodes, coefficients: ArrayLike, basis: Basis, rest: ArrayLike | str, rtol: float
) -> FieldHarmonics:
    """Return Fourier coefficients of forces at constant separations, integrated piece by piece."""
    rows = coefficients_of("coefficients", coefficients, basis, nodes.size).copy()
    means = rows[:, :1] if basis.has_mean else np.zeros((nodes.size, 1))
    begin, is_mean = rest_of(rest, means, nodes)
    if is_mean:
        begin = 0.0
        rows[:, : basis.has_mean] = 0.0
    if not basis.in_kernel:
        raise _order_error(basis)
    curve = nodes.curve.smooth_parts(*nodes.reach(None))
    with np.errstate(over="ignore"):  # full slip long before the clipping limit
        places = np.clip(rows / nodes.slips[:, None], -1e100, 1e100)
        begin = np.clip(begin / nodes.slips, -1e100, 1e100)

    def kernel(rows: Floats, size: int, wide: int, rtol: float, *out: Floats) -> bool:
        force, jacobian, orders = out

        def settle(part: slice) -> Any:
            return kernels.compiled.field_harmonics(
                rows[part], part.stop - part.start, wide, rtol, force[part], jacobian[part],
                orders, nodes.rests[part], *curve.arguments,
            )  # fmt: skip

        return any(in_parts(size, settle))

    force, jacobian = basis.integrated(places, begin, rtol, kernel)
    force *= nodes.weights[:, None]
    jacobian *= (nodes.weights / nodes.slips)[:, None, None]
    if is_mean and basis.has_mean:
        jacobian[:, :, 0] = 0.0  # the rest displacement shifts with the mean
    return FieldHarmonics(force, None, jacobian)
