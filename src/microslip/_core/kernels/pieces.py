"""Decreasing convex functions N(x) as piecewise polynomials, smooth between given breaks.

On a piece that ends at x_r, N(x) = N(x_r) + z G(z), where z = (x_r - x)/width falls from 1 to 0
over the piece, and G/width is the mean of the slope -N' between x and x_r. G is a polynomial of z
or, next to a break, it may be a polynomial of sqrt(z).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev

from microslip._core import kernels
from microslip._core.checks import Floats
from microslip._core.frozen import Locked, lock
from microslip._core.kernels.table import NODES, TO_POWERS, TO_SERIES
from microslip._core.quadrature import gauss_legendre

_ROUNDING = 4e-15  # truncation error over the slope on a piece
_NOTHING = 2e-17  # truncation error over the load
_LEVELS = 60
_MOST_PIECES = 60_000
_EPS = 2.3e-16
_Y = 0.5 * (1.0 + NODES)
_SHARES, _WEIGHTS = gauss_legendre(16)


def _mean_matrix(roots: bool) -> Floats:
    """Return the matrix from Chebyshev coefficients of the slope to power coefficients of its mean.

    The slope is -N' on a piece as a function of z; G(z) is its mean over the part of the piece
    from its end, z = 0, to z. With ``roots`` both are series in sqrt(z) instead of z.
    """
    weights = 2.0 * _SHARES * _WEIGHTS if roots else _WEIGHTS
    places = 2.0 * _Y[:, None] * _SHARES - 1.0
    rows = [
        (chebyshev.chebval(places, np.eye(kernels.TERMS)[k]) @ weights) @ TO_SERIES
        for k in range(kernels.TERMS)
    ]
    return np.asarray(np.array(rows)[:, : kernels.TERMS] @ TO_POWERS, dtype=np.float64)


_MEANS = _mean_matrix(False), _mean_matrix(True)


@dataclass(frozen=True, eq=False)
class Pieces(Locked):
    """Decreasing convex function N(x), such as a load curve, or the force limit minus a backbone.

    Between ``breaks`` N is smooth, except that it may depend on the square root of the distance to
    the next break, as at the end of a contact of spheres. The slope -N' is sampled, and N is
    integrated from the last edge, so both are accurate relative to their value.
    """

    edges: Floats
    rows: Floats
    breaks: Floats

    @classmethod
    def sample(
        cls,
        fall: Callable[[Floats], Floats],
        load: Callable[[Floats], Floats],
        breaks: Floats,
        low: float,
        high: float,
        origin: float = 0.0,
        cuts: Floats | None = None,
    ) -> Pieces | None:
        """Sample N on [low, high]; return None if too many pieces are needed.

        ``fall`` computes -N' and ``load`` N. Pieces end at the ``breaks``, where N is not smooth,
        and at ``cuts``, further initial edges for N with several length scales. x is a position
        minus ``origin``; the rounding error of positions limits the resolution of x. Pieces are
        bisected until the truncation error is within rounding of -N', or negligible relative to N.
        """
        inner = breaks[(breaks > low) & (breaks < high)]
        edges = np.concatenate(([low], inner, [high]))
        if cuts is not None:
            edges = np.unique(np.append(edges, cuts[(cuts > low) & (cuts < high)]))
        begin, end = edges[:-1], edges[1:]
        ends_at_break = np.isin(end, inner) | (end == high)
        done: list[tuple[Floats, Floats, Floats, Floats]] = []
        for level in range(_LEVELS):
            width = end - begin
            plain = end[:, None] - width[:, None] * _Y
            rooted = end[:, None] - width[:, None] * _Y**2
            series, fits = _fit(fall, load, plain, begin, width, origin)
            takes_roots = np.zeros(begin.size, dtype=bool)
            retry = np.flatnonzero(~fits & ends_at_break)
            if retry.size:
                other, fitted = _fit(fall, load, rooted[retry], begin[retry], width[retry], origin)
                good = retry[fitted]
                series[good], takes_roots[good], fits[good] = other[fitted], True, True
            size = abs(origin) + np.maximum(np.abs(begin), np.abs(end))
            fits |= (width <= 8.0 * _EPS * size) | (level == _LEVELS - 1)
            done.append((begin[fits], end[fits], takes_roots[fits], series[fits]))
            rough = ~fits
            if not rough.any():
                break
            begin, end, last = begin[rough], end[rough], ends_at_break[rough]
            middle = 0.5 * (begin + end)
            begin, end = np.append(begin, middle), np.append(middle, end)
            ends_at_break = np.append(np.zeros(last.size, dtype=bool), last)
            if begin.size + sum(part[0].size for part in done) > _MOST_PIECES:
                return None
        begin, end, roots, series = (np.concatenate(part) for part in zip(*done, strict=True))
        order = np.argsort(begin)
        begin, end, roots, series = begin[order], end[order], roots[order] > 0, series[order]
        # Remove terms at rounding level, so that linear pieces stay linear.
        straight = np.abs(series[:, 1:]).max(axis=1) <= 8.0 * _EPS * np.abs(series[:, 0])
        means = [series[:, : kernels.TERMS] @ matrix for matrix in _MEANS]
        powers = np.where(roots[:, None], means[1], means[0]) * (end - begin)[:, None]
        powers[straight, 0], powers[straight, 1:] = (series[:, 0] * (end - begin))[straight], 0.0
        whole = powers.sum(axis=1)
        after = np.append(np.cumsum(whole[::-1])[::-1], 0.0) + float(load(np.array([high]))[0])
        rows = np.column_stack((after[1:], roots, 1.0 / (end - begin), whole, powers))
        return cls(
            lock(np.append(begin, end[-1])),
            lock(np.ascontiguousarray(rows)),
            lock(np.append(inner, high)),
        )

    @cached_property
    def arguments(self) -> tuple[Any, ...]:
        """Edges, coefficients and breaks: the arguments of kernels that compute harmonics."""
        return self.edges, self.rows, self.breaks


def _fit(
    fall: Callable[[Floats], Floats],
    load: Callable[[Floats], Floats],
    x: Floats,
    begin: Floats,
    width: Floats,
    origin: float,
) -> tuple[Floats, Any]:
    """Return Chebyshev series of -N' on pieces, one row each, and a mask of accurate pieces.

    ``x`` are the sampling points of each piece, shape (pieces, nodes), ``begin`` and ``width`` its
    lower end and its width. A piece is accurate if the truncation error of its series is within the
    rounding error of -N', or negligible relative to N.
    """
    values = fall(x.reshape(-1)).reshape(x.shape)
    series = values @ TO_SERIES
    left_out = np.abs(series[:, kernels.TERMS - 1 :]).max(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        steep = np.abs(np.diff(values, axis=1) / np.diff(x, axis=1))
    noise = 4.0 * _EPS * (abs(origin) + np.abs(x).max(axis=1)) * np.nan_to_num(steep).max(axis=1)
    resolved = left_out <= np.maximum(_ROUNDING * np.abs(values).max(axis=1), noise)
    resolved |= left_out * width <= _NOTHING * np.abs(load(begin))
    return series, resolved


def backbone_pieces(
    backbone: Callable[[Floats], Floats],
    slope: Callable[[Floats], Floats],
    kinks: Floats,
    limit: float,
    stiffness: float,
) -> Pieces | None:
    """Return ``limit`` - T0(u) for a backbone T0 [N], from u = 0 to full slip.

    ``limit`` [N] is the force at full slip, ``stiffness`` [N/m] the slope at u = 0, and ``kinks``
    [m] are the displacements where ``slope`` jumps. Returns None if T0 does not reach the limit at
    a finite displacement, to rounding, or if too many pieces are needed.
    """
    end = reach = limit / stiffness
    kinks = kinks[kinks > 0.0]
    if kinks.size:
        end = max(end, float(kinks[-1]))
    if not (math.isfinite(end) and end > 0.0):
        return None
    for _ in range(400):
        if float(slope(np.array([end * (1.0 + 1e-12)]))[0]) * end <= 1e-17 * limit:
            break
        end *= 1.5
    else:
        return None

    def left(u: Floats) -> Floats:
        return np.maximum(limit - backbone(u), 0.0)

    doublings = math.ceil(math.log2(end / reach))
    cuts = np.array([math.ldexp(reach, k) for k in range(doublings if doublings > 8 else 0)])
    return Pieces.sample(slope, left, kinks, 0.0, end, cuts=cuts)
