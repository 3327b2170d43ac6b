"""Detection of file kinds, error messages for files, and the limit on file size.

A few bytes of an untrusted file can declare more data than fits in memory. Readers therefore check
the declared size against one limit (:func:`limited`) before they allocate memory.
"""

from __future__ import annotations

import math
import numbers
import os
import stat
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from microslip._core.errors import InputError
from microslip._core.files import reason
from microslip._core.options import option
from microslip._core.wording import did_you_mean, quote, shorten

_HEAD = 1024
POINTS = 50_000_000
"""Default limit of the numbers in a file: 0.4 GB, of which a few copies are made."""
LIMIT = option(
    "limit",
    "Largest number of points in a file; a file that declares more is rejected before reading.",
    int,
    default=POINTS,
    least=1,
)
_limit: ContextVar[int] = ContextVar("limit", default=POINTS)


def head_of(path: Path) -> bytes:
    """Read the first bytes of a file, which identify its kind."""
    with path.open("rb") as file:
        return file.read(_HEAD)


def file_kind(head: bytes, suffix: str) -> str | None:
    """Return the kind of a file from its first bytes, or from its suffix if they are ambiguous."""
    if head.startswith(b"TDSm"):
        return "tdms"
    if head.startswith(b"MATLAB ") or (suffix == ".mat" and b"\0" in head[:128]):
        return "mat"  # version 4 has no magic number
    if any(head.startswith(b"\x89HDF\r\n\x1a\n", start) for start in (0, 512)):
        return "hdf5"
    if head.startswith(b"\x93NUMPY"):
        return "npy"
    if head.startswith(b"PK") and suffix == ".npz":  # other archives begin in the same way
        return "npz"
    if head.startswith(b"PK\x03\x04") and suffix in (".xlsx", ".xlsm"):
        return "excel"
    if suffix in (".json", ".uff", ".unv"):
        return None
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "text"
    return None if b"\0" in head or head.startswith(b"PK\x03\x04") else "text"


@contextmanager
def usable(path: Path, noun: str) -> Iterator[None]:
    """Return a context in which errors of the operating system become a ValueError.

    Callers add the file name. ``noun`` states what the path should be, such as "a file".
    """
    if "\0" in os.fspath(path):
        raise ValueError("cannot be read: a file name cannot contain a null character")
    try:
        refuse_special(path, noun)
        yield
    except FileNotFoundError:
        raise ValueError(f"no such file{_near(path)}") from None
    except OSError as error:
        if os.path.isdir(path):  # noqa: PTH112 - Windows says "permission denied"; never raises
            raise ValueError(f"wanted {noun}, got a folder") from None
        raise ValueError(f"cannot be read: {reason(error)}") from None


def refuse_special(path: Path, noun: str = "a file") -> None:
    """Raise a ValueError unless the path is a regular file or a folder.

    Reading a named pipe that no process writes to would never end.
    """
    mode = path.stat().st_mode
    kinds = {"a named pipe": stat.S_ISFIFO, "a socket": stat.S_ISSOCK, "a device": stat.S_ISCHR}
    for kind, is_kind in kinds.items():
        if is_kind(mode):
            raise ValueError(f"wanted {noun}, got {kind}; save its content to a file")


@contextmanager
def reading(path: Path, noun: str, limit: object = POINTS, called: str = "") -> Iterator[None]:
    """Return a context for reading a file of at most ``limit`` numbers.

    Errors in the context become an InputError that names the file, or ``called`` if given.
    """
    name = called or shorten(path.name or str(path), 200)
    try:
        with usable(path, noun), limited(limit):
            yield
    except MemoryError:
        raise InputError(f"{name}: too large for the memory of this machine") from None
    except InputError as error:
        raise error.within(f"{name}: ") from None
    except ValueError as error:
        raise InputError(f"{name}: {error}") from None


def _near(path: Path) -> str:
    try:
        names = [entry.name for entry in path.parent.iterdir() if entry.is_file()]
    except (OSError, ValueError):
        return ""
    ended = [name for name in names if Path(name).stem == path.name]
    if len(ended) == 1:  # only the suffix is missing
        return f'; did you mean "{shorten(ended[0], 200)}"?'
    alike = [name for name in names if Path(name).suffix == path.suffix]
    return did_you_mean(shorten(path.name, 200), alike, cutoff=0.75)


_OF_THE_SYSTEM = (FileNotFoundError, IsADirectoryError, PermissionError)


@contextmanager
def decoded(kind: str, quiet: bool = True) -> Iterator[None]:
    """Return a context in which any error of a parsing library becomes an InputError.

    The message names the ``kind`` of file. ``quiet`` suppresses warnings of the library.
    """
    try:
        with warnings.catch_warnings():  # libraries warn about damaged content
            if quiet:
                warnings.simplefilter("ignore")
            yield
    except (MemoryError, InputError, *_OF_THE_SYSTEM):
        raise
    except Exception as error:
        raise InputError(f"not a usable {kind}: {first_line(error)}") from None


def first_line(error: BaseException, path: Path | None = None) -> str:
    """Return the first line of an error message, with the path reduced to the file name."""
    text = str(error) if path is None else str(error).replace(str(path), path.name)
    lines = text.strip().splitlines()
    return shorten(lines[0], 160) if lines else type(error).__name__


@contextmanager
def limited(points: object) -> Iterator[None]:
    """Return a context in which each file read may have at most ``points`` numbers."""
    if not isinstance(points, numbers.Integral) or isinstance(points, bool) or points < 1:
        raise InputError(f"`limit` must be a number of points above zero, got {quote(points)}")
    token = _limit.set(int(points))
    try:
        yield
    finally:
        _limit.reset(token)


def allowed_points() -> int:
    """Return the largest number of points that a file may contain in this context."""
    return _limit.get()


def refuse_beyond(*shape: int) -> None:
    """Raise an InputError if an array of this shape has more numbers than the limit."""
    if (count := math.prod(shape)) > _limit.get():
        size = f"{' x '.join(map(str, shape))} = " if len(shape) > 1 else ""
        raise InputError(
            f"contains {size}{count} points, more than `limit={_limit.get()}`; raise the limit if "
            f"memory suffices ({count * 8e-9:.3g} GB and a few times that)"
        )
