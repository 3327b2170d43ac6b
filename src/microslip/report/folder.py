"""A result folder appears whole or not at all, and replaces nothing but a result.

While a result is written it is in a hidden folder beside its place, ``.NAME.xxxxxxxx.tmp``, which
then changes places with an older result in one step. A killed process leaves the hidden folder
behind, complete or not; the next run that writes to the same place removes it.

Where the system has no such step there are two renames, and for a moment the older result is
``.NAME.xxxxxxxx.old`` and nothing is in its place. Whoever finds that so, and nobody at work there,
brings it back.
"""

from __future__ import annotations

import errno
import json
import os
import re
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

from microslip._core.files import reason
from microslip._core.wording import shorten
from microslip.errors import StudyError

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


# Files left by file managers.
_LITTER = frozenset({".DS_Store", "Thumbs.db", "desktop.ini"})
_TOKEN = "[a-z0-9_]{8}"  # what tempfile puts into names
_LONGEST = 200  # bytes of a name that hidden names hold as it is
_PATIENCE = 1.0  # seconds in which two renames are done, where nobody can be asked


class _Place(NamedTuple):
    """Destination of a result, and the files that may be replaced there."""

    target: Path
    name: str
    kind: str
    noun: str
    overwrite: bool


@contextmanager
def staged(
    folder: Path, overwrite: bool = False, kind: str = "microslip-result", noun: str = "result"
) -> Iterator[Path]:
    """Give a temporary folder that takes the place of `folder` when all has gone well."""
    name = shorten(str(folder), 200)
    target = Path(os.path.abspath(folder))  # noqa: PTH100 - resolve() would follow the links
    place = _Place(target, name, kind, noun, overwrite)
    ancestor = next((p for p in target.parents if os.path.lexists(p)), target)
    _tidy(place, ancestor)
    _check(place)
    try:
        with _stage(target, ancestor) as stage:
            yield stage
            # Checked again: during a long computation somebody may have put something there.
            _check(place)
            _finish(stage, kind)
            _swap_in(stage, place, ancestor)
    except OSError as error:
        raise StudyError(f"{name}: cannot be written: {reason(error)}") from error


@contextmanager
def _stage(target: Path, ancestor: Path) -> Iterator[Path]:
    """A hidden folder, held as long as somebody works in it; what it then is goes away."""
    for _ in range(100):
        stage = Path(tempfile.mkdtemp(prefix=_prefix(target), suffix=".tmp", dir=ancestor))
        with locked(stage) as mine:
            if mine is False:  # another run takes it for a leftover, not being held yet
                with suppress(OSError):
                    stage.rmdir()
                continue
            born = stage.stat()
            try:
                # a folder may hand its group down, which only shows in the mode.
                stage.chmod((born.st_mode & 0o7000) | (0o777 & ~_umask()))
                yield stage
            finally:
                # By the name of the stage there may now be the older result: see _swap_in.
                with suppress(OSError):
                    if os.path.samestat(born, stage.lstat()):
                        shutil.rmtree(stage, ignore_errors=True)
            return
    raise OSError("its temporary folders are deleted by another program")


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _prefix(target: Path) -> str:
    """Prefix of hidden names of a place; long ones by their hash, since names have a limit."""
    name = os.fsencode(target.name)
    if len(name) > _LONGEST:
        return f".{sha256(name).hexdigest()[:32]}."
    return f".{target.name}."


def _finish(stage: Path, kind: str) -> None:
    """Have everything there and on the disk before it counts: power fails, errors come late.

    Files may be gone: what cleans temporary folders may have come by in a long run.
    """
    gone = sorted((_files(stage, kind) or set()) - {entry.name for entry in stage.iterdir()})
    if gone:
        raise FileNotFoundError(errno.ENOENT, f"{gone[0]} has vanished while others were written")
    for entry in stage.iterdir():
        if entry.is_file():
            with entry.open("r+b") as file:
                os.fsync(file.fileno())
    _flush(stage)


def _flush(folder: Path) -> None:
    """Have the names in a folder on the disk."""
    if os.name == "posix":
        with suppress(OSError):  # some file systems have no such thing
            handle = os.open(folder, os.O_RDONLY)
            try:
                os.fsync(handle)
            finally:
                os.close(handle)


def _swap_in(stage: Path, place: _Place, ancestor: Path) -> None:
    """Move the finished folder to its place, and the older one out of it."""
    target = place.target
    new_folders: list[Path] = []
    try:
        for parent in reversed(target.parents):
            if ancestor in parent.parents and not parent.exists():
                parent.mkdir()
                new_folders.append(parent)
        if not os.path.lexists(target):
            try:
                move(stage, target)
                _flush(target.parent)
                return
            except FileExistsError:  # somebody was faster
                _check(place)
        _replace(stage, place)
        _flush(target.parent)
    except BaseException:
        for parent in reversed(new_folders):
            with suppress(OSError):
                parent.rmdir()
        raise


