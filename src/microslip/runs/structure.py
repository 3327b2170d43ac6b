"""From the structure of a study to its modes, and their bands on one reduced model."""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip.errors import InputError
from microslip.report.document import Progress
from microslip.runs.structure_prediction import SHARES, Bands, Mode, StructurePrediction
from microslip.structures import (
    Convergence,
    ModalCurve,
    ModalIdentification,
    ModalTest,
    Preload,
    ReducedJoint,
    identify_modal,
)
from microslip.structures.periodic_motion import moving_modes
from microslip.study.build import blame, build_surface
from microslip.study.description import StudyDescription
from microslip.study.draws import Design, at_middle, is_uncertain
from microslip.study.modal_tests import MeasuredPart
from microslip.study.structure import StructurePart
from microslip.sweeps.quantiles import quantiles
from microslip.sweeps.ranking import ranking

_NAMES = {
    "joint.friction_coefficient": "friction coefficient",
    "structure.bolts.tension": "bolt tension",
    "structure.bolts.torque": "bolt torque",
    "structure.form.factor": "factor on the form",
}
_OF_LAWS = ("bolts.tension", "bolts.torque", "bolts.nut_factor", "bolts.thread_friction",
            "bolts.bearing_friction", "form.factor", "base_damping_ratio")  # fmt: skip
"""Keys of a structure that leave its reduced model as it is."""
_DENSE = 4096  # points at which bands interpolate between the samples


def run(study: StudyDescription, progress: Progress | None = None) -> StructurePrediction:
    """Reduce the structure of a study once, tighten it, and follow its modes with their bands."""
    tell = progress or (lambda share: None)
    design = Design(study) if is_uncertain(study) else None
    middle = at_middle(study)
    part = middle.structure
    assert part is not None  # who calls has looked
    joint = _reduced(middle)
    tell(0.2)
    with blame(study, "structure"):
        formed, state = _tightened(middle, joint)
    convergence = None
    if part.converge:
        with blame(study, "structure.converge"):
            convergence = _converged(middle, joint, state)
            joint = convergence.joint
            formed, state = _tightened(middle, joint)
    with blame(study, "structure.sensor"):
        _check_sensor(part.modes, moving_modes(joint.sensor("sensor"), state.model.shapes))
    with blame(study, "structure"):
        curves = [_solved(part, joint, state, number) for number in part.modes]
    tell(0.5)
    samples: list[Sampled | None] = [None] * len(part.modes)
    inputs: tuple[tuple[str, str], ...] = ()
    if design is not None:
        inputs = tuple((_NAMES.get(entry.key, entry.key), entry.written) for entry in design.inputs)
        samples = _samples(design, joint, lambda s: tell(0.5 + 0.5 * s))
    names = tuple(name for name, _ in inputs)
    modes = tuple(
        Mode(number, curve, curve.other_method, _bands(samples[index], part, names, convergence))
        for index, (number, curve) in enumerate(zip(part.modes, curves, strict=True))
    )
    identified = None
    tests = _tests(part.measured, modes)
    if part.fitted:
        with blame(study, "structure.measured.fit"):
            identified = _identified(middle, joint, tests)
    return StructurePrediction(part, formed, state, modes, inputs, identified, tests, convergence)


def _reduced(study: StudyDescription) -> ReducedJoint:
    """The reduced model of a study without anything uncertain."""
    part = study.structure
    assert part is not None  # who calls has looked
    with blame(study, "structure"):
        materials = {name: material.build() for name, material in study.material.items()}
        return part.reduce(materials, study.surface.materials[0])


