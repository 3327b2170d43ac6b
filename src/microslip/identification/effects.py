"""Forces that may stand beside the law, their sizes free in each record."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats, show
from microslip.errors import InputError
from microslip.identification.options import NUISANCES
from microslip.tribometer.folding import Folded


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
