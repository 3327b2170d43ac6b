"""Many nodes on one load curve, in NumPy: part of :mod:`microslip.kernels.twin`.

All nodes go through a step together. Places (displacement over kappa) and steps (separations) count
from each node's own rest. The diagram of a node is a stack of rows, see
:func:`microslip.kernels.twin_diagram.step_front`, each with a mark: T/mu of the step that made it,
with the row reaching in to that step. Marks never change, also where a row is cut; at a held load
one difference of N then gives the value of a move.

The functions with a curve serve laws that no profile gives, too.
"""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from microslip.kernels.layout import Floats, Integers
from microslip.kernels.twin_losses import losses
from microslip.kernels.twin_profile import drops, loads

Bools = NDArray[np.bool_]


class ArrayCurve(Protocol):
    """A load curve, asked at many separations."""

    def drop(self, base: Floats, width: Floats) -> Floats:
        """N(b) - N(b + w)."""

    def load(self, step: Floats) -> tuple[Floats, Floats]:
        """N and -N'."""


class PanelCurve:
    """The curve of a profile."""

    def __init__(self, *profile: Any) -> None:
        self._profile = profile

    def drop(self, base: Floats, width: Floats) -> Floats:
        """N(b) - N(b + w)."""
        result = np.empty(base.size)
        drops(base, width, result, *self._profile)
        return result

    def load(self, step: Floats) -> tuple[Floats, Floats]:
        """N and -N'."""
        value, fall = np.empty(step.size), np.empty(step.size)
        loads(step, value, fall, *self._profile)
        return value, fall


def curve_of(*profile: Any) -> ArrayCurve:
    """The curve of a profile; to the twin any other curve may be given in its place."""
    return PanelCurve(*profile) if len(profile) > 1 else profile[0]


class Moves(NamedTuple):
    """One move of every node: rows that stay, front, D, kind, T/mu, and -N' by which it grows."""

    depth: Integers
    front: Floats
    density: Floats
    kind: Integers
    value: Floats
    fall: Floats


def fronts(
    step: Floats,
    place: Floats,
    rows: Floats,
    begin: Integers,
    depth: Integers,
    last_step: Floats,
    last_place: Floats,
) -> tuple[Integers, Floats, Floats, Integers]:
    """What ``step_front`` finds, for every node."""
    fall, move = last_step - step, place - last_place
    at = np.arange(step.size)
    sticks = np.abs(move) <= fall
    rising = ~sticks & (fall < 0.0)
    depth = depth.copy()

    def top(nodes: Integers) -> Floats:
        return np.asarray(rows[begin[nodes] + depth[nodes] - 1])

    lost = at[rising & (depth > 0)]
    while lost.size:
        lost = lost[top(lost)[:, 0] <= step[lost]]
        depth[lost] -= 1
        lost = lost[depth[lost] > 0]
    integral = np.zeros(step.size)
    inside = at[rising & (depth > 0)]
    end, density, beyond = top(inside).T
    integral[inside] = density * (end - step[inside]) + beyond
    equal = rising & (place == integral)
    sign = np.where(np.where(rising, place > integral, move > 0.0), 1.0, -1.0)
    q = np.where(rising, step, last_step)
    going = at[~sticks & ~equal & (depth > 0)]
    while going.size:
        end, density, beyond = top(going).T
        differs = density != sign[going]
        reach = np.divide(
            place[going] + sign[going] * step[going] - density * end - beyond,
            sign[going] - density,
            out=np.full(going.size, np.inf),
            where=differs,
        )
        ends_here = reach < end - 4e-16 * (np.abs(end) + np.abs(step[going]))
        q[going] = np.maximum(np.where(ends_here, reach, end), q[going])
        going = going[~ends_here]
        depth[going] -= 1
        going = going[depth[going] > 0]
    virgin = ~sticks & ~equal & (depth == 0)
    q = np.where(virgin, np.maximum(q, step + sign * place), q)
    share = np.divide(move, fall, out=np.zeros(step.size), where=fall > 0.0)
    kind = np.where(sticks, 0, np.where(equal, 2, 1))
    return depth, q, np.where(sticks, share, np.where(equal, 0.0, sign)), kind


