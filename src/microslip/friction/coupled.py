"""An interface whose normal load varies while it moves."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._checks import Floats, exact, record
from microslip._frozen import Locked, lock
from microslip._quadrature import gauss_legendre
from microslip.errors import InputError
from microslip.memory import Diagram, Slips, along, loads_along

if TYPE_CHECKING:
    from microslip.friction.interface import Interface

_NODES, _WEIGHTS = gauss_legendre(24)
# Towards both ends of a run the nodes lie as of a cosine: what has a root there is smooth then.
_ANGLES = 0.5 * math.pi * _NODES
_PLACES = np.sin(_ANGLES) ** 2
_SHARES = 0.5 * math.pi * _WEIGHTS * np.sin(2.0 * _ANGLES)
_BLOCK = 1 << 14  # pieces at a time


class Coupling:
    """What the memory of a varying load asks of an interface; separations count from its own."""

    def __init__(self, joint: Interface) -> None:
        self._joint = joint
        self._law = joint.surface
        self._origin = joint.separation
        self.friction = joint._friction
        self.slip = joint.slip_per_indentation

    def drop(self, base: Floats, width: Floats) -> Floats:
        """N(b) - N(b + w)."""
        return self._law._drop(base + self._origin, width) if base.size else base

    def fall(self, separation: float) -> float:
        """-N' there [N/m]."""
        return -self._law._derivative_at(separation + self._origin, 1)

    def load(self, separation: Floats) -> Floats:
        """N there [N]."""
        return self._law._derivative(separation + self._origin, 0)

    def step_of(self, load: float) -> float:
        """Separation at one load [N]."""
        if load == self._joint.normal_load:
            return 0.0
        return float(self.steps_of(np.array([load]))[0])

    def steps_of(self, load: Floats) -> Floats:
        """Separations at loads >= 0 [N]; without a load, that at which the last contact parts."""
        own = load == self._joint.normal_load
        steps = np.zeros_like(load)
        none = load == 0.0
        if none.any():
            top = self._law._top
            if not math.isfinite(top):
                raise InputError(
                    "normal_load must stay above zero on this surface, whose heights have no end: "
                    f"at any separation some summit touches; got 0 at sample "
                    f"{int(np.flatnonzero(none)[0])}"
                )
            steps[none] = top - self._origin
        other = ~(own | none)
        if other.any():
            values, which = np.unique(load[other], return_inverse=True)
            steps[other] = (np.asarray(self._law.separation(values)) - self._origin)[which]
        return steps

    def dissipated(self, slips: Slips, samples: int) -> Floats:
        """Energy dissipated in each step [J]: positive integrands only.

        While the front runs by dq over D, with s behind it, mu kappa (1 - s D) [N(d) - N(q) +
        N'(q) (q - d)] dq is lost.
        """
        if not slips.sample.size:
            return np.zeros(samples)
        total = np.zeros(samples)
        marks = self._law._kinks - self._origin
        block = max(1, _BLOCK // (1 + marks.size))
        for begin in range(0, slips.sample.size, block):
            part = Slips._make(column[begin : begin + block] for column in slips)
            total += np.bincount(part.sample, self._losses(part, marks), minlength=samples)
        return self.friction * self.slip * total

    def _losses(self, slips: Slips, marks: Floats) -> Floats:
        """Integral of each run, piece by piece where the front or the separation passes a mark."""
        _, start, end, density, sign, first, last = slips
        cuts = [np.zeros((start.size, 1)), np.ones((start.size, 1))]
        for low, high in ((start, end), (first, last)):
            with np.errstate(divide="ignore", invalid="ignore"):
                share = (marks - low[:, None]) / (high - low)[:, None]
            cuts.append(np.clip(np.nan_to_num(share), 0.0, 1.0))
        edges = np.sort(np.concatenate(cuts, axis=1), axis=1)
        run, piece = np.nonzero(np.diff(edges, axis=1) > 0.0)
        low, width = edges[run, piece], np.diff(edges, axis=1)[run, piece]
        u = low[:, None] + width[:, None] * _PLACES
        q = start[run, None] + u * (end - start)[run, None]
        d = first[run, None] + u * (last - first)[run, None]
        gap = np.maximum(q - d, 0.0).ravel()
        heights = self._law._excess_slope((d + self._origin).ravel(), gap).reshape(u.shape)
        value = np.bincount(run, width * (heights @ _SHARES), minlength=start.size)
        return np.asarray(2.0 * (end - start) * (1.0 - sign * density) * value)


@dataclass(frozen=True, eq=False)
class CoupledResponse(Locked):
    """A history of an interface under displacement and normal load, one entry a sample.

    Made by :meth:`microslip.Interface.coupled_response`, after Jaeger (1998),
    DOI 10.1115/1.2833765.
    """

    displacement: Floats
    """Displacements [m]."""
    force: Floats
    """Tangential forces [N]."""
    normal_load: Floats
    """Normal loads [N]."""
    separation: Floats
    """Separations [m]."""
    _coupling: Coupling

    @cached_property
    def dissipated_energy(self) -> Floats:
        """Energy dissipated up to each sample [J], from rest; it never falls.

        Once a periodic history has settled, the rise over a cycle is the area of its loop. In the
        first cycles the area also holds energy that is stored.
        """
        slips = Diagram().slips(
            self.separation - self._coupling._origin, self.displacement / self._coupling.slip
        )
        return lock(np.cumsum(self._coupling.dissipated(slips, self.force.size)))


def respond(
    joint: Interface, displacement: ArrayLike, normal_load: Any, separation: Any
) -> CoupledResponse:
    """See :meth:`microslip.Interface.coupled_response`."""
    x = record("displacement", displacement).reshape(-1)
    coupling = Coupling(joint)
    steps = _steps(coupling, joint, x.size, normal_load, separation)
    values = Diagram().respond(steps, x / coupling.slip, coupling.drop)
    return _response(coupling, joint, x, coupling.friction * values, steps)


def respond_to_force(
    joint: Interface, force: ArrayLike, normal_load: Any, separation: Any
) -> CoupledResponse:
    """The same under force control."""
    f = record("force", force).reshape(-1)
    coupling = Coupling(joint)
    steps = _steps(coupling, joint, f.size, normal_load, separation)
    limit = joint.friction_coefficient * coupling.load(steps)
    beyond = np.flatnonzero(np.abs(f) >= limit)
    if beyond.size:
        i = int(beyond[0])
        raise InputError(
            "force must stay below the force limit mu N in size (no displacement holds it beyond), "
            f"got {exact(f[i])} N at sample {i}, where the limit is {limit[i]:.10g} N"
        )
    places = _ForceWalk(coupling).walk(steps, f / coupling.friction)
    return _response(coupling, joint, coupling.slip * places, f, steps)


def _response(
    coupling: Coupling, joint: Interface, x: Floats, force: Floats, steps: Floats
) -> CoupledResponse:
    return CoupledResponse(
        lock(x.copy()),
        lock(np.array(force)),
        lock(coupling.load(steps)),
        lock(steps + joint.separation),
        coupling,
    )


def _steps(
    coupling: Coupling, joint: Interface, size: int, normal_load: Any, separation: Any
) -> Floats:
    """Separations from the joint's own along the history."""
    if (normal_load is None) == (separation is None):
        came = "neither" if normal_load is None else "both"
        raise InputError(
            f"normal_load=... [N] or separation=... [m] must be given, one of them, got {came}"
        )
    if separation is not None:
        values = along("separation", separation, size)
        return np.asarray(joint.surface._separations(values)) - joint.separation
    return coupling.steps_of(loads_along("normal_load", normal_load, size))


class _ForceWalk:
    """Places that hold given values T/mu, one step at a time."""

    def __init__(self, coupling: Coupling) -> None:
        self._coupling = coupling
        self._diagram = Diagram()

    def walk(self, steps: Floats, values: Floats) -> Floats:
        places = np.empty_like(values)
        for i, (step, value) in enumerate(zip(steps.tolist(), values.tolist(), strict=True)):
            places[i] = self._place(step, value)
            probed = self._diagram.probe(step, float(places[i]), self._coupling.drop)
            self._diagram.move(probed)
        return places

    def _drop(self, base: float, width: float) -> float:
        return float(self._coupling.drop(np.array([base]), np.array([width]))[0])

    def _place(self, step: float, value: float) -> float:
        """Place at which the value is the wanted one, at the separation ``step``."""
        g = self._diagram
        fall, change = g.separation - step, value - g.value
        depth = g.depth
        if fall >= 0.0:
            gain = self._drop(step, fall) if fall > 0.0 else 0.0
            if abs(change) <= gain:
                return g.place + (change / gain * fall if gain > 0.0 else 0.0)
            held, sign = g.value, 1.0 if change > 0.0 else -1.0
            begin = g.separation
        else:
            while depth and g.stack[depth - 1, 0] <= step:
                depth -= 1
            held, place = 0.0, 0.0
            if depth:
                end, density, beyond = g.stack[depth - 1].tolist()
                outer = float(g.values[depth - 2]) if depth > 1 else 0.0
                held = outer + density * self._drop(step, end - step)
                place = density * (end - step) + beyond
            if value == held:
                return place
            sign = 1.0 if value > held else -1.0
            begin = step
        # The front runs out to where sign N(q) and what lies beyond give the value.
        while depth:
            end, density, beyond = g.stack[depth - 1].tolist()
            outer = float(g.values[depth - 2]) if depth > 1 else 0.0
            at_end = sign * self._drop(step, end - step) + outer
            if density != sign and sign * (at_end - value) >= 0.0:
                # sign [N(step) - N(q)] + density [N(q) - N(end)] + outer = value
                wanted = sign * (at_end - value) / (1.0 - sign * density)
                q = self._before(end, wanted, max(begin, step))
                return float(sign * (q - step) + density * (end - q) + beyond)
            begin = max(begin, end)
            depth -= 1
        wanted = sign * value
        q = self._after(step, wanted, begin)
        return sign * (q - step)

    def _before(self, end: float, fall: float, low: float) -> float:
        """Where N is higher by ``fall`` than at ``end``; not below ``low``."""
        return self._solve(lambda q: self._drop(q, end - q) - fall, low, end)

    def _after(self, start: float, fall: float, low: float) -> float:
        """Where N is lower by ``fall`` than at ``start``."""
        wide = max(low - start, 1e-12 * abs(self._coupling._origin), 1e-30)
        high = start + wide
        while self._drop(start, high - start) < fall:
            wide *= 2.0
            high = start + wide
        return self._solve(lambda q: fall - self._drop(start, q - start), low, high)

    @staticmethod
    def _solve(miss: Callable[[float], float], low: float, high: float) -> float:
        """Root of a falling function between low and high."""
        if miss(low) <= 0.0:
            return low
        if miss(high) >= 0.0:
            return high
        from scipy.optimize import brentq

        root: Any = brentq(miss, low, high, xtol=1e-300, rtol=8.9e-16, maxiter=300)
        return float(root)
