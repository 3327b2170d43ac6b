"""Sections on tests of a structure: agreement, limits of frequencies, changes, fitted parameters.

Limits are the natural frequencies with the lap open, tied under the washers and tied wholly.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from microslip._core.dataset import DataSet
from microslip._core.quantities import count, dimensionless, hertz, named
from microslip.report import cells
from microslip.report.document import Block, Note, Section, Table, Verdicts
from microslip.structures import ModalIdentification
from microslip.study.runs.structure_prediction import QuantityVerdict, StructurePrediction

_WORDS = {"frequency": "Frequency", "damping_ratio": "Damping ratio"}


def verdict_sentences(prediction: StructurePrediction) -> list[str]:
    """Return one sentence for each quantity of each test, on its agreement with the prediction.

    It states how many points are outside the predicted band, by how much, and likely causes.
    """
    return [_sentence(verdict) for verdict in prediction.judged]


def _sentence(verdict: QuantityVerdict) -> str:
    name = f"{_WORDS[verdict.quantity]} of mode {verdict.mode}, {verdict.test or 'test'}"
    if verdict.word == "not compared":
        text = f"{name}: not compared, no point lies within the predicted amplitudes"
    elif verdict.word == "inside":
        return f"{name}: inside the 5 to 95 % band in all {verdict.points} points."
    else:
        parts = [f"{count} {word}" for count, word in
                 ((verdict.above, "above"), (verdict.below, "below")) if count]  # fmt: skip
        far = abs(verdict.distance)
        text = (
            f"{name}: {' and '.join(parts)} the 5 to 95 % band of {verdict.points} points, by "
            + (f"up to {100.0 * far:.2f} %" if far < 1.0 else f"a factor of up to {1.0 + far:.3g}")
        )
    if verdict.unit:
        return f"{text}. Likely a unit error: with {verdict.unit} all points lie inside."
    if verdict.candidates:
        listed = ", ".join(f"{more} {name}" for name, more in verdict.candidates)
        text += f". Candidates, the strongest first: {listed}"
    elif verdict.word != "not compared":
        text += ". No uncertain input changes it: check the inputs given as one number"
    return f"{text}."


def tested_sections(prediction: StructurePrediction) -> list[Section]:
    """Return the sections on tests, on limits of the frequencies, and on changes with amplitude.

    A terminal shows limits and changes only if there are tests.
    """
    sections = []
    if prediction.judged:
        notes = tuple(Note(text) for text in verdict_sentences(prediction))
        sections.append(Section("Tests compared with the bands", notes))
    blocks: list[Block] = []
    if prediction.limits:
        limits, modes = prediction.limits, prediction.modes
        data = DataSet.of_rows(
            {
                "mode": (count("Mode"), [mode.number for mode in modes]),
                "open": (hertz("Lap open"), [limit.open for limit in limits]),
                "washers": (hertz("Tied under the washers"), [limit.washers for limit in limits]),
                "predicted": (hertz("Predicted, stuck"), [m.curve.linear_frequency for m in modes]),
                "tied": (hertz("Tied wholly"), [limit.tied for limit in limits]),
            }
        )
        caption = (
            "A test near one limit indicates the state of the lap; a test outside the limits "
            "indicates a wrong input, such as a size, a modulus or a mass."
        )
        blocks.append(Table("Limits of the frequencies", data, caption=caption, noun="modes"))
    if prediction.changes:
        quantities = {
            "source": count("Of"),
            "mode": count("Mode"),
            "base_damping": dimensionless("Base damping"),
            "rise": dimensionless("Rise of ζ"),
            "fall": dimensionless("Change of frequency", "+.3%"),
            "ratio": dimensionless("Rise over fall", ".2f"),
        }
        data = DataSet.of_rows(
            {n: (q, [getattr(c, n) for c in prediction.changes]) for n, q in quantities.items()}
        )
        caption = " ".join(
            ["From the smallest to the largest amplitude; microslip has a ratio of 0.40 to 0.50.",
             *(c.doubt for c in prediction.changes if c.doubt)]
        )  # fmt: skip
        blocks.append(Table("Rise and fall", data, caption=caption, noun="curves"))
    if blocks:
        brief = bool(prediction.tests)
        sections.append(Section("Limits, rise and fall", tuple(blocks), brief=brief))
    return sections


def tested_numbers(prediction: StructurePrediction) -> dict[str, Any]:
    """Return the numbers of :func:`tested_sections` as plain values in SI units."""
    limits = zip(prediction.modes, prediction.limits, strict=True)
    return {
        "limits": [{"mode": mode.number, **limit._asdict()} for mode, limit in limits],
        "tests": [{**v._asdict(), "inside": v.inside} for v in prediction.judged],
        "changes": [{**c._asdict(), "ratio": c.ratio} for c in prediction.changes],
    }


# -- parameters fitted to tests --------------------------------------------------------------------


def fitted_numbers(identified: ModalIdentification) -> dict[str, Any]:
    """Return the fitted parameters and curves as plain values in SI units."""
    return {
        **named(identified, "values", "intervals", "correlation", "misfit"),
        "scatter": dict(zip(identified.values, identified.scatter, strict=True)),
        "linear_frequencies": [
            dict(zip(("test", "study", "fitted"), row, strict=True))
            for row in identified.linear_frequencies
        ],
        "curves": [
            {
                "mode": curve.index + 1,
                "amplitude": curve.amplitude,
                "modal_frequency": curve.frequency,
                "modal_damping_ratio": curve.damping_ratio,
                "modal_frequency_bands": band[0],
                "modal_damping_ratio_bands": band[1],
            }
            for curve, band in zip(identified.curves, identified.bands, strict=True)
        ],
        "verdicts": [v.word for v in identified.verdicts],
    }


_FITTED = {
    "friction_coefficient": "Friction coefficient",
    "tension": "Bolt tension over that of the study",
    "form": "Factor on the form",
    "young_modulus": "Young's modulus over that of the study",
    "base_damping_ratio": "Base damping ratio",
}


def fitted_section(prediction: StructurePrediction, identified: ModalIdentification) -> Section:
    """Return the section on the fitted parameters and their verdicts."""
    data = DataSet.of_rows(
        {
            name: (dimensionless(_FITTED[name]), (value, *identified.intervals[name]))
            for name, value in identified.values.items()
        }
    )
    table = cells.by_quantity("Fitted to the test", data, ("Parameter", "Value (5 to 95 %)"))
    verdicts = Verdicts(identified.verdicts, caption=_strongest_correlation(identified))
    return Section("Fitted to the test", (table, verdicts, _linear(prediction, identified)))


def _linear(prediction: StructurePrediction, identified: ModalIdentification) -> Table:
    labels = ("Test, smallest amplitude", "Joints stick, as in the study", "Joints stick, fitted")
    columns: dict[str, Any] = {"mode": (count("Mode"), [t.mode + 1 for t in prediction.tests])}
    for label, values in zip(labels, identified.linear_frequencies.T, strict=True):
        columns[label] = hertz(label), values
    return Table("Linear frequencies", DataSet.of_rows(columns), noun="tests")


MOTIONS = {"steady": "steady motion", "decay": "free decay"}


def _strongest_correlation(identified: ModalIdentification) -> str:
    names, matrix = tuple(identified.values), abs(identified.correlation)
    if len(names) < 2:
        return ""
    first, second = divmod(int(np.argmax(np.triu(matrix, 1))), len(names))
    value = identified.correlation[first, second]
    return f"{_FITTED[names[first]]} and {_FITTED[names[second]].lower()} correlate by {value:.2f}."
