"""Drops, stiffnesses and energies of a normal law for many pairs of separation and increment.

For a separation d and an increment u of it, the functions of :class:`NormalLaw` are the drop N(d) -
N(d + u), the fall -N'(d + u), the excess (half the integral of v (u - v) N''(d + v) over 0 <= v <=
u) and the derivative of the excess with respect to u. An interface evaluates them at one d for many
u; here each u has its own d. A smooth law is replaced by one profile, a piecewise polynomial
approximation of N; for other laws, increments with equal d are interpolated in a table if that is
faster.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property, lru_cache
from typing import Literal

import numpy as np

from microslip._core import kernels
from microslip._core.checks import Floats
from microslip._core.frozen import lock
from microslip._core.kernels.profile import Profile
from microslip._core.kernels.table import PolynomialTable
from microslip._core.quadrature import gauss_legendre
from microslip.contact.base import NormalLaw
from microslip.contact.spline import over_pairs

Difference = Literal["drop", "fall", "excess", "excess_slope"]

_POWERS = {"drop": 1, "excess": 3, "excess_slope": 2}
_BLOCK = 1 << 14  # points a pass, as many as a cache holds

# What things cost [s], to choose the quickest way; a factor of two either way does not matter.
_POINT = 2e-6
_ROW = 4e-4
_TERM = 8e-9
_PIECE = 6e-9

_RULE = lock(np.concatenate(gauss_legendre(12)))
"""Gauss-Legendre rule for v (u - v) N'', exact to 1e-16 over two decay lengths."""
_FAINT_LOAD = 1e-30  # of the largest load; fainter ones are rare, and cost wide panels their width
_ALL_TOUCH = 0.345  # N N'' / N'^2, which is 1 for an exponential and 1/3 where all summits touch


def _by_rows(law: NormalLaw, points: int, rows: int) -> bool:
    if law._spheres is not None:
        count = law._spheres.heights.size
        build = 4e-5 + (5e-6 * count if count > 24 else 0.0)
        return points * count * _TERM > rows * build + points * min(count * 1e-8, 8e-7)
    if law._spline is not None:
        return points * law._spline.knots.size * _PIECE > rows * 9e-5 + points * 1e-7
    return points * _POINT > rows * _ROW + points * 3e-8


def sum_over_pairs(law: NormalLaw, kind: Difference, d: Floats, u: Floats) -> Floats:
    """Return the drop, fall, excess or its slope (``kind``) at pairs (d, u), one-dimensional."""
    if law._spline is None:
        return np.asarray(getattr(law, f"_{kind}")(d, u))
    return -law._derivative(d + u, 1) if kind == "fall" else over_pairs(law._spline, kind, d, u)


def _row(law: NormalLaw, kind: Difference, d: float, u: Floats) -> Floats:
    exact: Callable[[float, Floats], Floats] = getattr(law, f"_{kind}")
    reach = law._table_reach(d) if kind != "fall" and u.size * _POINT > _ROW else None
    if reach is None:
        return exact(d, u)
    power = _POWERS[kind]
    last = float(exact(d, np.array([reach]))[0])
    load = law._derivative_at(d, 0)
    table = PolynomialTable.sample(
        lambda v: exact(d, v) / v**power,
        reach,
        power,
        {"drop": load, "excess": last, "excess_slope": 0.5 * load}[kind],
        0.5 * load if kind == "excess" else 0.0,
        tolerance=1e-13 if kind == "drop" else 1e-12,
    )
    return exact(d, u) if table is None else table.value(u)


class Pointwise:
    """Drops, stiffnesses and energies of a law at arrays of pairs (d, u), one-dimensional.

    If the law is smooth and decays fast, a profile replaces its load curve, and a value takes tens
    of nanoseconds. Other laws, and separations outside the profile, are evaluated pair by pair.
    """

    def __init__(self, law: NormalLaw) -> None:
        self.law = law

    @cached_property
    def _profile(self) -> tuple[Profile, tuple[Floats, Floats]] | None:
        """Polynomials of N and N'' on panels, and integrals of N from each midpoint to infinity.

        None if N is not smooth or decays too slowly.
        """
        law = self.law
        if law._spheres is not None or law._breaks[1:].size or law._spline is not None:
            return None
        low, high = law._span
        places = np.linspace(max(low, law._edge), high, 513)
        load, slope, bend = (law._derivative(places, k) for k in range(3))
        # Where nearly all summits touch, N tends to (-d)^(3/2) and no rule is short.
        smooth = places[(load > _FAINT_LOAD * load[0]) & (load * bend > _ALL_TOUCH * slope * slope)]
        if smooth.size < 2:
            return None
        low, high = float(smooth[0]), float(smooth[-1])
        reach = law._table_reach(high)
        if reach is None:
            return None
        profile = Profile.sample(law._derivative, low, high, high + reach, law._edge)
        if profile is None:
            return None
        count = len(profile.coefficients)
        shares = np.arange(float(count)) - (profile.first - 0.5)
        middles: Floats = np.asarray(profile.anchor + shares / profile.inverse_width, dtype=float)
        k = np.arange(2, kernels.PROFILE_TERMS)
        bends = profile.coefficients[:, 2:] * (k * (k - 1))
        return profile, (lock(np.ascontiguousarray(bends)), lock(law._derivative(middles, -1)))

    def separations(self, load: Floats) -> Floats:
        """Return the separations [m] of loads [N]."""
        if self._profile is None:
            return np.asarray(self.law.separation(load))
        profile, _ = self._profile
        low_load, high_load = profile.span
        inside = (load >= low_load) & (load <= high_load)
        if inside.all():
            return profile.separations(load)
        result = np.empty(load.size)
        result[inside] = profile.separations(load[inside])
        result[~inside] = self.law.separation(load[~inside])
        return result

    def load_and_fall(self, d: Floats) -> tuple[Floats, Floats]:
        """Return the load N(d) [N] and the stiffness -N'(d) [N/m]."""
        if self._profile is None:
            return self.law._derivative(d, 0), -self.law._derivative(d, 1)
        profile, _ = self._profile
        value, fall = np.empty(d.size), np.empty(d.size)
        outside = np.flatnonzero(~((d >= profile.low) & (d <= profile.high)))
        kernels.compiled.loads(np.maximum(d, profile.low), value, fall, *profile.arguments)
        if outside.size:
            value[outside] = self.law._derivative(d[outside], 0)
            fall[outside] = -self.law._derivative(d[outside], 1)
        return value, fall

    def sum(self, kind: Difference, d: Floats, u: Floats) -> Floats:
        """Return the function ``kind`` at separations d [m] and increments u >= 0 [m]."""
        if self._profile is None or kind not in ("drop", "excess"):
            return self._exact(kind, d, u)
        profile, extra = self._profile
        result = np.empty(d.size)
        outside = np.flatnonzero(~((d >= profile.low) & (d <= profile.high)))
        place, step = d, np.minimum(u, 1e200)
        if outside.size:
            place = d.copy()
            place[outside] = profile.low
        if kind == "drop":
            kernels.compiled.drops(place, step, result, *profile.arguments)
        else:
            kernels.compiled.cycle_energies(place, step, result, *extra, _RULE, *profile.arguments)
        if outside.size:
            result[outside] = self._exact(kind, d[outside], u[outside])
        return result

    def _exact(self, kind: Difference, d: Floats, u: Floats) -> Floats:
        # Neighbours of one separation are a row.
        ends = np.append(np.flatnonzero(np.diff(d)) + 1, d.size)
        result = np.empty(d.size)
        if _by_rows(self.law, d.size, ends.size):
            begin = 0
            for end in ends.tolist():
                result[begin:end] = _row(self.law, kind, float(d[begin]), u[begin:end])
                begin = end
            return result
        for begin in range(0, d.size, _BLOCK):
            part = slice(begin, begin + _BLOCK)
            result[part] = sum_over_pairs(self.law, kind, d[part], u[part])
        return result


_cached = lru_cache(maxsize=8)(Pointwise)


def pointwise_of(law: NormalLaw) -> Pointwise:
    """Return the :class:`Pointwise` of a law, cached with its profile."""
    try:
        return _cached(law)
    except TypeError:  # one without a hash
        return Pointwise(law)
