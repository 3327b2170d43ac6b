"""Document and files of an identification: a law fitted to records, and interface parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from microslip._core.dataset import DataSet
from microslip._core.quantities import QUANTITIES, Quantity, count, json_value, named
from microslip._core.units import engineering, significant
from microslip._core.wording import capital, plural, shorten
from microslip._version import __version__
from microslip.friction.law_files import law_content, law_text
from microslip.identification import Estimate, Identification, figures
from microslip.identification.curves import CONFIDENCE, SHOWN, curves_of
from microslip.report import cells
from microslip.report.document import (
    Document,
    Items,
    Note,
    Section,
    Table,
)
from microslip.report.files import csv_file, header, text_file
from microslip.study.toml_text import dump

_SCHEMA = 2

CONFIDENCE_TEXT = f"{100.0 * CONFIDENCE:g} %"
_METHOD = (
    "The settled cycles of each record are averaged; their scatter gives the noise. The force of "
    "any law that obeys Masing's rules is linear in its slider density, so all records are fitted "
    "together by least squares with non-negative stiffnesses: a convex problem without initial "
    "values or an assumed shape. At a lower normal load the yield displacements of all sliders are "
    f"smaller by one common shift. An interval ({CONFIDENCE_TEXT}, for each quantity separately) "
    "contains the values of all densities whose sum of squares exceeds the minimum by no more than "
    "a quantile, which is calibrated by simulation from the fit. Loops cannot separate the joint "
    "from the rig in series: without a measured rig stiffness, the results are those of both."
)
_RESIDUALS = (
    "The residual is the root mean square of measured minus fitted force over the mean cycle; the "
    "noise is that of one sample."
)


@dataclass(frozen=True)
class Identified:
    """Input and result of one run of ``identify``."""

    found: Identification
    title: str = ""
    """Title of the study that the materials are from."""
    step: Any = None
    """Parameters of the interface, from a second fit to the law; None without materials."""
    no_step: str = ""
    """Reason why no parameters of the interface were determined."""
    skipped: tuple[tuple[str, str], ...] = ()
    """Files that could not be read, and why."""


# -- the data set ---------------------------------------------------------------------------------


def identification_data(outcome: Identified, adapt: cells.Wording = str) -> dict[str, Any]:
    """Return all numbers of an identification as plain values in SI units.

    ``adapt`` replaces argument names in messages, for example by command options.
    """
    found = outcome.found
    law = found.law
    title = f"{outcome.title}: identified" if outcome.title else "Identified joint"
    data: dict[str, Any] = {
        **header("identification", _SCHEMA, title),
        "version": __version__,
        "of": found.series,
        "confidence": CONFIDENCE,
        "amplitude_range": found.amplitudes,
        "stiffness": {**named(found.stiffness), "unit": "N/m"},
        "force_limit": {**named(found.force_limit), "unit": "N"},
        "rig_stiffness": {
            **named(found.rig), "unit": "N/m", "given": found.rig_stiffness is not None,
        },
        "curves": [
            {
                "normal_load": table.load,
                "measured_amplitudes": table.measured,
                "amplitude": table.amplitude,
                **table.estimates,
            }
            for table in curves_of(found)
        ],
        "law": named(law, "yield_displacements", "stiffnesses"),
        "masing": {
            **named(found, "chi_squared", "degrees_of_freedom"),
            "holds": bool(found.masing.holds),
            "text": adapt(found.masing.text),
        },
        "interface": None if outcome.step is None else _step(outcome.step),
        "records": [
            {
                **named(record, "name", "normal_load"),
                **named(record.folded, "amplitude", "cycles"),
                "rms_residual": float(np.sqrt(np.mean(record.residual**2))),
                "force_noise": record.folded.force_noise,
                "measured_energy": record.measured_energy,
            }
            for record in found.records
        ],
        "skipped": [{"file": name, "reason": why} for name, why in outcome.skipped],
        "notes": [adapt(note) for note in found.notes],
        "files": [],
    }  # fmt: skip
    return {key: json_value(value) for key, value in data.items()}


def _step(step: Any) -> dict[str, Any]:
    rig, shown = step.rig_from_shape, ("value", "low", "high", "unit", "verdict")
    return {
        "law": "interface",
        "fits": bool(step.fits),
        **named(step, "misfit", "misfit_limit"),
        "parameters": {name: named(one, *shown) for name, one in step.parameters.items()},
        "rig_from_shape": None if rig is None else {**named(rig, *Estimate._fields), "unit": "N/m"},
    }


# -- the document ---------------------------------------------------------------------------------


def identification_document(outcome: Identified, adapt: cells.Wording = str) -> Document:
    """Return the document of a fitted law, with the interface parameters if materials were given.

    ``adapt`` is as for :func:`identification_data`.
    """
    data, found = identification_data(outcome, adapt), outcome.found
    holds = data["masing"]["holds"]
    sections = [
        Section("At rest and in gross slip", (_facts(data),)),
        Section("At the measured amplitudes", (_amplitudes(data),)),
        Section("Law", (Items(_masing(data)),)),
    ]
    if data["interface"] is not None:
        sections.append(Section("Parameters", _parameters(data)))
    elif outcome.no_step:
        sections.append(Section("Parameters", (Note(outcome.no_step, small=True),)))
    study = law_study_text(data)
    sections += [
        Section("Figures", figures.pictures(found), brief=False),
        Section("Residuals", (_records(data["records"]),), brief=False),
        Section(
            "The joint as a study",
            (Note("In joint.toml, for: microslip predict joint.toml"),),
            brief=False,
        ),
        Section("Method", (Note(_METHOD),), brief=False),
    ]
    if outcome.skipped:
        unreadable = tuple(f"{name}: {why}" for name, why in outcome.skipped)
        files = Note("Files that cannot be read:")
        sections.append(Section("Left out", (files, Items(unreadable))))
    if data["notes"]:
        sections.append(Section("Notes", (Items(tuple(data["notes"])),)))
    return Document(
        data["title"],
        headline(data),
        tuple(sections),
        data,
        () if holds else (f"{capital(data['masing']['text'])}.",),
        "law",
        (
            csv_file("curves.csv", lambda: curves_data(found)),
            csv_file("residuals.csv", lambda: residuals_data(found)),
            text_file("law.json", lambda: law_json(outcome)),
            text_file("joint.toml", lambda: study),
        ),
    )


def headline(data: Mapping[str, Any]) -> str:
    """Describe the largest measured cycle in a sentence."""
    curve = data["curves"][-1]
    at = f"±{engineering(curve['amplitude'][-1], 'm', 3, trim=True)}"
    if curve["normal_load"] is not None:
        at += f" and {engineering(curve['normal_load'], 'N', 3, trim=True)}"
    energy, damping = (
        _interval(curve[name], QUANTITIES[name], -1)
        for name in ("dissipated_energy", "damping_ratio")
    )
    return f"At {at} the energy per cycle is {energy}, and ζ is {damping} ({data['of']})."


def _interval(numbers: Mapping[str, Any], quantity: Quantity, place: int | None = None) -> str:
    """Format an estimate of the data, or one element of an estimate of a curve."""
    ends = (numbers[key] for key in Estimate._fields)
    if place is not None:
        ends = (end[place] for end in ends)
    return cells.interval_text(ends, quantity)


def _facts(data: Mapping[str, Any]) -> Table:
    rig = "as given" if data["rig_stiffness"]["given"] else "loops alone do not determine it"
    labels = {
        "stiffness": "Stiffness at rest",
        "force_limit": "Force limit",
        "rig_stiffness": f"Stiffness of the rig ({rig})",
    }
    columns = {
        name: (
            Quantity(data[name]["unit"], label=label),
            [data[name][key] for key in Estimate._fields],
        )
        for name, label in labels.items()
    }
    columns["amplitudes"] = (
        Quantity("m", label="Measured amplitudes"), [None, *data["amplitude_range"]],
    )  # fmt: skip
    load = data["curves"][-1]["normal_load"]
    at = "" if load is None else f" at {engineering(load, 'N', 3, trim=True)}"
    title = f"{capital(data['of'])}{at}, with {CONFIDENCE_TEXT} intervals"
    return cells.by_quantity(title, DataSet.of_rows(columns), ("", ""))


def _amplitudes(data: Mapping[str, Any]) -> Table:
    places = [
        (curve, a, curve["amplitude"].index(a))
        for curve in data["curves"]
        for a in curve["measured_amplitudes"]
    ]
    columns: dict[str, Any] = {
        "normal_load": (QUANTITIES["normal_load"], [c["normal_load"] for c, _, _ in places]),
        "amplitude": (QUANTITIES["amplitude"]._replace(form="4"), [a for _, a, _ in places]),
    }
    for name in SHOWN:
        quantity = QUANTITIES[name]
        label = f"{quantity.label} ({CONFIDENCE_TEXT})"
        texts = [_interval(curve[name], quantity, at) for curve, _, at in places]
        columns[name] = Quantity("", label=label, symbol=quantity.label), texts
    caption = f"Intervals of {CONFIDENCE_TEXT} for each quantity separately, of the {data['of']}."
    rows = DataSet.of_rows(columns)
    return Table("At the measured amplitudes", rows, keys=2, caption=caption)


def _masing(data: Mapping[str, Any]) -> tuple[str, ...]:
    masing = data["masing"]
    reduced = masing["chi_squared"] / masing["degrees_of_freedom"]
    return (
        f"{capital(masing['text'])}.",
        f"Reduced χ² {significant(reduced, 3)} over {masing['degrees_of_freedom']} degrees of "
        f"freedom, {plural(len(data['records']), 'record')}.",
    )


def _parameters(data: Mapping[str, Any]) -> tuple[Any, ...]:
    step = data["interface"]
    columns, verdicts = {}, []
    for name, one in step["parameters"].items():
        ends = [one[key] for key in Estimate._fields]
        if one["verdict"] == "not determined":
            ends = [None] * len(ends)
        columns[name] = Quantity(one["unit"] or "-", label=capital(name.replace("_", " "))), ends
        verdicts.append(one["verdict"])
    heads = ("Parameter", f"Value ({CONFIDENCE_TEXT})", "Verdict")
    table = cells.by_quantity("Parameters", DataSet.of_rows(columns), heads, verdicts)
    words = "fits the loops as well as the law does"
    if not step["fits"]:
        words = (
            "does not fit: χ² rises by more than from noise alone "
            f"({significant(step['misfit'], 3)} over {significant(step['misfit_limit'], 3)}), so "
            "its parameters are those of the best fit"
        )
    note = f"The {step['law']} {words}."
    rig = step["rig_from_shape"]
    if rig is not None:
        text = _interval(rig, Quantity("N/m"))
        note += f" With the assumed shape of the normal law the rig stiffness is {text}."
    return (table, Note(note))


def _records(records: Sequence[Mapping[str, Any]]) -> Table:
    quantities = {
        "name": count("Record"),
        "normal_load": Quantity("N", label="N"),
        "amplitude": Quantity("m", label="Amplitude"),
        "cycles": count("Cycles"),
        "rms_residual": Quantity("N", label="Residual", form="3"),
        "force_noise": Quantity("N", label="Noise of a sample", form="3"),
        "measured_energy": Quantity("J", label="Energy of the loop"),
    }
    data = DataSet.of_rows(
        {name: (quantity, [r[name] for r in records]) for name, quantity in quantities.items()}
    )
    return Table("Residuals", data, caption=_RESIDUALS, noun="records")


# -- files ----------------------------------------------------------------------------------------


def law_json(outcome: Identified) -> str:
    """Return the law at the highest load with its intervals, in the format of law files."""
    band = curves_of(outcome.found)[-1].band()
    return law_text(law_content(outcome.found.law, band))


def law_study_text(data: Mapping[str, Any]) -> str:
    """Return a study that computes the law in law.json at the measured amplitudes."""
    curve = data["curves"][-1]
    lines = [f"Identified by microslip {__version__}, the {data['of']}, from:"]
    lines += [
        f"  {shorten(record['name'], 60)}, N = {cells.cell(record['normal_load'], Quantity('N'))}, "
        f"amplitude {engineering(record['amplitude'], 'm', 4)}, {record['cycles']} cycles"
        for record in data["records"]
    ]
    if curve["normal_load"] is not None and len(data["curves"]) > 1:
        load = engineering(curve["normal_load"], "N", 4, trim=True)
        lines.append(f"The law is that of the highest normal load, {load}.")
    study = {
        "schema": 1,
        "title": data["title"],
        "joint": {"law_file": "law.json"},
        "excitation": {
            "amplitudes": [cells.toml_length(a) for a in curve["measured_amplitudes"]],
            "curve": {
                "from": cells.toml_length(curve["amplitude"][0]),
                "to": cells.toml_length(curve["amplitude"][-1]),
            },
        },
    }
    return "\n".join(f"# {line}" for line in lines) + f"\n{dump(study)}"


def curves_data(found: Identification) -> DataSet:
    """Return the curves of force, energy and damping over amplitude, with their intervals."""
    tables = curves_of(found)
    sizes = [len(table.amplitude) for table in tables]
    loads = np.array([table.load for table in tables], dtype=float)
    columns: dict[str, Any] = {
        "normal load": (Quantity("N"), np.repeat(loads, sizes)),
        "amplitude": (Quantity("m"), np.concatenate([table.amplitude for table in tables])),
    }
    for name in SHOWN:
        label, unit = name.replace("_", " "), QUANTITIES[name].unit
        for key in Estimate._fields:
            values = [np.asarray(getattr(table.estimates[name], key), float) for table in tables]
            heading = label if key == "value" else f"{label} {key}"
            columns[heading] = Quantity(unit), np.concatenate(values)
    return DataSet.of_rows(columns)


def residuals_data(found: Identification) -> DataSet:
    """Return measured and fitted forces of all records."""
    records = found.records
    sizes = [record.phase.size for record in records]
    names = [name for record, n in zip(records, sizes, strict=True) for name in [record.name] * n]
    loads = np.repeat(np.array([r.normal_load for r in records], dtype=float), sizes)
    columns: dict[str, Any] = {"record": (count(""), names)}
    columns["normal load"] = Quantity("N"), loads
    for heading, unit, name in (
        ("phase", "rad", "phase"),
        ("displacement", "m", "displacement"),
        ("measured force", "N", "measured"),
        ("fitted force", "N", "model"),
        ("residual", "N", "residual"),
    ):
        values = np.concatenate([getattr(record, name) for record in records])
        columns[heading] = Quantity(unit), values
    return DataSet.of_rows(columns)
