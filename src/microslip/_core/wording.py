"""Formatting of values and names in error messages."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from datetime import date, time
from difflib import get_close_matches
from typing import Final

ESCAPED: Final = "backslashreplace"
"""Error handler for text that UTF-8 cannot encode, such as bytes in a file name."""


def one_line(text: str) -> str:
    """Replace characters that are not printable by escapes, so that the text is on one line."""
    # Control characters must not reach the terminal.
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def shorten(text: str, length: int) -> str:
    """Return printable text on one line, cut to ``length`` characters."""
    text = one_line(text)
    return text if len(text) <= length else text[: length - 1] + "…"


def quote(value: object) -> str:
    """Format a value received in a file or command as it was written, short, on one line."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return f'"{shorten(value, 60)}"'
    if isinstance(value, (list, tuple)):
        return f"a list of {len(value)}" if value else "an empty list"
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, (int, float)):
        try:
            return shorten(repr(value), 40)
        except ValueError:
            return "an integer of thousands of digits"
    if isinstance(value, (date, time)):
        return f"the date or time {value}"
    return shorten(repr(value), 60)


def quoted(words: Iterable[str], join: str = "or") -> str:
    """Join words as a choice, such as '"a", "b" or "c"'."""
    texts = [f'"{shorten(word, 40)}"' for word in words]
    return texts[0] if len(texts) == 1 else f"{', '.join(texts[:-1])} {join} {texts[-1]}"


def nearest(word: str, words: Iterable[str], cutoff: float = 0.6) -> str | None:
    """Return the word of ``words`` most similar to ``word``, or None."""
    folded = {candidate.casefold(): candidate for candidate in words}
    plain = word.casefold().replace(" ", "_")
    match = get_close_matches(plain, folded, n=1, cutoff=cutoff)
    if not match and len(plain) >= 3:
        # Compare with beginnings too, such as "greenwod" with "greenwood-williamson".
        starts = {name[: len(plain)]: name for name in folded}
        match = [starts[start] for start in get_close_matches(plain, starts, n=1, cutoff=0.7)]
    # Do not suggest a single letter for a longer word.
    if not match or len(match[0]) < min(len(plain), 2):
        return None
    return folded[match[0]]


def did_you_mean(word: str, words: Iterable[str], cutoff: float = 0.6) -> str:
    """Return '; did you mean "..."?' with the nearest word, or "", to end a message."""
    match = nearest(word, words, cutoff)
    return f'; did you mean "{match}"?' if match else ""


def plural(count: int, noun: str) -> str:
    """Format a count with its noun, such as "1 cycle" or "3 cycles"."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def joined(texts: Sequence[str]) -> str:
    """Join texts, such as "a, b and c"."""
    return " and ".join(filter(None, (", ".join(texts[:-1]), texts[-1])))


def capital(text: str) -> str:
    """Return text with its first letter in upper case."""
    return f"{text[:1].upper()}{text[1:]}"
