"""``python -m laboratory``: how often intervals hold the truth, and what wrong physics passes."""

from __future__ import annotations

import argparse
import hashlib
import json
import re
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

import microslip

from .campaign import PARTS, Tally, table, tallied

PAGE = Path(__file__).parents[2] / "docs" / "identify.md"
LOG = Path(__file__).parents[2] / "build" / "laboratory.jsonl"
"""A line for each set: what was interrupted goes on there, until the code is another."""
LEAST = 0.9
"""Of the intervals of a parameter, or of all kinds together, that hold the truth."""
SETS = {"ordinary": 20, "imperfect": 32, "wrong": 4}
"""Of each kind."""
Job = tuple[str, str, int]


def main() -> int:
    """Exit with 1 where less than 90 % of the intervals hold, or wrong physics passes."""
    parser = argparse.ArgumentParser(prog="python -m laboratory", description=__doc__)
    for part, number in SETS.items():
        parser.add_argument(f"--{part}", type=int, default=number, help=f"sets a kind, {number}")
    parser.add_argument("--only", choices=PARTS, help="one of the three alone")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--write", action="store_true", help="write the tables into the page")
    given = parser.parse_args()
    parts = [given.only] if given.only else list(PARTS)
    jobs = [job for part in parts for job in _jobs(part, getattr(given, part))]
    done = _run(jobs, given.jobs)
    bad: list[str] = []
    for part in parts:
        tallies: dict[str, Tally] = {}
        for job in jobs:
            if job[0] == part:
                tallies.setdefault(job[1], Tally()).add(done[job])
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


def _jobs(part: str, number: int) -> Iterator[Job]:
    """Sets of a part; ordinary ones have seeds of their own."""
    names = PARTS[part][0]
    for i in range(number):
        for at, name in enumerate(names):
            yield part, name, i * len(names) + at if part == "ordinary" else i


def _run(jobs: list[Job], processes: int) -> dict[Job, Tally]:
    """Their tallies; those that this code has made before are read."""
    code = hashlib.sha256()
    for folder in (Path(microslip.__file__).parent, Path(__file__).parent):
        for path in sorted(folder.rglob("*.py")):
            code.update(path.read_bytes())
    done: dict[Job, Tally] = {}
    for line in LOG.read_text("utf-8").splitlines() if LOG.exists() else ():
        of_code, job, counts = json.loads(line)
        if of_code == code.hexdigest():
            found = {k: Counter(v) if isinstance(v, dict) else v for k, v in counts.items()}
            done[(job[0], job[1], job[2])] = Tally(**found)
    LOG.parent.mkdir(exist_ok=True)
    with ProcessPoolExecutor(processes) as pool, LOG.open("a", encoding="utf-8") as log:
        waiting = {pool.submit(tallied, *job): job for job in jobs if job not in done}
        for future in as_completed(waiting):
            job = waiting[future]
            done[job] = future.result()
            print(json.dumps([code.hexdigest(), job, vars(done[job])]), file=log, flush=True)
    return done


def write(part: str, rows: list[str]) -> None:
    """Put a table where the page says that it is."""
    text = PAGE.read_text(encoding="utf-8")
    place = re.compile(rf"(<!-- laboratory: {part} -->\n).*?(<!-- end -->)", re.DOTALL)
    if not place.search(text):
        raise SystemExit(f"{PAGE.name} has no place for the table {part!r}")
    body = "\n".join(rows)
    PAGE.write_text(place.sub(rf"\1\n{body}\n\n\2", text), encoding="utf-8")


if __name__ == "__main__":
    raise SystemExit(main())
