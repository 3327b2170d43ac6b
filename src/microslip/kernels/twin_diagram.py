"""Memory diagrams in NumPy: part of :mod:`microslip.kernels.twin`."""

from __future__ import annotations

from typing import Any

import numpy as np

from microslip.kernels.layout import Floats, Integers
from microslip.kernels.rows import values_along
from microslip.kernels.twin_memory import accumulate
from microslip.kernels.twin_profile import drop_at, drops, load_at


def step_front(
    separation: float,
    place: float,
    stack: Any,
    depth: int,
    last_separation: float,
    last_place: float,
) -> tuple[int, float, float, int]:
    """What a straight step of (separation, place) makes of the diagram D(eta), eta >= separation.

    The diagram is piecewise constant (THEORY of memory diagrams: Aleshin and others): row k of
    ``stack``, counted from outside, is (end, D, integral of D beyond end), and reaches inwards to
    the end of the next row or to ``last_separation``; beyond row 0 D is 0. ``place`` is the
    integral of all D that the step must lead to.

    Returns how many rows stay, where the last of them then begins (q), the D that fills the rest
    down to ``separation``, and 0 where nothing has slipped, 1 where the front ran from
    ``last_separation`` out to q, 2 where D was only cut off at q.
    """
    fall, move = last_separation - separation, place - last_place
    if abs(move) <= fall:
        # The new contact sticks wholly; the old one goes with it.
        return depth, last_separation, move / fall if fall > 0.0 else 0.0, 0
    if fall >= 0.0:
        sign = 1.0 if move > 0.0 else -1.0
        q = last_separation
    else:
        while depth and stack[depth - 1][0] <= separation:
            depth -= 1
        integral = 0.0
        if depth:
            end, density, beyond = stack[depth - 1]
            integral = density * (end - separation) + beyond
        if place == integral:
            return depth, separation, 0.0, 2
        sign = 1.0 if place > integral else -1.0
        q = separation
    while depth:
        end, density, beyond = stack[depth - 1]
        if density != sign:
            front = (place + sign * separation - density * end - beyond) / (sign - density)
            # Nearer to the end of the row than rounding can tell, the row is used up.
            if front < end - 4e-16 * (abs(end) + abs(separation)):
                return depth, max(front, q), sign, 1
        q = max(end, q)
        depth -= 1
    return 0, max(separation + sign * place, q), sign, 1


def diagram(
    separation: Floats,
    place: Floats,
    base: Floats,
    width: Floats,
    density: Floats,
    parent: Integers,
    top: Integers,
    stack: Floats,
    codes: Integers,
    depth: int,
    last_separation: float,
    last_place: float,
) -> tuple[int, int, float, float]:
    """The diagrams of a record as a tree of rows, see :func:`step_front`.

    Row i of the tree begins at ``base[i]``, is ``width[i]`` wide, has the D ``density[i]`` and
    lies before row ``parent[i]``: an index, -1 for none, -2 - k for row k of the stack at the
    start. Sample j sees row ``top[j]`` and all before it. ``stack`` (capacity, 3) and ``codes``
    hold the diagram at the start and at the end.

    Returns the depth, the number of rows in the tree, and the last separation and place.
    """
    rows: list[tuple[float, float, float]] = [tuple(row) for row in stack[:depth].tolist()]
    names: list[int] = codes[:depth].tolist()
    tree: list[tuple[float, float, float, int]] = []
    for j, (d, x) in enumerate(zip(separation.tolist(), place.tolist(), strict=True)):
        depth, q, D, kind = step_front(d, x, rows, len(rows), last_separation, last_place)
        if depth:
            end, old, beyond = rows[depth - 1]
            outer = old * (end - q) + beyond
        else:
            outer = 0.0
        del rows[depth:], names[depth:]
        if depth and kind:
            names[-1] = len(tree)
            tree.append((q, end - q, old, names[-2] if depth > 1 else -1))
        if q > d:
            tree.append((d, q - d, D, names[-1] if depth else -1))
            rows.append((q, D, last_place if kind == 0 else outer))
            names.append(len(tree) - 1)
        top[j] = names[-1] if names else -1
        last_separation, last_place = d, x
    count, depth = len(tree), len(rows)
    if count:
        columns = zip(*tree, strict=True)
        for target, column in zip((base, width, density, parent), columns, strict=True):
            target[:count] = column
    if depth:
        stack[:depth] = rows
        codes[:depth] = names
    return depth, count, last_separation, last_place


