"""Records of a campaign together: a row a record, evolution, fretting map, wear, runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from microslip._core.quantities import json_value, named
from microslip._core.units import engineering, significant
from microslip._core.wording import shorten
from microslip.figures.picture import Picture
from microslip.report import cells
from microslip.report.document import Column, Items, Note, Section, Table
from microslip.report.files import csv_text, text_cell
from microslip.tribometer import figures
from microslip.tribometer.campaign import Campaign, LoadLaw
from microslip.tribometer.campaign_laws import Pooled, RunningIn, Wear
from microslip.tribometer.cycle_columns import LABELS, UNITS
from microslip.tribometer.manifest import text_of

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
    per_area = campaign.area is not None
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
        means = {name: json_value(mean.value) for name, mean in measured.mean.items()}
        over_area = [means.get(name) for name in ("reversal_stiffness", "dissipated_energy")]
        rows.append(
            (
                shorten(measured.name, 40),
                *(text_of(values[i]) for values in campaign.columns.values()),
                *((campaign.runs[i],) if campaign.runs is not None else ()),
                len(measured),
                measured.regime,
                measured.probability.get(measured.regime),
                *(means.get(name) for name in _COLUMNS_SHOWN),
                *(v and v / campaign.area for v in over_area if campaign.area is not None),
                json_value(energies[i]),
                "yes" if measured.is_settled else "no",
            )
        )
    return rows


def csv_of(campaign: Campaign) -> str:
    """The rows as a file, all digits."""
    heads = [c.key if c.unit is None else f"{c.key} [{c.unit or '-'}]" for c in _columns(campaign)]
    rows = rows_of(campaign)
    # Behind the row of a terminal the intervals, which it has no room for.
    ends = [f"{name} {end} [{UNITS[name]}]" for name in _COLUMNS_SHOWN for end in ("low", "high")]
    intervals = [
        [end for name in _COLUMNS_SHOWN for end in m.mean.get(name, _NO_MEAN)[1:3]]
        for m in campaign.measurements
    ]
    return csv_text(
        [*heads, *ends],
        (
            [*(text_cell(v) if isinstance(v, str) else v for v in row), *map(json_value, behind)]
            for row, behind in zip(rows, intervals, strict=True)
        ),
    )


def sections(
    campaign: Campaign, skipped: Sequence[tuple[str, str]], confidence: float
) -> tuple[list[Section], list[Section]]:
    """Sections before and after the single records."""
    table = Table("Records", _columns(campaign), tuple(rows_of(campaign)), noun="records")
    first = [Section("Records", (table,))]
    if skipped:
        texts = tuple(f"{shorten(name, 80)}: {why}" for name, why in skipped)
        words = Note(f"{len(skipped)} file{'s' * (len(skipped) > 1)} could not be measured:")
        first.append(Section("Left out", (words, Items(texts))))
    picture = Picture(
        "evolution",
        "Every cycle of the records over its number, and over the cumulative dissipated energy of "
        "the run; logarithmic axes.",
        partial(figures.evolution, campaign),
        "Friction, stiffness and energy over cycles and cumulative energy",
    )
    last = [Section("Evolution", (picture,), brief=False)]
    if campaign.fretting_map():
        caption = (
            "Regimes over amplitude and normal load (Vingsbo and Söderberg 1988); mixed where a "
            "second regime has a probability, or a share of the cycles, of 1 in 20 or more."
        )
        if campaign.borders is not None:
            caption += " The lines are the borders by the law with its rig in series."
        plot = partial(figures.fretting_map, campaign)
        picture = Picture("fretting-map", caption, plot, "Regimes over amplitude and normal load")
        last.append(Section("Fretting map", (picture,), brief=False))
    if campaign.drawn_over is not None:
        caption = f"Means of the records with their intervals, over {campaign.drawn_over}."
        plot = partial(figures.means_figure, campaign)
        picture = Picture("means", caption, plot, "Means of the records")
        last.append(Section("Stages", (picture,), brief=False))
    if campaign.friction_logs():
        caption = (
            "Friction log: the force over displacement and cycle, for rising (left) and falling "
            "displacement (right); each cycle without its offsets."
        )
        plot = partial(figures.friction_log_figure, campaign)
        picture = Picture("friction-log", caption, plot, "Force over displacement and cycle")
        last.append(Section("Friction log", (picture,), brief=False))
    if found := campaign.pooled(confidence):
        pooled_table, means_table = _specimens(found, confidence)
        last.append(Section("Specimens", (pooled_table,)))
        last.append(Section("Each specimen", (means_table,), brief=False))
    if (load_law := campaign.load_law(confidence)) is not None:
        caption = "Stiffness after reversal over normal load, and the power law through it."
        plot = partial(figures.stiffness_figure, campaign, load_law)
        picture = Picture("stiffness", caption, plot, "Stiffness over normal load")
        words = Note(_load_text(load_law, confidence))
        last.append(Section("Stiffness and load", (words, picture)))
    if laws := campaign.running_in(confidence):
        caption = "Running-in cycles, and the exponential law through them."
        plot = partial(figures.running_in_figure, laws)
        picture = Picture("running-in", caption, plot, "Running in")
        last.append(Section("Running in", (_run_in(laws, confidence), picture)))
    if wear := campaign.wear_laws(confidence):
        caption = (
            "Worn volume over dissipated energy, and over load times sliding distance (Archard), "
            "with straight lines through zero; dashed: with a threshold."
        )
        plot = partial(figures.worn, wear)
        picture = Picture("wear", caption, plot, "Worn volume over dissipated energy")
        last.append(Section("Wear", (Items(tuple(map(_wear_text, wear))), picture)))
    if campaign.worn_volumes is not None and (uncounted := campaign.uncounted()):
        texts = tuple(f"{shorten(name, 80)}: {why}" for name, why in uncounted.items())
        words = Note("No energy wear coefficient of records whose dissipated energy is not known:")
        last.append(Section("Worn volumes without an energy", (words, Items(texts))))
    if campaign.comparison(confidence):
        last.append(Section("Runs compared", (_runs(campaign, confidence),)))
    return first, last


def _ends(estimate: Any, write: Callable[[float], str]) -> str:
    """A value, and its interval where it has one."""
    if not math.isfinite(estimate.low):
        return write(estimate.value)
    return f"{write(estimate.value)} ({write(estimate.low)} … {write(estimate.high)})"


def _wear_text(wear: Wear) -> str:
    # Of a cubic micrometre per joule, as papers have it.
    text = _ends(wear.coefficient, lambda value: f"{float(f'{1e18 * value:.3g}'):g}")
    count = f"{wear.coefficient.number} worn volume{'s' * (wear.coefficient.number > 1)}"
    beside = (
        "" if math.isnan(wear.scatter) else f", scatter {significant(1e9 * wear.scatter, 2)} mm³"
    )
    if wear.is_archard:
        return f"Archard's coefficient: {text} µm³/(N m), {count}{beside}."
    if wear.threshold is None:
        return (
            f"Energy wear coefficient: {text} µm³/J, {count}{beside}; after Fouvry et al. (2003): "
            "worn volume over energy dissipated in all cycles."
        )
    threshold = _ends(wear.threshold, lambda value: engineering(value, "J"))
    verdict = (
        "no wear below it" if wear.has_threshold else "not resolved, the interval includes zero"
    )
    return f"With a threshold: {text} µm³/J from {threshold}{beside}; {verdict}."


def _load_text(law: LoadLaw, confidence: float) -> str:
    exponent = _ends(law.exponent, significant)
    rig = (
        " These stiffnesses include the compliance of the rig, which lowers the exponent: give "
        "the stiffness of the rig to subtract it."
    )
    return (
        f"Stiffness after reversal grows with the load to the power {exponent}, "
        f"{100.0 * confidence:g} % interval; {engineering(law.stiffness, 'N/m')} at "
        f"{engineering(law.load, 'N')}.{rig * law.with_rig}"
    )


def _run_in(laws: Sequence[RunningIn], confidence: float) -> Table:
    level = f"({100.0 * confidence:g} % interval)"
    columns = (
        Column("record", "record"),
        Column("quantity", "quantity"),
        Column("constant", f"cycles to 1/e {level}"),
        Column("settled", f"tends to {level}"),
        Column("change", "from"),
    )
    rows = tuple(
        (
            shorten(law.label, 40),
            LABELS[law.column],
            _ends(law.constant, significant),
            _ends(law.settled, partial(cells.value, unit=UNITS[law.column])),
            cells.value(law.settled.value + law.change, UNITS[law.column]),
        )
        for law in laws
    )
    return Table("Running in", columns, rows, noun="laws")


def _specimens(found: Sequence[tuple[str, Pooled]], confidence: float) -> tuple[Table, Table]:
    """Pooled values, and those of each specimen."""
    columns = (
        Column("quantity", "quantity"),
        Column("condition", "condition"),
        Column("specimens", "specimens"),
        Column("mean", f"mean of all ({100.0 * confidence:g} % interval)"),
        Column("between", "scatter between specimens"),
    )
    rows, mean_rows = [], []
    for condition, pool in found:
        write = partial(cells.value, unit=UNITS[pool.quantity])
        name = LABELS[pool.quantity]
        rows.append(
            (name, condition, len(pool.of_each), _ends(pool.mean, write), write(pool.between))
        )
        mean_rows += [(label, name, condition, _ends(mean, write)) for label, mean in pool.of_each]
    caption = (
        "Specimens are taken as a random sample: the interval includes the scatter between them "
        "and the error of each. The scatter is the part that their own errors do not explain."
    )
    few = tuple(range(min(12, len(rows))))
    mean = Column("mean", f"mean ({100.0 * confidence:g} % interval)")
    heads = (Column("specimen", "specimen"), *columns[:2], mean)
    return (
        Table("Specimens together", columns, tuple(rows), caption=caption, few=few),
        Table("Each specimen", heads, tuple(mean_rows), noun="means"),
    )


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
        rows.append(
            (
                LABELS[comparison.column],
                comparison.condition,
                len(comparison.runs),
                _ends(comparison.mean, written),
                written(comparison.within),
                written(comparison.between),
            )
        )
    caption = (
        "Runs are taken as a random sample: the interval of the mean includes the scatter between "
        "them (one-way analysis of variance, as in ISO 5725-2)."
    )
    brief_rows = tuple(range(min(12, len(rows))))
    return Table(
        "Runs compared", columns, tuple(rows), caption=caption, noun="comparisons", few=brief_rows
    )


def data_of(
    campaign: Campaign, skipped: Sequence[tuple[str, str]], confidence: float
) -> dict[str, Any]:
    """The same as plain values."""
    wear, load_law = campaign.wear(confidence), campaign.load_law(confidence)
    keys = [column.key for column in _columns(campaign)]
    data = {
        "skipped": [{"file": name, "reason": why} for name, why in skipped],
        "table": [dict(zip(keys, row, strict=True)) for row in rows_of(campaign)],
        "fretting_map": list(map(named, campaign.fretting_map())),
        "wear": None if wear is None else {"unit": "m^3/J", **named(wear.coefficient)},
        "specimens": [
            {
                "condition": condition,
                **named(pool, "quantity", "mean", "between"),
                "each": {label: named(mean) for label, mean in pool.of_each},
            }
            for condition, pool in campaign.pooled(confidence)
        ],
        "stiffness_over_load": None if load_law is None else named(load_law),
        "running_in": [
            named(law, "label", "column", "change", "first", "settled", "constant")
            for law in campaign.running_in(confidence)
        ],
        "wear_laws": [
            named(law, "law", "coefficient", "threshold", "scatter")
            for law in campaign.wear_laws(confidence)
        ],
        "comparison": list(map(named, campaign.comparison(confidence))),
    }
    return {key: json_value(values) for key, values in data.items()}
