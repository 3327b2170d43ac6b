"""A resumable state: what time integrators and long records hold."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from microslip._checks import Floats, exact, number, record, show
from microslip.errors import InputError
from microslip.kernels.table import Table
from microslip.memory.record import Memory


class Law(Protocol):
    """What a state asks of its law."""

    @property
    def _table(self) -> Table | None: ...

    @property
    def _held_load(self) -> float | None: ...

    def _backbone(self, u: Floats) -> Floats: ...

    def _backbone_at(self, u: float) -> tuple[float, float]: ...


class State:
    """The place of one joint on its hysteresis, made by ``joint.start()``: (19.19)-(19.24).

    A trial moves nothing until it is committed::

        force, stiffness = state.try_(1.2e-6)  # as often as a solver's iteration wants
        state.commit()  # the last trial becomes the state
        state.rollback()  # or it is forgotten
        forces = state.advance(chunk)  # whole pieces of a record, committed at once

    Every trial starts from the last committed state, never from another trial.
    """

    __slots__ = ("_law", "_memory", "_trial")

    def __init__(self, law: Law) -> None:
        if not hasattr(law, "_backbone_at"):
            raise InputError(f"law must be a backbone law, got {show(law)}; write joint.start()")
        self._law = law
        self._memory = Memory()
        self._trial: tuple[float, float, tuple[int, int, int]] | None = None

    @property
    def displacement(self) -> float:
        """Committed displacement [m]."""
        return self._memory.last

    @property
    def force(self) -> float:
        """Committed force [N]."""
        return self._memory.value

    @property
    def open_reversals(self) -> int:
        """Number of reversals that are remembered; all that the state stores grows with it."""
        return self._memory.depth

    def try_(self, displacement: float, normal_load: float | None = None) -> tuple[float, float]:
        """Force and tangent stiffness at a trial displacement.

        Parameters
        ----------
        displacement : float
            Trial displacement [m].
        normal_load : float, optional
            Normal load [N]; this state holds the load of its joint, so only that one is accepted.

        Returns
        -------
        force : float
            Force needed to hold the displacement [N].
        stiffness : float
            Tangent stiffness [N/m] of the branch that the move to the displacement ends on.

        Raises
        ------
        InputError
            A displacement that is not finite; another normal load than the joint's.
        """
        self._trial = None  # should this one fail, no earlier one is left to commit
        x = number("displacement", displacement, "m")
        if normal_load is not None:
            self._check_load(normal_load)
        half, sign, start, move = self._memory.probe(x)
        value, slope = self._law._backbone_at(half)
        force = start + sign * value
        self._trial = x, force, move
        return force, slope

    def commit(self) -> None:
        """Make the last trial the state.

        Raises
        ------
        InputError
            There is no trial.
        """
        if self._trial is None:
            raise InputError("commit needs a trial: call try_(displacement) first")
        self._memory.move(*self._trial)
        self._trial = None

    def rollback(self) -> None:
        """Forget the last trial, if there is one."""
        self._trial = None

    def advance(self, displacement: ArrayLike) -> Any:
        """Forces along a piece of a record, which becomes part of the state.

        Parameters
        ----------
        displacement : array_like
            Displacements [m], one-dimensional, not empty; one number counts as one sample.

        Returns
        -------
        ndarray or float
            Forces [N], one for each displacement. Pieces in a row give what the whole gives.

        Raises
        ------
        InputError
            Empty, several dimensions, or not finite; the state is then unchanged.
        """
        x = record("displacement", displacement)
        self._trial = None
        if x.size == 1:  # in constant time, however many reversals are open
            force = self.try_(float(x.reshape(-1)[0]))[0]
            self.commit()
            return force if x.ndim == 0 else np.array([force])
        forces = self._memory.respond(x, self._law._backbone, self._law._table)
        return forces

    def copy(self) -> State:
        """An independent state at the same place, an open trial included."""
        other = State(self._law)
        other._memory, other._trial = self._memory.copy(), self._trial
        return other

    __copy__ = copy

    def _check_load(self, normal_load: float) -> None:
        load = number("normal_load", normal_load, "N")
        held = self._law._held_load
        if held is None:
            raise InputError(f"normal_load has no meaning for this law, got {exact(load)} N")
        if load != held:
            raise InputError(
                f"normal_load must be the joint's own {exact(held)} N, which this state holds, got "
                f"{exact(load)} N; for another constant load: "
                f"joint.at(normal_load={exact(load)}).start()"
            )

    def __repr__(self) -> str:
        return (
            f"State(displacement={self.displacement:g}, force={self.force:g}, "
            f"open_reversals={self.open_reversals})"
        )
