"""Height distributions: moments against other ways to them, and what they refuse."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from scipy import special, stats
from usual import rough

import microslip as ms

ORDERS = (-0.5, 0, 0.5, 1, 1.5, 2, 2.5)
S = 5e-7


# -- against scipy.stats ---------------------------------------------------------------------------

TWINS: dict[str, tuple[ms.HeightDistribution, Any]] = {
    "Gaussian": (ms.Gaussian(S), stats.norm(scale=S)),
    "shifted Gaussian": (ms.Gaussian(S, mean=-2e-6), stats.norm(-2e-6, S)),
    "Exponential": (ms.Exponential(S), stats.expon(scale=S)),
    "Statistical norm": (ms.Statistical(stats.norm(1e-7, S)), stats.norm(1e-7, S)),
    "Statistical Weibull": (
        ms.Statistical(stats.weibull_min(2.2, scale=S)),
        stats.weibull_min(2.2, scale=S),
    ),
    "Statistical uniform": (ms.Statistical(stats.uniform(-S, 3 * S)), stats.uniform(-S, 3 * S)),
    "Statistical skewed": (ms.Statistical(stats.skewnorm(4, scale=S)), stats.skewnorm(4, scale=S)),
}


@pytest.mark.parametrize("name", TWINS)
def test_probabilities(name: str) -> None:
    heights, twin = TWINS[name]
    y = twin.ppf([0.01, 0.2, 0.5, 0.9, 0.999])
    y = np.concatenate((y, [twin.mean() - 3 * S, twin.mean() + 3.9 * S]))
    # SciPy's own tails are right to 1e-12 or so.
    np.testing.assert_allclose(heights.pdf(y), twin.pdf(y), rtol=1e-12)
    np.testing.assert_allclose(heights.cdf(y), twin.cdf(y), rtol=0, atol=1e-11)
    np.testing.assert_allclose(heights.probability_above(y), twin.sf(y), rtol=1e-9, atol=1e-15)
    assert heights.spread == pytest.approx(twin.std(), rel=1e-12, abs=0)
    low, high = heights.span
    assert twin.cdf(low) < 1e-10
    assert twin.sf(high) < 1e-10


@pytest.mark.parametrize("h", [-30.0, -9.0, -3.0, -0.2, 0.0, 0.7, 6.0])
def test_gaussian_density_and_distribution(h: float) -> None:
    """(19.25) and (19.26), corrected, with a mean; the lower tail keeps its digits."""
    heights = ms.Gaussian(std=0.5, mean=2.0)
    with mp.workdps(40):
        y = 2 + mp.mpf(h) / 2
        density = mp.exp(-((y - 2) ** 2) / (2 * mp.mpf("0.25"))) / (
            mp.mpf("0.5") * mp.sqrt(2 * mp.pi)
        )
        below = mp.erfc(-(y - 2) / (mp.mpf("0.5") * mp.sqrt(2))) / 2
    # exp(-h^2/2) turns a rounding of h into h^2 times as much.
    tolerance = 1e-15 * (4.0 + h * h)
    assert heights.pdf(float(y)) == pytest.approx(float(density), rel=tolerance, abs=0)
    assert heights.cdf(float(y)) == pytest.approx(float(below), rel=tolerance, abs=0)


CLOSED: dict[str, tuple[Any, Callable[[float], float]]] = {
    # The moments about zero, where all of these begin.
    "Weibull": (stats.weibull_min(2.2, scale=S), lambda n: special.gamma(1 + n / 2.2)),
    "steep Weibull": (stats.weibull_min(0.8, scale=S), lambda n: special.gamma(1 + n / 0.8)),
    "gamma": (stats.gamma(3.5, scale=S), lambda n: special.gamma(3.5 + n) / special.gamma(3.5)),
    "Rayleigh": (stats.rayleigh(scale=S), lambda n: 2 ** (n / 2) * special.gamma(1 + n / 2)),
    "lognormal": (stats.lognorm(0.6, scale=S), lambda n: math.exp(0.5 * (0.6 * n) ** 2)),
    "half normal": (
        stats.halfnorm(scale=S),
        lambda n: 2 ** (n / 2) * special.gamma((n + 1) / 2) / math.sqrt(math.pi),
    ),
    "beta": (stats.beta(2, 3, scale=S), lambda n: special.beta(2 + n, 3) / special.beta(2, 3)),
    "uniform": (stats.uniform(0, S), lambda n: 1 / (1 + n)),
    "triangular": (stats.triang(1.0, scale=S), lambda n: 2 / (2 + n)),
    "Pareto": (stats.pareto(4, scale=S), lambda n: 4 / (4 - n)),
    "heavy Pareto": (stats.pareto(2.2, scale=S), lambda n: 2.2 / (2.2 - n)),
    "arcsine": (stats.arcsine(scale=S), lambda n: special.beta(n + 0.5, 0.5) / math.pi),
}


@pytest.mark.parametrize("name", CLOSED)
def test_moments_about_zero(name: str) -> None:
    distribution, moment = CLOSED[name]
    heights = ms.Statistical(distribution)
    for order in ORDERS:
        if order > -0.5 and order <= (1.5 if "heavy" in name else 9):
            value = heights.partial_moment(order, 0.0)
            assert value == pytest.approx(moment(order) * S**order, rel=1e-9, abs=0), order


# -- what they refuse ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "distribution",
    [stats.pareto(1.9, scale=S), stats.t(2.5, scale=S), stats.lognorm(1.5, scale=S),
     stats.levy_l(scale=S), stats.loglaplace(2, scale=S)],
    ids=["Pareto", "t", "lognormal", "lower tail", "log-Laplace"],
)  # fmt: skip
def test_heavy_tails_that_carry_a_load(distribution: Any) -> None:
    law = rough(distribution)
    loads = law.load(distribution.ppf([0.2, 0.5, 0.9]))
    assert np.all(np.isfinite(loads))
    assert np.all(np.diff(loads) < 0)
    assert 0.0 < law.heights.spread < math.inf  # also where the variance is infinite
