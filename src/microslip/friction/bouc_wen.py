"""The model of Bouc and Wen: hysteresis by a differential equation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, exact, positive, record
from microslip._core.parameters import Parametric, parameter
from microslip.errors import InputError
from microslip.friction.guesses import all_features
from microslip.loops import Loop, checked_cycle
from microslip.numerics.inversion import invert
from microslip.numerics.quadrature import gauss_legendre

_MAX_EXPONENT = 100.0  # the largest exponent
_MAX_DECAY = 45.0  # exp(-45) is nothing beside 1
_NODES, _WEIGHTS = gauss_legendre(16)
_BLOCK = 1 << 14  # values a pass, so that temporaries stay small


@dataclass(frozen=True)
class BoucWen(Parametric):
    """Hysteresis after Bouc (1967) and Wen (1976): T = alpha k x + (1 - alpha) F_y w.

    The memory w follows dw/dx = (k/F_y) [A - |w|^n (gamma + beta sign(w dx))].

    Parameters
    ----------
    stiffness : float
        Stiffness k [N/m], above zero.
    yield_force : float
        Force F_y that is the unit of the hysteretic part [N], above zero.
    alpha : float, optional
        Share of the stiffness that stays elastic [-], from 0 to below 1.
    A, beta, gamma : float, optional
        Shape of the loop [-]: A above zero, beta at least as large as gamma is in size, and their
        sum above zero. beta = gamma unloads along a straight line.
    n : float, optional
        Sharpness of the yielding [-], from 1 to 100.

    Notes
    -----
    Wen (1976, DOI 10.1061/JMCEA3.0002106). With the stored energy (1 - alpha) F_y^2 w^2/2 k A the
    model dissipates |w|^n (beta |w dx| + gamma w dx) >= 0 times a positive constant at every step
    just if beta >= |gamma|, and w is bounded just if beta + gamma > 0; such and other conditions
    are compared by Ismail, Ikhouane and Rodellar (2009, DOI 10.1007/s11831-009-9031-8).

    It is rate independent and no law of this package's kind: it obeys Masing's rule for no
    parameters exactly, and a small cycle within a larger one neither closes nor is forgotten.
    Along every move the equation is solved in closed form for n = 1 and 2, else by quadrature and
    Newton's method, to 1e-12 of the force limit; how densely a record is sampled does not matter.
    """

    stiffness: float = field(metadata=parameter("k", "N/m", "stiffness at rest", above=0.0))
    yield_force: float = field(
        metadata=parameter("F_y", "N", "unit of the hysteretic force", above=0.0)
    )
    alpha: float = field(
        default=0.0,
        metadata=parameter(
            "alpha", meaning="share of the stiffness that stays elastic", least=0.0, below=1.0
        ),
    )
    A: float = field(default=1.0, metadata=parameter("A", meaning="slope at rest", above=0.0))
    beta: float = field(default=0.5, metadata=parameter("beta", meaning="shape of the loop"))
    gamma: float = field(default=0.5, metadata=parameter("gamma", meaning="shape of the loop"))
    n: float = field(
        default=1.0,
        metadata=parameter("n", meaning="sharpness of the yielding", least=1.0, most=_MAX_EXPONENT),
    )

    def __post_init__(self) -> None:
        self._check_parameters()
        if self.beta < abs(self.gamma):
            raise InputError(
                "`beta` must be at least the size of gamma, or the model is not dissipative (it "
                f"would release energy on part of a cycle), got beta={exact(self.beta)}, "
                f"gamma={exact(self.gamma)}"
            )
        if self.beta + self.gamma <= 0.0:
            raise InputError(
                "beta + gamma must be above zero, or the force is not limited, got "
                f"beta={exact(self.beta)}, gamma={exact(self.gamma)}"
            )
        positive("beta + gamma", self.beta + self.gamma)

    @classmethod
    def guess(cls, data: Any) -> BoucWen:
        """A model to start a fit from, with A = 1 and beta = gamma = 1/2: the closest of a grid.

        Data and errors are those of :meth:`microslip.BackboneLaw.guess`.
        """
        features = all_features(data)
        force = np.concatenate([f.force for f in features])
        elastic = np.concatenate([f.gone - f.amplitude for f in features])
        best = (np.inf, 1.0, 0.0, 1.0, 1.0)
        for n in (1.0, 2.0, 5.0):
            low = 0.5 * min(float(f.gone[0]) for f in features)
            high = 20.0 * max(f.amplitude for f in features)
            for _ in range(2):
                lengths = np.geomspace(low, high, 17)
                for length in lengths.tolist():
                    unit = cls(1.0 / length, 1.0, n=n)  # in units of force and of this length
                    parts = []
                    for f in features:
                        peak = unit._settled(2.0 * f.amplitude / length)
                        parts.append(unit._flow(np.full(f.gone.size, -peak), f.gone / length))
                    spring, slider, misfit = _two_parts(elastic, np.concatenate(parts), force)
                    if misfit < best[0]:
                        best = (misfit, spring, slider, length, n)
                step = float(lengths[1] / lengths[0])
                low, high = best[3] / step, best[3] * step
        _, spring, slider, length, n = best
        # alpha k is the spring, (1 - alpha) k the slider over its length; one that is all spring is
        # no model of friction.
        stiffness = spring + slider / length
        alpha = min(spring / stiffness, 0.95)
        return cls(stiffness, stiffness * length, alpha, n=n)

    # -- what it is made of -------------------------------------------------------------------

    @property
    def force_limit(self) -> float:
        """Limit of the hysteretic force [N]; for alpha > 0 the elastic one adds to it."""
        return self._unit * self._memory_limit

    @property
    def tangential_stiffness(self) -> float:
        """Stiffness at rest [N/m]."""
        return self.stiffness * (self.alpha + (1.0 - self.alpha) * self.A)

    @property
    def _unit(self) -> float:
        """Hysteretic force for w = 1 [N]."""
        return (1.0 - self.alpha) * self.yield_force

    @property
    def _memory_limit(self) -> float:
        """Limit of w."""
        return float((self.A / (self.beta + self.gamma)) ** (1.0 / self.n))

    @property
    def _bend(self) -> float:
        """Size of w at which the stiffness of unloading has doubled; infinite if it is constant."""
        fall = self.beta - self.gamma
        with np.errstate(divide="ignore", over="ignore"):
            return float(np.power(np.divide(self.A, fall), 1.0 / self.n))

    # -- responses ----------------------------------------------------------------------------

    def force(self, displacement: ArrayLike) -> Floats | float:
        """Force [N] along any displacement record [m] from rest, one-dimensional."""
        displacements = record("displacement", displacement, "m")
        x = displacements.reshape(-1)
        w = self._memory(np.clip(x, -1e200, 1e200))
        force = self.alpha * self.stiffness * x + self._unit * w
        return float(force[0]) if displacements.ndim == 0 else force

    def loop(self, amplitude: float, samples: int = 512) -> Loop:
        """The settled loop between +amplitude and -amplitude [m], as it is after many cycles.

        Samples lie as those of :meth:`microslip.BackboneLaw.loop`.
        """
        a, shape, turn = checked_cycle(amplitude, samples)
        scale = self.stiffness / self.yield_force
        peak = self._settled(2.0 * a * scale)
        way_gone = np.concatenate((1.0 - shape[: turn + 1], 1.0 + shape[turn + 1 :]))
        w = self._flow(np.full(way_gone.size, -peak), a * scale * way_gone)
        w[: turn + 1] *= -1.0
        w[0] = w[-1] = peak
        w[turn] = -peak
        return Loop(a * shape, self.alpha * self.stiffness * a * shape + self._unit * w)

    # -- the equation -------------------------------------------------------------------------

    def _memory(self, x: Floats) -> Floats:
        """Memory w along a record: from turn to turn, then all samples at once."""
        path = np.append(0.0, x)
        steps = np.sign(np.diff(path))
        moved = np.flatnonzero(steps)
        if moved.size == 0:
            return np.zeros_like(x)
        turns = np.append(moved[0], moved[1:][steps[moved[1:]] != steps[moved[:-1]]])
        ways = steps[turns]
        places = path[turns]  # where each run begins
        scale = self.stiffness / self.yield_force
        starts = np.empty(turns.size)
        w = 0.0
        lengths = np.append(np.abs(np.diff(places)) * scale, 0.0)
        for i, (way, length) in enumerate(zip(ways.tolist(), lengths, strict=True)):
            starts[i] = w
            w = way * float(self._flow(np.array([way * w]), np.array([length]))[0])
        counts = np.diff(np.append(turns, x.size))
        way, start, place = (np.repeat(v, counts) for v in (ways, starts, places))
        result = np.zeros_like(x)
        inside = slice(int(turns[0]), None)
        way_gone = np.abs(x[inside] - place) * scale
        result[inside] = way * self._flow(way * start, way_gone)
        return result

    def _flow(self, y: Floats, s: Floats) -> Floats:
        """Solution of dy/ds = A - |y|^n (gamma + beta sign y) from ``y`` over distances ``s``.

        y is w seen along the motion: rising, first towards 0 if it begins below, then to its limit.
        """
        limit, bend, times = self._memory_limit, self._bend, _times(self.n)
        result, s = np.empty_like(y), self.A * s
        back = np.maximum(-y, 0.0)
        until = back if np.isinf(bend) else bend * times.fall(np.log1p(back / bend))
        falling = s < until
        if falling.any():
            distance = np.maximum(until - s, 0.0)[falling]
            if not np.isinf(bend):
                distance = bend * np.expm1(times.fallen(distance / bend, back[falling] / bend))
            result[falling] = -distance
        rising = ~falling
        if rising.any():
            share = np.minimum(np.maximum(y[rising], 0.0) / limit, 1.0 - 2.0**-53)
            begun = times.rise(-np.log1p(-share))
            result[rising] = -limit * np.expm1(-times.risen(begun + (s - until)[rising] / limit))
        return result

    def _settled(self, s: float) -> float:
        """Peak of w in a settled cycle: what a way of length ``s`` takes from -peak to peak."""
        limit, bend, times = self._memory_limit, self._bend, _times(self.n)

        def way_and_slope(v: Floats) -> tuple[Floats, Floats]:
            share = -np.expm1(-v)
            w = limit * share
            fall = w if np.isinf(bend) else bend * times.fall(np.log1p(w / bend))
            slope = limit * np.exp(-v) / (1.0 + (w / bend) ** self.n)
            return fall + limit * times.rise(v), slope + limit * times.rise_slope(v)

        full = np.array([_MAX_DECAY])
        target = np.minimum(np.array([self.A * s]), way_and_slope(full)[0])
        v = invert(way_and_slope, target, np.zeros(1), full)
        return float(-limit * np.expm1(-v[0]))


def _two_parts(first: Floats, second: Floats, target: Floats) -> tuple[float, float, float]:
    """Factors >= 0 of two curves whose sum is closest to a third, and what is left, squared."""
    a, b, c = float(first @ first), float(second @ second), float(first @ second)
    u, v = float(first @ target), float(second @ target)
    det = a * b - c * c
    x, y = ((u * b - v * c) / det, (v * a - u * c) / det) if det > 1e-14 * a * b else (0.0, v / b)
    if x < 0.0:
        x, y = 0.0, v / b
    elif y < 0.0:
        x, y = u / a, 0.0
    return x, y, float(np.sum((target - x * first - y * second) ** 2))


class _Times:
    """Integrals of the equation over its hysteretic force, for n = 1.

    In the rising part q = 1 - exp(-v) goes from 0 towards 1 with the rate 1 - q^n, in the falling
    part q = exp(v) - 1 goes to 0 with the rate 1 + q^n.
    """

    def rise(self, v: Floats) -> Floats:
        """Time from q = 0 to v."""
        return v

    def rise_slope(self, v: Floats) -> Floats:
        """Its derivative by v."""
        return np.ones_like(v)

    def risen(self, time: Floats) -> Floats:
        """The v that is reached in a time."""
        return np.minimum(time, _MAX_DECAY)

    def fall(self, v: Floats) -> Floats:
        """Time from v to q = 0."""
        return v

    def fallen(self, time: Floats, q: Floats) -> Floats:
        """The v from which it takes a time to q = 0, not beyond the one of ``q``."""
        return time


class _SquareTimes(_Times):
    """The same for n = 2."""

    def rise(self, v: Floats) -> Floats:
        return 0.5 * (v + np.log1p(-np.expm1(-v)))

    def rise_slope(self, v: Floats) -> Floats:
        return 1.0 / (2.0 - np.exp(-v))

    def risen(self, time: Floats) -> Floats:
        return np.log1p(0.5 * np.expm1(2.0 * np.minimum(time, _MAX_DECAY)))

    def fall(self, v: Floats) -> Floats:
        return np.arctan(np.expm1(v))

    def fallen(self, time: Floats, q: Floats) -> Floats:
        return np.log1p(np.tan(time))


class _AnyTimes(_Times):
    """The same for any n, by quadrature over v and Newton's method."""

    def __init__(self, n: float) -> None:
        self._n = n
        # Panels are narrow beside the distance of the rates' poles from the axis, pi/2n.
        self._width = 1.0 / max(4.0, n)
        self._edges = self._width * np.arange(np.ceil(2.0 * _MAX_DECAY / self._width) + 1.0)
        self._rises, self._falls = (
            np.append(0.0, np.cumsum(_areas(rate, self._edges[:-1], self._edges[1:])))
            for rate in (self.rise_slope, self.fall_slope)
        )

    def _until(self, rate: Callable[[Floats], Floats], sums: Floats, v: Floats) -> Floats:
        result = np.empty_like(v)
        for start in range(0, v.size, _BLOCK):
            part = slice(start, start + _BLOCK)
            panel = np.minimum(v[part] / self._width, self._edges.size - 2).astype(np.int64)
            result[part] = sums[panel] + _areas(rate, self._edges[panel], v[part])
        return result

    def rise(self, v: Floats) -> Floats:
        return self._until(self.rise_slope, self._rises, v)

    def rise_slope(self, v: Floats) -> Floats:
        decay = np.exp(-v)
        with np.errstate(divide="ignore"):
            log = np.where(v < 0.7, np.log(-np.expm1(-v)), np.log1p(-decay))
        return np.asarray(decay / -np.expm1(self._n * log))

    def risen(self, time: Floats) -> Floats:
        full = np.full_like(time, _MAX_DECAY)
        time = np.minimum(time, self.rise(full[:1]))
        # The slope lies between 1/n and 1.
        high = np.minimum(self._n * time, full)
        return invert(lambda v: (self.rise(v), self.rise_slope(v)), time, time, high)

    def fall(self, v: Floats) -> Floats:
        return self._until(self.fall_slope, self._falls, v)

    def fall_slope(self, v: Floats) -> Floats:
        """Derivative of the time from v to q = 0."""
        with np.errstate(divide="ignore"):
            return np.exp(v - np.logaddexp(0.0, self._n * np.log(np.expm1(v))))

    def fallen(self, time: Floats, q: Floats) -> Floats:
        start = np.zeros_like(time)
        return invert(lambda v: (self.fall(v), self.fall_slope(v)), time, start, np.log1p(q))


def _areas(rate: Callable[[Floats], Floats], low: Floats, high: Floats) -> Floats:
    """Integrals of a rate over intervals; those from 0 in the cubic root, to tame its powers."""
    root = (low == 0.0)[:, None]
    places = np.where(root, _NODES**3, _NODES)
    weights = np.where(root, 3.0 * _NODES**2 * _WEIGHTS, _WEIGHTS)
    width = (high - low)[:, None]
    return np.asarray((width * weights * rate(low[:, None] + width * places)).sum(axis=1))


@lru_cache(maxsize=16)
def _times(n: float) -> _Times:
    if n == 1.0:
        return _Times()
    return _SquareTimes() if n == 2.0 else _AnyTimes(n)
