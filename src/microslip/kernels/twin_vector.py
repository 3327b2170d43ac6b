"""Sliders in two directions, in NumPy: part of :mod:`microslip.kernels.twin`.

A slider holds a vector g, which follows every step of the place as long as its size stays within a
radius; where it would not, the slider slips along g. Radii go with the normal load: that of slider
k is ``tops[k]`` less the separation, none where that is negative, and changes evenly along a step,
which is a straight line. While g slips, with f its angle to the step and x the way made,

    df = -sin f dx / r(x),    tan(f/2) = tan(f0/2) exp(-integral of dx/r):

at a held load g runs along a tractrix, and however long the step this end is exact. The way to
where it begins to slip is the root of a quadratic.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from microslip.kernels.layout import Floats, Integers


def _mean_inverse(z: Any) -> tuple[Any, Any]:
    """ln(1 + z)/z and its derivative."""
    small = np.abs(z) < 1e-3
    w = np.where(small, 1.0, z)
    near = 1.0 - z * (0.5 - z * (1.0 / 3.0 - z * (0.25 - z * 0.2)))
    mean = np.where(small, near, np.log1p(w) / w)
    bend = -0.5 + z * (2.0 / 3.0 - z * (0.75 - z * 0.8))
    return mean, np.where(small, bend, (1.0 / (1.0 + w) - mean) / w)


def _slips(
    a: Floats, b: Floats, length: Floats, first: Floats, last: Floats
) -> tuple[Floats, Floats]:
    """Ends (2, n) of sliders that slip in the frame of the step, with derivatives (2, 5, n).

    (a, b) is where they are, a along the step; the columns are a, b, length, first and last radius.
    """
    rise = last - first
    square, half = length * length - rise * rise, a * length - first * rise
    inside = np.minimum(a * a + b * b - first * first, 0.0)
    root = np.sqrt(np.maximum(half * half - square * inside, 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        early = np.where(half + root > 0.0, -inside / (half + root), 0.0)
        late = np.where(square > 0.0, (root - half) / square, 0.0)
    time = np.clip(np.where(half >= 0.0, early, late), 0.0, 1.0)
    begin, radius, remaining = a + time * length, first + time * rise, 1.0 - time
    z = (last - radius) / radius
    mean, bend = _mean_inverse(z)
    way = length * remaining * mean / radius
    fade = np.exp(-np.minimum(way, 745.0)) * (way < 700.0)
    c, s = begin / radius, b / radius
    ahead, behind = np.maximum(1.0 + c, 0.0), np.maximum(1.0 - c, 0.0) * fade * fade
    total = ahead + behind
    against = ~(total > 0.0)  # straight against the step, where it turns neither way
    total = np.where(against, 1.0, total)
    share = 2.0 * fade / total
    cosine, sine = np.where(against, -1.0, (ahead - behind) / total), s * share
    ends = last * np.stack((cosine, sine))
    grip = begin * length - radius * rise
    zero, unity = np.zeros_like(a), np.ones_like(a)
    by = np.stack((begin, b, time * begin, -radius * remaining, -radius * time))
    dt = -np.divide(by, grip, out=np.zeros_like(by), where=grip > 0.0)
    dbegin = length * dt + np.stack((unity, zero, time, zero, zero))
    dradius = rise * dt + np.stack((zero, zero, zero, remaining, time))
    db, dlast = np.stack((zero, unity, zero, zero, zero)), np.stack((zero, zero, zero, zero, unity))
    dlength = np.stack((zero, zero, remaining, zero, zero))
    dangle = (begin * db - b * dbegin) / (radius * radius)
    dz = (dlast - (1.0 + z) * dradius) / radius
    dway = mean * (dlength - length * dt) / radius - way * dradius / radius
    dway = dway + length * remaining * bend * dz / radius
    dend = np.where(against, 0.0, share * dangle - sine * dway)
    slopes = np.stack((
        dlast * cosine - last * sine * dend, dlast * sine + last * cosine * dend
    ))  # fmt: skip
    return ends, slopes


def _presses(vectors: Floats, first: Floats, last: Floats) -> tuple[Floats, Floats]:
    """Ends (2, n) of sliders whose radius alone presses them in, as :func:`moves` has them."""
    size = np.hypot(*vectors)
    e = vectors / size
    radius = np.minimum(size, first)
    mean, _ = _mean_inverse((last - radius) / radius)
    share = np.divide(radius - last, first - last, out=np.zeros_like(last), where=first > last)
    across = np.eye(2)[:, :, None] - e[:, None] * e[None]
    jacobian = np.zeros((2, 6, size.size))
    jacobian[:, :2] = last / size * across
    jacobian[:, 2:4] = last * share * mean / radius * across
    jacobian[:, 5] = e
    return last * e, jacobian


def moves(vectors: Floats, step: Floats, first: Floats, last: Floats) -> tuple[Floats, Floats]:
    """Where sliders (2, n) go with steps (2, n), and how that depends on what came in (2, 6, n).

    Columns: by both parts of ``vectors`` and of ``step``, and by the first and the last radius.
    """
    n = vectors.shape[1]
    to, jacobian = np.zeros((2, n)), np.zeros((2, 6, n))
    length = np.hypot(*step)
    touches, vectors = last > 0.0, np.where(first > 0.0, vectors, 0.0)
    new = np.flatnonzero(touches & ~(first > 0.0))  # contact begins on the way
    if new.size:
        rise, far = last[new] - first[new], length[new]
        sticks = far <= rise
        e = np.divide(step[:, new], far, out=np.zeros((2, new.size)), where=far > 0.0)
        share = last[new] / rise
        to[:, new] = np.where(sticks, step[:, new] * share, last[new] * e)
        for i in range(2):
            for k in range(2):
                across = (i == k) - e[i] * e[k]
                slid = last[new] / np.where(sticks, 1.0, far) * across
                jacobian[i, 2 + k, new] = np.where(sticks, (i == k) * share, slid)
            jacobian[i, 4, new] = np.where(sticks, step[i, new] * share / rise, 0.0)
            late = step[i, new] * (1.0 - share) / rise
            jacobian[i, 5, new] = np.where(sticks, late, e[i])
    old = touches & (first > 0.0)
    end = vectors + step
    sticks_on = old & (end[0] ** 2 + end[1] ** 2 <= last * last)
    # At its bound by rounding, what does not move holds.
    sticks_on |= old & (length == 0.0) & (np.hypot(*end) <= last * (1.0 + 1e-14))
    to[:, sticks_on] = end[:, sticks_on]
    for i in range(2):
        jacobian[i, i, sticks_on] = jacobian[i, 2 + i, sticks_on] = 1.0
    pressed = np.flatnonzero(old & ~sticks_on & (length == 0.0))
    if pressed.size:
        to[:, pressed], jacobian[:, :, pressed] = _presses(
            vectors[:, pressed], first[pressed], last[pressed]
        )
    slid = np.flatnonzero(old & ~sticks_on & (length > 0.0))
    if slid.size:
        far = length[slid]
        e = step[:, slid] / far
        n_ = np.stack((-e[1], e[0]))
        a, b = (e * vectors[:, slid]).sum(axis=0), (n_ * vectors[:, slid]).sum(axis=0)
        (along, across), slopes = _slips(a, b, far, first[slid], last[slid])
        to[:, slid] = along * e + across * n_
        swing = slopes[:, 0] * b - slopes[:, 1] * a + np.stack((-across, along))
        by_parts = e[:, None] * slopes[0] + n_[:, None] * slopes[1]  # (2, 5, n)
        turned = (e * swing[0] + n_ * swing[1]) / far
        jacobian[:, :2, slid] = by_parts[:, :1] * e[None] + by_parts[:, 1:2] * n_[None]
        jacobian[:, 2:4, slid] = by_parts[:, 2:3] * e[None] + turned[:, None] * n_[None]
        jacobian[:, 4:, slid] = by_parts[:, 3:]
    return to, jacobian


def vector_try(
    place: Floats,
    step: Floats | None,
    last_place: Floats,
    last_step: Floats,
    vectors: Floats,
    tops: Floats,
    weights: Floats,
    new: Floats,
    value: Floats,
    tangent: Floats,
) -> None:
    """A trial of nodes that share the sliders: what they hold then, their sums and tangents.

    Places are (nodes, 2), ``vectors`` and ``new`` (nodes, sliders, 2), ``value`` (nodes, 2), and
    ``tangent`` (nodes, 2, 3) by both parts of the place and by the step, which is a separation;
    where that is None all separations stay what they are, and the last column is none.
    """
    nodes, sliders = last_step.size, tops.size
    current = last_step if step is None else step
    move = (place - last_place).reshape(nodes, 1, 2)
    steps = np.broadcast_to(move, (nodes, sliders, 2)).reshape(-1, 2).T
    first = (tops - last_step[:, None]).reshape(-1)
    last = (tops - current[:, None]).reshape(-1)
    to, jacobian = moves(vectors.reshape(-1, 2).T, steps, first, last)
    new.reshape(-1, 2)[:] = to.T
    value.reshape(nodes, 2)[:] = (to.reshape(2, nodes, sliders) @ weights).T
    sums = jacobian.reshape(2, 6, nodes, sliders) @ weights
    out = tangent.reshape(nodes, 2, 3)
    out[:, :, :2] = sums[:, 2:4].transpose(2, 0, 1)
    out[:, :, 2] = 0.0 if step is None else -sums[:, 5].T


def vector_cycle(
    place: Floats,
    step: Floats,
    rest: Floats,
    samples: int,
    tops: Floats,
    weights: Floats,
    by_place: Floats,
    places: int,
    by_step: Floats,
    steps: int,
    limit: int,
    small: float,
    value: Floats,
    slopes: Floats,
    passes: Integers,
) -> None:
    """Settled cycles of nodes that share the sliders, with derivatives along directions.

    Places are (nodes, samples, 2), steps (nodes, samples), from ``rest`` (nodes). A cycle begins
    where step + |place| is largest, with a straight path from rest, and is passed until its values
    change by no more than
    ``small``, or ``limit`` times: then ``passes`` is negative. Slopes are (nodes, samples, 2, 2
    places + steps): by the directions ``by_place`` (samples, places) of each part of the place, and
    ``by_step`` (samples, steps) of the separation.
    """
    nodes, sliders, columns = passes.size, tops.size, 2 * places + steps
    x, d = place.reshape(nodes, samples, 2), step.reshape(nodes, samples)
    u, v = by_place.reshape(samples, places), by_step.reshape(samples, steps)
    values, out = value.reshape(nodes, samples, 2), slopes.reshape(nodes, samples, 2, columns)
    for i in range(nodes):
        root = int(np.argmax(d[i] + np.hypot(x[i, :, 0], x[i, :, 1])))
        vectors, by = np.zeros((2, sliders)), np.zeros((2, columns, sliders))
        last, last_x, last_d = -1, np.zeros(2), float(rest[i])
        passes[i] = -limit
        for turn in range(limit):
            before = values[i].copy()
            for k in range(samples):
                t = (root + k) % samples
                move = np.broadcast_to((x[i, t] - last_x)[:, None], (2, sliders))
                vectors, jacobian = moves(vectors, move, tops - last_d, tops - d[i, t])
                values[i, t] = vectors @ weights
                if columns:
                    way = u[t] - (u[last] if last >= 0 else 0.0)
                    turned = np.einsum("irs,rcs->ics", jacobian[:, :2], by)
                    for r in range(2):
                        at = slice(r * places, (r + 1) * places)
                        turned[:, at] += jacobian[:, 2 + r, None] * way[:, None]
                    before_step = v[last] if last >= 0 else np.zeros(steps)
                    turned[:, 2 * places :] -= jacobian[:, 4, None] * before_step[:, None]
                    turned[:, 2 * places :] -= jacobian[:, 5, None] * v[t][:, None]
                    by = turned
                    out[i, t] = by @ weights
                last, last_x, last_d = t, x[i, t], float(d[i, t])
            if turn and np.abs(values[i] - before).max() <= small:
                passes[i] = turn + 1
                break


def slip_losses(vectors: Floats, step: Floats, radii: Floats) -> Floats:
    """What sliders lose at held radii, over their stiffness: arrays (nodes, sliders).

    From where it begins to slip, over the length x, the slider loses the integral of r cos f dx,
    which is r^2 ln(sin f0 / sin f1).
    """
    length = np.hypot(step[:, 0], step[:, 1])[:, None]
    e = np.divide(step, length, out=np.zeros_like(step), where=length > 0.0)[:, None]
    a = (vectors * e).sum(axis=2)
    b = vectors[:, :, 1] * e[:, :, 0] - vectors[:, :, 0] * e[:, :, 1]
    r = np.where(radii > 0.0, radii, 1.0)
    slides = (radii > 0.0) & (length > 0.0) & ((a + length) ** 2 + b * b > r * r)
    begin = np.sqrt(a * a - np.minimum(a * a + b * b - r * r, 0.0))
    way = np.where(slides, np.clip((length - (begin - a)) / r, 0.0, None), 0.0)
    c, fade = begin / r, np.exp(-np.minimum(way, 700.0))
    # ln((1 + c + (1 - c) fade^2)/2) without a loss of digits where the way is short
    closing = np.log1p(-0.5 * (1.0 - c) * (1.0 - fade) * (1.0 + fade))
    return np.asarray(np.where(slides, r * r * np.maximum(way + closing, 0.0), 0.0))
