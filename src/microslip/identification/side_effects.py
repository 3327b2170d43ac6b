"""What a rig or a contact adds to a law: forces beside it, each tested for whether it is needed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats, show
from microslip._core.units import significant
from microslip.errors import Argument, InputError, Phrase
from microslip.identification.fit import Fit
from microslip.identification.folding import Folded
from microslip.identification.problem import Problem
from microslip.identification.profiles import covariance_of
from microslip.identification.rules import LEFT

_MUCH, _SIGNIFICANT = 0.5, 1e-3


class Effect(NamedTuple):
    """A force beside that of the law, of unknown size in each record."""

    words: str
    shape: Callable[[Folded], Floats]
    """Its course over the bins of a record, of any size."""


def _middle(values: Floats) -> Floats:
    return np.asarray(values - 0.5 * (values.max() + values.min()))


EFFECTS: Mapping[str, Effect] = {
    "parallel": Effect("a spring beside the joint", lambda f: _middle(f.displacement(f.phase))),
    "viscous": Effect("a force that goes with velocity", lambda f: f.displacement(f.phase, 1)),
    "inertia": Effect("a mass behind the force sensor", lambda f: f.displacement(f.phase, 2)),
    "tilt": Effect(
        "friction that changes along the way, as of tilted faces (to first order)",
        lambda f: np.asarray(_middle(f.force) * _middle(f.displacement(f.phase))),
    ),
}
"""What may be asked for, by name."""


def checked(given: Sequence[str] | None) -> tuple[str, ...]:
    """The names of effects that were asked for."""
    if given is None:
        return ()
    if isinstance(given, str) or not isinstance(given, Sequence):
        raise InputError(
            Argument("nuisances"), f" must be a list of {', '.join(EFFECTS)}, got {show(given)}"
        )
    for name in given:
        if name not in EFFECTS:
            raise InputError(
                Argument("nuisances"), f" must be of {', '.join(EFFECTS)}, got {show(name)}"
            )
    return tuple(dict.fromkeys(given))


def columns_of(folded: Folded, names: Sequence[str]) -> Floats:
    """Courses of the effects in a record, a column each of the norm 1."""
    found = []
    for name in names:
        column = EFFECTS[name].shape(folded)
        size = float(np.linalg.norm(column))
        found.append(column / (size or 1.0))
    return np.array(found).T.reshape(folded.phase.size, len(names))


def needed(problem: Problem, best: Fit) -> dict[str, tuple[float, float]]:
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
        left = columns - by @ (inverse @ (by.T @ columns))
        size = np.linalg.norm(left, axis=0)
        known = size > 1e-4 * np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
        basis, _ = np.linalg.qr(left[:, known] / size[known])
        fall = float(np.sum((basis.T @ residual) ** 2))
        reduced = max(best.cost / max(residual.size - best.q.size, 1), 1.0)
        chance = float(chdtrc(max(int(known.sum()), 1), fall / reduced))
        shares[name] = fall / best.cost if best.cost > 0.0 else 0.0, chance
    return shares


def notes_of(problem: Problem, best: Fit, freedom: int) -> list[str]:
    """What is to be said of effects that would explain most of what the law leaves."""
    if not best.finite or best.cost < LEFT * freedom:
        return []
    found = needed(problem, best)
    most = max((share for share, _ in found.values()), default=0.0)
    # Of a sine displacement and acceleration are one: the first of what is as good.
    name = next((key for key, (share, _) in found.items() if share >= 0.97 * most), "")
    if not name or found[name][0] < _MUCH or found[name][1] > _SIGNIFICANT:
        return []
    share = significant(100.0 * min(found[name][0], 1.0), 2)
    return [
        Phrase(
            f"{EFFECTS[name].words} would explain {share} % of what the law leaves; ",
            *("write ", Argument("nuisances", [name])),
        )
    ]
