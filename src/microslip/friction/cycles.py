"""Settled cycle of a periodic displacement and its derivatives.

Equation numbers (19.x) are those of chapter 19, DOI 10.1007/978-3-319-56818-8_19.
"""

from __future__ import annotations

from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core import kernels
from microslip._core.checks import Floats, floats, number, record, show
from microslip._core.errors import InputError
from microslip.friction.energies import dissipated_along
from microslip.friction.memory import Memory, Nodes

Rest: TypeAlias = float | Literal["mean"]
"""Displacement of the force-free state before a cycle: a number [m] or the mean of the cycle."""


class _Cycle(NamedTuple):
    force: Floats
    stiffness: Floats
    parent: NDArray[np.int64]
    root: int


class PeriodicResponse(_Cycle):
    """Settled cycle of a periodic displacement, with the branches (19.20)-(19.24).

    Unpacks as ``force, stiffness, parent, root``. The arrays have one entry per sample.

    ``force``
        Forces of the settled cycle [N].
    ``stiffness``
        Tangent stiffness at each sample [N/m].
    ``parent``
        Index of the reversal at which the branch of each sample began; the root is its own parent.
    ``root``
        Index of the sample farthest from the rest displacement; it is on the first loading curve.

    For any parameter p of the displacements x, such as a Fourier coefficient, the derivatives D =
    dT/dp of the forces follow from x' = dx/dp: D[root] = stiffness[root] x'[root], then for samples
    t in cyclic order from the root D[t] = D[parent[t]] + stiffness[t] (x'[t] - x'[parent[t]]); see
    :meth:`derivative`. If the rest displacement is the mean, x' is taken relative to its mean.
    """

    _rest_is_mean = False
    _law: Any
    _path: Floats

    @property
    def dissipated_energy(self) -> float:
        """Energy dissipated in each cycle [J]: the area of the settled loop, in closed form."""
        twice = np.tile(np.roll(self._path, -self.root), 2)
        lost = dissipated_along(self._law, twice, twice)
        return float(lost[-1] - lost[self.force.size - 1])

    def derivative(self, directions: ArrayLike) -> Floats:
        """Compute derivatives of the forces along given directions of the displacements.

        Parameters
        ----------
        directions : array_like
            Derivatives of the displacement at each sample with respect to each parameter, shape
            (samples, parameters) or (samples,), [m] for dimensionless parameters.

        Returns
        -------
        ndarray
            Derivatives of the force, shape of ``directions``, [N] for dimensionless parameters.
        """
        change = rows_of("directions", directions, self.force.size)
        if self._rest_is_mean:
            change = change - change.mean(axis=0)
        size, root = self.force.size, self.root
        order = (np.arange(size) + root) % size
        change = change[order]
        parent = (self.parent[order] - root) % size
        column = (-1, *[1] * (change.ndim - 1))
        stiffness = self.stiffness[order].reshape(column)
        parent[0] = -1
        first = parent.reshape(column)
        with np.errstate(invalid="ignore"):
            rise = np.ascontiguousarray(
                stiffness * (change - np.where(first < 0, 0.0, change[parent]))
            )
        kernels.compiled.accumulate(parent, rise, np.zeros(rise[0].size))
        return np.roll(rise, root, axis=0)


def rows_of(name: str, value: ArrayLike, samples: int) -> Floats:
    """Return ``value`` as an array; its shape must be (samples,) or (samples, parameters)."""
    rows = floats(name, value)
    if rows.ndim not in (1, 2) or rows.shape[0] != samples:
        raise InputError(
            f"{name} must have one row for each of the {samples} samples, got shape {rows.shape}"
        )
    return rows


def rest_of(rest: Any, cycle: Floats, nodes: Nodes | None = None) -> tuple[Any, bool]:
    """Return the displacement [m] at zero force before the cycle, and whether it is the mean.

    The first is the number ``rest`` or, for "mean", the mean of ``cycle`` over its last axis, the
    samples. With ``nodes`` there is one displacement per node.
    """
    if isinstance(rest, str):
        if rest != "mean":
            raise InputError(f'rest must be a displacement [m] or "mean", got {show(rest)}')
        return cycle.mean(axis=-1), True
    return (
        number("rest", rest, "m") if nodes is None else nodes.per_node("rest", rest, "m")
    ), False


def settled_cycle(law: Any, displacement_cycle: ArrayLike, rest: Rest = 0.0) -> PeriodicResponse:
    """Compute the settled cycle of a law; see :meth:`microslip.BackboneLaw.periodic`."""
    x = record("displacement_cycle", displacement_cycle, "m").reshape(-1)
    begin, is_mean = rest_of(rest, x)
    x = x - begin
    root = int(np.argmax(np.abs(x)))
    # The largest displacement wipes out all memory, so the cycle begins there.
    tree = Memory().tree(np.roll(x, -root))
    stiffness = law._slope(tree.half)
    force = law._backbone(tree.half) * tree.sign
    kernels.compiled.accumulate(tree.parent, force, np.zeros(1))
    above = np.where(tree.parent < 0, 0, tree.parent)
    cycle = PeriodicResponse(
        np.roll(force, root),
        np.roll(stiffness, root),
        np.roll((above + root) % x.size, root),
        root,
    )
    cycle._rest_is_mean, cycle._law, cycle._path = is_mean, law, x
    return cycle
