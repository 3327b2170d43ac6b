"""``python -m laboratory``: how often intervals hold the true values, into docs/identify.md."""

from __future__ import annotations

import argparse
import hashlib
import json
import re
from collections import Counter
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

import microslip

from .campaign import PARTS, Tally, table, tallied
from .loops import CLEAN, FAULTS
from .measured import coverage, coverage_table, fault_table

PAGE = Path(__file__).parents[2] / "docs" / "identify.md"
LOG = Path(__file__).parents[2] / "build" / "laboratory.jsonl"
"""A line for each set: what was interrupted goes on there, until the code is another."""
LEAST = 0.9
"""Of the intervals of a parameter, or of all kinds together, that hold the truth."""
MEASURE_PAGE = PAGE.with_name("measure.md")
LEAST_MEASURED, MOST_WRONG = 0.93, 3
"""Of the intervals of `measure` in each kind that hold, and faults named wrongly."""
SETS = {"ordinary": 20, "imperfect": 32, "wrong": 4}
"""Of each kind."""
Job = tuple[str, str, int]


def main() -> int:
    """Exit with 1 where fewer intervals hold the true value than wanted."""
    parser = argparse.ArgumentParser(prog="python -m laboratory", description=__doc__)
    for part, number in SETS.items():
        parser.add_argument(f"--{part}", type=int, default=number, help=f"sets a kind, {number}")
    parser.add_argument("--only", choices=PARTS, help="one of the three alone")
    parser.add_argument("--measure", type=int, default=4, help="records a kind for `measure`, 4")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--write", action="store_true", help="write the table into the page")
    given = parser.parse_args()
    whole = _run(given.sets, given.jobs)
    rows = table(whole)
    print("\n".join([*rows, "", *whole.failures]), end="\n\n")
    for part, (names, _) in PARTS.items():
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
    if given.measure and not given.only:
        bad += _measured(given.measure, given.write)
    print(f"below {100 * LEAST:g} %, or passed: {', '.join(bad) or 'none'}")
    return 1 if bad else 0


def _measured(number: int, is_written: bool) -> list[str]:
    """Tables of what `measure` makes of ordinary and of faulty records; what fails."""
    found = coverage(CLEAN, range(number))
    rows = coverage_table(found)
    faults, wrong = fault_table(FAULTS)
    print("\n".join([*rows, "", *faults]), flush=True)
    for held in found.values():
        print("\n".join(held.missed))
    if is_written:
        write("measure", rows, MEASURE_PAGE)
        write("faults", faults, MEASURE_PAGE)
    bad = [name for name, held in found.items() if held.share < LEAST_MEASURED]
    return bad + [f"{wrong} faults named wrongly"] * (wrong > MOST_WRONG)


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
    done: dict[int, Coverage] = {}
    for line in LOG.read_text("utf-8").splitlines() if LOG.exists() else ():
        of_code, seed, counts = json.loads(line)
        if of_code == code.hexdigest():
            done[seed] = Coverage(**{**counts, **{k: _keyed(counts[k]) for k in _COUNTS}})
    LOG.parent.mkdir(exist_ok=True)
    with ProcessPoolExecutor(processes) as pool, LOG.open("a", encoding="utf-8") as log:
        waiting = {pool.submit(covered, seed): seed for seed in range(sets) if seed not in done}
        for future in as_completed(waiting):
            seed = waiting[future]
            done[seed] = counts = future.result()
            plain = vars(counts) | {
                k: [[*n, c] for n, c in vars(counts)[k].items()] for k in _COUNTS
            }
            print(json.dumps([code.hexdigest(), seed, plain]), file=log, flush=True)
    whole = Coverage()
    for seed in sorted(done):
        whole.add(done[seed])
    return whole


def write(part: str, rows: list[str], page: Path = PAGE) -> None:
    """Put a table where the page says that it is."""
    text = page.read_text(encoding="utf-8")
    place = re.compile(rf"(<!-- laboratory: {part} -->\n).*?(<!-- end -->)", re.DOTALL)
    if not place.search(text):
        raise SystemExit(f"{page.name} has no place for the table {part!r}")
    body = "\n".join(rows)
    page.write_text(place.sub(rf"\1\n{body}\n\n\2", text), encoding="utf-8")


if __name__ == "__main__":
    raise SystemExit(main())
