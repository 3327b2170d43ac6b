"""Settled cycles of nodes that move in two directions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip import kernels
from microslip._core.checks import Floats, exact, floats, positive
from microslip._core.frozen import Locked
from microslip.errors import InputError
from microslip.kernels import Integers
from microslip.memory.vector_state import Bank

_PASSES = 1000
SETTLED = 1e-6
"""Of the force limit: a cycle that changes less from period to period counts as settled."""
_BLOCK = 128  # nodes at a time, whose derivatives are held


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
    """Periods after which each cycle had settled."""
    _bank: Bank
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
        by_place = _directions("directions", directions, samples)
        by_step = np.zeros((samples, 0))
        if separations is not None:
            by_step = _directions("separations", separations, samples)
        slopes = settle(self._bank, self._places, self._steps, by_place, by_step, self._tolerance)[
            1
        ]
        return slopes[0] if self.force.ndim == 2 else slopes


def _directions(name: str, value: ArrayLike, samples: int) -> Floats:
    array = floats(name, value)
    if array.ndim != 2 or array.shape[0] != samples:
        raise InputError(f"{name} must have the shape ({samples}, directions), got {array.shape}")
    return array


def settle(
    bank: Bank, places: Floats, steps: Floats, by_place: Floats, by_step: Floats, tolerance: Any
) -> tuple[Floats, Floats, Integers]:
    """Forces (nodes, samples, 2) of settled cycles, their derivatives, and the passes made."""
    small_enough = positive("tolerance", tolerance, example=SETTLED)
    nodes, samples = steps.shape
    columns = 2 * by_place.shape[1] + by_step.shape[1]
    value, slopes = np.empty((nodes, samples, 2)), np.empty((nodes, samples, 2, columns))
    passes = np.empty(nodes, dtype=np.int64)
    reach = np.maximum(bank._tops - float(steps.min()), 0.0)
    small = small_enough * float(reach @ bank._weights)
    for start in range(0, nodes, _BLOCK):
        part = slice(start, start + _BLOCK)
        kernels.active.vector_cycle(
            np.ascontiguousarray(places[part]), np.ascontiguousarray(steps[part]),
            np.ascontiguousarray(bank._rests[part]), samples, bank._tops, bank._weights,
            np.ascontiguousarray(by_place), by_place.shape[1],
            np.ascontiguousarray(by_step), by_step.shape[1],
            _PASSES, small, value[part], slopes[part], passes[part],
        )  # fmt: skip
    if passes.min() < 0:
        raise InputError(
            f"displacements must be a cycle that settles: node {int(np.argmin(passes))} still "
            f"changes by more than {exact(small_enough)} of its force limit after {_PASSES} periods"
        )
    value *= bank._scales[:, None, None]
    slopes *= bank._scales[:, None, None, None]
    slopes[..., : 2 * by_place.shape[1]] /= bank._slips[:, None, None, None]
    return value, slopes, passes


def transform_slopes(
    slopes: Floats, analysis: Floats, count: int, step_count: int
) -> tuple[Floats, Floats]:
    """Jacobians of Fourier coefficients: by both displacements (n, 2, 2, c, c), and separations."""
    spectrum = np.einsum("tc,ntrk->nrck", analysis, slopes)
    nodes = len(slopes)
    by_place = (
        spectrum[..., : 2 * count].reshape(nodes, 2, count, 2, count).transpose(0, 1, 3, 2, 4)
    )
    return by_place, spectrum[..., 2 * count : 2 * count + step_count]
