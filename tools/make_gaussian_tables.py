#!/usr/bin/env python3
"""Make microslip/_core/kernels/gaussian_moments.npy: Chebyshev series of scaled Gaussian moments.

The moments are F_n(h) = integral over u > h of (u - h)^n exp(-u^2/2)/sqrt(2 pi), n = -1/2 ... 5/2
(DLMF 12.5.1: Gamma(n+1)/sqrt(2 pi) exp(-h^2/4) D_{-n-1}(h)). Four pieces cover every h; on each a
smooth scaled function of t in [-1, 1] is interpolated at Chebyshev nodes with 40 digits:

    h < -10        F = |h|^n g,                              t = 200/h^2 - 1
    -10 <= h < -4  F = g,                                    t = (h + 7)/3
    -4 <= h < 0    F = g,                                    t = (h + 2)/2
    h >= 0         F = exp(-h^2/2) (h + 4)^(-n-1) g,         t = (h - 4)/(h + 4)

The file holds doubles by (order, piece, term), twice the order from -1 to 5, lowest term first.

Needs mpmath and NumPy. Usage: make_gaussian_tables.py [--check]
"""

import argparse
from pathlib import Path

import mpmath as mp
import numpy as np

mp.mp.dps = 40
TERMS = 30
TWICE_ORDERS = (-1, 0, 1, 2, 3, 4, 5)
ROOT = Path(__file__).parents[1]
TARGET = ROOT / "src/microslip/_core/kernels/gaussian_moments.npy"


def moment(n, h):
    """F_n(h) for moderate h, by the parabolic cylinder function."""
    return mp.gamma(n + 1) / mp.sqrt(2 * mp.pi) * mp.exp(-h * h / 4) * mp.pcfd(-n - 1, h)


def heavy(n, t):
    """F_n(h)/|h|^n as its series in z = 1/h^2; what it leaves out is of order exp(-50)."""
    z = (t + 1) / 200
    terms, k = [mp.mpf(1)], 0
    while True:
        k += 1
        new = terms[-1] * (n - 2 * k + 2) * (n - 2 * k + 1) / (2 * k) * z
        if abs(new) >= abs(terms[-1]) or abs(new) < mp.mpf(10) ** -30:
            return mp.fsum(terms)
        terms.append(new)


def light(n, t):
    """Scaled moment on [0, infinity); its end t = 1, h infinite, is never a node."""
    h = 4 * (1 + t) / (1 - t)
    with mp.workdps(60):
        return +(moment(n, h) * mp.exp(h * h / 2) * (h + 4) ** (n + 1))


PIECES = (
    heavy,
    lambda n, t: moment(n, 3 * t - 7),
    lambda n, t: moment(n, 2 * t - 2),
    light,
)


def chebyshev(function):
    """Interpolation coefficients at the first-kind nodes; the first one is already halved."""
    size = 48
    angles = [mp.pi * (j + mp.mpf(1) / 2) / size for j in range(size)]
    values = [function(mp.cos(a)) for a in angles]
    c = [
        2 * mp.fsum(v * mp.cos(k * a) for v, a in zip(values, angles, strict=True)) / size
        for k in range(size)
    ]
    c[0] /= 2
    dropped = mp.fsum(abs(v) for v in c[TERMS:]) / abs(min(values, key=abs))
    return c[:TERMS], dropped


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="compare with the file, write nothing")
    check = parser.parse_args().check
    series = np.empty((len(TWICE_ORDERS), len(PIECES), TERMS))
    for i, twice in enumerate(TWICE_ORDERS):
        n = mp.mpf(twice) / 2
        for j, piece in enumerate(PIECES):
            c, dropped = chebyshev(lambda t, n=n, piece=piece: piece(n, t))
            assert dropped < mp.mpf(10) ** -16, (twice, piece, mp.nstr(dropped, 3))
            print(twice, getattr(piece, "__name__", "?"), "dropped", mp.nstr(dropped, 3))
            series[i, j] = [float(v) for v in c]
    if check:
        same = np.array_equal(np.load(TARGET), series)
        raise SystemExit(0 if same else f"{TARGET.name} is not up to date")
    np.save(TARGET, series)


if __name__ == "__main__":
    main()
