"""Report of a campaign: table of records, contradictions between them, wear."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any

from microslip._core.quantities import json_value, named
from microslip._core.wording import shorten
from microslip.figures.picture import Picture
from microslip.laboratory import figures
from microslip.laboratory.campaign import NUMBERS, Campaign
from microslip.laboratory.cycle_columns import LABELS, UNITS
from microslip.laboratory.manifest import Cell, text_of
from microslip.laboratory.wear import Wear
from microslip.report.document import Block, Column, Items, Note, Section, Table
from microslip.report.files import csv_text, text_cell

_COLUMNS_SHOWN = (
    "amplitude",
    "normal_load",
    "friction_peak",
    "friction_energy",
    "chord_stiffness",
    "dissipated_energy",
    "loss_factor",
)
_OF_WEAR = {"first_cycle": "first_cycle [-]", "worn_volume": "worn_volume [m^3]"}
"""Columns of a manifest that determine the wear, with their headings in campaign.csv."""
_NO_MEAN = (None, None, None)
_BRIEF = ("amplitude", "normal_load", "friction_energy", "dissipated_energy", "loss_factor")


def _data(campaign: Campaign) -> dict[str, Sequence[Cell]]:
    """Return the columns of a campaign without its numbers, which have columns of their own."""
    return {name: values for name, values in campaign.columns.items() if name not in NUMBERS}


def _columns(campaign: Campaign) -> tuple[Column, ...]:
    return (
        Column("record", "record"),
        *(
            Column(name, name, brief=name in ("specimen", "stage", "run"))
            for name in _data(campaign)
        ),
        Column("cycles", "cycles"),
        Column("regime", "regime"),
        Column("probability", "probability", "", 3, brief=False),
        *(
            Column(name, LABELS[name], UNITS[name].replace("-", ""), brief=name in _BRIEF)
            for name in _COLUMNS_SHOWN
        ),
        Column("settled", "settled"),
    )


def campaign_rows(campaign: Campaign) -> list[tuple[Any, ...]]:
    """Return one row for each record: plain values in SI units, None if unknown."""
    rows = []
    for i, measured in enumerate(campaign.measurements):
        means = {name: json_value(mean.value) for name, mean in measured.mean.items()}
        rows.append(
            (
                shorten(measured.name, 40),
                *(text_of(values[i]) for values in _data(campaign).values()),
                len(measured),
                measured.regime,
                measured.probability.get(measured.regime),
                *(means.get(name) for name in _COLUMNS_SHOWN),
                "yes" if measured.is_settled else "no",
            )
        )
    return rows


def csv_of(campaign: Campaign) -> str:
    """Return campaign.csv as text: a row per record, with wear and ends of confidence intervals."""
    heads = [c.key if c.unit is None else f"{c.key} [{c.unit or '-'}]" for c in _columns(campaign)]
    columns = campaign.columns
    stated = {head: columns[name] for name, head in _OF_WEAR.items() if name in columns}
    heads += ["frequency [Hz]", *stated]
    heads += [f"{name} {end} [{UNITS[name]}]" for name in _COLUMNS_SHOWN for end in ("low", "high")]
    behind = [
        [
            measured.frequency,
            *(values[i] for values in stated.values()),
            *(end for name in _COLUMNS_SHOWN for end in measured.mean.get(name, _NO_MEAN)[1:3]),
        ]
        for i, measured in enumerate(campaign.measurements)
    ]
    return csv_text(
        heads,
        (
            [*(text_cell(v) if isinstance(v, str) else v for v in row), *map(json_value, more)]
            for row, more in zip(campaign_rows(campaign), behind, strict=True)
        ),
    )


def campaign_sections(
    campaign: Campaign, skipped: Sequence[tuple[str, str]], confidence: float
) -> tuple[list[Section], list[Section]]:
    """Return two lists of sections, to be placed before and after the sections on each record."""
    table = Table("Records", _columns(campaign), tuple(campaign_rows(campaign)), noun="records")
    first = [Section("Records", (table,))]
    if skipped:
        texts = tuple(f"{shorten(name, 80)}: {why}" for name, why in skipped)
        words = Note(f"{len(skipped)} file{'s' * (len(skipped) > 1)} could not be measured:")
        first.append(Section("Skipped files", (words, Items(texts))))
    if contradictions := campaign.contradictions():
        first.append(Section("Contradictions", (Items(tuple(contradictions)),)))
    last = []
    if (wear := campaign.wear(confidence)) is not None:
        last.append(_wear_section(wear))
    return first, last


def _wear_section(wear: Wear) -> Section:
    parts: list[Block] = []
    if wear.coefficient is not None:
        # In cubic micrometres per joule, as usual in the literature.
        value, low, high = (1e18 * end for end in wear.coefficient[:3])
        ends = "" if math.isnan(low) else f" ({low:.3g} to {high:.3g})"
        count = len(wear.records)
        parts.append(
            Note(
                f"Energy wear coefficient: {value:.3g} µm³/J{ends}, from {count} worn volume"
                f"{'s' * (count > 1)} and the energy dissipated since the specimen was new "
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
    campaign: Campaign, skipped: Sequence[tuple[str, str]], confidence: float
) -> dict[str, Any]:
    """Return the numbers of a campaign as plain values in SI units."""
    keys = [column.key for column in _columns(campaign)]
    wear = campaign.wear(confidence)
    data = {
        "skipped": [{"file": name, "reason": why} for name, why in skipped],
        "table": [dict(zip(keys, row, strict=True)) for row in campaign_rows(campaign)],
        "contradictions": campaign.contradictions(),
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
