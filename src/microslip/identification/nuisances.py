"""Nuisances beside a law: forces, play, delays and noisy loads, each tested for its part."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats, show
from microslip.errors import InputError
from microslip.identification.caveats import IDENTIFIED, NOT, Caveat
from microslip.identification.fit import Fit, Score, covariance_of, score, settle_near
from microslip.identification.intervals import Profiled
from microslip.identification.models.base import BackboneModel
from microslip.identification.options import NUISANCES
from microslip.identification.problem import Problem
from microslip.identification.rules import CAUSES_FROM, WRONG_FROM
from microslip.identification.verdicts import Fitted
from microslip.tribometer.folding import CLIPPED, Folded

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


class Effect(NamedTuple):
    """A force beside that of the law, of unknown size in each record."""

    words: str
    shape: Callable[[Folded], Floats]
    """Its course over the bins of a record, of any size."""


def _centred(values: Floats) -> Floats:
    return np.asarray(values - 0.5 * (values.max() + values.min()))


EFFECTS: Mapping[str, Effect] = {
    "parallel": Effect("a spring beside the joint", lambda f: _centred(f.displacement(f.phase))),
    "viscous": Effect("a force proportional to velocity", lambda f: f.displacement(f.phase, 1)),
    "inertia": Effect("a mass behind the force sensor", lambda f: f.displacement(f.phase, 2)),
    "tilt": Effect(
        "friction that changes along the displacement, as of tilted faces (to first order)",
        lambda f: np.asarray(_centred(f.force) * _centred(f.displacement(f.phase))),
    ),
}
"""Forces that may be asked for, by name."""


def checked_effects(names: Sequence[str] | None) -> tuple[str, ...]:
    """The names of effects that were asked for."""
    if names is None:
        return ()
    if isinstance(names, str) or not isinstance(names, Sequence):
        raise InputError(f"`nuisances` must be a list of {', '.join(NUISANCES)}, got {show(names)}")
    for name in names:
        if name not in NUISANCES:
            raise InputError(f"`nuisances` must be among {', '.join(NUISANCES)}, got {show(name)}")
    return tuple(dict.fromkeys(names))


def columns_of(folded: Folded, names: Sequence[str]) -> Floats:
    """Courses of the effects in a record, a column each of the norm 1."""
    columns = []
    for name in names:
        column = EFFECTS[name].shape(folded)
        size = float(np.linalg.norm(column))
        columns.append(column / (size or 1.0))
    return np.array(columns).T.reshape(folded.phase.size, len(names))


def explained_shares(problem: Problem, best: Fit) -> dict[str, tuple[float, float]]:
    """Share of what is left that each effect would explain (score test), and its chance."""
    from scipy.special import chdtrc

    freedom = problem.residuals(best.q)[0].size - best.q.size
    reduced = max(best.cost / max(freedom, 1), 1.0)
    shares = {}
    for name in EFFECTS:
        if name in problem.effects:
            continue
        rows = np.zeros((len(problem.bins), problem.weight.size))
        for at, span in enumerate(problem.bins):
            rows[at, span] = columns_of(problem.folded[problem.order[at]], (name,))[:, 0]
        found = score(problem, best.q, rows * problem.weight)
        chance = float(chdtrc(max(found.distinct, 1), found.fall / reduced))
        shares[name] = _share(found, best), chance
    return shares


def _share(found: Score, best: Fit) -> float:
    return min(found.fall / best.cost, 1.0) if best.cost > 0.0 else 0.0


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


def play_of(problem: Problem, best: Fit) -> Play:
    """The play of all records, by a golden section in which all is fitted again."""
    if not isinstance(problem.model, BackboneModel):
        return Play(0.0, 0.0, 0.0)

    def cost_with(play: float) -> float:
        fit = settle_near(after_play(problem, play), best.q, np.arange(best.q.size))
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


def causes(problem: Problem, best: Fit, freedom: int) -> Iterator[Caveat]:
    """Likely causes of most of the misfit: play, a force beside the law, or a delay."""
    if not best.finite or best.cost < CAUSES_FROM * freedom:
        return
    shares = explained_shares(problem, best)
    largest = max((share for share, _ in shares.values()), default=0.0)
    beside = None
    if not any(folded.play for folded in problem.folded):
        play = play_of(problem, best)
        if play.explained > max(largest, _NEARLY_ALL):
            beside = Caveat("play explains", {"play": 2.0 * play.value, "share": play.explained})
    if beside is None:
        # Of a sine displacement and acceleration are one: the first of what is as good.
        name = next((key for key, (share, _) in shares.items() if share >= 0.97 * largest), "")
        if name and shares[name][0] >= _EXPLAINED and shares[name][1] <= _SIGNIFICANT:
            data = {"effect": EFFECTS[name].words, "name": name, "share": shares[name][0]}
            beside = Caveat("effect explains", data)
    if beside is not None:
        yield beside
    # A force that is cut off, or that another one stands beside, is no late one.
    is_other = beside is not None or any(f.doubt == CLIPPED for f in problem.folded)
    if any(problem.lags) or not is_other:
        yield from _late(problem, best, freedom)


# -- delays ---------------------------------------------------------------------------------------


def delays_of(problem: Problem, answer: Profiled) -> dict[str, Fitted]:
    """Delay of the force of each record [s], of one without a time base [rad], where it is free."""
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
            None if is_told else Caveat("no delay"),
            load=folded.normal_load,
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


def _late(problem: Problem, best: Fit, freedom: int) -> Iterator[Caveat]:
    """The caveat that a delay would explain the misfit (score test), or is wrong."""
    if problem.free_delay:
        return
    frequencies = [record.frequency for record in problem.folded]
    timed = all(frequencies)
    row = np.zeros((1, problem.weight.size))
    for at, span in enumerate(problem.bins):
        rate = 2.0 * math.pi * (frequencies[problem.order[at]] or 0.0) if timed else 1.0
        row[0, span] = rate * problem.late(at)
    found = score(problem, best.q, row)
    if found.distinct and _share(found, best) >= _EXPLAINED:
        lag = -float(found.sizes[0])
        yield Caveat(
            "delay explains",
            {
                "another": " another" if any(problem.lags) else "",
                "delay": abs(lag),
                "unit": "s" if timed else "rad",
                "way": "behind" if lag > 0.0 else "ahead of",
                "share": _share(found, best),
            },
        )
    elif any(problem.lags) and best.cost > WRONG_FROM * freedom:
        yield Caveat("wrong delay")


# -- noise ----------------------------------------------------------------------------------------


def noise_remarks(problem: Problem, best: Fit, freedom: int, loss: str) -> Iterator[Caveat]:
    """Remarks on the noise of the loads, and on a misfit too small to be noise."""
    wider = widened_by_loads(problem, best.q)
    if wider and max(wider.values()) > _NOTICED:
        name = max(wider, key=lambda key: wider[key])
        yield Caveat("noisy load", {"name": name, "times": wider[name]})
    # A robust loss gives less weight to noise, too; steps of a converter are the most they can be.
    has_steps = any(folded.stepped.size for folded in problem.folded)
    if loss == "linear" and not has_steps and is_less_than_noise(problem, best.cost, freedom):
        yield Caveat("too smooth", {"reduced": best.cost / freedom})


def widened_by_loads(problem: Problem, q: Floats) -> Mapping[str, float]:
    """Factors by which the noise of the loads widens each interval, in linear approximation."""
    uncertain = [problem.has_load_error(i) for i in problem.order]
    if not any(uncertain) or not problem.nuisance_effects:
        return {}
    by_all = problem.residuals(q)[1]
    metrics = list(problem.metrics)
    problem.metrics = [
        problem.metric_of(at, loads=False) if is_uncertain else metric
        for at, (is_uncertain, metric) in enumerate(zip(uncertain, metrics, strict=True))
    ]
    problem._last = None
    by_rest = problem.residuals(q)[1]
    problem.metrics = metrics
    problem._last = None
    with_loads, without = (np.diag(covariance_of(by.T @ by)) for by in (by_all, by_rest))
    names = [problem.coordinates[int(j)].name for j in problem.free]
    return dict(zip(names, np.sqrt(with_loads / without).tolist(), strict=True))


def is_less_than_noise(problem: Problem, cost: float, freedom: int) -> bool:
    """Whether the misfit is significantly less than the scatter of cycles (Fisher's F)."""
    from scipy.special import fdtr

    noise_freedom = sum(record.freedom for record in problem.folded)
    quiet = [record.force_noise < _QUIET * float(np.ptp(record.force)) for record in problem.folded]
    return not all(quiet) and bool(fdtr(freedom, noise_freedom, cost / freedom) < _RARE)
