"""Result folders: written completely or not at all; only earlier results are replaced.

A result is written to a hidden folder next to its destination. Then an older result is renamed to
``NAME.old``, the new one to ``NAME``, and the older one is deleted. If the program is killed
between these steps, ``NAME.old`` and a hidden folder ``.microslip-xxxxxxxx.tmp`` may remain; both
can be deleted.
"""

from __future__ import annotations

import json
import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple

from microslip._core.errors import StudyError
from microslip._core.files import reason
from microslip._core.wording import shorten

# Files created by file managers.
_LITTER = frozenset({".DS_Store", "Thumbs.db", "desktop.ini"})


class _Place(NamedTuple):
    """Destination of a result, and the files in it that may be replaced."""

    target: Path
    name: str
    kind: str
    overwrite: bool

    @property
    def old(self) -> Path:
        return self.target.with_name(f"{self.target.name}.old")


@contextmanager
def staged(folder: Path, overwrite: bool = False, kind: str = "result") -> Iterator[Path]:
    """Context manager that yields a temporary folder, which replaces `folder` if no error occurs.

    Only an earlier result of the same ``kind`` is replaced.
    """
    name = shorten(str(folder), 200)
    target = Path(os.path.abspath(folder))  # noqa: PTH100 - resolve() would follow the links
    place = _Place(target, name, f"microslip-{kind}", overwrite)
    _check(place)
    ancestor = next((p for p in target.parents if os.path.lexists(p)), target)
    stage = ancestor / f".microslip-{secrets.token_hex(4)}.tmp"
    try:
        try:
            stage.mkdir()
            yield stage
            # Check again: the destination may have changed during a long computation.
            _check(place)
            _flush(stage)
            target.parent.mkdir(parents=True, exist_ok=True)
            _move_in(stage, place)
        finally:
            shutil.rmtree(stage, ignore_errors=True)
    except OSError as error:
        raise StudyError(f"{name}: cannot be written: {reason(error)}") from error


def _flush(stage: Path) -> None:
    """Write all files to disk, so that delayed write errors appear before the rename."""
    for entry in stage.iterdir():
        if entry.is_file():
            with entry.open("r+b") as file:
                os.fsync(file.fileno())


def _move_in(stage: Path, place: _Place) -> None:
    target, old = place.target, place.old
    if not target.exists():
        stage.rename(target)
        return
    target.rename(old)
    try:
        stage.rename(target)
    except BaseException:
        if not os.path.lexists(target):
            old.rename(target)
        raise
    _discard(old, place.kind)


def _discard(folder: Path, kind: str) -> None:
    """Remove the files of a result; the folder remains if it contains others."""
    with suppress(OSError):
        names = {entry.name for entry in folder.iterdir()}
        known = (_files(folder, kind) or set()) | _LITTER
        if names <= known and not _other_entries(folder):
            for name in names:
                (folder / name).unlink()
            folder.rmdir()


def _check(place: _Place) -> None:
    target, name = place.target, place.name
    if os.path.islink(target):  # noqa: PTH114 - never raises
        raise StudyError(f"{name}: is a link; give the folder itself, or another folder with -o")
    try:
        target.stat()
    except FileNotFoundError:
        return
    except (OSError, ValueError) as error:
        raise StudyError(f"{name}: cannot be written: {reason(error)}") from None
    if not target.is_dir():
        raise StudyError(f"{name}: is a file; give a folder with -o")
    if not place.overwrite:
        raise StudyError(
            f"{name}: exists; replace it with --overwrite, or give another folder with -o"
        )
    here = Path.cwd()
    if target == here or target in here.parents or target in (Path.home(), *Path.home().parents):
        raise StudyError(f"{name}: not replaced: it contains the current or the home folder")
    if os.path.lexists(place.old):
        raise StudyError(
            f"{name}: not replaced: {place.old.name} exists, probably an older result from a "
            "killed run; move or delete it first"
        )
    _check_contents(target, place)


def _check_contents(folder: Path, place: _Place) -> None:
    name = place.name
    try:
        entries = {entry.name for entry in folder.iterdir()}
        odd = _other_entries(folder)
    except OSError as error:
        raise StudyError(f"{name}: not replaced: {reason(error)}") from None
    if not entries:
        return
    result_files = _files(folder, place.kind)
    if result_files is None:
        raise StudyError(
            f"{name}: not replaced: it is not a result of this command (no such summary.json)"
        )
    foreign = [*sorted(entries - result_files - _LITTER), *odd]
    if foreign:
        raise StudyError(
            f'{name}: not replaced: "{shorten(foreign[0], 60)}" in it is not part of the result; '
            "move it elsewhere first"
        )


def _other_entries(folder: Path) -> list[str]:
    """Return the names of the folders and links in a folder; these belong to the user."""
    return sorted(e.name for e in folder.iterdir() if e.is_symlink() or not e.is_file())


def _files(folder: Path, kind: str) -> set[str] | None:
    try:
        summary: Any = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
        if summary["kind"] != kind:
            return None
        return {str(name) for name in summary["files"]}
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None
