"""Normal load law given as a table."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, exact, record, show
from microslip._core.errors import InputError
from microslip._core.frozen import Locked, assign, lock
from microslip._core.kernels import Integers
from microslip.contact.base import NormalLaw, aluminium, check_pair
from microslip.contact.materials import MaterialPair
from microslip.contact.spline import Spline, convex_spline, decayed


class _Run(NamedTuple):
    """Part of a spline beyond a separation d; its pieces are given by their distance from d."""

    starts: Floats
    slopes: Floats  # N' at each start, on its right
    curvatures: Floats
    drops: Floats  # N(d) - N there
    rates: Floats  # half the integral of v N'' up to there, a jump there included
    excesses: Floats  # integral of the rates up to there


@dataclass(frozen=True, eq=False)
class TabulatedNormalLaw(Locked, NormalLaw):
    """Table of loads at given separations, interpolated by a decreasing, convex function.

    Parameters
    ----------
    pair : MaterialPair
        The two materials; only their stiffness ratio enters.
    separation : array_like
        Separations d [m], increasing, at least three, one-dimensional.
    load : array_like
        Loads N [N] at the separations, decreasing and convex; the last one must be zero without a
        tail.
    tail : {None, "exponential"}, optional
        Extrapolation beyond the last separation: N and N' are continued by an exponential.

    Notes
    -----
    A quadratic spline with at most one additional knot per interval (Schumaker 1983, DOI
    10.1137/0720057) keeps data monotone and convex; a negative N'' would be a negative density of
    sliders in the parallel Iwan model of the interface. Separations below the first one raise an
    InputError.
    """

    pair: MaterialPair
    separations: ArrayLike
    loads: ArrayLike
    tail: Literal["exponential"] | None = None

    def __init__(
        self,
        pair: MaterialPair,
        separation: ArrayLike,
        load: ArrayLike,
        tail: Literal["exponential"] | None = None,
    ) -> None:
        check_pair(pair)
        if tail is not None and not (isinstance(tail, str) and tail == "exponential"):
            raise InputError(f'tail must be None or "exponential", got {show(tail)}')
        d, n = record("separation", separation, "m"), record("load", load, "N")
        if d.ndim != 1 or d.shape != n.shape or d.size < 3:
            raise InputError(
                "separation and load must be of one length, at least three, "
                f"got {d.size} and {n.size}"
            )
        _check_table(d, n, tail)
        assign(self, pair=pair, separations=lock(d.copy()), loads=lock(n.copy()), tail=tail)

    def __repr__(self) -> str:
        d, n = np.asarray(self.separations), np.asarray(self.loads)
        tail = "" if self.tail is None else f", tail={self.tail!r}"
        return (
            f"TabulatedNormalLaw({d.size} loads from {n[0]:g} at {d[0]:g} "
            f"to {n[-1]:g} at {d[-1]:g}{tail})"
        )

    @cached_property
    def _spline(self) -> Spline:
        d, n = np.asarray(self.separations), np.asarray(self.loads)
        return convex_spline(d, n, self.tail is not None)

    @cached_property
    def _integrals(self) -> Floats:
        """Integral of N from each knot to infinity [N m]."""
        knots, slopes, curvatures, loads = self._spline[:4]
        h = np.diff(knots)
        areas = h * (loads[:-1] + h * (slopes[:-1] / 2.0 + h * curvatures[:-1] / 6.0))
        end = 0.0 if self.tail is None else loads[-1] ** 2 / -slopes[-1]
        return np.append(np.cumsum(areas[::-1])[::-1] + end, end)

    @property
    def _span(self) -> tuple[float, float]:
        knots, slopes, _, loads, *_ = self._spline
        if self.tail is None:
            return float(knots[0]), float(knots[-1])
        return float(knots[0]), float(knots[-1] + 650.0 * loads[-1] / -slopes[-1])

    @property
    def _top(self) -> float:
        return float(self._spline.knots[-1]) if self.tail is None else math.inf

    @property
    def _kinks(self) -> Floats:
        return self._spline.knots

    def _separations(self, value: ArrayLike) -> Floats:
        d, first = super()._separations(value), self._span[0]
        if d.min() < first:
            raise InputError(
                f"`separation` must be at least {exact(first)} m, where the table begins, got "
                f"{exact(d.min())}"
            )
        return d

    def _derivative(self, separation: Floats, order: int) -> Floats:
        # From the right end of a piece every term is positive: no digits are lost near the end.
        knots, slopes, curvatures, loads, _, ends, _ = self._spline
        last = knots.size - 1
        i = np.clip(np.searchsorted(knots, separation, side="right") - 1, 0, last - 1)
        r = knots[i + 1] - np.minimum(separation, knots[last])
        n, slope, curve = loads[i + 1], ends[i], curvatures[i]
        if order == -1:
            inner = self._integrals[i + 1] + r * (n + r * (r * curve / 6.0 - slope / 2.0))
        elif order == 0:
            inner = n + r * (r * curve / 2.0 - slope)
        else:
            inner = slope - r * curve if order == 1 else curve
        past = separation >= knots[last]
        if self.tail is None:
            return np.where(past, 0.0, inner)
        rate = -slopes[-1] / loads[-1]
        beyond = np.where(past, separation - knots[last], 0.0)
        outer = loads[-1] * np.exp(-rate * beyond) * (-rate) ** order
        return np.asarray(np.where(past, -outer if order == -1 else outer, inner))

    def _solve(self, loads: Floats) -> Floats:
        heaviest = float(np.asarray(self.loads)[0])
        if loads.max() > heaviest:
            raise InputError(
                f"`load` must be at most {exact(heaviest)} N, where the table begins, got "
                f"{exact(loads.max())} N"
            )
        knots, _, curvatures, ends_of, _, ends, _ = self._spline
        i = np.clip(np.searchsorted(-ends_of, -loads, side="left"), 1, ends.size) - 1
        # The steps from the right ends of pieces, where the load is less, without cancellation.
        surplus = np.maximum(loads - ends_of[i + 1], 0.0)
        root = np.sqrt(ends[i] ** 2 + 2.0 * curvatures[i] * surplus)
        d = np.maximum(knots[i + 1] - 2.0 * surplus / (root - ends[i]), knots[0])
        if self.tail is not None:
            past = loads < ends_of[-1]
            d[past] = knots[-1] + self._spline.decay_length * np.log(ends_of[-1] / loads[past])
        self._check_fine(d, loads)
        return np.asarray(d)

    # Sums over the pieces from a separation on; every term is positive, none cancels another.

    def _run(self, d: float) -> _Run:
        cached = self.__dict__.get("_last_run")
        if cached is None or cached[0] != d:
            cached = (d, self._make_run(d))
            self.__dict__["_last_run"] = cached  # one assignment: threads see this or another
        run: _Run = cached[1]
        return run

    def _make_run(self, d: float) -> _Run:
        knots, slopes, curvatures, _, jumps, ends, _ = self._spline
        first = max(int(np.searchsorted(knots, d, side="right")) - 1, 0)
        starts = np.maximum(knots[first:] - d, 0.0)
        slope, curve = slopes[first:].copy(), curvatures[first:]
        if first < ends.size:
            slope[0] = self._derivative_at(d, 1)
        if self.tail is None:
            slope[-1] = 0.0  # past the end
        h, v = np.diff(starts), starts[:-1]
        drops = 0.5 * h * (-slope[:-1] - ends[first:])
        rises = 0.5 * curve[:-1] * (v + 0.5 * h) * h + 0.5 * starts[1:] * jumps[first + 1 :]
        rates = np.append(0.0, np.cumsum(rises))
        steps = h * rates[:-1] + 0.5 * curve[:-1] * h * h * (0.5 * v + h / 6.0)
        return _Run(
            starts,
            slope,
            curve,
            np.append(0.0, np.cumsum(drops)),
            rates,
            np.append(0.0, np.cumsum(steps)),
        )

    def _tail_at(self, d: float) -> tuple[float, float]:
        """Return the load [N] at max(d, start of the tail) and the tail's decay length [m]."""
        if self.tail is None:
            return 0.0, 1.0
        knots, length = self._spline.knots, self._spline.decay_length
        load = float(self._spline.loads[-1])
        return load * math.exp(-max(d - float(knots[-1]), 0.0) / length), length

    def _drop(self, d: Any, u: Floats) -> Floats:
        run, k, h = self._locate(d, u)
        inner = run.drops[k] + h * (-run.slopes[k] - 0.5 * run.curvatures[k] * h)
        load, length = self._tail_at(d)
        past = (k == run.starts.size - 1) & (load > 0.0)
        return np.where(past, run.drops[-1] - load * np.expm1(-h / length), inner)

    def _excess(self, d: Any, u: Floats) -> Floats:
        run, k, h = self._locate(d, u)
        result = run.excesses[k] + h * run.rates[k]
        result += 0.5 * run.curvatures[k] * h * h * (0.5 * run.starts[k] + h / 6.0)
        load, length = self._tail_at(d)
        past = np.flatnonzero((k == run.starts.size - 1) & (load > 0.0))
        x = h[past] / length
        result[past] += 0.5 * load * (run.starts[-1] * decayed(x, 0, 1) + length * decayed(x, 1, 1))
        return result

    def _excess_slope(self, d: Any, u: Floats) -> Floats:
        run, k, h = self._locate(d, u)
        result = run.rates[k] + 0.5 * run.curvatures[k] * h * (run.starts[k] + 0.5 * h)
        load, length = self._tail_at(d)
        past = np.flatnonzero((k == run.starts.size - 1) & (load > 0.0))
        x = h[past] / length
        result[past] += 0.5 * load * (run.starts[-1] / length * decayed(x, 0, 0) + decayed(x, 1, 0))
        return result

    def _locate(self, d: float, u: Floats) -> tuple[_Run, Integers, Floats]:
        """Return the spline pieces from d on, and the piece that contains each d + u.

        The third value is the distance of d + u from the start of its piece [m].
        """
        run = self._run(d)
        k = np.searchsorted(run.starts, u, side="right") - 1
        return run, k, u - run.starts[k]

    def __getstate__(self) -> dict[str, Any]:
        return {key: value for key, value in super().__getstate__().items() if key != "_last_run"}

    def _corners(self, d: float) -> tuple[Floats, Floats]:
        knots, jumps = self._spline.knots, self._spline.jumps
        at = (jumps > 0.0) & (knots > d)
        return knots[at] - d, jumps[at]

    def _table_reach(self, d: float) -> float | None:
        return None  # a spline of parabolas is no smooth function

    @classmethod
    def examples(cls) -> tuple[NormalLaw, ...]:
        """Return a parabola that ends at zero, and a coarse exponential with a tail."""
        d = np.linspace(0.0, 1e-6, 11)
        return (
            cls(aluminium(), d, 1e3 * (1.0 - d / 1e-6) ** 2),
            cls(aluminium(), d, 1e3 * np.exp(-d / 3e-7), tail="exponential"),
        )


