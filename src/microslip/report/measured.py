"""Document and files of measured records, and of campaigns of several records."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip._core.dataset import DataSet
from microslip._core.quantities import Quantity, count, dimensionless, json_value, named
from microslip._core.units import engineering, interval_digits, significant
from microslip._core.wording import plural, shorten
from microslip.figures.picture import Picture
from microslip.laboratory import Measurement, figures
from microslip.laboratory.campaign import NUMBERS, Campaign, Wear
from microslip.laboratory.cycle_columns import COLUMN_UNITS, LABELS
from microslip.laboratory.figures import measured_loops
from microslip.laboratory.manifest import text_of
from microslip.laboratory.measurement import GROSS, STICK
from microslip.laboratory.reading import ChannelNote
from microslip.report import cells
from microslip.report.document import Block, Document, Items, Note, Section, Table
from microslip.report.files import csv_file, header

_CERTAIN_REGIME = 0.999
"""Probability of a regime above which it is not reported."""
_FIRST = (
    "amplitude",
    "force_amplitude",
    "normal_load",
    "dissipated_energy",
    "loss_factor",
    "friction_peak",
    "friction_energy",
    "chord_stiffness",
)
"""Columns of a single record on a terminal; page and summary.json have all columns."""


def measurement_document(
    measurements: Sequence[Measurement] | Campaign,
    adapt: cells.Wording = str,
    skipped: Sequence[tuple[str, str]] = (),
) -> Document:
    """Return the document of measured records, with ``skipped`` files and the reasons.

    ``adapt`` replaces argument names in messages, for example by command options.
    """
    campaign = measurements if isinstance(measurements, Campaign) else Campaign(tuple(measurements))
    measurements = campaign.measurements
    names = [shorten(measured.name, 200) for measured in measurements]
    title = names[0] if len(names) == 1 else f"{len(names)} measured records"
    heading = header("measurement", 1, title)
    data = {
        **heading,
        "version": heading["generator"]["version"],
        "records": [measured.summary() for measured in measurements],
        "files": [],
    }
    sections = [
        part
        for measured in measurements
        for part in _sections(measured, adapt, len(measurements) == 1)
    ]
    last: list[Section] = []
    rows, contradictions = campaign_table(campaign), campaign.contradictions()
    if len(measurements) > 1 or skipped or contradictions:
        wear = campaign.wear(measurements[0].confidence)
        shown = tuple(rows)[: [*rows].index("settled") + 1]
        sections[:0] = campaign_sections(rows, shown, skipped, contradictions)
        last = [] if wear is None else [_wear_section(wear)]
        data["campaign"] = {
            "skipped": [{"file": name, "reason": why} for name, why in skipped],
            "table": rows.records(shown),
            "contradictions": contradictions,
            "wear": None if wear is None else json_value(_wear_data(wear)),
        }
    caption = (
        "Mean cycles of the records without offsets, as in Fig. 19.7 of the chapter, and the "
        "energy of each cycle."
    )
    picture = Picture(
        "loops",
        caption,
        lambda: measured_loops(measurements),
        "Mean loops, and energies over the cycles",
    )
    sections += [Section("Loops", (picture,), brief=False), *last]
    tables = [csv_file("cycles.csv", lambda: cycles_data(measurements))]
    if len(measurements) > 1:
        tables.append(csv_file("campaign.csv", lambda: rows))
    answer = _answer(measurements)
    return Document(title, answer, tuple(sections), data, (), "loops", tuple(tables))


def _joules(*ends: float, digits: int = 0) -> str:
    digits = digits or interval_digits(ends[0], ends[-1])
    return " to ".join(engineering(end, "J", digits) for end in ends)


def _answer(measurements: Sequence[Measurement]) -> str:
    energies = [measured.mean["dissipated_energy"] for measured in measurements]
    if len(measurements) > 1:
        values = [energy.value for energy in energies]
        ends = _joules(min(values), max(values))
        return f"{_campaign_regimes(measurements)}: a cycle dissipates {ends}."
    measured, energy = measurements[0], energies[0]
    if len(measured.levels) > 1:
        return f"{len(measured)} cycles at {len(measured.levels)} amplitudes: {_ends(measured)}."
    cycles = plural(len(measured), "cycle")
    spread = ""
    if energy.number > 1:
        ends = _joules(energy.low, energy.high)
        spread = f" ({ends} with {100.0 * measured.confidence:g} % confidence)"
        if not measured.is_settled:
            spread = f" in the mean, not settled ({ends})"
    value = _joules(energy.value, digits=interval_digits(energy.low, energy.high))
    return f"{cycles}, {_regime(measured)}: each dissipates {value}{spread}."


def _regime(measured: Measurement) -> str:
    possible = measured.possible_regimes
    if len(possible) < 2:
        is_one = measured.is_settled or possible[measured.regime] == 1.0
        return measured.regime if is_one else f"mostly {measured.regime}"
    shares = " or ".join(f"{name} ({100.0 * share:.0f} %)" for name, share in possible.items())
    return shares if measured.is_settled else shares.replace(" or ", ", ")


def _campaign_regimes(measurements: Sequence[Measurement]) -> str:
    counts = Counter(" or ".join(sorted(m.possible_regimes)) for m in measurements)
    texts = [f"{number} in {regime}" for regime, number in counts.most_common()]
    first, _, rest = texts[0].partition(" ")
    return ", ".join([f"{plural(int(first), 'record')} {rest}", *texts[1:]])


def _ends(measured: Measurement) -> str:
    """Describe the energies per cycle at the smallest and the largest amplitude of a record."""
    levels = sorted(measured.levels, key=lambda level: level.mean["amplitude"].value)
    low, high = (
        f"{_joules(level.mean['dissipated_energy'].value)} at "
        f"{engineering(level.mean['amplitude'].value, 'm')}"
        for level in (levels[0], levels[-1])
    )
    return f"each dissipates {low}, to {high}"


def _sections(
    measured: Measurement, adapt: cells.Wording, is_alone: bool
) -> tuple[Section, Section]:
    summary = measured.summary()
    counts = [f"{n} {name}" for name, n in summary["regimes"].items() if n]
    facts = [f"{', '.join(counts)} cycle{'s' * (len(measured) > 1)}"]
    likely = summary["probability"].get(measured.regime)
    # With stepped amplitudes the means and the regimes refer to different cycles.
    if likely is not None and likely < _CERTAIN_REGIME and not measured.levels:
        facts.append(f"{measured.regime} with a probability of {100.0 * likely:.0f} %")
    if measured.frequency is not None:
        facts.append(f"frequency {engineering(measured.frequency, 'Hz', 4, trim=True)}")
    facts.append(f"third harmonic {significant(100.0 * measured.third_harmonic)} %")
    if measured.load_ripple is not None:
        facts.append(f"load ripple {significant(100.0 * measured.load_ripple)} %")
    if measured.rig_stiffness is not None:
        facts.append(f"rig of {engineering(measured.rig_stiffness, 'N/m')} subtracted")
    regimes = (
        f"Regimes: stick up to A = {STICK:.3g}, gross slip from B = {GROSS:.3g}, "
        "the limits of one sphere."
    )
    channels = [note for note in measured.notes if isinstance(note, ChannelNote)]
    blocks: tuple[Block, ...] = (
        Note(f"{shorten(measured.name, 200)}: {', '.join(facts)}."),
        _levels(measured) if measured.levels else _means(measured),
        *((Note(_channels_text(channels)),) if channels else ()),
        Items(tuple(adapt(note) for note in measured.notes if note not in channels)),
    )
    title = shorten(measured.name, 100)
    return (
        Section(title, blocks, brief=is_alone),
        Section(f"{title}, as read", (Note(regimes), Items(tuple(channels))), brief=False),
    )


def _channels_text(notes: Sequence[ChannelNote]) -> str:
    words = [
        f'{note.kind.replace("_", " ")} "{note.heading}"{", sign reversed" * note.is_turned}'
        for note in notes
    ]
    return f"Read: {'; '.join(words)}."


def _means(measured: Measurement) -> Table:
    level = f"{100.0 * measured.confidence:g} % interval of the mean"
    if not measured.is_settled:
        level = "range of the cycles: not settled"
    names = [
        name
        for name in (*_FIRST, *(name for name in LABELS if name not in _FIRST))
        if name in measured.mean
    ]
    data = DataSet.of_rows({name: (_quantity(name), measured.mean[name][:3]) for name in names})
    heads = ("quantity", f"mean ({level})")
    few = tuple(range(sum(name in measured.mean for name in _FIRST)))
    return replace(cells.by_quantity("Means over the cycles", data, heads), few=few)


_OF_LEVELS = ("amplitude", "force_amplitude", "dissipated_energy", "loss_factor", "friction_peak")


def _levels(measured: Measurement) -> Table:
    names = [name for name in _OF_LEVELS if name in measured.mean]
    levels = measured.levels
    ends = (dict.fromkeys(level.cycles[[0, -1]].tolist()) for level in levels)
    energy = _quantity("dissipated_energy")
    columns: dict[str, Any] = {
        "cycles": (count("cycles"), [" to ".join(f"{end + 1}" for end in of) for of in ends]),
        **{name: (_quantity(name), [level.mean[name].value for level in levels]) for name in names},
        "energy_interval": (
            count(f"{100.0 * measured.confidence:g} % of the energy"),
            [
                cells.interval_text(
                    [None, *json_value(level.mean["dissipated_energy"][1:3])], energy
                )
                for level in levels
            ],
        ),
        "settled": (
            count(" "),
            ["settled" if level.is_settled else "not settled" for level in levels],
        ),
    }
    return Table("Results by amplitude", DataSet.of_rows(columns))


def _quantity(name: str) -> Quantity:
    return Quantity(COLUMN_UNITS[name], label=LABELS[name])


def cycles_data(measurements: Sequence[Measurement]) -> DataSet:
    """Return the numbers of all cycles of all records, NaN where a record has no such number."""

    def over_records(name: str) -> Floats:
        parts = (m.cycles.get(name, np.full(len(m), np.nan)) for m in measurements)
        return np.concatenate([np.asarray(part, dtype=float) for part in parts])

    columns: dict[str, Any] = {
        "record": (count(""), [m.name for m in measurements for _ in m.regimes]),
        "cycle": (count(""), [n + 1 for m in measurements for n in range(len(m))]),
    }
    for name, unit in COLUMN_UNITS.items():
        if any(name in m.cycles for m in measurements):
            columns[name] = Quantity(unit), over_records(name)
    columns["regime"] = count(""), [regime for m in measurements for regime in m.regimes]
    return DataSet.of_rows(columns)


# -- campaigns -------------------------------------------------------------------------------------

_COLUMNS_SHOWN = (
    "amplitude",
    "normal_load",
    "friction_peak",
    "friction_energy",
    "chord_stiffness",
    "dissipated_energy",
    "loss_factor",
)
_BRIEF = ("amplitude", "normal_load", "friction_energy", "dissipated_energy", "loss_factor")
_BRIEF_TEXTS = ("record", "specimen", "stage", "run", "cycles", "regime", "settled")


def campaign_table(campaign: Campaign) -> DataSet:
    """Return one row for each record: means of its cycles, then wear and confidence intervals.

    A column of the manifest with the name of a measured one has "(manifest)" behind its name.
    """
    every, unknown = campaign.measurements, (math.nan, math.nan, math.nan)
    likely = [measured.probability.get(measured.regime) for measured in every]
    columns: dict[str, tuple[Quantity, Any]] = {
        "record": (count("record"), [shorten(measured.name, 40) for measured in every]),
        "cycles": (count("cycles"), list(map(len, every))),
        "regime": (count("regime"), [measured.regime for measured in every]),
        "probability": (dimensionless("probability", "3"), likely),
    }
    means = {name: [m.mean.get(name, unknown)[:3] for m in every] for name in _COLUMNS_SHOWN}
    for name, values in means.items():
        columns[name] = _quantity(name), [value for value, _, _ in values]
    settled = ["yes" if measured.is_settled else "no" for measured in every]
    columns["settled"] = count("settled"), settled
    columns["frequency"] = Quantity("Hz"), [measured.frequency for measured in every]
    for name, unit in (("first_cycle", "-"), ("worn_volume", "m^3")):
        if name in campaign.columns:
            columns[name] = Quantity(unit), campaign.columns[name]
    for name, values in means.items():
        for place, end in ((1, "low"), (2, "high")):
            columns[f"{name} {end}"] = Quantity(COLUMN_UNITS[name]), [row[place] for row in values]
    taken = {*columns, *(f"{name} [{quantity.unit}]" for name, (quantity, _) in columns.items())}
    given = {
        f"{name} (manifest)" if name in taken else name: (count(name), list(map(text_of, values)))
        for name, values in campaign.columns.items()
        if name not in NUMBERS
    }
    return DataSet.of_rows({"record": columns.pop("record"), **given, **columns})


def campaign_sections(
    data: DataSet,
    shown: tuple[str, ...],
    skipped: Sequence[tuple[str, str]],
    contradictions: Sequence[str],
) -> list[Section]:
    """Return the sections on all records together; ``shown`` are the columns of their table."""
    hidden = tuple(name for name in shown if name not in (*_BRIEF, *_BRIEF_TEXTS))
    table = Table("Records", data, shown, noun="records", hidden=hidden)
    sections = [Section("Records", (table,))]
    if skipped:
        texts = tuple(f"{shorten(name, 80)}: {why}" for name, why in skipped)
        words = Note(f"{plural(len(skipped), 'file')} could not be measured:")
        sections.append(Section("Skipped files", (words, Items(texts))))
    if contradictions:
        sections.append(Section("Contradictions", (Items(tuple(contradictions)),)))
    return sections


def _wear_section(wear: Wear) -> Section:
    parts: list[Block] = []
    if wear.coefficient is not None:
        # In cubic micrometres per joule, as usual in the literature.
        value, low, high = (1e18 * end for end in wear.coefficient[:3])
        ends = "" if math.isnan(low) else f" ({low:.3g} to {high:.3g})"
        volumes = plural(len(wear.records), "worn volume")
        parts.append(
            Note(
                f"Energy wear coefficient: {value:.3g} µm³/J{ends}, from {volumes} and the energy "
                "dissipated since the specimen was new (Fouvry et al. 2003)."
            )
        )
        plot = partial(figures.worn, wear)
        caption = "Worn volume over dissipated energy, with the line through zero."
        parts.append(Picture("wear", caption, plot, "Worn volume over dissipated energy"))
    if wear.unknown:
        parts.append(Note("Not used for the energy wear coefficient:"))
        texts = (f"{shorten(name, 80)}: {reason}" for name, reason in wear.unknown.items())
        parts.append(Items(tuple(texts)))
    return Section("Wear", tuple(parts))


def _wear_data(wear: Wear) -> dict[str, Any]:
    rows = zip(wear.records, wear.energy, wear.volume, strict=True)
    return {
        "unit": "m^3/J",
        **({} if wear.coefficient is None else named(wear.coefficient)),
        "records": [
            dict(zip(("record", "energy", "worn_volume"), row, strict=True)) for row in rows
        ],
        "unknown": wear.unknown,
    }
