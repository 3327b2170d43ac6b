"""Document of a batch: number of items, failures with reasons, one table and figures over all."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip._core.files import whole_file
from microslip._core.quantities import UNITS, json_value
from microslip._core.units import SMALLEST, significant
from microslip.figures.picture import Picture
from microslip.figures.plot import Axis, Panel, Plot, stacked
from microslip.report import cells
from microslip.report.document import (
    Block,
    Column,
    Document,
    Facts,
    Items,
    Note,
    Number,
    Section,
    Table,
)
from microslip.report.files import csv_text, header, listed, standard_files, text_cell, text_file
from microslip.runs.batch import Batch, Outcome
from microslip.sweeps.quantiles import intervals

KIND = "microslip-batch"
SUMMARY_SCHEMA = 1
_QUANTILES = {"q5": 0.05, "q50": 0.5, "q95": 0.95}
_OUTER = ("q5", "q95")
_WITHIN = (
    "Intervals are 90 % intervals of the quantiles, if the items are independent samples of the "
    "production; an open end (?) needs 59 items or more."
)


def document(batch: Batch) -> Document:
    """A batch as a document; its data is the summary."""
    completed, failed = batch.done, batch.failed
    missing = len(batch.items) - len(completed) - len(failed)
    columns = columns_of(completed)
    statistics = _statistics(columns, len(completed))
    counts = (
        ("Done", str(len(completed))),
        ("Failed", str(len(failed))),
        ("Remaining", str(missing)),
        ("Computed in this run", str(batch.computed)),
    )
    blocks: list[Block] = [Facts("Items", counts)]
    reasons = tuple((outcome["item"], outcome["reason"]) for outcome in failed)
    if failed:
        heads = (Column("item", "Item"), Column("reason", "Reason"))
        blocks.append(Table("Failed", heads, reasons, noun="items"))
    sections = [Section("Items", tuple(blocks))]
    if completed:
        blocks = [_table(statistics), Note(_WITHIN, small=True)]
        sections.append(Section("Over all", tuple(blocks)))
    is_drawn = "loss_factor" in columns and _amplitude(columns) is not None
    if is_drawn:
        caption = "Loss factor and energy of all items against the amplitude."
        picture = Picture("batch", caption, lambda: plot(columns), "Results of all items")
        sections.append(Section("Figures", (picture,), brief=False))
    if missing:
        note = f"{missing} items belong to another shard or to the next run."
        sections.append(Section("Notes", (Items((note,)),)))
    number = _number(statistics)
    answer = f"{len(completed)} of {len(batch.items)} items done, {len(failed)} failed"
    answer += f"; the median {number.name} is {number.value}." if number else "."
    data: dict[str, Any] = {
        **header(KIND, SUMMARY_SCHEMA, "Batch"),
        "items": len(batch.items),
        "done": len(completed),
        "failed": [{"item": outcome["item"], "reason": outcome["reason"]} for outcome in failed],
        "not_yet": missing,
        "statistics": statistics,
        "units": dict(UNITS),
        "files": [],
    }
    files = (
        text_file("items.csv", lambda: _items(completed, columns)),
        text_file(
            "failures.csv",
            lambda: csv_text(
                ("item", "reason"),
                ([text_cell(o[key]) for key in ("item", "reason")] for o in failed),
            ),
        ),
    )
    figure = "batch" if is_drawn else ""
    return listed(Document(KIND, "Batch", answer, tuple(sections), data, (), number, figure, files))


def columns_of(completed: list[Outcome]) -> dict[str, Floats]:
    """The numbers of all items, a row each; the columns in the order they first come in."""
    rows = [row for outcome in completed for row in outcome["rows"]]
    names = dict.fromkeys(name for row in rows for name in row)
    return {
        name: np.array([math.nan if row.get(name) is None else row[name] for row in rows])
        for name in names
    }


def _statistics(columns: dict[str, Floats], items: int) -> dict[str, Any]:
    """Quantiles over all rows, and their intervals where the items are independent draws."""
    statistics = {}
    for name, values in columns.items():
        finite = values[np.isfinite(values)]
        if finite.size:
            ends = np.quantile(finite, list(_QUANTILES.values())).tolist()
            between = intervals(finite[None], list(_QUANTILES.values()), min(items, finite.size))
            statistics[name] = {
                "count": finite.size,
                **dict(zip(_QUANTILES, ends, strict=True)),
                "intervals": dict(zip(_QUANTILES, json_value(between.T), strict=True)),
            }
    return statistics


def _number(statistics: dict[str, Any]) -> Number | None:
    """The median over all rows with its band: of the damping, where there is one."""
    preferred = ("loss_factor", "damping_ratio", *statistics)
    name = next((n for n in preferred if n in statistics), None)
    if name is None:
        return None
    low, middle, high = (_written(statistics[name][q], name) for q in _QUANTILES)
    band = f"{low} to {high} (5 to 95 % of {statistics[name]['count']} rows)"
    return Number(name.replace("_", " "), middle, band)


def _written(value: float, name: str) -> str:
    unit = UNITS.get(name, "-")
    value = 0.0 if abs(value) < SMALLEST else value  # rounding, such as of a stiffness past slip
    # A prefix before a square would be squared as well.
    return f"{significant(value, 4)} {unit}" if "^" in unit else cells.value(value, unit)


def _table(statistics: dict[str, Any]) -> Table:
    columns = (
        Column("quantity", "Quantity"),
        Column("count", "Rows", write=cells.counted),
        *(Column(name, f"{100.0 * share:g} %") for name, share in _QUANTILES.items()),
        *(
            Column(f"{name}_interval", f"{100.0 * _QUANTILES[name]:g} % interval")
            for name in _OUTER
        ),
    )

    def within(ends: list[float | None], name: str) -> str:
        return " to ".join("?" if end is None else _written(end, name) for end in ends)

    rows = tuple(
        (
            name.replace("_", " "),
            n["count"],
            *(_written(n[q], name) for q in _QUANTILES),
            *(within(n["intervals"][q], name) for q in _OUTER),
        )
        for name, n in statistics.items()
    )
    return Table("All rows of all items", columns, rows, noun="quantities")


def _amplitude(columns: dict[str, Floats]) -> Floats | None:
    return columns.get("amplitude", columns.get("displacement_amplitude"))


def plot(columns: dict[str, Floats]) -> Plot:
    """Marks of all rows over their amplitudes."""
    amplitude = _amplitude(columns)
    assert amplitude is not None  # who calls has looked
    panels = []
    for name, label in (("loss_factor", "Loss factor η"), ("dissipated_energy", "Energy [J]")):
        if name in columns:
            panel = Panel(Axis("Displacement amplitude [µm]", log=True), Axis(label, log=True))
            panel.marks(amplitude * 1e6, columns[name], "#2b7bba", size=2.5, filled=True)
            panels.append(panel)
    return stacked(panels, 3.2 * len(panels) + 0.6)


def _items(completed: list[Outcome], columns: dict[str, Floats]) -> str:
    """The table over all."""
    items = [text_cell(outcome["item"]) for outcome in completed for _ in outcome["rows"]]
    numbers = (map(repr, values.tolist()) for values in columns.values())
    heads = ["item", *(f"{name} [{UNITS.get(name, '-')}]" for name in columns)]
    return csv_text(heads, zip(items, *numbers, strict=True))


def finish(batch: Batch, folder: Path) -> None:
    """Write the table over all and the report into the folder of a batch, each file whole."""
    for file in standard_files(document(batch)):
        with whole_file(folder / file.name, overwrite=True) as stage:
            file.write(stage, lambda share: None)
