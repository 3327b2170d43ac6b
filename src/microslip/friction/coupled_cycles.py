"""The settled cycle of an interface whose separation varies, and its derivative by both motions.

Each step ends on a slip front q with sign s in front of it, in the row that an earlier sample k
left with D_k. With p = displacement/kappa, in units of mu,

    dT = dT_k - N'(q) (dp - dp_k) + s [N'(d) - N'(q)] dd + D_k [N'(q) - N'(d_k)] dd_k
         - dD_k [N(d_k) - N(q) + N'(q) (q - d_k)],

the last where sample k stuck and so left a D_k between -1 and 1 (Jaeger 1998,
DOI 10.1115/1.2833765, differentiated). What sticks hangs from the sample before it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from microslip import kernels
from microslip._core.checks import Floats, is_whole, record, show
from microslip._core.frozen import Locked, lock
from microslip.errors import InputError
from microslip.friction.coupled import Coupling, Joint, steps_of_history
from microslip.friction.cycles import Rest, rest_of, rows_of
from microslip.friction.harmonics import Basis, coefficients_of
from microslip.memory import Diagram

_MOST_SAMPLES = 1 << 20


@dataclass(frozen=True, eq=False)
class CoupledCycle(Locked):
    """The settled cycle of a displacement and a normal load that vary together.

    Made by :meth:`microslip.Interface.periodic`, after Jaeger (1998), DOI 10.1115/1.2833765. Every
    array has one entry a sample.
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
    """Tangent stiffnesses dT/d(displacement) [N/m] of a step that ends at the sample."""
    _trace: _Trace
    _rest_is_mean: bool

    def derivative(
        self,
        displacement: ArrayLike | None = None,
        *,
        separation: ArrayLike | None = None,
        normal_load: ArrayLike | None = None,
    ) -> Floats:
        """How the forces change while displacements and separations change in given directions.

        Changes of the displacement [m], and of the separation [m] or of the normal load [N], at
        each sample a unit of each parameter, are of the shape (samples, parameters) or (samples,).
        Those of the force [N] that come back have it, too; that of the normal load is
        ``-normal_stiffness`` times that of the separation.
        """
        if separation is not None and normal_load is not None:
            raise InputError("separation or normal_load must be given, not both")
        size = self.force.size
        changes = {
            "displacement": displacement,
            "separation": separation,
            "normal_load": normal_load,
        }
        rows = {k: rows_of(k, v, size) for k, v in changes.items() if v is not None}
        if not rows:
            raise InputError("displacement, separation or normal_load must be given")
        shapes = {v.shape for v in rows.values()}
        if len(shapes) > 1:
            raise InputError(f"directions must have one shape, got {sorted(shapes)}")
        shape = shapes.pop()
        by = {k: v.reshape(size, -1) for k, v in rows.items()}
        nothing = np.zeros((size, by[next(iter(by))].shape[1]))
        move = by.get("displacement", nothing)
        if self._rest_is_mean:
            move = move - move.mean(axis=0)
        rise = by.get("separation", nothing)
        if normal_load is not None:
            stiff = self.normal_stiffness[:, None]
            if np.any((stiff == 0.0) & (by["normal_load"] != 0.0)):
                i = int(np.argmax(np.any((stiff == 0.0) & (by["normal_load"] != 0.0), axis=1)))
                raise InputError(f"normal_load must not change where nothing touches: sample {i}")
            rise = -np.divide(by["normal_load"], stiff, out=nothing.copy(), where=stiff > 0.0)
        return self._trace.derivative(move, rise).reshape(shape)

    @cached_property
    def dissipated_energy(self) -> float:
        """Energy dissipated in each cycle [J]."""
        return self._trace.loss()


