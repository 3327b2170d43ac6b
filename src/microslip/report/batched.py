"""Document of a batch: counts, failures with reasons, and a table over all items."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip._core.dataset import DataSet
from microslip._core.files import atomic_file
from microslip._core.quantities import QUANTITY_UNITS, Quantity, count
from microslip.report import cells
from microslip.report.document import Block, Document, Section, Table
from microslip.report.files import complete, csv_file, header
from microslip.study.runs.batch import Batch, Outcome

BATCH_SCHEMA = 1


def batch_document(batch: Batch) -> Document:
    """Return the document of a batch; its field ``data`` holds the content of summary.json."""
    done, failed = batch.done, batch.failed
    columns = batch_columns(done)
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
        **header("batch", BATCH_SCHEMA, "Batch"),
        "items": len(batch.outcomes),
        "done": len(done),
        "failed": DataSet.of_rows(reasons).records(),
        "units": dict(QUANTITY_UNITS),
        "files": [],
    }
    files = (csv_file("items.csv", lambda: items_data(done, columns)),)
    sections = (Section("Items", tuple(blocks)),)
    return complete(Document("Batch", answer, sections, data, files=files))


def batch_columns(completed: list[Outcome]) -> dict[str, Floats]:
    """Return the numbers of all items, one array per name; NaN where an item has no such number."""
    rows = [row for outcome in completed for row in outcome["rows"]]
    names = dict.fromkeys(name for row in rows for name in row)
    return {
        name: np.array([math.nan if row.get(name) is None else row[name] for row in rows])
        for name in names
    }


def items_data(completed: list[Outcome], columns: dict[str, Floats]) -> DataSet:
    """Return the numbers of all items, one row per load and amplitude."""
    items = [outcome["item"] for outcome in completed for _ in outcome["rows"]]
    numbers = {name: (Quantity(QUANTITY_UNITS.get(name, "-")), v) for name, v in columns.items()}
    return DataSet.of_rows({"item": (count("Item"), items), **numbers})


def finish(batch: Batch, folder: Path) -> Document:
    """Write the files of a batch into its folder, each completely or not at all."""
    result = batch_document(batch)
    for file in result.files:
        with atomic_file(folder / file.name, overwrite=True) as stage:
            file.write(stage)
    return result
