"""Faulty records: is the force limit in its interval, or the fault reported."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import microslip as ms

from .imperfections import IMPERFECTIONS, an_imperfect_set
from .physics import Set
from .wrong_physics import WRONG, a_wrong_set

PARTS = {
    "imperfect": (IMPERFECTIONS, an_imperfect_set),
    "wrong": (tuple(WRONG), a_wrong_set),
}
"""Kinds of sets of each part, and what makes one of a seed."""


@dataclass
class Tally:
    """Counts of sets of one kind."""

    sets: int = 0
    refused: int = 0
    held: int = 0
    """Sets whose force limit is inside its interval."""
    seen: int = 0
    """Sets whose loops are found not to obey Masing's rules, or with a note on their fault."""
    unseen: list[str] = field(default_factory=list)
    """Sets whose force limit is neither held nor in doubt."""

    def add(self, other: Tally) -> None:
        """Add the counts of other sets."""
        for name in ("sets", "refused", "held", "seen"):
            setattr(self, name, getattr(self, name) + getattr(other, name))
        self.unseen += other.unseen


def judged(made: Set, label: str) -> Tally:
    """Identify a set and compare its force limit at the highest load with the true one."""
    tally = Tally(sets=1)
    try:
        found: Any = ms.identify(made.records, **made.options)  # type: ignore[arg-type]
    except ms.InputError:
        tally.refused = 1
        return tally
    limit = found.force_limit
    truth = made.truth["friction_coefficient"] * max(found.loads)
    tally.held = int(limit.low <= truth <= limit.high)
    tally.seen = int(not found.masing.holds or bool(found.notes))
    if not tally.held and not tally.seen:
        tally.unseen.append(f"{label}: {limit.low:.6g} to {limit.high:.6g} N, true {truth:.6g} N")
    return tally


def tallied(part: str, name: str, seed: int) -> Tally:
    """Return the counts of one set."""
    return judged(PARTS[part][1](name, seed), f"{name} {seed}")


def table(tallies: dict[str, Tally]) -> list[str]:
    """Return rows of a page."""
    lines = ["| records | sets | refused | held | seen | neither |"]
    lines.append("| --- | ---: | ---: | ---: | ---: | ---: |")
    for name, t in tallies.items():
        lines.append(f"| {name} | {t.sets} | {t.refused} | {t.held} | {t.seen} | {len(t.unseen)} |")
    return lines
