"""Tables of text, as long as products have some of their own."""

from __future__ import annotations

from typing import NamedTuple


class Table(NamedTuple):
    """A table of text."""

    head: tuple[str, ...]
    rows: list[tuple[str, ...]]
    left_out: int = 0
    """How many more rows there would be."""


class Judgement(NamedTuple):
    """One assumption of the model, held to its limit at all loads."""

    word: str
    """The worst verdict, ``ok``, ``watch`` or ``outside``."""
    name: str
    """What is judged."""
    value: str
    """Its value, or the smallest and the largest."""
    bound: str
    """Where it would be ok."""
    where: str
    """The loads at which it is so, if these are not all; where the load varies, in any case."""
    meaning: str
    """What is assumed."""
