"""A study, read from a file or told in one line what is wrong with it."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Self

from microslip._core.files import reason
from microslip._core.wording import did_you_mean, shorten
from microslip.errors import StudyError
from microslip.normal import NormalLaw
from microslip.study.joints import Joint
from microslip.study.overrides import MAX_DEPTH, Override, apply, dump, is_too_deep, relocated_text
from microslip.study.part import one_line
from microslip.study.readers import FAILED, Place, Reading
from microslip.study.schema import StudyTables
from microslip.study.sense import check, mean_load

MAX_BYTES = 64_000_000


class StudyDescription(StudyTables):
    """What :class:`microslip.Study` is, before anything is computed."""

    _name: str = "study"
    _text: str | None = None
    _tables: dict[str, Any]
    _notes: tuple[str, ...] = ()
    _folder: Path = Path()
    _law: NormalLaw | None = None  # drawn, in place of the surface's own

    def __init__(self, /, **tables: Any) -> None:
        self._fill(tables)

    def _fill(
        self,
        tables: dict[str, Any],
        name: str = "study",
        folder: Path | None = None,
        changes: Sequence[Override] = (),
    ) -> None:
        """Validate keys and values as in a file into this study, which is still empty."""
        reading = Reading(folder)
        place = Place("", reading)
        read = place.attempt(lambda: self.read(tables, place))
        if read is FAILED:
            blamed = _blamed(reading.errors[0][0], changes)
            raise StudyError(f"{name}: {one_line(reading.errors, blamed)}")
        self.__dict__.update(read.__dict__)
        self._name = name
        self._tables = tables
        self._folder = folder or Path()
        self._notes = (*(change.note for change in changes), *reading.notes)

    def check(self, place: Place) -> None:
        """Refuse what only shows in the whole."""
        if isinstance(self.joint, Joint) and not self.joint.normal_load:
            self.__dict__["joint"] = self.joint.copy(normal_load=(mean_load(self),))
        check(self)

    @property
    def asks_for_joint(self) -> bool:
        """Whether cycles of the joint by itself are wanted, too, and not of a structure alone."""
        joint = self._tables.get("joint", {})
        of_joint = ("excitation", "oscillator")
        return (
            self.structure is None
            or "normal_load" in joint
            or any(name in self._tables for name in of_joint)
        )

    @property
    def name(self) -> str:
        """Name of the file, or what stands for it in messages."""
        return self._name

    @property
    def text(self) -> str:
        """TOML text of the study: as it was read, overrides applied; comments are kept."""
        if self._text is None:
            self._text = dump(self._tables)
        return self._text

    def text_for(self, folder: str | Path) -> str:
        """The study as TOML for a file in another folder, from which it finds the same files.

        Parameters
        ----------
        folder : str or pathlib.Path
            Where it will stand.

        Returns
        -------
        str
            Its :attr:`text`, with the names of files that it uses seen from there.
        """
        return relocated_text(self.text, self._folder, Path(folder))

    @property
    def notes(self) -> tuple[str, ...]:
        """What was taken from elsewhere: table values and their sources, files, overrides."""
        return self._notes

    @classmethod
    def load(cls, path: str | Path, overrides: Sequence[str] = ()) -> Self:
        """Read a study file (TOML).

        Parameters
        ----------
        path : str or pathlib.Path
            The file. Files that it names are relative to its folder.
        overrides : sequence of str
            Keys and their values in place of those in the file, such as
            ``'joint.normal_load="3 kN"'``. The value is TOML; what is not TOML is text.

        Returns
        -------
        Study
            The validated study, in SI units.
        """
        path = Path(path)
        name = shorten(str(path), 200)
        try:
            text = _text_of(path)
        except ValueError as error:
            raise StudyError(f"{name}: {error}") from None
        return cls.from_toml(text, name, overrides, path.parent)

    @classmethod
    def from_toml(
        cls,
        text: str,
        name: str = "study",
        overrides: Sequence[str] = (),
        folder: str | Path | None = None,
    ) -> Self:
        """Read a study from TOML text.

        Parameters
        ----------
        text : str
            What would be in the file.
        name : str
            What stands for the file in messages.
        overrides : sequence of str
            As in :meth:`load`.
        folder : str or pathlib.Path, optional
            Folder of the files that the study names; by default the current one.

        Returns
        -------
        Study
            The validated study, in SI units.
        """
        if is_too_deep(text):
            raise StudyError(f"{name}: not a study: a key of more than {MAX_DEPTH} levels")
        try:
            data = tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            raise StudyError(f"{name}: {_toml_message(str(error), text)}") from None
        except RecursionError:
            raise StudyError(f"{name}: not TOML that can be read: nested too deeply") from None
        except ValueError:  # the only one of tomllib's that says nothing of the place
            raise StudyError(f"{name}: not a study: an integer of thousands of digits") from None
        if not data:
            raise StudyError(
                f"{name}: wanted a study, got none; microslip new NAME.toml writes one"
            )
        changes: list[Override] = []
        if overrides:
            try:
                text, data, changes = apply(overrides, text, data)
            except StudyError as error:
                raise StudyError(f"{name}: {error}") from None
        study = cls.__new__(cls)
        study._fill(data, name, None if folder is None else Path(folder), changes)
        study._text = text
        return study


def _blamed(key: str, changes: Sequence[Override]) -> str:
    """The override that gave a key its value, in brackets."""
    path = f"{key.split(', item')[0]}."
    for change in reversed(changes):
        if path.startswith(f"{change.blamed}.") or f"{change.blamed}.".startswith(path):
            return f' (override "{shorten(change.text, 80)}")'
    return ""


def _text_of(path: Path) -> str:
    """The UTF-8 text of a study, or one line that says why there is none."""
    try:
        with path.open("rb") as file:
            content = file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise ValueError(f"no such file{_near(path)}") from None
    except (OSError, ValueError) as error:
        if os.path.isdir(path):  # noqa: PTH112 - Windows says "permission denied"; never raises
            raise ValueError("wanted a study file, got a folder") from None
        raise ValueError(f"cannot be read: {reason(error)}") from None
    if len(content) > MAX_BYTES:
        raise ValueError(f"wanted a study of at most {MAX_BYTES // 1_000_000} MB")
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise ValueError("not UTF-8 text (it is UTF-16); save the file as UTF-8")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise ValueError(
            f"line {line}: not UTF-8 text (byte 0x{content[error.start]:02x}); "
            "save the file as UTF-8"
        ) from None


def _near(path: Path) -> str:
    try:
        entries = list(path.parent.iterdir())
    except (OSError, ValueError):
        return ""
    ended = [entry.name for entry in entries if entry.stem == path.name]
    if len(ended) == 1:  # only the end of the name was left out
        return f'; did you mean "{shorten(ended[0], 200)}"?'
    names = [entry.name for entry in entries if entry.suffix == path.suffix]
    return did_you_mean(shorten(path.name, 200), names, cutoff=0.75)


# What tomllib says where an engineer would not see what to do.
_CLEARER = {
    "Invalid value": "invalid value (text and quantities stand in quotes)",
    "Cannot overwrite a value": "this key is given twice",
    "Illegal character '\\n'": "a text without its closing quote",
    "Unterminated string": "a text without its closing quote",
}

# What stands where it says so, and after what, when the reason is one of these.
_REASONS = (
    (r"\d$", r",\d", 'the decimal sign is the point, "."'),
    (r"\d\s*$", r"[^\W\d_]|[/%°]", 'quantities stand in quotes, such as "2 kN"'),
    (r"[=\[,]\s*$", r"[+-]?\.\d", "write a 0 before the point"),
    (r"[=\[,]\s*$", "[“”„«»‘’´`]", 'quotes are straight, as in "2 kN"'),
)


def _toml_message(message: str, text: str) -> str:
    where = re.search(r"\s*\(at (?:line (\d+), column (\d+)|end of document)\)$", message)
    fault = message[: where.start()] if where else message
    lines = text.split("\n")
    if where and where[1]:
        line, column = int(where[1]), int(where[2])
        before, after = lines[line - 1][: column - 1], lines[line - 1][column - 1 :].lstrip()
        for end, begin, explanation in _REASONS:
            if re.search(end, before[-80:]) and re.match(begin, after):
                fault = explanation
    else:
        lines = text.rstrip("\n").split("\n")
        line, column = len(lines), len(lines[-1]) + 1
    fault = _CLEARER.get(fault, fault)
    # tomllib shows the path of a table as a Python tuple.
    fault = re.sub(r"\('([^()]*)',?\)", lambda m: "[" + m[1].replace("', '", ".") + "]", fault)
    fault = shorten(fault[:1].lower() + fault[1:], 120)
    return f"line {line}, column {column}: not TOML: {fault}"
