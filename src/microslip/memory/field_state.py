"""A resumable state of many nodes at once."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from microslip import kernels
from microslip._core.checks import Floats, beyond
from microslip.errors import InputError
from microslip.kernels import Integers, twin_field
from microslip.kernels.profile import LOSS_RULES, Profile
from microslip.memory.diagram import Diagram, Slips

_ROWS = 2  # rows of a node at the start; a move to and fro needs no more


class FieldResponse(NamedTuple):
    """What the nodes of a field answer to displacements and separations.

    Within Cattaneo and Mindlin's theory, after Jaeger (1998), DOI 10.1115/1.2833765.
    """

    force: Floats
    """Tangential forces T [N], one a node."""
    load: Floats
    """Normal loads N [N], one a node."""
    tangent: Floats
    """Derivatives of (T, N) by (displacement, separation) [N/m], shape (nodes, 2, 2)."""


class Curve(twin_field.ArrayCurve, Protocol):
    """The load curve of the nodes; steps are separations from its origin."""

    origin: float

    def profile(self, low: float) -> Profile | None:
        """The same as a profile, down to a step, if it can be one."""

    def losses(self, slips: Slips, count: int) -> Floats:
        """What slip loses in each of so many samples, over mu kappa, where it is none."""


class Nodes(Protocol):
    """What a state asks of its field."""

    @property
    def size(self) -> int:
        """Number of nodes."""

    @property
    def _weights(self) -> Floats:
        """What N of the surface is times for the force of gross slip."""

    @property
    def _scale(self) -> Floats:
        """What it is times for the load of a node."""

    @property
    def _slip(self) -> Floats:
        """Displacement per separation, kappa."""

    @property
    def _steps(self) -> Floats:
        """Separations at rest from the origin."""

    @property
    def _curve(self) -> Curve:
        """The load curve."""

    def _per_node(self, name: str, value: Any) -> Floats:
        """One number a node."""

    def _step_array(self, separations: Any, name: str = "separations") -> Floats:
        """Separations, one a node, from the origin."""


class FieldState:
    """The place of all nodes of a field on their hysteresis, made by :meth:`JointField.start`.

    A trial moves nothing until it is committed, as in :class:`microslip.State`::

        forces, stiffnesses = state.try_(displacements)
        forces, loads, tangents = state.try_(displacements, separations=d)
        state.commit()  # or state.rollback()

    The method of memory diagrams (DOI 10.3389/fmech.2020.00030) node by node: exact within Cattaneo
    and Mindlin's theory. It holds 128 bytes a node, 48 more while there is a trial, and some 60 for
    each row of a node's diagram beyond two: a reversal that is open, or a step of new contact that
    sticks.
    """

    __slots__ = (
        "_begin", "_depth", "_field", "_loss", "_marks", "_place", "_room", "_rows", "_step",
        "_trial", "_used", "_value",
    )  # fmt: skip

    def __init__(self, field: Nodes, energies: bool) -> None:
        nodes = field.size
        self._field = field
        self._rows, self._marks = np.zeros((_ROWS * nodes, 3)), np.zeros((_ROWS * nodes, 2))
        self._begin, self._room = _ROWS * np.arange(nodes), np.full(nodes, _ROWS)
        self._used = _ROWS * nodes
        self._depth = np.zeros(nodes, dtype=np.int64)
        self._place, self._step, self._value = np.zeros(nodes), np.zeros(nodes), np.zeros(nodes)
        self._loss = np.zeros(nodes) if energies else None
        # Places, steps if they vary, and what the kernel makes of them.
        self._trial: tuple[Floats, Floats | None, tuple[Any, ...]] | None = None

    @property
    def displacement(self) -> Floats:
        """Committed displacements [m]."""
        return self._place * self._field._slip

    @property
    def separation(self) -> Floats:
        """Committed separations [m]."""
        return self._field._curve.origin + (self._field._steps + self._step)

    @property
    def force(self) -> Floats:
        """Committed forces [N]."""
        return self._value * self._field._weights

    @property
    def normal_load(self) -> Floats:
        """Committed normal loads [N]."""
        return self._field._scale * self._field._curve.load(self._field._steps + self._step)[0]

    @property
    def open_reversals(self) -> Integers:
        """Rows of each node's memory diagram; what the state stores grows with them."""
        return self._depth.copy()

    @property
    def dissipated_energy(self) -> Floats:
        """Energies dissipated so far [J], one a node."""
        if self._loss is None:
            raise InputError(
                "dissipated_energy is not counted: start the state with start(energies=True)"
            )
        field = self._field
        return self._loss * field._weights * field._slip

    def try_(self, displacement: ArrayLike, separations: ArrayLike | None = None) -> Any:
        """Forces and tangents at trial displacements and, if they vary, separations.

        Parameters
        ----------
        displacement : array_like
            Trial displacements [m], one-dimensional, one a node, or one number.
        separations : array_like, optional
            Trial separations [m], likewise; without them they stay what they are. The step from
            the committed state is a straight line of separation and displacement.

        Returns
        -------
        tuple of ndarray or FieldResponse
            Without separations the forces [N] and the tangent stiffnesses dT/d(displacement) [N/m]
            of the step; with them ``force``, ``load`` [N] and ``tangent`` [N/m], shape (nodes, 2,
            2), consistent with the step.
        """
        self._trial = None  # should this one fail, no earlier one is left to commit
        field = self._field
        place = beyond(field._per_node("displacement", displacement), field._slip)
        step = None
        if separations is not None:
            step = field._step_array(separations) - field._steps
        nodes = place.size
        front, density, value, by_place = (np.empty(nodes) for _ in range(4))
        code = np.empty(nodes, dtype=np.int64)
        varied: tuple[Any, ...] = (None, None, None)
        if step is not None:
            varied = tuple(np.empty(nodes) for _ in range(3))
        arguments = (
            place, step, field._steps, self._place, self._step, self._value, self._rows,
            self._marks, self._begin, self._depth, front, density, value, code, by_place, *varied,
        )  # fmt: skip
        profile = self._profile(step)
        if profile is None:
            twin_field.field_try(*arguments, field._curve)
        else:
            kernels.active.field_try(*arguments, *profile.arguments)
        self._trial = place, step, (front, density, value, code)
        stiffness = by_place * (field._weights / field._slip)
        force = value * field._weights
        if step is None:
            return force, stiffness
        load, fall, by_step = varied
        tangent = np.zeros((nodes, 2, 2))
        tangent[:, 0, 0] = stiffness
        tangent[:, 0, 1] = field._weights * by_step
        tangent[:, 1, 1] = -field._scale * fall
        return FieldResponse(force, field._scale * load, tangent)

    def commit(self) -> None:
        """Make the last trial the state; without a trial it is an InputError."""
        if self._trial is None:
            raise InputError("commit needs a trial: call try_(displacement) first")
        place, step, (front, density, value, code) = self._trial
        current = self._step if step is None else step
        if self._loss is not None:
            self._loss += self._losses(place, current, code)
        self._make_room((code >> 2) + (front > current))
        kernels.active.field_commit(
            place, step, front, density, value, code, self._begin, self._room, self._place,
            self._step, self._value, self._rows, self._marks, self._depth,
        )  # fmt: skip
        self._trial = None

    def rollback(self) -> None:
        """Forget the last trial, if there is one."""
        self._trial = None

    def copy(self) -> FieldState:
        """An independent state at the same place, an open trial included."""
        state = object.__new__(FieldState)
        state._field, state._trial = self._field, self._trial  # what a trial holds never changes
        for name in ("_rows", "_marks", "_begin", "_room", "_depth", "_place", "_step", "_value"):
            setattr(state, name, getattr(self, name).copy())
        state._used = self._used
        state._loss = None if self._loss is None else self._loss.copy()
        return state

    __copy__ = copy

    def _profile(self, step: Floats | None) -> Profile | None:
        origin = self._field._steps
        low = float((origin + self._step).min())
        if step is not None:
            low = min(low, float((origin + step).min()))
        return self._field._curve.profile(low)

    def _make_room(self, rows: Integers) -> None:
        """Room for so many rows a node; who asks for more moves to the end of the pool."""
        full = np.flatnonzero(rows > self._room)
        if not full.size:
            return
        room = rows[full] + rows[full] // 2
        used = self._used + int(room.sum())
        if used > len(self._rows):
            self._repack(rows)
            return
        old = self._begin[full].copy()
        self._begin[full] = self._used + np.cumsum(room) - room
        self._room[full] = room
        self._move((self._rows, self._marks), full, old)
        self._used = used

    def _repack(self, rows: Integers) -> None:
        """A new pool, with an eighth to spare, for so many rows a node."""
        self._room = np.where(rows > _ROWS, rows + rows // 2, _ROWS)
        old, self._begin = self._begin, np.cumsum(self._room) - self._room
        self._used = int(self._room.sum())
        before = self._rows, self._marks
        room = self._used + self._used // 8 + _ROWS
        self._rows, self._marks = np.zeros((room, 3)), np.zeros((room, 2))
        self._move(before, np.arange(rows.size), old)

    def _move(self, before: tuple[Floats, Floats], nodes: Integers, old: Integers) -> None:
        """Take rows and marks of nodes from where they were to where they begin now."""
        depth = self._depth[nodes]
        place = np.arange(depth.sum()) - np.repeat(np.cumsum(depth) - depth, depth)
        source = np.repeat(old, depth) + place
        target = np.repeat(self._begin[nodes], depth) + place
        self._rows[target], self._marks[target] = before[0][source], before[1][source]

    def _losses(self, place: Floats, step: Floats, code: Integers) -> Floats:
        """What the trial loses, over mu kappa."""
        field, lost = self._field, np.zeros(place.size)
        profile = self._profile(step)
        if profile is not None:
            kernels.active.field_losses(
                place, step, field._steps, code, self._place, self._step, self._begin, self._depth,
                LOSS_RULES, self._rows, lost, *profile.arguments,
            )  # fmt: skip
            return lost
        for i in np.flatnonzero(code % 4):
            diagram, origin = Diagram(), float(field._steps[i])
            first = int(self._begin[i])
            diagram.stack = self._rows[first : first + int(self._depth[i])].copy()
            diagram.stack[:, 0] += origin
            diagram.depth = int(self._depth[i])
            diagram.separation = origin + float(self._step[i])
            diagram.place = float(self._place[i])
            slips = diagram.slips(origin + step[i : i + 1], place[i : i + 1])
            lost[i] = field._curve.losses(slips, 1)[0]
        return lost

    def __repr__(self) -> str:
        return f"FieldState({self._place.size} nodes, {int(self._depth.sum())} rows)"
