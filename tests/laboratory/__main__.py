"""``python -m laboratory``: how often intervals hold the truth, and what wrong physics passes."""

from __future__ import annotations

import argparse
from concurrent.futures import ProcessPoolExecutor
from itertools import pairwise

from .campaign import Tally, coverage, table, wrong


def main() -> int:
    """Exit with 1 where less than 90 % of the intervals of a parameter or a kind hold, or wrong
    physics passes."""
    parser = argparse.ArgumentParser(prog="python -m laboratory", description=__doc__)
    parser.add_argument("--sets", type=int, default=360, help="ordinary sets of records")
    parser.add_argument("--wrong", type=int, default=4, help="sets of each kind of wrong physics")
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args()
    parts = 8 * given.jobs
    edges = [given.sets * i // parts for i in range(parts + 1)]
    with ProcessPoolExecutor(given.jobs) as pool:
        ordinary = pool.map(coverage, [range(a, b) for a, b in pairwise(edges)])
        others = pool.map(wrong, [range(i, i + 1) for i in range(given.wrong)])
        known, bad = _together(ordinary), _together(others)
    print("\n".join(table(known)), end="\n\n")
    print("\n".join(table(bad)))
    whole = Tally()
    for tally in known.values():
        whole.add(tally)
    for text in (*whole.missed, *(text for tally in bad.values() for text in tally.missed)):
        print(text)
    low = [name for name, count in whole.identified.items() if whole.covered[name] < 0.9 * count]
    low += [name for name, tally in known.items() if tally.held < 0.9]
    passed = [name for name, tally in bad.items() if tally.covered != tally.identified]
    print(f"below 90 %: {', '.join(low) or 'none'}; passed: {', '.join(passed) or 'none'}")
    return 1 if low or passed else 0


def _together(parts):  # type: ignore[no-untyped-def]
    tallies: dict[str, Tally] = {}
    for part in parts:
        for name, tally in part.items():
            tallies.setdefault(name, Tally()).add(tally)
    return tallies


if __name__ == "__main__":
    raise SystemExit(main())
