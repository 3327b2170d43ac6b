"""Sections on tests of a structure, limits of its frequencies, and changes with amplitude.

Limits are the natural frequencies with the lap open, tied under the washers and tied wholly.
"""

from __future__ import annotations

import math
from typing import Any

from microslip._core.dataset import DataSet
from microslip._core.quantities import count, dimensionless, hertz, json_value
from microslip.report.document import Block, Note, Section, Table
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
    return {
        "limits": [
            {"mode": mode.number, **json_value(limit._asdict())}
            for mode, limit in zip(prediction.modes, prediction.limits, strict=True)
        ],
        "tests": [
            {
                **json_value({k: v for k, v in verdict._asdict().items() if k != "candidates"}),
                "inside": verdict.inside,
                "candidates": [list(pair) for pair in verdict.candidates],
            }
            for verdict in prediction.judged
        ],
        "changes": [
            json_value({**c._asdict(), "ratio": c.ratio if math.isfinite(c.ratio) else None})
            for c in prediction.changes
        ],
    }
