"""Rows of memory diagrams: what they are worth along a record, and how a step adds to them."""

from __future__ import annotations

from typing import Any

import numpy as np

from microslip.kernels.layout import Floats, Integers


def values_along(
    tree: tuple[Floats, Floats, Floats, Integers],
    top: Integers,
    codes: Integers,
    drop: Floats,
    before: Floats,
    accumulate: Any,
) -> tuple[Floats, Floats]:
    """Values at the samples, and of the rows at the end, from those ``before`` the record."""
    value = tree[2] * drop
    base = before if before.size else np.zeros(1)
    accumulate(tree[3], value, base)
    padded = np.append(value, 0.0)  # so that -1 is the empty diagram
    old = base[-2 - np.minimum(codes, -2)]
    ends = np.where(codes >= 0, padded[np.maximum(codes, 0)], old)
    at_start = base[-2 - np.minimum(top, -2)]
    return np.where(top >= -1, padded[np.maximum(top, -1)], at_start), ends


def push(
    stack: Floats,
    values: Floats,
    depth: int,
    separation: float,
    front: float,
    density: float,
    kind: int,
    value: float,
    outer: float,
    last_place: float,
) -> int:
    """Make a step the diagram; returns how many rows it has then."""
    beyond = 0.0
    if depth:
        end, old, outer_integral = stack[depth - 1].tolist()
        beyond = old * (end - front) + outer_integral
        values[depth - 1] = outer
    if front > separation:
        stack[depth] = front, density, last_place if kind == 0 else beyond
        values[depth] = value
        depth += 1
    return depth
