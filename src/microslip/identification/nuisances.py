"""Nuisances beside a law: forces, play, delays and noisy loads, each tested for significance."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip.identification.caveats import IDENTIFIED, NOT, Caveat
from microslip.identification.fit import Fit, covariance_of
from microslip.identification.intervals import Profiled
from microslip.identification.problem import EFFECTS, Problem, columns_of
from microslip.identification.verdicts import CAUSES_FROM, WRONG_FROM, Fitted
from microslip.laboratory.folding import CLIPPED

_EXPLAINED, _SIGNIFICANT = 0.5, 1e-3
"""Share of the sum of squares that an effect or a delay has to explain, and not by chance."""
_NOTICED = 1.1  # times as wide
_RARE = 1e-4
_QUIET = 1e-8  # of the range of force: less noise is none
PLAY = "play"
_NEARLY_ALL = 0.95
"""Share that play has to explain: it is fitted, and a delay looks a little like it."""
_WIDEST, _SECTIONS, _GOLDEN, _BESIDE = 0.5, 12, 0.618, 0.005
"""Half the play is looked for up to so much of the smallest amplitude; steps, their ratio, and how
far beside it, of that range, the sum of squares tells its error."""


def after_play(problem: Problem, play: float) -> Problem:
    """The same records with half the play [m], in which the joint stands after each reversal."""
    moved = problem.copy()
    been = np.repeat([problem.folded[i].play for i in problem.order], np.diff(problem.starts))
    moved.half = np.maximum(problem.half + been - play, 0.0)
    moved.guess = [np.zeros(0) for _ in problem.groups]
    moved.forget_answers()
    return moved


class Play(NamedTuple):
    """Half the play [m] with which the law leaves least."""

    value: float
    error: float
    """Standard error [m], by how fast the sum of squares rises beside it."""
    explained: float
    """Share of what the law leaves without play that it explains."""


def play_of(best: Fit) -> Play:
    """The play of all records, by a golden section in which all is fitted again."""
    problem = best.problem

    def cost_with(play: float) -> float:
        fit = Fit(after_play(problem, play), best.q).settled_near(np.arange(best.q.size))
        return math.inf if fit is None else fit.cost

    low, high = 0.0, _WIDEST * min(folded.amplitude for folded in problem.folded)
    step = _BESIDE * high
    for _ in range(_SECTIONS):
        near, far = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
        if cost_with(near) < cost_with(far):
            high = far
        else:
            low = near
    # The sum of squares is a parabola there.
    play = max(0.5 * (low + high), step)
    costs = [cost_with(play + way * step) for way in (-1.0, 0.0, 1.0)]
    bend = costs[0] - 2.0 * costs[1] + costs[2]
    if not (math.isfinite(bend) and bend > 0.0 and costs[1] < best.cost):
        return Play(0.0, 0.0, 0.0)
    play += min(max(0.5 * step * (costs[0] - costs[2]) / bend, -step), step)
    cost = cost_with(play)
    error = step * math.sqrt(2.0 / bend) * max(math.sqrt(cost / max(problem.weight.size, 1)), 1.0)
    return Play(play, error, 1.0 - cost / best.cost)


def causes(best: Fit) -> Iterator[Caveat]:
    """Likely causes of most of the misfit: play, a force beside the law, or a delay."""
    from scipy.special import chdtrc

    problem = best.problem
    if not best.finite or best.cost < CAUSES_FROM * problem.freedom:
        return
    scores = {}
    for name in EFFECTS:
        if name not in problem.effects:
            rows = np.zeros((len(problem.bins), problem.weight.size))
            for at, span in enumerate(problem.bins):
                rows[at, span] = columns_of(problem.folded[problem.order[at]], (name,))[:, 0]
            scores[name] = best.score(rows * problem.weight)
    largest = max((found.share for found in scores.values()), default=0.0)
    beside = None
    if not any(folded.play for folded in problem.folded):
        play = play_of(best)
        if play.explained > max(largest, _NEARLY_ALL):
            beside = Caveat("play explains", {"play": 2.0 * play.value, "share": play.explained})
    if beside is None:
        # Of a sine displacement and acceleration are one: the first of what is as good.
        name = next((key for key, found in scores.items() if found.share >= 0.97 * largest), "")
        if name and (found := scores[name]).share >= _EXPLAINED:
            freedom = problem.residuals(best.q)[0].size - best.q.size
            fall = found.fall / max(best.cost / max(freedom, 1), 1.0)
            if chdtrc(max(found.distinct, 1), fall) <= _SIGNIFICANT:
                data = {"effect": EFFECTS[name].words, "name": name, "share": found.share}
                beside = Caveat("effect explains", data)
    if beside is not None:
        yield beside
    # A force that is cut off, or that another one stands beside, is no late one.
    is_other = beside is not None or any(f.doubt == CLIPPED for f in problem.folded)
    if any(problem.lags) or not is_other:
        yield from _late(best)


# -- delays ---------------------------------------------------------------------------------------


def delays_of(answer: Profiled) -> dict[str, Fitted]:
    """Delay of the force of each record [s], of one without a time base [rad], where it is free."""
    problem = answer.best.problem
    if not problem.free_delay:
        return {}
    errors = _errors(answer.best) * math.sqrt(answer.widest)
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
            None if is_told else Caveat("no delay"),
            load=folded.normal_load,
        )
    return {problem.folded[i].name: delays[i] for i in sorted(delays)}


def _errors(best: Fit) -> Floats:
    """Standard errors of the phases of all records, in the order of the problem [rad]."""
    problem, q = best.problem, best.q
    _, by = problem.residuals(q)
    inverse = covariance_of(by.T @ by)
    rows = np.asarray((problem.to_bins(problem.respond(q)[2])) * problem.weight)
    count = problem.weight.size
    moves = problem.in_metrics(inverse @ by.T)  # of the coordinates, by whitened residuals
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


def _late(best: Fit) -> Iterator[Caveat]:
    """The caveat that a delay would explain the misfit (score test), or is wrong."""
    problem = best.problem
    if problem.free_delay:
        return
    frequencies = [record.frequency for record in problem.folded]
    timed = all(frequencies)
    row = np.zeros((1, problem.weight.size))
    for at, span in enumerate(problem.bins):
        rate = 2.0 * math.pi * (frequencies[problem.order[at]] or 0.0) if timed else 1.0
        row[0, span] = rate * problem.late(at)
    found = best.score(row)
    if found.distinct and found.share >= _EXPLAINED:
        lag = -float(found.sizes[0])
        yield Caveat(
            "delay explains",
            {
                "another": " another" if any(problem.lags) else "",
                "delay": abs(lag),
                "unit": "s" if timed else "rad",
                "way": "behind" if lag > 0.0 else "ahead of",
                "share": found.share,
            },
        )
    elif any(problem.lags) and best.cost > WRONG_FROM * problem.freedom:
        yield Caveat("wrong delay")


# -- noise ----------------------------------------------------------------------------------------


def noise_remarks(best: Fit, loss: str) -> Iterator[Caveat]:
    """Remarks on the noise of the loads, and on a misfit too small to be noise."""
    wider = widened_by_loads(best)
    if wider and max(wider.values()) > _NOTICED:
        name = max(wider, key=lambda key: wider[key])
        yield Caveat("noisy load", {"name": name, "times": wider[name]})
    # A robust loss gives less weight to noise, too; steps of a converter are the most they can be.
    has_steps = any(folded.stepped.size for folded in best.problem.folded)
    if loss == "linear" and not has_steps and _is_less_than_noise(best):
        yield Caveat("too smooth", {"reduced": best.reduced})


def widened_by_loads(best: Fit) -> Mapping[str, float]:
    """Factors by which the noise of the loads widens each interval, in linear approximation."""
    problem, q = best.problem, best.q
    uncertain = [problem.has_load_error(i) for i in problem.order]
    if not any(uncertain) or not problem.nuisance_effects:
        return {}
    certain = problem.copy()
    certain.metrics = [
        problem.metric_of(at, loads=False) if is_uncertain else metric
        for at, (is_uncertain, metric) in enumerate(zip(uncertain, problem.metrics, strict=True))
    ]
    certain._last = None
    informations = (Fit(p, q).information for p in (problem, certain))
    with_loads, without = (np.diag(covariance_of(information)) for information in informations)
    problem.evaluations = certain.evaluations
    names = [coordinate.name for coordinate in problem.free_coordinates]
    return dict(zip(names, np.sqrt(with_loads / without).tolist(), strict=True))


def _is_less_than_noise(best: Fit) -> bool:
    """Whether the misfit is significantly less than the scatter of cycles (Fisher's F)."""
    from scipy.special import fdtr

    records = best.problem.folded
    noise_freedom = sum(record.freedom for record in records)
    quiet = [record.force_noise < _QUIET * float(np.ptp(record.force)) for record in records]
    chance = fdtr(best.problem.freedom, noise_freedom, best.reduced)
    return not all(quiet) and bool(chance < _RARE)
