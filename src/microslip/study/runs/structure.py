"""Modes of the structure of a study, with bands over samples of its uncertain inputs."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from microslip._core.checks import Floats, Progress
from microslip._core.errors import InputError
from microslip.contact import NormalLaw
from microslip.friction.sweeps.quantiles import quantiles, regression
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
from microslip.structures.reduction_convergence import patch_error
from microslip.structures.tie_limits import tie_limits
from microslip.study.build import Design, build_surface, is_uncertain, naming_key
from microslip.study.description import StudyDescription
from microslip.study.measured_face import MeasuredFace
from microslip.study.runs.structure_prediction import (
    BAND_QUANTILES,
    Mode,
    ModeBands,
    ModeSamples,
    StructurePrediction,
    joint_damping,
)
from microslip.study.runs.structure_responses import (
    forced_mode,
    gain_of,
)
from microslip.study.runs.structure_tests import amplitude_trends, compare_tests
from microslip.study.structure import StructurePart
from microslip.study.uncertain import at_central_values, value_at
from microslip.study.vibration import MeasuredPart

_NAMES = {
    "surface.stiffness_factor": "factor on the normal stiffness",
    "surface.shape_factor": "factor on the energy of small cycles",
    "joint.friction_coefficient": "friction coefficient",
    "structure.bolts.tension": "bolt tension",
    "structure.bolts.torque": "bolt torque",
    "structure.bolts.embedding": "embedding of the bolts",
    "structure.form.factor": "factor on the form",
    "structure.form.flatness": "flatness of the faces",
    "structure.form.correlation": "correlation length of the faces",
    "structure.form.rim": "rim around the holes",
    "structure.base_damping_ratio": "base damping ratio",
}
_OF_LAWS = ("bolts.tension", "bolts.torque", "bolts.nut_factor", "bolts.thread_friction",
            "bolts.bearing_friction", "bolts.embedding", "bolts.rz", "bolts.clamp_length",
            "form.factor", "form.flatness", "form.correlation", "form.rim",
            "base_damping_ratio")  # fmt: skip
"""Keys of a structure that do not change its reduced model."""
_SIDES = ["structure.lap", "structure.width"]
BASE = "structure.base_damping_ratio"
_FACES = 44  # random stream of the faces of the samples
SAMPLE_RTOL = 1e-5  # of the curves of samples: errors of damping below 0.1 %
_DENSE = 16_384  # points of the surrogate model from which quantiles are computed


def run_structure(study: StudyDescription, progress: Progress | None = None) -> StructurePrediction:
    """Return the modes of the structure of a study, with bands if inputs are uncertain."""
    tell = progress or (lambda share: None)
    design = Design(study) if is_uncertain(study) else None
    middle = at_central_values(study)
    part = middle.bolted
    if isinstance(middle.surface, MeasuredFace):
        build_surface(middle, lambda share: tell(0.1 * share))  # solved once and cached
    joint = _reduced(middle)
    tell(0.2)
    with naming_key(study, "structure"):
        formed, state = tightened(middle, joint)
    convergence = None
    if part.converge:
        with naming_key(study, "structure.converge"):
            convergence = _converged(middle, joint, state, lambda share: tell(0.2 + 0.3 * share))
            joint = convergence.joint
            formed, state = tightened(middle, joint)
    with naming_key(study, "structure.sensor"):
        _check_sensor(part.modes, moving_modes(joint.sensor("sensor"), state.model.shapes))
    with naming_key(study, "structure"):
        curves = [_solved(part, joint, state, number) for number in part.modes]
    coarse = None if part.converge else _patch_error(middle, joint, curves[0])
    tell(0.5)
    samples: list[ModeSamples | None] = [None] * len(part.modes)
    inputs: tuple[tuple[str, str], ...] = ()
    if design is not None:
        inputs = tuple((_NAMES.get(entry.key, entry.key), entry.written) for entry in design.inputs)
        samples = _samples(design, middle, joint, curves, lambda s: tell(0.5 + 0.5 * s))
    names = tuple(name for name, _ in inputs)
    forces = () if part.force is None else part.force.amplitude
    modes = tuple(
        Mode(
            number,
            curve,
            _bands(samples[index], part, names, convergence),
            tuple(forced_mode(part, joint, curve, samples[index], force) for force in forces),
        )
        for index, (number, curve) in enumerate(zip(part.modes, curves, strict=True))
    )
    identified = None
    tests = _tests(part.measured, modes)
    if part.fitted:
        with naming_key(study, "structure.measured.fit"):
            identified = _identified(middle, joint, tests)
    shapes = state.model.shapes[:, [number - 1 for number in part.modes]]
    return StructurePrediction(
        part, formed, state, modes, inputs, identified, tests, convergence, coarse,
        tuple(tie_limits(joint, part.washers, shapes)),
        compare_tests(tests, modes, part.quantity), amplitude_trends(tests, modes),
    )  # fmt: skip


def _reduced(study: StudyDescription, patches: Floats | None = None) -> ReducedJoint:
    part = study.bolted
    reduction = part.reduction if patches is None else part.reduction | {"patches": patches}
    with naming_key(study, "structure"):
        return part.reducer().reduce(**reduction)


def _converged(
    study: StudyDescription, joint: ReducedJoint, state: Preload, progress: Progress
) -> Convergence:
    """Return the model with patches refined until the damping ratio of a mode converges.

    The mode is the first one of the study. Convergence is judged at the smallest, a middle and the
    largest amplitude that were solved.
    """
    part = study.bolted
    curve = _solved(part, joint, state, part.modes[0])
    reached = curve.modal_amplitude[curve.converged]
    return part.build().converge(
        *part.body,
        build_surface(study),
        float(study.joint.friction_coefficient),
        np.unique(reached[[0, reached.size // 2, -1]]),
        mode=part.modes[0] - 1,
        patches=part.reduction["patches"],
        form=part.gaps,
        element_size=part.element_size,
        sensors=part.sensors,
        progress=progress,
    )


def _patch_error(
    study: StudyDescription, joint: ReducedJoint, curve: ModalCurve
) -> tuple[float, float] | None:
    """Return the relative errors of frequency and joint damping due to the patch size [-]."""
    part, solved = study.bolted, np.flatnonzero(curve.converged)

    def solve(trial: ReducedJoint) -> tuple[Floats, Floats]:
        found = tightened(study, trial)[1].modes(
            curve.index,
            part.amplitudes[solved[[solved.size // 2, -1]]],
            at=trial.sensor("sensor"),
            quantity=part.quantity,  # type: ignore[arg-type]
            harmonics=part.harmonics,
            rtol=SAMPLE_RTOL,
        )
        return found.frequency, found.damping_ratio

    error = patch_error(joint, solve)
    return error if error is None or np.isfinite(error).all() else None


def _check_sensor(numbers: tuple[int, ...], moving: list[int]) -> None:
    for number in numbers:
        if number - 1 not in moving:
            listed = ", ".join(str(i + 1) for i in moving[:6])
            raise InputError(
                f"mode {number} has no motion there in that direction (modes {listed} have); "
                "remove it from structure.modes, or move the sensor"
            )


def _tests(measured: tuple[MeasuredPart, ...], modes: tuple[Mode, ...]) -> tuple[ModalTest, ...]:
    """Return the tests of a study; one without a mode number gets the mode of nearest frequency."""
    tests = []
    for part in measured:
        number = part.mode
        if number is None:
            middle = float(np.exp(np.log(part.test.frequency).mean()))
            near = min(modes, key=lambda m: abs(math.log(m.curve.linear_frequency / middle)))
            number = near.number
        tests.append(replace(part.test, mode=number - 1))
    return tuple(tests)


def _identified(
    study: StudyDescription,
    joint: ReducedJoint,
    tests: tuple[ModalTest, ...],
) -> ModalIdentification:
    part = study.bolted
    body = study.surface.materials[0]

    def surface(modulus: float) -> NormalLaw:
        """Return the surface with Young's modulus of its first material times ``modulus`` [-]."""
        given = study.material[body]
        scaled = given.copy(young_modulus=modulus * given.young_modulus)
        return build_surface(study.copy(material={**study.material, body: scaled}))

    return identify_modal(
        joint,
        surface,
        tests,
        part.fitted,
        friction_coefficient=float(study.joint.friction_coefficient),
        form=1.0 if part.form is None else float(part.form.factor),
        base_damping_ratio=part.base_damping_ratio,
        form_table=None if part.form is None else part.form.table,
    )