def _check_table(d: Floats, n: Floats, tail: str | None) -> None:
    steps = np.diff(d)
    if steps.min() <= 0.0:
        i = int(np.argmin(steps))
        raise InputError(
            f"`separation` must increase, got {d[i]:g} then {d[i + 1]:g} at index {i + 1}"
        )
    drops = -np.diff(n)
    if drops.min() <= 0.0:
        i = int(np.argmin(drops))
        raise InputError(f"`load` must decrease, got {n[i]:g} then {n[i + 1]:g} at index {i + 1}")
    if n[-1] < 0.0:
        raise InputError(f"`load` must not be negative, got {n[-1]:g} at the end")
    bends = np.diff(-drops / steps)
    # Points on a straight line are convex, whatever rounding says.
    i = int(np.argmin(bends))
    if bends[i] < -1e-9 * drops[i] / steps[i]:
        raise InputError(
            "`load` must be convex (its slope must decrease: N'' < 0 would be a negative "
            f"density of sliders), got a slope that grows at index {i + 1}, d = {d[i + 1]:g} m"
        )
    if tail is None and n[-1] > 0.0:
        raise InputError(
            f"`load` must end at zero, got {n[-1]:g} N at the last separation; add the point "
            'where contact ends or state `tail="exponential"`'
        )
    if tail is not None and n[-1] == 0.0:
        raise InputError("`tail` must be None where the load ends at zero")
