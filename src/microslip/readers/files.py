"""Kind of a file, its errors, and the limit of its size.

A stranger's file may declare more than any memory holds in a few bytes. So its readers compare what
it declares with one limit (:func:`limited`) before they ask for memory.
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
"""Numbers that a file may hold unless more are allowed: 0.4 GB, of which a few copies are made."""
LIMIT = option(
    "limit",
    "Numbers that a file may hold; one that declares more is refused before it is read.",
    int,
    default=POINTS,
    least=1,
)
_limit: ContextVar[int] = ContextVar("limit", default=POINTS)

# What else is brought, and what to do with it.
_STRANGERS = (
    (b"PK\x03\x04", "an Excel workbook or another archive"),
    (b"\xd0\xcf\x11\xe0", "an old Excel workbook or another Office file"),
)


def head_of(path: Path) -> bytes:
    """The first bytes of a file, by which its kind is told."""
    with path.open("rb") as file:
        return file.read(_HEAD)


def kind_of(head: bytes, suffix: str) -> str | None:
    """Kind of a file by its first bytes, and by its ending only where they say nothing."""
    if head.startswith(b"TDSm"):
        return "tdms"
    if head.startswith(b"MATLAB ") or (suffix == ".mat" and b"\0" in head[:128]):
        return "mat"  # version 4 has no header of its own
    if any(head.startswith(b"\x89HDF\r\n\x1a\n", start) for start in (0, 512)):
        return "hdf5"
    if head.startswith(b"\x93NUMPY"):
        return "npy"
    if head.startswith(b"PK") and suffix == ".npz":  # other archives begin in the same way
        return "npz"
    if head.startswith(b"PK\x03\x04") and suffix in (".xlsx", ".xlsm"):
        return "excel"
    if head.startswith(b"PAR1"):
        return "parquet"
    if suffix == ".json":
        return "json"
    if suffix in (".uff", ".unv"):
        return "uff"
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "text"
    return None if b"\0" in head or head.startswith(b"PK\x03\x04") else "text"


def foreign_kind(head: bytes) -> str:
    """Probable kind of a file of no known format."""
    return next(
        (name for magic, name in _STRANGERS if head.startswith(magic)), "another binary file"
    )


@contextmanager
def usable(path: Path, noun: str) -> Iterator[None]:
    """Turn what the system says of a file into a ValueError that does not name the file."""
    if "\0" in os.fspath(path):
        raise ValueError("cannot be read: no file has such a name")
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
    """Refuse what is no regular file, such as a named pipe without a writer, which never ends.

    Raises
    ------
    ValueError
        If the path is neither a regular file nor a folder.
    OSError
        If the path does not exist or cannot be read.
    """
    mode = path.stat().st_mode
    kinds = {"a named pipe": stat.S_ISFIFO, "a socket": stat.S_ISSOCK, "a device": stat.S_ISCHR}
    for kind, is_kind in kinds.items():
        if is_kind(mode):
            raise ValueError(f"wanted {noun}, got {kind}; save its content to a file")


@contextmanager
def reading(path: Path, noun: str, limit: object = POINTS, called: str = "") -> Iterator[None]:
    """Read a file of at most so many numbers; what is wrong is an InputError that names it."""
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
    """The file that is probably meant."""
    try:
        names = [entry.name for entry in path.parent.iterdir() if entry.is_file()]
    except (OSError, ValueError):
        return ""
    ended = [name for name in names if Path(name).stem == path.name]
    if len(ended) == 1:  # only the end of the name was left out
        return f'; did you mean "{shorten(ended[0], 200)}"?'
    alike = [name for name in names if Path(name).suffix == path.suffix]
    return did_you_mean(shorten(path.name, 200), alike, cutoff=0.75)


_OF_THE_SYSTEM = (FileNotFoundError, IsADirectoryError, PermissionError)


class Unusable(ValueError):
    """A file that is damaged, or none of the kind that it seems to be."""


@contextmanager
def decoded(kind: str, quiet: bool = True) -> Iterator[None]:
    """Say that a file is none of its kind, whatever its library raises on what is damaged."""
    try:
        with warnings.catch_warnings():  # what a library thinks of damaged content follows here
            if quiet:
                warnings.simplefilter("ignore")
            yield
    except (MemoryError, InputError, Unusable, *_OF_THE_SYSTEM):
        raise
    except Exception as error:
        raise Unusable(f"not a usable {kind}: {first_line(error)}") from None


def first_line(error: BaseException, path: Path | None = None) -> str:
    """Message of a library on one line; a path is cut to the name of its file."""
    text = str(error) if path is None else str(error).replace(str(path), path.name)
    lines = text.strip().splitlines()
    return shorten(lines[0], 160) if lines else type(error).__name__


@contextmanager
def limited(points: object) -> Iterator[None]:
    """Read files of at most so many numbers."""
    if not isinstance(points, numbers.Integral) or isinstance(points, bool) or points < 1:
        raise InputError(f"`limit` must be a number of points above zero, got {quote(points)}")
    token = _limit.set(int(points))
    try:
        yield
    finally:
        _limit.reset(token)


def allowed_points() -> int:
    """Numbers that a file may hold."""
    return _limit.get()


def refuse_beyond(*shape: int) -> None:
    """Refuse more points than are allowed, before they are read."""
    if (count := math.prod(shape)) > _limit.get():
        size = f"{' x '.join(map(str, shape))} = " if len(shape) > 1 else ""
        raise InputError(
            f"holds {size}{count} points, more than `limit={_limit.get()}`; give a higher limit if "
            f"there is memory for it ({count * 8e-9:.3g} GB and a few times that)"
        )
