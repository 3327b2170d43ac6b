"""Friction law of free form: a density of sliders, by a convex fit to mean cycles of records."""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip.identification.loads import backbone_of, carried, shift_between, stiffness_of
from microslip.identification.nonnegative import Cone, cone_of, minimum
from microslip.identification.rows import DesignRows

THRESHOLDS = 110
"""Number of thresholds of the first grid, which are geometrically spaced."""
_MOST_THRESHOLDS = 240
"""Number of thresholds above which some without stiffness are left out."""
_FINEST = 150.0
"""Smallest amplitude over the finest threshold."""
_REFINEMENTS, _BETWEEN, _VISIBLE, _ADDED = 2, 3, 1.0, 8
"""Number of refinements, thresholds per gap, error over noise, and thresholds beyond the others."""
_OF_LOWER, _APART, _REGRIDS = 0.6, 0.6, 2
"""Number of thresholds for each lower load over THRESHOLDS, smallest spacing over that of the grid,
and most times that thresholds are placed again while the shifts change."""
NEVER = 1e3
"""Threshold of the slider that never slips, over the largest amplitude."""
_FRICTION_STEP = 0.01
"""Relative step of differences by the friction coefficient."""
_LEAST_FRICTION = 0.9
"""Smallest friction coefficient, relative to the largest ratio of force to load.

Less than 1, since the load may be above its mean where the force is largest.
"""
_SHIFT_STEP, _SHIFT_ROUNDS, _ROUGH, _STILL = 0.02, 8, 0.02, 0.1
"""Finite-difference step of a shift, over the largest amplitude; largest number of iterations of
the shifts; changes of the sum of squares at which they end, on rough grids relative to the sum."""


