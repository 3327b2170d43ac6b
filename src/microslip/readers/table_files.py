"""Tables of columns in files of any supported format."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from microslip.readers import array_files, arrays, hdf5, laboratory, matlab, text
from microslip.readers.files import file_kind, foreign_kind, head_of
from microslip.readers.tables import RawTable

READERS: Mapping[str, Callable[[Path], RawTable]] = {
    "tdms": laboratory.tdms_table,
    "mat": lambda path: arrays.array_table(matlab.read_matlab(path)),
    "hdf5": lambda path: arrays.array_table(hdf5.read_hdf5(path)),
    "npy": lambda path: arrays.array_table(array_files.read_npy(path)),
    "npz": lambda path: arrays.array_table(array_files.read_npz(path)),
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
            "wanted text, Excel, MAT, TDMS, HDF5 or NumPy files, got "
            f"{foreign_kind(head)}; save {noun} as CSV"
        )
    return READERS[kind](path)
