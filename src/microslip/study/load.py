"""Floor 8: from a file to a study, or to one line that says what is wrong with the file."""

from __future__ import annotations

import os
import re
import tomllib
from pathlib import Path

from pydantic import ValidationError

from microslip.errors import StudyError
from microslip.study.explain import explain
from microslip.study.schema import Study
from microslip.study.wording import did_you_mean, shorten

MAX_BYTES = 64_000_000


def read(path: Path) -> Study:
    """Read a study file.

    Parameters
    ----------
    path : pathlib.Path
        The file.

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
        with path.open("rb") as file:
            content = file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise StudyError(f"{name}: no such file{_near_file(path)}") from None
    except IsADirectoryError:
        raise StudyError(f"{name}: wanted a study file, got a folder") from None
    except (OSError, ValueError) as error:
        if os.path.isdir(path):  # noqa: PTH112 - Windows says "permission denied"; never raises
            raise StudyError(f"{name}: wanted a study file, got a folder") from None
        reason = getattr(error, "strerror", None) or str(error)
        raise StudyError(f"{name}: cannot be read: {reason.lower()}") from None
    if len(content) > MAX_BYTES:
        raise StudyError(f"{name}: wanted a study of at most {MAX_BYTES // 1_000_000} MB")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise StudyError(
            f"{name}: line {line}: not UTF-8 text (byte 0x{content[error.start]:02x}); "
            "save the file as UTF-8"
        ) from None
    return parse(text, name)


def parse(text: str, name: str = "study") -> Study:
    """Validate the text of a study.

    Parameters
    ----------
    text : str
        TOML.
    name : str
        What stands for the file in messages.

    Returns
    -------
    Study
        The validated study.

    Raises
    ------
    StudyError
        If the text is not TOML or not a study.
    """
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise StudyError(f"{name}: {_toml_message(str(error), text)}") from None
    except RecursionError:
        raise StudyError(f"{name}: not TOML that can be read: nested too deeply") from None
    except ValueError:  # the only one of tomllib's that says nothing of the place
        raise StudyError(f"{name}: not a study: an integer of thousands of digits") from None
    try:
        study = Study.model_validate(data)
    except ValidationError as error:
        raise StudyError(f"{name}: {explain(error, data)}") from None
    study._name = name
    study._text = text
    return study


# What tomllib says where an engineer would not see what to do.
_CLEARER = {
    "Invalid value": "invalid value (text and quantities stand in quotes)",
    "Cannot overwrite a value": "this key is given twice",
}


def _toml_message(message: str, text: str) -> str:
    where = re.search(r"\s*\(at (?:line (\d+), column (\d+)|end of document)\)$", message)
    what = message[: where.start()] if where else message
    what = _CLEARER.get(what, what)
    # tomllib shows the path of a table as a Python tuple.
    what = re.sub(r"\(('[^()]*'),?\)", lambda m: f"[{m[1].replace(chr(39), '')}]", what)
    what = shorten(what[:1].lower() + what[1:], 120)
    if where and where[1]:
        return f"line {where[1]}, column {where[2]}: not TOML: {what}"
    lines = text.rstrip("\n").split("\n")
    return f"line {len(lines)}, column {len(lines[-1]) + 1}: not TOML: {what}"


def _near_file(path: Path) -> str:
    try:
        names = [entry.name for entry in path.parent.iterdir() if entry.suffix == ".toml"]
    except OSError:
        return ""
    return did_you_mean(path.name, names)
