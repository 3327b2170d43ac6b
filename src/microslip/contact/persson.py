"""Stiffness of an elastic face by its power spectrum, after Persson: the basis of rough faces."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from microslip._core.checks import LARGEST, Floats, floats, plain, positive, positives
from microslip._core.errors import InputError
from microslip._core.frozen import assign, lock
from microslip._core.quadrature import gauss_legendre
from microslip.contact.materials import MaterialPair

_STORED = 0.45  # Persson's gamma: share of the elastic energy of full contact that is stored
_END = 6.6  # beyond, exp(-x^2) is no part of anything
_PIECE = 10  # nodes between two points of the spectrum
_MOST_PIECES = 400
_BEARING = 3.3  # share of the heights that the load stands on, over Persson's contact share
_BY_TAIL = 0.9  # power of the ratio of mean heights above, fitted to boundary elements
_FEWEST = 20  # heights in a mean


@lru_cache(maxsize=1)
def _erf2_to_end() -> Floats:
    """Chebyshev series over 0 ... _END of the integral of erf^2(y) exp(-y^2)/y from x on."""
    from scipy.special import erf

    def over_x(t: Any) -> Any:
        x = 0.5 * _END * (t + 1.0)
        return np.asarray(erf(x) ** 2 * np.exp(-x * x) / np.where(x > 0.0, x, 1.0))

    falling = -np.asarray(chebyshev.chebint(chebyshev.chebinterpolate(over_x, 90), scl=0.5 * _END))
    falling[0] -= chebyshev.chebval(1.0, falling)
    return lock(falling)


@dataclass(frozen=True, eq=False, repr=False)
class PerssonCurve:
    """Elastic half space pressed against a rough face that is known by its power spectrum.

    Parameters
    ----------
    pair : MaterialPair
        The two materials.
    wavenumber : ndarray
        Wavenumbers q [1/m] (2 pi over the wavelength), rising, from the longest wave to the
        shortest.
    spectrum : ndarray
        Power spectral density C(q) at these wavenumbers [m^4]. Its integral over the plane of
        wavenumbers is the mean square height. Interpolated linearly in logarithms.
    area : float
        Apparent area [m^2].
    heights : array_like, optional
        Heights of the face [m], of any shape and origin, which
        :meth:`stiffness_by_heights` compares with Gaussian ones.

    Notes
    -----
    Yang and Persson (2008), DOI 10.1088/0953-8984/20/21/215214: the mean separation under a
    pressure p, written here with v^2 the integral of q^3 C up to q,

    u(p) = 2 int dv/q(v) int_x^inf [gamma + 3 (1 - gamma) erf^2(y)] exp(-y^2) dy/y,
    x = p/(sqrt(pi) E* v),

    which has the same value without a root that is infinite at the longest wave. Separations are
    those of the mean planes, above zero.
    """

    pair: MaterialPair
    wavenumber: Floats
    spectrum: Floats
    area: float
    heights: Any = None

    def __post_init__(self) -> None:
        if self.heights is not None:
            heights = floats("heights", self.heights).ravel()
            if heights.size < 10 * _FEWEST or np.ptp(heights) == 0.0:
                raise InputError(
                    f"`heights` must be {10 * _FEWEST} or more that differ, got {heights.size}"
                )
            assign(self, heights=lock(np.sort(heights)))

    # -- the spectrum -----------------------------------------------------------------------------

    @cached_property
    def _nodes(self) -> tuple[Floats, Floats]:
        """Places v of an integral over it [m/m], and their weights over q [m]."""
        q, c = np.log(self.wavenumber), np.log(self.spectrum)
        count = max(-(-60 // (q.size - 1)), 1)
        if q.size > _MOST_PIECES:
            edges = np.linspace(q[0], q[-1], _MOST_PIECES + 1)
        else:
            edges = np.unique(np.concatenate(
                [np.linspace(a, b, count + 1) for a, b in pairwise(q)]
            ))  # fmt: skip
        ends = np.concatenate(([0.0], np.cumsum(self._between(edges[:-1], edges[1:], q, c))))
        v = np.sqrt(ends)
        share, weight = gauss_legendre(_PIECE)
        places = v[:-1, None] + np.diff(v)[:, None] * share
        # q(v) by Newton in each piece, where the spectrum is a power law.
        target = places**2 - ends[:-1, None]
        low, high = edges[:-1, None], edges[1:, None]
        at = low + (high - low) * target / (ends[1:, None] - ends[:-1, None])
        for _ in range(60):
            reached = self._between(np.broadcast_to(low, at.shape), at, q, c)
            slope = np.exp(4.0 * at + np.interp(at, q, c))
            new = np.clip(at - (reached - target) / slope, low, high)
            converged = np.abs(new - at).max() < 1e-15 * max(abs(q[0]), abs(q[-1]), 1.0)
            at = new
            if converged:
                break
        weights = 2.0 * np.diff(v)[:, None] * weight / np.exp(at)
        return places.reshape(-1), weights.reshape(-1)

    @staticmethod
    def _between(low: Floats, high: Floats, q: Floats, c: Floats) -> Floats:
        """Integral of q^3 C from low to high [-], logarithms within one piece of the spectrum."""
        middle = 0.5 * (low + high)
        piece = np.clip(np.searchsorted(q, middle) - 1, 0, q.size - 2)
        power = 4.0 + (c[piece + 1] - c[piece]) / (q[piece + 1] - q[piece])
        begin = c[piece] + (power - 4.0) * (low - q[piece]) + 4.0 * low
        width = power * (high - low)
        small = np.abs(width) < 1e-8
        ratio = np.where(small, 1.0 + 0.5 * width, np.expm1(width) / np.where(small, 1.0, width))
        return np.asarray(np.exp(begin) * (high - low) * ratio)

    @property
    def rms_slope(self) -> float:
        """Root mean square slope of the surface [-], that of its gradient."""
        q, c = np.log(self.wavenumber), np.log(self.spectrum)
        return math.sqrt(2.0 * math.pi * float(self._between(q[:-1], q[1:], q, c).sum()))

    # -- separation by pressure -------------------------------------------------------------------

    def separation(self, load: ArrayLike) -> Any:
        """Mean separation of the mean planes [m] under loads [N] of any shape."""
        from scipy.special import exp1

        loads = positives("load", load, "N")
        v, weights = self._nodes
        scale = math.sqrt(math.pi) * self.pair.composite_modulus * self.area
        series = _erf2_to_end()
        gaps = np.empty(loads.size)
        for start in range(0, loads.size, 256):
            part = slice(start, start + 256)
            x = loads.reshape(-1)[part, None] / (scale * v)
            partial = chebyshev.chebval(2.0 / _END * np.minimum(x, _END) - 1.0, series)
            far = x < 26.0
            log = np.where(far, exp1(np.where(far, x * x, 1.0)), 0.0)
            inner = 0.5 * _STORED * log
            inner += 3.0 * (1.0 - _STORED) * np.where(x < _END, partial, 0.0)
            gaps[part] = inner @ weights
        return plain(gaps.reshape(loads.shape))

    def stiffness(self, load: ArrayLike) -> Any:
        """Normal stiffness -dN/du [N/m] under loads [N] of any shape."""
        from scipy.special import erf

        loads = positives("load", load, "N")
        v, weights = self._nodes
        scale = math.sqrt(math.pi) * self.pair.composite_modulus * self.area
        x = loads.reshape(-1, 1) / (scale * v)
        stored = _STORED + 3.0 * (1.0 - _STORED) * erf(x) ** 2
        return plain(loads / ((stored * np.exp(-x * x)) @ weights).reshape(loads.shape))

    def contact_share(self, load: ArrayLike) -> Any:
        """Real over apparent area [-] at the shortest waves, under loads [N] of any shape."""
        from scipy.special import erf

        full = self.pair.composite_modulus * self.rms_slope / math.sqrt(2.0)
        loads = np.clip(floats("load", load, "N"), -LARGEST, LARGEST)
        return plain(np.asarray(erf(loads / self.area / full)))

    def stiffness_by_heights(self, load: float) -> float:
        """Factor [-] by which the stiffness under a load [N] is too large for the given heights.

        Of faces of one spectrum the stiffness under a light load goes as the pressure over the mean
        height of what stands above the bearing level, and the law has that of a Gaussian.
        """
        if self.heights is None:
            raise InputError("`heights` missing: give those of the face, heights=scan.heights")
        from scipy.special import ndtri

        share = _BEARING * self.contact_share(positive("load", load, "N", 100.0))
        ratio, count, spread = 1.0, self.heights.size, float(self.heights.std())
        for _ in range(12):  # what stands out further is steeper, so that less of it bears
            above = min(max(round(share / ratio * count), _FEWEST), count // 2)
            level, top = self.heights[-above - 1], self.heights[-above:]
            score = -float(ndtri(above / count))
            density = math.exp(-0.5 * score**2) / math.sqrt(2.0 * math.pi)
            gaussian = spread * (density * count / above - score)
            ratio = math.sqrt(ratio * max(float(top.mean() - level), 1e-9 * spread) / gaussian)
        return float(ratio**_BY_TAIL)
