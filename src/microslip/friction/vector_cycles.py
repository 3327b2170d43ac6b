"""Settled cycles of sliders in two directions, with their derivatives and harmonics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core import kernels
from microslip._core.checks import Floats, exact, floats, positive
from microslip._core.errors import InputError
from microslip._core.frozen import Locked
from microslip._core.kernels import Integers
from microslip._core.threads import in_parts
from microslip.friction.harmonics import Basis, coefficients_of
from microslip.friction.memory import SliderBank

_PASSES = 100_000
SETTLED = 1e-6
"""Share of the force limit: a cycle whose forces repeat so closely counts as settled."""


@dataclass(frozen=True, eq=False)
class VectorCycle(Locked):
    """Settled cycles in two directions, made by the ``periodic`` of what moves in both.

    Sliders as Iwan's (1966, DOI 10.1115/1.3625199), each with a vector.
    """

    force: Floats
    """Forces (T1, T2) [N], shape (nodes, samples, 2), of one joint (samples, 2)."""
    load: Floats | None
    """Normal loads [N], shape (nodes, samples); None of one joint, whose law knows none."""
    passes: Integers
    """Times that the slowest slider of each cycle was taken around it until it had settled."""
    _bank: SliderBank
    _places: Floats
    _steps: Floats
    _tolerance: float

    def derivative(self, directions: ArrayLike, separations: ArrayLike | None = None) -> Floats:
        """Derivatives of the forces [N a unit] along directions that all nodes share.

        Directions, of the shape (samples, directions), are how a displacement changes with each
        parameter [m a unit]: they serve for the first displacement, then again for the second, then
        come those of the separations. What comes back is of the shape (nodes, samples, 2,
        directions twice and more), of one joint without the first axis.
        """
        samples = self._places.shape[1]
        by = [_directions("directions", directions, samples)]
        if separations is not None:
            by.append(_directions("separations", separations, samples))
        slopes = _settle(self._bank, self._places, self._steps, self._tolerance, *by)[1]
        return slopes[0] if self.force.ndim == 2 else slopes


def _directions(name: str, value: ArrayLike, samples: int) -> Floats:
    array = floats(name, value)
    if array.ndim != 2 or array.shape[0] != samples:
        raise InputError(f"{name} must have the shape ({samples}, directions), got {array.shape}")
    return array


def _settle(
    bank: SliderBank,
    places: Floats,
    steps: Floats,
    tolerance: Any,
    by_place: Floats | None = None,
    by_step: Floats | None = None,
) -> tuple[Floats, Floats, Integers]:
    """Forces (nodes, samples, 2) of settled cycles, their derivatives, and the passes made."""
    nothing = np.zeros((places.shape[1], 0))
    by_place = nothing if by_place is None else by_place
    by_step = nothing if by_step is None else by_step
    small_enough = positive("tolerance", tolerance, example=SETTLED)
    nodes, samples = steps.shape
    columns = 2 * by_place.shape[1] + by_step.shape[1]
    value, slopes = np.empty((nodes, samples, 2)), np.empty((nodes, samples, 2, columns))
    passes = np.empty(nodes, dtype=np.int64)
    reach = np.maximum(bank.tops - float(steps.min()), 0.0)
    small = small_enough * float(reach @ bank.weights)
    sliders = bank.tops, bank.weights, bank.compliances

    def settle(part: slice) -> None:
        kernels.compiled.vector_cycle(
            np.ascontiguousarray(places[part]), np.ascontiguousarray(steps[part]),
            np.ascontiguousarray(bank.rests[part]), samples, *sliders,
            np.ascontiguousarray(by_place), by_place.shape[1],
            np.ascontiguousarray(by_step), by_step.shape[1],
            _PASSES, small, value[part], slopes[part], passes[part],
        )  # fmt: skip

    in_parts(nodes, settle)
    if passes.min() < 0:
        raise InputError(
            f"displacements must be a cycle that settles: node {int(np.argmin(passes))} is still "
            f"more than {exact(small_enough)} of its force limit off after {_PASSES} periods; "
            f"give a larger tolerance"
        )
    value *= bank.scales[:, None, None]
    slopes *= bank.scales[:, None, None, None]
    wide = 2 * by_place.shape[1]
    slopes[..., :wide] /= bank.slips[:, None, None, None]
    if bank.lay is not None and wide:
        by_both = slopes[..., :wide].reshape(nodes, samples, 2, 2, -1)
        slopes[..., :wide] = np.einsum("ij,ntrjc->ntric", bank.lay, by_both).reshape(
            nodes, samples, 2, wide
        )
    return value, slopes, passes


def settled_cycle(
    bank: SliderBank, displacements: Floats, steps: Floats, tolerance: Any
) -> tuple[Floats, Integers, tuple[Any, ...]]:
    """Forces and passes of settled cycles, and what a :class:`VectorCycle` keeps of them."""
    places = bank.places(displacements)
    force, _, passes = _settle(bank, places, steps, tolerance)
    return force, passes, (bank, places, steps, tolerance)


def settled_harmonics(
    bank: SliderBank,
    coefficients: ArrayLike,
    harmonics: Any,
    separations: ArrayLike | None,
    samples: int,
    tolerance: Any,
    single: bool = False,
) -> tuple[Floats, ...]:
    """Coefficients of forces and loads, and the Jacobian: as the ``harmonics`` below give them."""
    basis, size = Basis(harmonics), bank.size
    functions, analysis = basis.sampled(samples)
    count, values = basis.size, floats("coefficients", coefficients, "m")
    shape = (2, count) if single else (size, 2, count)
    if values.shape != shape:
        rows = ", a row for each direction" if single else ""
        raise InputError(f"coefficients must have the shape {shape}{rows}, got {values.shape}")
    places = bank.places(np.einsum("tc,nic->nti", functions, values.reshape(size, 2, count)))
    steps, by_step = np.repeat(bank.rests[:, None], len(functions), axis=1), None
    if separations is not None:
        d = coefficients_of("separations", separations, basis, size) @ functions.T
        steps, by_step = bank.steps_at(d), functions
    force, slopes, _ = _settle(bank, places, steps, tolerance, functions, by_step)
    force = np.einsum("tc,nti->nic", analysis, force)
    spectrum = np.einsum("tc,ntrk->nrck", analysis, slopes)
    by_places = spectrum[..., : 2 * count].reshape(size, 2, count, 2, count)
    by_places = by_places.transpose(0, 1, 3, 2, 4)
    if separations is None:
        return force, by_places
    load, fall = bank.loads(steps)
    jacobian = np.zeros((size, 3, 3, count, count))
    jacobian[:, :2, :2], jacobian[:, :2, 2] = by_places, spectrum[..., 2 * count :]
    jacobian[:, 2, 2] = np.einsum("tc,nt,tk->nck", analysis, fall, functions)
    return force, load @ analysis, jacobian