def trace(
    separation: Floats,
    place: Floats,
    front: Floats,
    density: Floats,
    kind: Integers,
    parent: Integers,
    stack: Floats,
    codes: Integers,
) -> None:
    """What each step of a record from rest ends on: front, D and kind of :func:`step_front`.

    ``parent`` is the sample whose row the front lies in, -1 where it is beyond all rows; where a
    step sticks (kind 0) it is the sample before. Where nothing moves all is as a sample before.
    ``stack`` (samples, 3) and ``codes`` are room to work in.
    """
    rows: list[tuple[float, float, float]] = []
    names: list[int] = []
    last_separation = last_place = 0.0
    for i, (d, x) in enumerate(zip(separation.tolist(), place.tolist(), strict=True)):
        if i and (d, x) == (last_separation, last_place):
            for column in (front, density, kind, parent):
                column[i] = column[i - 1]
            continue
        depth, q, D, how = step_front(d, x, rows, len(rows), last_separation, last_place)
        outer = 0.0
        if depth:
            end, old, beyond = rows[depth - 1]
            outer = old * (end - q) + beyond
        front[i], density[i], kind[i] = q, D, how
        parent[i] = i - 1 if how == 0 else names[depth - 1] if depth else -1
        del rows[depth:], names[depth:]
        if q > d:
            rows.append((q, D, last_place if how == 0 else outer))
            names.append(i)
        last_separation, last_place = d, x


# -- with a load curve ----------------------------------------------------------------------------


def coupled_step(
    separation: float,
    place: float,
    stack: Any,
    values: Any,
    depth: int,
    last_separation: float,
    last_place: float,
    *profile: Any,
) -> tuple[int, float, float, int, float, float, float]:
    """A step as :func:`step_front` has it, with the value it leads to.

    ``values[k]`` is the integral of D (-N') from where row k begins. After what
    :func:`step_front` returns come the value at the end, the share of it that the rows which stay
    hold, and -dN/d(eta) where the front goes on.
    """
    depth, front, density, kind = step_front(
        separation, place, stack, depth, last_separation, last_place
    )
    outer = float(values[depth - 1]) if depth else 0.0
    if depth and kind:  # the last row that stays is cut
        end, old, _ = (float(v) for v in stack[depth - 1])
        outer = float(values[depth - 2]) if depth > 1 else 0.0
        outer = old * drop_at(front, end - front, *profile) + outer
    value, fall = outer, 0.0
    if front > separation:
        drop = drop_at(separation, front - separation, *profile)
        value = density * drop + outer
        fall = drop / (front - separation)
    if kind == 1:
        fall = load_at(front, *profile)[1]
    elif not front > separation:  # a move in the same direction goes on from where slip ended
        slipped = kind == 0 and depth and abs(stack[depth - 1][1]) == 1.0
        fall = load_at(float(stack[depth - 1][0]) if slipped else separation, *profile)[1]
    return depth, front, density, kind, value, outer, fall


def coupled(
    separation: Floats,
    place: Floats,
    value: Floats,
    stack: Floats,
    values: Floats,
    depth: int,
    last_separation: float,
    last_place: float,
    *profile: Any,
) -> tuple[int, float, float]:
    """Values T/mu along a record; ``stack`` (capacity, 3) and ``values`` are updated.

    Returns the depth, and the last separation and place.
    """
    n = separation.size
    base, width, density = np.empty(2 * n), np.empty(2 * n), np.empty(2 * n)
    parent, top = np.empty(2 * n, dtype=np.int64), np.empty(n, dtype=np.int64)
    codes = np.empty(depth + n, dtype=np.int64)
    codes[:depth] = -2 - np.arange(depth)
    before = values[:depth].copy()
    depth, count, last_separation, last_place = diagram(
        separation, place, base, width, density, parent, top, stack, codes, depth,
        last_separation, last_place,
    )  # fmt: skip
    drop = np.empty(count)
    drops(base[:count], width[:count], drop, *profile)
    tree = base[:count], width[:count], density[:count], parent[:count]
    value[:], values[:depth] = values_along(tree, top, codes[:depth], drop, before, accumulate)
    return depth, last_separation, last_place
