"""Atomic writing of files, and error messages of the operating system."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from microslip._core.errors import InputError


def reason(error: Exception) -> str:
    """Return the message of the operating system in lower case, to be written after a colon."""
    return (getattr(error, "strerror", None) or str(error) or type(error).__name__).lower()


@contextmanager
def atomic_file(path: str | Path, overwrite: bool) -> Iterator[Path]:
    """Yield a temporary path, which replaces ``path`` if the block succeeds and is deleted if not.

    Raises InputError if ``path`` exists and ``overwrite`` is False, or if it cannot be written.
    """
    target = Path(path)
    try:
        if target.is_dir():
            raise InputError(f"{str(target)[:200]}: is a folder")
        if target.exists() and not overwrite:
            raise _exists(target)
        handle, name = tempfile.mkstemp(prefix=f".{target.name[:100]}.", dir=target.parent)
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{str(target)[:200]}: cannot be written: {reason(error)}") from None
    os.close(handle)
    stage = Path(name)
    try:
        stage.unlink()  # the writer creates it with the permissions of a new file
        yield stage
        if overwrite:
            stage.replace(target)
            return
        try:
            os.link(stage, target)
        except FileExistsError:
            raise _exists(target) from None
        except OSError:  # a file system without links
            if target.exists():
                raise _exists(target) from None
            stage.rename(target)
    except OSError as error:
        raise InputError(f"{str(target)[:200]}: cannot be written: {reason(error)}") from error
    finally:
        stage.unlink(missing_ok=True)


def _exists(target: Path) -> InputError:
    return InputError(f"{str(target)[:200]}: exists; replace it with `overwrite=True`")


def relative_path(folder: Path, path: Path) -> str:
    """Return the path of a file relative to a folder, with "/"; absolute on another drive."""
    # Resolve links of folders, since ".." leads up from their targets, but not the file itself.
    here = Path(os.path.realpath(path.parent)) / path.name
    try:
        return Path(os.path.relpath(here, os.path.realpath(folder))).as_posix()
    except ValueError:  # on another drive
        return os.fspath(here)
