"""Floor 8: the text of a file, or one line that says why there is none."""

from __future__ import annotations

import os
from pathlib import Path

from microslip._core.files import reason
from microslip._core.wording import did_you_mean, shorten


def read_text(path: Path, noun: str, limit: int, missing: str = "no such file") -> str:
    """Read a file of UTF-8 text."""
    try:
        with path.open("rb") as file:
            content = file.read(limit + 1)
    except FileNotFoundError:
        raise ValueError(f"{missing}{_near(path)}") from None
    except IsADirectoryError:
        raise ValueError(f"wanted {noun} file, got a folder") from None
    except (OSError, ValueError) as error:
        if os.path.isdir(path):  # noqa: PTH112 - Windows says "permission denied"; never raises
            raise ValueError(f"wanted {noun} file, got a folder") from None
        raise ValueError(f"cannot be read: {reason(error)}") from None
    if len(content) > limit:
        raise ValueError(f"wanted {noun} of at most {limit // 1_000_000} MB")
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
