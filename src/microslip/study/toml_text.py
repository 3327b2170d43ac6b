"""The text of a study and its tables, or one line that says what is wrong with them."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from microslip._core.wording import shorten
from microslip.readers.files import usable
from microslip.study.overrides import MAX_DEPTH, is_too_deep

MAX_BYTES = 16_000_000


def text_of(path: Path) -> str:
    """The UTF-8 text of a study, or one line that says why there is none."""
    with usable(path, "a study file"), path.open("rb") as file:
        content = file.read(MAX_BYTES + 1)
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


def tables_of(text: str) -> dict[str, Any]:
    """The tables of a TOML text, or a ValueError that says what is wrong with it."""
    if is_too_deep(text):
        raise ValueError(f"not a study: a key of more than {MAX_DEPTH} levels")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ValueError(_toml_message(str(error), text)) from None
    except RecursionError:
        raise ValueError("not TOML that can be read: nested too deeply") from None
    except ValueError:  # the only one of tomllib's that says nothing of the place
        raise ValueError("not a study: an integer of thousands of digits") from None


# Messages of tomllib that an engineer would not understand.
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
