"""Quantiles from few points: those of a smooth function, those of scatter, what is not known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm, qmc

from microslip.sweeps.quantiles import quantiles

SHARES = (0.05, 0.5, 0.95)


def scores(count: int, seed: int) -> np.ndarray:
    points = qmc.Sobol(2, scramble=True, rng=np.random.default_rng(seed)).random(count)
    return np.asarray(norm.ppf(points))


@pytest.mark.parametrize("seed", range(4))
def test_of_a_smooth_function_they_are_exact_within_their_error(seed: int) -> None:
    """A rising function of one sum of normals, whose quantiles are known."""
    some = scores(32, seed)
    total = some @ [0.8, 0.6]
    values = np.stack([total, np.exp(0.5 * total)], axis=1)
    middle, error = quantiles(some, values, scores(4096, 9), SHARES)
    wanted = np.stack([norm.ppf(SHARES), np.exp(0.5 * norm.ppf(SHARES))], axis=1)
    np.testing.assert_allclose(middle, wanted, rtol=0.02, atol=0.02)
    assert (np.abs(middle - wanted) < 4.0 * error + 0.01).all()


def test_scatter_keeps_its_own_quantiles_and_their_error() -> None:
    """What the inputs do not tell is not interpolated; the error is that of so many draws."""
    some, noise = scores(256, 1), np.random.default_rng(2).normal(size=(256, 1))
    middle, error = quantiles(some, noise, scores(4096, 9), SHARES)
    np.testing.assert_array_equal(middle[:, 0], np.quantile(noise[:, 0], SHARES))
    spread = np.sqrt(np.array(SHARES) * (1.0 - np.array(SHARES)) / 256) / norm.pdf(norm.ppf(SHARES))
    assert (error[:, 0] > 0.3 * spread).all()
    assert (error[:, 0] < 3.0 * spread).all()


def test_what_is_not_known_is_left_out_where_it_is_not() -> None:
    some = scores(32, 3)
    values = np.stack([some[:, 0], some[:, 0], np.full(32, np.nan)], axis=1)
    values[5, 1] = np.nan
    middle, _ = quantiles(some, values, scores(4096, 9), SHARES)
    np.testing.assert_allclose(middle[:, 0], middle[:, 1], atol=0.02)
    assert np.isnan(middle[:, 2]).all()
