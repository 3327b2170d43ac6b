"""Settled cycles of joints whose separation varies, one or many, with their derivatives.

Each step ends on a slip front q with sign s in front of it, in the row that an earlier sample k
left with D_k. With p = displacement/kappa, in units of mu,

    dT = dT_k - N'(q) (dp - dp_k) + s [N'(d) - N'(q)] dd + D_k [N'(q) - N'(d_k)] dd_k
         - dD_k [N(d_k) - N(q) + N'(q) (q - d_k)],

the last where sample k stuck and so left a D_k between -1 and 1 (Jaeger 1998,
DOI 10.1115/1.2833765, differentiated). What sticks hangs from the sample before it.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from microslip import kernels
from microslip._core.checks import Floats
from microslip.kernels import Integers
from microslip.memory import Nodes

_NOTHING = np.zeros(0)


class NodeCycles:
    """Cycles of nodes by places and steps from rest, (nodes, samples); held without steps.

    Each node goes from rest in a straight line to the sample where step + |place| is largest, its
    root. All memory is gone there, unless the root lies within what that path pressed down
    sticking: then a second pass settles it.
    """

    def __init__(self, nodes: Nodes, displacements: Floats, steps: Floats | None) -> None:
        self.nodes, self.steps = nodes, steps
        # Beyond 1e200 slips there is no more to come, but numbers that overflow.
        with np.errstate(over="ignore"):
            places = np.clip(displacements / nodes.slips[:, None], -1e200, 1e200)
        self.places = np.ascontiguousarray(places)
        self._profile = nodes.profile(steps)

    @cached_property
    def _trace(self) -> _Trace:
        """The cycles where the curve is no profile."""
        return _Trace(self.nodes, self.places, self.steps)

    def forces(self) -> tuple[Floats, Floats, Floats]:
        """Tangential forces [N], normal loads [N] and tangent stiffnesses [N/m]."""
        nodes, shape = self.nodes, self.places.shape
        if self._profile is None:
            force, load, stiffness = self._trace.values()
        else:
            force, load, stiffness = (np.empty(shape) for _ in range(3))
            kernels.active.field_cycle(
                self.places, self.steps, nodes.rests, shape[1], force, load, stiffness,
                *self._profile.arguments,
            )  # fmt: skip
        force *= nodes.weights[:, None]
        load *= nodes.scales[:, None]
        stiffness *= (nodes.weights / nodes.slips)[:, None]
        return force, load, stiffness

    def slopes(
        self, by_displacement: Floats, by_separation: Floats | None = None
    ) -> tuple[Floats, Floats]:
        """Derivatives of forces and loads [N a unit], (nodes, samples, directions).

        Along each direction, (nodes or 1, samples, directions), displacements change, and
        separations where they are given.
        """
        nodes, samples = self.places.shape
        count = by_displacement.shape[2]
        by_step = np.zeros((1, samples, 0)) if by_separation is None else by_separation
        steps = by_step.shape[2]
        force, load = np.empty((nodes, samples, count + steps)), np.empty((nodes, samples, steps))
        self._derive(
            by_displacement, by_step, _NOTHING, _NOTHING, force, _NOTHING, load
        )  # fmt: skip
        force, load = self._scaled(force, count, load)
        if not steps:
            return force, np.zeros_like(force)
        return force[:, :, :count] + force[:, :, count:], load

    def spectra(
        self, by_displacement: Floats, by_separation: Floats, analysis: Floats
    ) -> tuple[Floats, Floats, Floats, Floats]:
        """Fourier coefficients of forces and loads [N], and the derivatives of both.

        ``analysis``, (samples, coefficients), makes coefficients of samples. Derivatives, of the
        shape (nodes, coefficients, directions), have the directions of the displacements first,
        then those of the separations, by which alone loads change.
        """
        size, count = self.nodes.size, analysis.shape[1]
        directions = by_displacement.shape[2] + by_separation.shape[2]
        force, load = np.empty((size, count)), np.empty((size, count))
        by_force = np.empty((size, count, directions))
        by_load = np.empty((size, count, by_separation.shape[2]))
        self._derive(by_displacement, by_separation, analysis, force, by_force, load, by_load)
        force *= self.nodes.weights[:, None]
        load *= self.nodes.scales[:, None]
        return force, load, *self._scaled(by_force, by_displacement.shape[2], by_load)

    def _scaled(self, force: Floats, places: int, load: Floats) -> tuple[Floats, Floats]:
        nodes = self.nodes
        force[:, :, :places] *= (nodes.weights / nodes.slips)[:, None, None]
        force[:, :, places:] *= nodes.weights[:, None, None]
        load *= nodes.scales[:, None, None]
        return force, load

    def _derive(
        self, by_place: Floats, by_step: Floats, analysis: Floats, spectrum: Floats,
        jacobian: Floats, load_spectrum: Floats, load_jacobian: Floats,
    ) -> None:  # fmt: skip
        if self._profile is None:
            slopes = self._trace.slopes(by_place, by_step)
            if not analysis.size:
                jacobian[...], load_jacobian[...] = slopes
                return
            value, load, _ = self._trace.values()
            spectrum[...], load_spectrum[...] = value @ analysis, load @ analysis
            jacobian[...], load_jacobian[...] = (analysis.T @ slope for slope in slopes)
            return
        kernels.active.field_slopes(
            self.places, self.steps, self.nodes.rests, self.places.shape[1],
            np.ascontiguousarray(by_place), by_place.shape[2],
            np.ascontiguousarray(by_step), by_step.shape[2], int(len(by_place) > 1),
            analysis, analysis.shape[-1], spectrum, jacobian, load_spectrum, load_jacobian,
            *self._profile.arguments,
        )  # fmt: skip


def from_root(places: Floats, steps: Floats | None) -> Integers:
    """Samples of two passes of each cycle, from its root on; the second pass is settled."""
    samples = places.shape[1]
    root = np.argmax(np.abs(places) if steps is None else steps + np.abs(places), axis=1)
    return np.asarray((root[:, None] + np.arange(2 * samples)) % samples)


class _Trace:
    """Two passes of each cycle: which row a step hangs from is geometry, the law is asked at once.

    All nodes lie one after the other; index -1 is rest.
    """

    def __init__(self, nodes: Nodes, places: Floats, steps: Floats | None) -> None:
        self.curve, self.shape = nodes.curve, places.shape
        self.order = from_root(places, steps)
        at = np.arange(nodes.size)[:, None]
        x = np.ascontiguousarray(places[at, self.order])
        d = np.zeros_like(x) if steps is None else np.ascontiguousarray(steps[at, self.order])
        front, density = np.empty_like(x), np.empty_like(x)
        kind, parent = (np.empty(x.shape, dtype=np.int64) for _ in range(2))
        count = x.shape[1]
        room = np.empty((count, 3)), np.empty(count, dtype=np.int64)
        for i in range(nodes.size):
            kernels.active.trace(d[i], x[i], front[i], density[i], kind[i], parent[i], *room)
        self.parent = np.where(parent < 0, -1, parent + count * at).ravel()
        self.density, self.kind, d = density.ravel(), kind.ravel(), d.ravel()
        self.base = np.repeat(nodes.rests, count) + d
        # Over which D is what the step made it; 0 at rest.
        self.width = np.append(np.maximum(front.ravel() - d, 0.0), 0.0)
        self.stuck = np.append((self.kind == 0) & (self.width[:-1] > 0.0), False)
        # In a row of its parent: how far the front is from where that one began.
        self.gap = np.append(d, 0.0)[self.parent]
        self.same = self.gap == d
        self.gap = np.maximum(front.ravel() - self.gap, 0.0)
        self.old = np.append(self.density, 0.0)[self.parent]
        self.slipped = (self.kind != 0) & (self.parent >= 0)

    @cached_property
    def drops(self) -> Floats:
        """N(d) - N(q) at each step."""
        return self.curve.drop(self.base, self.width[:-1])

    @cached_property
    def loads(self) -> tuple[Floats, Floats, Floats]:
        """N and -N' at the steps, and -N' with which a step ends: at its front, or sticking."""
        load, here = self.curve.load(self.base)
        stuck = self.stuck[:-1]
        there = self.curve.fall(self.base + self.width[:-1])
        there[stuck] = self.drops[stuck] / self.width[:-1][stuck]
        return load, here, there

    def _settled(self, array: Floats) -> Floats:
        """What belongs to the samples of the second pass, in the order of the cycle."""
        nodes, samples = self.shape
        late = array.reshape(nodes, 2 * samples, *array.shape[1:])[:, samples:]
        result = np.empty_like(late)
        result[np.arange(nodes)[:, None], self.order[:, samples:]] = late
        return result

    def values(self) -> tuple[Floats, Floats, Floats]:
        """T/mu, N and d(T/mu)/d(place), (nodes, samples)."""
        value = np.where(self.kind == 2, 0.0, self.density) * self.drops
        cut, at = np.zeros_like(value), np.flatnonzero(self.slipped)
        cut[at] = self.curve.drop(self.base[self.parent[at]], self.gap[at])
        # At a held separation one difference of N is enough, which keeps the digits of a small one.
        at = np.flatnonzero(self.slipped & self.same)
        cut[at] = self.drops[at]
        value -= self.old * cut
        kernels.active.accumulate(self.parent, value, np.zeros(1))
        load, _, there = self.loads
        return self._settled(value), self._settled(load), self._settled(there)

    @cached_property
    def weights(self) -> tuple[Floats, ...]:
        """Of dp and dp_k, dd and dd_k at each sample, and of dD_k."""
        _, here, there = self.loads
        stuck, before = self.stuck[:-1], np.append(here, 0.0)[self.parent]
        # What sticks: D [N'(d) dd - N'(d_k) dd_k] + drop dD with D = (p - p_k)/(d_k - d).
        sign = np.where(self.kind == 2, 0.0, self.density)
        by_old = np.where(stuck, sign, self.old) * (before - there)
        bend = np.zeros(here.size)
        # Rows that stuck, and that a front has run into since.
        at = np.flatnonzero(~stuck & self.stuck[self.parent])
        if at.size:
            base = self.base[self.parent[at]]
            bend[at] = -2.0 * self.curve.excess("excess_slope", base, self.gap[at])
        return there, -sign * (here - there), by_old, bend

    def slopes(self, by_place: Floats, by_step: Floats) -> tuple[Floats, Floats]:
        """Derivatives of T/mu and N along directions, (nodes, samples, directions)."""
        there, by_rise, by_old, bend = self.weights
        parent, places, steps = self.parent, by_place.shape[2], by_step.shape[2]
        rest = np.zeros((1, places + steps))

        def along(directions: Floats, before: int, after: int) -> Floats:
            """Directions of all samples, nothing for those of the other kind and at rest."""
            at = np.arange(len(directions))[:, None]
            rows = directions[at, self.order].reshape(self.base.size, directions.shape[2])
            return np.vstack((np.pad(rows, ((0, 0), (before, after))), rest))

        move, rise = along(by_place, 0, steps), along(by_step, places, 0)
        total = there[:, None] * (move[:-1] - move[parent])
        total += by_rise[:, None] * rise[:-1] + by_old[:, None] * rise[parent]
        late = np.flatnonzero(bend)
        if late.size:
            k = parent[late]
            j = parent[k]  # before the row that stuck
            change = move[k] - move[j] - self.density[k, None] * (rise[j] - rise[k])
            total[late] += bend[late, None] * change / self.width[k, None]
        kernels.active.accumulate(parent, total, np.zeros(places + steps))
        _, here, _ = self.loads
        return self._settled(total), self._settled(-here[:, None] * rise[:-1, places:])
