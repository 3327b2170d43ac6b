"""A resumable state: what time integrators and long records hold."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, exact, floats, number, record, show
from microslip.errors import Argument, InputError
from microslip.kernels.profile import Profile
from microslip.kernels.table import Table
from microslip.memory.diagram import Diagram, Step
from microslip.memory.record import Memory


class Load(Protocol):
    """What a state asks of a law under a load that varies; separations count from its own."""

    friction: float
    """Coefficient mu [-]."""
    slip: float
    """Displacement per place, kappa [-]."""

    def drop(self, base: Floats, width: Floats) -> Floats:
        """N(b) - N(b + w) [N] for separations b and widths w [m]."""

    def fall(self, separation: float) -> float:
        """-N' [N/m] at a separation [m]."""

    def profile(self, low: float, high: float) -> Profile | None:
        """N over the separations from low to high [m], if it can be tabulated."""

    def step_of(self, load: float) -> float:
        """Separation [m] at a load [N]."""

    def steps_of(self, load: Floats, numbered: bool = True) -> Floats:
        """Separations [m] at loads [N]; what is refused names its sample if it is ``numbered``."""


class Law(Protocol):
    """What a state asks of its law."""

    @property
    def _coupling(self) -> Load | None: ...

    @property
    def _table(self) -> Table | None: ...

    def _backbone(self, u: Floats) -> Floats: ...

    def _backbone_at(self, u: float) -> tuple[float, float]: ...


class _Coupled(NamedTuple):
    """A trial under a load that varies."""

    displacement: float
    diagram: Diagram
    step: Step


def loads_along(name: str, given: ArrayLike, size: int) -> Floats:
    """Normal loads [N] >= 0 of a record of ``size`` samples: one for each, or one for all.

    Raises
    ------
    InputError
        Not finite, negative, or another number of them.
    """
    values = along(name, given, size)
    if values.min() < 0.0:
        i = int(np.argmax(values < 0.0))
        where = f" at sample {i}" if np.ndim(given) else ""
        raise InputError(
            Argument(name), f" must not be negative [N], got {exact(values[i])}{where}"
        )
    return values


def along(name: str, given: ArrayLike, size: int) -> Floats:
    """Numbers along a record of ``size`` samples: one for each, or one for all.

    Raises
    ------
    InputError
        Not finite, or another number of them.
    """
    values = floats(name, given)
    if values.ndim > 1 or values.size not in (1, size):
        raise InputError(
            Argument(name),
            f" must be one number or one for each of the {size} samples, got shape {values.shape}",
        )
    return np.ascontiguousarray(np.broadcast_to(values.reshape(-1), (size,)))