def _replace(stage: Path, place: _Place) -> None:
    """Let the new result take the place of an older one, which then goes by the stage's name."""
    target = place.target
    with locked(target):  # so that no other run takes the older one for a leftover
        if swap(stage, target):
            try:
                _check_contents(stage, place)
            except BaseException:
                swap(stage, target)
                raise
        else:
            old = stage.with_suffix(".old")
            try:
                target.rename(old)
                _check_contents(old, place)
                stage.rename(target)
            except BaseException:
                if os.path.lexists(old) and not os.path.lexists(target):
                    old.rename(target)
                raise
            old.rename(stage)
        _discard(stage, place.kind)


# -- what killed runs leave -----------------------------------------------------------------------


def _tidy(place: _Place, ancestor: Path) -> None:
    """Bring an older result back, and remove hidden folders, where their run was killed."""
    hidden = re.compile(rf"{re.escape(_prefix(place.target))}{_TOKEN}\.(tmp|old)")
    with suppress(OSError):
        leftovers = sorted(entry for entry in ancestor.iterdir() if hidden.fullmatch(entry.name))
        for old in leftovers:
            if old.suffix == ".old" and ancestor == place.target.parent:
                _bring_back(old, place.target)
        for stage in leftovers:
            if stage.suffix == ".tmp":
                with locked(stage) as mine:
                    if mine:
                        _discard(stage, place.kind)


def _bring_back(old: Path, target: Path) -> None:
    """Undo the first of two renames whose second one was never done."""
    stage = old.with_suffix(".tmp")

    def between() -> bool:
        return old.is_dir() and stage.is_dir() and not os.path.lexists(target)

    # Without the stage the second rename had been done, and the old result is complete.
    if not between():
        return
    with locked(stage) as mine:
        if mine is None:
            time.sleep(_PATIENCE)
        if mine is not False and between():
            with suppress(OSError):
                move(old, target)


def _discard(folder: Path, kind: str) -> None:
    """Remove a result or the beginning of one, unless anything else is in it."""
    with suppress(OSError):
        names = {entry.name for entry in folder.iterdir()}
        result_files = _files(folder, kind) or set()
        if names <= result_files | _LITTER | {"summary.json"} and not _other_entries(folder):
            # The summary says what the others are, so it goes last.
            for name in sorted(names, key=lambda name: name == "summary.json"):
                (folder / name).unlink()
            folder.rmdir()


# -- what may be replaced -------------------------------------------------------------------------


def _check(place: _Place) -> None:
    """Refuse a place that is taken, unless by a result that may be replaced."""
    target, name = place.target, place.name
    if os.path.islink(target):  # noqa: PTH114 - never raises
        raise StudyError(f"{name}: is a link; name the folder itself, or another one with -o")
    try:
        target.stat()
    except FileNotFoundError:
        return
    except (OSError, ValueError) as error:
        raise StudyError(f"{name}: cannot be written: {reason(error)}") from None
    if not target.is_dir():
        raise StudyError(f"{name}: is a file; name a folder with -o")
    if not place.overwrite:
        raise StudyError(f"{name}: exists; replace it with --overwrite or name another with -o")
    here = Path.cwd()
    if target == here or target in here.parents or target in (Path.home(), *Path.home().parents):
        raise StudyError(f"{name}: not replaced: it holds the current or the home folder")
    _check_contents(target, place)


def _check_contents(folder: Path, place: _Place) -> None:
    """Refuse a folder that holds anything else than a result."""
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
            f"{name}: not replaced: it is no {place.noun} of microslip (no summary.json of one)"
        )
    foreign = [*sorted(entries - result_files - _LITTER), *odd]
    if foreign:
        raise StudyError(
            f'{name}: not replaced: "{shorten(foreign[0], 60)}" in it is not of the '
            f"{place.noun}; move it elsewhere first"
        )


def _other_entries(folder: Path) -> list[str]:
    """Entries that are no plain files: a folder or a link is the user's own, whatever its name."""
    return sorted(e.name for e in folder.iterdir() if e.is_symlink() or not e.is_file())


def _files(folder: Path, kind: str) -> set[str] | None:
    """Names of the files of a result, or None if the folder is none."""
    try:
        summary: Any = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
        if summary["kind"] != kind:
            return None
        return {str(name) for name in summary["files"]}
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None
