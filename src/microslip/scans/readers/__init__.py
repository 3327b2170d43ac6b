"""Readers of scans: one kind of file a module. To add one, write its module and list it here."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from microslip.scans.readers.base import Raw, Reader, Wishes
from microslip.scans.readers.instruments import Instrument
from microslip.scans.readers.mat import Mat
from microslip.scans.readers.numpy_files import Npy, Npz
from microslip.scans.readers.text import Text

__all__ = ["READERS", "Raw", "Reader", "Wishes", "reader_of"]

READERS: tuple[Reader, ...] = (Npy(), Npz(), Mat(), Text(), Instrument())
"""Every reader, in the order in which they are asked whether a file is theirs."""

_TEXTS = {".txt", ".csv", ".tsv", ".dat", ".xyz", ".asc", ".prf", ".prn", ""}
_BINARY = {".npy", ".npz"}
_HEAD = 1024


def reader_of(path: Path, wanted: Any) -> Reader:
    """The reader for a file: the one of the format wanted, or by the file's beginning and ending.

    Parameters
    ----------
    path : pathlib.Path
        The file.
    wanted : str or None
        Name of a format; no other is tried then.

    Returns
    -------
    Reader
        One of `READERS`.

    Raises
    ------
    OSError
        If the file cannot be opened.
    ValueError
        If it is empty, or not what its ending says.
    """
    with path.open("rb") as file:
        head = file.read(_HEAD)
    if not head:
        raise ValueError("wanted a scan, got an empty file")
    if wanted is not None:
        return next((reader for reader in READERS if wanted in reader.names), READERS[-1])
    suffix = path.suffix.lower()
    for reader in READERS:
        # Some instruments write text of their own, which their endings tell.
        if isinstance(reader, Text) and suffix not in _TEXTS:
            continue
        if isinstance(reader, Instrument) and suffix in _BINARY:
            raise ValueError(
                f"its ending says {suffix}, its first bytes do not; if it is of another kind, "
                "write format="
            )
        if reader.knows(head, suffix):
            return reader
    raise AssertionError  # pragma: no cover - the last one knows all
