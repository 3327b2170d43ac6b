"""Size of the model of a structure, and its computing time estimated from one solution."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from microslip.study.build import Design, is_uncertain, naming_key
from microslip.study.description import StudyDescription
from microslip.study.runs.structure import (
    BASE,
    SAMPLE_RTOL,
    keys_of_model,
    modal_curve,
    tightened,
)
from microslip.study.uncertain import at_central_values

_TRIALS = 20  # reductions of a convergence study
_EVALUATIONS, _DRAWS = 12, 32  # modal curves per fitted parameter, and for its interval
_UNSURE = 1.6  # factor of uncertainty of the estimated time


def cost_of(study: StudyDescription) -> dict[str, Any]:
    """Return the model size of a study, and its computing time [s] from one modal solution.

    ``balances`` is the number of modal curves, including samples and fits; ``measured`` are the
    times [s] of one factorisation, one reduction, and one modal curve with its preload.
    """
    middle = at_central_values(study)
    part = middle.bolted
    with naming_key(study, "structure"):
        reducer = part.reducer()
    with naming_key(study, "structure.sensor"):
        reducer.check_sensors(part.reduction["sensors"])
    design = Design(study) if is_uncertain(study) else None
    count, samples, drawn_anew = reducer.elements.size, 0, False
    if design is not None and design.spreads.keys() != {BASE}:
        samples, drawn_anew = part.samples, bool(keys_of_model(study, design.spreads))
    reductions = 1 + samples * drawn_anew + _TRIALS * part.converge
    fits = len(part.measured) * (_DRAWS + _EVALUATIONS * len(part.fitted)) if part.fitted else 0
    balances = len(part.modes) * (1 + samples) + fits
    with naming_key(study, "structure"):
        marks = [time.perf_counter()]
        _ = reducer.body
        marks.append(time.perf_counter())
        joint = reducer.reduce(**part.reduction)
        marks.append(time.perf_counter())
        tightened(middle, joint)  # tabulates the law, once for all samples
        marks.append(time.perf_counter())
        _, state = tightened(middle, joint)
        modal_curve(part, joint, state, part.modes[0], SAMPLE_RTOL)
        marks.append(time.perf_counter())
    factor, reduction, law, balance = np.diff(marks).tolist()
    meshes = 1 + samples * drawn_anew + part.converge
    seconds = meshes * factor + reductions * reduction + law + balances * balance
    return {
        "degrees_of_freedom": count,
        "patches": joint.patches,
        "balances": balances,
        "reductions": reductions,
        "measured": (factor, reduction, balance),
        "seconds": (seconds / _UNSURE, seconds * _UNSURE),
        "gigabytes": 0.15 + 0.7 * count / 4e4,
    }
