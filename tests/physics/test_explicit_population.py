"""The explicit population by itself: each asperity against the equations of the chapter."""

import numpy as np
import pytest
from explicit_population import ExplicitPopulation

MU, LOAD, LIMIT = 0.55, 3.7, 2.3e-7
FRICTION = MU * LOAD


def single() -> ExplicitPopulation:
    return ExplicitPopulation([1e-7], [LOAD], [LIMIT], MU)


def many(count: int = 40) -> ExplicitPopulation:
    indentation = np.geomspace(1e-9, 1e-6, count)
    return ExplicitPopulation(indentation, 3e9 * indentation**1.5, 0.7 * indentation, MU)


# The chapter's formulas as printed, misprints mended, x = delta / delta_L and t = T / mu N.


def loading(x):  # (19.19), (19.15)
    return 1 - max(0, 1 - x) ** 1.5


def unloading(x, t_max, delta_0=0.0):  # (19.20); (19.23) with its offset; (19.16)
    return 2 * (max(0, 0.5 * (x + delta_0 + (1 - t_max) ** (2 / 3) + 1)) ** 1.5 - 1) + t_max


def reloading(x, minus_t, delta_0=0.0):  # (19.21), (19.17)
    return -2 * (max(0, -0.5 * (x - delta_0 - (1 - minus_t) ** (2 / 3) - 1)) ** 1.5 - 1) - minus_t


@pytest.mark.parametrize(
    ("a", "b", "c", "d"),
    [
        (0.6, -0.3, 0.4, -0.2),
        (0.6, 0.5, 0.58, 0.51),  # T_B > 0, where the printed max|T_id| fails
        (0.8, -0.75, -0.6, -0.7),  # T_C < 0
        (-0.0 + 0.95, -0.9, 0.9, -0.85),
    ],
)
def test_path_oabcd(a, b, c, d):
    joint = single()
    expected, got = [], []

    def go(start, stop, formula):
        for x in np.linspace(start, stop, 7)[1:]:
            got.append(joint.step(x * LIMIT) / FRICTION)
            expected.append(formula(x))
        return expected[-1]

    t_a = go(0.0, a, loading)
    t_b = go(a, b, lambda x: unloading(x, t_a))
    offset_b = b - (-1 + (1 + t_b) ** (2 / 3))  # (19.22)
    t_c = go(b, c, lambda x: reloading(x, -t_b, offset_b))
    offset_c = (1 - (1 - t_c) ** (2 / 3)) - c  # (19.24)
    go(c, d, lambda x: unloading(x, t_c, offset_c))
    assert np.sign(t_b) == np.sign(0.2 - (a - b))
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize("peak", [1.0, 1.4, 25.0])
def test_total_slip(peak):
    """(19.15)-(19.17): after sliding the loop shifts by delta_0 = delta_max - delta_L."""
    joint = single()
    x = np.concatenate([np.linspace(0, peak, 30), np.linspace(peak, -peak, 30)])
    x = np.concatenate([x, np.linspace(-peak, peak, 30)])
    delta_0 = peak - 1
    expected = np.concatenate(
        [
            [loading(v) for v in x[:30]],
            [unloading(v, 1.0, -delta_0) if v > delta_0 - 1 else -1 for v in x[30:60]],
            [reloading(v, 1.0, -delta_0) if v < 1 - delta_0 else 1 for v in x[60:]],
        ]
    )
    got = joint.force(x * LIMIT) / FRICTION
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-13 * peak)
    assert np.all(np.abs(got) <= 1 + 1e-15)


def test_states_differ_and_add():
    history = 1e-7 * np.array([1.0, -0.6, 0.8, -0.3, 0.5, 0.1, 0.4, 0.2, 0.35, 0.3, 0.31, -0.55, 4])
    joint = many()
    total = np.zeros_like(history)
    for load, limit in zip(joint.normal_loads, joint.slip_limits, strict=True):
        total += ExplicitPopulation([1.0], [load], [limit], MU).force(history)
    np.testing.assert_allclose(joint.force(history), total, rtol=0, atol=1e-14 * joint.force_limit)
    joint.force(history[:11])
    assert set(joint.open_reversals) >= {1, 2, 10}
    assert 0 < joint.has_slid.sum() < joint.contact_count
    assert joint.asperity_forces.sum() == pytest.approx(total[10], rel=1e-12, abs=0)
