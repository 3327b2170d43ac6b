"""What measured records say together: a row a record, evolution, fretting map, wear, runs."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

from microslip._core.units import significant
from microslip._core.wording import shorten
from microslip.report import cells
from microslip.report.document import Column, Items, Note, Picture, Section, Table
from microslip.report.files import csv_text, plain, text_cell
from microslip.tribometer.campaign import Campaign, Wear
from microslip.tribometer.cycle_columns import LABELS, UNITS
from microslip.tribometer.figures import evolution, fretting_map, worn

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
_BRIEF = ("amplitude", "normal_load", "friction_energy", "dissipated_energy", "loss_factor")


def _columns(campaign: Campaign) -> tuple[Column, ...]:
    per_area = campaign.area is not None
    return (
        Column("record", "record"),
        *((Column("run", "run"),) if campaign.runs is not None else ()),
        Column("cycles", "cycles"),
        Column("regime", "regime"),
        Column("probability", "probability", "", 3, brief=False),
        *(
            Column(name, LABELS[name], UNITS[name].replace("-", ""), brief=name in _BRIEF)
            for name in _COLUMNS_SHOWN
        ),
        *((Column("stiffness_per_area", "stiffness/area", "N/m^3"),) if per_area else ()),
        *((Column("energy_per_area", "energy/cycle/area", "J/m^2"),) if per_area else ()),
        Column("cumulative_energy", "energy, all cycles", "J"),
        Column("settled", "settled"),
    )


def rows_of(campaign: Campaign) -> list[tuple[Any, ...]]:
    """One row a record: plain SI values, None where something is not known."""
    rows = []
    energies = campaign.energies()
    for i, measured in enumerate(campaign.measurements):
        means = {name: plain(mean.value) for name, mean in measured.mean.items()}
        over_area = [means.get(name) for name in ("reversal_stiffness", "dissipated_energy")]
        rows.append(
            (
                shorten(measured.name, 40),
                *((campaign.runs[i],) if campaign.runs is not None else ()),
                len(measured),
                measured.regime,
                measured.probability.get(measured.regime),
                *(means.get(name) for name in _COLUMNS_SHOWN),
                *(v and v / campaign.area for v in over_area if campaign.area is not None),
                plain(energies[i]),
                "yes" if measured.is_settled else "no",
            )
        )
    return rows


def table_of(campaign: Campaign) -> Table:
    """The rows as a table."""
    return Table("Records", _columns(campaign), tuple(rows_of(campaign)), noun="records")


def csv_of(campaign: Campaign) -> str:
    """The rows as a file, all digits."""
    heads = [c.key if c.unit is None else f"{c.key} [{c.unit or '-'}]" for c in _columns(campaign)]
    rows = rows_of(campaign)
    return csv_text(heads, ([text_cell(v) if isinstance(v, str) else v for v in r] for r in rows))


def pictures(campaign: Campaign) -> dict[str, Picture]:
    """Figures of several records, by the names of their files."""
    figures = [
        Picture(
            "evolution",
            "Every cycle of the records over its number, and over the energy that the run has "
            "dissipated so far; logarithmic axes.",
            lambda: evolution(campaign),
            "Friction, stiffness and energy over cycles and cumulative energy",
        )
    ]
    if campaign.fretting_map():
        caption = (
            "Regimes over amplitude and normal load (Vingsbo and Söderberg 1988); mixed where a "
            "second regime is as likely as 1 in 20, or has as many of the cycles."
        )
        plot = partial(fretting_map, campaign)
        figures.append(
            Picture("fretting-map", caption, plot, "Regimes over amplitude and normal load")
        )
    if (wear := campaign.wear()) is not None:
        caption = "Worn volume over dissipated energy, and the straight line through zero."
        plot = partial(worn, wear)
        figures.append(Picture("wear", caption, plot, "Worn volume over dissipated energy"))
    return {figure.name: figure for figure in figures}


def sections(
    campaign: Campaign, skipped: Sequence[tuple[str, str]], confidence: float
) -> tuple[list[Section], list[Section]]:
    """What stands before the single records, and behind them."""
    first = [Section("Records", (table_of(campaign),))]
    if skipped:
        texts = tuple(f"{shorten(name, 80)}: {why}" for name, why in skipped)
        words = Note(f"{len(skipped)} file{'s' * (len(skipped) > 1)} could not be measured:")
        first.append(Section("Left out", (words, Items(texts))))
    figures = pictures(campaign)
    last = [Section("Evolution", (figures["evolution"],), brief=False)]
    if "fretting-map" in figures:
        last.append(Section("Fretting map", (figures["fretting-map"],), brief=False))
    wear = campaign.wear(confidence)
    if wear is not None:
        last.append(Section("Wear", (Note(_wear_text(wear)), figures["wear"])))
    if campaign.worn_volumes is not None and (uncounted := campaign.uncounted()):
        texts = tuple(f"{shorten(name, 80)}: {why}" for name, why in uncounted.items())
        words = Note("No energy wear coefficient of records whose dissipated energy is not known:")
        last.append(Section("Wear without an energy", (words, Items(texts))))
    if campaign.comparison(confidence):
        last.append(Section("Runs compared", (_runs(campaign, confidence),)))
    return first, last


def _wear_text(wear: Wear) -> str:
    coefficient = wear.coefficient
    # Of a cubic micrometre per joule, as papers have it.
    value, low, high = (
        significant(1e18 * x) for x in (coefficient.value, coefficient.low, coefficient.high)
    )
    text = f"Energy wear coefficient: {value} µm³/J"
    if coefficient.number > 1:
        text += f" ({low} … {high}, {coefficient.number} worn volumes)"
    return f"{text}, after Fouvry et al. (2003): worn volume over energy dissipated in all cycles."


def _runs(campaign: Campaign, confidence: float) -> Table:
    columns = (
        Column("quantity", "quantity"),
        Column("condition", "condition"),
        Column("runs", "runs"),
        Column("mean", f"mean ({100.0 * confidence:g} % interval)"),
        Column("within", "std within runs"),
        Column("between", "std between runs"),
    )
    rows = []
    for comparison in campaign.comparison(confidence):
        written = partial(cells.value, unit=UNITS[comparison.column])
        ends = f"{written(comparison.mean.low)} … {written(comparison.mean.high)}"
        rows.append(
            (
                LABELS[comparison.column],
                comparison.condition,
                len(comparison.runs),
                f"{written(comparison.mean.value)} ({ends})",
                written(comparison.within),
                written(comparison.between),
            )
        )
    caption = (
        "Runs are taken at random from all that could be: the interval of the mean holds what "
        "differs between them (one-way analysis of variance, as in ISO 5725-2)."
    )
    brief_rows = tuple(range(min(12, len(rows))))
    return Table(
        "Runs compared", columns, tuple(rows), caption=caption, noun="comparisons", few=brief_rows
    )


def data_of(
    campaign: Campaign, skipped: Sequence[tuple[str, str]], confidence: float
) -> dict[str, Any]:
    """The same as plain values."""
    wear = campaign.wear(confidence)
    keys = [column.key for column in _columns(campaign)]
    data = {
        "skipped": [{"file": name, "reason": why} for name, why in skipped],
        "table": [dict(zip(keys, row, strict=True)) for row in rows_of(campaign)],
        "fretting_map": [point._asdict() for point in campaign.fretting_map()],
        "wear": None if wear is None else {"unit": "m^3/J", **wear.coefficient._asdict()},
        "comparison": [
            {**comparison._asdict(), "mean": comparison.mean._asdict()}
            for comparison in campaign.comparison(confidence)
        ],
    }
    return {key: plain(values) for key, values in data.items()}
