"""Verdicts on a predicted structure.

They judge convergence, the sampling error of bands, the range of forced responses, and agreement
with tests.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from microslip._core.verdicts import Rule, Verdict
from microslip.report.document import Verdicts
from microslip.study.runs.structure_prediction import StructurePrediction

# Limits, by their effect on what the report shows. Errors of damping: up to 5 %, the scatter of a
# careful modal test, need no remark; from 20 % on they exceed the effect of most design changes.
# Samples without a solution may all lie beyond one end of a band: 2 % move a 5 % end to 3 or 7 %,
# 20 % leave no end. Half of the amplitudes, forces or tested points is a majority. The points of
# one test belong to one joint and lie in or out together, so one is worth a remark; by chance one
# test in ten lies outside a band of 90 %.
_SOLVED = Rule(
    "amplitudes without a solution", 0.0, 0.5, "each amplitude of a mode is solved",
    remedy="end at a smaller amplitude.to",
)  # fmt: skip
_SAMPLED = Rule(
    "samples without a solution", 0.02, 0.2, "bands count all samples",
    "samples that fail are often those of the weakest joints",
    "narrow the uncertain inputs or end at a smaller amplitude.to",
)  # fmt: skip
_HARMONICS = Rule(
    "damping by harmonics left out", 0.05, 0.2, "few harmonics describe the motion",
    remedy="add harmonics", missing="no solution to judge",
)  # fmt: skip
_SAMPLING = Rule(
    "sampling error of the bands", 0.1, 0.5, "there are enough samples for the bands",
    remedy="take more samples", missing="no sample has a solution",
)  # fmt: skip
_DRAWN = Rule(
    "error of patches, mesh and reduction", 0.05, 0.2, "the model is fine enough",
    remedy="give more patches or smaller elements", missing="converge = true estimates it",
)  # fmt: skip
_MESHED = Rule(
    _DRAWN.name, _DRAWN.watch, _DRAWN.outside, _DRAWN.meaning,
    missing="compare with a finer mesh and more patches",
)  # fmt: skip
_PATCHES = replace(
    _DRAWN, name="error of patches", remedy="give more patches; converge = true covers the mesh too"
)
_FORCED = Rule(
    "forced responses beyond the amplitudes", 0.0, 0.5, "responses end below the largest amplitude",
    remedy="give a larger amplitude.to",
)  # fmt: skip
_TESTED = Rule(
    "points of tests outside the bands", 0.0, 0.5, "tests lie within the 5 to 95 % bands",
    remedy="see the candidates of each test",
)  # fmt: skip
_LIMITED = Rule(
    "points of tests beyond open and tied laps", 0.0, 0.0,
    "tested frequencies lie between those of the open and of the wholly tied lap",
    remedy="check sizes, moduli, masses and the number of the mode",
)  # fmt: skip


def structure_verdicts(prediction: StructurePrediction) -> tuple[Verdict, ...]:
    """Return verdicts on all parts of a structure's report, for its headline."""
    return tuple(_judged(prediction))


def with_structure(block: Verdicts, prediction: StructurePrediction) -> Verdicts:
    """Add the verdicts on a structure, with values in percent, to those on its contact."""
    verdicts = structure_verdicts(prediction)
    return replace(
        block,
        verdicts=(*verdicts, *block.verdicts),
        places=(*[""] * len(verdicts), *(block.places or [""] * len(block.verdicts))),
        percent=block.percent | {verdict.name for verdict in verdicts},
        short=True,
    )


def _judged(prediction: StructurePrediction) -> Iterator[Verdict]:
    modes, part = prediction.modes, prediction.part
    yield _SOLVED.judge(1.0 - min(float(mode.curve.converged.mean()) for mode in modes))
    errors = np.concatenate([abs(mode.curve.harmonic_error) for mode in modes])
    known = errors[np.isfinite(errors)]
    yield _HARMONICS.judge(float(known.max()) if known.size else None)
    if bands := [mode.bands for mode in modes if mode.bands is not None]:
        yield _SAMPLED.judge(max(band.unsolved for band in bands) / part.samples)
        errors = np.array([[band.frequency_error, band.damping_error] for band in bands])
        largest = float(np.nanmax(errors, initial=-np.inf))
        few = replace(_SAMPLING, missing="too few samples for the ends of the bands")
        yield (few if largest == np.inf else _SAMPLING).judge(
            largest if np.isfinite(largest) else None
        )
    if prediction.convergence is None and prediction.patch_error is not None:
        rule = _PATCHES if part.mesh is None else replace(_PATCHES, remedy="give more patches")
        frequency, of_joint = prediction.patch_error
        curve = modes[0].curve
        share = float(np.nanmax(1.0 - curve.base_damping / curve.damping_ratio))  # of the joint
        yield rule.judge(max(frequency, share * of_joint))
    else:
        error = None if prediction.convergence is None else max(prediction.convergence.error)
        yield (_DRAWN if part.mesh is None else _MESHED).judge(error)
    if forced := [response for mode in modes for response in mode.forced]:
        shares = [r.beyond if np.isfinite(r.peak[0]) else 1.0 for r in forced]
        yield _FORCED.judge(max(shares))
    if points := sum(verdict.points for verdict in prediction.judged):
        outside = sum(verdict.above + verdict.below for verdict in prediction.judged)
        yield _TESTED.judge(outside / points)
    if prediction.tests and prediction.limits:
        limits = dict(zip((mode.number for mode in modes), prediction.limits, strict=True))
        beyond = [
            (test.frequency < limits[test.mode + 1].open)
            | (test.frequency > limits[test.mode + 1].tied)
            for test in prediction.tests
        ]
        yield _LIMITED.judge(float(np.concatenate(beyond).mean()))
