"""A joint of which a profile, or no more than skewness and kurtosis of the heights, is known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

import microslip as ms
from microslip.heights.by_moments import heights_by_moments
from microslip.scans import random_surface
from microslip.scans.joints import profile_joint, rough_of_profile

STEEL = ms.Material(210e9, 0.3)
PAIR = ms.MaterialPair(STEEL, STEEL)


@pytest.mark.parametrize(
    ("known", "rel"),
    [
        (stats.norm(), 0.01),
        (stats.gamma(4.0), 0.01),
        (stats.uniform(), 0.01),
        (stats.beta(2.0, 5.0), 0.01),
        (stats.lognorm(0.3), 0.07),
        (stats.t(9.0), 0.06),
    ],
)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_two_moments_measure_the_peaks(known: object, rel: float, sign: float) -> None:
    """Mean height above the bearing level, which verdicts use, of distributions of other kinds."""
    skew, excess = (float(x) for x in known.stats("sk"))  # type: ignore[attr-defined]
    found = heights_by_moments(sign * skew, 3.0 + excess)
    shares = (np.arange(400_000) + 0.5) / 400_000
    true = np.sort(sign * known.ppf(shares))  # type: ignore[attr-defined]
    for share in (0.3, 0.1, 0.03, 0.01):
        above = []
        for heights in (found, true):
            top = heights[-round(share * heights.size) :]
            above.append((top.mean() - top[0]) / heights.std())
        assert above[0] == pytest.approx(above[1], rel=rel if sign > 0.0 else 2.5 * rel)


def test_no_heights_have_such_moments() -> None:
    with pytest.raises(ms.InputError, match="must be above 1 \\+ skewness"):
        heights_by_moments(1.0, 2.0)
    with pytest.raises(ms.InputError, match="skewness must be at least -1"):
        heights_by_moments(-1.5, 7.0)


@pytest.mark.slow
@pytest.mark.parametrize(("m4", "seed"), [(1.5e8, 4), (4e8, 4)])
def test_a_profile_of_an_isotropic_face(m4: float, seed: int) -> None:
    """Against boundary elements of another face of the same statistics, at two loads."""
    moments = {"m0": 2.5e-13, "m2": 4e-3, "m4": m4}
    lines = random_surface((256, 2048), 1e-6, **moments, seed=seed + 10).heights
    face = random_surface((256, 256), 1e-6, **moments, seed=seed)
    modulus = PAIR.composite_modulus * math.sqrt(2.0 * 4e-3)
    for share in (3e-3, 3e-2):
        solved = ms.MeasuredContact(face, PAIR, None, share * modulus, area=1e-4, piece=None)
        load = 0.999 * share * modulus * 1e-4
        true = solved.stiffness(solved.separation(load))
        laws = [rough_of_profile(ms.Scan(line, 1e-6), PAIR, 1e-4) for line in lines[::64]]
        logs = np.log([law.stiffness(law.separation(load)) / true for law in laws])
        assert abs(logs.mean()) < 0.2
        assert abs(logs).max() < 0.4


def test_how_far_a_profile_tells_its_stiffness() -> None:
    """The standard error by pieces against that of many profiles, and what is refused."""
    lines = random_surface((1024, 1024), 1e-6, m0=2.5e-13, m2=4e-3, m4=1.5e8, seed=5).heights
    found = [
        profile_joint(ms.Scan(line, 1e-6), {}, PAIR, 500.0, 1e-4, 0.3, None) for line in lines[::64]
    ]
    logs = [math.log(one.laws["rough"].tangential_stiffness) for one in found]
    told = math.sqrt(np.mean([(one.scatter or 0.0) ** 2 for one in found]))
    assert told == pytest.approx(float(np.std(logs, ddof=1)), rel=0.6)
    wave = ms.Scan(np.sin(np.arange(512) * 2.0 * np.pi / 32.0) * 1e-7, 1e-6)
    with pytest.raises(ms.InputError, match="waves are all of one length"):
        rough_of_profile(wave, PAIR, 1e-4)
    with pytest.raises(ms.InputError, match='area="2 cm\\^2" goes with a profile'):
        profile_joint(wave, {}, PAIR, 500.0, None, 0.3, None)
