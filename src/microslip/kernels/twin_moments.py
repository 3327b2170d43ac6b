"""Moments of the Gaussian in NumPy: part of :mod:`microslip.kernels.twin`."""

from __future__ import annotations

import math

import numpy as np

from microslip.kernels.layout import MOMENT_TERMS, Floats


def _chebyshev(c: Floats, t: Floats) -> Floats:
    b1, b2 = np.zeros_like(t), np.zeros_like(t)
    twice = 2.0 * t
    for coefficient in c[:0:-1]:
        b1, b2 = twice * b1 - b2 + coefficient, b1
    return np.asarray(t * b1 - b2 + c[0])


def _half_power(v: Floats, twice: int) -> Floats:
    if twice == -1:
        return 1.0 / np.sqrt(v)
    result = np.sqrt(v) if twice & 1 else np.ones_like(v)
    for _ in range(twice // 2):
        result = result * v
    return result


def gaussian_moment(h: Floats, out: Floats, coefficients: Floats, twice: int) -> None:
    """F_n(h) of the standard Gaussian with 2n = ``twice``; pieces as in make_gaussian_tables.py."""
    pieces = coefficients.reshape(4, MOMENT_TERMS)
    for mask, piece in (
        (h < -10.0, 0),
        ((h >= -10.0) & (h < -4.0), 1),
        ((h >= -4.0) & (h < 0.0), 2),
        ((h >= 0.0) & (h <= 1e3), 3),
    ):
        if not mask.any():
            continue
        v = h[mask]
        if piece == 0:
            z = 10.0 / v
            out[mask] = _half_power(-v, twice) * _chebyshev(pieces[0], 2.0 * z * z - 1.0)
        elif piece == 1:
            out[mask] = _chebyshev(pieces[1], (v + 7.0) / 3.0)
        elif piece == 2:
            out[mask] = _chebyshev(pieces[2], (v + 2.0) / 2.0)
        else:
            # exp(-h^2/2) with h = head + tail, head^2 exact: a rounded square would cost 1e-13.
            head = np.floor(v * 128.0 + 0.5) / 128.0
            tail = v - head
            decay = np.exp(-0.5 * head * head) * np.exp(-0.5 * tail * (v + head))
            r = 1.0 / (v + 4.0)
            out[mask] = decay * _half_power(r, twice + 2) * _chebyshev(pieces[3], (v - 4.0) * r)
    out[h > 1e3] = 0.0


def gaussian_moment_at(h: float, coefficients: Floats, twice: int) -> float:
    """F_n(h) at one h, in plain Python: arrays of one are slow."""
    if h > 1e3:
        return 0.0
    if h >= 0.0:
        r = 1.0 / (h + 4.0)
        piece, t = 3, (h - 4.0) * r
        head = math.floor(h * 128.0 + 0.5) / 128.0
        decay = math.exp(-0.5 * head * head) * math.exp(-0.5 * (h - head) * (h + head))
        scale = decay * r ** (0.5 * twice + 1.0)
    elif h >= -10.0:
        piece, t = (2, (h + 2.0) / 2.0) if h >= -4.0 else (1, (h + 7.0) / 3.0)
        scale = 1.0
    else:
        piece, t = 0, 200.0 / (h * h) - 1.0
        scale = (-h) ** (0.5 * twice)
    first = piece * MOMENT_TERMS
    b1 = b2 = 0.0
    for c in coefficients[first + MOMENT_TERMS - 1 : first : -1].tolist():
        b1, b2 = 2.0 * t * b1 - b2 + c, b1
    return float(scale * (t * b1 - b2 + coefficients[first]))
