"""NumPy's files: one array, or several in an archive. Sizes are checked before they are read."""

from __future__ import annotations

import math
import zipfile
from pathlib import Path
from typing import IO, Any

import numpy as np

from microslip.scans.readers.base import Raw, Reader, Wishes, few, first_line, one_of

_BROKEN = (zipfile.BadZipFile, EOFError, OSError, ValueError, NotImplementedError, RuntimeError)


class Npy(Reader):
    """One array."""

    names = ("npy",)

    def knows(self, head: bytes, suffix: str) -> bool:
        """By its first bytes."""
        return head.startswith(b"\x93NUMPY")

    def read(self, path: Path, wishes: Wishes) -> Raw:
        """The array."""
        with path.open("rb") as file:
            shape, kind = _header(file)
            here = file.tell()
        _check(shape, kind, path.stat().st_size - here, wishes.limit)
        return Raw("NumPy's npy file", _load(path, "the array"))


class Npz(Reader):
    """Arrays with names."""

    names = ("npz",)
    takes = ("key",)

    def knows(self, head: bytes, suffix: str) -> bool:
        """By its ending: other archives begin in the same way."""
        return head.startswith(b"PK") and suffix == ".npz"

    def read(self, path: Path, wishes: Wishes) -> Raw:
        """The array that is meant."""
        headers: dict[str, tuple[tuple[int, ...], np.dtype[Any], int]] = {}
        try:
            with zipfile.ZipFile(path) as archive:
                for entry in archive.infolist():
                    if entry.filename.endswith(".npy"):
                        with archive.open(entry) as file:
                            shape, kind = _header(file)
                            rest = entry.file_size - file.tell()
                        headers[entry.filename[:-4]] = shape, kind, rest
        except _BROKEN as error:
            raise ValueError(f"not a usable npz file: {first_line(error)}") from None
        shapes = {name: h[0] for name, h in headers.items() if h[1].kind in "iuf"}
        name = one_of(shapes, wishes, "this npz file")
        _check(*headers[name], wishes.limit)
        return Raw(f'NumPy\'s npz file, array "{name}"', _load(path, name))


def _header(file: IO[bytes]) -> tuple[tuple[int, ...], np.dtype[Any]]:
    """Shape and type of an array, from its first bytes."""
    try:
        version = np.lib.format.read_magic(file)
        read = (
            np.lib.format.read_array_header_1_0
            if version == (1, 0)
            else np.lib.format.read_array_header_2_0
        )
        shape, _, kind = read(file)
    except Exception as error:  # a header is Python text, which breaks in many ways
        raise ValueError(f"not a usable npy file: {first_line(error)}") from None
    if any(count < 0 for count in shape):
        size = " x ".join(map(str, shape))
        raise ValueError(f"not a usable npy file: it says that it holds {size} numbers")
    return tuple(shape), kind


def _check(shape: tuple[int, ...], kind: np.dtype[Any], rest: int, limit: int) -> None:
    if kind.kind not in "iuf":
        raise ValueError(f"wanted real numbers, got an array of {kind}")
    few(shape, limit)
    if (needed := math.prod(shape) * kind.itemsize) > rest:
        raise ValueError(
            f"truncated: its {' x '.join(map(str, shape))} numbers take {needed} bytes, "
            f"{max(rest, 0)} are there"
        )


def _load(path: Path, name: str) -> np.ndarray:
    try:
        found = np.load(path, allow_pickle=False)
        if isinstance(found, np.ndarray):
            return found
        with found as archive:
            return np.asarray(archive[name])
    except MemoryError:
        raise
    except Exception as error:  # zlib.error among them
        raise ValueError(f"cannot be read: {first_line(error)}") from None
