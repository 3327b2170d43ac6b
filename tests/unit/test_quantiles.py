"""Quantiles from few points: those of a smooth function, those of scatter, what is not known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm, qmc

from microslip.sweeps.quantiles import intervals, quantiles, samples_for

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
    middle, half = quantiles(some, values, scores(4096, 9), SHARES)
    wanted = np.stack([norm.ppf(SHARES), np.exp(0.5 * norm.ppf(SHARES))], axis=1)
    np.testing.assert_allclose(middle, wanted, rtol=0.02, atol=0.02)
    assert (half < 0.1).all()


def test_scatter_keeps_its_own_quantiles_and_their_intervals() -> None:
    """What the inputs do not tell is not interpolated; the interval is that of so many draws."""
    some, noise = scores(256, 1), np.random.default_rng(2).normal(size=(256, 1))
    middle, half = quantiles(some, noise, scores(4096, 9), SHARES)
    np.testing.assert_array_equal(middle[:, 0], np.quantile(noise[:, 0], SHARES))
    spread = np.sqrt(np.array(SHARES) * (1.0 - np.array(SHARES)) / 256) / norm.pdf(norm.ppf(SHARES))
    assert (half[:, 0] > 0.8 * spread).all()
    assert (half[:, 0] < 5.0 * spread).all()
    # The smallest of 32 draws is below the 5 % quantile in 81 of 100 cases: no end of 90 %.
    few = np.random.default_rng(3).normal(size=(32, 1))
    half = quantiles(scores(32, 1), few, scores(4096, 9), SHARES)[1][:, 0]
    assert np.isinf(half[[0, 2]]).all()
    assert np.isfinite(half[1])


def answers(z: np.ndarray) -> np.ndarray:
    """A rising answer, one with a fold and a product, and one that jumps."""
    step = np.where(z[..., 0] + 0.3 * z[..., 1] > 1.2, 0.7, 0.0) + 0.2 * z[..., 2]
    bent = 0.3 * z[..., 0] - 0.2 * np.abs(z[..., 1] - 0.5) + 0.1 * z[..., 2] * z[..., 0]
    return np.stack([0.5 * z[..., 0] + 0.1 * z[..., 1:].sum(axis=-1), bent, step], axis=-1)


@pytest.mark.parametrize("quasi", [True, False])
@pytest.mark.parametrize("groups", [8, 1])
def test_intervals_hold_quantiles_in_ninety_of_a_hundred_cases(groups: int, quasi: bool) -> None:
    rng = np.random.default_rng(4)
    exact = np.quantile(answers(rng.normal(size=(1_000_000, 4))), SHARES, axis=0)
    inside = []
    for _ in range(150):
        points = [
            qmc.Sobol(4, scramble=True, rng=rng).random(512 // groups)
            if quasi
            else rng.random((512 // groups, 4))
            for _ in range(groups)
        ]
        low, high = intervals(answers(norm.ppf(np.array(points))), SHARES)
        inside.append((low <= exact) & (exact <= high))
    cover = np.mean(inside, axis=0)
    assert cover.mean() > 0.9
    assert cover.min() > 0.82  # three standard deviations of 150 cases below 0.9
    if not quasi or groups > 1:  # independent draws are no worse than they are
        assert cover.mean() < 0.975


def test_samples_for_a_wanted_error() -> None:
    assert samples_for(512, 0.03, 0.01) == 4608
    assert samples_for(512, 0.005, 0.01) == 512


def test_what_is_not_known_is_left_out_where_it_is_not() -> None:
    some = scores(32, 3)
    values = np.stack([some[:, 0], some[:, 0], np.full(32, np.nan)], axis=1)
    values[5, 1] = np.nan
    middle, _ = quantiles(some, values, scores(4096, 9), SHARES)
    np.testing.assert_allclose(middle[:, 0], middle[:, 1], atol=0.02)
    assert np.isnan(middle[:, 2]).all()
