"""Tables of columns in files of any supported format."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from microslip._core.wording import quote, quoted
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


def read_table(path: Path, noun: str, file_format: object = None) -> RawTable:
    """Read the table in a file, in the given format or the one detected from its content.

    Parameters
    ----------
    path : Path
        File to read.
    noun : str
        Expected content, for messages, such as ``"a record"``.
    file_format : str, optional
        Key of :data:`READERS`.

    Raises
    ------
    ValueError
        If the format is unknown or not recognised, or the file is empty.
    """
    head = head_of(path)
    if file_format is not None:
        if not isinstance(file_format, str) or file_format not in READERS:
            raise ValueError(f"wanted format {quoted(sorted(READERS))}, got {quote(file_format)}")
        return READERS[file_format](path)
    if not head:
        raise ValueError(f"wanted {noun}, got an empty file")
    kind = file_kind(head, path.suffix.lower())
    if kind is None:
        raise ValueError(
            "wanted text, Excel, MAT, TDMS, HDF5 or NumPy files, got "
            f"{foreign_kind(head)}; save {noun} as CSV"
        )
    return READERS[kind](path)
