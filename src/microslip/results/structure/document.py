"""What is said of a bolted structure: its answer, its sections, its numbers and its table."""

from __future__ import annotations

from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip._core.units import engineering
from microslip.report import cells
from microslip.report.document import (
    Block,
    Column,
    Facts,
    Note,
    Number,
    Picture,
    Section,
    Table,
    Verdicts,
)
from microslip.report.files import plain
from microslip.results.structure.pictures import (
    curve_plot,
    loss_plot,
    pressure_plot,
    shape_plot,
    slip_plot,
)
from microslip.results.structure.prediction import Mode, StructurePrediction
from microslip.structures import Convergence, ModalIdentification

FIGURES = ("modal_curves", "pressure_map", "slip_map", "loss_map", "mode_shapes")
"""Names of the figures."""

_BANDS = (
    "Bands are the 5, 50 and 95 % of quasi-static curves over Sobol' points, on one reduced model, "
    "moved to where the balance of harmonics has the middle."
)


def answer(prediction: StructurePrediction) -> str:
    """The result in a sentence."""
    mode = prediction.modes[0]
    last = _last(mode)
    curve = mode.curve
    band = ""
    if mode.bands is not None:
        low, _, high = mode.bands.damping_ratio[:, last]
        band = f" (5–95 %: {cells.ratio(low)} to {cells.ratio(high)})"
    return (
        f"Mode {mode.number} lies at {curve.linear_frequency:.5g} Hz while all sticks; at "
        f"{engineering(float(curve.amplitude[last]), 'm', 3)} at the sensor it is at "
        f"{curve.frequency[last]:.5g} Hz, and its damping ratio is "
        f"{cells.ratio(float(curve.damping_ratio[last]))}{band}."
    )


def number(prediction: StructurePrediction) -> Number:
    """The damping ratio at the largest amplitude, with its band."""
    mode = prediction.modes[0]
    last = _last(mode)
    place = engineering(float(mode.curve.amplitude[last]), "m", 3)
    band = f"quasi-static: {cells.ratio(float(mode.quick.damping_ratio[last]))}"
    if mode.bands is not None:
        low, _, high = mode.bands.damping_ratio[:, last]
        band = f"5 to 95 %: {cells.ratio(low)} to {cells.ratio(high)}"
    value = cells.ratio(float(mode.curve.damping_ratio[last]))
    return Number(f"damping ratio ζ of mode {mode.number} at {place}", value, band)


def sections(prediction: StructurePrediction) -> tuple[Section, ...]:
    """The parts of a document that are about the structure, the first ones to read."""
    parts = [Section("Structure", (_model(prediction),))]
    blocks: list[Block] = [_table(mode) for mode in prediction.modes]
    ranking = [_ranking(mode) for mode in prediction.modes if mode.bands is not None]
    parts.append(Section("Frequency and damping", (*blocks, Note(_remark(prediction), small=True))))
    if prediction.convergence is not None:
        parts.append(_how_good(prediction.convergence, prediction.part.modes[0]))
    if ranking:
        parts.append(Section("What decides", tuple(ranking)))
    if prediction.identified is not None:
        parts.append(_fitted(prediction.identified))
    parts.append(Section("Structure in figures", pictures(prediction), brief=False))
    return tuple(parts)


def pictures(prediction: StructurePrediction) -> tuple[Picture, ...]:
    """The figures."""
    markers = " Markers are the tests." if prediction.tests else ""
    bands = " Shaded: 5 to 95 % of what is not known." if prediction.inputs else ""
    return (
        Picture(
            "modal_curves",
            "Frequency and damping ratio of each mode against the displacement amplitude at the "
            f"sensor, by balance of harmonics; dashed: quasi-static.{bands}{markers}",
            lambda: curve_plot(prediction),
            "Frequency and damping of the modes against amplitude",
        ),
        Picture(
            "pressure_map",
            "Mean pressure on each patch after tightening, seen from above.",
            lambda: pressure_plot(prediction),
            "Pressure on the contact patches",
        ),
        Picture(
            "slip_map",
            "Relative tangential amplitude of the two faces at each patch, at the largest "
            "amplitude: where it slips.",
            lambda: slip_plot(prediction),
            "Relative motion of the contact patches",
        ),
        Picture(
            "loss_map",
            "Share of each patch in the energy lost a cycle, at the largest amplitude: there the "
            "patches should be fine, and there form and friction count.",
            lambda: loss_plot(prediction),
            "Loss of the contact patches",
        ),
        Picture(
            "mode_shapes",
            "The modes at the largest amplitude, seen from the side, or from above where they bend "
            "that way; the motion is exaggerated.",
            lambda: shape_plot(prediction),
            "Shapes of the modes",
        ),
    )


