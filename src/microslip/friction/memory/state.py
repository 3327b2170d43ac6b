"""Resumable state of a joint, for time integration and long records.

Equation numbers (19.x) are those of chapter 19, DOI 10.1007/978-3-319-56818-8_19.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import LARGEST, Floats, beyond, exact, number, record, show
from microslip._core.errors import InputError
from microslip.friction.memory.diagram import (
    Diagram,
    EnergyAccumulator,
    Step,
    checked_depth,
    merging_profile,
)
from microslip.friction.memory.nodes import steps_along
from microslip.friction.memory.record import Memory
from microslip.friction.memory.resumable import Resumable, synchronized
from microslip.friction.memory.trial import Trial

if TYPE_CHECKING:
    from microslip.contact.load_curve import LoadCurve


class State(Resumable):
    """Hysteresis state of one joint, returned by ``joint.start()``: (19.19)-(19.24).

    A trial does not change the state until it is committed::

        force, stiffness = state.try_(1.2e-6)  # in each iteration of a solver
        trial = state.try_(1.2e-6, separation=d)  # also trial.normal_load, trial.tangent
        state.commit()  # the last trial becomes the state
        state.rollback()  # or it is discarded
        forces = state.advance(chunk)  # a chunk of a record, committed

    Every trial starts from the last committed state. If the law has a surface, each trial may have
    its own normal load. Calls from several threads are serialised.
    """

    __slots__ = ("_accumulator", "_diagram", "_law", "_lost", "_memory")

    _changing = ("_diagram", "_accumulator", "_memory")
    # Displacement, force and move of the memory, or displacement and step of the diagram.
    _trial: tuple[float, float, tuple[int, int, int]] | tuple[float, Step] | None

    def __init__(self, law: Any, depth: int | None = None) -> None:
        if not hasattr(law, "_backbone_at"):
            raise InputError(f"`law` must be a backbone law, got {show(law)}; write joint.start()")
        super().__init__()
        self._law, self._memory = law, Memory()
        # Replaces the memory once the load has varied.
        self._diagram: Diagram | None = None
        self._accumulator: EnergyAccumulator | None = None
        self._lost = 0.0  # energy dissipated in closed loops at constant load [J]
        if depth is not None:
            if law._load_curve is None:
                raise InputError(
                    "`depth` must be None for a law without a surface; exported code has a limit: "
                    'microslip.export.write("c", law, ...)'
                )
            limit = checked_depth(depth)
            merging_profile(law._load_curve, 0.0)
            self._diagram = Diagram(limit)
            self._accumulator = EnergyAccumulator(self._diagram, 0.0)

    @property
    def displacement(self) -> float:
        """Committed displacement [m]."""
        return self._memory.last

    @property
    def force(self) -> float:
        """Committed force [N]."""
        return self._memory.value

    @property
    def normal_load(self) -> float:
        """Committed normal load [N], for an interface only."""
        return self._committed().normal_load

    @property
    def separation(self) -> float:
        """Committed separation [m], for an interface only."""
        return self._committed().separation

    @property
    def stiffness(self) -> float:
        """Tangent stiffness [N/m] at constant load for continued motion in the last direction."""
        return self._committed().stiffness

    @property
    @synchronized
    def dissipated_energy(self) -> float:
        """Energy dissipated since rest [J], nondecreasing."""
        if self._accumulator is not None and self._diagram is not None:
            return self._accumulator.settle(self._diagram, self._curve())
        memory = self._memory
        ends = np.append(memory.stack[: memory.depth, 0], memory.last)
        # First loading, and a branch from each open reversal to the next.
        amplitudes = 0.5 * np.abs(np.diff(ends, prepend=0.0))
        amplitudes[0] *= 2.0
        energy = 0.5 * self._law._energy(amplitudes)
        energy[0] *= 0.5
        return self._lost + float(energy.sum())

    @property
    @synchronized
    def stored_energy(self) -> float:
        """Elastic energy of the tangential springs [J].

        The sum of force^2/(2 stiffness) over the sliders (Iwan 1966, DOI 10.1115/1.3625199), in
        closed form from the memory. At a constant load the work done on the joint equals stored
        plus dissipated energy; at a varying load the normal force also does work on slipping
        contacts.
        """
        if self._diagram is not None:
            return self._diagram.stored(self._curve())
        memory, law = self._memory, self._law
        rows = memory.stack[: memory.depth]
        ends = np.append(rows[:, 0], memory.last)
        half = 0.5 * np.abs(np.diff(ends, prepend=0.0))
        half[0] *= 2.0
        backbone = law._backbone(half)
        first = 0.5 * half[0] * backbone[0] - 0.125 * float(law._energy(half[:1])[0])
        branches = rows[:, 1] * np.diff(ends) + 2.0 * half[1:] * backbone[1:]
        return max(float(first + branches.sum()), 0.0)

    @property
    def open_reversals(self) -> int:
        """Number of open reversals; memory use grows with it.

        Once the load has varied, or with a ``depth``: the number of rows of the memory diagram.
        """
        return self._memory.depth if self._diagram is None else self._diagram.depth

    @property
    def error_bound(self) -> float:
        """Bound of the force error [N] due to a limited depth; 0 without a limit.

        Actual errors are smaller by an order of magnitude or more. The bound is at most twice the
        friction limit; at that value the force is undetermined.
        """
        if self._diagram is None or self._diagram.limit is None:
            return 0.0
        return float(self._diagram.errors[-1]) * self._curve().friction

    @synchronized
    def try_(
        self,
        displacement: float,
        normal_load: float | None = None,
        *,
        separation: float | None = None,
    ) -> Trial:
        """Compute force and tangents at a trial displacement and load or separation.

        Parameters
        ----------
        displacement : float
            Trial displacement [m].
        normal_load : float, optional
            Trial normal load [N], not negative; by default it does not change. The step from the
            committed state is straight in separation and displacement.
        separation : float, optional
            Trial separation [m], given instead of the load.

        Returns
        -------
        Trial
            Unpacks as ``force, stiffness``: the force [N] at the trial displacement and the tangent
            stiffness [N/m] at constant load. Its attributes include ``normal_load`` and the
            tangents with respect to displacement and separation or load.
        """
        self._trial = None  # after an error there is no trial to commit
        x = number("displacement", displacement, "m")
        if separation is not None:
            if normal_load is not None:
                raise InputError("`normal_load` or `separation` must be given, not both")
            d = number("separation", separation, "m")
            step: float | None = float(self._curve("separation").steps_at(d))
        else:
            if normal_load is not None:
                normal_load = number("normal_load", normal_load, "N")
            step = self._step(normal_load)
        trial: Trial
        trial, self._trial = self._trial_of(x, step, normal_load)
        return trial

    def _apply(self, trial: Any) -> None:
        if len(trial) == 2:
            x, step = trial
            diagram, curve = self._current(), self._curve()
            accumulator = self._open_accumulator(diagram)
            diagram.move(step, curve)
            accumulator.note(np.array([step.separation]), np.array([x]), diagram, curve)
            self._settle(diagram, x, curve.friction * step.value)
            return
        memory, (depth, pushed, direction) = self._memory, trial[2]
        if not pushed and (depth, direction) != (memory.depth, memory.direction):
            self._close(np.array([trial[0]]), max(depth - 2, 0))
        memory.move(*trial)

    @synchronized
    def advance(
        self,
        displacement: ArrayLike,
        normal_load: ArrayLike | None = None,
        *,
        separation: ArrayLike | None = None,
    ) -> Any:
        """Compute forces along a chunk of a record and update the state.

        Parameters
        ----------
        displacement : array_like
            Displacements [m], one-dimensional, not empty; a number is one sample.
        normal_load : array_like, optional
            Normal loads [N], a number or one per displacement; by default constant.
        separation : array_like, optional
            Separations [m], given instead of the loads.

        Returns
        -------
        ndarray or float
            Forces [N], one per displacement. They do not depend on the size of chunks.
        """
        x = record("displacement", displacement, "m")
        self._trial = None
        if normal_load is None and separation is None and self._diagram is None:
            if x.size == 1:  # constant time for any number of open reversals
                force = self.try_(float(x.reshape(-1)[0]))[0]
                self.commit()
                return force if x.ndim == 0 else np.array([force])
            self._close(x)
            return self._memory.respond(x, self._law._backbone, self._law._table)
        if normal_load is not None and separation is not None:
            raise InputError("`normal_load` or `separation` must be given, not both")
        curve = self._curve("normal_load" if separation is None else "separation")
        diagram = self._current()
        if normal_load is None and separation is None:
            steps = np.full(x.size, diagram.separation)
        else:
            steps = steps_along(curve, x.size, normal_load, separation)
        accumulator = self._open_accumulator(diagram)
        row = x.reshape(-1)
        forces = curve.friction * diagram.respond(steps, beyond(row, curve.slip), curve)
        accumulator.note(steps, row.copy(), diagram, curve)
        self._settle(diagram, float(row[-1]), float(forces[-1]))
        return float(forces[0]) if x.ndim == 0 else forces

    def _close(self, x: Floats, first: int = 0) -> None:
        """Add the energies of loops closed by ``x`` [m]; ignore the ``first`` oldest reversals."""
        closed = self._memory.closed(x, first)
        if closed.size:
            # Limit the amplitude to avoid overflow.
            energy = self._law._energy(np.minimum(np.abs(closed), LARGEST))
            self._lost += float(np.where(closed < 0.0, 0.5 * energy, energy).sum())

    # -- a step -----------------------------------------------------------------------------------

    def _trial_of(self, x: float, step: float | None, normal_load: float | None = None) -> Any:
        """Return the trial at displacement ``x`` [m] and ``step`` [m], and the data to commit it.

        ``step`` is the separation minus that of the joint, None at constant load. The second result
        is the argument of :meth:`_apply`.
        """
        if step is None:
            half, sign, start, move = self._memory.probe(x)
            value, slope = self._law._backbone_at(half)
            force = start + sign * value
            return Trial._of(force, slope, x, float(move[2]), self._law._load_curve), (
                x,
                force,
                move,
            )
        curve, diagram = self._curve(), self._current()
        probed = diagram.probe(step, beyond(x, curve.slip), curve)
        rests = probed.kind == 0 and not probed.front > step
        density = diagram.slip if rests else probed.density
        force, stiffness = curve.friction * probed.value, curve.friction / curve.slip * probed.fall
        return Trial._of(force, stiffness, x, density, curve, step, normal_load), (x, probed)

    def _committed(self) -> Trial:
        step = None if self._diagram is None else self._diagram.separation
        trial: Trial = self._trial_of(self._memory.last, step)[0]
        return trial

    # -- varying load -----------------------------------------------------------------------------

    def _curve(self, name: str = "normal_load") -> LoadCurve:
        curve: LoadCurve | None = self._law._load_curve
        if curve is None:
            raise InputError(f"`{name}` has no meaning for a law without a surface")
        return curve

    def _open_accumulator(self, diagram: Diagram) -> EnergyAccumulator:
        if self._accumulator is None:
            self._accumulator = EnergyAccumulator(diagram, self.dissipated_energy)
        return self._accumulator

    def _step(self, normal_load: float | None) -> float | None:
        """Return the separation under a load minus that of the joint [m]; None at constant load."""
        if normal_load is None:
            return None if self._diagram is None else self._diagram.separation
        if normal_load < 0.0:
            raise InputError(f"`normal_load` must not be negative [N], got {exact(normal_load)}")
        step = self._curve().step_of(normal_load)
        return None if step == 0.0 and self._diagram is None else step

    def _current(self) -> Diagram:
        if self._diagram is not None:
            return self._diagram
        memory, curve, diagram = self._memory, self._curve(), Diagram()
        places = np.append(memory.stack[: memory.depth, 0], memory.last) / curve.slip
        diagram.respond(np.zeros(places.size), places, curve)
        return diagram

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
