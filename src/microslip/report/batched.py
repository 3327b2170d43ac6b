"""Document of a batch: counts, failures with reasons, and a table over all items."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from microslip._core.dataset import DataSet
from microslip._core.files import atomic_file
from microslip._core.quantities import QUANTITY_UNITS, Quantity, count
from microslip.report import cells
from microslip.report.document import Block, Document, Section, Table
from microslip.report.files import complete, csv_file, header
from microslip.study.runs.batch import Batch, Outcome


def batch_document(batch: Batch) -> Document:
    """Return the document of a batch; its field ``data`` holds the content of summary.json."""
    done, failed = batch.done, batch.failed
    counts = (
        ("Done", str(len(done))),
        ("Failed", str(len(failed))),
        ("Computed in this run", str(batch.computed)),
    )
    reasons = {
        name: (count(name.capitalize()), [outcome[name] for outcome in failed])
        for name in ("item", "reason")
    }
    blocks: list[Block] = [cells.texts("Items", counts)]
    if failed:
        blocks.append(Table("Failed", DataSet.of_rows(reasons), noun="items"))
    answer = f"{len(done)} of {len(batch.outcomes)} items done, {len(failed)} failed."
    data: dict[str, Any] = {
        **header("batch", 1, "Batch"),
        "items": len(batch.outcomes),
        "done": len(done),
        "failed": DataSet.of_rows(reasons).records(),
        "units": dict(QUANTITY_UNITS),
        "files": [],
    }
    files = (csv_file("items.csv", lambda: items_data(done)),)
    sections = (Section("Items", tuple(blocks)),)
    return complete(Document("Batch", answer, sections, data, files=files))


def items_data(completed: list[Outcome]) -> DataSet:
    """Return the numbers of all items, one row per load and amplitude; NaN where one is absent."""
    rows = [row for outcome in completed for row in outcome["rows"]]
    columns: dict[str, Any] = {
        "item": (count("Item"), [done["item"] for done in completed for _ in done["rows"]])
    }
    for name in dict.fromkeys(name for row in rows for name in row):
        columns[name] = Quantity(QUANTITY_UNITS.get(name, "-")), [row.get(name) for row in rows]
    return DataSet.of_rows(columns)


def finish(batch: Batch, folder: Path) -> Document:
    """Write the files of a batch into its folder, each completely or not at all."""
    result = batch_document(batch)
    for file in result.files:
        with atomic_file(folder / file.name, overwrite=True) as stage:
            file.write(stage)
    return result
