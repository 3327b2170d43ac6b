"""Verdicts as data: a rule is a name, a quantity, limits, words, a reason and a remedy."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, NamedTuple, Self, get_args

Word = Literal["ok", "not judged", "watch", "outside"]
WORDS: tuple[str, ...] = get_args(Word)
"""From the best to the worst; what is not judged is not fine."""


class Verdict(NamedTuple):
    """One assumption held to its limit.

    Of interfaces those of Greenwood and Williamson (DOI 10.1098/rspa.1966.0242).
    """

    name: str
    """Name of the judged quantity."""
    value: float | None
    """Its value [-]; None where it is not known."""
    limit: float
    """Limit of ``ok``; that of ``outside`` is further out."""
    word: Word
    """``ok``, ``watch`` (the result depends on it), ``outside``, or ``not judged``."""
    meaning: str
    """The assumption, in a sentence."""
    reason: str = ""
    """Source of the limits or, if not judged, the missing input."""
    remedy: str = ""
    """Remedy."""


class Remark(str):
    """A note that is to be read with a result: a text that knows its kind and the words after it.

    So whoever shows notes picks them by their kind and need not read the text.
    """

    def __new__(cls, kind: str, words: str) -> Self:
        """Make ``"kind: words"``."""
        self = super().__new__(cls, f"{kind}: {words}")
        self.kind, self.words = kind, words
        return self

    kind: str
    """Kind of the remark, such as "suspect"."""
    words: str
    """The remark in a sentence."""

    def __getnewargs__(self) -> tuple[str, str]:  # type: ignore[override]
        return self.kind, self.words


@dataclass(frozen=True)
class Rule:
    """Rule by which a quantity is judged."""

    name: str  # what is judged
    # Where ``ok`` ends and where ``outside`` begins; falling limits (``outside`` below
    # ``watch``) judge what must not be too small.
    watch: float
    outside: float
    meaning: str  # the assumption in a sentence
    reason: str = ""  # evidence for the limits, with its source
    remedy: str = ""  # what to do where it does not hold
    missing: str = ""  # what has to be given before it can be judged

    def judge(self, value: float | None) -> Verdict:
        """Hold a value to the limits; None or not a number is not judged."""
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
    """The worst word of all; only where all was judged and holds it is ``ok``."""
    return max((verdict.word for verdict in verdicts), key=WORDS.index, default="not judged")
