"""Load levels: loads that count as one, and their labels."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from microslip.tribometer.folding import Folded

SAME_LOAD = 0.01
"""Loads that differ by no more than this share count as one."""
_DIGITS = 4
_CLOSE, _LARGEST = 1e-3, 4e-3
"""Shares of a load that came out of a channel which its name may leave out, by itself and by its
uncertainty; levels differ by more."""


def groups_of(values: Iterable[float]) -> list[list[float]]:
    """Rising values; those that differ from the first of a group by 1 % at most are in it."""
    groups: list[list[float]] = []
    for value in sorted(values):
        if groups and value <= groups[-1][0] * (1.0 + SAME_LOAD):
            groups[-1].append(value)
        else:
            groups.append([value])
    return groups


def levels_of(loads: Sequence[float | None]) -> list[int]:
    """Number of the load level of each record, from the lightest on; without a load the last."""
    groups = groups_of({load for load in loads if load is not None})
    level = {load: number for number, group in enumerate(groups) for load in group}
    return [len(groups) if load is None else level[load] for load in loads]


def labels_of(folded: Sequence[Folded], levels: Sequence[int]) -> dict[int, str]:
    """The load of each level [N], with as few digits as its uncertainty allows."""
    labels = {}
    for level in sorted(set(levels)):
        of_level = [folded[i] for i, number in enumerate(levels) if number == level]
        loads = [record.normal_load for record in of_level if record.normal_load is not None]
        if not loads:
            continue
        mean = float(np.mean(loads))
        error = max(record.load_error for record in of_level)
        room = min(max(3.0 * error, _CLOSE * abs(mean)), _LARGEST * abs(mean)) if error else 0.0
        texts = [f"{mean:.{digits}g}" for digits in range(1, _DIGITS + 1)]
        near = (text for text in texts if abs(float(text) - mean) <= room)
        labels[level] = f"{float(next(near, texts[-1])):g}"
    return labels
