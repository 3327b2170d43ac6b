"""Fourier coefficients of the settled force for a displacement with few harmonics.

The displacement x(t) is smooth, so the settled force is smooth between turning points, closures of
inner loops and kinks of the law. Gauss-Legendre quadrature of each piece gives the coefficients to
rounding error with a few dozen nodes, whereas equidistant samples would miss the turning points.
The derivatives D = dT/dp and x' = dx/dp with respect to a coefficient p satisfy D = D_r + k (x' -
x'_r) on the branch that began at reversal r, with the tangent stiffness k.

The compiled kernel integrates most laws, and fields; this module integrates all other laws.

Equation numbers (19.x) are those of chapter 19, DOI 10.1007/978-3-319-56818-8_19.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from microslip._core import kernels
from microslip._core.checks import Floats, number
from microslip._core.errors import InputError
from microslip._core.quadrature import gauss_legendre
from microslip.friction.cycles import Rest, rest_of
from microslip.friction.harmonic_basis import Basis, coefficients_of

_NODES, _WEIGHTS = gauss_legendre(16)
# Nodes are clustered like those of a cosine, which makes square roots at the ends smooth.
_SHARES = np.sin(0.5 * math.pi * _NODES) ** 2
_SHARE_WEIGHTS = 0.5 * math.pi * np.sin(math.pi * _NODES) * _WEIGHTS
_MAX_PIECES = 1 << 15
_LEVELS = 48
_NO_REST = np.zeros(1)


class HarmonicForce(NamedTuple):
    """Fourier coefficients of the settled force on a joint, with their Jacobian.

    The force follows the branches (19.20)-(19.24); see :meth:`microslip.BackboneLaw.harmonics`.
    """

    force: Floats
    """Coefficients of the force [N], in the order of the displacement coefficients."""
    jacobian: Floats
    """Jacobian [N/m]: rows are force coefficients, columns displacement coefficients."""


def harmonic_force(
    law: Any,
    coefficients: ArrayLike,
    harmonics: Any,
    rest: Rest,
    rtol: float,
    least: float = 0.0,
) -> HarmonicForce:
    """Compute Fourier coefficients of a law; see :meth:`microslip.BackboneLaw.harmonics`.

    The tolerance is ``rtol`` times the larger of ``least`` [N] and the largest force of the cycle.
    """
    basis = Basis(harmonics)
    c = coefficients_of("coefficients", coefficients, basis).copy()
    begin, moves = 0.0, None  # moves: 0 for coefficients that shift the rest displacement too
    if type(rest) is not float or rest != 0.0:
        begin, from_mean = rest_of(rest, np.zeros(1))
        if from_mean and basis.has_mean:
            moves = np.ones(basis.size)
            c[0], moves[0] = 0.0, 0.0
    tolerance = checked_tolerance(rtol)
    table = law._table
    if c[int(basis.has_mean) :].any():
        table = table or getattr(law, "_rigid_table", None)
    kernel: Any = None
    if basis.in_kernel and table is not None:
        kernel, line = kernels.compiled.table_harmonics, table.arguments
    elif basis.in_kernel and (pieces := getattr(law, "_pieces", None)) is not None:
        kernel, line = kernels.compiled.field_harmonics, (_NO_REST, *pieces.arguments)
    if kernel is not None:
        values, slopes = basis.integrated(c[None], begin, tolerance, kernel, *line)
        return HarmonicForce(values[0], slopes[0] if moves is None else slopes[0] * moves)
    motion = _Motion(basis, c, begin, np.ones(basis.size) if moves is None else moves)
    if motion.turns.size < 2:
        return _at_rest(law, motion)
    return _Cycle(law, motion).coefficients(tolerance, least)


def checked_tolerance(rtol: float) -> float:
    """Check the relative tolerance ``rtol`` [-]."""
    tolerance = number("rtol", rtol)
    if not 1e-14 <= tolerance <= 0.1:
        raise InputError(f"`rtol` must be between 1e-14 and 0.1, got {tolerance:g}")
    return tolerance


class _Motion:
    """Displacement x(t) relative to the rest displacement, with the times of its turning points."""

    def __init__(self, basis: Basis, c: Floats, begin: float, moves: Floats) -> None:
        self.basis, self.c, self.begin, self.moves = basis, c, begin, moves
        self.turns = self._turning_points()

    def at(self, t: Floats, derivative: int = 0) -> Floats:
        value = self.basis.values(t, derivative) @ self.c
        return value if derivative else value - self.begin

    def directions(self, t: Floats, derivative: int = 0) -> Floats:
        """Return dx(t)/dc, or its time derivative, for each coefficient c, shape (t.size, size)."""
        return self.basis.values(t, derivative) * self.moves

    def _turning_points(self) -> Floats:
        """Return the times of the turning points [rad] in cyclic order from the largest |x| on."""
        waves = self.c[int(self.basis.has_mean) :]
        top = self.basis.orders[-1]
        if not np.any(waves):
            return np.zeros(0)
        # Roots of the derivative as a polynomial in exp(i t); close roots appear as pairs.
        cosines, sines = np.zeros(top + 1), np.zeros(top + 1)
        turning = [n for n in self.basis.orders if n]
        scale = np.abs(waves).max()
        for n, (a, b) in zip(turning, waves.reshape(-1, 2) / scale, strict=True):
            cosines[n], sines[n] = n * b, -n * a
        upper = 0.5 * (cosines - 1j * sines)
        roots = np.roots(np.concatenate((upper[:0:-1], [0.0], np.conj(upper[1:]))))
        grid = np.concatenate((
            np.angle(roots), 2.0 * math.pi * np.arange(4 * top + 5) / (4 * top + 5) + 0.1
        ))  # fmt: skip
        grid = np.unique(np.mod(grid, 2.0 * math.pi))
        middles = 0.5 * (grid + np.append(grid[1:], grid[0] + 2.0 * math.pi))
        places = np.sort(np.concatenate((grid, middles)))
        speed = self.at(places, 1)
        after = np.append(places[1:], places[0] + 2.0 * math.pi)
        ahead = np.append(speed[1:], speed[0])
        change = (np.sign(speed) * np.sign(ahead) < 0.0) | (speed == 0.0)
        low, high = places[change], after[change]
        exact = speed[change] == 0.0
        high = np.where(exact, low, high)
        turns = bracketed_roots(lambda t: self.at(t, 1), lambda t: self.at(t, 2), low, high)
        turns = np.unique(np.mod(turns, 2.0 * math.pi))
        x = self.at(turns)
        # Keep only true turning points, at which the direction changes.
        while x.size > 2:
            steps = x - np.roll(x, 1)
            monotone = np.sign(steps) == np.sign(np.roll(steps, -1))
            monotone |= steps == 0.0
            if not monotone.any():
                break
            first = int(np.argmax(monotone))
            turns, x = np.delete(turns, first), np.delete(x, first)
        if x.size < 2 or not np.ptp(x) > 0.0:
            return np.zeros(0)
        # If two extremes have equal magnitude within rounding, begin at the positive one.
        size = np.abs(x)
        largest = np.flatnonzero(size >= size.max() * (1.0 - 1e-13))
        root = int(largest[np.argmax(x[largest])])
        return np.roll(turns, -root)


def bracketed_roots(function: Any, slope: Any, low: Floats, high: Floats) -> Floats:
    """Find a root of ``function``, with derivative ``slope``, in each bracket [low, high]."""
    low, high = low.copy(), high.copy()
    rising = function(high) > function(low)
    t = 0.5 * (low + high)
    for _ in range(80):
        value = function(t)
        beyond = (value > 0.0) == rising
        high, low = np.where(beyond, t, high), np.where(beyond, low, t)
        with np.errstate(divide="ignore", invalid="ignore"):
            step = value / slope(t)
        size = np.maximum(np.abs(t), 1.0)
        there = (np.abs(step) <= 4e-16 * size) | (value == 0.0)
        # A root at an end of its bracket may be outside within rounding.
        inside = (t - step > low - 1e-14 * size) & (t - step < high + 1e-14 * size)
        new = np.where(inside, np.clip(t - step, low, high), 0.5 * (low + high))
        new = np.where(there, t, new)
        converged = np.abs(new - t) <= 4e-16 * size
        t = new
        if converged.all():
            break
    return t


def _at_rest(law: Any, motion: _Motion) -> HarmonicForce:
    """Return force and Jacobian at a constant displacement: the limit of small cycles."""
    basis = motion.basis
    x = float(motion.at(np.zeros(1))[0])
    force, jacobian = np.zeros(basis.size), np.zeros((basis.size, basis.size))
    np.fill_diagonal(jacobian, law.tangential_stiffness)
    if basis.has_mean:
        place = np.array([abs(x)])
        force[0] = math.copysign(1.0, x) * float(law._backbone(place)[0])
        jacobian[0, 0] = float(law._slope(place)[0]) * motion.moves[0]
    return HarmonicForce(force, jacobian)


class _Piece(NamedTuple):
    """Monotone part of a cycle, with the displacements [m] at which it begins and ends.

    ``parent`` is the index of the turning point at which its branch began, and ``turn`` that of the
    turning point before it.
    """

    begin: float
    end: float
    parent: int
    turn: int


class _Cycle:
    """Branches of a settled cycle of a law, from the largest |displacement| on."""

    def __init__(self, law: Any, motion: _Motion) -> None:
        self.law, self.motion = law, motion
        self.times = motion.turns
        self.x = motion.at(self.times)
        self.sign = np.sign(np.roll(self.x, -1) - self.x)  # direction after each turning point
        self.changes = motion.directions(self.times)  # dx/dp at the turning points
        self.pieces = self._branches()

    def _branches(self) -> list[_Piece]:
        law, x, count = self.law, self.x, self.x.size
        half, stack = np.array([abs(x[0])]), [0]
        self.force = np.empty(count)
        self.derivative = np.empty((count, self.motion.basis.size))
        self.force[0] = math.copysign(1.0, x[0]) * float(law._backbone(half)[0])
        self.derivative[0] = float(law._slope(half)[0]) * self.changes[0]
        pieces = []
        for turn in range(count):
            here, end, sign = float(x[turn]), float(x[(turn + 1) % count]), self.sign[turn]
            if turn:
                stack.append(turn)
            while len(stack) > 2 and (end - x[stack[-2]]) * sign >= 0.0:
                close = float(x[stack[-2]])
                if (close - here) * sign > 0.0:
                    pieces.append(_Piece(here, close, stack[-1], turn))
                    here = close
                del stack[-2:]
            parent = stack[-1]
            if (end - here) * sign > 0.0:
                pieces.append(_Piece(here, end, parent, turn))
            if turn + 1 < count:
                half = np.array([0.5 * abs(end - x[parent])])
                rise = 2.0 * sign * float(law._backbone(half)[0])
                self.force[turn + 1] = self.force[parent] + rise
                slope = float(law._slope(half)[0])
                change = self.changes[turn + 1] - self.changes[parent]
                self.derivative[turn + 1] = self.derivative[parent] + slope * change
        return pieces

    def _cut(self) -> tuple[Floats, Floats, Any]:
        """Return the pieces, cut at the kinks of the law: begin and end [rad], (parent, turn)."""
        kinks = self.law._kinks
        begin, end, parent, turn = (np.array(v) for v in zip(*self.pieces, strict=True))
        sign = self.sign[turn]
        marks, owner = [begin, end], [np.arange(begin.size)] * 2
        if kinks.size:
            origin = self.x[parent]
            low = np.searchsorted(kinks, 0.5 * np.abs(begin - origin), side="right")
            high = np.searchsorted(kinks, 0.5 * np.abs(end - origin), side="left")
            counts = np.maximum(high - low, 0)
            of = np.repeat(np.arange(begin.size), counts)
            index = low[of] + np.arange(of.size) - np.repeat(np.cumsum(counts) - counts, counts)
            marks.append(origin[of] + 2.0 * sign[of] * kinks[index])
            owner.append(of)
        x, of = np.concatenate(marks), np.concatenate(owner)
        order = np.lexsort((x * sign[of], of))
        x, of = x[order], of[order]
        # Turning points are known; other times are solved for.
        first = self.times[turn[of]]
        last = np.roll(self.times, -1)[turn[of]]
        last = np.where(last <= first, last + 2.0 * math.pi, last)
        t = np.where(x == self.x[turn[of]], first, last)
        inner = np.flatnonzero((x != self.x[turn[of]]) & (x != np.roll(self.x, -1)[turn[of]]))
        if inner.size:
            target = x[inner]
            t[inner] = bracketed_roots(
                lambda s: self.motion.at(s) - target,
                lambda s: self.motion.at(s, 1),
                first[inner],
                last[inner],
            )
        inside = np.flatnonzero((np.diff(of) == 0) & (np.diff(t) > 0.0))
        return t[inside], t[inside + 1], np.column_stack((parent[of[inside]], turn[of[inside]]))

    def coefficients(self, tolerance: float, least: float) -> HarmonicForce:
        """Return coefficients and Jacobian; bisect pieces until their integrals have converged."""
        size = self.motion.basis.size
        begin, end, of = self._cut()
        total, slopes = np.zeros(size), np.zeros((size, size))
        force_scale = max(float(np.abs(self.force).max()), least, 1e-200)
        coarse = self._integrals(begin, end, of)
        stiff = float(np.abs(coarse[1]).sum(axis=0).max())
        stiff = max(stiff / (2.0 * math.pi), float(np.abs(self.derivative).max()), 1e-200)
        for _ in range(_LEVELS):
            middle = 0.5 * (begin + end)
            ends = np.column_stack((begin, middle)), np.column_stack((middle, end))
            low, high, owners = ends[0].ravel(), ends[1].ravel(), np.repeat(of, 2, axis=0)
            halves = self._integrals(low, high, owners)
            sums = [v.reshape(begin.size, 2, *v.shape[1:]).sum(axis=1) for v in halves]
            off = np.maximum(
                np.abs(sums[0] - coarse[0]).max(axis=1) / (tolerance * force_scale),
                np.abs(sums[1] - coarse[1]).max(axis=(1, 2)) / (100.0 * tolerance * stiff),
            )
            good = (off <= 0.1) | (end - begin <= 1e-13)
            total += sums[0][good].sum(axis=0)
            slopes += sums[1][good].sum(axis=0)
            if good.all():
                break
            rough = np.repeat(~good, 2)
            begin, end, of = low[rough], high[rough], owners[rough]
            coarse = tuple(v[rough] for v in halves)
            if begin.size > _MAX_PIECES:
                raise InputError(
                    f"`rtol` must be larger for this law, which needs more than {_MAX_PIECES} "
                    f"pieces of a cycle, got {tolerance:g}"
                )
        else:
            total, slopes = total + coarse[0].sum(axis=0), slopes + coarse[1].sum(axis=0)
        factors = self.motion.basis.factors
        slopes += self._jumps()
        return HarmonicForce(factors * total, factors[:, None] * slopes)

    def _integrals(self, begin: Floats, end: Floats, of: Any) -> tuple[Floats, Floats]:
        """Return integrals of basis functions times force, and times dforce/dc, for each piece.

        The pieces, cut at the kinks, are from ``begin`` to ``end`` [rad]. The columns of ``of`` are
        their ``parent`` and ``turn``, see :class:`_Piece`. c are the displacement coefficients.
        """
        parent, turn = of[:, 0], of[:, 1]
        width = end - begin
        t = begin[:, None] + width[:, None] * _SHARES
        weights = width[:, None] * _SHARE_WEIGHTS
        flat, shape = t.ravel(), t.shape
        x = self.motion.at(flat).reshape(shape)
        half = 0.5 * np.abs(x - self.x[parent, None])
        value = self.law._backbone(half.ravel()).reshape(shape)
        slope = self.law._slope(half.ravel()).reshape(shape)
        force = self.force[parent, None] + 2.0 * self.sign[turn, None] * value
        functions = self.motion.basis.values(flat).reshape(*shape, -1)
        change = functions * self.motion.moves - self.changes[parent, None, :]
        derivative = self.derivative[parent, None, :] + slope[:, :, None] * change
        weighted = weights[:, :, None] * functions
        return (
            np.einsum("pnj,pn->pj", weighted, force),
            np.matmul(weighted.transpose(0, 2, 1), derivative),
        )

    def _jumps(self) -> Floats:
        size = self.motion.basis.size
        if math.isfinite(self.law.tangential_stiffness):
            return np.zeros((size, size))
        jump = 2.0 * self.sign * float(self.law._backbone(np.array([5e-324]))[0])
        moved = -self.motion.directions(self.times, 1) / self.motion.at(self.times, 2)[:, None]
        return -np.asarray((self.motion.basis.values(self.times) * jump[:, None]).T @ moved)