def numbers(prediction: StructurePrediction) -> dict[str, Any]:
    """What the summary holds of the structure: plain values in SI units."""
    joint, state, convergence = prediction.joint, prediction.state, prediction.convergence
    parts = {
        "convergence": convergence and [change._asdict() for change in convergence.changes],
        "identified": prediction.identified and _identified(prediction.identified),
    }
    return {
        "answer": answer(prediction),
        "degrees_of_freedom": {"elements": joint.full_size, "reduced": joint.size},
        "equilibrium_error": state.equilibrium_error,
        "bolt_tension": joint.tensions(state.displacement, state.static_force).tolist(),
        "uncertain": dict(prediction.inputs),
        "patches": [
            dict(zip(("x", "y"), map(float, centre), strict=True))
            | {"area": float(area), "gap": float(gap), "normal_load": float(load)}
            for centre, area, gap, load in zip(
                joint.patch_centres, joint.patch_areas, joint.patch_gaps, state.normal_loads,
                strict=True,
            )
        ],
        "modes": [_mode_numbers(mode) for mode in prediction.modes],
        **{name: part for name, part in parts.items() if part is not None},
    }  # fmt: skip


def columns(prediction: StructurePrediction) -> dict[str, Floats]:
    """The curves of all modes in long form, for a CSV file."""
    parts: list[dict[str, Floats]] = []
    for mode in prediction.modes:
        size = mode.curve.amplitude.size
        part = {
            "mode": np.full(size, float(mode.number)),
            "amplitude": mode.curve.amplitude,
            "modal_frequency": mode.curve.frequency,
            "modal_damping_ratio": mode.curve.damping_ratio,
            "quasi_static_frequency": mode.quick.frequency,
            "quasi_static_damping_ratio": mode.quick.damping_ratio,
        }
        if mode.bands is not None:
            for name, values in (
                ("frequency", mode.bands.frequency),
                ("damping_ratio", mode.bands.damping_ratio),
            ):
                for word, row in zip(("low", "median", "high"), values, strict=True):
                    part[f"modal_{name}_{word}"] = row
        parts.append(part)
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _identified(identified: ModalIdentification) -> dict[str, Any]:
    return {
        "values": dict(identified.values),
        "intervals": {name: list(ends) for name, ends in identified.intervals.items()},
        "correlation": identified.correlation.tolist(),
        "misfit": plain(identified.misfit),
        "verdicts": [v.word for v in identified.verdicts],
    }


def _mode_numbers(mode: Mode) -> dict[str, Any]:
    curve, bands = mode.curve, mode.bands
    result: dict[str, Any] = {
        "mode": mode.number,
        "linear_frequency": curve.linear_frequency,
        "message": curve.message,
        "amplitude": plain(curve.amplitude),
        "modal_frequency": plain(curve.frequency),
        "modal_damping_ratio": plain(curve.damping_ratio),
        "quasi_static_damping_ratio": plain(mode.quick.damping_ratio),
        "loss_share": plain(mode.loss()),
    }
    if bands is not None:
        result["modal_frequency_bands"] = plain(bands.frequency)
        result["modal_damping_ratio_bands"] = plain(bands.damping_ratio)
        result["ranking"] = dict(bands.ranking)
    return result


def _last(mode: Mode) -> int:
    return int(np.flatnonzero(mode.curve.converged)[-1])


def _model(prediction: StructurePrediction) -> Facts:
    joint, state, part = prediction.joint, prediction.state, prediction.part
    tensions = joint.tensions(state.displacement, state.static_force)
    pressed = int((state.normal_loads > 0.0).sum())
    bolts = f"{len(tensions)} bolt{'s' if len(tensions) > 1 else ''}"
    rows = [
        ("Finite elements", f"{joint.full_size} degrees of freedom"),
        ("Reduced to", f"{joint.patches} patches, {bolts}, {joint.size} in all"),
        ("Bolt tension", ", ".join(engineering(float(t), "N", 4) for t in tensions)),
        ("Patches in contact", f"{pressed} of {joint.patches}"),
        ("Largest pressure", engineering(float(state.pressures.max()), "Pa", 3)),
        ("Balance of the tightened state", f"{state.equilibrium_error:.1e} of the largest force"),
        ("Base damping, an input", cells.ratio(part.base_damping_ratio)),
    ]
    rows += [(f"Not known exactly: {name}", text) for name, text in prediction.inputs]
    return Facts("Model", tuple(rows))


