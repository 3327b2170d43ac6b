"""Settled cycles of joints whose separation varies, one or many, with their derivatives.

Each step ends on a slip front q with sign s in front of it, in the row that an earlier sample k
left with D_k. With p = displacement/kappa, in units of mu,

    dT = dT_k - N'(q) (dp - dp_k) + s [N'(d) - N'(q)] dd + D_k [N'(q) - N'(d_k)] dd_k
         - dD_k [N(d_k) - N(q) + N'(q) (q - d_k)],

the last where sample k stuck and so left a D_k between -1 and 1 (Jaeger 1998,
DOI 10.1115/1.2833765, differentiated). What sticks hangs from the sample before it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from microslip import kernels
from microslip._core.checks import Floats
from microslip.kernels import Integers
from microslip.memory import Nodes

_NOTHING = np.zeros(0)


class NodeCycles:
    """Cycles of nodes by displacements and steps from rest, (nodes, samples); held without steps.

    The nodes began at displacements ``rest``, as :func:`rest_of` has them: a mean moves along.

    Each node goes from rest in a straight line to the sample where step + |place| is largest, its
    root. All memory is gone there, unless the root lies within what that path pressed down
    sticking: then a second pass settles it.
    """

    def __init__(
        self, nodes: Nodes, displacements: Floats, steps: Floats | None, rest: tuple[Any, bool]
    ) -> None:
        begin, self._rest_is_mean = rest
        self.nodes, self.steps = nodes, steps
        # Beyond 1e200 slips there is no more to come, but numbers that overflow.
        with np.errstate(over="ignore"):
            moved = displacements - np.reshape(begin, (-1, 1))
            places = np.clip(moved / nodes.slips[:, None], -1e200, 1e200)
        self.places = np.ascontiguousarray(places)
        self._reach = nodes.reach(steps)

    def forces(self) -> tuple[Floats, Floats, Floats]:
        """Tangential forces [N], normal loads [N] and tangent stiffnesses [N/m]."""
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
        """Derivatives of forces and loads [N a unit], (nodes, samples, directions).

        Along each direction, (nodes or 1, samples, directions), displacements change, and
        separations where they are given.
        """
        nodes, samples = self.places.shape
        count = by_displacement.shape[2]
        by_step = np.zeros((1, samples, 0)) if by_separation is None else by_separation
        steps = by_step.shape[2]
        force, load = np.empty((nodes, samples, count + steps)), np.empty((nodes, samples, steps))
        self._derive(
            by_displacement, by_step, _NOTHING, _NOTHING, force, _NOTHING, load
        )  # fmt: skip
        force, load = self._scaled(force, count, load)
        if not steps:
            return force, np.zeros_like(force)
        return force[:, :, :count] + force[:, :, count:], load

    def spectra(
        self, by_displacement: Floats, by_separation: Floats, analysis: Floats
    ) -> tuple[Floats, Floats, Floats, Floats]:
        """Fourier coefficients of forces and loads [N], and the derivatives of both.

        ``analysis``, (samples, coefficients), makes coefficients of samples. Derivatives, of the
        shape (nodes, coefficients, directions), have the directions of the displacements first,
        then those of the separations, by which alone loads change.
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
        force[:, :, places:] *= nodes.weights[:, None, None]
        load *= nodes.scales[:, None, None]
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
    """Samples of two passes of each cycle, from its root on; the second pass is settled."""
    samples = places.shape[1]
    root = np.argmax(np.abs(places) if steps is None else steps + np.abs(places), axis=1)
    return np.asarray((root[:, None] + np.arange(2 * samples)) % samples)
