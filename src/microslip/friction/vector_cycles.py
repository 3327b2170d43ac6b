"""Settled cycles of sliders in two directions, with derivatives and harmonics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from microslip._core import kernels
from microslip._core.checks import Floats, floats, positive, show
from microslip._core.errors import InputError
from microslip._core.frozen import Locked, lock
from microslip._core.kernels import Integers
from microslip._core.threads import in_parts
from microslip.friction.field_harmonics import Bools, FieldHarmonics
from microslip.friction.harmonic_basis import Basis, coefficients_of
from microslip.friction.memory import SliderBank

_PASSES = 2000  # largest number of periods of a slider, besides Newton steps
SETTLED = 1e-6
"""Default tolerance of a settled cycle over the force limit."""
STARTS = ("farthest", "first")


@dataclass(frozen=True, eq=False)
class VectorCycle(Locked):
    """Settled cycles in two directions, the result of the ``periodic`` methods.

    The sliders are those of Iwan (1966, DOI 10.1115/1.3625199), each with a spring whose deflection
    is a vector.
    """

    force: Floats
    """Forces (T1, T2) [N], shape (nodes, samples, 2), or (samples, 2) for a single joint."""
    load: Floats | None
    """Normal loads [N], shape (nodes, samples); None for a single joint."""
    passes: Integers
    """Number of periods [-] until the slowest slider of each node settled, shape (nodes,)."""
    residual: Floats
    """Estimated distance of the force of each node from the limit cycle [N], shape (nodes,)."""
    converged: Bools
    """True for each node whose residual is within the tolerance, shape (nodes,)."""
    _bank: SliderBank
    _places: Floats
    _steps: Floats
    _tolerance: float
    _start: str

    def derivative(self, directions: ArrayLike, separations: ArrayLike | None = None) -> Floats:
        """Compute derivatives of the forces with respect to parameters of the motion.

        ``directions``, shape (samples, directions), are derivatives of a displacement with respect
        to parameters [m per unit], common to all nodes. Each column is used twice: for a parameter
        of the first displacement, and for another one of the second. ``separations``, shape
        (samples, k), are derivatives of the separation with respect to k further parameters.

        The result [N per unit] has the shape (nodes, samples, 2, 2 * directions + k), without the
        first axis for a single joint. The third axis is the force component; the last has the
        parameters of the first displacement, then of the second, then of the separation.
        """
        samples = self._places.shape[1]
        by = [_directions("directions", directions, samples)]
        if separations is not None:
            by.append(_directions("separations", separations, samples))
        slopes = _settle(
            self._bank, self._places, self._steps, self._tolerance, self._start, *by
        ).slopes
        if separations is not None:
            columns = slopes[..., 2 * by[0].shape[1] :]
            columns[...] = self._bank.per_length(columns)
        return slopes[0] if self.force.ndim == 2 else slopes


def _directions(name: str, value: ArrayLike, samples: int) -> Floats:
    array = floats(name, value)
    if array.ndim != 2 or array.shape[0] != samples:
        raise InputError(f"`{name}` must have the shape ({samples}, directions), got {array.shape}")
    return array


class _Settled(NamedTuple):
    force: Floats  # [N], (nodes, samples, 2)
    slopes: Floats  # derivatives [N per unit], (nodes, samples, 2, columns)
    passes: Integers  # (nodes,)
    residual: Floats  # [N], (nodes,)
    converged: Bools  # (nodes,)


def _settle(
    bank: SliderBank,
    places: Floats,
    steps: Floats,
    tolerance: Any,
    start: Any = "farthest",
    by_place: Floats | None = None,
    by_step: Floats | None = None,
) -> _Settled:
    """Repeat the cycle of each node until it settles; return forces and their derivatives.

    ``places`` are slider coordinates and ``steps`` separations from the origin of the load curve at
    the samples [m], see :class:`.SliderBank`. ``by_place`` and ``by_step`` are the ``directions``
    and ``separations`` of :meth:`VectorCycle.derivative`.
    """
    nothing = np.zeros((places.shape[1], 0))
    by_place = nothing if by_place is None else by_place
    by_step = nothing if by_step is None else by_step
    if start not in STARTS:
        raise InputError(f'`start` must be "farthest" or "first", got {show(start)}')
    small_enough = positive("tolerance", tolerance, example=SETTLED)
    nodes, samples = steps.shape
    columns = 2 * by_place.shape[1] + by_step.shape[1]
    value, slopes = np.empty((nodes, samples, 2)), np.empty((nodes, samples, 2, columns))
    passes, left = np.empty(nodes, dtype=np.int64), np.empty(nodes)
    reach = np.maximum(bank.tops - float(steps.min()), 0.0)
    small = small_enough * float(reach @ bank.weights)
    sliders = bank.tops, bank.weights, bank.compliances

    def settle(part: slice) -> None:
        kernels.compiled.settle_vectors(
            np.ascontiguousarray(places[part]), np.ascontiguousarray(steps[part]),
            np.ascontiguousarray(bank.rests[part]), samples, *sliders,
            np.ascontiguousarray(by_place), by_place.shape[1],
            np.ascontiguousarray(by_step), by_step.shape[1],
            _PASSES, int(start == "first"), small, value[part], slopes[part], passes[part],
            left[part],
        )  # fmt: skip

    in_parts(nodes, settle)
    value *= bank.scales[:, None, None]
    slopes *= bank.scales[:, None, None, None]
    wide = 2 * by_place.shape[1]
    slopes[..., :wide] /= bank.slips[:, None, None, None]
    if bank.lay is not None and wide:
        by_both = slopes[..., :wide].reshape(nodes, samples, 2, 2, -1)
        slopes[..., :wide] = np.einsum("ij,ntrjc->ntric", bank.lay, by_both).reshape(
            nodes, samples, 2, wide
        )
    return _Settled(value, slopes, passes, left * bank.scales, left <= small * (1.0 + 1e-9))


def settled_vectors(
    bank: SliderBank,
    displacements: Floats,
    load: Floats | None,
    steps: Floats,
    tolerance: Any,
    start: Any,
) -> VectorCycle:
    """Return settled cycles for displacements [m], shape (nodes, samples, 2).

    ``steps`` are separations relative to the origin of the load curve [m] and ``load`` the normal
    loads [N], both of shape (nodes, samples). The result of a single joint has no axis of nodes.
    """
    places = bank.places(displacements)
    found = _settle(bank, places, steps, tolerance, start)
    return VectorCycle(
        lock(found.force[0] if bank.nodes is None else found.force),
        load,
        found.passes,
        lock(found.residual),
        lock(found.converged),
        bank,
        places,
        steps,
        tolerance,
        start,
    )


def settled_harmonics(
    bank: SliderBank,
    coefficients: ArrayLike,
    harmonics: Any,
    separations: ArrayLike | None,
    samples: int,
    tolerance: Any,
    start: Any,
) -> FieldHarmonics:
    """Return Fourier coefficients of force and load; see :meth:`IsotropicField.harmonics`."""
    basis, size, single = Basis(harmonics), bank.size, bank.nodes is None
    functions, analysis = basis.sampled(samples)
    count, values = basis.size, floats("coefficients", coefficients, "m")
    shape = (2, count) if single else (size, 2, count)
    if values.shape != shape:
        rows = ", a row for each direction" if single else ""
        raise InputError(f"`coefficients` must have the shape {shape}{rows}, got {values.shape}")
    places = bank.places(np.einsum("tc,nic->nti", functions, values.reshape(size, 2, count)))
    steps, by_step = np.repeat(bank.rests[:, None], len(functions), axis=1), None
    if separations is not None:
        d = coefficients_of("separations", separations, basis, size) @ functions.T
        steps, by_step = bank.steps_at(d), functions
    found = _settle(bank, places, steps, tolerance, start, functions, by_step)
    force = np.einsum("tc,nti->nic", analysis, found.force)
    spectrum = np.einsum("tc,ntrk->nrck", analysis, found.slopes)
    by_places = spectrum[..., : 2 * count].reshape(size, 2, count, 2, count)
    by_places = by_places.transpose(0, 1, 3, 2, 4)
    if separations is None:
        if single:
            force, by_places = force[0], by_places[0]
        return FieldHarmonics(force, None, by_places, found.residual, found.converged)
    load, fall = bank.loads(steps)
    jacobian = np.zeros((size, 3, 3, count, count))
    jacobian[:, :2, :2], jacobian[:, :2, 2] = by_places, bank.per_length(spectrum[..., 2 * count :])
    jacobian[:, 2, 2] = np.einsum("tc,nt,tk->nck", analysis, fall, functions)
    return FieldHarmonics(force, load @ analysis, jacobian, found.residual, found.converged)