@dataclass(eq=False)
class FreeForm:
    """Density of sliders (elastic-plastic elements): stiffnesses k_i at thresholds y_i.

    A threshold is the displacement [m] at which a slider yields, at the reference load: the highest
    normal load, or the highest one within a cycle if the load varies. At a lower load all are less
    by one length: the threshold is max(y_i + s, 0), with the shift s <= 0 [m] of that load. The
    backbone B(u) = sum_i k_i min(u, y_i) is the first-loading force [N]. With the friction
    coefficient mu, N_reference the reference load and N a lower load, B(-s) = mu (N_reference - N).
    """

    rows: Sequence[DesignRows]
    loads: Sequence[float | None]
    """Distinct normal loads [N], decreasing."""
    follow: bool = True
    """Whether to follow loads that vary within the cycle; otherwise their means are used."""
    y: Floats = field(init=False)
    """Thresholds [m], increasing; the last one is never reached."""
    shifts: Floats = field(init=False)
    """Shift of the thresholds at each load [m], zero at the first."""

    def __post_init__(self) -> None:
        self.largest = max(rows.amplitude for rows in self.rows)
        self.smallest = min(rows.amplitude for rows in self.rows)
        error = np.median([rows.displacement_error for rows in self.rows])
        finest = min(max(2.0 * float(error), self.smallest / _FINEST), 0.2 * self.smallest)
        self.finest = finest
        grid = np.geomspace(finest, self.largest, THRESHOLDS)
        self.y = np.append(grid, NEVER * self.largest)
        levels = sorted({rows.load for rows in self.rows})
        self.level = {load: number for number, load in enumerate(levels)}
        self.shifts = np.zeros(len(self.loads))
        self.k = np.zeros(self.y.size)
        self.friction: float | None = None
        self.is_exact = False
        self.reference: float | None = self.loads[0]
        self._assemble()
        self.separate: list[FreeForm] = []
        if len(self.loads) > 1:
            self._search_shifts()
        if self.follow and any(rows.loads is not None for rows in self.rows):
            self._follow_loads()
        if self.extra:
            for _ in range(_REGRIDS):
                before = self.shifts
                self._place_thresholds()
                self._iterate_shifts(_ROUGH)
                if np.all(np.abs(self.shifts - before) < self.finest):
                    break
        for _ in range(_REFINEMENTS):
            self._solve()
            if self.extra:
                self._thin()
            for rows in self.rows:
                rows.weigh(self.y + self.shifts[self.level[rows.load]], self.k)
            self._refine()
            self._assemble()
        self._solve()
        self._thin()
        if self.extra:
            self._iterate_shifts()
        if self.friction is not None:
            self._correct()

    # -- the convex problem -----------------------------------------------------------------------

    def _assemble(self) -> None:
        count = self.y.size
        blocks = []
        used = np.flatnonzero(self.k)
        if self.friction is not None:
            self.shifts = np.array([self.shift_at(load) for load in self.loads])
            self.fall = self._fall()
        for rows in self.rows:
            level = self.level[rows.load]
            shift = float(self.shifts[level])
            by_extra = np.zeros((rows.weight.size, self.extra))
            by_path = np.zeros((rows.weight.size, count))
            if self.friction is not None and rows.loads is not None:
                path = self.path(rows, self.friction)
                columns = rows.varying_columns(self.y, *path)
                if self.is_exact:
                    by_path = self._by_path(rows, path, columns @ self.k)
                step = _FRICTION_STEP * self.friction
                more, less = (
                    rows.varying_columns(self.carried(self.y[used], mu), *self.path(rows, mu))
                    @ self.k[used]
                    for mu in (self.friction + step, self.friction - step)
                )
                by_extra[:, 0] = (more - less) / (2.0 * step)
            else:
                columns = rows.columns(self.y + shift)
                gradient = self.shift_gradient(level)
                if gradient.any() and used.size:
                    step = _SHIFT_STEP * self.largest
                    y, k = self.y[used] + shift, self.k[used]
                    slope = (rows.columns(y + step) - rows.columns(y - step)) @ k / (2.0 * step)
                    by_extra[:] = np.outer(slope, gradient)
                    if self.is_exact:
                        by_path = np.outer(slope, self.shift_by_stiffness(self.loads[level]))
            force = rows.folded.force + by_path @ self.k
            whole = np.hstack((columns + by_path, by_extra, force[:, None]))
            blocks.append(rows.whitened(whole))
        whole = np.vstack(blocks)
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
        g = minimum(self.cone, h, np.append(self.k > 0.0, np.zeros(self.extra, dtype=bool)))
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

    def _refine(self) -> None:
        """Insert thresholds between sliders, and below the first one, where they affect the fit.

        Thresholds a distance D apart cause an error of up to k D/4 [N], which the noise should
        exceed.
        """
        y, k = self.y[:-1], self.k[:-1]
        noise = min(float((1.0 / rows.weight[rows.weight > 0.0]).mean()) for rows in self.rows)
        wide = (k[1:] + k[:-1]) * np.diff(y) > _VISIBLE * noise
        below = y[0] / 2.0 ** np.arange(5 * int(k[0] * y[0] > noise), 0, -1)
        if not wide.any() and not below.size:
            return
        parts = np.arange(1, _BETWEEN + 1) / (_BETWEEN + 1)
        new = y[:-1][wide, None] + np.diff(y)[wide, None] * parts
        grid = np.union1d(y, np.append(below, new))
        spread = np.zeros(grid.size + 1)
        spread[np.searchsorted(grid, y)] = k
        spread[-1] = self.k[-1]
        self.y, self.k = np.append(grid, self.y[-1]), spread

    def _thin(self) -> None:
        """Remove most thresholds without stiffness if there are many; the fit is unchanged."""
        used = self.k[:-1] > 0.0
        kept = used.copy()
        kept[1:] |= used[:-1]
        kept[:-1] |= used[1:]
        others = np.flatnonzero(~kept)
        room = max(_MOST_THRESHOLDS - int(kept.sum()), THRESHOLDS // 2)
        if others.size <= room:
            return
        kept[others[:: others.size // -room]] = True  # from the last, which ends the range
        kept = np.append(kept, True)
        self.y, self.k = self.y[kept], self.k[kept]
        kept = np.append(kept, np.ones(self.extra, dtype=bool))
        self.g, self.h, self.scale = (one[kept] for one in (self.g, self.h, self.scale))
        self.free = self.free[kept]
        self.design = self.design[:, kept]
        self.cone = Cone(self.cone.gram[np.ix_(kept, kept)], self.free)

    def _search_shifts(self) -> None:
        """Find initial shifts of the lower loads from the backbones of separate fits."""
        alone = [
            FreeForm(
                [rows for rows in self.rows if rows.load == load], [self.loads[load]], follow=False
            )
            for load in range(len(self.loads))
        ]
        self.separate = alone
        self.shifts[1:] = [shift_between(alone[0], low) for low in alone[1:]]
        for rows in self.rows:
            rows.weigh(alone[rows.load].y, alone[rows.load].k)
        self.y, self.k = alone[0].y.copy(), alone[0].k.copy()

    def _iterate_shifts(self, share: float = 0.0) -> None:
        """Fit shifts, or the friction, until a step changes the sum of squares little.

        "Little" is _STILL, or ``share`` times the sum of squares if that is more.
        """
        last, damping = np.zeros(self.extra), np.ones(self.extra)
        for _ in range(_SHIFT_ROUNDS):
            self._assemble()
            self._solve()
            gain = float(np.sum(damping * self.g[self.y.size :] ** 2))
            if gain < max(_STILL, share * self.chi_squared):
                return
            limit = 0.2 * np.maximum(-self.shifts[1:], 0.05 * self.largest)
            if self.friction is not None:
                limit = np.array([0.2 * self.friction])
            step = np.clip(self.moved, -limit, limit)
            # Smaller steps where they go to and fro between two sets of sliders.
            turns = (step * last < 0.0) & (abs(step) > 0.5 * abs(last))
            damping = np.where(turns, 0.5 * damping, 1.0)
            last = step
            if self.friction is not None:
                friction = max(self.friction + float(damping[0] * step[0]), self._least_friction)
                if friction == self.friction:
                    break
                self.y[:-1] = self.carried(self.y[:-1], friction)
                self.friction = friction
            else:
                self.shifts = np.append(0.0, np.minimum(self.shifts[1:] + damping * step, 0.0))
        self._assemble()
        self._solve()

    # -- loads that vary within the cycle ---------------------------------------------------------

    @property
    def extra(self) -> int:
        """Number of fitted shifts, one per lower load; 1 (for mu) if the load varies in a cycle."""
        return 1 if self.friction is not None else len(self.loads) - 1

    def path(self, rows: DesignRows, friction: float) -> tuple[Floats, Floats]:
        """Return the shift s [m] at each node and midway from the preceding node to it."""
        assert rows.loads is not None
        return self._shifts_at(rows.loads, friction), self._shifts_at(rows.middle_loads, friction)

    def _shifts_at(self, loads: Any, friction: float) -> Floats:
        """Return the solution s [m] of B(-s) = mu (N_reference - N) for loads N [N]."""
        u = np.append(0.0, self.y)
        force = backbone_of(self.y, self.k, u)
        return np.asarray(-np.interp(friction * ((self.reference or 0.0) - loads), force, u))

    def shift_at(self, load: float | None, friction: float | None = None) -> float:
        """Return the shift [m] of the thresholds from the reference load to a load [N]."""
        friction = self.friction if friction is None else friction
        if friction is None or load is None or self.reference is None:
            return 0.0
        return float(self._shifts_at(load, friction))

    def _fall(self, friction: float | None = None) -> float:
        """Return how much thresholds decrease from the reference to the highest mean load [m]."""
        return -self.shift_at(self.loads[0], friction)

    def shift_by_stiffness(self, load: float | None) -> Floats:
        """Return the derivatives of the shift at a load with respect to each k_i [m^2/N].

        Differentiating B(-s) = mu (N_reference - N) gives ds/dk_i = min(-s, y_i)/B'(-s). The value
        at the highest mean load, which is zero unless the load varies within a cycle, is
        subtracted, since the thresholds at that load stay fixed.
        """
        if self.friction is None:
            return np.zeros(self.y.size)
        here, top = (
            np.minimum(fall, self.y) / max(stiffness_of(self.y, self.k, fall), 1e-300)
            for fall in (-self.shift_at(load), self._fall())
        )
        return np.asarray((here - top) * (self.y >= 2.0 * self._fall()))

    def _by_path(self, rows: DesignRows, path: tuple[Floats, Floats], force: Floats) -> Floats:
        """Return derivatives of the force by the stiffnesses k_i through s, (bins, thresholds) [m].

        For a shift that varies within the cycle, min(-s, y_i) in ds/dk_i = min(-s, y_i)/B'(-s) is
        approximated by alpha_i (-s) + beta_i, the line through its values at both ends of the range
        of -s. The value at the highest mean load is subtracted. The result is set to 0 for y_i < 2
        _fall(), as in :meth:`shift_by_stiffness`.
        """
        y, top = self.y, self._fall()
        low, high = -float(path[0].max()), -float(path[0].min())
        alpha = np.clip((y - low) / max(high - low, 1e-300), 0.0, 1.0)
        beta = np.where(y <= low, y, low * (1.0 - alpha))
        stiff = [np.maximum(stiffness_of(y, self.k, -s), 1e-300) for s in path]
        at_top = max(float(stiffness_of(y, self.k, top)), 1e-300)
        used = np.flatnonzero(self.k)
        change = np.zeros((force.size, y.size))
        for weights, ways in (
            (alpha, [-s / b for s, b in zip(path, stiff, strict=True)]),
            (beta, [1.0 / b for b in stiff]),
            (-np.minimum(top, y) / at_top, [np.ones(s.size) for s in path]),
        ):
            size = float(np.abs(ways[0]).max())
            if not size > 0.0 or not weights.any():
                continue
            step = _FRICTION_STEP * high / size
            moved = (s + step * way for s, way in zip(path, ways, strict=True))
            other = rows.varying_columns(y[used], *moved) @ self.k[used]
            change += np.outer((other - force) / step, weights * (y >= 2.0 * top))
        return change

    def _correct(self) -> None:
        """Improve the fit by a Newton step that includes the derivatives of the shifts s [m]."""
        self.is_exact = True
        self._assemble()
        before = self._fall()
        self._solve()
        self.y[:-1] = carried(self.y[:-1], before, self._fall())
        if len(self.loads) > 1:  # at one load only its quotient by the stiffness shows
            friction = max((self.friction or 0.0) + self.moved[0], self._least_friction)
            self.y[:-1] = self.carried(self.y[:-1], friction)
            self.friction = float(friction)
        self._assemble()
        k = self.k
        self._solve()
        for level, load in enumerate(self.loads):
            self.shifts[level] += self.shift_gradient(level) @ self.moved
            self.shifts[level] += self.shift_by_stiffness(load) @ (self.k - k)

    def friction_gradient(self, load: float | None) -> float:
        """Return d(shift)/d(mu) [m] of the shift from the highest mean load to ``load`` [N]."""
        if self.friction is None:
            return 0.0
        step = _FRICTION_STEP * self.friction
        more, less = (
            self.shift_at(load, mu) - self.shift_at(self.loads[0], mu)
            for mu in (self.friction + step, self.friction - step)
        )
        return (more - less) / (2.0 * step)

    def carried(self, y: Floats, friction: float) -> Floats:
        """Return the thresholds at the reference load [m] after mu has changed to ``friction``.

        ``y`` [m] are those at the present mu. Thresholds at the highest mean load stay fixed.
        """
        return carried(y, self._fall(), self._fall(friction))

    def about(self, moved: Floats, k: Floats) -> FreeForm:
        """Return the fit about stiffnesses [N/m] and changes of the shifts or friction of a law."""
        other = copy(self)
        other.y, other.k = self.y.copy(), k.copy()
        if self.friction is None:
            other.shifts = np.append(0.0, np.minimum(self.shifts[1:] + moved, 0.0))
            end = max(rows.amplitude - other.shifts[self.level[rows.load]] for rows in self.rows)
            if end > self.y[-2]:  # the law is straight beyond the last threshold
                other.y = np.insert(self.y, -1, np.linspace(self.y[-2], end, _ADDED + 1)[1:])
                other.k = np.insert(k, -1, np.zeros(_ADDED))
        else:
            other.friction = self.friction + float(moved[0])
            for _ in range(3):  # the fall depends on the thresholds, which move with it
                other.y[:-1] = carried(self.y[:-1], self.fall, other._fall())
        other._assemble()
        other._solve()
        return other

    def shift_gradient(self, level: int) -> Floats:
        """Return the derivatives of the shift at load number ``level``.

        They are with respect to mu [m] if mu is fitted, or else to all fitted shifts [-].
        """
        gradient = np.zeros(self.extra)
        if self.friction is not None:
            gradient[0] = self.friction_gradient(self.loads[level])
        elif level:
            gradient[level - 1] = 1.0
        return gradient

    def _follow_loads(self) -> None:
        """Refer thresholds to the largest load in any cycle, and fit mu, not a shift per load."""
        high = self.loads[0]
        assert high is not None
        top = max(
            float(rows.loads.max()) if rows.loads is not None else (rows.folded.normal_load or 0.0)
            for rows in self.rows
        )
        if len(self.loads) == 1:
            self._solve()
        force = float(backbone_of(self.y, self.k, np.array([self.largest]))[0])
        self.friction = force / high  # at least, where there is no gross slip
        if len(self.loads) > 1:
            low = self.loads[-1]
            assert low is not None
            fall = float(self.backbone(-self.shifts[-1:])[0])
            self.friction = max(self.friction, fall / (high - low))
        self._least_friction = _LEAST_FRICTION * self.friction
        self.reference = top
        further = self.friction * (top - high) / float(self.k.sum())
        self.y = self.y + further
        self.shifts = self.shifts - further

    def force_of(self, rows: DesignRows, x: Floats | None = None) -> Floats:
        """Return the force of the law in the bins of a record [N], without a constant offset.

        ``x`` holds stiffnesses [N/m] and changes of the fitted shifts, by default those of the fit.
        """
        x = np.append(self.k, np.zeros(self.extra)) if x is None else x
        k, moved = x[: self.y.size], x[self.y.size :]
        used = np.flatnonzero(k)
        if self.friction is not None and rows.loads is not None:
            friction = self.friction + float(moved[0])
            path = self.path(rows, friction)
            return rows.varying_columns(self.carried(self.y[used], friction), *path) @ k[used]
        level = self.level[rows.load]
        shift = self.shifts[level] + float(self.shift_gradient(level) @ moved)
        return rows.columns(self.y[used] + shift) @ k[used]

    def _place_thresholds(self) -> None:
        """Place thresholds y_i such that at each load y_i + s is spaced as finely as loops resolve.

        The stiffness of each old threshold is distributed to its two neighbours in the new grid.
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
        kept[-1] = y[-1]  # laws of the second step are straight beyond the last threshold
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
        """Return the thresholds [m] at the load of this index, none below zero."""
        return np.asarray(np.maximum(self.y + self.shifts[load], 0.0))

    def backbone(self, u: Floats, load: int = 0) -> Floats:
        """Return the first-loading force [N] at displacements u [m], at the load of an index."""
        return backbone_of(self.thresholds(load), self.k, np.asarray(u))

    @property
    def freedom(self) -> int:
        """Number of forces minus the number of fitted coefficients."""
        return max(self.measured.size - len(self.rows) - self.used, 1)

    @property
    def used(self) -> int:
        """Number of combinations of stiffnesses that the noisy data determine independently."""
        used = np.flatnonzero(self.g)
        # Columns that are nearly equal count as the directions that noise can tell.
        part = self.cone.gram[np.ix_(used, used)]
        told = np.linalg.eigvalsh(part) * float(np.max(self.g, initial=0.0)) ** 2 > 1.0
        return int(np.count_nonzero(told))
