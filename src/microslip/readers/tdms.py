"""TDMS, the files of LabVIEW and DIAdem, by npTDMS."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip.readers.files import first_line
from microslip.readers.tables import Column, Table, refuse_long


def table(path: Path) -> Table:
    """Channels such as "Log/Force", with the unit and rate that LabVIEW keeps."""
    nptdms = _library()
    try:
        with path.open("rb") as raw, nptdms.TdmsFile.open(raw) as file:
            channels = [
                (channel.group_name, channel.name, column)
                for group in file.groups()
                for channel in group.channels()
                if (column := _column(channel)) is not None
            ]
    except MemoryError:
        raise
    except Exception as error:  # npTDMS raises many kinds on what is damaged
        raise ValueError(f"not a usable TDMS file: {first_line(error)}") from None
    if not channels:
        raise ValueError("wanted channels of numbers, got none in this TDMS file")

    def load(places: Sequence[int]) -> list[Floats]:
        selection = [channels[place] for place in places]
        refuse_long(column for _, _, column in selection)
        try:
            with path.open("rb") as raw, nptdms.TdmsFile.open(raw) as file:
                return [np.array(file[g][c][:], dtype=float) for g, c, _ in selection]
        except MemoryError:
            raise
        except Exception as error:
            raise ValueError(f"not a usable TDMS file: {first_line(error)}") from None

    return Table("TDMS file", tuple(column for _, _, column in channels), load)


def _library() -> Any:
    try:
        import nptdms
    except ImportError:
        raise ValueError(
            'TDMS files are read by npTDMS, which is not installed: pip install "microslip[tdms]"'
        ) from None
    return nptdms


def _column(channel: Any) -> Column | None:
    if len(channel) < 2 or np.dtype(channel.dtype).kind not in "iuf":
        return None
    step = channel.properties.get("wf_increment")
    rate = None
    if isinstance(step, (int, float)) and 0.0 < step < math.inf:
        rate = 1.0 / float(step)
    unit = str(channel.properties.get("unit_string", "")).strip() or None
    return Column(f"{channel.group_name}/{channel.name}", unit, len(channel), rate, channel.name)
