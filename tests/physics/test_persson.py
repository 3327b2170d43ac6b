"""Persson's separation and stiffness: against the published form, each other, and limits."""

from __future__ import annotations

import math

import numpy as np
import pytest

import microslip as ms
from microslip.contact.persson import PerssonCurve

ALUMINIUM = ms.Material(69e9, 0.33)
PAIR = ms.MaterialPair(ALUMINIUM, ALUMINIUM)


def _self_affine(
    *, rms: float, hurst: float, longest: float, roll_off: float, shortest: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return wavenumbers and spectrum, even down to the roll-off, which falls from there."""
    q = 2.0 * math.pi / np.array([longest, roll_off, shortest])
    flat = math.pi * (q[1] ** 2 - q[0] ** 2)
    tail = 2.0 * math.pi * q[1] ** 2 * (1.0 - (q[2] / q[1]) ** (-2.0 * hurst))
    level = rms**2 / (flat + tail / (2.0 * hurst))
    return q, level * np.minimum((q / q[1]) ** (-2.0 - 2.0 * hurst), 1.0)


LAW = PerssonCurve(
    PAIR, *_self_affine(rms=5e-7, hurst=0.8, longest=2e-3, roll_off=5e-4, shortest=2e-5), 2e-4
)


def test_the_published_double_integral() -> None:
    """Yang and Persson's (2008) form over q with its w(q), in which no root was taken out."""
    law = LAW
    modulus = law.pair.composite_modulus
    q0, q1, q2 = (float(v) for v in law.wavenumber)
    level, fall = float(law.spectrum[0]), 3.6

    def density(q: float) -> float:
        return level * (q / q1) ** -fall if q > q1 else level

    def slope(q: float) -> float:
        first = level * (min(q, q1) ** 4 - q0**4) / 4.0
        return first + (0.0 if q <= q1 else level * q1**fall * (q**0.4 - q1**0.4) / 0.4)

    def inner(start: float) -> float:
        """Of the pressure, in its logarithm, by Gauss."""
        end = max(7.0, 2.0 * start)
        x, w = np.polynomial.legendre.leggauss(80)
        y = math.log(start) + 0.5 * (math.log(end) - math.log(start)) * (x + 1.0)
        from scipy.special import erf

        t = np.exp(y)
        part = (0.45 + 3.0 * 0.55 * erf(t) ** 2) * np.exp(-t * t)
        return float(0.5 * (math.log(end) - math.log(start)) * (w @ part))

    x, w = np.polynomial.legendre.leggauss(60)
    for pressure in (1e6, 1e7):
        total = 0.0
        for low, high in ((q0, q1), (q1, q2)):
            # The root at the longest wave: q - low goes with the square of the variable.
            t = 0.5 * (x + 1.0)
            q = low + (high - low) * t * t
            for place, weight, root in zip(q, w, t, strict=True):
                width = (math.pi * slope(place)) ** -0.5
                value = place**2 * density(place) * width * inner(width * pressure / modulus)
                total += 0.5 * weight * 2.0 * (high - low) * root * value
        # Gauss on either side of what is left of a logarithm.
        assert law.separation(pressure * law.area) == pytest.approx(
            math.sqrt(math.pi) * total, rel=1e-6
        )


def test_limits() -> None:
    """Light: N falls as exp(-d/u0), area 1.596 p/(E* h'); the spectrum holds its height."""
    loads = np.array([1e-4, 1e-3])
    d = LAW.separation(loads)
    assert LAW.contact_share(loads[0]) == pytest.approx(
        math.sqrt(8 / math.pi) * loads[0] / LAW.area / PAIR.composite_modulus / LAW.rms_slope,
        rel=1e-6,
    )
    # Persson (2007), DOI 10.1103/PhysRevLett.99.125502: u0 is some half of the rms height.
    assert 0.3 < (d[0] - d[1]) / math.log(10.0) / 5e-7 < 0.6
    twice = ms.MaterialPair(*[ms.Material(138e9, 0.33)] * 2)
    stiffer = PerssonCurve(twice, LAW.wavenumber, LAW.spectrum, LAW.area)
    np.testing.assert_allclose(stiffer.separation(2.0 * loads), d, rtol=1e-13)
    q, c = LAW.wavenumber, LAW.spectrum
    fine = np.geomspace(q[1], q[2], 200_001)
    power = np.exp(np.interp(np.log(fine), np.log(q), np.log(c)))
    whole = math.pi * c[0] * (q[1] ** 2 - q[0] ** 2)
    whole += float(np.sum(math.pi * np.diff(fine**2) * np.sqrt(power[1:] * power[:-1])))
    assert math.sqrt(whole) == pytest.approx(5e-7, rel=1e-6)


def test_stiffness_is_the_slope_of_the_separation() -> None:
    loads, step = np.geomspace(1.0, 1e4, 9), 1e-4
    d = [np.asarray(LAW.separation(loads * math.exp(s))) for s in (-step, step)]
    slope = 2.0 * step * loads / (d[0] - d[1])
    np.testing.assert_allclose(LAW.stiffness(loads), slope, rtol=1e-6)


def test_the_factor_of_heights_by_closed_forms() -> None:
    """None of Gaussian heights; of exponential ones the mean above any level is their scale."""
    from scipy.stats import norm

    points = (np.arange(200_000) + 0.5) / 200_000
    load = 500.0
    share = 3.3 * LAW.contact_share(load)

    def of(heights: np.ndarray) -> PerssonCurve:
        return PerssonCurve(PAIR, LAW.wavenumber, LAW.spectrum, LAW.area, heights=heights)

    assert of(norm.ppf(points)).stiffness_by_heights(load) == pytest.approx(1.0, abs=3e-3)
    # Of Gaussian heights by its own two numbers, where less bears by the ratio itself.
    found = of(-np.log(points)).stiffness_by_heights(load) ** (1.0 / 0.9)
    bears = share / found
    assert found == pytest.approx(
        1.0 / (norm.pdf(norm.isf(bears)) / bears - norm.isf(bears)), rel=5e-3
    )
    with pytest.raises(ms.InputError, match="heights must be 200 or more that differ, got 3"):
        of(np.arange(3.0))
    with pytest.raises(ms.InputError, match="heights missing"):
        LAW.stiffness_by_heights(load)
