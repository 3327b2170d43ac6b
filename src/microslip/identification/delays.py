"""How late the force of each record is, and whether that would explain a misfit."""

from __future__ import annotations

import math

import numpy as np

from microslip._core.checks import Floats
from microslip._core.units import significant
from microslip.errors import Argument, Phrase
from microslip.identification.fit import Fit
from microslip.identification.intervals import Profiled
from microslip.identification.problem import Problem
from microslip.identification.profiles import covariance_of
from microslip.identification.rules import CAUSES_FROM, WRONG_FROM
from microslip.identification.verdicts import IDENTIFIED, NOT, Fitted, number_text

_FREE = ("write ", Argument("delay", "free"))
_MUCH = 0.5
"""Share of the sum of squares that a delay has to explain."""


def delays_of(problem: Problem, answer: Profiled) -> dict[str, Fitted]:
    """Delay of the force of each record [s], of one without a time base [rad], where it is free.

    A delay is what least squares say at the best values of all others, so its error is that of the
    noise of its own record and of all that moves these values.
    """
    if not problem.free_delay or not answer.best.finite:
        return {}
    errors = _errors(problem, answer.best.q) * math.sqrt(float(answer.widen.max(initial=1.0)))
    reach = math.sqrt(answer.threshold)
    delays = {}
    several = len(problem.folded) > 1
    for at, i in enumerate(problem.order):
        folded = problem.folded[i]
        unit = "rad" if folded.frequency is None else "s"
        scale = 1.0 if folded.frequency is None else 1.0 / (2.0 * math.pi * folded.frequency)
        value, error = scale * problem.lags[i], scale * float(errors[at])
        is_told = reach * error < scale * math.pi / 2.0  # half a period is the other way round
        delays[i] = Fitted(
            f"delay of {folded.name}" if several else "delay",
            unit,
            value,
            value - reach * error,
            value + reach * error,
            error,
            IDENTIFIED if is_told else NOT,
            "" if is_told else "the loops tell no delay within half a period",
            "" if is_told else "more cycles, or less noise of the force",
            False,
            folded.normal_load,
        )
    return {problem.folded[i].name: delays[i] for i in sorted(delays)}


def _errors(problem: Problem, q: Floats) -> Floats:
    """Standard errors of the phases of all records, in the order of the problem [rad]."""
    _, by = problem.residuals(q)
    inverse = covariance_of(by.T @ by)
    rows = np.asarray((problem.to_bins(problem.respond(q)[2])) * problem.weight)
    count = problem.weight.size
    moves = inverse @ by.T  # of the coordinates, by whitened residuals
    for span, metric in zip(problem.bins, problem.metrics, strict=True):
        moves[:, span] = metric.apply(moves[:, span])
    variance = np.zeros(len(problem.order))
    for at, own_span in enumerate(problem.bins):
        flat = np.stack((problem.weight[own_span], problem.late(at))).T
        by_force = np.linalg.pinv(flat)[1]
        every = -(by_force @ rows[:, own_span].T) @ moves
        every[own_span] += by_force
        variance[at] = float(every[count:] @ every[count:])
        for record, span in enumerate(problem.bins):
            part = every[span]
            effects = part @ problem.nuisances_of(record)
            variance[at] += float(part @ part) + float(effects @ effects)
    return np.sqrt(variance)


def late_note(problem: Problem, best: Fit, freedom: int) -> str | None:
    """What says that a delay would explain most of what the law leaves, or may be given wrong.

    A score test of one delay of all forces: by how much the sum of squares would fall, in the
    linear approximation.
    """
    if problem.free_delay or not best.finite or best.cost < CAUSES_FROM * freedom:
        return None
    text = _explains(problem, best)
    if text is None and any(problem.lags) and best.cost > WRONG_FROM * freedom:
        return Phrase("the delay that was given may not be that of these records; ", *_FREE)
    return text


def _explains(problem: Problem, best: Fit) -> str | None:
    residual, by = problem.residuals(best.q)
    frequencies = [record.frequency for record in problem.folded]
    timed = all(frequencies)
    late = np.zeros(residual.size)
    for at, (span, metric) in enumerate(zip(problem.bins, problem.metrics, strict=True)):
        rate = 2.0 * math.pi * (frequencies[problem.order[at]] or 0.0) if timed else 1.0
        late[span] = metric.apply(rate * problem.late(at))
    size = float(np.linalg.norm(late))
    if size == 0.0:
        return None
    remainder = late - by @ (covariance_of(by.T @ by) @ (by.T @ late))
    square = float(remainder @ remainder)
    if square <= 1e-8 * size**2:
        return None
    fall = float(remainder @ residual) ** 2 / square
    if fall < _MUCH * best.cost:
        return None
    lag = float(remainder @ residual) / square
    by_this = number_text(abs(lag), "s" if timed else "rad", 2)
    way = "behind" if lag > 0.0 else "ahead of"
    return Phrase(
        f"a force{' another' if any(problem.lags) else ''} {by_this} {way} the displacement would "
        f"explain {significant(100.0 * min(fall / best.cost, 1.0), 2)} % of what the law leaves; ",
        *_FREE,
    )
