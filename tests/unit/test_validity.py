"""Verdicts on the assumptions of the model, one by one."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest
from real_area import compare

import microslip as ms
from microslip._core.verdicts import worst
from microslip.contact import Verdict
from microslip.contact.validity import RULES

DENSITY, AREA = 1e8, 2e-4  # 20 000 summits
STRAIN = "density * radius * std"
SHARE = "real over apparent area"
SPACING = "contact radius over summit spacing"
COUNT = "contacts"
PLASTICITY = "plasticity index"


def pair(hardness: float | None = None) -> ms.MaterialPair:
    metal = ms.Material(69e9, 0.33, hardness)
    return ms.MaterialPair(metal, metal)


def exponential(product: float, h: float, **changes: Any) -> ms.Interface:
    """Exponential heights, where everything judged has a closed form for h >= 0."""
    std, density = 5e-7, changes.pop("density", DENSITY)
    surface = ms.GreenwoodWilliamson(
        pair(changes.pop("hardness", None)),
        ms.Exponential(std),
        radius=product / (density * std),
        density=density,
        area=changes.pop("area", AREA),
    )
    return ms.Interface(surface, 0.5, separation=h * std)


def verdicts(joint: ms.Interface) -> dict[str, Verdict]:
    found = {verdict.name: verdict for verdict in joint.validity}
    assert len(found) == len(joint.validity)
    return found


# Each assumption with the joint that has a given value of it, and its two thresholds.
THRESHOLDS: dict[str, tuple[Callable[[float], ms.Interface], float, float]] = {
    STRAIN: (lambda product: exponential(product, 3.0), 0.1, 0.5),
    SHARE: (lambda share: exponential(share / math.pi * math.e, 1.0), 0.01, 0.1),
    SPACING: (lambda radius: exponential(radius**2, 2.0), 0.25, 0.5),
    COUNT: (lambda count: exponential(0.05, 0.0, area=count / DENSITY), 30.0, 10.0),
    PLASTICITY: (lambda index: exponential(0.05, 1.0, hardness=hardness_of(index)), 0.6, 1.0),
}


def hardness_of(index: float) -> float:
    """Return the hardness at which the joint of the test has this plasticity index."""
    surface = exponential(0.05, 1.0).surface
    slope = math.sqrt(5e-7 / surface.radius)  # type: ignore[attr-defined]
    return float(surface.pair.composite_modulus * slope / index)


@pytest.mark.parametrize("name", THRESHOLDS)
def test_words_change_at_the_thresholds(name: str) -> None:
    make, watch, outside = THRESHOLDS[name]
    worse = 1e-9 if outside > watch else -1e-9
    for threshold, words in ((watch, ("ok", "watch")), (outside, ("watch", "outside"))):
        for side, word in zip((1.0 - worse, 1.0 + worse), words, strict=True):
            verdict = verdicts(make(side * threshold))[name]
            assert verdict.value == pytest.approx(side * threshold, rel=1e-12, abs=0)
            assert (verdict.limit, verdict.word) == (watch, word)


def test_without_a_hardness_plasticity_is_not_judged() -> None:
    """A steel joint whose index would be 6.4 is no joint of which all assumptions hold."""
    steel = ms.Material(210e9, 0.3)
    surface = ms.GreenwoodWilliamson(
        ms.MaterialPair(steel, steel), ms.Gaussian(1e-6), radius=5e-5, density=1e9, area=1e-4
    )
    found = ms.Interface(surface, 0.5, 500.0).validity
    assert [v.word for v in found] == ["ok"] * 4 + ["not judged"]
    assert worst(found) == "not judged"
    verdict = found[-1]
    assert (verdict.name, verdict.value, verdict.limit) == (PLASTICITY, None, 0.6)
    assert "hardness" in verdict.reason
    known = [rule.judge(0.0 if rule.outside > rule.watch else 1e9) for rule in RULES]
    assert worst(known) == "ok"
    assert worst([*known, *found]) == "not judged"
    assert worst([]) == "not judged", "nothing holds of what nobody looked at"


def test_a_sphere_is_held_to_first_yield() -> None:
    """Hertz's pressure over 1.295 exp(0.736 nu) times the yield stress, by hand."""
    both = pair(1e9)
    joint = ms.Interface(ms.SphereOnFlat(both, 5e-3), 0.5, 100.0)
    modulus = both.composite_modulus
    pressure = (6.0 * 100.0 * modulus**2 / (math.pi**3 * 5e-3**2)) ** (1.0 / 3.0)
    yields = 1.295 * math.exp(0.736 * both.first.poisson_ratio) * 1e9 / 2.84
    (verdict,) = joint.validity
    assert verdict.value == pytest.approx(pressure / yields, rel=1e-12)
    assert verdict.word == "watch"
    assert joint.surface.hertz_pressure(joint.separation) == pytest.approx(pressure, rel=1e-12)  # type: ignore[attr-defined]
    (unknown,) = ms.Interface(ms.SphereOnFlat(pair(), 5e-3), 0.5, 100.0).validity
    assert unknown.word == "not judged"


def test_the_limits_are_where_neighbours_begin_to_be_felt() -> None:
    """Small areas agree to the scatter of a few contacts; at the limits they are stiffer."""
    rule = next(rule for rule in RULES if rule.name == SHARE)
    light, middle, heavy = compare(128, 4, 12, seed=3, loads=(0.001, 0.0055, 0.08))
    assert light["population area"] < 0.5 * rule.watch
    assert light["population ratio"] == pytest.approx(1.0, abs=0.2)
    assert middle["population area"] == pytest.approx(rule.watch, rel=0.2)
    assert 1.0 < middle["population ratio"] < 1.25
    assert heavy["population area"] == pytest.approx(rule.outside, rel=0.2)
    assert heavy["population ratio"] > 1.4
