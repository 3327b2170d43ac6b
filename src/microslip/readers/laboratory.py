"""Tables that other libraries read: LabVIEW's TDMS, Parquet, and the universal file format."""

from __future__ import annotations

import logging
import math
import warnings
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip.readers.files import Unusable, decoded
from microslip.readers.tables import Column, Table, refuse_long


def tdms_table(path: Path) -> Table:
    """Channels such as "Log/Force", with the unit and rate that LabVIEW keeps."""
    nptdms = library("nptdms", "TDMS", "npTDMS", "tdms")
    # What it thinks of a damaged file, it also raises.
    import_module("nptdms.log").log_manager.set_level(logging.CRITICAL)
    with decoded("TDMS file"), path.open("rb") as raw, nptdms.TdmsFile.open(raw) as file:
        channels = [
            (channel.group_name, channel.name, column)
            for group in file.groups()
            for channel in group.channels()
            if (column := _of_channel(channel)) is not None
        ]
    if not channels:
        raise ValueError("wanted channels of numbers, got none in this TDMS file")

    def load(places: Sequence[int]) -> list[Floats]:
        selection = [channels[place] for place in places]
        refuse_long(column for _, _, column in selection)
        with decoded("TDMS file"), path.open("rb") as raw, nptdms.TdmsFile.open(raw) as file:
            return [np.array(file[g][c][:], dtype=float) for g, c, _ in selection]

    return Table("TDMS file", tuple(column for _, _, column in channels), load)


def _of_channel(channel: Any) -> Column | None:
    if len(channel) < 2 or np.dtype(channel.dtype).kind not in "iuf":
        return None
    step = channel.properties.get("wf_increment")
    rate = None
    if isinstance(step, (int, float)) and 0.0 < step < math.inf:
        rate = 1.0 / float(step)
    unit = str(channel.properties.get("unit_string", "")).strip() or None
    return Column(f"{channel.group_name}/{channel.name}", unit, len(channel), rate, channel.name)


def parquet_table(path: Path) -> Table:
    """Columns of numbers of a data frame, with the unit that a field's metadata may have."""
    parquet = library("pyarrow.parquet", "Parquet", "pyarrow", "parquet")
    with decoded("Parquet file"):
        file = parquet.ParquetFile(path)
        fields, rows = file.schema_arrow, int(file.metadata.num_rows)
    names = [field.name for field in fields if _is_number(field)]
    columns = tuple(Column(name, _unit(fields.field(name)), rows) for name in names)
    if not columns:
        raise ValueError("wanted columns of numbers, got none in this Parquet file")

    def load(places: Sequence[int]) -> list[Floats]:
        refuse_long(columns[place] for place in places)
        selection = [names[place] for place in places]
        with decoded("Parquet file"):
            table = parquet.read_table(path, columns=selection)
            return [np.array(table.column(name).to_numpy(), dtype=float) for name in selection]

    return Table("Parquet file", columns, load)


def _is_number(field: Any) -> bool:
    try:
        return np.dtype(field.type.to_pandas_dtype()).kind in "iuf"
    except (NotImplementedError, TypeError):
        return False


def _unit(field: Any) -> str | None:
    metadata = field.metadata or {}
    unit = next((metadata[key] for key in (b"unit", b"units") if key in metadata), b"")
    return unit.decode("utf-8", "replace").strip() or None


def uff_table(path: Path) -> Table:
    """Functions of time (data sets 58), with their names, units and sample rate."""
    pyuff = library("pyuff", "UFF", "pyuff", "uff")
    with decoded("UFF file"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        file = pyuff.UFF(str(path))
        places = [i for i, kind in enumerate(file.get_set_types()) if int(kind) == 58]
        sets = [file.read_sets(i) for i in places]
    real = [part for part in sets if np.isrealobj(part["data"]) and np.size(part["data"]) > 1]
    if not real:
        raise ValueError("wanted functions of time (data sets 58), got none in this UFF file")

    def load(selection: Sequence[int]) -> list[Floats]:
        return [np.array(real[place]["data"], dtype=float) for place in selection]

    return Table("UFF file", tuple(map(_of_set, real)), load)


def _of_set(part: dict[str, Any]) -> Column:
    step = float(part.get("abscissa_inc") or 0.0)
    rate = 1.0 / step if 0.0 < step < math.inf and part.get("abscissa_spacing", 1) == 1 else None
    names = (part.get("ordinate_axis_lab"), part.get("id1"), part.get("rsp_ent_name"))
    labels = (str(name).strip() for name in names if name)
    heading = next((name for name in labels if name and name.upper() != "NONE"), "")
    unit = str(part.get("ordinate_axis_units_lab") or "").strip()
    return Column(heading, None if unit.upper() in ("", "NONE") else unit, None, rate)


def library(module: str, kind: str, name: str, extra: str) -> Any:
    """The module that reads a kind of file, or an error that says how to install it."""
    try:
        return import_module(module)
    except ImportError:
        raise Unusable(
            f"{kind} files are read by {name}, which is not installed: "
            f'pip install "microslip[{extra}]"'
        ) from None
