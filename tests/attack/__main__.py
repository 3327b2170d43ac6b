"""``python -m attack``: make the inputs, print and keep the table of what became of them."""

from __future__ import annotations

import argparse
import os
import resource
import signal
import sys
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

from . import ATTACKS
from .campaign import Tally, run

MEMORY = 6 * 2**30
"""Bytes a worker may have: what grows without bound ends here, and counts as wrong."""
SHARE = 25_000
"""Inputs of all attacks together after which a worker begins anew."""


def work(name: str, inputs: int, seed: int) -> tuple[str, Tally, float]:
    """One share of one attack, in a process of its own."""
    if "ASAN_OPTIONS" not in os.environ:  # whose shadow memory alone is terabytes of addresses
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    begun = time.perf_counter()
    tally = run(ATTACKS[name].attack, inputs, seed)
    return name, tally, time.perf_counter() - begun


def main() -> int:
    """Exit with 1 where anything went wrong."""
    parser = argparse.ArgumentParser(prog="python -m attack", description=__doc__)
    parser.add_argument("--inputs", type=int, default=20_000, help="how many in all")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", choices=sorted(ATTACKS), action="append")
    parser.add_argument("--table", type=Path, help="write the table into this page, too")
    given = parser.parse_args()
    names = given.only or list(ATTACKS)
    weight = sum(ATTACKS[name].weight for name in names)
    tallies = {name: Tally() for name in names}
    seconds = dict.fromkeys(names, 0.0)
    signal.signal(signal.SIGINT, signal.default_int_handler)  # which shells ignore in background
    parts = max(4 * given.jobs, given.inputs // SHARE)
    with ProcessPoolExecutor(given.jobs) as pool:
        shares = [
            pool.submit(
                work,
                name,
                max(1, round(given.inputs * ATTACKS[name].weight / weight / parts)),
                given.seed * 1000 + part,
            )
            for part in range(parts)
            for name in names
        ]
        try:
            for done, share in enumerate(as_completed(shares), 1):
                name, tally, took = share.result()
                tallies[name].add(tally)
                seconds[name] += took
                for text in tally.wrong[:20]:
                    print(f"WRONG {name}: {text}", flush=True)
                if sys.stderr.isatty():
                    print(f"\r{done} of {len(shares)} shares", end="", file=sys.stderr)
        except KeyboardInterrupt:  # what has come until then counts
            pool.shutdown(wait=False, cancel_futures=True)
    lines = table(tallies, seconds)
    print("\n".join(lines))
    if given.table is not None:
        write(given.table, lines)
    return 1 if any(tally.wrong for tally in tallies.values()) else 0


def table(tallies: dict[str, Tally], seconds: dict[str, float]) -> list[str]:
    """Rows of a page: what was attacked, and tried, refused, wrong."""
    lines = [
        "| attack | inputs | refused | wrong | slowest answer |",
        "| --- | ---: | ---: | ---: | ---: |",
    ]
    total = Tally()
    for name, tally in tallies.items():
        total.add(tally)
        lines.append(row(ATTACKS[name].title, tally))
    return [*lines, row("all", total)]


def row(title: str, tally: Tally) -> str:
    """One line of the table."""
    return (
        f"| {title} | {tally.tried:,} | {tally.refused:,} | {len(tally.wrong):,} "
        f"| {tally.slowest:.2g} s |"
    )


def write(page: Path, lines: list[str]) -> None:
    """Put the table between the marks of a page."""
    text = page.read_text(encoding="utf-8")
    begin, end = "<!-- attack: begin -->\n", "<!-- attack: end -->"
    head, rest = text.split(begin)
    tail = rest.split(end)[1]
    page.write_text(head + begin + "\n".join(lines) + "\n" + end + tail, encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
