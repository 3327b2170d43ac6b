"""The limit of the real area against a half space that feels all contacts at once."""

from __future__ import annotations

import pytest
from real_area import compare

from microslip.contact.validity import RULES


def test_the_limits_are_where_neighbours_begin_to_be_felt() -> None:
    """Small areas agree to the scatter of a few contacts; at the limits they are stiffer."""
    rule = next(rule for rule in RULES if rule.name == "real over apparent area")
    light, middle, heavy = compare(128, 4, 12, seed=3, loads=(0.001, 0.0055, 0.08))
    assert light["population area"] < 0.5 * rule.watch
    assert light["population ratio"] == pytest.approx(1.0, abs=0.2)
    assert middle["population area"] == pytest.approx(rule.watch, rel=0.2)
    assert 1.0 < middle["population ratio"] < 1.25
    assert heavy["population area"] == pytest.approx(rule.outside, rel=0.2)
    assert heavy["population ratio"] > 1.4
