"""Size of the model of a structure, and its computing time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from microslip.study.build import Design, at_middle, blame, is_uncertain
from microslip.study.description import StudyDescription
from microslip.study.runs.structure import BASE, keys_of_model
from microslip.study.structure import USUAL_PATCHES

_PER_REDUCTION, _PER_POINT, _PER_LOOK = 4.0, 0.012, 0.6
"""Seconds of a core of 2023: of 40 000 degrees of freedom with 30 patches; of an amplitude and 30
patches; of the harmonics left out, 30 patches, whose laws are tightened
by their own pressure up to three times as long."""
_TRIALS = 20  # reductions that a convergence takes
_EVALUATIONS, _DRAWS = 12, 32  # curves of a fit a parameter, and for its band
_UNSURE = 1.8  # measured over estimated time, at most; benchmarks of studies in either direction


class Cost(NamedTuple):
    """Size of the model of a study, and the time of a run on one core."""

    degrees_of_freedom: int
    patches: int
    balances: int
    """Curves of modes, those of samples and fits included."""
    reductions: int
    seconds: tuple[float, float]
    """Lower and upper estimate."""
    gigabytes: float


def cost_of(study: StudyDescription) -> Cost:
    """The meshed structure looked over as a run does, without solving it."""
    middle = at_middle(study)
    part = middle.bolted
    with blame(study, "structure"):
        reducer = part.reducer()
    with blame(study, "structure.sensor"):
        reducer.check_sensors(part.reduction["sensors"])
    design = Design(study) if is_uncertain(study) else None
    count, samples, drawn_anew = reducer.elements.size, 0, False
    if design is not None and design.changed_keys != {BASE}:
        samples, drawn_anew = part.samples, bool(keys_of_model(study, design.changed_keys))
    patches = int(np.prod(part.patches or USUAL_PATCHES)) * len(reducer.mesh.contacts)
    reductions = 1 + (part.patches is None) + samples * drawn_anew + _TRIALS * part.converge
    reductions += bool(part.bolts.slack)
    fits = len(part.measured) * (_DRAWS + _EVALUATIONS * len(part.fitted)) if part.fitted else 0
    balances = len(part.modes) * (1 + samples + bool(part.bolts.slack)) + fits
    size, finer = count / 4e4, patches / 30.0
    seconds = _PER_REDUCTION * size**1.3 * (0.75 + 0.25 * finer) * reductions
    seconds += _PER_POINT * len(part.amplitudes) * finer**0.8 * balances
    seconds += _PER_LOOK * len(part.modes) * finer
    bounds = (seconds / _UNSURE, seconds * _UNSURE)
    return Cost(count, patches, balances, reductions, bounds, 0.15 + 0.7 * size)
