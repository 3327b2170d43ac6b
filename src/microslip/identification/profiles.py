"""Floor 6: how far each number can go before the data contradict it: likelihood profiles."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from microslip._checks import Floats
from microslip.identification.fit import Fit, bounds_of, settle
from microslip.identification.problem import Problem

_CLOSE = 0.01  # of the threshold, within which an end of an interval is found
_TRIES = 14


@dataclass(frozen=True)
class Interval:
    """Ends of a profile in a fitted coordinate; an end that is open is a bound."""

    low: float
    high: float
    low_open: bool
    high_open: bool
    at_low: Floats
    """All coordinates where the low end was found."""
    at_high: Floats


def information(problem: Problem, q: Floats) -> Floats:
    """Half the second derivatives of the sum of squares, after Gauss and Newton."""
    _, by = problem.residuals(q)
    return by.T @ by


def covariance_of(information: Floats) -> Floats:
    """Its inverse; very large where the data say nothing."""
    size = np.sqrt(np.diag(information))
    unknown = size == 0.0
    size[unknown] = 1.0
    scaled = information / np.outer(size, size)
    values, vectors = np.linalg.eigh(scaled)
    values = np.maximum(values, 1e-14)
    inverse = (vectors / values) @ vectors.T
    return np.asarray(inverse / np.outer(size, size))


def profile(
    problem: Problem, best: Fit, i: int, threshold: float, covariance: Floats
) -> tuple[Interval, Fit | None]:
    """The profile of coordinate ``i`` up to a rise ``threshold`` of the sum of squares.

    Also a better minimum, if the profile came upon one.
    """
    found: list[tuple[float, bool, Floats]] = []
    better: Fit | None = None
    for direction in (-1.0, 1.0):
        end, is_open, place, lower = _end(problem, best, i, direction, threshold, covariance)
        found.append((end, is_open, place))
        if lower is not None and (better is None or lower.cost < better.cost):
            better = lower
    (low, low_open, at_low), (high, high_open, at_high) = found
    return Interval(low, high, low_open, high_open, at_low, at_high), better


def _end(
    problem: Problem,
    best: Fit,
    i: int,
    direction: float,
    threshold: float,
    covariance: Floats,
) -> tuple[float, bool, Floats, Fit | None]:
    low, high = bounds_of(problem)
    bound = float(high[i] if direction > 0.0 else low[i])
    room = abs(bound - best.q[i])
    if room == 0.0:
        return bound, True, best.q, None
    error = math.sqrt(max(float(covariance[i, i]), 1e-300))
    along = covariance[:, i] / max(float(covariance[i, i]), 1e-300)
    others = np.delete(np.arange(best.q.size), i)
    goal = math.sqrt(threshold)

    lowest: Fit | None = None

    def rise(distance: float, near: Floats) -> tuple[float, Floats]:
        nonlocal lowest
        start = np.clip(near, low, high)
        start[i] = bound if distance >= room else best.q[i] + direction * distance
        fit = settle(problem, start, others, good_enough=2e-3 * threshold)
        if fit.cost < best.cost - 0.02 * threshold and (lowest is None or fit.cost < lowest.cost):
            lowest = fit
        return math.sqrt(max(fit.cost - best.cost, 0.0)) if fit.finite else math.inf, fit.q

    inside, at_inside, place = 0.0, 0.0, best.q
    outside, at_outside = math.inf, math.inf
    distance = min(goal * error, room)
    for _ in range(_TRIES):
        step = direction * distance - (place[i] - best.q[i])
        reached, answer = rise(distance, place + along * step)
        if lowest is not None:
            break
        if abs(reached - goal) <= _CLOSE * goal:
            # The root of the rise is nearly straight: the rest is interpolated.
            end = float(best.q[i] + direction * min(distance * goal / reached, room))
            return end, False, answer, None
        if reached < goal:
            if distance >= room:
                return bound, True, answer, None
            inside, at_inside, place = distance, reached, answer
        else:
            outside, at_outside = distance, reached
        distance = _next(inside, at_inside, outside, at_outside, goal, room)
    end = outside if math.isfinite(outside) else inside
    return float(best.q[i] + direction * min(end, room)), False, place, lowest


def _next(
    inside: float, below: float, outside: float, above: float, goal: float, room: float
) -> float:
    """Where to look next: secant within the bracket, or further out by no more than four times."""
    if math.isinf(outside):
        guess = inside * goal / max(below, 1e-3 * goal)
        return min(max(guess * 1.02, 1.1 * inside), 4.0 * inside, room)
    if math.isinf(above):
        return 0.5 * (inside + outside)
    guess = inside + (outside - inside) * (goal - below) / (above - below)
    width = outside - inside
    return min(max(guess, inside + 0.05 * width), outside - 0.05 * width)


def derived_interval(
    problem: Problem,
    best: Fit,
    function: Callable[[Floats], tuple[float, Floats]],
    threshold: float,
    covariance: Floats,
) -> tuple[float, float, float]:
    """Value and ends of a quantity that follows from the coordinates.

    Along the direction in which the quantity moves most for a rise of the sum of squares; there the
    quantity is taken as it is, not as a straight line.
    """
    value, gradient = function(best.q)
    along = covariance @ gradient
    variance = float(gradient @ along)
    if not variance > 0.0:
        return value, value, value
    low, high = bounds_of(problem)
    ends = []
    for direction in (-1.0, 1.0):
        move = direction * math.sqrt(threshold / variance) * along
        ends.append(function(np.clip(best.q + move, low, high))[0])
    return value, min(ends), max(ends)


def cycle_ratio(problem: Problem, q: Floats, confidence: float = 0.999) -> Floats:
    """By how much the scatter of whole cycles exceeds what white noise makes of each coordinate.

    The sandwich of the scores of single cycles (Huber 1967) over its expectation, one for each free
    coordinate; 1 where it does not exceed it significantly.
    """
    from scipy.special import chdtri

    _, by = problem.residuals(q)
    inverse = covariance_of(by.T @ by)
    measured = np.zeros(q.size)
    expected = np.zeros(q.size)
    square = np.zeros(q.size)
    for at, i in enumerate(problem.order):
        span, folded, metric = problem.bins[at], problem.folded[i], problem.metrics[at]
        # Each cycle's part in the weighted residuals of the mean, without what all share.
        part = (folded.cycle_force - folded.cycle_count * folded.force) / folded.count
        part = part * problem.weight[span]
        influence = metric.apply(np.ascontiguousarray(by[span].T))
        scores = part @ influence.T @ inverse
        number = part.shape[0]
        measured += np.sum(scores**2, axis=0) * number / (number - 1)
        share = np.sum((inverse @ influence) ** 2, axis=1)
        expected += share
        square += share**2 / (number - 1)
    ratio = np.divide(measured, expected, out=np.ones(q.size), where=expected > 0.0)
    # Records that count little bring little: degrees of freedom after Satterthwaite.
    freedom = np.divide(expected**2, square, out=np.ones(q.size), where=square > 0.0)
    largest = chdtri(freedom, 1.0 - confidence) / freedom
    return np.where(ratio > largest, ratio, 1.0)
