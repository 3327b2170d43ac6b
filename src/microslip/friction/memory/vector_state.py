"""Resumable state of contact nodes that move in two tangential directions."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core import kernels
from microslip._core.checks import Floats, floats
from microslip._core.errors import InputError
from microslip.friction.memory.field_state import FieldResponse
from microslip.friction.memory.nodes import Nodes, along
from microslip.friction.memory.resumable import Resumable, accumulated, synchronized


class VectorResponse(FieldResponse):
    """Response of nodes to displacements in two tangential directions and separations.

    Unpacks as ``force, stiffness`` for constant separations, otherwise as ``force, load, tangent``.
    The sliders are those of Iwan (1966, DOI 10.1115/1.3625199), each with a spring whose deflection
    is a vector.
    """

    force: Floats
    """Tangential forces (T1, T2) [N], shape (nodes, 2), or (2,) for a single joint."""
    load: Floats
    """Normal loads N [N], shape (nodes,); NaN for a law at constant load."""
    tangent: Floats
    """d(T1, T2, N)/d(displacement 1, displacement 2, separation) [N/m], shape (nodes, 3, 3)."""

    @property
    def stiffness(self) -> Floats:
        """d(T1, T2)/d(displacement 1, displacement 2) [N/m], shape (nodes, 2, 2)."""
        return self.tangent[..., :2, :2]


@dataclass(frozen=True, eq=False)
class SliderBank:
    """Sliders common to all nodes, with factors that convert slider forces to forces of nodes.

    Slider coordinates are displacements divided by kappa, the slip per indentation. Steps are
    separations relative to the origin of the load curve; see :class:`Nodes`.
    """

    tops: Floats
    """Separation, or displacement at constant load, at which each slider begins to slip [m]."""
    weights: Floats
    """Stiffness of each slider [N/m]: force over deflection, without the factor ``scales``."""
    nodes: Nodes | None
    """The nodes, or None for a single law at constant load, whose slider coordinate is the
    displacement."""
    nearest: float = 0.0
    """Smallest step covered by the sliders [m]."""
    lay: Floats | None = None
    """Tangential stiffness tensor over its value along the first displacement [-], shape (2, 2);
    None if isotropic. It contains the effect of the lay, the direction of machining marks."""

    @property
    def size(self) -> int:
        """Number of nodes."""
        return 1 if self.nodes is None else self.nodes.size

    @cached_property
    def scales(self) -> Floats:
        """Force of each node over the sum of stiffness times deflection of its sliders [-]."""
        return np.ones(self.size) if self.nodes is None else self.nodes.weights

    @cached_property
    def slips(self) -> Floats:
        """Displacement over slider coordinate of each node [-]; 1 for a law at constant load."""
        return np.ones(self.size) if self.nodes is None else self.nodes.slips

    @cached_property
    def rests(self) -> Floats:
        """Step of each node at rest [m], relative to the origin of the load curve."""
        return np.zeros(self.size) if self.nodes is None else self.nodes.rests

    @cached_property
    def compliances(self) -> Floats | None:
        """Inverse principal values of the stiffness tensor ``lay``, and its first principal axis.

        The axis is given by the cosine and sine of its angle from the first displacement.
        """
        if self.lay is None:
            return None
        stiffnesses, axes = np.linalg.eigh(self.lay)
        if np.linalg.det(axes) < 0.0:
            axes[:, 1] *= -1.0
        return np.array([*(1.0 / stiffnesses), *axes[:, 0]])

    def places(self, displacements: Floats) -> Floats:
        """Convert displacements [m], nodes on the first axis, to slider coordinates [m]."""
        slips = self.slips.reshape(-1, *[1] * (displacements.ndim - 1))
        return (displacements if self.lay is None else displacements @ self.lay) / slips

    def displacements(self, places: Floats) -> Floats:
        """Convert slider coordinates [m] to displacements [m], both of shape (nodes, 2)."""
        moved = places if self.lay is None else np.linalg.solve(self.lay, places.T).T
        return np.asarray(moved * self.slips[:, None])

    def loads(self, step: Floats) -> tuple[Floats, Floats]:
        """Return normal loads N and dN/d(separation) at steps, nodes on the first axis [N, N/m]."""
        if self.nodes is None:
            return np.full(step.shape, np.nan), np.full(step.shape, np.nan)
        load, fall = self.nodes.curve.load(step.reshape(-1))
        scales = self.nodes.scales.reshape(-1, *[1] * (step.ndim - 1))
        fall = self.nodes.per_length(scales * fall.reshape(step.shape))
        return scales * load.reshape(step.shape), -fall

    def per_length(self, values: Floats) -> Floats:
        """Convert d/d(step) to d/d(separation), for values with nodes on the first axis."""
        return values if self.nodes is None else self.nodes.per_length(values)

    def steps_at(self, separations: Floats) -> Floats:
        """Check separations [m], nodes on the first axis; return steps from the origin [m]."""
        if self.nodes is None:
            raise InputError(
                "`separations` have no meaning for a joint at constant load; write "
                "JointField(...).two_directions() for varying separations"
            )
        steps = self.nodes.steps_of(separations)
        if steps.min() < self.nearest:
            place = np.unravel_index(np.argmin(steps), steps.shape)
            node = int(place[0])
            nearest = self.nodes.separations_of(np.full(self.size, self.nearest))[node]
            raise InputError(
                f"`separations` must not be below the nearest one of the sliders, {nearest:g} m, "
                f"got {separations[place]:g} at node {node}; "
                "write two_directions(nearest=...)"
            )
        return steps


class VectorState(Resumable):
    """Hysteresis state of nodes in two tangential directions.

    A trial does not change the state until it is committed, as in :class:`microslip.State`::

        force, stiffness = state.try_([1e-7, -2e-7])
        state.commit()  # or state.rollback()

    The spring of each slider of the Iwan model (1966, DOI 10.1115/1.3625199) is deflected by a
    vector of two components. A state needs 16 bytes per slider and node, twice as much during a
    trial.
    """

    __slots__ = ("_bank", "_loss", "_place", "_step", "_value", "_vectors")

    _changing = ("_loss",)
    _trial: tuple[Floats, Floats | None, Floats, Floats] | None

    def __init__(self, bank: SliderBank, energies: bool) -> None:
        super().__init__()
        self._bank = bank
        self._place, self._value = np.zeros((bank.size, 2)), np.zeros((bank.size, 2))
        self._step = bank.rests.copy()
        self._vectors = np.zeros((bank.size, bank.tops.size, 2))
        self._loss = np.zeros(bank.size) if energies else None

    def _out(self, array: Floats) -> Any:
        return array[0] if self._bank.nodes is None else array

    @property
    def displacement(self) -> Floats:
        """Committed displacements [m], shape (nodes, 2), or (2,) for a single joint."""
        return np.asarray(self._out(self._bank.displacements(self._place)))

    @property
    def force(self) -> Floats:
        """Committed forces [N], shape (nodes, 2), or (2,) for a single joint."""
        return np.asarray(self._out(self._value * self._bank.scales[:, None]))

    @property
    def stored_energy(self) -> Any:
        """Elastic energies of the sliders [J], shape (nodes,)."""
        moved = self._vectors
        if self._bank.lay is not None:
            moved = moved @ np.linalg.inv(self._bank.lay)
        squares = (self._vectors * moved).sum(axis=2) @ self._bank.weights
        return self._out(0.5 * self._bank.scales * self._bank.slips * squares)

    @property
    def dissipated_energy(self) -> Any:
        """Energies dissipated since rest [J], shape (nodes,).

        InputError is raised unless the state was started with ``energies=True``.
        """
        return self._out(accumulated(self._loss) * self._bank.scales * self._bank.slips)

    @synchronized
    def try_(self, displacement: ArrayLike, separations: ArrayLike | None = None) -> VectorResponse:
        """Compute forces and tangents at trial displacements and separations.

        Parameters
        ----------
        displacement : array_like
            Trial displacements [m] in both directions, shape (nodes, 2), or (2,).
        separations : array_like, optional
            Trial separations [m], a number or one per node; by default they do not change. The step
            from the committed state is straight in displacements and separation.

        Returns
        -------
        VectorResponse
            ``force`` [N], shape (nodes, 2), ``load`` [N], shape (nodes,), ``stiffness`` [N/m],
            shape (nodes, 2, 2), and ``tangent`` [N/m], shape (nodes, 3, 3): derivatives of (T1, T2,
            N) with respect to both displacements and the separation. A single joint has no first
            axis. Unpacks as ``force, stiffness`` without separations, as ``force, load, tangent``
            with separations.
        """
        self._trial = None  # after an error there is no trial to commit
        bank, nodes = self._bank, self._bank.size
        displacements = floats("displacement", displacement, "m")
        if displacements.shape not in ((2,), (nodes, 2)):
            raise InputError(
                f"`displacement` must have the shape ({nodes}, 2) or (2,), got "
                f"{displacements.shape}"
            )
        place = np.ascontiguousarray(bank.places(np.broadcast_to(displacements, (nodes, 2))))
        step = None
        if separations is not None:
            step = bank.steps_at(along("separations", separations, nodes, "m", "nodes"))
        new = np.empty_like(self._vectors)
        value, slope = np.empty((nodes, 2)), np.empty((nodes, 2, 3))
        kernels.compiled.vector_try(
            place, step, self._place, self._step, self._vectors, bank.tops, bank.weights,
            bank.compliances, new, value, slope,
        )  # fmt: skip
        self._trial = place, step, new, value
        force = value * bank.scales[:, None]
        stiffness = slope[:, :, :2] * (bank.scales / bank.slips)[:, None, None]
        if bank.lay is not None:
            stiffness = stiffness @ bank.lay
        load, by_step = bank.loads(self._step if step is None else step)
        tangent = np.zeros((nodes, 3, 3))
        tangent[:, :2, :2] = stiffness
        tangent[:, :2, 2] = bank.per_length(slope[:, :, 2] * bank.scales[:, None])
        tangent[:, 2, 2] = by_step
        pair = self._out(stiffness) if step is None else None
        return VectorResponse(self._out(force), self._out(load), self._out(tangent), pair)

    def _apply(self, trial: Any) -> None:
        place, step, new, value = trial
        if self._loss is not None:
            first, lost = self._bank.tops - self._step[:, None], np.empty(self._vectors.shape[:2])
            last = first if step is None else self._bank.tops - step[:, None]
            kernels.compiled.vector_losses(
                self._vectors, place - self._place, first, last, self._bank.compliances, lost
            )
            self._loss += lost @ self._bank.weights
        self._place, self._vectors, self._value = place, new, value
        self._step = self._step if step is None else step

    def __repr__(self) -> str:
        nodes, sliders = self._vectors.shape[:2]
        return f"VectorState({nodes} {'node' if nodes == 1 else 'nodes'}, {sliders} sliders)"
