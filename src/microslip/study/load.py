"""Floor 8: from a file to a study, or to one line that says what is wrong with the file."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from microslip._core.wording import shorten
from microslip.errors import StudyError
from microslip.study.explain import explain
from microslip.study.overrides import MAX_DEPTH, Override, apply, is_too_deep
from microslip.study.part import Reading
from microslip.study.schema import Study
from microslip.study.textfile import read_text

MAX_BYTES = 64_000_000


def read(path: Path, overrides: Sequence[str] = ()) -> Study:
    """Read a study file.

    Parameters
    ----------
    path : pathlib.Path
        The file.
    overrides : sequence of str
        What takes the place of keys of the file, as in :meth:`Study.load`.

    Returns
    -------
    Study
        The validated study.

    Raises
    ------
    StudyError
        If the file cannot be read or is not a study.
    """
    name = shorten(str(path), 200)
    try:
        text = read_text(path, "a study", MAX_BYTES)
    except ValueError as error:
        raise StudyError(f"{name}: {error}") from None
    return parse(text, name, overrides, path.parent)


def parse(
    text: str, name: str = "study", overrides: Sequence[str] = (), folder: Path | None = None
) -> Study:
    """Validate the text of a study.

    Parameters
    ----------
    text : str
        TOML.
    name : str
        What stands for the file in messages.
    overrides : sequence of str
        What takes the place of keys of the text, as in :meth:`Study.load`.
    folder : pathlib.Path, optional
        Folder of the files that the study names.

    Returns
    -------
    Study
        The validated study.

    Raises
    ------
    StudyError
        If the text is not TOML or not a study.
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
        raise StudyError(f"{name}: wanted a study, got none; microslip new NAME.toml writes one")
    changes: list[Override] = []
    if overrides:
        try:
            text, data, changes = apply(overrides, text, data)
        except StudyError as error:
            raise StudyError(f"{name}: {error}") from None
    study = Study.__new__(Study)
    fill(study, data, name, folder, changes)
    study._text = text
    return study


def fill(
    study: Study,
    given: dict[str, Any],
    name: str = "study",
    folder: Path | None = None,
    changes: Sequence[Override] = (),
) -> None:
    """Validate what a study was given into that study.

    Parameters
    ----------
    study : Study
        A new one, still empty.
    given : dict
        Keys and values as in a file.
    name : str
        What stands for the file in messages.
    folder : pathlib.Path, optional
        Folder of the files that the study names.
    changes : sequence of Override
        What took the place of keys, for messages and notes.

    Raises
    ------
    StudyError
        If it is not a study.
    """
    reading = Reading(folder)
    try:
        Study.__pydantic_validator__.validate_python(given, self_instance=study, context=reading)
    except ValidationError as error:
        raise StudyError(f"{name}: {explain(error, given, changes)}") from None
    study._name = name
    study._given = given
    study._folder = folder or Path()
    study._notes = (*(change.note for change in changes), *reading.notes)


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
    what = message[: where.start()] if where else message
    lines = text.split("\n")
    if where and where[1]:
        line, column = int(where[1]), int(where[2])
        before, after = lines[line - 1][: column - 1], lines[line - 1][column - 1 :].lstrip()
        for end, begin, reason in _REASONS:
            if re.search(end, before[-80:]) and re.match(begin, after):
                what = reason
    else:
        lines = text.rstrip("\n").split("\n")
        line, column = len(lines), len(lines[-1]) + 1
    what = _CLEARER.get(what, what)
    # tomllib shows the path of a table as a Python tuple.
    what = re.sub(r"\('([^()]*)',?\)", lambda m: "[" + m[1].replace("', '", ".") + "]", what)
    what = shorten(what[:1].lower() + what[1:], 120)
    return f"line {line}, column {column}: not TOML: {what}"
