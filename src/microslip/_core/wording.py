"""Wording of error messages: the value received and the name of the argument."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from datetime import date, time
from difflib import get_close_matches
from typing import Final

ESCAPED: Final = "backslashreplace"
"""Error handler for text that UTF-8 cannot encode, such as bytes in the name of a file."""


def one_line(text: str) -> str:
    """Text on one line, printable."""
    # Escaping keeps a message on one line and the terminal safe from control characters.
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def shorten(text: str, length: int) -> str:
    """Text on one line, printable, and cut to a length."""
    text = one_line(text)
    return text if len(text) <= length else text[: length - 1] + "…"


def quote(value: object) -> str:
    """A received value as the user would recognise it, short and on one line."""
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
    """Words as a choice, such as '"a", "b" or "c"'."""
    texts = [f'"{shorten(word, 40)}"' for word in words]
    return texts[0] if len(texts) == 1 else f"{', '.join(texts[:-1])} {join} {texts[-1]}"


def nearest(word: str, words: Iterable[str], cutoff: float = 0.6) -> str | None:
    """The one of `words` that `word` was probably meant to be, or None."""
    folded = {candidate.casefold(): candidate for candidate in words}
    plain = word.casefold().replace(" ", "_")
    match = get_close_matches(plain, folded, n=1, cutoff=cutoff)
    if not match and len(plain) >= 3:
        # Only the beginning was written, such as "greenwod" of "greenwood-williamson".
        starts = {name[: len(plain)]: name for name in folded}
        match = [starts[start] for start in get_close_matches(plain, starts, n=1, cutoff=0.7)]
    # One letter is no suggestion for two or more: it would be right by chance.
    if not match or len(match[0]) < min(len(plain), 2):
        return None
    return folded[match[0]]


def did_you_mean(word: str, words: Iterable[str], cutoff: float = 0.6) -> str:
    """A question to append to a message, or nothing."""
    match = nearest(word, words, cutoff)
    return f'; did you mean "{match}"?' if match else ""


def plural(count: int, noun: str) -> str:
    """A number of things, such as "1 cycle" or "3 cycles"."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def joined(texts: Sequence[str]) -> str:
    """Texts as one, such as "a, b and c"."""
    return " and ".join(filter(None, (", ".join(texts[:-1]), texts[-1])))


def capital(text: str) -> str:
    """A sentence that begins with a capital."""
    return f"{text[:1].upper()}{text[1:]}"
