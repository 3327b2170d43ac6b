"""Quantiles from few points: those of a smooth function, those of scatter, what is not known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm, qmc

from microslip.friction.sweeps.quantiles import intervals, quantiles

SHARES = (0.05, 0.5, 0.95)


def scores(count: int, seed: int, inputs: int = 2) -> np.ndarray:
    points = qmc.Sobol(inputs, scramble=True, rng=np.random.default_rng(seed)).random(count)
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


def test_a_column_of_two_branches_is_not_interpolated_because_others_are_smooth() -> None:
    some = scores(64, 5)
    total = some @ [0.8, 0.6]
    branches = np.where(np.sin(4.0 * total) > 0.3, 1.0, 0.0) + 0.01 * total
    values = np.stack([3.0 * total, total, branches], axis=1)
    middle, half = quantiles(some, values, scores(4096, 9), SHARES)
    np.testing.assert_allclose(middle[:, 0], 3.0 * norm.ppf(SHARES), atol=0.05)
    np.testing.assert_array_equal(middle[:, 2], np.quantile(branches, SHARES))
    assert half[:, :2].max() < 0.2 < half[:, 2].max()


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


@pytest.mark.slow
def test_intervals_of_interpolated_quantiles() -> None:
    """Of smooth, bent and kinked answers at 32 and 64 points: they hold, and are not far too wide.

    Where the interpolation bends alike at all points, as at the median of a softplus, two of three.
    """

    def bend(x: np.ndarray) -> np.ndarray:
        return np.asarray(np.log1p(np.exp(3.0 * x)) / 3.0)

    answers = {
        2: [lambda z: bend(z[:, 0] + 0.4 * z[:, 1]), lambda z: np.log(0.2 + np.exp(z).sum(axis=1))],
        3: [
            lambda z: z @ [0.5, 0.3, 0.1],
            lambda z: np.exp(0.4 * z[:, 0] + 0.2 * z[:, 1]) + 0.1 * z[:, 2],
            lambda z: 0.4 * z[:, 0] + 0.2 * z[:, 1] * z[:, 2] + 0.1 * z[:, 1] ** 2,
            lambda z: 0.3 * z[:, 0] - 0.2 * np.abs(z[:, 1] - 0.5) + 0.1 * z[:, 2] * z[:, 0],
        ],
    }
    rng, cover, wide = np.random.default_rng(0), [], []
    for inputs, functions in answers.items():
        draws = rng.normal(size=(1_000_000, inputs))
        exact = np.array([np.quantile(f(draws), SHARES) for f in functions]).T
        for count in (32, 64):
            missed, told = [], []
            for seed in range(30):
                few = scores(count, 1000 + seed, inputs)
                many = [scores(1024, 10_000 + 8 * seed + group, inputs) for group in range(8)]
                values = np.stack([f(few) for f in functions], axis=1)
                middle, half = quantiles(few, values, np.concatenate(many), SHARES)
                missed.append(middle - exact)
                told.append(half)
            cover.append((np.abs(missed) <= told).mean(axis=0))
            wide.append(np.mean(told, axis=0) / np.sqrt(np.square(missed).mean(axis=0)))
    assert np.mean(np.concatenate([c.ravel() for c in cover])) > 0.9
    assert min(c.min() for c in cover) > 0.55
    assert np.median(np.concatenate([w.ravel() for w in wide])) < 3.2  # 1.65 of normal errors


def test_what_is_not_known_is_left_out_where_it_is_not() -> None:
    some = scores(32, 3)
    values = np.stack([some[:, 0], some[:, 0], np.full(32, np.nan)], axis=1)
    values[5, 1] = np.nan
    middle, _ = quantiles(some, values, scores(4096, 9), SHARES)
    np.testing.assert_allclose(middle[:, 0], middle[:, 1], atol=0.02)
    assert np.isnan(middle[:, 2]).all()