class State:
    """The place of one joint on its hysteresis, made by ``joint.start()``: (19.19)-(19.24).

    A trial moves nothing until it is committed::

        force, stiffness = state.try_(1.2e-6)  # as often as a solver's iteration wants
        state.commit()  # the last trial becomes the state
        state.rollback()  # or it is forgotten
        forces = state.advance(chunk)  # whole pieces of a record, committed at once

    Every trial starts from the last committed state, never from another trial. Where the law has a
    surface, each trial may come with a normal load of its own.
    """

    __slots__ = ("_diagram", "_law", "_memory", "_trial")

    def __init__(self, law: Law) -> None:
        if not hasattr(law, "_backbone_at"):
            raise InputError(
                Argument("law"), f" must be a backbone law, got {show(law)}; write joint.start()"
            )
        self._law = law
        self._memory = Memory()
        # Once the load has varied, this is the memory.
        self._diagram: Diagram | None = None
        self._trial: tuple[float, float, tuple[int, int, int]] | _Coupled | None = None

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
        """Number of reversals that are remembered; all that the state stores grows with it.

        After the load has varied: the rows of the memory diagram.
        """
        return self._memory.depth if self._diagram is None else self._diagram.depth

    def try_(self, displacement: float, normal_load: float | None = None) -> tuple[float, float]:
        """Force and tangent stiffness at a trial displacement and, if it varies, normal load.

        Parameters
        ----------
        displacement : float
            Trial displacement [m].
        normal_load : float, optional
            Trial normal load [N], not negative; without it the load stays what it is. The step from
            the committed state is a straight line of separation and displacement.

        Returns
        -------
        force : float
            Force needed to hold the displacement [N].
        stiffness : float
            Tangent stiffness [N/m], at this load, of the branch that the step ends on.

        Raises
        ------
        InputError
            A displacement that is not finite; a load that the surface cannot carry, or any load
            for a law without a surface.
        """
        self._trial = None  # should this one fail, no earlier one is left to commit
        x = number("displacement", displacement, "m")
        step = self._step(normal_load)
        if step is not None:
            return self._try_coupled(x, step)
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
        if isinstance(self._trial, _Coupled):
            trial, load = self._trial, self._coupling()
            trial.diagram.move(trial.step)
            self._settle(trial.diagram, trial.displacement, load.friction * trial.step.value)
        else:
            self._memory.move(*self._trial)
        self._trial = None

    def rollback(self) -> None:
        """Forget the last trial, if there is one."""
        self._trial = None

    def advance(self, displacement: ArrayLike, normal_load: ArrayLike | None = None) -> Any:
        """Forces along a piece of a record, which becomes part of the state.

        Parameters
        ----------
        displacement : array_like
            Displacements [m], one-dimensional, not empty; one number counts as one sample.
        normal_load : array_like, optional
            Normal loads [N], one for each displacement or one number; without it the load stays.

        Returns
        -------
        ndarray or float
            Forces [N], one for each displacement. Pieces in a row give what the whole gives.

        Raises
        ------
        InputError
            Empty, several dimensions, or not finite; loads as for :meth:`try_`, or of another
            length. The state is then unchanged.
        """
        x = record("displacement", displacement)
        self._trial = None
        if normal_load is not None or self._diagram is not None:
            forces = self._advance_coupled(x.reshape(-1), normal_load)
            return float(forces[0]) if x.ndim == 0 else forces
        if x.size == 1:  # in constant time, however many reversals are open
            force = self.try_(float(x.reshape(-1)[0]))[0]
            self.commit()
            return force if x.ndim == 0 else np.array([force])
        return self._memory.respond(x, self._law._backbone, self._law._table)

    def copy(self) -> State:
        """An independent state at the same place, an open trial included."""
        other = State(self._law)
        other._memory = self._memory.copy()
        other._diagram = None if self._diagram is None else self._diagram.copy()
        trial = self._trial
        if isinstance(trial, _Coupled):
            trial = trial._replace(diagram=other._diagram or trial.diagram.copy())
        other._trial = trial
        return other

    __copy__ = copy

    # -- a load that varies -----------------------------------------------------------------------

    def _coupling(self) -> Load:
        load = self._law._coupling
        if load is None:
            raise InputError("normal_load has no meaning for this law: it has no surface")
        return load

    def _step(self, normal_load: float | None) -> float | None:
        """Separation of a trial from the joint's own; None where the load has never varied."""
        if normal_load is None:
            return None if self._diagram is None else self._diagram.separation
        load = number("normal_load", normal_load, "N")
        if load < 0.0:
            raise InputError(
                Argument("normal_load"), f" must not be negative [N], got {exact(load)}"
            )
        step = self._coupling().step_of(load)
        return None if step == 0.0 and self._diagram is None else step

    def _current(self) -> Diagram:
        """The diagram of the committed state; from the open reversals while there is none."""
        if self._diagram is not None:
            return self._diagram
        memory, load = self._memory, self._coupling()
        places = np.append(memory.stack[: memory.depth, 0], memory.last) / load.slip
        diagram = Diagram()
        diagram.respond(np.zeros(places.size), places, load.drop)
        return diagram

    def _try_coupled(self, x: float, step: float) -> tuple[float, float]:
        load, diagram = self._coupling(), self._current()
        profile = load.profile(min(step, diagram.separation), max(step, diagram.separation))
        probed = diagram.probe(step, x / load.slip, load.drop, profile)
        self._trial = _Coupled(x, diagram, probed)
        if probed.fall is not None:
            fall = probed.fall
        elif probed.kind == 1:
            fall = load.fall(probed.front)
        elif probed.front > step:  # new contact that sticks: its share of the load
            width = probed.front - step
            fall = float(load.drop(np.array([step]), np.array([width]))[0]) / width
        else:
            fall = load.fall(diagram.front() if probed.kind == 0 else step)
        return load.friction * probed.value, load.friction / load.slip * fall

    def _advance_coupled(self, x: Floats, normal_load: ArrayLike | None) -> Floats:
        load, diagram = self._coupling(), self._current()
        if normal_load is None:
            steps = np.full(x.size, diagram.separation)
        else:
            loads = loads_along("normal_load", normal_load, x.size)
            steps = load.steps_of(loads, numbered=np.ndim(normal_load) > 0)
        profile = load.profile(
            min(float(steps.min()), diagram.separation), max(float(steps.max()), diagram.separation)
        )
        forces = load.friction * diagram.respond(steps, x / load.slip, load.drop, profile)
        self._settle(diagram, float(x[-1]), float(forces[-1]))
        return forces

    def _settle(self, diagram: Diagram, displacement: float, force: float) -> None:
        if self._diagram is None:
            self._memory = Memory()
        self._diagram = diagram
        self._memory.last, self._memory.value = displacement, force

    def __repr__(self) -> str:
        return (
            f"State(displacement={self.displacement:g}, force={self.force:g}, "
            f"open_reversals={self.open_reversals})"
        )
