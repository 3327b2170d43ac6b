"""Verdicts on assumptions: rules with limits, and the results of applying them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, NamedTuple, Self, get_args

Word = Literal["ok", "not judged", "watch", "outside"]
WORDS: tuple[str, ...] = get_args(Word)
"""Words from best to worst; "not judged" is worse than "ok"."""


class Verdict(NamedTuple):
    """Result of comparing a quantity with the limits of an assumption.

    For interfaces the assumptions are those of Greenwood and Williamson (DOI
    10.1098/rspa.1966.0242).
    """

    name: str
    """Name of the judged quantity."""
    value: float | None
    """Value of the quantity [-]; None if unknown."""
    limit: float
    """Limit of ``ok``; the limit of ``outside`` is further away."""
    word: Word
    """``ok``, ``watch`` (the result depends on it), ``outside``, or ``not judged``."""
    meaning: str
    """Assumption, as a sentence."""
    reason: str = ""
    """Source of the limits or, if not judged, the missing input."""
    remedy: str = ""
    """Remedy."""


class Remark(str):
    """Note to a result: text with a kind, by which notes are selected."""

    def __new__(cls, kind: str, words: str) -> Self:
        """Create the text ``"kind: words"``."""
        self = super().__new__(cls, f"{kind}: {words}")
        self.kind, self.words = kind, words
        return self

    kind: str
    """Kind of the remark, such as "suspect"."""
    words: str
    """Remark as a sentence."""

    def __getnewargs__(self) -> tuple[str, str]:  # type: ignore[override]
        return self.kind, self.words


@dataclass(frozen=True)
class Rule:
    """Limits of a quantity within which an assumption holds."""

    name: str  # judged quantity
    # Limits of ``ok`` and of ``outside``; for ``outside`` below ``watch`` small values are worse.
    watch: float
    outside: float
    meaning: str  # assumption, as a sentence
    reason: str = ""  # evidence for the limits, with its source
    remedy: str = ""  # action if the assumption fails
    missing: str = ""  # input needed to judge the quantity

    def judge(self, value: float | None) -> Verdict:
        """Compare a value with the limits; None and NaN are not judged."""
        if value is None or math.isnan(value):
            return Verdict(
                self.name, None, self.watch, "not judged", self.meaning, self.missing, self.remedy
            )
        falling = self.outside < self.watch
        fine = value >= self.watch if falling else value <= self.watch
        bearable = value >= self.outside if falling else value <= self.outside
        word: Word = "ok" if fine else "watch" if bearable else "outside"
        return Verdict(self.name, value, self.watch, word, self.meaning, self.reason, self.remedy)


def worst(verdicts: Iterable[Verdict]) -> Word:
    """Return the worst word (outside, watch, not judged, ok) of verdicts; "not judged" if none."""
    return max((verdict.word for verdict in verdicts), key=WORDS.index, default="not judged")
