"""Resumable hysteresis state of all nodes of a contact field."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from microslip._core import kernels
from microslip._core.checks import LARGEST, Floats, floats
from microslip._core.kernels import Integers
from microslip.friction.memory.diagram import (
    ERROR_SIZE,
    Diagram,
    checked_depth,
    merging_profile,
)
from microslip.friction.memory.nodes import Nodes
from microslip.friction.memory.resumable import Resumable, accumulated, synchronized

_ROWS = 2  # initial rows per node, sufficient for a move to and fro


class FieldResponse(tuple[Floats, ...]):
    """Response of the nodes of a field to displacements and separations.

    Unpacks as ``force, stiffness`` for constant separations, otherwise as ``force, load, tangent``.
    After Cattaneo and Mindlin, by superposition (Jaeger 1998, DOI 10.1115/1.2833765).
    """

    force: Floats
    """Tangential forces T [N], shape (nodes,)."""
    load: Floats
    """Normal loads N [N], shape (nodes,)."""
    tangent: Floats
    """Derivatives of (T, N) with respect to (displacement, separation) [N/m], (nodes, 2, 2)."""

    def __new__(
        cls, force: Floats, load: Floats, tangent: Floats, stiffness: Floats | None = None
    ) -> Self:
        """Create the response; with ``stiffness`` it unpacks as for constant separations."""
        parts = (force, load, tangent) if stiffness is None else (force, stiffness)
        response = super().__new__(cls, parts)
        response.force, response.load, response.tangent = force, load, tangent
        return response

    @property
    def stiffness(self) -> Floats:
        """Tangent stiffnesses dT/d(displacement) [N/m]."""
        return self.tangent[..., 0, 0]


_FLOAT = np.dtype(float)


def _is_plain(values: ArrayLike, size: int) -> bool:
    """Return True for a contiguous float64 array of shape (size,), which kernels accept."""
    return (
        type(values) is np.ndarray
        and values.dtype is _FLOAT
        and values.shape == (size,)
        and values.flags.c_contiguous
    )


class FieldState(Resumable):
    """Hysteresis state of all nodes of a field, returned by :meth:`JointField.start`.

    A trial does not change the state until it is committed, as in :class:`microslip.State`::

        forces, stiffnesses = state.try_(displacements)
        forces, loads, tangents = state.try_(displacements, separations=d)
        state.commit()  # or state.rollback()

    Each node has a memory diagram (DOI 10.3389/fmech.2020.00030), exact within the theory of
    Cattaneo and Mindlin. A row of the diagram is an open reversal, or a step of new contact that
    has not slipped since. A state needs 144 bytes per node, 40 more during a trial, and about 60
    for each row beyond two per node. A ``depth`` limits the number of rows.
    """

    __slots__ = (
        "_begin", "_depth", "_errors", "_held", "_limit", "_loss", "_marks", "_nodes", "_now",
        "_room", "_rows", "_used",
    )  # fmt: skip

    _changing = ("_begin", "_depth", "_errors", "_loss", "_marks", "_now", "_room", "_rows")
    # Places, fronts, densities and T/mu, for varying steps also these, N and -N' of the curve;
    # codes of the moves; range of the curve.
    _trial: tuple[Floats, Integers, tuple[float, float]] | None
    _errors: Floats | None
    _now: Floats  # rows: place, step, T/mu, N and -N' of the curve, committed
    # Range and kernel arguments of the curve at constant separations.
    _held: tuple[tuple[float, float], tuple[Any, ...]] | None

    def __init__(self, nodes: Nodes, energies: bool, depth: int | None = None) -> None:
        super().__init__()
        size = nodes.size
        self._limit, self._errors = checked_depth(depth), None
        if self._limit is not None:
            merging_profile(nodes.curve, 0.0)
            self._errors = np.zeros((size, ERROR_SIZE))
        self._nodes, self._held = nodes, None
        self._rows, self._marks = np.zeros((_ROWS * size, 3)), np.zeros((_ROWS * size, 2))
        self._begin, self._room = _ROWS * np.arange(size), np.full(size, _ROWS)
        self._used = _ROWS * size
        self._depth = np.zeros(size, dtype=np.int64)
        self._now = np.zeros((5, size))
        self._now[3:] = nodes.curve.load(nodes.rests)
        self._loss = np.zeros(size) if energies else None

    @property
    def _place(self) -> Floats:
        return np.asarray(self._now[0])

    @property
    def _step(self) -> Floats:
        return np.asarray(self._now[1])

    @property
    def _value(self) -> Floats:
        return np.asarray(self._now[2])

    @property
    def displacement(self) -> Floats:
        """Committed displacements [m]."""
        return self._place * self._nodes.slips

    @property
    def separation(self) -> Floats:
        """Committed separations [m]."""
        return self._nodes.separations_of(self._nodes.rests + self._step)

    @property
    def force(self) -> Floats:
        """Committed forces [N]."""
        return self._value * self._nodes.weights

    @property
    def normal_load(self) -> Floats:
        """Committed normal loads [N]."""
        return np.asarray(self._nodes.scales * self._now[3])

    @property
    def open_reversals(self) -> Integers:
        """Number of rows of the memory diagram of each node; memory use grows with it."""
        return self._depth.copy()

    @property
    def dissipated_energy(self) -> Floats:
        """Energies dissipated since rest [J], shape (nodes,).

        InputError is raised unless the state was started with ``energies=True``.
        """
        return accumulated(self._loss) * self._nodes.weights * self._nodes.slips

    @property
    @synchronized
    def stored_energy(self) -> Floats:
        """Elastic energies of the tangential springs [J], shape (nodes,), as in State."""
        nodes = self._nodes
        stored = [self._diagram(i).stored(nodes.curve) for i in range(nodes.size)]
        return np.array(stored) * nodes.weights * nodes.slips

    def _diagram(self, node: int) -> Diagram:
        diagram, origin, begin = Diagram(), self._nodes.rests[node], int(self._begin[node])
        diagram.depth = int(self._depth[node])
        diagram.stack = self._rows[begin : begin + diagram.depth] + np.array([origin, 0.0, 0.0])
        diagram.separation = float(origin + self._step[node])
        diagram.place = float(self._place[node])
        return diagram

    @property
    def error_bound(self) -> Floats:
        """Bounds of the force errors [N] due to a limited depth, shape (nodes,)."""
        if self._errors is None:
            return np.zeros(self._nodes.size)
        return self._errors[:, -1] * self._nodes.weights

    @synchronized
    def try_(self, displacement: ArrayLike, separations: ArrayLike | None = None) -> FieldResponse:
        """Compute forces and tangents at trial displacements and separations.

        Parameters
        ----------
        displacement : array_like
            Trial displacements [m], a number or one-dimensional, one per node.
        separations : array_like, optional
            Trial separations [m], a number or one per node; by default they do not change. The step
            from the committed state is straight in separation and displacement.

        Returns
        -------
        FieldResponse
            ``force`` T and ``load`` N [N] and ``stiffness`` [N/m], shape (nodes,), and ``tangent``
            [N/m], shape (nodes, 2, 2): derivatives of (T, N) with respect to (displacement,
            separation) at the end of the step. Unpacks as ``force, stiffness`` without separations,
            as ``force, load, tangent`` with separations.
        """
        self._trial = None  # after an error there is no trial to commit
        nodes = self._nodes
        size = nodes.size
        if not _is_plain(displacement, size):
            displacement = nodes.per_node("displacement", displacement, "m")
        step = None
        if separations is None:
            if self._held is None:
                reach = nodes.reach(self._step)
                self._held = reach, nodes.curve.arguments(*reach)
            reach, curve = self._held
        else:
            step, reach = self._steps(separations)
            curve = nodes.curve.arguments(*reach)
        force, load, tangent = np.empty(size), np.empty(size), np.empty((size, 2, 2))
        stiffness = np.empty(size) if step is None else None
        trial, code = np.empty((4 if step is None else 7, size)), np.empty(size, dtype=np.int64)
        if kernels.compiled.field_try(
            displacement, step, nodes.rests, nodes.slips, nodes.weights, nodes.scales,
            nodes.lengths, self._now, self._rows, self._marks, self._begin, self._depth, trial,
            code, force, load, tangent, stiffness, *curve,
        ):  # fmt: skip
            floats("displacement", displacement, "m")  # raises: a value is not finite
        self._trial = trial, code, reach
        return FieldResponse(force, load, tangent, stiffness)

    def _steps(self, separations: ArrayLike) -> tuple[Floats, tuple[float, float]]:
        """Return the steps of a trial from rest [m], and the least and largest from the origin."""
        nodes = self._nodes
        if _is_plain(separations, nodes.size):
            step = np.empty(nodes.size)
            wrong, least, low, high = kernels.compiled.field_steps(
                separations, nodes.curve.origin, nodes.origins, nodes.lengths, nodes.rests,
                self._step, step,
            )  # fmt: skip
            if not wrong and least >= nodes.nearest and high <= LARGEST:
                return step, (low, low if nodes.curve.shared else high)
        step = nodes.steps_at("separations", separations) - nodes.rests
        return step, nodes.reach(self._step, step)

    def _apply(self, trial: Any) -> None:
        values, code, reach = trial
        place, front, step = values[0], values[1], self._step
        if len(values) > 4:
            step, self._held = values[4], None
        if self._loss is not None:
            self._loss += self._losses(place, step, code, reach)
        if self._errors is not None:
            nodes, code = self._nodes, code.copy()
            farthest = max(float((nodes.rests + step).max()), 0.0)
            kernels.compiled.field_bound(
                step, nodes.rests, front, code, self._begin, self._depth, self._limit,
                self._errors, self._rows, self._marks,
                *merging_profile(nodes.curve, farthest).arguments,
            )  # fmt: skip
        for _ in range(2):
            self._used = kernels.compiled.field_commit(
                values, code, self._begin, self._room, self._now, self._rows, self._marks,
                self._depth, self._used,
            )  # fmt: skip
            if self._used >= 0:
                break
            self._repack(code >> 2, (code >> 2) + (front > step))

    def _repack(self, kept: Integers, rows: Integers) -> None:
        """Rebuild the common storage so that each node has room for ``rows`` rows and 6 % more.

        Only the rows that remain after the step, ``kept`` per node, are copied.
        """
        self._room = np.maximum(rows + rows // 2 + 1, _ROWS)
        old, self._begin = self._begin, np.cumsum(self._room) - self._room
        self._used = int(self._room.sum())
        room = self._used + self._used // 16 + _ROWS
        before = self._rows, self._marks
        self._rows, self._marks = np.empty((room, 3)), np.empty((room, 2))
        kernels.compiled.field_move(kept, old, self._begin, *before, self._rows, self._marks)
        self._depth = kept

    def _losses(self, place: Floats, step: Floats, code: Integers, reach: Any) -> Floats:
        """Return energies dissipated in a step: per node [J], divided by ``weights`` and ``slips``.

        ``code`` is 4 times the number of rows that remain, plus 0 for a node that sticks.
        """
        nodes, lost = self._nodes, np.empty(place.size)
        profile = nodes.curve.profile(*reach)
        if profile is not None:
            kernels.compiled.field_losses(
                place, step, nodes.rests, code, self._place, self._step, self._begin, self._depth,
                profile.loss_rules, self._rows, lost, *profile.arguments,
            )  # fmt: skip
            return lost
        runs = [np.zeros((8, 0))]
        for i in np.flatnonzero(code % 4).tolist():
            at_end = nodes.rests[i] + step[i : i + 1], place[i : i + 1]
            runs.append(self._diagram(i).runs(*at_end))
            runs[-1][0] = i
        # All nodes at once; a shared curve has no coefficient of friction and no kappa.
        return nodes.curve.slip_losses.of(np.concatenate(runs, axis=1), place.size)

    def __repr__(self) -> str:
        return f"FieldState({self._place.size} nodes, {int(self._depth.sum())} rows)"
