"""What measured records say together: a row a record, evolution, fretting map, wear, runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from microslip._core.units import engineering, significant
from microslip._core.wording import shorten
from microslip.report.document import Column, Items, Note, Picture, Section, Table
from microslip.report.files import text_cell
from microslip.report.plot import Plot
from microslip.tribometer.campaign import Campaign, Wear
from microslip.tribometer.campaign_figures import evolution, fretting_map, worn
from microslip.tribometer.cycle_columns import LABELS, UNITS

_SHOWN = (
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
            for name in _SHOWN
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
        means = {name: mean.value for name, mean in measured.mean.items()}
        known = [_known(means.get(name)) for name in _SHOWN]
        per_area: list[float | None] = []
        if campaign.area is not None:
            for name in ("reversal_stiffness", "dissipated_energy"):
                value = _known(means.get(name))
                per_area.append(None if value is None else value / campaign.area)
        rows.append(
            (
                shorten(measured.name, 40),
                *((campaign.runs[i],) if campaign.runs is not None else ()),
                len(measured),
                measured.regime,
                measured.probability.get(measured.regime),
                *known,
                *per_area,
                float(energies[i]),
                "yes" if measured.is_settled else "no",
            )
        )
    return rows


def _known(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


def table_of(campaign: Campaign) -> Table:
    """The rows as a table."""
    return Table("Records", _columns(campaign), tuple(rows_of(campaign)), noun="records")


def csv_of(campaign: Campaign) -> str:
    """The rows as a file, all digits."""
    columns = _columns(campaign)

    def lines() -> Iterator[str]:
        yield ",".join(
            f"{c.key} [{c.unit or '-'}]" if c.unit is not None else c.key for c in columns
        )
        for row in rows_of(campaign):
            cells = (
                "" if v is None else text_cell(v) if isinstance(v, str) else repr(v) for v in row
            )
            yield ",".join(cells)

    return "\n".join(lines()) + "\n"


def pictures(campaign: Campaign) -> dict[str, Picture]:
    """Figures of several records, by the names of their files."""
    found = {
        "evolution": Picture(
            "evolution",
            "Every cycle of the records over its number, and over the energy that the run has "
            "dissipated so far; logarithmic axes.",
            lambda: evolution(campaign),
            "Friction, stiffness and energy over cycles and cumulative energy",
        )
    }
    if campaign.fretting_map():
        found["fretting-map"] = Picture(
            "fretting-map",
            "Regimes over amplitude and normal load (Vingsbo and Söderberg 1988); mixed where a "
            "second regime is as likely as 1 in 20, or has as many of the cycles.",
            lambda: fretting_map(campaign),
            "Regimes over amplitude and normal load",
        )
    wear = campaign.wear()
    if wear is not None:
        found["wear"] = Picture(
            "wear",
            "Worn volume over dissipated energy, and the straight line through zero.",
            _plot_of(wear),
            "Worn volume over dissipated energy",
        )
    return found


def _plot_of(wear: Wear) -> Callable[[], Plot]:
    return lambda: worn(wear)


def sections(
    campaign: Campaign, skipped: Sequence[tuple[str, str]], confidence: float
) -> tuple[list[Section], list[Section]]:
    """What stands before the single records, and behind them."""
    first = [Section("Records", (table_of(campaign),))]
    if skipped:
        texts = tuple(f"{shorten(name, 80)}: {why}" for name, why in skipped)
        words = Note(f"{len(skipped)} file{'s' * (len(skipped) > 1)} could not be measured:")
        first.append(Section("Left out", (words, Items(texts))))
    drawn = pictures(campaign)
    last = [Section("Evolution", (drawn["evolution"],), brief=False)]
    if "fretting-map" in drawn:
        last.append(Section("Fretting map", (drawn["fretting-map"],), brief=False))
    wear = campaign.wear(confidence)
    if wear is not None:
        last.append(Section("Wear", (Note(_wear_text(wear)), drawn["wear"])))
    compared = campaign.comparison(confidence)
    if compared:
        last.append(Section("Runs compared", (_runs(campaign, confidence),)))
    return first, last


def _wear_text(wear: Wear) -> str:
    found = wear.coefficient
    # Of a cubic micrometre per joule, as papers have it.
    value, low, high = (significant(1e18 * x) for x in (found.value, found.low, found.high))
    text = f"Energy wear coefficient: {value} µm³/J"
    if found.number > 1:
        text += f" ({low} … {high}, {found.number} worn volumes)"
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
    for found in campaign.comparison(confidence):
        unit = UNITS[found.column].replace("-", "")

        def said(value: float, unit: str = unit) -> str:
            if not math.isfinite(value):
                return "–"
            return engineering(value, unit, 4) if unit else significant(value, 4)

        ends = f"{said(found.mean.low)} … {said(found.mean.high)}"
        rows.append(
            (
                LABELS[found.column],
                found.condition,
                len(found.runs),
                f"{said(found.mean.value)} ({ends})",
                said(found.within),
                said(found.between),
            )
        )
    caption = (
        "Runs are taken at random from all that could be: the interval of the mean holds what "
        "differs between them (one-way analysis of variance, as in ISO 5725-2)."
    )
    return Table(
        "Runs compared",
        columns,
        tuple(rows),
        caption=caption,
        noun="comparisons",
        few=tuple(range(min(12, len(rows)))),
    )


def data_of(
    campaign: Campaign, skipped: Sequence[tuple[str, str]], confidence: float
) -> dict[str, Any]:
    """The same as plain values."""
    wear = campaign.wear(confidence)
    return {
        "skipped": [{"file": name, "reason": why} for name, why in skipped],
        "table": [
            dict(zip((c.key for c in _columns(campaign)), row, strict=True))
            for row in rows_of(campaign)
        ],
        "fretting_map": [point._asdict() for point in campaign.fretting_map()],
        "wear": None
        if wear is None
        else {
            "unit": "m^3/J",
            **{key: _known(value) for key, value in wear.coefficient._asdict().items()},
        },
        "comparison": [
            {
                "column": found.column,
                "condition": found.condition,
                "runs": list(found.runs),
                "mean": {key: _known(value) for key, value in found.mean._asdict().items()},
                "within": _known(found.within),
                "between": _known(found.between),
            }
            for found in campaign.comparison(confidence)
        ],
    }