def tightened(
    study: StudyDescription, joint: ReducedJoint, rng: np.random.Generator | None = None
) -> tuple[ReducedJoint, Preload]:
    """Return the joint with gaps between its unloaded faces, and its state with tightened bolts.

    Random faces are drawn with ``rng``; without it they are flat.
    """
    part = study.bolted
    if part.form is not None:
        joint = part.form.apply(joint, part.holes, rng)
    joint = joint.with_tension(part.tension)
    return joint, joint.tightened(build_surface(study), study.joint.friction_coefficient)


def modal_curve(
    part: StructurePart, joint: ReducedJoint, state: Preload, number: int, rtol: float = 1e-10
) -> ModalCurve:
    """Return a mode of a study, counted from 1, at its amplitudes."""
    return state.modes(
        number - 1,
        part.amplitudes,
        at=joint.sensor("sensor"),
        quantity=part.quantity,  # type: ignore[arg-type]
        damping_ratio=part.base_damping_ratio,
        harmonics=part.harmonics,
        rtol=rtol,
    )


def _solved(part: StructurePart, joint: ReducedJoint, state: Preload, number: int) -> ModalCurve:
    curve = modal_curve(part, joint, state, number)
    if not curve.converged.any():
        raise InputError(f"mode {number} has no solution: {curve.message}")
    return curve


