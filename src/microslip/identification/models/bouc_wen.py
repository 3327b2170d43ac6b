"""Bouc's and Wen's model for an identification: settled cycles with exact sensitivities."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip._core.parameters import Parameter, parameters_of
from microslip.errors import InputError
from microslip.friction.bouc_wen import BoucWen
from microslip.identification.models.base import (
    UNKNOWN,
    Branch,
    CycleModel,
    Derived,
    Loads,
    Materials,
    Model,
    Values,
)
from microslip.numerics.quadrature import gauss_legendre

_NODES, _WEIGHTS = gauss_legendre(16)
_FULL = 37.0  # exp(-37) is nothing beside 1
_ROUNDS = 60
_ROUNDING = 1e-12  # of the range of the displacement


@dataclass(frozen=True)
class BoucWenModel(CycleModel):
    """T = alpha k x + (1 - alpha) F_y w with dw/dx = (k/F_y) [1 - |w|^n (gamma + beta sign)].

    Of Wen's constants (1976, DOI 10.1061/JMCEA3.0002106) two say nothing of their own: A is a
    factor of k and alpha, beta + gamma one of F_y. So A = 1 and gamma = 1 - beta here, and F_y is
    the force that w = 1 limits. Along a move dy/ds = f(y) is solved exactly, and so are its
    sensitivities: dy/dp = f(y) [integral of (df/dp)/f^2 from y_0 to y + dy_0/dp / f(y_0) + ds/dp].
    The settled cycle is the fixed point of one period, and its sensitivity that of a fixed point.
    """

    law: BoucWen | None = None

    name = "bouc-wen"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Stiffness, yield force, elastic share, sharpness, beta (which gives energy below 1/2)."""
        metadata = {item.name: item for item in parameters_of(BoucWen)}
        searched = {"alpha": (0.0, 0.99), "n": (1.0, 20.0), "beta": (0.5, 5.0)}
        names = ("stiffness", "yield_force", "alpha", "n", "beta")
        return tuple(replace(metadata[name], search=searched.get(name)) for name in names)

    @property
    def start(self) -> Values | None:
        """Values of the instance it was made of, with A = 1 and beta + gamma = 1."""
        law = self.law
        if law is None:
            return None
        elastic = law.alpha * law.stiffness
        stiffness = elastic + (1.0 - law.alpha) * law.A * law.stiffness
        alpha = elastic / stiffness
        return {
            "stiffness": stiffness,
            "yield_force": law.force_limit / (1.0 - alpha),
            "alpha": alpha,
            "n": law.n,
            "beta": law.beta / (law.beta + law.gamma),
        }

    def guess(self, loops: Sequence[Any], loads: Loads) -> dict[str, float]:
        """First guess of :meth:`BoucWen.guess`."""
        values = BoucWenModel(BoucWen.guess(loops)).start
        assert values is not None
        return self.within(values)

    def cycle(self, x: Floats, values: Values) -> Branch:
        """Forces of the settled cycle, their slope along the motion, and their derivatives."""
        k, limit, alpha, _, _ = (values[name] for name in self.names)
        path, memory, rate, memory_by = self._period(x, values, np.zeros((0, x.size)))
        unit = (1.0 - alpha) * limit
        by = np.empty((5, path.size))
        by[0] = alpha * path + unit * memory_by[0]
        by[1] = (1.0 - alpha) * memory + unit * memory_by[1]
        by[2] = k * path - limit * memory
        by[3:] = unit * memory_by[2:]
        return alpha * k * path + unit * memory, k * (alpha + (1.0 - alpha) * rate), by

    def moved(self, x: Floats, values: Values, moves: Floats) -> Floats:
        """Change of the forces by moves (rows) of the displacement, memory of the way included."""
        k, limit, alpha, _, _ = (values[name] for name in self.names)
        _, _, _, memory_by = self._period(x, values, moves)
        return np.asarray(alpha * k * moves + (1.0 - alpha) * limit * memory_by[4:])

    def _period(
        self, x: Floats, values: Values, moves: Floats
    ) -> tuple[Floats, Floats, Floats, Floats]:
        """Settled cycle: x, w, f(y), and w by k, F_y, n, beta and by the moves (rows) of x."""
        k, limit, _, n, beta = (values[name] for name in self.names)
        law = self.build(values)
        root = int(np.argmax(x))
        path = np.append(np.roll(x, -root), x[root])  # begins and ends at its highest place
        span = float(np.ptp(x))
        if span == 0.0:
            raise InputError(f"`displacement` must move, got {x[0]:g} m throughout")
        turns, ways = _runs(path, _ROUNDING * span)
        ends = [*turns[1:], path.size - 1]
        flow = _Flow(law, n, beta)
        scale = k / limit
        by_scale = np.array([1.0 / k, -1.0 / limit])  # of ln(k/F_y)

        start = law._settled(span * scale)  # right where it turns twice a period
        lengths = np.abs(path[ends] - path[turns]) * scale
        for _ in range(_ROUNDS if len(turns) > 2 else 0):
            w, grown = start, 1.0
            for way, length in zip(ways, lengths, strict=True):
                w, gain = flow.go(way * w, length)
                w, grown = way * w, grown * gain
            # What the start should have been.
            miss, settles = w - start, max(1.0 - grown, 2.0**-53)
            if abs(miss) <= 4e-16 + 1e-15 * settles:
                break
            start = float(np.clip(start + miss / settles, -1.0, 1.0))

        memory, rate, by_start = (np.empty(path.size) for _ in range(3))
        shift = np.roll(moves, -root, axis=1)
        shift = scale * np.hstack((shift, shift[:, :1]))
        by_values = np.empty((4 + len(shift), path.size))
        w, grown, by_start_values = start, 1.0, np.zeros((len(by_values), 1))
        for turn, end, way in zip(turns, ends, ways, strict=True):
            part = slice(turn, end + 1)
            s = np.abs(path[part] - path[turn]) * scale
            y, f, gain, by_shape = flow.move(way * w, s)
            memory[part], rate[part], by_start[part] = way * y, f, f * gain * grown
            by_values[:, part] = f * gain * by_start_values
            by_values[:2, part] += way * f * s * by_scale[:, None]
            by_values[2:4, part] += way * by_shape
            by_values[4:, part] += f * (shift[:, part] - shift[:, [turn]])
            w, grown, by_start_values = (
                float(memory[end]),
                float(by_start[end]),
                by_values[:, [end]],
            )
        # How what it should have been moves with the parameters.
        settles = max(1.0 - grown, 2.0**-53)
        memory_by = by_values + (by_start_values / settles) * by_start

        path, memory, rate, memory_by = (
            np.roll(row[..., :-1], root, axis=-1) for row in (path, memory, rate, memory_by)
        )
        return path, memory, rate, memory_by

    def build(
        self, values: Values, load: float | None = None, given: Materials = UNKNOWN
    ) -> BoucWen:
        """The model itself; the load does not enter."""
        k, limit, alpha, n, beta = (values[name] for name in self.names)
        return BoucWen(k, limit, alpha, 1.0, beta, 1.0 - beta, n)

    def derived(
        self, values: Values, loads: Loads, given: Materials = UNKNOWN
    ) -> tuple[Derived, ...]:
        """The limit (1 - alpha) F_y of the hysteretic force."""
        limit, alpha = values["yield_force"], values["alpha"]
        by = np.array([0.0, 1.0 - alpha, -limit, 0.0, 0.0])
        return (Derived("force_limit", "N", (1.0 - alpha) * limit, by, None),)

    @classmethod
    def examples(cls) -> tuple[tuple[Model, Values], ...]:
        """Smooth and sharp ones, some with stiffness left, some that unload along a curve."""
        laws = (
            BoucWen(5e7, 100.0),
            BoucWen(5e7, 100.0, 0.2, beta=0.9, gamma=0.1, n=2.0),
            BoucWen(1e3, 2e-3, 0.05, beta=0.7, gamma=0.3, n=3.7),
            BoucWen(2e8, 1500.0, 0.6, A=2.0, beta=1.5, gamma=-0.7, n=1.3),
        )
        models = [cls(law) for law in laws]
        return tuple((model, model.start or {}) for model in models)


