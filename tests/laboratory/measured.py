"""What `measure` makes of records with a known truth, and of faulty ones."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field

from scipy.stats import binom

import microslip as ms

from .loops import CAUSES, CLEAN, a_fault, a_record

EXACT = 3e-6
"""Accuracy of the truth and of the samples: straight lines between 2000 steps a cycle."""
UNDECIDED = "cause not determined"
LEAST, CHANCE, SEEDS = 0.93, 0.01, 12
"""Share of the intervals of each kind that hold; probability of a count below which it is not by
chance that fewer do; and records of each kind, by which 84 % are told from 95 %."""
_SAME = ("friction_peak",)
"""Columns whose intervals are those of another one, so that they are not counted twice."""


@dataclass
class Held:
    """Intervals of a kind that hold the truth, by column, and what missed."""

    held: Counter[str] = field(default_factory=Counter)
    number: Counter[str] = field(default_factory=Counter)
    missed: list[str] = field(default_factory=list)

    @property
    def share(self) -> float:
        """Share of all intervals that hold [-]."""
        return self.held.total() / max(self.number.total(), 1)

    @property
    def is_short(self) -> bool:
        """Whether so few intervals hold by a chance of under 1 % if 93 % do."""
        held, number = (
            sum(count for name, count in counts.items() if name not in _SAME)
            for counts in (self.held, self.number)
        )
        return bool(binom.cdf(held, number, LEAST) < CHANCE)


def coverage(names: Iterable[str], seeds: Iterable[int]) -> dict[str, Held]:
    """Intervals of the means that hold, by kind."""
    found: dict[str, Held] = defaultdict(Held)
    for name in names:
        for seed in seeds:
            record, truth = a_record(name, seed)
            measured = ms.measure(record, **CLEAN[name].options)  # type: ignore[arg-type]
            mean = measured.mean
            if measured.levels:
                mean = max(measured.levels, key=lambda level: level.mean["amplitude"].value).mean
            for column, value in truth.items():
                of = mean[column]
                good = of.low - EXACT * value <= value <= of.high + EXACT * value
                found[name].number[column] += 1
                found[name].held[column] += good
                if not good:
                    found[name].missed.append(
                        f"{name} {seed}: {column} {of.low:.6g} to {of.high:.6g} "
                        f"({of.value / value - 1:+.4%}), true {value:.6g}"
                    )
    return dict(found)


def verdict_on(name: str, seed: int) -> tuple[str, list[str]]:
    """ "named", "undecided", "silent" or "wrong", and the notes, of a faulty record."""
    record, words = a_fault(name, seed)
    try:
        notes = list(ms.measure(record).notes)
    except ms.InputError as error:
        notes = [str(error)]
    certain = [note for note in notes if UNDECIDED not in note]
    named = {
        cause
        for cause, texts in CAUSES.items()
        if any(text in note for note in certain for text in texts)
    }
    if any(word in note for word in words for note in certain):
        return "named", notes
    if named:
        return "wrong", notes
    return ("undecided" if len(certain) < len(notes) else "silent"), notes


def coverage_table(found: dict[str, Held]) -> list[str]:
    """Rows of a page: intervals that hold, by kind and column."""
    columns = list(next(iter(found.values())).number)
    lines = [
        f"| records | {' | '.join(columns)} | held |",
        f"| --- |{' ---: |' * len(columns)} ---: |",
    ]
    for name, held in found.items():
        cells = " | ".join(f"{held.held[c]}/{held.number[c]}" for c in columns)
        lines.append(f"| {name} | {cells} | {100.0 * held.share:.0f} % |")
    return lines


def fault_table(names: Iterable[str], seed: int = 0) -> tuple[list[str], Counter[str]]:
    """Rows of a page: what is said of each fault; and how many verdicts of each kind there are."""
    verdicts = {name: verdict_on(name, seed)[0] for name in names}
    rows = [f"| {name} | {verdict} |" for name, verdict in verdicts.items()]
    return ["| fault | `measure` |", "| --- | --- |", *rows], Counter(verdicts.values())