def _table(mode: Mode) -> Table:
    curve, bands = mode.curve, mode.bands
    listed = [
        Column("amplitude", "Amplitude at the sensor", "m", 3, short="amplitude"),
        Column("modal_frequency", "Frequency", "Hz", write=lambda f: f"{f:.5g}", short="Hz"),
        Column("modal_damping_ratio", "Damping ratio ζ", "", write=cells.ratio, short="ζ"),
        Column("quasi_static_damping_ratio", "ζ, quasi-static", "", write=cells.ratio),
    ]
    values = [curve.amplitude, curve.frequency, curve.damping_ratio, mode.quick.damping_ratio]
    if bands is not None:
        for name, row in zip(("5 %", "50 %", "95 %"), bands.damping_ratio, strict=True):
            listed.append(Column(f"damping_{name}", f"ζ, {name}", "", write=cells.ratio))
            values.append(row)
    rows = tuple(zip(*map(plain, values), strict=True))
    title = f"Mode {mode.number}, {curve.linear_frequency:.5g} Hz while all sticks"
    return Table(title, tuple(listed), rows, caption=curve.message, noun="amplitudes")


def _remark(prediction: StructurePrediction) -> str:
    worst = max(
        (float(np.nanmax(abs(m.curve.damping_difference))) for m in prediction.modes), default=0.0
    )
    text = f"The quasi-static damping differs from the balance of harmonics by up to {worst:.0%}."
    return f"{text} {_BANDS}" if prediction.inputs else text


_FITTED = {
    "friction_coefficient": "Friction coefficient",
    "tension": "Bolt tension, of the study's",
    "form": "Factor on the form",
    "base_damping_ratio": "Base damping ratio",
}


def _fitted(identified: ModalIdentification) -> Section:
    """What the test says of the joint, and what it does not."""
    listed = (
        Column("parameter", "Parameter"),
        Column("value", "Value", "", write=cells.ratio),
        Column("low", "5 %", "", write=cells.ratio),
        Column("high", "95 %", "", write=cells.ratio),
    )
    rows = tuple(
        (_FITTED[name], value, *identified.intervals[name])
        for name, value in identified.values.items()
    )
    table = Table("Fitted to the test", listed, rows, noun="parameters")
    return Section(
        "Fitted to the test",
        (table, Verdicts(identified.verdicts, caption=_correlated(identified))),
    )


def _correlated(identified: ModalIdentification) -> str:
    """The two parameters that the test tells apart least, in words."""
    names, matrix = tuple(identified.values), abs(identified.correlation)
    if len(names) < 2:
        return ""
    first, second = divmod(int(np.argmax(np.triu(matrix, 1))), len(names))
    value = identified.correlation[first, second]
    return f"{_FITTED[names[first]]} and {_FITTED[names[second]].lower()} correlate by {value:.2f}."


def _how_good(convergence: Convergence, number: int) -> Section:
    """What a finer model would change."""
    listed = (
        Column("what", "Changed"),
        Column("from", "From"),
        Column("to", "To"),
        Column("frequency", "Frequency", "", write=lambda change: f"{change:+.3%}"),
        Column("damping_ratio", "ζ", "", write=lambda change: f"{change:+.2%}"),
    )
    title = f"Mode {number}, the largest changes over its amplitudes"
    table = Table(title, listed, convergence.changes, noun="changes")
    message = Note(f"{convergence.message}.", small=True)
    return Section("How good the model is", (table, message))


def _ranking(mode: Mode) -> Table:
    assert mode.bands is not None  # who calls has looked
    listed = (
        Column("input", "Not known exactly"),
        Column("share", "Share in the scatter of ln ζ", "", write=cells.percent),
    )
    return Table(f"Mode {mode.number}", listed, mode.bands.ranking, noun="inputs")
