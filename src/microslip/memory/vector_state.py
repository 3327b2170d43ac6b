"""A resumable state of nodes that move in two directions."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from microslip import kernels
from microslip._core.checks import Floats, floats
from microslip.errors import InputError
from microslip.kernels.twin_vector import slip_losses


class VectorResponse(NamedTuple):
    """What nodes answer to displacements in two directions and separations.

    Sliders as Iwan's (1966, DOI 10.1115/1.3625199), each with a vector.
    """

    force: Floats
    """Tangential forces (T1, T2) [N], shape (nodes, 2)."""
    load: Floats
    """Normal loads N [N], one a node."""
    tangent: Floats
    """Derivatives of (T1, T2, N) by both displacements and the separation [N/m], (nodes, 3, 3)."""


class Bank(Protocol):
    """Sliders that nodes share, and what makes forces of them."""

    @property
    def _tops(self) -> Floats:
        """Separation, or displacement, at which each slider begins to slip from rest."""

    @property
    def _weights(self) -> Floats:
        """What each adds to the force for what it holds."""

    @property
    def _scales(self) -> Floats:
        """Force of each node for what the sliders hold, times the slip of a place."""

    @property
    def _slips(self) -> Floats:
        """Displacement per place of each node."""

    @property
    def _rests(self) -> Floats:
        """Separation of each node at rest, as the sliders count it."""

    def _loads(self, step: Floats) -> tuple[Floats, Floats]:
        """Normal loads of the nodes [N] and their derivatives by the separation [N/m]."""

    def _step_array(self, separations: ArrayLike) -> Floats:
        """Separations as the sliders count them."""


class VectorState:
    """The place of nodes on their hysteresis in two directions.

    A trial moves nothing until it is committed, as in :class:`microslip.State`::

        force, stiffness = state.try_([1e-7, -2e-7])
        state.commit()  # or state.rollback()

    Each slider holds a vector (Iwan 1966, DOI 10.1115/1.3625199, in two directions): 16 bytes a
    slider and node, twice that while there is a trial.
    """

    __slots__ = ("_bank", "_loss", "_place", "_single", "_step", "_trial", "_value", "_vectors")

    def __init__(self, bank: Bank, single: bool, energies: bool) -> None:
        nodes = bank._rests.size
        self._bank, self._single = bank, single
        self._place, self._value = np.zeros((nodes, 2)), np.zeros((nodes, 2))
        self._step = bank._rests.copy()
        self._vectors = np.zeros((nodes, bank._tops.size, 2))
        self._loss = np.zeros(nodes) if energies else None
        self._trial: tuple[Floats, Floats | None, Floats, Floats] | None = None

    def _out(self, array: Floats) -> Any:
        return array[0] if self._single else array

    @property
    def displacement(self) -> Floats:
        """Committed displacements [m], shape (nodes, 2), or (2,) of one node."""
        return np.asarray(self._out(self._place * self._bank._slips[:, None]))

    @property
    def force(self) -> Floats:
        """Committed forces [N], shape (nodes, 2), or (2,) of one node."""
        return np.asarray(self._out(self._value * self._bank._scales[:, None]))

    @property
    def stored_energy(self) -> Any:
        """Elastic energies of the sliders [J], one a node."""
        squares = (self._vectors**2).sum(axis=2) @ self._bank._weights
        return self._out(0.5 * self._bank._scales * self._bank._slips * squares)

    @property
    def dissipated_energy(self) -> Any:
        """Energies dissipated so far at held separations [J], one a node."""
        if self._loss is None:
            raise InputError(
                "dissipated_energy is not counted: start the state with start(energies=True)"
            )
        return self._out(self._loss * self._bank._scales * self._bank._slips)

    def try_(self, displacement: ArrayLike, separations: ArrayLike | None = None) -> Any:
        """Forces and tangents at trial displacements and, if they vary, separations.

        Parameters
        ----------
        displacement : array_like
            Trial displacements [m] in both directions, shape (nodes, 2), or (2,).
        separations : array_like, optional
            Trial separations [m], one a node; without them they stay what they are. The step from
            the committed state is a straight line.

        Returns
        -------
        tuple of ndarray or VectorResponse
            Without separations the forces [N], shape (nodes, 2), and the stiffnesses of the step
            [N/m], (nodes, 2, 2), of one node without the first axis. With them ``force``, ``load``
            and ``tangent``.
        """
        self._trial = None  # should this one fail, no earlier one is left to commit
        bank, nodes = self._bank, self._step.size
        displacements = floats("displacement", displacement)
        if displacements.shape not in ((2,), (nodes, 2)):
            raise InputError(
                f"displacement must have the shape ({nodes}, 2), or (2,), got {displacements.shape}"
            )
        place = np.ascontiguousarray(
            np.broadcast_to(displacements, (nodes, 2)) / bank._slips[:, None]
        )
        step = None
        if separations is not None:
            if self._loss is not None:
                raise InputError(
                    "separations cannot vary while energies are counted: start without energies"
                )
            step = bank._step_array(separations)
        new = np.empty_like(self._vectors)
        value, slope = np.empty((nodes, 2)), np.empty((nodes, 2, 3))
        kernels.active.vector_try(
            place, step, self._place, self._step, self._vectors, bank._tops, bank._weights, new,
            value, slope,
        )  # fmt: skip
        self._trial = place, step, new, value
        force = value * bank._scales[:, None]
        stiffness = slope[:, :, :2] * (bank._scales / bank._slips)[:, None, None]
        if step is None:
            return self._out(force), self._out(stiffness)
        load, by_step = bank._loads(step)
        tangent = np.zeros((nodes, 3, 3))
        tangent[:, :2, :2] = stiffness
        tangent[:, :2, 2] = slope[:, :, 2] * bank._scales[:, None]
        tangent[:, 2, 2] = by_step
        return VectorResponse(force, load, tangent)

    def commit(self) -> None:
        """Make the last trial the state; without a trial it is an InputError."""
        if self._trial is None:
            raise InputError("commit needs a trial: call try_(displacement) first")
        place, step, new, value = self._trial
        if self._loss is not None:
            radii = self._bank._tops - self._step[:, None]
            lost = slip_losses(self._vectors, place - self._place, radii)
            self._loss += lost @ self._bank._weights
        self._place, self._vectors, self._value = place, new, value
        self._step = self._step if step is None else step
        self._trial = None

    def rollback(self) -> None:
        """Forget the last trial, if there is one."""
        self._trial = None

    def copy(self) -> VectorState:
        """An independent state at the same place, an open trial included."""
        state = object.__new__(VectorState)
        for name in VectorState.__slots__:  # what they hold is replaced, never changed
            setattr(state, name, getattr(self, name))
        state._loss = None if self._loss is None else self._loss.copy()
        return state

    __copy__ = copy

    def __repr__(self) -> str:
        nodes, sliders = self._vectors.shape[:2]
        return f"VectorState({nodes} {'node' if nodes == 1 else 'nodes'}, {sliders} sliders)"
