"""Readers of records: one kind of file a module. To add one, write its module and list it here."""

from __future__ import annotations

from pathlib import Path

from microslip.tribometer.readers.base import Column, Reader, Table
from microslip.tribometer.readers.hdf5 import Hdf5
from microslip.tribometer.readers.mat import Mat, Mat73
from microslip.tribometer.readers.tdms import Tdms
from microslip.tribometer.readers.text import Text

__all__ = ["READERS", "Column", "Reader", "Table", "reader_of"]

READERS: tuple[Reader, ...] = (Tdms(), Mat73(), Hdf5(), Mat(), Text())
"""Every reader, in the order in which they are asked whether a file is theirs."""

# What else is brought, and what to do with it.
_STRANGERS = (
    (b"PK\x03\x04", "an Excel workbook or another archive"),
    (b"\xd0\xcf\x11\xe0", "an old Excel workbook or another Office file"),
)
_HEAD = 1024


def reader_of(path: Path, wanted: str | None) -> Reader:
    """The reader for a file, by what the file begins with.

    Parameters
    ----------
    path : pathlib.Path
        The file.
    wanted : str or None
        Name of a reader, where the file's beginning is not to be asked.

    Returns
    -------
    Reader
        One of `READERS`.

    Raises
    ------
    OSError
        If the file cannot be opened.
    ValueError
        If no reader is called so, or none knows such a file.
    """
    from microslip._core.wording import quoted, show

    with path.open("rb") as file:
        head = file.read(_HEAD)
    if wanted is not None:
        names = sorted({reader.name for reader in READERS})
        if wanted not in names:
            raise ValueError(f"wanted format {quoted(names)}, got {show(wanted)}")
        fit = [reader for reader in READERS if reader.name == wanted]
        return next((reader for reader in fit if reader.knows(head, path.suffix)), fit[-1])
    if not head:
        raise ValueError("wanted a record, got an empty file")
    for reader in READERS:
        if reader.knows(head, path.suffix.lower()):
            return reader
    for magic, what in _STRANGERS:
        if head.startswith(magic):
            raise ValueError(f"wanted text, MAT, TDMS or HDF5, got {what}; save the record as CSV")
    raise ValueError(
        "wanted text, MAT, TDMS or HDF5, got another binary file; save the record as CSV"
    )
