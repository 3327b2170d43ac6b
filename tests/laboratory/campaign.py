"""What the package makes of sets of records, counted."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import microslip as ms

from .imperfections import IMPERFECTIONS, an_imperfect_set
from .sets import KINDS, Set, a_set
from .wrong_physics import WRONG, a_wrong_set


@dataclass
class Tally:
    """Numbers called identified, how many of their intervals hold the truth, and verdicts."""

    sets: int = 0
    refused: int = 0
    identified: Counter[str] = field(default_factory=Counter)
    covered: Counter[str] = field(default_factory=Counter)
    verdicts: Counter[str] = field(default_factory=Counter)
    missed: list[str] = field(default_factory=list)

    @property
    def held(self) -> float:
        """Share of the intervals that hold the truth; 1 of none."""
        return self.covered.total() / max(self.identified.total(), 1) if self.identified else 1.0

    def add(self, other: Tally) -> None:
        """Count another one in."""
        self.sets, self.refused = self.sets + other.sets, self.refused + other.refused
        self.identified += other.identified
        self.covered += other.covered
        self.verdicts += other.verdicts
        self.missed += other.missed


def judged(found: Set, label: str) -> Tally:
    """One set, identified."""
    tally = Tally(sets=1)
    try:
        fit = ms.identify(found.records, held_back=0.0, **found.options)  # type: ignore[arg-type]
    except ms.InputError as error:
        tally.refused = 1
        tally.missed.append(f"{label}: refused: {error}")
        return tally
    if not fit.converged:
        tally.refused = 1
        return tally
    for name, truth in found.truth.items():
        number = fit.parameters[name]
        tally.verdicts[number.verdict] += 1
        if number.verdict == "identified":
            tally.identified[name] += 1
            covered = number.low <= truth <= number.high
            tally.covered[name] += covered
            if not covered:
                tally.missed.append(
                    f"{label}: {name} {number.low:.5g} to {number.high:.5g}, true {truth:.5g}"
                )
    return tally


def tallied(part: str, name: str, seed: int) -> Tally:
    """One set of a part of the laboratory."""
    make = PARTS[part][1]
    return judged(make(name, seed), f"{name} {seed}")


PARTS: dict[str, tuple[tuple[str, ...], Callable[[str, int], Set]]] = {
    "ordinary": (KINDS, lambda kind, seed: a_set(seed, kind)),
    "imperfect": (IMPERFECTIONS, an_imperfect_set),
    "wrong": (tuple(WRONG), a_wrong_set),
}
"""The parts of the laboratory: the kinds of sets of each, and what makes one of a seed."""


def together(jobs: Iterable[tuple[str, str, int]]) -> dict[str, Tally]:
    """Tallies of sets, each of a part, a kind and a seed, by their kinds."""
    tallies: dict[str, Tally] = {}
    for part, name, seed in jobs:
        tallies.setdefault(name, Tally()).add(tallied(part, name, seed))
    return tallies


def coverage(seeds: Iterable[int]) -> dict[str, Tally]:
    """Tallies of ordinary sets, by their kinds."""
    return together(("ordinary", KINDS[seed % len(KINDS)], seed) for seed in seeds)


def wrong(seeds: range) -> dict[str, Tally]:
    """Tallies of sets with something wrong, by what that is."""
    return together(("wrong", name, seed) for name in WRONG for seed in seeds)


def table(tallies: dict[str, Tally]) -> list[str]:
    """Rows of a page."""
    names = ("friction_coefficient", "slip_scale", "standardised_separation", "rig_stiffness")
    lines = [
        "| records | sets | refused | μ | κσ | h | rig | held | other verdicts |",
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | --- |",
    ]
    whole = Tally()
    for tally in tallies.values():
        whole.add(tally)
    for label, tally in {**tallies, "all": whole}.items():
        cells = " | ".join(f"{tally.covered[name]}/{tally.identified[name]}" for name in names)
        others = ", ".join(
            f"{count} {word}"
            for word, count in sorted(tally.verdicts.items())
            if word != "identified"
        )
        held = f"{100.0 * tally.held:.0f} %" if tally.identified.total() else "–"
        lines.append(f"| {label} | {tally.sets} | {tally.refused} | {cells} | {held} | {others} |")
    return lines


__all__ = ["KINDS", "PARTS", "Tally", "coverage", "table", "tallied", "wrong"]