def _samples(
    design: Design,
    middle: StudyDescription,
    joint: ReducedJoint,
    curves: list[ModalCurve],
    progress: Progress,
) -> list[ModeSamples | None]:
    """Return the curves of each mode for samples of the inputs at Sobol' points.

    The model is reduced again only for uncertain dimensions: for an uncertain modulus or mass
    density it is scaled, and base damping is added to the solution.
    """
    study = design.study
    part = study.bolted
    scaled, anew = scaling_keys(study), bool(keys_of_model(study, design.spreads))
    scores = design.scores(design.points(part.samples, 1)[0])
    dense = design.scores(np.concatenate(design.points(_DENSE)))
    base = _base_damping(design, part, scores), _base_damping(design, part, dense)

    def numbers(curve: ModalCurve, model: ReducedJoint) -> Floats:
        gain = 1.0 if part.force is None else gain_of(curve, model)
        return np.array([
            curve.frequency, joint_damping(curve),
            gain * np.ones(curve.amplitude.size),
        ])  # fmt: skip

    # With only the base damping uncertain, all samples have the same curve.
    at_middle = np.array([numbers(curve, joint) for curve in curves])
    samples = np.repeat(at_middle[:, :, None], len(scores), axis=2)
    for row, place in enumerate(scores if design.spreads.keys() != {BASE} else ()):
        sample = design.at(place)
        sample_part = sample.bolted
        with naming_key(study, "structure"):
            if anew:
                sides = [] if part.mesh else _SIDES
                lap, width = scales(middle, sample, sides) or (1.0, 1.0)
                model = _reduced(sample, joint.layout * [1.0, lap, lap, width, width])
            else:
                model = joint.scaled(*scales(middle, sample, scaled))
            rng = np.random.default_rng([design.part.seed, _FACES, row])
            _, state = tightened(sample, model, rng)
            for index, number in enumerate(sample_part.modes):
                curve = modal_curve(sample_part, model, state, number, SAMPLE_RTOL)
                samples[index, :, row] = numbers(curve, model)
        progress((row + 1) / len(scores))
    return [ModeSamples(scores, dense, f, zeta, gain, base) for f, zeta, gain in samples]


