"""Arrays in NumPy files, read without unpickling, and in JSON: columns, mappings or lists of rows.

A child process parses JSON, because a few characters can expand to large data.
"""

from __future__ import annotations

import json
import math
import sys
import zipfile
from collections.abc import Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import IO, Any

import numpy as np

from microslip.readers.arrays import Arrays, Leaf, arrays_in
from microslip.readers.child import parsed
from microslip.readers.files import Unusable, decoded, refuse_beyond


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


_MAX_BYTES = 1_000_000_000


def read_json(path: Path) -> Arrays:
    """Return all lists of numbers of a JSON file by name; null becomes NaN."""
    if (size := path.stat().st_size) > _MAX_BYTES:
        raise ValueError(
            f"wanted JSON of at most {_MAX_BYTES // 1_000_000} MB, got {size // 1_000_000} MB; "
            "save it as HDF5"
        )
    return Arrays("JSON file", arrays_in(parsed("JSON file", path, json_tree)), ".")


# ------------------------------------------------------------------ executed in the child process


def json_tree(path: Path) -> dict[str, Any]:
    """Parse a JSON file into nested mappings of numbers, texts and arrays."""
    content = path.read_bytes()
    refuse_beyond(content.count(b","))
    tree = json.loads(content.decode("utf-8-sig"))
    if isinstance(tree, list) and tree and all(isinstance(row, dict) for row in tree):
        names = dict.fromkeys(name for row in tree for name in row)
        refuse_beyond(len(names), len(tree))
        tree = {name: [row.get(name) for row in tree] for name in names}
    if not isinstance(tree, dict):
        raise Unusable("wanted JSON with named columns or a list of rows")
    return _arrays(tree)


def _arrays(tree: Mapping[str, Any]) -> dict[str, Any]:
    result: dict[str, Any] = {}
    for name, value in tree.items():
        if isinstance(value, dict):
            result[name] = _arrays(value)
        elif isinstance(value, list):
            with suppress(TypeError, ValueError, OverflowError):  # not numeric
                plain = [np.nan if item is None else item for item in value]
                result[name] = np.array(plain, dtype=float)
        else:
            result[name] = value
    return result
