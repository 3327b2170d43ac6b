"""Report of a campaign: table of records, contradictions between them, wear."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any

from microslip._core.dataset import DataSet
from microslip._core.quantities import Quantity, count, dimensionless, json_value, named
from microslip._core.wording import shorten
from microslip.figures.picture import Picture
from microslip.laboratory import figures
from microslip.laboratory.campaign import NUMBERS, Campaign
from microslip.laboratory.cycle_columns import LABELS, UNITS
from microslip.laboratory.manifest import text_of
from microslip.laboratory.wear import Wear
from microslip.report.document import Block, Items, Note, Section, Table

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
        quantity = Quantity(UNITS[name], label=LABELS[name])
        columns[name] = quantity, [value for value, _, _ in values]
    settled = ["yes" if measured.is_settled else "no" for measured in every]
    columns["settled"] = count("settled"), settled
    columns["frequency"] = Quantity("Hz"), [measured.frequency for measured in every]
    for name, unit in (("first_cycle", "-"), ("worn_volume", "m^3")):
        if name in campaign.columns:
            columns[name] = Quantity(unit), campaign.columns[name]
    for name, values in means.items():
        for place, end in ((1, "low"), (2, "high")):
            columns[f"{name} {end}"] = Quantity(UNITS[name]), [row[place] for row in values]
    taken = {*columns, *(f"{name} [{quantity.unit}]" for name, (quantity, _) in columns.items())}
    given = {
        f"{name} (manifest)" if name in taken else name: (count(name), list(map(text_of, values)))
        for name, values in campaign.columns.items()
        if name not in NUMBERS
    }
    return DataSet.of_rows({"record": columns.pop("record"), **given, **columns})


def _shown(data: DataSet) -> list[str]:
    names = list(data)
    return names[: names.index("settled") + 1]


def campaign_sections(
    data: DataSet,
    skipped: Sequence[tuple[str, str]],
    contradictions: Sequence[str],
    wear: Wear | None,
) -> tuple[list[Section], list[Section]]:
    """Return two lists of sections, to be placed before and after the sections on each record."""
    names = tuple(_shown(data))
    hidden = tuple(name for name in names if name not in (*_BRIEF, *_BRIEF_TEXTS))
    table = Table("Records", data, names, noun="records", hidden=hidden)
    first = [Section("Records", (table,))]
    if skipped:
        texts = tuple(f"{shorten(name, 80)}: {why}" for name, why in skipped)
        words = Note(f"{len(skipped)} file{'s' * (len(skipped) > 1)} could not be measured:")
        first.append(Section("Skipped files", (words, Items(texts))))
    if contradictions:
        first.append(Section("Contradictions", (Items(tuple(contradictions)),)))
    return first, [] if wear is None else [_wear_section(wear)]


def _wear_section(wear: Wear) -> Section:
    parts: list[Block] = []
    if wear.coefficient is not None:
        # In cubic micrometres per joule, as usual in the literature.
        value, low, high = (1e18 * end for end in wear.coefficient[:3])
        ends = "" if math.isnan(low) else f" ({low:.3g} to {high:.3g})"
        volumes = len(wear.records)
        parts.append(
            Note(
                f"Energy wear coefficient: {value:.3g} µm³/J{ends}, from {volumes} worn volume"
                f"{'s' * (volumes > 1)} and the energy dissipated since the specimen was new "
                "(Fouvry et al. 2003)."
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


def campaign_data(
    rows: DataSet,
    skipped: Sequence[tuple[str, str]],
    contradictions: Sequence[str],
    wear: Wear | None,
) -> dict[str, Any]:
    """Return the numbers of a campaign as plain values in SI units."""
    data = {
        "skipped": [{"file": name, "reason": why} for name, why in skipped],
        "table": rows.records(_shown(rows)),
        "contradictions": list(contradictions),
        "wear": None if wear is None else _wear_data(wear),
    }
    return {key: json_value(values) for key, values in data.items()}


def _wear_data(wear: Wear) -> dict[str, Any]:
    coefficient = {} if wear.coefficient is None else named(wear.coefficient)
    rows = zip(wear.records, wear.energy.tolist(), wear.volume.tolist(), strict=True)
    return {
        "unit": "m^3/J",
        **coefficient,
        "records": [
            {"record": name, "energy": energy, "worn_volume": volume}
            for name, energy, volume in rows
        ],
        "unknown": dict(wear.unknown),
    }
