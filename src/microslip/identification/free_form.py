"""Masing law of free form: a density of sliders, by one convex fit to folded cycles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array

from microslip._core import kernels
from microslip._core.checks import Floats
from microslip.identification.branches import Cycle, cycle_of
from microslip.identification.nonnegative import Cone, cone_of, minimum
from microslip.identification.whitening import Metric, metric_of
from microslip.laboratory.folding import Folded, load_basis

THRESHOLDS = 110
"""Thresholds of the first grid, in geometric steps."""
_FINEST = 150.0
"""Smallest amplitude over the finest threshold."""
_FLOOR = 1e-5
"""Noise of a force over its range below which the grid of thresholds counts more."""
_REFINEMENTS, _BETWEEN, _VISIBLE = 2, 3, 1.0
"""Rounds in which thresholds are put beside those that carry stiffness, and how many."""
_OF_LOWER, _APART, _REGRIDS = 0.6, 0.6, 2
"""Share of these for each lower load; least distance of two over that of the grid; and how often
they are put where the shifts have come to."""
NEVER = 1e3
"""Threshold of the slider that never slips, over the largest amplitude."""
_FRICTION_STEP = 0.01
"""Step of the difference by the friction, over it."""
_SHIFT_STEP, _SHIFT_ROUNDS, _ROUGH, _STILL = 0.02, 12, 1e-3, 2e-5
"""Step of the difference by a shift, over the largest amplitude; most steps of the search of the
shifts, and the steps over the largest amplitude at which it ends, in between and at last."""


@dataclass(eq=False)
class Rows:
    """Columns of stop elements of one record, in the bins of its phase."""

    folded: Folded
    load: int
    """Number of its load among the different ones, the highest being 0."""

    def __post_init__(self) -> None:
        self.cycle: Cycle = cycle_of(self.folded, math.sqrt(3.0))
        self.weight = np.sqrt(self.folded.count) / self.noise
        self.metric: Metric = metric_of(self.weight[:, None], np.zeros((self.weight.size, 0)))

    @cached_property
    def noise(self) -> float:
        """Standard deviation of one sample of force [N], not below what the grid resolves."""
        floor = _FLOOR * 0.5 * float(np.ptp(self.folded.force))
        return max(self.folded.force_noise, floor * math.sqrt(float(self.folded.count.mean())))

    @cached_property
    def amplitude(self) -> float:
        """Half the range of the displacement [m]."""
        return float(self.cycle.half.max())

    def sums(self, rises: Floats) -> Floats:
        """Return means over the bins of what accumulates along the branches (places, columns)."""
        cycle = self.cycle
        rises = np.ascontiguousarray(rises)
        kernels.compiled.accumulate(cycle.parent, rises, np.zeros(rises.shape[1]))
        if not cycle.bin.size:
            return np.asarray(rises[cycle.first])
        return self._means(0.5 * (rises[cycle.begin] + rises[cycle.end]))

    def _means(self, pieces: Floats) -> Floats:
        """Return means over the bins of means over their pieces (pieces, columns)."""
        return np.asarray(self._bins @ pieces)

    @cached_property
    def _bins(self) -> csr_array:
        cycle = self.cycle
        shape = self.weight.size, cycle.bin.size
        return csr_array((cycle.share, (cycle.bin, np.arange(cycle.bin.size))), shape=shape)

    @cached_property
    def _bends(self) -> Floats:
        """Mean of the displacement over each piece less the mean of its ends [m]."""
        cycle, folded = self.cycle, self.folded
        begin = cycle.phase[cycle.begin]
        end = begin + np.mod(cycle.phase[cycle.end] - begin, 2.0 * math.pi)
        ends = folded.displacement(np.concatenate((begin, 0.5 * (begin + end), end)))
        first, middle, last = ends.reshape(3, -1)
        return np.asarray((2.0 * middle - first - last) / 3.0)

    def columns(self, y: Floats) -> Floats:
        """Return the deflection [m] of a stop element of each threshold (bins, thresholds).

        A bin has the mean over its phases, exact where a stop element yields inside it.
        """
        cycle = self.cycle
        reach = np.maximum(y, 0.0)
        half, sign = cycle.half[:, None], cycle.sign[:, None]
        values = np.minimum(half, reach) * sign
        kernels.compiled.accumulate(cycle.parent, values, np.zeros(y.size))
        if not cycle.bin.size:
            return np.asarray(values[cycle.first])
        begin, end = cycle.begin, cycle.end
        starts = cycle.parent[end] == begin  # the branch begins where the piece does
        along = (starts | (cycle.parent[begin] == cycle.parent[end])) & (cycle.parent[end] >= 0)
        along &= begin != end
        pieces = 0.5 * (values[begin] + values[end])
        start, stop = begin[along], end[along]
        low = np.where(starts[along], 0.0, cycle.half[start])[:, None]
        high = cycle.half[stop][:, None]
        over = (
            np.maximum(np.maximum(low, high) - reach, 0.0),
            np.maximum(np.minimum(low, high) - reach, 0.0),
        )
        # The mean of min(h, y) over h between two ends is that of h less the excess over y.
        width = np.maximum(np.abs(high - low), 1e-300)
        lost = (over[0] ** 2 - over[1] ** 2) / (2.0 * width)
        lost = np.where(np.abs(high - low) > 1e-9 * high, lost, 0.5 * (over[0] + over[1]))
        mean = 0.5 * (low + high) - lost
        pieces[along] = values[cycle.parent[stop]] + cycle.sign[stop][:, None] * mean
        # The displacement bends inside a piece: what sticks goes with it.
        sticks = 1.0 - np.clip((over[0] - over[1]) / width, 0.0, 1.0)
        pieces[along] += self._bends[along][:, None] * sticks
        return self._means(pieces)

    @cached_property
    def loads(self) -> Floats | None:
        """Normal load [N] at each place of the cycle; None where it does not vary."""
        terms = self.folded.load_terms
        if not terms.size or self.folded.normal_load is None:
            return None
        return self.folded.normal_load + load_basis(self.cycle.phase, terms.size) @ terms

    def varying_columns(self, y: Floats, shift: Floats) -> Floats:
        """Return the columns of thresholds y + shift, with a shift [m] at each place of the cycle.

        A slider whose threshold rises above zero during a step moves only after its entry.
        """
        x = self.cycle.basis.T @ self.folded.coefficients
        limits = y + shift[:, None]
        values = np.empty_like(limits)
        state = np.minimum(np.maximum(limits[0], 0.0), self.amplitude)
        before, size = limits[-1], x.size
        bounds = np.maximum(limits, 0.0)
        enters = (limits > 0.0) & (np.roll(limits, 1, axis=0) <= 0.0)
        any_enters = np.asarray(enters.any(axis=1))
        steps = np.diff(x, prepend=x[-1])
        # From the largest displacement on; the second cycle is the settled one.
        for turn in range(2):
            for i in range(1 if turn == 0 else 0, size):
                if any_enters[i]:
                    before = limits[i - 1]
                    gone = np.where(enters[i], limits[i] / (limits[i] - before), 1.0)
                    state = state + gone * steps[i]
                else:
                    state = state + steps[i]
                np.minimum(state, bounds[i], out=state)
                np.maximum(state, -bounds[i], out=state)
                values[i] = state
        cycle = self.cycle
        if not cycle.bin.size:
            return np.asarray(values[cycle.first])
        return self._means(0.5 * (values[cycle.begin] + values[cycle.end]))

    def stiffness(self, y: Floats, k: Floats) -> Floats:
        """Return the tangent stiffness [N/m] at each place of the cycle."""
        order = np.argsort(y)
        left = np.append(np.cumsum(k[order][::-1])[::-1], 0.0)
        return np.asarray(left[np.searchsorted(y[order], self.cycle.half, side="right")])

    def by_displacement(self, y: Floats, k: Floats) -> Floats:
        """Return the change of the force by each coefficient of the displacement (terms, bins)."""
        cycle = self.cycle
        above = np.where(cycle.parent < 0, 0, cycle.parent)
        moves = cycle.basis - cycle.basis[:, above]
        return self.sums((self.stiffness(y, k) * moves).T).T

    def weigh(self, y: Floats, k: Floats) -> None:
        """Whiten by the noise of the bins and the effect of errors of the displacement."""
        folded = self.folded
        root = np.linalg.cholesky(folded.covariance)
        rows = [root.T @ self.by_displacement(y, k)]
        rows += [np.atleast_2d(part) for part in (folded.drifted, folded.stepped) if part.size]
        uncertain = (np.vstack(rows) * self.weight).T
        self.metric = metric_of(self.weight[:, None], np.asarray(uncertain))

    def whitened(self, columns: Floats) -> Floats:
        """Return weighted columns (bins, columns) with the nuisances eliminated."""
        return self.metric.apply((columns * self.weight[:, None]).T).T


@dataclass(eq=False)
class FreeForm:
    """Density of sliders that fits the records best, at the highest of their loads.

    At a lower load every threshold is less by one shift (section 20 of the theory).
    """

    rows: Sequence[Rows]
    loads: Sequence[float | None]
    """Different normal loads [N], falling."""
    follow: bool = True
    """Whether loads that vary within the cycle are followed; else their means count."""
    y: Floats = field(init=False)
    """Thresholds [m], rising; the last one is never reached."""
    shifts: Floats = field(init=False)
    """Shift of the thresholds at each load [m], zero at the first."""

    def __post_init__(self) -> None:
        self.largest = max(rows.amplitude for rows in self.rows)
        self.smallest = min(rows.amplitude for rows in self.rows)
        told = np.median([math.sqrt(_mean_variance(rows.folded)) for rows in self.rows])
        finest = min(max(2.0 * float(told), self.smallest / _FINEST), 0.2 * self.smallest)
        self.finest = finest
        grid = np.geomspace(finest, self.largest, THRESHOLDS)
        self.y = np.append(grid, NEVER * self.largest)
        levels = sorted({rows.load for rows in self.rows})
        self.level = {load: number for number, load in enumerate(levels)}
        self.shifts = np.zeros(len(self.loads))
        self.k = np.zeros(self.y.size)
        self._columns: dict[int, Floats] = {}
        self.friction: float | None = None
        self.reference: float | None = self.loads[0]
        self._assemble()
        self.separate: list[FreeForm] = []
        if len(self.loads) > 1:
            self._search_shifts()
        if self.follow and any(rows.loads is not None for rows in self.rows):
            self._follow_loads()
        if self.extra:
            for _ in range(_REGRIDS):
                self._put_thresholds()
                self._settle(_ROUGH)
        for _ in range(_REFINEMENTS):
            self._solve()
            self._reweigh()
            self._refine()
            self._assemble()
        self._solve()
        if self.extra:
            self._settle(_STILL)

    # -- the convex problem -----------------------------------------------------------------------

    def _assemble(self) -> None:
        """Assemble Gram matrix and right-hand side of all records."""
        count = self.y.size
        self.blocks: list[Floats] = []
        used = np.flatnonzero(self.k)
        if self.friction is not None:
            self.shifts = np.array([self.shift_at(load)[0] for load in self.loads])
        for rows in self.rows:
            level = self.level[rows.load]
            shift = float(self.shifts[level])
            by_extra = np.zeros((rows.weight.size, self.extra))
            if self.friction is not None and rows.loads is not None:
                columns = rows.varying_columns(self.y, self._path(rows, self.friction))
                step = _FRICTION_STEP * self.friction
                more, less = (
                    rows.varying_columns(self.y[used], self._path(rows, self.friction + way * step))
                    @ self.k[used]
                    for way in (1.0, -1.0)
                )
                by_extra[:, 0] = (more - less) / (2.0 * step)
            else:
                columns = rows.columns(self.y + shift)
                gradient = self.shift_gradient(level)
                if gradient.any() and used.size:
                    step = _SHIFT_STEP * self.largest
                    both = np.concatenate([self.y[used] + shift + way * step for way in (1, -1)])
                    weights = np.concatenate((self.k[used], -self.k[used])) / (2.0 * step)
                    by_extra[:] = np.outer(rows.columns(both) @ weights, gradient)
            self._columns[id(rows)] = columns
            force = rows.folded.force[:, None]
            self.blocks.append(rows.whitened(np.hstack((columns, by_extra, force))))
        whole = np.vstack(self.blocks)
        design, self.measured = whole[:, :-1], whole[:, -1]
        scale = np.sqrt(np.einsum("ij,ij->j", design, design))
        scale[:count][scale[:count] < 1e-9 * scale[:count].max()] = math.inf
        scale[scale == 0.0] = math.inf
        self.scale = scale
        self.design = design / scale
        self.free = np.arange(count + self.extra) >= count
        self.free &= np.isfinite(scale)
        gram = self.design.T @ self.design
        empty = ~np.isfinite(scale)
        gram[empty, empty] = 1.0
        self.cone: Cone = cone_of(gram, self.free)

    def _solve(self) -> None:
        h = self.design.T @ self.measured
        g = minimum(self.cone, h)
        for _ in range(2):
            # Against the rounding of the Gram matrix: the same about the residual of the rows.
            h = self.cone.gram @ g + self.design.T @ (self.measured - self.design @ g)
            g = minimum(self.cone, h, g > 0.0)
        self.h, self.g = h, g
        x = g / self.scale
        self.k = x[: self.y.size]
        self.moved = x[self.y.size :]
        self.residual = self.measured - self.design @ g
        self.chi_squared = float(self.residual @ self.residual)

    def _reweigh(self) -> None:
        for rows in self.rows:
            rows.weigh(self.y + self.shifts[self.level[rows.load]], self.k)

    def _refine(self) -> None:
        """Put thresholds between two that carry stiffness where their distance shows.

        A slider that yields between two thresholds a distance D apart is rendered with an error of
        up to k D/4, which counts where it is not small beside the noise of the bins.
        """
        y, k = self.y[:-1], self.k[:-1]
        noise = min(float((1.0 / rows.weight).mean()) for rows in self.rows)
        wide = (k[1:] + k[:-1]) * np.diff(y) > _VISIBLE * noise
        if not wide.any():
            return
        parts = np.arange(1, _BETWEEN + 1) / (_BETWEEN + 1)
        new = y[:-1][wide, None] + np.diff(y)[wide, None] * parts
        grid = np.union1d(y, new.ravel())
        spread = np.zeros(grid.size + 1)
        spread[np.searchsorted(grid, y)] = k
        spread[-1] = self.k[-1]
        self.y, self.k = np.append(grid, self.y[-1]), spread

    def _search_shifts(self) -> None:
        """Find the shift of each lower load, first from the backbones of separate fits.

        The backbone at a lower load is the tail of that at the highest one,
        B_low(u) = B_high(u* + u) - B_high(u*), at a shift of -u*.
        """
        alone = [
            FreeForm(
                [rows for rows in self.rows if rows.load == load], [self.loads[load]], follow=False
            )
            for load in range(len(self.loads))
        ]
        self.separate = alone
        high = alone[0]
        for load, low in enumerate(alone[1:], 1):
            u = np.linspace(0.0, low.largest, 41)[1:]
            wanted = low.backbone(u)
            starts = np.linspace(0.0, high.largest, 401)
            tail = high.backbone(starts[:, None] + u) - high.backbone(starts)[:, None]
            miss = np.sum((tail - wanted) ** 2, axis=1)
            self.shifts[load] = -float(starts[int(np.argmin(miss))])
        for rows in self.rows:
            rows.weigh(alone[rows.load].y, alone[rows.load].k)
        self.y, self.k = high.y.copy(), high.k.copy()

    def _settle(self, still: float) -> None:
        """Move the shifts, or the friction, by Gauss and Newton's method until they stay."""
        for _ in range(_SHIFT_ROUNDS):
            self._assemble()
            self._solve()
            if self.friction is not None:
                step = np.clip(self.moved[0], -0.2 * self.friction, 0.2 * self.friction)
                self.friction += float(step)
                if abs(step) < still * self.friction:
                    break
                continue
            limit = 0.2 * np.maximum(-self.shifts[1:], 0.05 * self.largest)
            step = np.clip(self.moved, -limit, limit)
            if np.all(np.abs(step) < still * self.largest):
                break
            self.shifts[1:] = np.minimum(self.shifts[1:] + step, 0.0)
        if self.friction is not None:
            self._assemble()
            self._solve()

    # -- loads that vary within the cycle ---------------------------------------------------------

    @property
    def extra(self) -> int:
        """Number of free coefficients beside stiffnesses: shifts, or the friction."""
        return 1 if self.friction is not None else len(self.loads) - 1

    def _corners(self) -> tuple[Floats, Floats]:
        """Return displacements and forces of the corners of first loading at the reference."""
        u = np.append(0.0, self.y)
        return backbone_of(self.y, self.k, u), u

    def _path(self, rows: Rows, friction: float) -> Floats:
        """Return the shift at each place of a record, by B(-s) = mu (N_reference - N)."""
        assert self.reference is not None
        assert rows.loads is not None
        force, u = self._corners()
        return -np.interp(friction * (self.reference - rows.loads), force, u)

    def shift_at(self, load: float | None) -> tuple[float, float]:
        """Return the shift [m] at a load [N] and its derivative by the friction."""
        if self.friction is None or load is None or self.reference is None:
            return 0.0, 0.0
        force, u = self._corners()
        drop = self.reference - load
        step = _FRICTION_STEP * self.friction
        at = (self.friction, self.friction + step, self.friction - step)
        here, more, less = (-float(np.interp(mu * drop, force, u)) for mu in at)
        return here, (more - less) / (2.0 * step)

    def shift_gradient(self, level: int) -> Floats:
        """Return the derivatives of the shift at a load by the free coefficients."""
        gradient = np.zeros(self.extra)
        if self.friction is not None:
            gradient[0] = self.shift_at(self.loads[level])[1]
        elif level:
            gradient[level - 1] = 1.0
        return gradient

    def _follow_loads(self) -> None:
        """Refer the thresholds to the largest load of all, and the shifts to one friction."""
        high = self.loads[0]
        assert high is not None
        top = max(
            float(rows.loads.max()) if rows.loads is not None else (rows.folded.normal_load or 0.0)
            for rows in self.rows
        )
        if len(self.loads) == 1:
            self._solve()
        force = float(backbone_of(self.y, self.k, np.array([self.largest]))[0])
        self.friction = force / high
        if len(self.loads) > 1:
            low = self.loads[-1]
            assert low is not None
            self.friction = float(self.backbone(-self.shifts[-1:])[0]) / (high - low)
        self.reference = top
        further = self.friction * (top - high) / float(self.k.sum())
        self.y = self.y + further
        self.shifts = self.shifts - further

    def force_of(self, rows: Rows) -> Floats:
        """Return the force of the law in the bins of a record [N], without an offset."""
        return self._columns[id(rows)] @ self.k

    def _put_thresholds(self) -> None:
        """Put thresholds as fine about the shift of each load as its loops resolve.

        The stiffnesses go to the two neighbours of each old threshold.
        """
        places, wanted = [], []
        for number, fit in enumerate(self.separate or [self]):
            count = int(THRESHOLDS * (1.0 if number == 0 else _OF_LOWER))
            largest = max(rows.amplitude for rows in fit.rows)
            places.append(np.geomspace(self.finest, largest, count) - self.shifts[number])
            wanted.append(-self.shifts[number])
        start = -float(self.shifts[0])
        if start > 0.0:  # sliders that enter only when the load is above its mean
            places.append(np.linspace(0.1 * start, start, 10))
        y = np.sort(np.concatenate([*places, np.array(wanted)[np.array(wanted) > 0.0]]))
        # As close as the finest grid wants them at each place, and no closer.
        ratio = (self.largest / self.finest) ** (1.0 / THRESHOLDS) - 1.0
        above = np.where(y[:, None] >= np.array(wanted), y[:, None] - np.array(wanted), math.inf)
        room = _APART * np.maximum(ratio * above.min(axis=1), ratio * self.finest)
        kept, last = [], -math.inf
        for place, apart in zip(y, np.where(np.isfinite(room), room, 0.05 * start), strict=True):
            if place - last >= apart and place > 0.0:
                kept.append(place)
                last = place
        grid = np.array(kept)
        self.largest = float(grid[-1])
        old_y, old_k = self.y[:-1], self.k[:-1]
        at = np.clip(np.searchsorted(grid, old_y), 1, grid.size - 1)
        share = np.clip((old_y - grid[at - 1]) / (grid[at] - grid[at - 1]), 0.0, 1.0)
        k = np.zeros(grid.size + 1)
        np.add.at(k, at, share * old_k)
        np.add.at(k, at - 1, (1.0 - share) * old_k)
        k[-1] += self.k[-1]
        self.y, self.k = np.append(grid, NEVER * self.largest), k

    # -- what follows -----------------------------------------------------------------------------

    def thresholds(self, load: int = 0) -> Floats:
        """Return the thresholds [m] at a load, none below zero."""
        return np.asarray(np.maximum(self.y + self.shifts[load], 0.0))

    def backbone(self, u: Floats, load: int = 0) -> Floats:
        """Return the force of first loading [N]."""
        return backbone_of(self.thresholds(load), self.k, np.asarray(u))

    @property
    def freedom(self) -> int:
        """Number of forces less what was fitted."""
        return max(self.measured.size - len(self.rows) - self.used, 1)

    @property
    def used(self) -> int:
        """Number of independent columns that carry stiffness, as far as noise can tell them."""
        used = np.flatnonzero(self.g)
        # Columns that are nearly equal count as the directions that noise can tell.
        part = self.cone.gram[np.ix_(used, used)]
        told = np.linalg.eigvalsh(part) * float(np.max(self.g, initial=0.0)) ** 2 > 1.0
        return int(np.count_nonzero(told))


def _mean_variance(folded: Folded) -> float:
    """Return the mean variance of the displacement [m^2] over the cycle."""
    basis = folded.basis(folded.phase)
    return float(np.einsum("ij,jk,ik->i", basis, folded.covariance, basis).mean())


def backbone_of(y: Floats, k: Floats, u: Floats) -> Floats:
    """Return the sum of k min(u, y) [N] at displacements u of any shape."""
    order = np.argsort(y)
    y, k = y[order], k[order]
    slipped = np.append(0.0, np.cumsum(k * y))
    stuck = np.append(np.cumsum(k[::-1])[::-1], 0.0)
    at = np.searchsorted(y, u, side="right")
    return np.asarray(slipped[at] + u * stuck[at])
