"""Groups of values that are measured as equal."""

from __future__ import annotations

from collections.abc import Iterable

SAME = 0.01
"""Relative difference up to which values, such as normal loads, are taken for one."""


def groups_of(values: Iterable[float]) -> list[list[float]]:
    """Return rising values in groups, each within 1 % above the first of its group."""
    groups: list[list[float]] = []
    for value in sorted(values):
        if groups and value <= groups[-1][0] * (1.0 + SAME):
            groups[-1].append(value)
        else:
            groups.append([value])
    return groups