def make_moves(
    curve: ArrayCurve,
    rest: Floats,
    rows: Floats,
    marks: Floats,
    begin: Integers,
    depth: Integers,
    last: tuple[Floats, Floats, Floats],
    step: Floats,
    place: Floats,
) -> Moves:
    """The moves from the ``last`` step, place and value; nothing is changed."""
    before = depth
    depth, front, density, kind = fronts(step, place, rows, begin, depth, *last[:2])
    width = np.maximum(front - step, 0.0)
    drop = curve.drop(rest + step, width)
    stuck, slipped = kind == 0, kind != 0
    value = np.where(stuck, last[2], 0.0) + density * drop
    over = np.flatnonzero(slipped & (depth > 0))
    if over.size:
        newest = begin[over] + depth[over] - 1
        row, mark = rows[newest], marks[newest]
        same_step = mark[:, 1] == step[over]
        cut = curve.drop(rest[over] + mark[:, 1], front[over] - mark[:, 1])
        value[over] = np.where(
            same_step,
            mark[:, 0] + (density[over] - row[:, 1]) * drop[over],
            value[over] + (mark[:, 0] - row[:, 1] * cut),
        )
    # Where it stays where it is, what last slipped would go on.
    top = rows[begin + np.maximum(before - 1, 0)]
    slid = (before > 0) & (np.abs(top[:, 1]) == 1.0)
    resting = stuck & ~(front > step)
    fall = curve.load(rest + np.where(resting & slid, top[:, 0], np.where(resting, step, front)))[1]
    fresh = stuck & ~resting
    fall = np.where(fresh, np.divide(drop, width, out=np.zeros_like(drop), where=fresh), fall)
    return Moves(depth, front, density, kind, value, fall)


def take_moves(
    rows: Floats,
    marks: Floats,
    begin: Integers,
    last_place: Floats,
    step: Floats,
    moves: Moves,
) -> Integers:
    """Make moves the diagrams, which need room for one more row; returns their depths."""
    depth = moves.depth.copy()
    new = np.flatnonzero(moves.front > step)
    outside = begin[new] + depth[new]
    row = rows[outside - 1]
    outer = np.where(depth[new] > 0, row[:, 1] * (row[:, 0] - moves.front[new]) + row[:, 2], 0.0)
    beyond = np.where(moves.kind[new] == 0, last_place[new], outer)
    rows[outside] = np.stack((moves.front[new], moves.density[new], beyond), axis=1)
    marks[outside] = np.stack((moves.value[new], step[new]), axis=1)
    depth[new] += 1
    return depth


# -- states ---------------------------------------------------------------------------------------


def field_try(
    place: Floats,
    step: Floats | None,
    rest: Floats,
    last_place: Floats,
    last_step: Floats,
    last_value: Floats,
    rows: Floats,
    marks: Floats,
    begin: Integers,
    depth: Integers,
    front: Floats,
    density: Floats,
    value: Floats,
    code: Integers,
    by_place: Floats,
    load: Floats | None,
    fall: Floats | None,
    by_step: Floats | None,
    *profile: Any,
) -> None:
    """A trial of every node; ``step`` is None where separations stay what they are.

    Rows and marks of node i begin at entry ``begin[i]`` and are ``depth[i]``. Written are what
    :func:`field_commit` needs (``front``, ``density``, ``value`` and ``code``, which is four times
    the rows that stay and the kind) and d(T/mu)/d(place); with steps N, -N' and d(T/mu)/d(step).
    """
    curve = curve_of(*profile)
    current = last_step if step is None else step
    last = last_step, last_place, last_value
    moves = make_moves(curve, rest, rows, marks, begin, depth, last, current, place)
    front[:], density[:], value[:] = moves.front, moves.density, moves.value
    code[:], by_place[:] = 4 * moves.depth + moves.kind, moves.fall
    if load is None or fall is None or by_step is None:
        return
    load[:], fall[:] = curve.load(rest + current)
    top = rows[begin + np.maximum(moves.depth - 1, 0), 1]
    slid = (moves.kind == 0) & ~(moves.front > current) & (moves.depth > 0) & (np.abs(top) == 1.0)
    by_step[:] = np.where(slid, top, moves.density) * (moves.fall - fall)


def field_commit(
    place: Floats,
    step: Floats | None,
    front: Floats,
    density: Floats,
    value: Floats,
    code: Integers,
    begin: Integers,
    room: Integers,
    last_place: Floats,
    last_step: Floats,
    last_value: Floats,
    rows: Floats,
    marks: Floats,
    depth: Integers,
) -> None:
    """Make a trial the state; every node needs ``room`` for the row that it adds."""
    current = last_step if step is None else step
    moves = Moves(code // 4, front, density, code % 4, value, front)
    depth[:] = take_moves(rows, marks, begin, last_place, current, moves)
    last_place[:], last_step[:], last_value[:] = place, current, value


def field_losses(
    place: Floats,
    step: Floats,
    rest: Floats,
    code: Integers,
    last_place: Floats,
    last_step: Floats,
    begin: Integers,
    depth: Integers,
    rules: Floats,
    rows: Floats,
    loss: Floats,
    coefficients: Floats,
    anchor: float,
    inverse_width: float,
    first: int,
) -> None:
    """What a trial loses in every node, over mu kappa."""
    for i in range(place.size):
        diagram = np.empty((depth[i] + 1, 3))
        diagram[:-1] = rows[begin[i] : begin[i] + depth[i]]
        losses(
            step[i : i + 1], place[i : i + 1], loss[i : i + 1], diagram, int(depth[i]),
            float(last_step[i]), float(last_place[i]), rules,
            coefficients, anchor - float(rest[i]), inverse_width, first,
        )  # fmt: skip
