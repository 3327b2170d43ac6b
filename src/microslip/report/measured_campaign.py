"""Records of a campaign: table, evolution, fretting map, wear."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from microslip._core.quantities import json_value, named
from microslip._core.units import significant
from microslip._core.wording import shorten
from microslip.figures.picture import Picture
from microslip.laboratory import figures
from microslip.laboratory.campaign import Campaign, Wear
from microslip.laboratory.cycle_columns import LABELS, UNITS
from microslip.laboratory.manifest import text_of
from microslip.report.document import Column, Items, Note, Section, Table
from microslip.report.files import csv_text, text_cell

_COLUMNS_SHOWN = (
    "amplitude",
    "normal_load",
    "friction_peak",
    "friction_energy",
    "stiffness_left",
    "stiffness_right",
    "linear_range",
    "dissipated_energy",
    "loss_factor",
)
_NO_MEAN = (None, None, None)
_BRIEF = ("amplitude", "normal_load", "friction_energy", "dissipated_energy", "loss_factor")


def _columns(campaign: Campaign) -> tuple[Column, ...]:
    return (
        Column("record", "record"),
        *(Column(name, name, brief=name in ("specimen", "stage")) for name in campaign.columns),
        *((Column("run", "run"),) if campaign.runs is not None else ()),
        Column("cycles", "cycles"),
        Column("regime", "regime"),
        Column("probability", "probability", "", 3, brief=False),
        *(
            Column(name, LABELS[name], UNITS[name].replace("-", ""), brief=name in _BRIEF)
            for name in _COLUMNS_SHOWN
        ),
        Column("cumulative_energy", "energy, all cycles", "J"),
        Column("settled", "settled"),
    )


def campaign_rows(campaign: Campaign) -> list[tuple[Any, ...]]:
    """Return one row for each record: plain values in SI units, None if unknown."""
    rows = []
    energies = campaign.energies()
    for i, measured in enumerate(campaign.measurements):
        means = {name: json_value(mean.value) for name, mean in measured.mean.items()}
        rows.append(
            (
                shorten(measured.name, 40),
                *(text_of(values[i]) for values in campaign.columns.values()),
                *((campaign.runs[i],) if campaign.runs is not None else ()),
                len(measured),
                measured.regime,
                measured.probability.get(measured.regime),
                *(means.get(name) for name in _COLUMNS_SHOWN),
                json_value(energies[i]),
                "yes" if measured.is_settled else "no",
            )
        )
    return rows


def csv_of(campaign: Campaign) -> str:
    """Return the rows as text of campaign.csv, with frequency, wear and ends of intervals."""
    heads = [c.key if c.unit is None else f"{c.key} [{c.unit or '-'}]" for c in _columns(campaign)]
    heads += ["frequency [Hz]", "worn_volume [m^3]", "contact_energy [J]"]
    heads += [f"{name} {end} [{UNITS[name]}]" for name in _COLUMNS_SHOWN for end in ("low", "high")]
    volumes = campaign.worn_volumes or [None] * len(campaign.measurements)
    energies, _ = campaign.worn_by()
    behind = [
        [
            *(measured.frequency, volume, energy),
            *(end for name in _COLUMNS_SHOWN for end in measured.mean.get(name, _NO_MEAN)[1:3]),
        ]
        for measured, volume, energy in zip(
            campaign.measurements, volumes, energies.tolist(), strict=True
        )
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
    """Return the sections to place before and after those of the single records."""
    table = Table("Records", _columns(campaign), tuple(campaign_rows(campaign)), noun="records")
    first = [Section("Records", (table,))]
    if skipped:
        texts = tuple(f"{shorten(name, 80)}: {why}" for name, why in skipped)
        words = Note(f"{len(skipped)} file{'s' * (len(skipped) > 1)} could not be measured:")
        first.append(Section("Skipped files", (words, Items(texts))))
    if contradictions := campaign.contradictions():
        first.append(Section("Contradictions", (Items(tuple(contradictions)),)))
    picture = Picture(
        "evolution",
        "Every cycle of the records against its number, and against the cumulative dissipated "
        "energy of the run; logarithmic axes.",
        partial(figures.evolution, campaign),
        "Friction, stiffness and energy over cycles and cumulative energy",
    )
    last = [Section("Evolution", (picture,), brief=False)]
    if campaign.fretting_map():
        caption = (
            "Regimes over amplitude and normal load (Vingsbo and Söderberg 1988); mixed if a "
            "second regime has a probability, or a fraction of the cycles, of 5 % or more."
        )
        plot = partial(figures.fretting_map, campaign)
        picture = Picture("fretting-map", caption, plot, "Regimes over amplitude and normal load")
        last.append(Section("Fretting map", (picture,), brief=False))
    if (wear := campaign.wear(confidence)) is not None:
        caption = "Worn volume over dissipated energy, with a straight line through zero."
        plot = partial(figures.worn, wear)
        picture = Picture("wear", caption, plot, "Worn volume over dissipated energy")
        last.append(Section("Wear", (Note(_wear_text(wear)), picture)))
    if campaign.worn_volumes is not None and (uncounted := campaign.uncounted()):
        texts = tuple(f"{shorten(name, 80)}: {why}" for name, why in uncounted.items())
        words = Note("No energy wear coefficient for records with unknown dissipated energy:")
        last.append(Section("Worn volumes without an energy", (words, Items(texts))))
    return first, last


def _ends(estimate: Any, write: Callable[[float], str]) -> str:
    if not math.isfinite(estimate.low):
        return write(estimate.value)
    return f"{write(estimate.value)} ({write(estimate.low)} … {write(estimate.high)})"


def _wear_text(wear: Wear) -> str:
    # In cubic micrometres per joule, as usual in the literature.
    text = _ends(wear.coefficient, lambda value: f"{float(f'{1e18 * value:.3g}'):g}")
    count = f"{wear.coefficient.number} worn volume{'s' * (wear.coefficient.number > 1)}"
    beside = (
        "" if math.isnan(wear.scatter) else f", scatter {significant(1e9 * wear.scatter, 2)} mm³"
    )
    return (
        f"Energy wear coefficient: {text} µm³/J, {count}{beside}; after Fouvry et al. (2003): "
        "worn volume over energy dissipated in all cycles."
    )


def campaign_data(
    campaign: Campaign, skipped: Sequence[tuple[str, str]], confidence: float
) -> dict[str, Any]:
    """Return the numbers of a campaign as plain values in SI units."""
    wear = campaign.wear(confidence)
    keys = [column.key for column in _columns(campaign)]
    data = {
        "skipped": [{"file": name, "reason": why} for name, why in skipped],
        "table": [dict(zip(keys, row, strict=True)) for row in campaign_rows(campaign)],
        "fretting_map": list(map(named, campaign.fretting_map())),
        "contradictions": campaign.contradictions(),
        "wear": None if wear is None else {"unit": "m^3/J", **named(wear.coefficient)},
    }
    return {key: json_value(values) for key, values in data.items()}
