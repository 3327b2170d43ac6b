"""``python -m laboratory``: how often intervals hold the truth, and what wrong physics passes."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from itertools import pairwise
from pathlib import Path

from .campaign import Tally, coverage, imperfect, table, wrong

PAGE = Path(__file__).parents[2] / "docs" / "identify.md"
PARTS: dict[str, Callable[[range], dict[str, Tally]]] = {
    "ordinary": coverage,
    "imperfect": imperfect,
    "wrong": wrong,
}
LEAST = 0.9
"""Of the intervals of a parameter, or of all kinds together, that hold the truth."""


def main() -> int:
    """Exit with 1 where less than 90 % of the intervals hold, or wrong physics passes."""
    parser = argparse.ArgumentParser(prog="python -m laboratory", description=__doc__)
    parser.add_argument("--sets", type=int, default=360, help="ordinary sets of records")
    parser.add_argument("--imperfect", type=int, default=12, help="sets of each imperfection")
    parser.add_argument("--wrong", type=int, default=4, help="sets of each kind of wrong physics")
    parser.add_argument("--only", choices=PARTS, help="one of the three alone")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--write", action="store_true", help="write the tables into the page")
    given = parser.parse_args()
    counts = {"ordinary": given.sets, "imperfect": given.imperfect, "wrong": given.wrong}
    bad: list[str] = []
    for part in [given.only] if given.only else list(PARTS):
        number = min(counts[part], 8 * given.jobs)
        edges = [counts[part] * i // number for i in range(number + 1)]
        with ProcessPoolExecutor(given.jobs) as pool:
            ranges = [range(a, b) for a, b in pairwise(edges)]
            tallies = _together(list(pool.map(PARTS[part], ranges)))
        rows = table(tallies)
        print("\n".join(rows), end="\n\n")
        whole = Tally()
        for tally in tallies.values():
            whole.add(tally)
        print("\n".join(whole.missed), flush=True)
        if given.write:
            write(part, rows)
        if part == "wrong":
            bad += [name for name, tally in tallies.items() if tally.covered != tally.identified]
        else:
            bad += [n for n, c in whole.identified.items() if whole.covered[n] < LEAST * c]
    print(f"below {100 * LEAST:g} %, or passed: {', '.join(bad) or 'none'}")
    return 1 if bad else 0


def write(part: str, rows: list[str]) -> None:
    """Put a table where the page says that it is."""
    text = PAGE.read_text(encoding="utf-8")
    place = re.compile(rf"(<!-- laboratory: {part} -->\n).*?(<!-- end -->)", re.DOTALL)
    if not place.search(text):
        raise SystemExit(f"{PAGE.name} has no place for the table {part!r}")
    body = "\n".join(rows)
    PAGE.write_text(place.sub(rf"\1\n{body}\n\n\2", text), encoding="utf-8")


def _together(parts: list[dict[str, Tally]]) -> dict[str, Tally]:
    tallies: dict[str, Tally] = {}
    for part in parts:
        for name, tally in part.items():
            tallies.setdefault(name, Tally()).add(tally)
    return tallies


if __name__ == "__main__":
    raise SystemExit(main())
