"""What stands beside a law: forces, play, delays and noisy loads, each tested for its part."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats, show
from microslip._core.units import engineering, significant
from microslip.errors import InputError, in_python
from microslip.identification.fit import Fit, settle
from microslip.identification.intervals import Profiled
from microslip.identification.models.base import BackboneModel
from microslip.identification.options import NUISANCES
from microslip.identification.problem import Problem
from microslip.identification.profiles import covariance_of
from microslip.identification.rules import CAUSES_FROM, WRONG_FROM
from microslip.identification.verdicts import IDENTIFIED, NOT, Fitted, number_text
from microslip.tribometer.folding import Folded

_EXPLAINED, _SIGNIFICANT = 0.5, 1e-3
"""Share of the sum of squares that an effect or a delay has to explain, and not by chance."""
_FREE = 'write `delay="free"`'
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
    "viscous": Effect("a force that goes with velocity", lambda f: f.displacement(f.phase, 1)),
    "inertia": Effect("a mass behind the force sensor", lambda f: f.displacement(f.phase, 2)),
    "tilt": Effect(
        "friction that changes along the way, as of tilted faces (to first order)",
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
            raise InputError(f"`nuisances` must be of {', '.join(NUISANCES)}, got {show(name)}")
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

    residual, by = problem.residuals(best.q)
    inverse = covariance_of(by.T @ by)
    shares = {}
    for name in EFFECTS:
        if name in problem.effects:
            continue
        columns = np.zeros((residual.size, len(problem.bins)))
        for at, (span, metric) in enumerate(zip(problem.bins, problem.metrics, strict=True)):
            column = columns_of(problem.folded[problem.order[at]], (name,))[:, 0]
            columns[span, at] = metric.apply(column * problem.weight[span])
        remainder = columns - by @ (inverse @ (by.T @ columns))
        size = np.linalg.norm(remainder, axis=0)
        is_distinct = size > 1e-4 * np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
        basis, _ = np.linalg.qr(remainder[:, is_distinct] / size[is_distinct])
        fall = float(np.sum((basis.T @ residual) ** 2))
        reduced = max(best.cost / max(residual.size - best.q.size, 1), 1.0)
        chance = float(chdtrc(max(int(is_distinct.sum()), 1), fall / reduced))
        shares[name] = fall / best.cost if best.cost > 0.0 else 0.0, chance
    return shares


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
        with np.errstate(all="ignore"):
            try:
                trial = after_play(problem, play)
                return settle(trial, best.q, np.arange(best.q.size)).cost
            except (ArithmeticError, ValueError, np.linalg.LinAlgError):
                return math.inf

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


def effect_notes(problem: Problem, best: Fit, freedom: int) -> list[str]:
    """What is to be said of effects that would explain most of what the law leaves."""
    if not best.finite or best.cost < CAUSES_FROM * freedom:
        return []
    shares = explained_shares(problem, best)
    largest = max((share for share, _ in shares.values()), default=0.0)
    if not any(folded.play for folded in problem.folded):
        play = play_of(problem, best)
        if play.explained > max(largest, _NEARLY_ALL):
            share = significant(100.0 * play.explained, 2)
            return [
                (
                    f"play of {engineering(2.0 * play.value, 'm')} between joint and transducer "
                    f"would explain {share} % of what the law leaves; write "
                    f"`nuisances={in_python([PLAY])}`"
                )
            ]
    # Of a sine displacement and acceleration are one: the first of what is as good.
    name = next((key for key, (share, _) in shares.items() if share >= 0.97 * largest), "")
    if not name or shares[name][0] < _EXPLAINED or shares[name][1] > _SIGNIFICANT:
        return []
    share = significant(100.0 * min(shares[name][0], 1.0), 2)
    return [
        (
            f"{EFFECTS[name].words} would explain {share} % of what the law leaves; write "
            f"`nuisances={in_python([name])}`"
        )
    ]


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
    """What says that a delay would explain what the law leaves (score test), or is wrong."""
    if problem.free_delay or not best.finite or best.cost < CAUSES_FROM * freedom:
        return None
    text = _explains(problem, best)
    if text is None and any(problem.lags) and best.cost > WRONG_FROM * freedom:
        return f"the delay that was given may not be that of these records; {_FREE}"
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
    if fall < _EXPLAINED * best.cost:
        return None
    lag = float(remainder @ residual) / square
    by_this = number_text(abs(lag), "s" if timed else "rad", 2)
    way = "behind" if lag > 0.0 else "ahead of"
    return (
        f"a force{(' another' if any(problem.lags) else '')} {by_this} {way} the "
        "displacement would explain "
        f"{significant(100.0 * min(fall / best.cost, 1.0), 2)} % of what the law leaves; "
        f"{_FREE}"
    )


# -- noise ----------------------------------------------------------------------------------------


def noise_notes(problem: Problem, best: Fit, freedom: int, loss: str = "linear") -> list[str]:
    """What is worth saying of the noise of the loads, and of a misfit too small to be noise."""
    notes: list[str] = []
    if not best.finite:
        return notes
    wider = widened_by_loads(problem, best.q)
    if wider and max(wider.values()) > _NOTICED:
        name = max(wider, key=lambda key: wider[key])
        notes.append(
            f"the noise of the measured load makes the interval of {name} "
            f"{significant(wider[name], 3)} times as wide: more cycles, or a load that is known "
            "better, would narrow it"
        )
    # A robust loss gives less weight to noise, too.
    if loss == "linear" and is_less_than_noise(problem, best.cost, freedom):
        notes.append(
            "the mean loops are smoother than the scatter of the forces lets expect (reduced "
            f"chi-squared {significant(best.cost / freedom, 2)}): that scatter is no white noise, "
            "such as a force that wanders; the intervals may be wider than need be"
        )
    return notes


def widened_by_loads(problem: Problem, q: Floats) -> Mapping[str, float]:
    """How many times as wide the noise of the loads makes each interval, if all is linear."""
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