class _Trace:
    """Two passes of a cycle from rest, of which the second is settled."""

    def __init__(self, coupling: Coupling, steps: Floats, displacement: Floats) -> None:
        self.coupling, size = coupling, steps.size
        self.steps, self.places = np.tile(steps, 2), np.tile(displacement / coupling.slip, 2)
        n = 2 * size
        self.front, self.density = np.empty(n), np.empty(n)
        self.kind, self.parent = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
        room = np.empty((n, 3)), np.empty(n, dtype=np.int64)
        kernels.active.trace(
            self.steps, self.places, self.front, self.density, self.kind, self.parent, *room
        )

    @cached_property
    def normal_stiffnesses(self) -> tuple[Floats, Floats]:
        """-N' at the separations, and that with which a step ends: at its front, or sticking."""
        coupling, stuck = self.coupling, self._stuck
        ends = np.where(stuck, self.steps, self.front)
        slopes = coupling.normal_stiffnesses(np.concatenate((self.steps, ends)))
        here, there = slopes[: self.steps.size], slopes[self.steps.size :].copy()
        if stuck.any():
            width = self._width[stuck]
            there[stuck] = coupling.drop(self.steps[stuck], width) / width
        return here, there

    @cached_property
    def _width(self) -> Floats:
        """Over which D is what the step made it."""
        return np.maximum(self.front - self.steps, 0.0)

    @cached_property
    def _stuck(self) -> Any:
        return (self.kind == 0) & (self._width > 0.0)

    @cached_property
    def _weights(self) -> tuple[Floats, ...]:
        """Of dp, dp_k and dd, dd_k at each sample, and of dD_k."""
        here, there = self.normal_stiffnesses
        parent, stuck = self.parent, self._stuck
        above = np.where(parent < 0, 0, parent)
        old = np.where(parent < 0, 0.0, self.density[above])
        before = np.where(parent < 0, here, here[above])
        # What sticks: D [N'(d) dd - N'(d_k) dd_k] + drop dD with D = (p - p_k)/(d_k - d).
        sign = np.where(self.kind == 2, 0.0, self.density)
        by_rise = -sign * (here - there)
        by_old = np.where(stuck, sign * (before - there), old * (before - there))
        bend = np.zeros(parent.size)
        # Rows that stuck, and that a front has run into since.
        inside = ~stuck & (parent >= 0) & self._stuck[above]
        if inside.any():
            base = self.steps[above[inside]]
            gap = np.maximum(self.front[inside] - base, 0.0)
            bend[inside] = -2.0 * self.coupling.excess_slope(base, gap)
        return there, by_rise, by_old, bend

    def derivative(self, move: Floats, rise: Floats) -> Floats:
        """Forces of the second pass by directions, columns of displacement and separation."""
        there, by_rise, by_old, bend = self._weights
        parent, size = self.parent, self.parent.size // 2
        change, rise = np.tile(move, (2, 1)) / self.coupling.slip, np.tile(rise, (2, 1))
        nothing = np.zeros((1, move.shape[1]))
        change_, rise_ = np.vstack((change, nothing)), np.vstack((rise, nothing))  # index -1: rest
        total = there[:, None] * (change - change_[parent])
        total += by_rise[:, None] * rise + by_old[:, None] * rise_[parent]
        late = np.flatnonzero(bend)
        if late.size:
            k = parent[late]
            j = parent[k]  # before the row that stuck
            width, density = self._width[k, None], self.density[k, None]
            slope = (change_[k] - change_[j] - density * (rise_[j] - rise_[k])) / width
            total[late] += bend[late, None] * slope
        kernels.active.accumulate(parent, total, np.zeros(move.shape[1]))
        return np.ascontiguousarray(self.coupling.friction * total[size:])

    def loss(self) -> float:
        """What a settled cycle dissipates [J]."""
        half = self.steps.size // 2
        lost = self.coupling.losses(self.steps, self.coupling.slip * self.places)
        return float(lost[half:].sum())


def coupled_cycle(
    joint: Joint,
    displacement_cycle: ArrayLike,
    rest: Rest,
    normal_load: Any,
    separation: Any,
) -> CoupledCycle:
    """See :meth:`microslip.Interface.periodic`."""
    x = record("displacement_cycle", displacement_cycle).reshape(-1)
    steps = steps_of_history(joint, x.size, normal_load, separation)
    begin, is_mean = rest_of(rest, x)
    coupling = joint._coupling
    trace = _Trace(coupling, steps, x - begin)
    profile = coupling.profile(float(steps.min()), float(steps.max()))
    values = Diagram().respond(trace.steps, trace.places, coupling.drop, profile)
    here, there = (fall[x.size :] for fall in trace.normal_stiffnesses)
    return CoupledCycle(
        lock(x.copy()),
        lock(steps + joint.separation),
        lock(coupling.friction * values[x.size :]),
        lock(coupling.load(steps)),
        lock(here.copy()),
        lock(coupling.friction / coupling.slip * there),
        trace,
        is_mean,
    )


class CoupledHarmonics(NamedTuple):
    """Fourier coefficients of the settled forces on an interface, and how they change.

    After Jaeger (1998), DOI 10.1115/1.2833765; see :meth:`microslip.Interface.harmonics`.
    """

    force: Floats
    """Coefficients of the tangential force [N], in the order of those of the displacement."""
    normal_load: Floats
    """Those of the normal load [N]."""
    jacobian: Floats
    """Derivatives of force and load (first axis) by displacement and by separation or load as it
    was given (second axis), coefficients by coefficients: shape (2, 2, n, n)."""


def coupled_harmonics(
    joint: Joint,
    coefficients: ArrayLike,
    harmonics: Any,
    rest: Rest,
    normal_load: ArrayLike | None,
    separation: ArrayLike | None,
    samples: int,
) -> CoupledHarmonics:
    """See :meth:`microslip.Interface.harmonics`."""
    if normal_load is not None and separation is not None:
        raise InputError("normal_load or separation must be given, not both")
    basis = Basis(harmonics)
    fewest = 2 * basis.orders[-1] + 1
    if not is_whole(samples) or not fewest <= samples <= _MOST_SAMPLES:
        raise InputError(
            f"samples must be a whole number from {fewest}, for harmonic {basis.orders[-1]}, to "
            f"{_MOST_SAMPLES}, got {show(samples)}"
        )
    size = int(samples)
    waves = basis.values(2.0 * math.pi * np.arange(size) / size)
    analysis = basis.factors[:, None] * waves.T * (2.0 * math.pi / size)
    x = waves @ coefficients_of("coefficients", coefficients, basis)
    name = "separation" if normal_load is None else "normal_load"
    varying_coefficients = separation if normal_load is None else normal_load
    varying: Floats = coefficients_of(name, varying_coefficients, basis)  # type: ignore[arg-type]
    varying_samples = waves @ varying
    cycle = coupled_cycle(
        joint,
        x,
        rest,
        None if normal_load is None else varying_samples,
        None if separation is None else varying_samples,
    )
    by_displacement = analysis @ cycle.derivative(waves)
    if normal_load is None:
        by_other = analysis @ cycle.derivative(separation=waves)
        load = -(analysis * cycle.normal_stiffness) @ waves
    else:
        by_other, load = analysis @ cycle.derivative(normal_load=waves), np.eye(basis.size)
    jacobian = np.array([[by_displacement, by_other], [np.zeros_like(load), load]])
    return CoupledHarmonics(analysis @ cycle.force, analysis @ cycle.normal_load, jacobian)
