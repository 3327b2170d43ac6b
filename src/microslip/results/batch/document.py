"""What a batch says: how many, which failed and why, one table and figures over all."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip._core.files import whole_file
from microslip._core.quantities import UNITS
from microslip._core.units import engineering, significant
from microslip.report.document import (
    Block,
    Column,
    Document,
    Facts,
    Items,
    Number,
    Picture,
    Section,
    Table,
)
from microslip.report.files import File, header, standard_files, text_cell, text_file
from microslip.report.plot import Axis, Panel, Plot, stacked
from microslip.results.batch.run import Batch, Outcome

KIND = "microslip-batch"
SUMMARY_SCHEMA = 1


def document(batch: Batch) -> Document:
    """A batch as a document; its data is the summary."""
    done, failed = batch.done, batch.failed
    missing = len(batch.items) - len(done) - len(failed)
    blocks: list[Block] = [
        Facts(
            "Items",
            (
                ("Done", str(len(done))),
                ("Failed", str(len(failed))),
                ("Not yet", str(missing)),
                ("Computed in this run", str(batch.computed)),
            ),
        )
    ]
    if failed:
        columns = (Column("item", "Item"), Column("reason", "Reason"))
        rows = tuple((one["item"], one["reason"]) for one in failed)
        blocks.append(Table("Failed", columns, rows, noun="items"))
    sections = [Section("Items", tuple(blocks))]
    if done:
        sections.append(Section("Over all", (_statistics(done),)))
        if _drawable(done):
            picture = Picture(
                "batch",
                "Loss factor and energy of all items against the amplitude.",
                lambda: plot(done),
                "Results of all items",
            )
            sections.append(Section("Figures", (picture,), brief=False))
    if missing:
        note = f"{missing} items are another shard's, or wait for the next run."
        sections.append(Section("Notes", (Items((note,)),)))
    number = _number(done)
    answer = f"{len(done)} of {len(batch.items)} items done, {len(failed)} failed"
    answer += f"; the median {number.name} is {number.value}." if number else "."
    drawn = ("batch.svg",) if _drawable(done) else ()
    data: dict[str, Any] = {
        **header(KIND, SUMMARY_SCHEMA, "Batch"),
        "items": len(batch.items),
        "done": len(done),
        "failed": [{"item": one["item"], "reason": one["reason"]} for one in failed],
        "not_yet": missing,
        "statistics": _numbers(done),
        "units": dict(UNITS),
        "files": [
            "summary.json", "report.html", "items.csv", "failures.csv", *drawn,
        ],
    }  # fmt: skip
    figure = "batch" if _drawable(done) else ""
    return Document(KIND, "Batch", answer, tuple(sections), data, number=number, figure=figure)


def names_of(done: list[Outcome]) -> list[str]:
    """Columns of the table over all items, in the order they first come in."""
    names: dict[str, None] = {}
    for outcome in done:
        for row in outcome["rows"]:
            names |= dict.fromkeys(row)
    return list(names)


def columns_of(done: list[Outcome]) -> dict[str, Floats]:
    """The numbers of all items, a row each."""
    rows = [row for outcome in done for row in outcome["rows"]]
    return {
        name: np.array([math.nan if row.get(name) is None else row[name] for row in rows])
        for name in names_of(done)
    }


def _numbers(done: list[Outcome]) -> dict[str, Any]:
    found = {}
    for name, values in columns_of(done).items():
        known = values[np.isfinite(values)]
        if known.size:
            low, middle, high = np.quantile(known, [0.05, 0.5, 0.95]).tolist()
            found[name] = {"count": int(known.size), "q5": low, "q50": middle, "q95": high}
    return found


def _number(done: list[Outcome]) -> Number | None:
    """The median over all rows with its band: of the damping, where there is one."""
    found = _numbers(done)
    name = next((n for n in ("loss_factor", "damping_ratio", *found) if n in found), None)
    if name is None:
        return None
    low, middle, high = (_written(found[name][q], name) for q in ("q5", "q50", "q95"))
    band = f"{low} to {high} (5 to 95 % of {found[name]['count']} rows)"
    return Number(name.replace("_", " "), middle, band)


def _written(value: float, name: str) -> str:
    unit = UNITS.get(name, "-")
    if unit in ("-", "1", ""):
        return significant(value, 4)
    # A prefix before a square would be squared as well.
    return f"{significant(value, 4)} {unit}" if "^" in unit else engineering(value, unit, 4)


def _statistics(done: list[Outcome]) -> Table:
    columns = (
        Column("quantity", "Quantity"),
        Column("count", "Rows", write=lambda n: f"{n:.0f}"),
        *(Column(f"q{share}", f"{share} %") for share in (5, 50, 95)),
    )
    rows = tuple(
        (
            name.replace("_", " "), n["count"],
            *(_written(n[f"q{share}"], name) for share in (5, 50, 95)),
        )
        for name, n in _numbers(done).items()
    )  # fmt: skip
    return Table("All rows of all items", columns, rows, noun="quantities")


def _drawable(done: list[Outcome]) -> bool:
    names = names_of(done)
    return "loss_factor" in names and bool(_amplitude(names))


def _amplitude(names: list[str]) -> str:
    return next((n for n in ("amplitude", "displacement_amplitude") if n in names), "")


def plot(done: list[Outcome]) -> Plot:
    """Marks of all rows over their amplitudes."""
    columns = columns_of(done)
    x = columns[_amplitude(list(columns))] * 1e6
    panels = []
    for name, label in (("loss_factor", "Loss factor η"), ("dissipated_energy", "Energy [J]")):
        if name in columns:
            panel = Panel(
                Axis("Displacement amplitude [µm]", log=True),
                Axis(label, log=True),
            )
            panel.marks(x, columns[name], "#2b7bba", size=2.5, filled=True)
            panels.append(panel)
    return stacked(panels, 3.2 * len(panels) + 0.6, (1.0,) * len(panels))


def files(batch: Batch) -> tuple[File, ...]:
    """The table over all, the failures, and what every result writes."""
    done = batch.done
    columns = columns_of(done)
    lengths = [len(outcome["rows"]) for outcome in done]

    def table() -> str:
        heads = ["item", *(f"{n} [{UNITS.get(n, '-')}]" for n in columns)]
        lines = [",".join(heads)]
        place = 0
        for outcome, length in zip(done, lengths, strict=True):
            for _ in range(length):
                numbers = (repr(float(values[place])) for values in columns.values())
                lines.append(",".join((text_cell(outcome["item"]), *numbers)))
                place += 1
        return "\n".join(lines) + "\n"

    def failures() -> str:
        lines = [f"{text_cell(one['item'])},{text_cell(one['reason'])}" for one in batch.failed]
        return "\n".join(["item,reason", *lines]) + "\n"

    own = [text_file("items.csv", table), text_file("failures.csv", failures)]
    made = document(batch)
    return standard_files(made, made.data["files"], own)


def finish(batch: Batch, folder: Path) -> None:
    """Write the table over all and the report into the folder of a batch, each file whole."""
    for file in files(batch):
        with whole_file(folder / file.name, overwrite=True) as stage:
            file.write(stage, lambda share: None)
