"""Least squares with non-negative coefficients, by the Gram matrix, and profile intervals."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError
from scipy.linalg.lapack import dposv

from microslip._core.checks import Floats

_RIDGE = 1e-10
"""Ridge over the mean diagonal of the Gram matrix. It keeps nearly equal columns solvable."""
_SMALL = 1e-4
"""Gradient along a column of norm 1, in standard deviations of noise, that is not followed."""
_MOST_CHANGES = 20
"""Changes of the passive set per column until a search stops."""


class Cone(NamedTuple):
    """Quadratic g'Gg - 2 h'g with coefficients g >= 0, except those that are ``free`` in sign.

    ``gram`` is G, the Gram matrix of the design matrix; the right-hand side h is given separately.
    The columns of the design matrix have the norm 1, so that coefficients are comparable.
    """

    gram: Floats
    free: NDArray[np.bool_]


def cone_of(gram: Floats, free: NDArray[np.bool_]) -> Cone:
    """Return the quadratic of a Gram matrix, with a small ridge against nearly equal columns."""
    return Cone(gram + _RIDGE * np.trace(gram) / len(gram) * np.eye(len(gram)), free)


def _solve(matrix: Floats, right: Floats) -> Floats:
    _, x, info = dposv(matrix, right)
    if info == 0:
        return np.asarray(x)
    return np.asarray(np.linalg.lstsq(matrix, right, rcond=None)[0])


def minimum(cone: Cone, h: Floats, passive: NDArray[np.bool_] | None = None) -> Floats:
    """Return the coefficients at the minimum (Lawson and Hanson's method on the Gram matrix).

    Parameters
    ----------
    cone : Cone
        Gram matrix (n, n) and signs of the n coefficients.
    h : ndarray
        Right-hand side (n,).
    passive : ndarray of bool, optional
        Initial guess of the coefficients above zero, from the fit of a similar problem.
    """
    gram, free = cone
    size = h.size
    p = free.copy() if passive is None else passive | free
    g = np.zeros(size)
    tolerance = max(1e-12 * float(np.abs(h).max(initial=0.0)), _SMALL)
    barred = np.zeros(size, dtype=bool)
    for _ in range(_MOST_CHANGES * size):
        while True:
            at = np.flatnonzero(p)
            if not at.size:
                break
            s = _solve(gram[np.ix_(at, at)], h[at])
            wrong = (s <= 0.0) & ~free[at]
            if not wrong.any():
                g[:] = 0.0
                g[at] = s
                break
            old = g[at]
            with np.errstate(divide="ignore", invalid="ignore"):
                step = np.where(wrong, old / (old - s), np.inf)
            best = float(np.nanmin(step[wrong])) if np.isfinite(step[wrong]).any() else 0.0
            best = min(max(best, 0.0), 1.0)
            g[at] = old + best * (s - old)
            leaves = wrong & (step <= best * (1.0 + 1e-12) + 1e-300)
            leaves |= wrong & (old <= 0.0)
            g[at[leaves]] = 0.0
            p[at[leaves]] = False
        w = h - gram @ g
        w[p | barred] = -np.inf
        new = int(np.argmax(w))
        if not w[new] > tolerance:
            break
        p[new] = True
        at = np.flatnonzero(p)
        s = _solve(gram[np.ix_(at, at)], h[at])
        # A coefficient that rounding would remove again at once ends in a circle.
        if s[np.searchsorted(at, new)] <= 0.0:
            p[new] = False
            barred[new] = True
        else:
            barred[:] = False
    return g


class Path:
    """Minima of g'Gg - 2 (h - l c)'g over g >= 0 for increasing multipliers l >= 0 of c'g.

    They are piecewise linear in l. For the set P of coefficients that are positive, g = a - l b
    with G_PP a = h_P and G_PP b = c_P, where the subscript P selects rows and columns of that set.
    So both the rise of g'Gg - 2 h'g at a given l and the l at a given rise have a closed form.
    """

    def __init__(self, cone: Cone, h: Floats, g: Floats, c: Floats) -> None:
        self.cone, self.h, self.c, self.g = cone, h, c, g
        self.start = float(g @ (cone.gram @ g) - 2.0 * (h @ g))
        self.passive = (g > 0.0) | cone.free

    def until(self, level: float | None = None, value: float | None = None) -> tuple[float, float]:
        """Increase l until the objective has risen by ``level``, or c'g has decreased to ``value``.

        Return c'g and the rise there; minus infinity for c'g if rounding errors stop the search.
        """
        for tolerance in (0.0, 1e-3 * _SMALL, _SMALL):
            found = self._until(level, value, tolerance)
            if found is not None:
                return found
        return (-np.inf, level) if level is not None else (float(self.c @ self.g), 0.0)

    def _until(
        self, level: float | None, value: float | None, tolerance: float
    ) -> tuple[float, float] | None:
        """Follow the minima; None if equal columns enter and leave the set P without end."""
        (gram, free), h, c = self.cone, self.h, self.c
        p, at_l = self.passive.copy(), 0.0
        both, whole = np.column_stack((h, c)), np.zeros((h.size, 2))
        last = -1
        reached, rise = float(c @ self.g), 0.0
        for _ in range(4 * h.size):
            at = np.flatnonzero(p)
            if not at.size:
                return 0.0, max(rise, -self.start)
            try:
                ab = _solve(gram[np.ix_(at, at)], both[at])
            except LinAlgError:
                return None
            a, b = ab[:, 0], ab[:, 1]
            ca, cb, ha = float(c[at] @ a), float(c[at] @ b), float(h[at] @ a)
            base = -ha - self.start
            with np.errstate(divide="ignore", invalid="ignore"):
                leave = np.where((b > 0.0) & ~free[at], a / b, np.inf)
            leave[at == last] = np.inf
            whole[:] = 0.0
            whole[at] = ab
            w = both - gram @ whole
            with np.errstate(divide="ignore", invalid="ignore"):
                enter = np.where(w[:, 1] < 0.0, (w[:, 0] - tolerance) / w[:, 1], np.inf)
            enter[p] = np.inf
            if last >= 0:
                enter[last] = np.inf
            out, into = int(np.argmin(leave)), int(np.argmin(enter))
            ends = max(min(float(leave[out]), float(enter[into])), at_l)
            if level is not None:
                stop = np.sqrt(max(level - base, 0.0) / cb) if cb > 0.0 else np.inf
            else:
                stop = (ca - (value or 0.0)) / cb if cb > 0.0 else np.inf
            stop = max(float(stop), at_l)
            if stop <= ends or not np.isfinite(ends):
                if not np.isfinite(stop):
                    return reached, rise
                return ca - stop * cb, base + stop * stop * cb
            at_l = ends
            reached, rise = ca - ends * cb, base + ends * ends * cb
            if leave[out] <= enter[into]:
                last = int(at[out])
                p[last] = False
            else:
                last = into
                p[last] = True
        return None