def _converged(study: StudyDescription, joint: ReducedJoint, state: Preload) -> Convergence:
    """The model refined for the first mode, from the least to the largest amplitude."""
    part = study.structure
    assert part is not None  # who calls has looked
    curve = _solved(part, joint, state, part.modes[0])
    reached = curve.modal_amplitude[curve.converged]
    return part.convergence(
        study.material[study.surface.materials[0]].build(),
        build_surface(study),
        float(study.joint.friction_coefficient),
        np.unique(reached[[0, reached.size // 2, -1]]),
    )


def _check_sensor(numbers: tuple[int, ...], moving: list[int]) -> None:
    """The sensor must not lie in a node of a mode whose amplitudes it is to tell."""
    for number in numbers:
        if number - 1 not in moving:
            listed = ", ".join(str(i + 1) for i in moving[:6])
            raise InputError(
                f"mode {number} does not move there in that direction (modes {listed} do); leave "
                "it out of structure.modes, or put the sensor elsewhere"
            )


def _tests(measured: tuple[MeasuredPart, ...], modes: tuple[Mode, ...]) -> tuple[ModalTest, ...]:
    """The tests of a study; of the mode that it says, or whose frequency is nearest."""
    tests = []
    for test in measured:
        amplitude, frequency, damping = test.table.T
        number = test.mode
        if number is None:
            middle = float(np.exp(np.log(frequency).mean()))
            near = min(modes, key=lambda m: abs(math.log(m.curve.linear_frequency / middle)))
            number = near.number
        tests.append(
            ModalTest(
                amplitude,
                frequency,
                damping,
                mode=number - 1,
                frequency_error=test.frequency_error,
                damping_error=test.damping_error,
                name=Path(test.file).name,
            )
        )
    return tuple(tests)


def _identified(
    study: StudyDescription,
    joint: ReducedJoint,
    tests: tuple[ModalTest, ...],
) -> ModalIdentification:
    """What tests say of the joint, from the values of the study on."""
    part = study.structure
    assert part is not None  # who calls has looked
    return identify_modal(
        joint,
        build_surface(study),
        tests,
        part.fitted,
        friction_coefficient=float(study.joint.friction_coefficient),
        form=1.0 if part.form is None else float(part.form.factor),
        base_damping_ratio=part.base_damping_ratio,
        form_table=None if part.form is None else part.form.table,
    )


def _tightened(study: StudyDescription, joint: ReducedJoint) -> tuple[ReducedJoint, Preload]:
    """The joint with the form and the tension of a study, and its state under them."""
    part = study.structure
    assert part is not None  # who calls has looked
    if part.form is not None:
        joint = joint.with_form(part.form.table, part.form.factor)
    joint = joint.with_tension(part.tension)
    return joint, joint.tightened(build_surface(study), study.joint.friction_coefficient)


def _curve(part: StructurePart, joint: ReducedJoint, state: Preload, number: int) -> ModalCurve:
    """A mode along the amplitudes of a study."""
    return state.modes(
        number - 1,
        part.amplitudes,
        at=joint.sensor("sensor"),
        damping_ratio=part.base_damping_ratio,
        harmonics=part.harmonics,
    )


def _solved(part: StructurePart, joint: ReducedJoint, state: Preload, number: int) -> ModalCurve:
    curve = _curve(part, joint, state, number)
    if not curve.converged.any():
        raise InputError(f"mode {number} has no solution: {curve.message}")
    return curve


class Sampled(NamedTuple):
    """A mode over the samples of what is not known exactly."""

    scores: Floats
    """Inputs as normal scores, (samples, inputs)."""
    dense: Floats
    """The same at many more points."""
    frequency: Floats
    """(samples, amplitudes) [Hz]; NaN where the balance was not reached."""
    damping_ratio: Floats
    """The same [-]."""


def _samples(design: Design, joint: ReducedJoint, progress: Progress) -> list[Sampled | None]:
    """The curves of each mode over Sobol' points; the model anew where its drawing scatters."""
    study = design.study
    part = study.structure
    assert part is not None  # who calls has looked
    bodies = "material." if part.mesh else f"material.{study.surface.materials[0]}."
    anew = any(
        key.startswith((bodies, "structure."))
        and not key.endswith(".hardness")
        and key.removeprefix("structure.") not in _OF_LAWS
        for key in design.changed_keys
    )
    scores = design.scores(design.points(part.samples, 1)[0])
    curves = np.full((len(part.modes), 2, len(scores), len(part.amplitudes)), math.nan)
    for row, place in enumerate(scores):
        sample = design.at(place)
        sample_part = sample.structure
        assert sample_part is not None  # as in the study
        with blame(study, "structure"):
            model = _reduced(sample) if anew else joint
            _, state = _tightened(sample, model)
            for index, number in enumerate(sample_part.modes):
                curve = _curve(sample_part, model, state, number)
                curves[index, :, row] = curve.frequency, curve.damping_ratio
        progress((row + 1) / len(scores))
    dense = design.scores(design.points(_DENSE, 1)[0])
    return [Sampled(scores, dense, frequency, damping) for frequency, damping in curves]


def _bands(
    sampled: Sampled | None,
    part: StructurePart,
    names: tuple[str, ...],
    convergence: Convergence | None,
) -> Bands | None:
    """Quantiles, their ends moved out by what a finer model would change, and the ranking."""
    if sampled is None:
        return None
    scores, dense = sampled.scores, sampled.dense
    joints = sampled.damping_ratio - part.base_damping_ratio
    with np.errstate(invalid="ignore", divide="ignore"):
        logs = np.log(sampled.frequency), np.log(joints)
    (frequency, frequency_error), (damping, damping_error) = (
        quantiles(scores, log, dense, SHARES) for log in logs
    )
    model = _model_error(convergence)
    if model is not None:
        outwards = np.array([-1.0, 0.0, 1.0])[:, None]
        frequency, damping = frequency + model[0] * outwards, damping + model[1] * outwards
    return Bands(
        np.exp(frequency),
        np.exp(damping) + part.base_damping_ratio,
        _ranking(scores, joints[:, len(part.amplitudes) // 2], names),
        float(np.nanmax(frequency_error, initial=0.0)),
        float(np.nanmax(damping_error, initial=0.0)),
        int((~np.isfinite(sampled.frequency)).any(axis=1).sum()),
        model,
    )


def _model_error(convergence: Convergence | None) -> tuple[float, float] | None:
    """Of frequency and damping ratio [-]: the changes that were tried, as independent errors."""
    if convergence is None:
        return None
    changes = np.array([(c.frequency, c.damping_ratio) for c in convergence.changes])
    frequency, damping = np.sqrt((changes**2).sum(axis=0))
    return float(frequency), float(damping)


def _ranking(
    scores: Floats, damping: Floats, names: tuple[str, ...]
) -> tuple[tuple[str, float], ...]:
    """Shares of the inputs in the scatter of ln(damping), by a linear regression on them."""
    with np.errstate(divide="ignore", invalid="ignore"):
        shares, _ = ranking(scores, np.log(damping))
    pairs = [(name, float(share)) for name, share in zip(names, shares, strict=True)]
    return tuple(sorted(pairs, key=lambda pair: -pair[1]))
