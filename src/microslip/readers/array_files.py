"""Arrays in NumPy files, read without unpickling."""

from __future__ import annotations

import sys
import zipfile
from functools import partial
from pathlib import Path

import numpy as np

from microslip.readers.arrays import Arrays, Leaf
from microslip.readers.files import decoded, refuse_beyond

_HEADER = 128  # bytes before the numbers of an array


def read_npy(path: Path) -> Arrays:
    """Return the array of an .npy file, mapped into memory."""
    with decoded("npy file of real numbers"):
        array = np.lib.format.open_memmap(path, mode="r")
    tree = _leaves("array", array)
    if not tree:
        raise ValueError(f"wanted real numbers, got an array of {array.dtype}")
    return Arrays("NumPy's npy file", tree, ".")


def read_npz(path: Path) -> Arrays:
    """Return the arrays of an .npz archive by name."""
    tree: dict[str, Leaf] = {}
    for name, array in archived(path).items():
        tree |= _leaves(name, array)
    return Arrays("npz file", tree, ".")


def archived(path: Path) -> dict[str, np.ndarray]:
    """Load the arrays of an .npz archive; objects, which would have to be unpickled, are skipped.

    Raises InputError if the archive unpacks to more numbers than the limit.
    """
    arrays = {}
    with decoded("npz file"), path.open("rb") as file:
        with zipfile.ZipFile(file) as archive:
            sizes = [entry.file_size - _HEADER for entry in archive.infolist()]
        refuse_beyond(sum(sizes) // 8)
        with np.load(file, allow_pickle=False) as content:
            for name in content.files:
                try:
                    arrays[name] = _text_checked(np.asarray(content[name]))
                except ValueError as error:
                    if "allow_pickle" not in str(error):
                        raise
    return arrays


def _text_checked(array: np.ndarray) -> np.ndarray:
    # Code points beyond Unicode crash Python when a string is made of them.
    if array.dtype.kind == "U" and array.size:
        codes = np.dtype("u4").newbyteorder(array.dtype.byteorder)
        if np.frombuffer(array.tobytes(), codes).max(initial=0) > sys.maxunicode:
            raise ValueError("contains text with code points outside Unicode")
    return array


def _leaves(name: str, array: np.ndarray) -> dict[str, Leaf]:
    """Return leaves by name: an array of numbers, or the fields of a structured array."""
    fields = {field: array[field] for field in array.dtype.names or ()} or {name: array}
    return {
        field: Leaf(values.shape, partial(np.asarray, values))
        for field, values in fields.items()
        if values.dtype.kind in "iuf"
    }
