"""Tables of columns in files of any supported format."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from microslip._core.wording import quote
from microslip.readers import array_files, hdf5, laboratory, matlab, text
from microslip.readers.arrays import Arrays, array_table
from microslip.readers.files import file_kind, head_of
from microslip.readers.tables import RawTable

ARRAY_FILES: Mapping[str, Callable[[Path], Arrays]] = {
    "npy": array_files.read_npy,
    "npz": array_files.read_npz,
    "mat": matlab.read_matlab,
    "hdf5": hdf5.read_hdf5,
}
"""Readers of named arrays by file format."""
TABLES: Mapping[str, Callable[[Path], RawTable]] = {
    "tdms": laboratory.tdms_table,
    "excel": laboratory.excel_table,
    "text": text.text_table,
}
"""Readers of columns by file format."""


def read_table(path: Path, noun: str) -> RawTable:
    """Read the table in a file, in the format detected from its content.

    Parameters
    ----------
    path : Path
        File to read.
    noun : str
        Expected content, for messages, such as ``"a record"``.

    Raises
    ------
    ValueError
        If the format is not recognised, or the file is empty.
    """
    head = head_of(path)
    if not head:
        raise ValueError(f"wanted {noun}, got an empty file")
    kind = file_kind(head, path.suffix.lower())
    if kind is None:
        raise ValueError(
            "wanted text, .xlsx, MAT, TDMS, HDF5 or NumPy files, got another format with the "
            f"suffix {quote(path.suffix)}; save {noun} as CSV"
        )
    return array_table(ARRAY_FILES[kind](path)) if kind in ARRAY_FILES else TABLES[kind](path)
