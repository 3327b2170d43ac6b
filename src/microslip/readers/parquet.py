"""Parquet, the tables of data frames, by pyarrow."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip.readers.files import first_line
from microslip.readers.tables import Column, Table, refuse_long


def table(path: Path) -> Table:
    """Columns of numbers, with the unit that a field's metadata may have."""
    parquet = _library()
    try:
        file = parquet.ParquetFile(path)
        fields, rows = file.schema_arrow, int(file.metadata.num_rows)
    except Exception as error:  # Arrow raises kinds of its own
        raise ValueError(f"not a usable Parquet file: {first_line(error)}") from None
    names = [field.name for field in fields if _is_number(field)]
    columns = tuple(Column(name, _unit(fields.field(name)), rows) for name in names)
    if not columns:
        raise ValueError("wanted columns of numbers, got none in this Parquet file")

    def load(places: Sequence[int]) -> list[Floats]:
        refuse_long(columns[place] for place in places)
        selection = [names[place] for place in places]
        try:
            read = parquet.read_table(path, columns=selection)
            return [np.array(read.column(name).to_numpy(), dtype=float) for name in selection]
        except Exception as error:
            raise ValueError(f"not a usable Parquet file: {first_line(error)}") from None

    return Table("Parquet file", columns, load)


def _library() -> Any:
    try:
        import pyarrow.parquet
    except ImportError:
        raise ValueError(
            "Parquet files are read by pyarrow, which is not installed: "
            'pip install "microslip[parquet]"'
        ) from None
    return pyarrow.parquet


def _is_number(field: Any) -> bool:
    try:
        return np.dtype(field.type.to_pandas_dtype()).kind in "iuf"
    except (NotImplementedError, TypeError):
        return False


def _unit(field: Any) -> str | None:
    metadata = field.metadata or {}
    unit = next((metadata[key] for key in (b"unit", b"units") if key in metadata), b"")
    return unit.decode("utf-8", "replace").strip() or None
