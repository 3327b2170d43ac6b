"""Atomic steps of the file system: swap two folders, take a free name, hold a folder.

Python has neither of the renames used here; they are called in the C library.
"""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path

# Flags of renameat2 of Linux and of renamex_np of macOS.
_NEW, _SWAP = {"linux": (1, 2), "darwin": (4, 2)}.get(sys.platform, (0, 0))
# What says that the file system or the kernel does not have such a rename, and nothing else.
_UNKNOWN = {errno.ENOSYS, errno.EINVAL, errno.ENOTSUP, errno.EOPNOTSUPP, errno.EPERM}


@lru_cache(maxsize=1)
def _rename() -> Callable[[bytes, bytes, int], int] | None:
    """Rename with flags, giving 0 or the number of the error; None where there is none."""
    if not _SWAP:
        return None
    import ctypes

    library = ctypes.CDLL(None, use_errno=True)
    function = getattr(library, "renameat2" if sys.platform == "linux" else "renamex_np", None)
    if function is None:
        return None
    linux, path = sys.platform == "linux", ctypes.c_char_p
    here = -100  # AT_FDCWD: paths are what they are everywhere else
    function.argtypes = [
        *((ctypes.c_int, path, ctypes.c_int, path) if linux else (path, path)),
        ctypes.c_uint,
    ]

    def rename(first: bytes, second: bytes, flags: int) -> int:
        names = (here, first, here, second) if linux else (first, second)
        return ctypes.get_errno() if function(*names, flags) else 0

    return rename


def _flagged(first: Path, second: Path, flag: int) -> bool:
    rename = _rename()
    if rename is None:
        return False
    number = rename(os.fsencode(first), os.fsencode(second), flag)
    if number and number not in _UNKNOWN:
        raise OSError(number, os.strerror(number), str(second))
    return not number


def swap(first: Path, second: Path) -> bool:
    """Let two folders change places in one step: at no moment is either name without one."""
    return _flagged(first, second, _SWAP)


def move(folder: Path, target: Path) -> None:
    """Rename a folder to a name that is free."""
    if _flagged(folder, target, _NEW):
        return
    # Elsewhere an empty folder in the way may be replaced, which loses nothing.
    try:
        folder.rename(target)
    except OSError as error:
        if os.path.lexists(target):
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(target)) from error
        raise


@contextmanager
def locked(folder: Path) -> Iterator[bool | None]:
    """Hold a folder, so that others know that its owner lives; a killed process holds nothing."""
    handle, mine = _hold(folder)
    try:
        yield mine
    finally:
        if handle is not None:
            os.close(handle)


def _hold(folder: Path) -> tuple[int | None, bool | None]:
    """Handle of the folder, which holds it until it is closed, and whether it does."""
    if os.name != "posix":
        return None, None
    import fcntl

    try:
        handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    except FileNotFoundError:
        return None, False
    except OSError:
        return None, None
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        # Meanwhile another may have removed it, or put a new one in its place.
        return handle, os.path.samestat(os.fstat(handle), folder.lstat())
    except (BlockingIOError, FileNotFoundError):
        return handle, False
    except OSError:
        return handle, None
