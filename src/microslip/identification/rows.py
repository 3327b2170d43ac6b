"""Design matrix of one folded record: deflections of elastic-plastic elements.

Rows are the phase bins of the record, columns the yield thresholds of the elements. The branches of
the mean cycle follow by Masing's rules from the displacement alone. Nodes are those of
:class:`Cycle`: samples or ends of phase bins, and turning points of the displacement. They divide
the bins into pieces. The nuisance parameters, eliminated in :meth:`DesignRows.whitened`, are the
offset of the force and the errors of the displacement, the drift removal and the quantisation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from microslip._core import kernels
from microslip._core.checks import Floats
from microslip.friction.harmonics import bracketed_roots
from microslip.friction.memory import Memory
from microslip.identification.loads import stiffness_of
from microslip.laboratory.folding import Folded, load_basis

_FLOOR = 1e-5
"""Noise of a force over its range below which the threshold grid is the larger error."""

_SMALL = 0.02  # of the noise: nuisance parameters of smaller effect are not eliminated
_COINCIDENT = 1e-7  # rad
_TANGENT = 1e-3
"""Distance from a turn [rad] within which the displacement does not cross the level of the turn."""
_AT_ONCE = 64
"""Thresholds whose columns are computed together: larger temporary arrays are slower."""


class Cycle(NamedTuple):
    """Branches of a mean cycle: its nodes in temporal order, from the largest displacement on.

    Node i has the force sign[i] B(half[i]) plus that of node parent[i], at which its branch starts;
    B is the backbone, half[i] half the distance from the start of the branch [m], and sign[i] 2 or
    -2. The largest displacement has parent -1, its own value as half[i], and sign 1.
    """

    half: Floats
    sign: Floats
    parent: NDArray[np.int64]
    basis: Floats
    """Terms of the displacement (rows) at each node."""
    phase: Floats
    """Phase of each node [rad]."""
    first: NDArray[np.int64]
    """Index of the first node of each bin."""
    begin: NDArray[np.int64]
    """Start nodes of the pieces of the bins; empty if the bins are points."""
    end: NDArray[np.int64]
    """End nodes of the pieces of the bins."""
    bin: NDArray[np.int64]
    """Bin of each piece."""
    share: Floats
    """Weight of each piece in its bin [-]."""


def _cycle_of(folded: Folded) -> Cycle:
    """Return the branches of a folded record, with nodes at bins, corners and turning points.

    The nodes of a bin are its samples, if the fold has kept their phases (``folded.samples``).
    Otherwise they are two: the mean phase of the bin minus and plus sqrt(3) times the standard
    deviation of its phases, which are the ends of a bin whose phases are evenly distributed.
    """
    is_wide = bool(np.any(folded.spread > 0.0))
    width = math.sqrt(3.0) * folded.spread
    low, high = folded.phase - width, folded.phase + width
    corners = low[0] + np.mod(folded.motion.corners - low[0], 2.0 * math.pi)
    sampled = is_wide and folded.samples.size > 0
    if sampled:
        nodes = np.append(np.mod(folded.samples[0] - low[0], 2.0 * math.pi) + low[0], corners)
    else:
        nodes = np.concatenate((low, high, corners) if is_wide else (low, corners))
    turns = low[0] + np.mod(_turning_points(folded) - low[0], 2.0 * math.pi)
    # A turning point at a node is not added: it would make a loop of the size of rounding errors.
    away = np.abs((turns[:, None] - nodes + math.pi) % (2.0 * math.pi) - math.pi)
    closings = _closings(folded, turns) if is_wide and not sampled and turns.size > 2 else turns[:0]
    phase = np.concatenate((nodes, turns[away.min(axis=1) > _COINCIDENT], closings))
    phase = low[0] + np.mod(phase - low[0], 2.0 * math.pi)
    order = np.argsort(phase, kind="stable")
    phase = phase[order]
    basis = folded.motion.basis(phase)
    x = basis @ folded.motion.coefficients
    x -= 0.5 * (float(x.min()) + float(x.max()))
    root = int(np.argmax(x))
    place = np.empty(order.size, dtype=np.int64)
    place[order] = (np.arange(order.size) - root) % order.size
    x = np.ascontiguousarray(np.roll(x, -root))
    phase = np.roll(phase, -root)
    tree = Memory().tree(x)
    count = folded.phase.size
    first = place[:count]
    second = place[count : 2 * count] if is_wide else first
    pieces = [np.zeros(0, dtype=np.int64)] * 3
    share = np.zeros(0)
    if sampled:
        first = place[: folded.samples.shape[1]]
        bins = folded.samples[1].astype(np.int64)
        pieces, share = [first, first, bins], 1.0 / np.bincount(bins)[bins]
    elif is_wide:
        size = order.size
        number = (second - first) % size
        bins = np.repeat(np.arange(count), number)
        along = np.arange(bins.size) - np.repeat(np.cumsum(number) - number, number)
        begin = (first[bins] + along) % size
        end = (begin + 1) % size
        length = np.mod(phase[end] - phase[begin], 2.0 * math.pi)
        whole = np.bincount(bins, length, minlength=count)
        share = length / np.where(whole > 0.0, whole, 1.0)[bins]
        keep = share > 0.0
        pieces, share = [begin[keep], end[keep], bins[keep]], share[keep]
        alone = np.flatnonzero(np.bincount(pieces[2], minlength=count) == 0)
        more = (first[alone], first[alone], alone)
        pieces = [np.append(*both) for both in zip(pieces, more, strict=True)]
        share = np.append(share, np.ones(alone.size))
    return Cycle(
        tree.half,
        tree.sign,
        tree.parent,
        np.ascontiguousarray(np.roll(basis, -root, axis=0).T),
        phase,
        first,
        pieces[0],
        pieces[1],
        pieces[2],
        share,
    )


def _closings(folded: Folded, turns: Floats) -> Floats:
    """Return phases [rad] just before and after the displacement meets that of an inner turn.

    An inner loop closes there, and the stiffness jumps.
    """
    levels = folded.displacement(turns)
    inner = np.abs(levels - 0.5 * (levels.max() + levels.min())) < 0.4999999 * np.ptp(levels)
    grid = np.linspace(0.0, 2.0 * math.pi, max(512, 16 * int(folded.motion.harmonics.max())) + 1)
    above = folded.displacement(grid) > levels[inner][:, None]
    which, at = np.nonzero(above[:, 1:] != above[:, :-1])
    level = levels[inner][which]
    low = bracketed_roots(
        lambda phase: folded.displacement(phase) - level,
        lambda phase: folded.displacement(phase, 1),
        grid[at],
        grid[at + 1],
    )
    away = np.abs((low[:, None] - turns + math.pi) % (2.0 * math.pi) - math.pi)
    low = low[away.min(axis=1) > _TANGENT]
    return np.concatenate((low - 2.0 * _COINCIDENT, low + 2.0 * _COINCIDENT))


def _turning_points(folded: Folded) -> Floats:
    """Return the phases [rad] at which the displacement has a maximum or minimum."""
    size = max(512, 16 * int(folded.motion.harmonics.max()))
    grid = np.linspace(0.0, 2.0 * math.pi, size + 1)
    slope = folded.displacement(grid, 1)
    at = np.flatnonzero((slope[1:] > 0.0) != (slope[:-1] > 0.0))
    return bracketed_roots(
        lambda phase: folded.displacement(phase, 1),
        lambda phase: folded.displacement(phase, 2),
        grid[at],
        grid[at + 1],
    )


@dataclass(eq=False)
class DesignRows:
    """Design matrix of one record: deflections of elastic-plastic elements in its phase bins."""

    folded: Folded
    load: int
    """Index of the normal load among the distinct loads, 0 for the highest."""

    def __post_init__(self) -> None:
        self.cycle: Cycle = _cycle_of(self.folded)
        self.weight = np.sqrt(self.folded.count) / self.noise
        if self.folded.completed.size:
            self.weight[self.folded.completed] = 0.0
        self._eliminate(np.zeros((self.weight.size, 0)))

    @cached_property
    def noise(self) -> float:
        """Standard deviation of force samples [N], at least the error of discrete thresholds."""
        floor = _FLOOR * 0.5 * float(np.ptp(self.folded.force))
        return max(self.folded.force_noise, floor * math.sqrt(float(self.folded.count.mean())))

    @cached_property
    def amplitude(self) -> float:
        """Amplitude of the displacement [m], half of its range."""
        return float(self.cycle.half.max())

    @cached_property
    def displacement_error(self) -> float:
        """Standard error of the displacement of the mean cycle [m], RMS over the cycle."""
        motion = self.folded.motion
        basis = motion.basis(self.folded.phase)
        return math.sqrt(float(np.einsum("ij,jk,ik->i", basis, motion.covariance, basis).mean()))

    def sums(self, rises: Floats) -> Floats:
        """Return the bin means (bins, columns) of quantities summed along the branches.

        The value at a node is its row of ``rises`` (nodes, columns) plus the value at the node
        where its branch starts.
        """
        cycle = self.cycle
        rises = np.ascontiguousarray(rises)
        kernels.compiled.accumulate(cycle.parent, rises, np.zeros(rises.shape[1]))
        return np.asarray(0.5 * (self._nodes_of(cycle.begin) + self._nodes_of(cycle.end)) @ rises)

    def _nodes_of(self, node: NDArray[np.int64], only: Any = slice(None)) -> csr_array:
        """Return the matrix (bins, nodes) of means over pieces of each bin at ``node``.

        ``only`` selects the pieces that count; a bin that is a point is its first node.
        """
        cycle = self.cycle
        shape = self.weight.size, cycle.half.size
        if not cycle.bin.size:
            return csr_array((np.ones(shape[0]), (np.arange(shape[0]), cycle.first)), shape=shape)
        return csr_array((cycle.share[only], (cycle.bin[only], node[only])), shape=shape)

    @cached_property
    def _of_values(self) -> csr_array:
        """Matrix that takes the bin means of the values at the nodes of pieces that are points."""
        return self._nodes_of(self.cycle.end, self.cycle.begin == self.cycle.end)

    @cached_property
    def _of_means(self) -> csr_array:
        """Matrix that takes the bin means of the means over the steps to the nodes."""
        return self._nodes_of(self.cycle.end, self.cycle.begin != self.cycle.end)

    def columns(self, y: Floats) -> Floats:
        """Return the deflection [m] of an elastic-plastic element per threshold (bins, thresholds).

        The deflection is averaged over the phases of the bin, also if the element yields inside it.
        """
        cycle, reach = self.cycle, np.maximum(y, 0.0)
        if cycle.bin.size and not self.folded.samples.size:  # elements yield inside pieces
            still = np.zeros(cycle.half.size)
            return self.varying_columns(reach, still, still)
        columns = np.empty((self.weight.size, y.size))
        for i in range(0, y.size, _AT_ONCE):
            values = np.minimum(cycle.half[:, None], reach[i : i + _AT_ONCE])
            values *= cycle.sign[:, None]
            kernels.compiled.accumulate(cycle.parent, values, np.zeros(values.shape[1]))
            columns[:, i : i + _AT_ONCE] = self._of_values @ values
        return columns

    @cached_property
    def loads(self) -> Floats | None:
        """Normal load [N] at each node of the cycle; None if it is constant."""
        if not self.folded.load_terms.size or self.folded.normal_load is None:
            return None
        return self._loads_at(self.cycle.phase)

    @cached_property
    def _steps(self) -> tuple[Floats, Floats, Floats]:
        """Displacement increment [m], curvature [m] and middle phase [rad] of the step to a node.

        The curvature is the mean displacement during the step minus the mean of both its ends.
        """
        phase, coefficients = self.cycle.phase, self.folded.motion.coefficients
        begin = np.roll(phase, 1)
        middle = begin + 0.5 * np.mod(phase - begin, 2.0 * math.pi)
        x, between = self.cycle.basis.T @ coefficients, self.folded.displacement(middle)
        before = np.roll(x, 1)
        return x - before, (2.0 * between - x - before) / 3.0, middle

    @cached_property
    def middle_loads(self) -> Floats:
        """Normal load [N] midway between each node of the cycle and the node before."""
        return self._loads_at(self._steps[2])

    def _loads_at(self, phase: Floats) -> Floats:
        terms = self.folded.load_terms
        return (self.folded.normal_load or 0.0) + load_basis(phase, terms.size) @ terms

    def varying_columns(self, y: Floats, shift: Floats, middle: Floats) -> Floats:
        """Return the deflections [m] of elements with thresholds y + shift (bins, thresholds).

        ``shift`` [m] is the shift of the thresholds at each node, ``middle`` [m] that midway
        between the node and the preceding one.
        """
        move, bend, _ = self._steps
        shift_bend = (2.0 * middle - shift - np.roll(shift, 1)) / 3.0
        has_steps = self.cycle.bin.size > 0 and self._of_means.nnz > 0
        columns = np.empty((self.weight.size, y.size))
        for i in range(0, y.size, _AT_ONCE):
            part = y[i : i + _AT_ONCE]
            values = np.empty((move.size, part.size))
            means = np.empty_like(values) if has_steps else np.empty((0, 0))
            kernels.compiled.stops(
                move, bend, shift, shift_bend, part, self.amplitude, values, means
            )
            columns[:, i : i + _AT_ONCE] = self._of_values @ values
            if has_steps:
                columns[:, i : i + _AT_ONCE] += self._of_means @ means
        return columns

    def by_displacement(self, y: Floats, k: Floats) -> Floats:
        """Return d(force)/d(coefficients of the motion) [N/m], shape (terms, bins)."""
        cycle = self.cycle
        above = np.where(cycle.parent < 0, 0, cycle.parent)
        moves = cycle.basis - cycle.basis[:, above]
        return self.sums((stiffness_of(y, k, cycle.half) * moves).T).T

    def weigh(self, y: Floats, k: Floats) -> None:
        """Set the weights from the noise of the bins and the errors of the displacement."""
        folded = self.folded
        root = np.linalg.cholesky(folded.motion.covariance)
        rows = [root.T @ self.by_displacement(y, k)]
        rows += [np.atleast_2d(part) for part in (folded.drifted, folded.stepped) if part.size]
        self._eliminate((np.vstack(rows) * self.weight).T)

    def _eliminate(self, uncertain: Floats) -> None:
        """Set directions D (bins, directions) and shares s (directions,) of :meth:`whitened`.

        With them a row r of values over their noise (bins,) becomes r - (r D) s D'. That eliminates
        the offset, which is unknown, and the parameters of ``uncertain`` (bins, parameters), whose
        columns are the effects over the noise of one standard error each.
        """
        offset, _ = np.linalg.qr(self.weight[:, None])
        uncertain = uncertain - offset @ (offset.T @ uncertain)
        square, turned = np.linalg.eigh(uncertain.T @ uncertain)
        matters = square > _SMALL**2
        further = (uncertain @ turned[:, matters]) / np.sqrt(square[matters])
        shrink = 1.0 - 1.0 / np.sqrt(1.0 + square[matters])
        self._lost = np.hstack((offset, further)), np.append(1.0, shrink)

    def whitened(self, columns: Floats) -> Floats:
        """Return columns over their noise (bins, columns), with nuisance parameters eliminated.

        Bins without weight are left out.
        """
        directions, share = self._lost
        rows = (columns * self.weight[:, None]).T
        whitened = np.asarray((rows - ((rows @ directions) * share) @ directions.T).T)
        return whitened[self.weight > 0.0] if self.folded.completed.size else whitened