def scaling_keys(study: StudyDescription) -> list[str]:
    """Return the keys whose values only scale the stiffness or the mass matrix of the model."""
    if study.bolted.mesh:
        return []
    return [f"material.{study.surface.materials[0]}.young_modulus", "structure.density"]


def keys_of_model(study: StudyDescription, keys: Iterable[str]) -> list[str]:
    """Return the given keys whose change requires a new reduced model."""
    part = study.bolted
    body = f"material.{study.surface.materials[0]}."
    scaled = scaling_keys(study)
    return sorted(
        key
        for key in keys
        if key.startswith(("material." if part.mesh else body, "structure."))
        and not key.endswith(".hardness")
        and key.removeprefix("structure.") not in _OF_LAWS
        and key not in scaled
    )


def scales(middle: StudyDescription, sample: StudyDescription, keys: list[str]) -> list[float]:
    """Return the ratio of a sample's value to the central value, for each of the keys."""
    return [value_at(sample, key) / value_at(middle, key) for key in keys]  # type: ignore[operator]


def _base_damping(design: Design, part: StructurePart, scores: Floats) -> Floats:
    """Return the base damping ratio [-] for rows of normal scores, shape (samples,)."""
    from scipy.special import ndtr

    base = part.base_damping_ratio
    if BASE not in design.spreads:
        return np.full(len(scores), float(base))
    column = list(design.spreads).index(BASE)
    return design.spreads[BASE].quantiles(ndtr(scores[:, column]))


def _bands(
    sampled: ModeSamples | None,
    part: StructurePart,
    names: tuple[str, ...],
    convergence: Convergence | None,
) -> ModeBands | None:
    """Return quantiles of frequency and damping of a mode, and contributions of the inputs.

    The outer quantiles are moved outwards by the discretisation error of the refined model.
    """
    if sampled is None:
        return None
    scores, dense = sampled.scores, sampled.dense
    with np.errstate(invalid="ignore", divide="ignore"):
        logs = np.log(sampled.frequency), np.log(sampled.joint_damping)
    middle = len(part.amplitudes) // 2
    total = sampled.joint_damping[:, middle] + sampled.base_damping[0]
    with np.errstate(invalid="ignore", divide="ignore"):
        of_middle = {"frequency": logs[0][:, middle], "damping_ratio": np.log(total)}
    found = {name: regression(scores, values) for name, values in of_middle.items()}
    slopes = {
        name: tuple(zip(names, per_input.tolist(), strict=True))
        for name, (per_input, _, _) in found.items()
    }
    frequency, frequency_error = quantiles(scores, logs[0], dense, BAND_QUANTILES)
    damping, damping_error = quantiles(scores, logs[1], dense, BAND_QUANTILES, sampled.base_damping)
    model = None if convergence is None else convergence.error
    if model is not None:
        outwards = np.array([-1.0, 0.0, 1.0])[:, None]
        frequency = frequency + model[0] * outwards
        # This error affects only the damping of the joint.
        of_joint = 1.0 - float(sampled.base_damping[0].mean()) / np.exp(damping)
        damping = damping + model[1] * np.maximum(of_joint, 0.0) * outwards
    random = part.form is not None and part.form.is_random
    return ModeBands(
        np.exp(frequency),
        np.exp(damping),
        _ranking(names, *found["damping_ratio"][1:], random),
        slopes,
        frequency_error.max(axis=0),
        damping_error.max(axis=0),
        int((~np.isfinite(sampled.frequency)).any(axis=1).sum()),
        model,
    )


def _ranking(
    names: tuple[str, ...], shares: Floats, explained: float, random: bool
) -> tuple[tuple[str, float], ...]:
    """Return the fraction of the variance of ln(damping ratio) due to each input, largest first.

    The unexplained fraction is attributed to random faces, if there are any.
    """
    pairs = [(name, float(share)) for name, share in zip(names, shares, strict=True)]
    if random:
        explained = min(max(explained, 0.0), 1.0)
        pairs = [(name, explained * share) for name, share in pairs]
        pairs.append(("waves of the faces", 1.0 - explained))
    return tuple(sorted(pairs, key=lambda pair: -pair[1]))
