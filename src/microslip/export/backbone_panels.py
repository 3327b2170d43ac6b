"""Backbones and load curves as piecewise polynomials, for exported code."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from microslip._core import kernels
from microslip._core.checks import Floats
from microslip._core.errors import InputError
from microslip._core.frozen import lock
from microslip._core.kernels.profile import Profile
from microslip._core.kernels.table import NODES, TO_POWERS, TO_SERIES, PolynomialTable
from microslip._core.quadrature import gauss_legendre
from microslip.contact.load_curve import LoadCurve
from microslip.friction import BackboneLaw, Interface, IsotropicField

_PANEL_LIMIT = 20_000  # panels
_ROUNDING = 1e-15  # truncation error over the force at the end of a panel
_NOISE = 1e-13  # the same where halving no longer helps because the law itself is inexact
_NOTHING = 1e-14  # negligible force over that at the smallest amplitude
_HALVINGS = 60


@dataclass(frozen=True)
class BackbonePanels:
    """Backbone T0 as polynomials on panels from 0 to ``end``, and the force limit beyond.

    Each polynomial is in powers of s, which increases from -1 to 1 over the panel. If panels have
    equal width (``inverse_width`` above 0), all polynomials represent T0/u; otherwise the first
    represents T0/u, and the others T0.
    """

    edges: Floats  # (panels + 1,), rising from 0
    coefficients: Floats  # (panels, terms)
    inverse_width: float
    limit: float

    @classmethod
    def of(cls, law: BackboneLaw, smallest: float) -> BackbonePanels:
        """Return the panels of a law, those of its kernel :class:`PolynomialTable` if it has one.

        Otherwise the kinks of the law are edges, and panels are halved until the truncation error
        is within rounding, or negligible against the force at the ``smallest`` amplitude [m].
        """
        table = law._table
        if table is not None and table.power == 1 and table.rate == 0.0:
            panels = len(table.coefficients)
            edges = np.arange(panels + 1) / table.inverse_width
            return cls(edges, table.coefficients, table.inverse_width, table.limit)
        return _unequal(law, smallest)

    @property
    def end(self) -> float:
        """Displacement [m] beyond which the force is the force limit."""
        return float(self.edges[-1])

    def force(self, u: Floats) -> Floats:
        """Return the backbone T0 [N] at displacements u >= 0 [m], as exported code computes it."""
        return self._evaluate(u)[0]

    def energy(self, amplitudes: Floats) -> Floats:
        """Return the energy dissipated per cycle [J], for increasing amplitudes [m]."""

        def rate(u: Floats) -> Floats:
            force, slope = self._evaluate(u)
            return 4.0 * (force - u * slope)

        return cycle_energy(np.unique(np.append(self.edges, amplitudes)), amplitudes, rate)

    @property
    def middles(self) -> Floats:
        """Integrals of T0 [J] from 0 to the middle of each panel, and last from 0 to ``end``."""
        c, width = self.coefficients, np.diff(self.edges)[:, None]
        k = np.arange(c.shape[1])
        ends = np.array([-1.0, 1.0])[:, None, None]
        first, second = c / (k + 1) * ends ** (k + 1), c / (k + 2) * ends ** (k + 2)
        over = 0.5 * width * ((self.edges[:-1, None] + 0.5 * width) * first + 0.5 * width * second)
        plain = 0.5 * width * first
        divided = np.arange(len(c)) < (len(c) if self.inverse_width > 0.0 else 1)
        before, after = np.where(divided, over.sum(axis=-1), plain.sum(axis=-1))
        begin = np.append(0.0, np.cumsum(after - before))
        return np.append(begin[:-1] - before, begin[-1])

    def _evaluate(self, u: Floats) -> tuple[Floats, Floats]:
        if self.inverse_width > 0.0:
            table = PolynomialTable(lock(self.coefficients), self.inverse_width, 1, self.limit, 0.0)
            return table.value_and_slope(u)
        panel = np.clip(np.searchsorted(self.edges, u, side="right") - 1, 0, len(self.edges) - 2)
        low, high = self.edges[panel], self.edges[panel + 1]
        s = 2.0 * ((u - low) / (high - low)) - 1.0
        c = self.coefficients[panel]
        shape, grade = np.zeros(u.size), np.zeros(u.size)
        for k in range(c.shape[1] - 1, -1, -1):
            grade = grade * s + shape
            shape = shape * s + c[:, k]
        grade = grade * (2.0 / (high - low))
        first = panel == 0
        value = np.where(first, u * shape, shape)
        slope = np.where(first, shape + u * grade, grade)
        past = u >= self.end
        return np.where(past, self.limit, value), np.where(past, 0.0, slope)


def cycle_energy(places: Floats, amplitudes: Floats, rate: Callable[[Floats], Floats]) -> Floats:
    """Return the integral of ``rate`` [N] from 0 to each amplitude [m], an energy per cycle [J].

    ``rate`` = dW/da is smooth between the increasing ``places`` [m], which include the amplitudes.
    """
    # 4 (T0 - u T0') = -4 u^2 (T0/u)': the second form does not suffer from cancellation.
    nodes, weights = gauss_legendre(16)
    width = np.diff(places)
    u = places[:-1, None] + width[:, None] * nodes
    pieces = width * (rate(u.reshape(-1)).reshape(u.shape) @ weights)
    sums = np.append(0.0, np.cumsum(pieces))
    return np.asarray(sums[np.searchsorted(places, amplitudes)])


def _unequal(law: BackboneLaw, smallest: float) -> BackbonePanels:
    limit = law.force_limit
    floor = _NOTHING * float(law._backbone(np.array([smallest]))[0])
    end = _end(law, limit)
    kinks = np.asarray(law._kinks)
    kinks = kinks[(kinks > 0.0) & (kinks < end)]
    if kinks.size > _PANEL_LIMIT:
        raise _too_rough(law)
    edges = np.concatenate(([0.0], kinks, [end]))
    # If T0/u is not smooth at rest, the first panel is so short that its error is negligible.
    todo = [(float(a), float(b), 0, np.inf) for a, b in itertools.pairwise(edges)][::-1]
    places, rows = [0.0], []
    while todo:
        low, high, depth, before = todo.pop()
        row, error = _panel(law._backbone, low, high, floor)
        middle = low + 0.5 * (high - low)
        noise = low > 0.0 and 0.5 * before < error <= _NOISE
        if error > 0.0 and not noise and depth < _HALVINGS and low < middle < high:
            todo += [(middle, high, depth + 1, error), (low, middle, depth + 1, error)]
            continue
        places.append(high)
        rows.append(row)
        if len(rows) + len(todo) > _PANEL_LIMIT:
            raise _too_rough(law)
    coefficients = np.array(rows)
    size = np.abs(coefficients).max(axis=0)
    used = int(np.flatnonzero(size > 0.0)[-1]) + 1 if size.any() else 1
    return BackbonePanels(np.array(places), coefficients[:, : max(used, 2)], 0.0, limit)


def _panel(
    backbone: Callable[[Floats], Floats], low: float, high: float, floor: float
) -> tuple[Floats, float]:
    """Return coefficients of powers of s on the panel [low, high], and their error.

    The error [-] is relative to the largest force on the panel; it is returned as 0 if it is at
    rounding level or below a hundredth of ``floor`` [N]. On the first panel (low = 0) the function
    is T0/u.
    """
    u = low + 0.5 * (high - low) * (1.0 + NODES)
    force = backbone(u)
    series = (force / u if low == 0.0 else force) @ TO_SERIES
    size = high if low == 0.0 else 1.0
    scale = max(float(force.max()), floor / _NOTHING * 1e-3)
    small = np.abs(series) * size <= 2.0 * _ROUNDING * scale
    left_out = float(np.abs(series[kernels.TERMS - 1 :]).max()) * size
    fits = left_out <= 2.0 * _ROUNDING * scale or left_out <= 0.01 * floor
    # Trailing terms at rounding level are removed, so that straight pieces stay straight.
    terms = kernels.TERMS
    while terms > 1 and small[terms - 1]:
        terms -= 1
    series[terms:] = 0.0
    return series[: kernels.TERMS] @ TO_POWERS, 0.0 if fits else left_out / scale


def _end(law: BackboneLaw, limit: float) -> float:
    """Return a displacement [m] at which the force equals the limit within rounding."""
    end = limit / law.tangential_stiffness
    for _ in range(400):
        force, later = law._backbone(np.array([end, 1.5 * end])).tolist()
        # Rounding of the separation may keep the force a few last places below the limit.
        last = 8.0 * _ROUNDING if force == later else _ROUNDING
        if force >= limit * (1.0 - last):
            return end
        end *= 1.5
    raise _too_rough(law)


def _too_rough(law: BackboneLaw) -> InputError:
    name = type(law).__name__
    return InputError(
        f"c and fmu support laws of at most {_PANEL_LIMIT} smooth pieces, and {name} needs more; "
        "cells represent it with a known error: use kind iwan, opensees or calculix, or "
        "law.to_iwan(...)"
    )


_HEAVIEST = (20.0, 10.0, 5.0, 2.0)  # largest loads tried, over the load at rest
_FAR = 1e3  # decay lengths: beyond any contact


@dataclass(frozen=True)
class LoadPanels:
    """Load curve N, a function of the step (separation minus ``origin``), as polynomials."""

    profile: Profile
    origin: float
    """Separation [m] at step 0."""
    rest: float
    """Step at rest [m]."""
    nearest: float
    """Smallest step relative to that at rest [m] that the panels cover, negative."""
    friction: float
    """Tangential force over the corresponding value of the curve [-], including mu."""
    load_scale: float
    """Normal load over the value of the curve [-]."""
    slip: float
    """Tangential displacement that corresponds to a step of 1, kappa [-]."""

    @classmethod
    def of_interface(cls, joint: Interface) -> LoadPanels:
        """Return the load curve of an interface, up to 20 times its load if possible."""
        curve = LoadCurve(joint.surface, joint.separation, joint.normal_load)
        coupling = joint._load_curve
        for factor in _HEAVIEST:
            try:
                nearest = curve.step_of(factor * joint.normal_load)
            except InputError:  # the surface does not bear this load
                continue
            profile = curve.profile(nearest, _FAR * curve._length)
            if profile is not None:
                rest = joint.separation
                friction, slip = coupling.friction, coupling.slip
                return cls(profile, rest, 0.0, nearest, friction, 1.0, slip)
        raise InputError(
            "contact elements need a smooth load curve, and that of "
            f"{type(joint.surface).__name__} "
            'has kinks; use element="joint" at a constant load, or in Python '
            "state.try_(displacement, separation=...)"
        )

    @classmethod
    def of_field(cls, field: IsotropicField) -> LoadPanels:
        """Return the load curve of an :class:`IsotropicField` with a single contact node."""
        nodes, bank = field.field._nodes, field._bank
        profile = nodes.curve.profile(bank.nearest, 0.0)
        if profile is None:
            raise InputError(
                "planar-contact elements need a smooth load curve, and that of "
                f"{type(nodes.curve.surface).__name__} has kinks; "
                "use start().try_(displacement, separations) in Python"
            )
        rest, scale = float(nodes.rests[0]), float(nodes.scales[0])
        origin = float(field.field.separations[0])
        weight, slip = float(nodes.weights[0]), float(nodes.slips[0])
        return cls(profile, origin, rest, bank.nearest - rest, weight, scale, slip)

    @property
    def middles(self) -> Floats:
        """Integrals of N [N m] from the middle of each panel to the loss of contact."""
        coefficients, half = self.profile.coefficients, 0.5 / self.profile.inverse_width
        k = np.arange(coefficients.shape[1])
        after = half * (coefficients / (k + 1)).sum(axis=1)
        before = -half * (coefficients / (k + 1) * (-1.0) ** (k + 1)).sum(axis=1)
        beyond = np.append(np.cumsum((after + before)[::-1])[::-1][1:], 0.0)
        return np.asarray(after + beyond)

    def force(self, u: Floats) -> Floats:
        """Return the backbone [N] at displacements u [m] and the load at rest.

        It is computed from the panels of N as friction times (N(rest) - N(rest + u/slip)).
        """
        return self._from_kernel(kernels.compiled.drops, u)

    def energy(self, amplitudes: Floats) -> Floats:
        """Return the energy dissipated per cycle [J] at the load at rest, for rising amplitudes."""
        return cycle_energy(
            np.unique(np.append(0.0, amplitudes)),
            amplitudes,
            lambda u: 4.0 * self._from_kernel(kernels.compiled.excesses, u),
        )

    def _from_kernel(self, kernel: Any, u: Floats) -> Floats:
        result = np.empty(u.size)
        kernel(np.full(u.size, self.rest), u / self.slip, result, *self.profile.arguments)
        return np.asarray(self.friction * result)
