"""Document of a bolted structure: its main result, sections, numbers, tables and arrays."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np

from microslip._core.dataset import DataSet
from microslip._core.quantities import QUANTITIES, count, dimensionless, json_value, named
from microslip._core.units import engineering
from microslip._core.wording import plural
from microslip.figures.kit import evenly
from microslip.figures.picture import Picture
from microslip.report import cells
from microslip.report.document import Block, Note, Section, Table
from microslip.report.structure.data import curves, force_numbers, force_rows
from microslip.report.structure.driven import (
    FORCED_FIGURE,
    force_plot,
    force_section,
    response_numbers,
)
from microslip.report.structure.judged import structure_verdicts
from microslip.report.structure.pictures import (
    curve_plot,
    loss_plot,
    pressure_plot,
    shape_plot,
    slip_plot,
)
from microslip.report.structure.tested import (
    fitted_numbers,
    fitted_section,
    tested_numbers,
    tested_sections,
)
from microslip.structures import Convergence
from microslip.structures.modal_curve import Resonance
from microslip.study.runs.structure_prediction import Mode, ModeBands, StructurePrediction

_PATCH = ("x", "y", "area", "gap", "normal_load")
_TERMINAL_ROWS = 8  # rows of all tables of modes together on a terminal


def structure_answer(prediction: StructurePrediction) -> str:
    """Describe frequency and damping at the largest amplitude, with bands and numerical errors."""
    mode = prediction.modes[0]
    curve, last, bands = mode.curve, mode.last, mode.bands
    frequency, damping = f"{curve.frequency[last]:.5g} Hz", cells.ratio(curve.damping_ratio[last])
    if bands is not None:
        low, high = bands.frequency[[0, -1], last]
        frequency += f" ({low:.5g} to {high:.5g})"
        damping += f" ({_band(bands, last)})"
    brackets = "" if bands is None else "; brackets: 5 to 95 %"
    return (
        f"Mode {mode.number} at {_place(prediction)} at the sensor: frequency {frequency}, damping "
        f"ratio in steady motion {damping}{brackets}. Fully stuck: "
        f"{curve.linear_frequency:.5g} Hz.{_outside(prediction)} {_errors(prediction)}"
    )


def _place(prediction: StructurePrediction) -> str:
    mode = prediction.modes[0]
    return engineering(float(mode.curve.amplitude[mode.last]), prediction.part.unit, 3)


def _outside(prediction: StructurePrediction) -> str:
    away = [verdict for verdict in prediction.judged if verdict.word != "inside"]
    text = ""
    if away:
        text = (
            f" {len(away)} of {len(prediction.judged)} tested quantities lie outside their bands."
        )
    beyond = [f for mode in prediction.modes for f in mode.forced if f.beyond]
    if beyond:
        text += " Not covered: forced responses beyond the largest amplitude."
    return text


def _errors(prediction: StructurePrediction) -> str:
    mode, convergence = prediction.modes[0], prediction.convergence
    model = "patches, mesh and reduction not estimated"
    if convergence is not None:
        model = f"patches, mesh and reduction ±{_part_of(convergence.error[1])} the joint's damping"
    elif prediction.patch_error is not None:
        model = f"patches about ±{_part_of(prediction.patch_error[1])} the joint's damping"
    left = float(abs(mode.curve.harmonic_error[mode.last]))
    errors = f"Errors: truncated harmonics ±{100.0 * left:.1f} %; {model}"
    if mode.bands is None:
        return f"{errors}."
    sampling = float(mode.bands.damping_error[mode.last])
    if math.isnan(sampling):
        return f"{errors}; no sample has a solution, so there is no band."
    if not math.isfinite(sampling):
        return f"{errors}; ends of the band unknown: too few samples."
    return f"{errors}; ends of this band ±{100.0 * sampling:.1f} % by sampling."


def _part_of(fraction: float) -> str:
    """Return a fraction as a part of what follows: "31 % of", or "1.5 times" above one."""
    return f"{100.0 * fraction:.2g} % of" if fraction < 0.995 else f"{fraction:.2g} times"


def _band(bands: ModeBands, place: int) -> str:
    return " to ".join(cells.ratio(bands.damping_ratio[end, place]) for end in (0, -1))


def structure_sections(prediction: StructurePrediction) -> tuple[Section, ...]:
    """Return the sections on the structure; a terminal omits those on the model and its figures."""
    rows = max(3, _TERMINAL_ROWS // len(prediction.modes))
    blocks: list[Block] = [_table(mode, prediction.part.unit, rows) for mode in prediction.modes]
    blocks += [Note(text, small=True) for text in _warnings(prediction)]
    blocks.append(Note(_methods(prediction), small=True, brief=False))
    parts = [Section("Frequency and damping", tuple(blocks))]
    parts += tested_sections(prediction)
    if prediction.part.force is not None:
        parts.append(force_section(prediction))
    if prediction.convergence is not None:
        parts.append(_convergence_section(prediction.convergence, prediction.part.modes[0]))
    if any(mode.bands is not None for mode in prediction.modes):
        parts.append(Section("Contributions to the scatter", _ranking(prediction.modes)))
    if prediction.identified is not None:
        parts.append(fitted_section(prediction, prediction.identified))
    parts.append(Section("Structure", (_model(prediction),), brief=False))
    parts.append(Section("Structure in figures", structure_pictures(prediction), brief=False))
    return tuple(parts)


def structure_pictures(prediction: StructurePrediction) -> tuple[Picture, ...]:
    """Return the figures with their captions."""
    markers = " Markers are the tests." if prediction.tests else ""
    if any(test.motion == "decay" for test in prediction.tests):
        markers += " Thin lines: free decay, to compare with ring-downs."
    fitted = (
        " Dotted: fitted to the tests, with its 5 to 95 % range."
        if prediction.identified is not None
        else ""
    )
    bands = " Shaded: 5 to 95 % of the uncertain inputs." if prediction.inputs else ""
    figures = {
        "modal_curves": (
            curve_plot,
            f"Frequency and damping ratio of each mode against the {prediction.part.quantity} "
            "amplitude at the sensor, in steady motion by harmonic balance."
            f"{bands}{markers}{fitted} {_errors(prediction)}",
            "Frequency and damping of the modes against amplitude",
        ),
        "pressure_map": (
            pressure_plot,
            "Mean pressure on each patch after tightening, seen from above.",
            "Pressure on the contact patches",
        ),
        "slip_map": (
            slip_plot,
            "Relative tangential amplitude of the two faces at each patch, at the largest "
            "amplitude: where it slips.",
            "Relative motion of the contact patches",
        ),
        "loss_map": (
            loss_plot,
            "Fraction of the energy dissipated per cycle in each patch, at the largest amplitude: "
            "patches should be fine where it is large, and form and friction matter there.",
            "Loss of the contact patches",
        ),
        "mode_shapes": (
            shape_plot,
            "The modes at the largest amplitude, seen from the side, or from above where they bend "
            "that way; the motion is exaggerated.",
            "Shapes of the modes",
        ),
    }
    if prediction.part.force is not None:
        figures[FORCED_FIGURE] = (
            force_plot,
            f"Amplitude at the sensor against the frequency of the force, near each mode.{bands}",
            "Response of the modes to the force",
        )
    return tuple(
        Picture(name, caption, partial(plot, prediction), alternative)
        for name, (plot, caption, alternative) in figures.items()
    )


def structure_numbers(prediction: StructurePrediction) -> dict[str, Any]:
    """Return the entry of the structure in the summary: plain values in SI units."""
    joint, state, convergence = prediction.joint, prediction.state, prediction.convergence
    of_joint = ("frequency", "joint_damping_ratio")
    parts = {
        "convergence": convergence and convergence.changes,
        "model_error": convergence and dict(zip(of_joint, convergence.error, strict=True)),
        "patch_error": prediction.patch_error
        and dict(zip(of_joint, prediction.patch_error, strict=True)),
        "from_asked_patches_to_limit": convergence
        and dict(zip(("frequency", "damping_ratio"), convergence.requested, strict=True)),
        "bolts": force_numbers(prediction.part.bolt_forces),
        "identified": prediction.identified and fitted_numbers(prediction.identified),
    }
    numbers = {
        "answer": structure_answer(prediction),
        "amplitude_quantity": prediction.part.quantity,
        "degrees_of_freedom": {"elements": joint.full_size, "reduced": joint.size},
        "equilibrium_error": state.equilibrium_error,
        "bolt_tension": joint.tensions(state.displacement, state.static_force),
        "uncertain": dict(prediction.inputs),
        "patches": [
            dict(zip(_PATCH, row, strict=True))
            for row in np.column_stack(
                [joint.patch_centres, joint.patch_areas, joint.patch_gaps, state.normal_loads]
            )
        ],
        "modes": [_mode_numbers(mode) for mode in prediction.modes],
        "verdicts": [
            named(verdict, "name", "value", "limit", "word")
            for verdict in structure_verdicts(prediction)
        ],
        **tested_numbers(prediction),
        **{name: part for name, part in parts.items() if part is not None},
    }
    return {name: json_value(value) for name, value in numbers.items()}


def _mode_numbers(mode: Mode) -> dict[str, Any]:
    bands, columns = mode.bands, curves(mode)
    result: dict[str, Any] = {
        "mode": mode.number,
        **named(mode.curve, "linear_frequency", "message"),
        **{key: columns[key] for key in _CURVES},
        "harmonic_error": mode.curve.harmonic_error,
        "loss_share": mode.loss(),
        "mac": mode.curve.mac,
        "near_resonances": [
            {"mode": r.mode + 1, **named(r, "multiple", "distance")} for r in mode.curve.near
        ],
    }
    if mode.forced:
        result["forced_response"] = [response_numbers(response) for response in mode.forced]
    if bands is not None:
        result["modal_frequency_bands"] = bands.frequency
        result["modal_damping_ratio_bands"] = bands.damping_ratio
        # Of each amplitude; infinite where few samples leave an end open.
        result["sampling_error"] = {
            "modal_frequency": bands.frequency_error,
            "modal_damping_ratio": bands.damping_error,
        }
        if bands.model_error is not None:
            frequency, damping = bands.model_error
            result["model_error"] = {"modal_frequency": frequency, "joint_damping_ratio": damping}
        result["unsolved_samples"] = bands.unsolved
        result["ranking"] = dict(bands.ranking)
    return result


def _model(prediction: StructurePrediction) -> Table:
    joint, state, part = prediction.joint, prediction.state, prediction.part
    tensions = joint.tensions(state.displacement, state.static_force)
    pressed = int((state.normal_loads > 0.0).sum())
    bolts = plural(len(tensions), "bolt")
    asked = int(np.prod(part.patches or 0)) * (int(joint.patch_contacts.max()) + 1)
    fewer = prediction.convergence is None and joint.patches < asked
    note = f" (of {asked}, the others outside the faces or merged)" if fewer else ""
    rows = [
        ("Finite elements", f"{joint.full_size} degrees of freedom"),
        ("Reduced to", f"{joint.patches} patches{note}, {bolts}, {joint.size} in all"),
        ("Bolt tension", ", ".join(engineering(float(t), "N", 4) for t in tensions)),
        *force_rows(part.bolt_forces),
        ("Patches in contact", f"{pressed} of {joint.patches}"),
        ("Largest pressure", engineering(float(state.pressures.max()), "Pa", 3)),
        ("Residual of the tightened state", f"{state.equilibrium_error:.1e} of the largest force"),
        ("Base damping, an input", cells.ratio(part.base_damping_ratio)),
        ("Form", _form(prediction)),
    ]
    rows += [(f"Uncertain inputs: {name}", text) for name, text in prediction.inputs]
    return cells.texts("Model", rows)


def _form(prediction: StructurePrediction) -> str:
    form = prediction.part.form
    if form is None:
        return "faces taken as flat"
    words = [] if form.table is None else [f"table of {form.file}"]
    if form.is_random:
        words.append("random faces in the samples, flat for the central values")
    if form.rim is not None:
        words.append("rims around the holes")
    return ", ".join(words)


_CURVES = ("amplitude", "modal_frequency", "modal_damping_ratio")


def _table(mode: Mode, unit: str, few: int) -> Table:
    columns = curves(mode)
    at_sensor = QUANTITIES["amplitude"]._replace(
        unit=unit, label="Amplitude at the sensor", form="3"
    )
    data = DataSet.of_rows(
        {
            name: (at_sensor if name == "amplitude" else QUANTITIES[name], columns[name])
            for name in sorted(columns, key=lambda name: name.startswith("modal_damping"))
        }
    )
    title = f"Mode {mode.number}, {mode.curve.linear_frequency:.5g} Hz fully stuck"
    shown = tuple(evenly(data.sizes["row"], few))
    hidden = tuple(name for name in data if name.endswith("median"))
    return Table(
        title, data, caption=mode.curve.message, noun="amplitudes", few=shown, hidden=hidden
    )


def _patches_remark(prediction: StructurePrediction) -> list[str]:
    form, joint = prediction.part.form, prediction.joint
    if form is None or not form.is_random:
        return []
    correlation = form.correlation
    shortest = float(getattr(correlation, "low", None) or correlation or 0.0)
    longest = float(np.diff(joint.patch_boxes)[:, [0, 2]].max())
    if longest <= 0.5 * shortest:
        return []
    return [
        f"Patches of {engineering(longest, 'm')} are longer than half the shortest correlation "
        f"length, {engineering(shortest, 'm')}: give more patches, or a longer correlation."
    ]


def _methods(prediction: StructurePrediction) -> str:
    errors = np.concatenate([abs(m.curve.harmonic_error) for m in prediction.modes])
    harmonics = ", ".join(map(str, prediction.part.harmonics))
    text = f"The effect of harmonics beyond {harmonics} is not known."
    if (known := errors[np.isfinite(errors)]).size:
        text = (
            f"Harmonics beyond {harmonics} would change the joint's damping by "
            f"{100.0 * known.max():.1f} %."
        )
    meshed = prediction.part.mesh is not None
    return " ".join(
        [text, *(_bands_remark(mode, prediction.part.unit, meshed) for mode in prediction.modes)]
    )


def _warnings(prediction: StructurePrediction) -> list[str]:
    """Return a sentence for each condition that makes the curves unreliable."""
    texts = [_resonance(mode, other) for mode in prediction.modes for other in mode.curve.near]
    macs = np.concatenate([m.curve.mac for m in prediction.modes])
    shapes = float(np.min(macs, where=np.isfinite(macs), initial=1.0))
    if shapes < _SAME_SHAPE:
        texts.append(f"Shapes change: their MAC with those of stuck joints falls to {shapes:.3f}.")
    return texts + _patches_remark(prediction)


_SAME_SHAPE = 0.99


def _resonance(mode: Mode, other: Resonance) -> str:
    times = "the frequency" if other.multiple == 1 else f"{other.multiple} times the frequency"
    return (
        f"Mode {other.mode + 1} is {100.0 * other.distance:+.1f} % away from {times} of mode "
        f"{mode.number}: an internal resonance is possible, which curves of one mode do not show."
    )


def _bands_remark(mode: Mode, unit: str, meshed: bool) -> str:
    if mode.bands is None:
        return ""
    errors = mode.bands.damping_error
    if np.isnan(errors).all():
        return (
            f"Mode {mode.number} has no bands: none of the samples has a solution; narrow the "
            "uncertain inputs or take smaller amplitudes."
        )
    least, most = float(np.nanmin(errors)), float(np.nanmax(errors))
    sampling = "of its outer quantiles is unknown: take more samples."
    if math.isfinite(most):
        at = engineering(float(mode.curve.amplitude[np.nanargmax(errors)]), unit, 3)
        sampling = (
            f"of the damping's quantiles is ±{100.0 * least:.1f} % to ±{100.0 * most:.1f} % "
            f"(90 %), most at {at}."
        )
    text = (
        f"Bands of mode {mode.number} are the 5, 50 and 95 % quantiles of harmonic balances at "
        "Sobol' points, interpolated where the inputs explain the result. The sampling error "
        f"{sampling}"
    )
    if mode.bands.unsolved:
        text += (
            f" {mode.bands.unsolved} samples do not reach all amplitudes and are left out there."
        )
    if mode.bands.model_error is None:
        remedy = "" if meshed else "; converge = true includes it"
        return f"{text} The error of patches, mesh and reduction is not included{remedy}."
    return (
        f"{text} Their ends are moved out by {_part_of(mode.bands.model_error[1])} the joint's "
        "damping, the error of patches, mesh and reduction."
    )


def _convergence_section(convergence: Convergence, number: int) -> Section:
    quantities = (
        count("Changed"),
        count("From"),
        count("To"),
        dimensionless("Frequency", "+.3%"),
        dimensionless("ζ", "+.2%"),
        dimensionless("Frequency, remaining", "+.3%"),
        dimensionless("ζ, remaining", "+.2%"),
    )
    names, columns = convergence.changes[0]._fields, zip(*convergence.changes, strict=True)
    pairs = zip(quantities, columns, strict=True)
    title = f"Mode {number}, the largest changes over its amplitudes"
    data = DataSet.of_rows(dict(zip(names, pairs, strict=True)))
    table = Table(title, data, noun="changes", brief=False)
    message = Note(f"{convergence.message}.", small=True)
    return Section("Convergence of the model", (table, message))


def _ranking(modes: tuple[Mode, ...]) -> tuple[Note, Table]:
    """Return the largest contributions to the scatter of ln ζ in words, and all in a table."""
    shares = {mode.number: dict(mode.bands.ranking) for mode in modes if mode.bands is not None}
    names = dict.fromkeys(name for share in shares.values() for name in share)
    columns: dict[str, Any] = {"input": (count("Fraction of the variance of ln ζ"), names)}
    for n, share in shares.items():
        of_mode = dimensionless(f"Mode {n}", "percent")
        columns[f"mode_{n}"] = of_mode, [share.get(name) for name in names]
    largest = "; ".join(
        f"mode {n}: "
        + ", ".join(f"{x} {100.0 * part:.0f} %" for x, part in list(share.items())[:2])
        for n, share in shares.items()
    )
    note = Note(f"Largest causes of the scatter of ζ: {largest}.")
    return note, Table("All inputs", DataSet.of_rows(columns), noun="inputs", brief=False)
