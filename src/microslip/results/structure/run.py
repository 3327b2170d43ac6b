"""From the structure of a study to its modes, and their bands on one reduced model."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np

from microslip._core.checks import Floats
from microslip.errors import InputError
from microslip.normal import NormalLaw
from microslip.results.structure.prediction import SHARES, Bands, Mode, StructurePrediction
from microslip.structures import (
    ModalCurve,
    ModalIdentification,
    ModalTest,
    Preload,
    ReducedJoint,
    identify_modal,
)
from microslip.structures.amplitude import moving_modes
from microslip.study.build import blame, build_surface
from microslip.study.description import StudyDescription
from microslip.study.structure import MeasuredPart
from microslip.study.uncertain import Spread
from microslip.sweeps.ranking import ranking

Progress = Callable[[float], None]

FRICTION, TENSION, FORM = "friction coefficient", "bolt tension", "factor on the form"


def run(study: StudyDescription, progress: Progress | None = None) -> StructurePrediction:
    """Reduce the structure of a study once, tighten it, and follow its modes.

    Parameters
    ----------
    study : Study
        A study with a structure.
    progress : callable, optional
        Called now and then with the share that is done, 0 … 1.

    Returns
    -------
    StructurePrediction
        Its modes, with bands where something is given as a range.

    Raises
    ------
    StudyError
        If the physics has no answer.
    """
    tell = progress or (lambda share: None)
    part = study.structure
    assert part is not None  # who calls has looked
    surface = build_surface(study)
    with blame(study, "structure"):
        materials = {name: material.build() for name, material in study.material.items()}
        joint = part.reduce(materials, study.surface.materials[0])
    tell(0.2)
    spreads = uncertain(study)
    centre = {name: float(spread) for name, spread in spreads.items()}
    with blame(study, "structure"):
        state = _state(study, joint, surface, centre)
    with blame(study, "structure.sensor"):
        _check_sensor(part.modes, moving_modes(joint.sensor("sensor"), state.model.shapes))
    with blame(study, "structure"):
        pairs = [_pair(study, joint, state, number) for number in part.modes]
    tell(0.5)
    samples = _samples(study, joint, surface, spreads, lambda s: tell(0.5 + 0.5 * s))
    modes = tuple(
        Mode(number, curve, quick, _bands(curve, quick, samples[index], spreads))
        for index, (number, (curve, quick)) in enumerate(zip(part.modes, pairs, strict=True))
    )
    inputs = tuple((name, spread.written) for name, spread in spreads.items())
    identified = None
    tests = _tests(part.measured, modes)
    if part.fitted:
        with blame(study, "structure.measured.fit"):
            identified = _identified(study, joint, surface, tests)
    formed = _formed(study, joint, centre)
    return StructurePrediction(part, formed, state, modes, inputs, identified, tests)


def _check_sensor(wanted: tuple[int, ...], moving: list[int]) -> None:
    """The sensor must not lie in a node of a mode whose amplitudes it is to tell."""
    for number in wanted:
        if number - 1 not in moving:
            others = ", ".join(str(i + 1) for i in moving[:6])
            raise InputError(
                f"mode {number} does not move there in that direction (modes {others} do); leave "
                "it out of structure.modes, or put the sensor elsewhere"
            )


def _tests(measured: tuple[MeasuredPart, ...], modes: tuple[Mode, ...]) -> tuple[ModalTest, ...]:
    """The tests of a study; of the mode that it says, or whose frequency is nearest."""
    found = []
    for test in measured:
        amplitude, frequency, damping = test.table.T
        number = test.mode
        if number is None:
            middle = float(np.exp(np.log(frequency).mean()))
            near = min(modes, key=lambda m: abs(math.log(m.curve.linear_frequency / middle)))
            number = near.number
        found.append(
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
    return tuple(found)


def _identified(
    study: StudyDescription,
    joint: ReducedJoint,
    surface: NormalLaw,
    tests: tuple[ModalTest, ...],
) -> ModalIdentification:
    """What tests say of the joint, from the values of the study on."""
    part = study.structure
    assert part is not None  # who calls has looked
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


def uncertain(study: StudyDescription) -> dict[str, Spread]:
    """What a study gives as a range, by name."""
    part = study.structure
    assert part is not None  # who calls has looked
    given = {
        FRICTION: study.joint.friction_coefficient,
        TENSION: part.bolts.tension if part.bolts.torque is None else part.bolts.torque,
        FORM: None if part.form is None else part.form.factor,
    }
    return {name: value for name, value in given.items() if isinstance(value, Spread)}


def _formed(study: StudyDescription, joint: ReducedJoint, values: dict[str, float]) -> ReducedJoint:
    """The joint with its form and its tension at some values of what is uncertain."""
    part = study.structure
    assert part is not None  # who calls has looked
    if part.form is not None:
        joint = joint.with_form(part.form.table, values.get(FORM, float(part.form.factor)))
    if TENSION in values:
        bolts = part.bolts
        middle = float(bolts.tension if bolts.torque is None else bolts.torque)  # type: ignore[arg-type]
        joint = joint.with_tension(joint.bolt_tension * (values[TENSION] / middle))
    return joint


def _state(
    study: StudyDescription, joint: ReducedJoint, surface: NormalLaw, values: dict[str, float]
) -> Preload:
    friction = values.get(FRICTION, float(study.joint.friction_coefficient))
    return _formed(study, joint, values).tightened(surface, friction)


def _quick(study: StudyDescription, joint: ReducedJoint, state: Preload, number: int) -> ModalCurve:
    part = study.structure
    assert part is not None  # who calls has looked
    return state.modes(
        number - 1,
        part.amplitudes,
        at=joint.sensor("sensor"),
        damping_ratio=part.base_damping_ratio,
        method="quasi-static",
    )


def _pair(
    study: StudyDescription, joint: ReducedJoint, state: Preload, number: int
) -> tuple[ModalCurve, ModalCurve]:
    quick = _quick(study, joint, state, number)
    curve = quick.other_method
    if not curve.converged.any():
        raise InputError(f"mode {number} has no solution: {curve.message}")
    return curve, quick


Sampled = tuple[Floats, Floats, Floats]
"""Inputs as normal scores (samples, inputs); frequencies and damping (samples, amplitudes)."""


def _samples(
    study: StudyDescription,
    joint: ReducedJoint,
    surface: NormalLaw,
    spreads: dict[str, Spread],
    progress: Progress,
) -> list[Sampled | None]:
    """Quasi-static curves of each mode over Sobol' points; only the laws change."""
    part = study.structure
    assert part is not None  # who calls has looked
    if not spreads:
        return [None] * len(part.modes)
    from scipy.special import ndtri
    from scipy.stats import qmc

    count = 2 ** math.ceil(math.log2(part.samples))
    # Sobol' points fill the space more evenly than random ones, and powers of two most of all.
    points = qmc.Sobol(len(spreads), scramble=True, rng=0).random(count)
    columns = [s.quantiles(points[:, k]) for k, s in enumerate(spreads.values())]
    found = np.full((len(part.modes), 2, count, len(part.amplitudes)), math.nan)
    for row in range(count):
        values = {name: float(c[row]) for name, c in zip(spreads, columns, strict=True)}
        with blame(study, "structure"):
            state = _state(study, joint, surface, values)
            for index, number in enumerate(part.modes):
                curve = _quick(study, joint, state, number)
                found[index, :, row] = curve.frequency, curve.damping_ratio
        progress((row + 1) / count)
    scores = ndtri(points)
    return [(scores, frequency, damping) for frequency, damping in found]


def _bands(
    curve: ModalCurve, quick: ModalCurve, sampled: Sampled | None, spreads: dict[str, Spread]
) -> Bands | None:
    """Quantiles, moved to where the balance of harmonics has the middle, and the ranking."""
    if sampled is None:
        return None
    scores, frequency, damping = sampled
    middle = len(curve.amplitude) // 2
    return Bands(
        np.nanquantile(frequency * (curve.frequency / quick.frequency), SHARES, axis=0),
        np.nanquantile(damping * (curve.damping_ratio / quick.damping_ratio), SHARES, axis=0),
        _ranking(scores, damping[:, middle], tuple(spreads)),
    )


def _ranking(
    scores: Floats, damping: Floats, names: tuple[str, ...]
) -> tuple[tuple[str, float], ...]:
    """Shares of the inputs in the scatter of ln(damping), by a linear regression on them."""
    with np.errstate(divide="ignore", invalid="ignore"):
        shares, _ = ranking(scores, np.log(damping))
    pairs = [(name, float(share)) for name, share in zip(names, shares, strict=True)]
    return tuple(sorted(pairs, key=lambda pair: -pair[1]))
