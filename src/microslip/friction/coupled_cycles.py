"""Settled cycle of an interface under a varying load, computed as a contact field of one node."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, record
from microslip._core.errors import InputError
from microslip._core.frozen import Locked, lock
from microslip.friction.cycles import Rest, rest_of, rows_of
from microslip.friction.field_cycles import NodeCycles, SettledField, from_root
from microslip.friction.harmonic_basis import Basis, coefficients_of
from microslip.friction.memory import Diagram, Nodes, steps_along


@dataclass(frozen=True, eq=False)
class CoupledCycle(Locked):
    """Settled cycle under a periodic displacement and normal load.

    Result of :meth:`microslip.Interface.periodic`, after Jaeger (1998), DOI 10.1115/1.2833765.
    Arrays have one entry per sample.
    """

    displacement: Floats
    """Displacements [m]."""
    separation: Floats
    """Separations [m]."""
    force: Floats
    """Tangential forces [N]."""
    normal_load: Floats
    """Normal loads [N]."""
    normal_stiffness: Floats
    """Normal stiffnesses -dN/d(separation) [N/m]."""
    stiffness: Floats
    """Tangent stiffnesses dT/d(displacement) [N/m] at the end of each step."""
    _cycles: NodeCycles

    def derivative(
        self, displacement: ArrayLike | None = None, *, separation: ArrayLike | None = None
    ) -> Floats:
        """Compute derivatives of the forces of the cycle with respect to parameters of its inputs.

        Arguments are the derivatives of the displacement [m] and of the separation [m] with respect
        to each parameter, shape (samples, parameters) or (samples,). The result has the same shape
        [N]. An input not given does not depend on the parameters. The derivative of the normal load
        itself is ``-normal_stiffness`` times that of the separation.
        """
        size = self.force.size
        changes = {"displacement": displacement, "separation": separation}
        rows = {k: rows_of(k, v, size) for k, v in changes.items() if v is not None}
        if not rows:
            raise InputError("`displacement` or `separation` must be given")
        shapes = {v.shape for v in rows.values()}
        if len(shapes) > 1:
            raise InputError(f"directions must have the same shape, got {sorted(shapes)}")
        shape = shapes.pop()
        by = {k: v.reshape(1, size, -1) for k, v in rows.items()}
        move = by.get("displacement", np.zeros_like(next(iter(by.values()))))
        return np.ascontiguousarray(
            self._cycles.slopes(move, by.get("separation"))[0].reshape(shape)
        )

    @cached_property
    def dissipated_energy(self) -> float:
        """Energy dissipated in each cycle [J]."""
        places, steps = self._cycles.places, self._cycles.steps
        order, curve = from_root(places, steps)[0], self._cycles.nodes.curve
        at = steps[0, order]  # type: ignore[index]
        lost = Diagram().losses(at, curve.slip * places[0, order], curve)
        return float(lost[self.force.size :].sum())


def coupled_cycle(
    nodes: Nodes, displacement_cycle: ArrayLike, rest: Rest, separation: ArrayLike
) -> CoupledCycle:
    """Compute the settled cycle of one node; see :meth:`microslip.Interface.periodic`."""
    x, curve = record("displacement_cycle", displacement_cycle, "m").reshape(-1), nodes.curve
    steps = steps_along(curve, x.size, None, separation)
    cycles = NodeCycles(nodes, x[None], steps[None], rest_of(rest, x))
    force, _, stiffness = cycles.forces()
    load, fall = curve.load(steps)
    arrays = x.copy(), steps + curve.origin, force[0], load, fall, stiffness[0]
    x, d, t, n, k_n, k_t = map(lock, arrays)
    return CoupledCycle(x, d, t, n, k_n, k_t, cycles)


class CoupledHarmonics(NamedTuple):
    """Fourier coefficients of the settled forces on an interface, with their Jacobian.

    After Jaeger (1998), DOI 10.1115/1.2833765; see :meth:`microslip.Interface.harmonics`.
    """

    force: Floats
    """Coefficients of the tangential force [N], in the order of the displacement coefficients."""
    normal_load: Floats
    """Coefficients of the normal load [N]."""
    jacobian: Floats
    """Derivatives of the coefficients of (force, load) with respect to those of (displacement,
    separation), shape (2, 2, coefficients, coefficients)."""


def coupled_harmonics(
    nodes: Nodes,
    coefficients: ArrayLike,
    harmonics: Any,
    rest: Rest,
    separation: ArrayLike,
    rtol: float,
) -> CoupledHarmonics:
    """Compute Fourier coefficients of one node; see :meth:`microslip.Interface.harmonics`."""
    basis = Basis(harmonics)
    row = coefficients_of("coefficients", coefficients, basis)[None]
    path = coefficients_of("separation", separation, basis)[None]
    node = SettledField()
    node._nodes, node.separations = nodes, np.array([nodes.curve.origin])
    found = node.harmonics(row, basis.orders, separations=path, rest=rest, rtol=rtol)
    return CoupledHarmonics(found.force[0], np.asarray(found.load)[0], found.jacobian[0])
