"""Arrays in NumPy files, read without unpickling."""

from __future__ import annotations

import math
import sys
import zipfile
from functools import partial
from pathlib import Path
from typing import IO, Any

import numpy as np

from microslip.readers.arrays import Arrays, Leaf
from microslip.readers.files import decoded, refuse_beyond


def read_npy(path: Path) -> Arrays:
    """Return the array of an .npy file; its numbers are loaded on demand."""
    with path.open("rb") as file:
        shape, kind = _header(file)
        available = path.stat().st_size - file.tell()
    tree = _leaves("array", shape, kind, available, path)
    if not tree:
        raise ValueError(f"wanted real numbers, got an array of {kind}")
    return Arrays("NumPy's npy file", tree, ".")


def read_npz(path: Path) -> Arrays:
    """Return the arrays of an .npz archive by name; their numbers are loaded on demand."""
    tree: dict[str, Any] = {}
    for entry in _entries(path):
        tree |= _leaves(*entry, path)
    return Arrays("npz file", tree, ".")


def archived(path: Path) -> dict[str, np.ndarray]:
    """Load all arrays of an .npz archive, without unpickling."""
    refuse_beyond(sum(_size(shape, kind) for _, shape, kind, _ in _entries(path)) // 8)
    with decoded("npz file"), path.open("rb") as file, np.load(file, allow_pickle=False) as content:
        return {name: _text_checked(np.asarray(content[name])) for name in content.files}


def _text_checked(array: np.ndarray) -> np.ndarray:
    # Code points beyond Unicode crash Python when a string is made of them.
    if array.dtype.kind == "U" and array.size:
        codes = np.dtype("u4").newbyteorder(array.dtype.byteorder)
        if np.frombuffer(array.tobytes(), codes).max(initial=0) > sys.maxunicode:
            raise ValueError("contains text with code points outside Unicode")
    return array


def _entries(path: Path) -> list[tuple[str, tuple[int, ...], np.dtype[Any], int]]:
    entries = []
    with decoded("npz file"), zipfile.ZipFile(path) as archive:
        for entry in archive.infolist():
            if entry.filename.endswith(".npy"):
                with archive.open(entry) as file:
                    shape, kind = _header(file)
                    entries.append(
                        (entry.filename[:-4], shape, kind, entry.file_size - file.tell())
                    )
    return entries


def _size(shape: tuple[int, ...], kind: np.dtype[Any]) -> int:
    return math.prod(shape) * kind.itemsize


def _leaves(
    name: str, shape: tuple[int, ...], kind: np.dtype[Any], available: int, path: Path
) -> dict[str, Any]:
    """Return leaves by name: one for an array of numbers, or one per field of a structured array.

    A leaf is a shape with a function that loads the numbers.
    """
    size = _size(shape, kind)
    get = partial(_load, path, name, shape, size, available)
    if kind.kind in "iuf":
        return {name: Leaf(shape, get)}
    fields = [field for field in kind.names or () if kind[field].kind in "iuf"]
    return {field: Leaf(shape, partial(_field, get, field)) for field in fields}


def _header(file: IO[bytes]) -> tuple[tuple[int, ...], np.dtype[Any]]:
    with decoded("npy file"):  # a damaged header raises many kinds of errors
        version = 1 if np.lib.format.read_magic(file) == (1, 0) else 2
        shape, _, kind = getattr(np.lib.format, f"read_array_header_{version}_0")(file)
    if any(count < 0 for count in shape):
        size = " x ".join(map(str, shape))
        raise ValueError(f"not a usable npy file: its header declares {size} numbers")
    return tuple(shape), kind


def _load(path: Path, name: str, shape: tuple[int, ...], size: int, available: int) -> Any:
    refuse_beyond(size // 8)
    if size > available:
        raise ValueError(
            f"truncated: its {' x '.join(map(str, shape))} numbers take {size} bytes, "
            f"and the file has {max(available, 0)}"
        )
    with decoded("NumPy file"):
        content = np.load(path, allow_pickle=False)
        if isinstance(content, np.ndarray):
            return content
        with content as archive:
            return np.asarray(archive[name])


def _field(get: Any, field: str) -> Any:
    return get()[field]
