"""Floor 8: a result folder appears whole or not at all, and replaces nothing but a result."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from microslip.errors import StudyError
from microslip.study.summary import KIND
from microslip.study.wording import shorten

# Left behind by file managers, and nobody's work.
_LITTER = frozenset({".DS_Store", "Thumbs.db", "desktop.ini"})


@contextmanager
def staged(folder: Path, overwrite: bool = False) -> Iterator[Path]:
    """Give a temporary folder that takes the place of `folder` when all has gone well.

    Parameters
    ----------
    folder : pathlib.Path
        The result folder to be. Parents that are missing are made.
    overwrite : bool
        Whether a result that is there may be replaced.

    Yields
    ------
    pathlib.Path
        An empty folder beside the one to be; it is removed whenever something fails.

    Raises
    ------
    StudyError
        Before anything is computed, if the folder exists and may not be replaced, or if nothing
        can be written there; afterwards, if writing fails.
    """
    name = shorten(str(folder), 200)
    target = Path(os.path.abspath(folder))  # noqa: PTH100 - resolve() would follow the links
    _check(target, name, overwrite)
    stage = None
    try:
        ancestor = next(parent for parent in target.parents if os.path.lexists(parent))
        stage = Path(tempfile.mkdtemp(prefix=f".{target.name[:100]}.", suffix=".tmp", dir=ancestor))
        stage.chmod(0o777 & ~_umask())
    except (OSError, ValueError) as error:
        if stage is not None:
            shutil.rmtree(stage, ignore_errors=True)
        raise StudyError(f"{name}: cannot be written: {_reason(error)}") from None
    try:
        yield stage
        # Looked at again: a long computation leaves others the time to put something there.
        _check(target, name, overwrite)
        _put(stage, target, ancestor)
    except OSError as error:
        raise StudyError(f"{name}: cannot be written: {_reason(error)}") from error
    finally:
        shutil.rmtree(stage, ignore_errors=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _reason(error: Exception) -> str:
    return (getattr(error, "strerror", None) or str(error) or type(error).__name__).lower()


def _put(stage: Path, target: Path, ancestor: Path) -> None:
    """Move the finished folder to its place, and the old one out of it."""
    made: list[Path] = []
    try:
        for parent in reversed(target.parents):
            if ancestor in parent.parents and not parent.exists():
                parent.mkdir()
                made.append(parent)
        if not target.exists():
            stage.rename(target)
            return
        # Two renames: should the process be killed between them, the old result is still there
        # under the hidden name.
        old = stage.with_suffix(".old")
        target.rename(old)
        try:
            stage.rename(target)
        except BaseException:
            old.rename(target)
            raise
        shutil.rmtree(old, ignore_errors=True)
    except BaseException:
        for parent in reversed(made):
            with suppress(OSError):
                parent.rmdir()
        raise


def _check(target: Path, name: str, overwrite: bool) -> None:
    """Refuse a place that is taken, unless by a result that may be replaced."""
    if os.path.islink(target):  # noqa: PTH114 - never raises
        raise StudyError(f"{name}: is a link; name the folder itself, or another one with -o")
    try:
        target.stat()
    except FileNotFoundError:
        return
    except (OSError, ValueError) as error:
        raise StudyError(f"{name}: cannot be written: {_reason(error)}") from None
    if not target.is_dir():
        raise StudyError(f"{name}: is a file; name a folder with -o")
    if not overwrite:
        raise StudyError(f"{name}: exists; replace it with --overwrite or name another with -o")
    here = Path.cwd()
    if target == here or target in here.parents or target in (Path.home(), *Path.home().parents):
        raise StudyError(f"{name}: not replaced: it holds the current or the home folder")
    try:
        found = {entry.name for entry in target.iterdir()}
    except OSError as error:
        raise StudyError(f"{name}: not replaced: {_reason(error)}") from None
    if not found:
        return
    known = _files(target)
    if known is None:
        raise StudyError(
            f"{name}: not replaced: it is no result of microslip (no summary.json of one)"
        )
    foreign = sorted(found - known - _LITTER)
    if foreign:
        raise StudyError(
            f'{name}: not replaced: "{shorten(foreign[0], 60)}" in it is not of the result; '
            "move it elsewhere first"
        )
    # A result holds plain files; a folder or a link by one of their names is somebody's own.
    for entry in target.iterdir():
        if entry.is_symlink() or not entry.is_file():
            raise StudyError(
                f'{name}: not replaced: "{shorten(entry.name, 60)}" in it is not of the result; '
                "move it elsewhere first"
            )


def _files(folder: Path) -> set[str] | None:
    """Names of the files of a result, or None if the folder is none."""
    try:
        summary: Any = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
        if summary["kind"] != KIND:
            return None
        return {str(name) for name in summary["files"]}
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None
