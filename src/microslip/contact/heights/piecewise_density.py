"""Partial moments of a density that is linear between the points of a table."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip._core.quadrature import gauss_legendre

Panels = tuple[Floats, Floats, Floats]
"""Knots [m], and the density [1/m] at the left and at the right end of each piece between them."""

_TERMS = 26  # of a series: what is left out falls like 3.7^-k
_NODES = np.cos(math.pi * (np.arange(_TERMS) + 0.5) / _TERMS)
_TO_SERIES = np.linalg.inv(chebyshev.chebvander(_NODES, _TERMS - 1)).T
_OCTAVES_BELOW = 12  # octaves below the span that have panels
_BLOCK = 1 << 16  # pieces times thresholds a pass


def piece_moment(
    twice: int, low: Floats, high: Floats, width: Floats, left: Floats, right: Floats
) -> Floats:
    """Return the integral of s^(twice/2) p(s) over low <= s <= high.

    s is the height above the threshold [m], and p the density [1/m], linear in s: ``left`` at
    ``low`` and ``right`` at ``high``. ``width`` is high - low, passed separately because the
    difference of the limits loses digits.
    """
    nodes, weights = gauss_legendre((twice + 5) // 2)
    first = np.sqrt(low)
    roots = first + np.sqrt(high)
    reach = np.divide(width, roots, out=np.zeros_like(roots), where=roots > 0.0)
    total = np.zeros_like(roots)
    for node, weight in zip(nodes, weights, strict=True):
        root = first + reach * node
        share = np.divide(node * (root + first), roots, out=np.zeros_like(roots), where=roots > 0.0)
        term = (left + (right - left) * share) * (2.0 * weight)
        for _ in range(twice + 1):
            term *= root
        total += term
    return np.asarray(total * reach)


def piece_moment_at(
    twice: int, low: float, high: float, width: float, left: float, right: float
) -> float:
    """Return :func:`piece_moment` of one piece in plain Python, faster than NumPy for one value."""
    first = math.sqrt(low)
    roots = first + math.sqrt(high)
    if roots == 0.0:
        return 0.0
    reach, total = width / roots, 0.0
    for node, weight in _pairs((twice + 5) // 2):
        root = first + reach * node
        share = node * (root + first) / roots
        total += weight * (left + (right - left) * share) * root ** (twice + 1)
    return 2.0 * total * reach


@lru_cache
def _pairs(count: int) -> list[tuple[float, float]]:
    nodes, weights = gauss_legendre(count)
    return list(zip(nodes.tolist(), weights.tolist(), strict=True))


def panels_of(knots: Floats, left: Floats, right: Floats, limit: int) -> Panels | None:
    """Divide the pieces of a density until each is at most twice as wide as the next one.

    Below the lowest height, panels of zero density are added, each twice as wide as the one above
    it. Return None if there would be more than ``limit`` panels.
    """
    while knots.size - 1 <= limit:
        width = np.diff(knots)
        wide = np.append(width[:-1] > 2.0 * width[1:] * (1.0 + 1e-12), False)
        middle = knots[:-1] + 0.5 * width
        wide &= (middle > knots[:-1]) & (middle < knots[1:])
        if not wide.any():
            break
        at = np.flatnonzero(wide)
        half = 0.5 * (left[at] + right[at])
        knots = np.insert(knots, at + 1, middle[at])
        right = np.insert(right, at, half)
        left = np.insert(left, at + 1, half)
    # Up to some spans below; beyond, all is summed.
    unit = float(knots[1] - knots[0])
    count = _OCTAVES_BELOW + max(0, math.ceil(math.log2(float(knots[-1] - knots[0]) / unit)))
    below = knots[0] - unit * (2.0 ** np.arange(count, 0.0, -1.0) - 1.0)
    if knots.size - 1 + count > limit:
        return None
    empty = np.zeros(count)
    return (
        np.concatenate([below, knots]),
        np.concatenate([empty, left]),
        np.concatenate([empty, right]),
    )


def direct(
    panels: Panels,
    twice: int,
    threshold: Floats,
    first: NDArray[np.intp],
    last: int | None = None,
) -> Floats:
    """Return moments of order ``twice``/2 above each threshold t [m], without a Chebyshev series.

    They are integrals of (z - t)^(twice/2) p(z) over z > t, summed over pieces first to last - 1.
    """
    knots, left, right = panels
    stop = left.size if last is None else last
    result = np.zeros(threshold.size)
    rows = max(1, _BLOCK // max(1, stop - int(first.min())))
    for start in range(0, threshold.size, rows):
        part = slice(start, start + rows)
        low = int(first[part].min())
        if low >= stop:
            continue
        distance = np.maximum(knots[None, low : stop + 1] - threshold[part, None], 0.0)
        terms = piece_moment(
            twice,
            distance[:, :-1],
            distance[:, 1:],
            np.diff(knots[low : stop + 1]),
            left[low:stop],
            right[low:stop],
        )
        terms[np.arange(low, stop) < first[part, None]] = 0.0
        result[part] = terms.sum(axis=1)
    return result


def far_series(panels: Panels) -> dict[int, Floats]:
    """Return Chebyshev series for the moments of distant heights, by twice the order.

    Each has the shape (panels, terms): a row holds the coefficients of the moment as a function of
    the threshold in a panel. Heights in that panel and in the next higher one are left out.
    """
    knots = panels[0]
    half = 0.5 * np.diff(knots)
    series = _beyond(panels, -1, knots[:-1, None] + half[:, None] * (1.0 + _NODES)) @ _TO_SERIES
    result = {-1: series}
    for twice in (1, 3, 5):
        # The derivative of the next order is this one times -n: from its value at the right end.
        inner = chebyshev.chebint(result[twice - 2], axis=1)[:, : _TERMS + 1]
        inner *= -0.5 * twice * half[:, None]
        inner[:, 0] += _beyond(panels, twice, knots[1:, None])[:, 0] - inner.sum(axis=1)
        result[twice] = inner
    return result


def _beyond(panels: Panels, twice: int, places: Floats) -> Floats:
    """Return moments of order ``twice``/2, as :func:`direct`, without the nearest two pieces.

    ``places`` are the thresholds [m], one row for each panel. The pieces of the density in the
    panel of a threshold and in the next higher one are left out. Neighbouring panels form blocks.
    Pieces farther above a block than half its width contribute one Chebyshev series in the
    threshold, valid in the whole block; the others are summed for each threshold.
    """
    knots = panels[0]
    count = knots.size - 1
    first = np.minimum(np.arange(count) + 2, count)
    result = np.empty(places.shape)
    size = max(1, math.isqrt(count))
    for start in range(0, count, size):
        block = slice(start, min(start + size, count))
        low, high = knots[block.start], knots[block.stop]
        first_far = int(np.searchsorted(knots, high + 0.5 * (high - low)))
        first_far = min(max(first_far, block.stop + 1), count)
        nodes = low + 0.5 * (high - low) * (1.0 + _NODES)
        far = direct(panels, twice, nodes, np.full(_TERMS, first_far)) @ _TO_SERIES
        t = places[block]
        near = direct(
            panels, twice, t.reshape(-1), np.repeat(first[block], t.shape[1]), first_far
        ).reshape(t.shape)
        result[block] = near + chebyshev.chebval(2.0 * ((t - low) / (high - low)) - 1.0, far)
    return result
