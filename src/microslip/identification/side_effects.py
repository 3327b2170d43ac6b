"""What a rig or a contact adds to a law: forces beside it, each tested for whether it is needed."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats, show
from microslip._core.units import engineering, significant
from microslip.errors import Argument, InputError, Phrase
from microslip.identification.fit import Fit, settle
from microslip.identification.folding import Folded
from microslip.identification.models.base import BackboneModel
from microslip.identification.problem import Problem
from microslip.identification.profiles import covariance_of
from microslip.identification.rules import CAUSES_FROM

_MUCH, _SIGNIFICANT = 0.5, 1e-3
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
NAMES = (*EFFECTS, PLAY)
"""All that may be asked for."""


def checked_effects(names: Sequence[str] | None) -> tuple[str, ...]:
    """The names of effects that were asked for."""
    if names is None:
        return ()
    if isinstance(names, str) or not isinstance(names, Sequence):
        raise InputError(
            Argument("nuisances"), f" must be a list of {', '.join(NAMES)}, got {show(names)}"
        )
    for name in names:
        if name not in NAMES:
            raise InputError(
                Argument("nuisances"), f" must be of {', '.join(NAMES)}, got {show(name)}"
            )
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
    """Share of what is left that each effect would explain, and the chance that noise does.

    A score test, one size for each record: by how much the sum of squares would fall in the linear
    approximation. Of what was fitted with the others, the same without it.
    """
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
    """The same records, half the play between joint and transducer being so much [m].

    After each reversal the joint stands still till the play is gone, so half distances are shorter
    by half of it.
    """
    moved = copy.copy(problem)
    been = np.repeat([problem.folded[i].play for i in problem.order], np.diff(problem.starts))
    moved.half = np.maximum(problem.half + been - play, 0.0)
    moved.guess = [np.zeros(0) for _ in problem.groups]
    moved.forget_answers()
    moved.metrics = list(problem.metrics)
    return moved


class Play(NamedTuple):
    """Half the play [m] with which the law leaves least."""

    value: float
    error: float
    """Standard error [m], by how fast the sum of squares rises beside it."""
    explained: float
    """Share of what the law leaves without play that it explains."""


def play_of(problem: Problem, best: Fit) -> Play:
    """The play of the records, the same in all of them.

    Play is no small effect, so all is fitted again at each; a golden section finds the least.
    """
    if not isinstance(problem.model, BackboneModel):
        return Play(0.0, 0.0, 0.0)

    def left(play: float) -> float:
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
        if left(near) < left(far):
            high = far
        else:
            low = near
    # The sum of squares is a parabola there.
    play = max(0.5 * (low + high), step)
    costs = [left(play + way * step) for way in (-1.0, 0.0, 1.0)]
    bend = costs[0] - 2.0 * costs[1] + costs[2]
    if not (math.isfinite(bend) and bend > 0.0 and costs[1] < best.cost):
        return Play(0.0, 0.0, 0.0)
    play += min(max(0.5 * step * (costs[0] - costs[2]) / bend, -step), step)
    cost = left(play)
    error = step * math.sqrt(2.0 / bend) * max(math.sqrt(cost / max(problem.weight.size, 1)), 1.0)
    return Play(play, error, 1.0 - cost / best.cost)


def notes_of(problem: Problem, best: Fit, freedom: int) -> list[str]:
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
                Phrase(
                    f"play of {engineering(2.0 * play.value, 'm')} between joint and transducer "
                    f"would explain {share} % of what the law leaves; ",
                    *("write ", Argument("nuisances", [PLAY])),
                )
            ]
    # Of a sine displacement and acceleration are one: the first of what is as good.
    name = next((key for key, (share, _) in shares.items() if share >= 0.97 * largest), "")
    if not name or shares[name][0] < _MUCH or shares[name][1] > _SIGNIFICANT:
        return []
    share = significant(100.0 * min(shares[name][0], 1.0), 2)
    return [
        Phrase(
            f"{EFFECTS[name].words} would explain {share} % of what the law leaves; ",
            *("write ", Argument("nuisances", [name])),
        )
    ]