def _runs(path: Floats, shortest: float) -> tuple[list[int], list[float]]:
    """Starts and directions of the runs of a path from its top; ``shortest`` is rounding."""
    steps = np.sign(np.diff(path))
    moves = np.flatnonzero(steps)
    bends = moves[1:][steps[moves[1:]] != steps[moves[:-1]]]
    turns, ways, way, furthest = [0], [-1.0], -1.0, 0
    for place in [*bends.tolist(), path.size - 1]:
        on = way * float(path[place] - path[furthest])
        if on > 0.0:
            furthest = place
        elif on < -shortest:
            way = -way
            turns.append(furthest)
            ways.append(way)
            furthest = place
    return turns, ways


class _Flow:
    """Moves, y being w along the motion: f = 1 - y^n above 0, 1 + (2 beta - 1) |y|^n below."""

    def __init__(self, law: BoucWen, n: float, beta: float) -> None:
        self._law, self._n, self._c = law, n, 2.0 * beta - 1.0
        width = 0.5 / max(4.0, n)
        self._rise = _Integral(self._rising, _FULL, width)
        self._fall_n = _Integral(self._falling_n, 1.0, width)
        self._fall_beta = _Integral(self._falling_beta, 1.0, width)

    def move(self, start: float, s: Floats) -> tuple[Floats, Floats, float, Floats]:
        """Moves over distances ``s``: y, f(y), 1/f of the start, and dy/dn, dy/dbeta on the way."""
        y = self._law._flow(np.full(s.size, start), s)
        f, gone = self._rate_and_integrals(y)
        first, before = self._rate_and_integrals(np.array([start]))
        return y, f, float(1.0 / first[0]), f * (gone - before)

    def go(self, start: float, s: float) -> tuple[float, float]:
        """End of a move over ``s``, and its derivative by the start."""
        y = float(self._law._flow(np.array([start]), np.array([s]))[0])
        first, last = self._rate(np.array([start, y]))
        return y, float(last / first)

    def _rate(self, y: Floats) -> Floats:
        up, down = np.clip(y, 0.0, 1.0 - 2.0**-53), np.maximum(-y, 0.0)
        with np.errstate(divide="ignore"):
            rising = -np.expm1(self._n * np.log(up))
        return np.where(y > 0.0, rising, 1.0 + self._c * down**self._n)

    def _rate_and_integrals(self, y: Floats) -> tuple[Floats, Floats]:
        """f(y), and the integrals of (df/dn)/f^2 and (df/dbeta)/f^2 from 0 to y."""
        up, down, f = np.clip(y, 0.0, 1.0 - 2.0**-53), np.maximum(-y, 0.0), self._rate(y)
        by_n = self._rise(-np.log1p(-up)) - self._fall_n(down)
        return f, np.stack((by_n, -self._fall_beta(down)))

    def _rising(self, v: Floats) -> Floats:
        """-q^n ln q/(1 - q^n)^2 with q = 1 - exp(-v), over dv."""
        complement = np.exp(-v)
        with np.errstate(divide="ignore"):
            right = np.log1p(-complement)
        log = np.where(v < 0.7, np.log(-np.expm1(-v)), right)
        power = self._n * log
        return np.asarray(-np.exp(power) * log / np.expm1(power) ** 2 * complement)

    def _falling_n(self, r: Floats) -> Floats:
        power = r**self._n
        return self._c * power * np.log(r) / (1.0 + self._c * power) ** 2

    def _falling_beta(self, r: Floats) -> Floats:
        power = r**self._n
        return 2.0 * power / (1.0 + self._c * power) ** 2


class _Integral:
    """Integral of a function from 0, which may begin like a power times a logarithm."""

    def __init__(self, function: Callable[[Floats], Floats], end: float, width: float) -> None:
        self._function = function
        self._edges = np.linspace(0.0, end, int(np.ceil(end / width)) + 1)
        self._sums = np.append(0.0, np.cumsum(self._parts(self._edges[:-1], self._edges[1:])))

    def _parts(self, low: Floats, high: Floats) -> Floats:
        # From 0 in the cubic root, which tames what the function begins with.
        first = (low == 0.0)[:, None]
        places = np.where(first, _NODES**3, _NODES)
        weights = np.where(first, 3.0 * _NODES**2 * _WEIGHTS, _WEIGHTS)
        width = np.maximum(high - low, 1e-300)[:, None]
        values = self._function(low[:, None] + width * places)
        return np.asarray((width * weights * values).sum(axis=1))

    def __call__(self, x: Floats) -> Floats:
        panel = np.searchsorted(self._edges, x, side="right") - 1
        panel = np.clip(panel, 0, self._edges.size - 2)
        return np.asarray(self._sums[panel] + self._parts(self._edges[panel], x))
