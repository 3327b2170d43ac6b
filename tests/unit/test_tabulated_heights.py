"""Heights by a table of their density: moments against high precision, and what is refused."""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest
from usual import rough

import microslip as ms
from microslip.contact.heights.base import ORDERS


def exact(x: np.ndarray, f: np.ndarray, order: float, threshold: float) -> float:
    """Antiderivatives of each piece, in forty digits, which cancel but have enough of them."""
    with mp.workdps(60):
        xs, fs = [mp.mpf(float(v)) for v in x], [mp.mpf(float(v)) for v in f]
        t, n, total, whole = mp.mpf(threshold), mp.mpf(order), mp.mpf(0), mp.mpf(0)
        for a, b, left, right in zip(xs, xs[1:], fs, fs[1:], strict=False):
            whole += (b - a) * (left + right) / 2
            if b <= t or a == b:
                continue
            slope = (right - left) / (b - a)
            here = left + slope * (t - a)
            low, high = max(a, t) - t, b - t
            total += here * (high ** (n + 1) - low ** (n + 1)) / (n + 1)
            total += slope * (high ** (n + 2) - low ** (n + 2)) / (n + 2)
        return float(total / whole)


def tables() -> dict[str, tuple[np.ndarray, np.ndarray]]:
    rng = np.random.default_rng(1)
    uneven = np.cumsum(rng.random(30) ** 12) * 1e-7
    jumps = np.array([-3e-7, -1e-7, -1e-7, 1e-7, 2e-7])
    return {
        "ramp": (np.array([-1e-7, 3e-7]), np.array([0.0, 2.0])),
        "jumps": (jumps, np.array([1.0, 3.0, 0.5, 0.0, 2.0])),
        "triangle": (np.array([-4e-7, 1e-7, 3e-7]), np.array([0.0, 1e6, 0.0])),
        "gap": (np.arange(6) * 1e-7, np.array([1.0, 0.0, 0.0, 0.0, 2.0, 0.0])),
        "uneven": (uneven, rng.random(30)),
        "even": (np.linspace(-2e-6, 1e-6, 60), rng.random(60)),
    }


TABLES = tables()


@pytest.mark.parametrize("name", TABLES)
@pytest.mark.parametrize("order", ORDERS)
def test_moments_against_high_precision(name: str, order: float) -> None:
    """Asked: 1e-12; reached: rounding, and 2e-13 where widths differ by orders of magnitude."""
    x, f = TABLES[name]
    heights = ms.TabulatedHeights(x, f)
    low, high = heights.span
    width = high - low
    inner = low + width * np.array([1e-9, 0.01, 0.3, 0.55, 0.8, 0.99, 1.0 - 1e-9])
    below = low - width * np.array([0.0, 1e-6, 0.2, 3.0, 1e3, 1e5, 1e9])
    t = np.concatenate([inner, below, x[:-1][:: max(1, len(x) // 8)]])
    wanted = [exact(x, f, order, float(v)) for v in t]
    np.testing.assert_allclose(heights.partial_moment(order, t), wanted, rtol=5e-13)
    assert heights.partial_moment(order, high + 1e-7) == 0.0


@pytest.mark.parametrize("name", TABLES)
def test_mean_std_and_tails(name: str) -> None:
    x, f = TABLES[name]
    heights = ms.TabulatedHeights(x, f)
    low, high = heights.span
    first = exact(x, f, 1.0, low)
    second = exact(x, f, 2.0, low)
    assert heights.mean == pytest.approx(low + first, rel=1e-13, abs=1e-15 * (high - low))
    assert heights.spread == pytest.approx(math.sqrt(second - first**2), rel=1e-9)
    assert heights.top == high
    assert heights.edge == low
    y = np.linspace(low, high, 101)
    np.testing.assert_allclose(heights.cdf(y) + heights.probability_above(y), 1.0, rtol=1e-14)
    mirrored = ms.TabulatedHeights(-x[::-1], f[::-1])
    np.testing.assert_allclose(heights.cdf(y), mirrored.probability_above(-y), rtol=1e-12)
    assert heights.pdf(low - 1e-9) == heights.pdf(high + 1e-9) == 0.0
    integral = np.sum(np.diff(x) * (f[1:] + f[:-1])) / 2
    assert heights.integral == pytest.approx(integral, rel=1e-14)
    middle = 0.5 * (x[1:] + x[:-1])
    there = np.diff(x) > 0
    # In a narrow piece a rounding of the height is a change of the density.
    np.testing.assert_allclose(
        heights.pdf(middle[there]), (0.5 * (f[1:] + f[:-1]) / integral)[there], rtol=1e-7
    )


# -- from samples ----------------------------------------------------------------------------------


def long_tables() -> dict[str, tuple[np.ndarray, np.ndarray]]:
    rng = np.random.default_rng(0)
    x = np.linspace(0.0, 2e-6, 40)
    return {
        "sine": (x, np.sin(np.linspace(0.0, np.pi, 40))),
        "box": (x, np.ones(40)),
        "jumps": (np.sort(np.append(x, x[[13, 27]])), rng.uniform(0.2, 1.0, 42)),
        "jagged": (np.linspace(0.0, 2e-6, 200), rng.random(200)),
    }


LONG = long_tables()


@pytest.mark.parametrize("name", LONG)
def test_a_joint_on_a_long_table(name: str) -> None:
    surface = rough(ms.TabulatedHeights(*LONG[name]))
    for separation in (-1e-7, 6e-7, 1.4e-6):
        joint = ms.Interface(surface, 0.3, separation=separation)
        x = joint.force_limit / joint.tangential_stiffness * np.array([0.1, 0.5, 1.0, 3.0])
        there = surface.load(joint.separation + x / joint.slip_per_indentation)
        wanted = joint.friction_coefficient * (joint.normal_load - there)
        np.testing.assert_allclose(joint.backbone(x), wanted, rtol=1e-12)
        # The engine of varying loads goes run by run, cut at each knot that it passes.
        for a in x:
            lost = joint.coupled_response([a, -a, a], normal_load=joint.normal_load)
            cycle = lost.dissipated_energy[2] - lost.dissipated_energy[0]
            assert cycle == pytest.approx(joint.dissipated_energy(a), rel=1e-10)


# -- mistakes --------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", ["leaping", "of all sizes"])
def test_panels_are_bounded_and_not_only_heights(law: str) -> None:
    """Few heights whose steps leap by many powers of ten are refused; evenly made, they are not."""
    steps = {
        "leaping": np.tile([1e-6, 1e-15], 200),
        "of all sizes": 10.0 ** np.random.default_rng(1).uniform(-14.0, -6.0, 2000),
    }[law]
    height = np.append(0.0, np.cumsum(steps))
    density = np.random.default_rng(2).uniform(0.0, 1.0, height.size)
    with pytest.raises(ms.InputError, match=f"got {height.size} heights with steps from 1e-1") as e:
        ms.TabulatedHeights(height, density)
    assert "np.linspace(height[0], height[-1], 1000)" in str(e.value)
    new = np.linspace(height[0], height[-1], 1000)  # what the message says
    assert ms.TabulatedHeights(new, np.interp(new, height, density)).spread > 0.0
