"""``python -m laboratory``: coverage of the intervals of `identify` and `measure`."""

from __future__ import annotations

import argparse
import hashlib
import json
import re
from collections import Counter
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

import microslip

from .campaign import PARTS, Tally, tallied
from .campaign import table as faults
from .free_form import Coverage, covered, table
from .loops import CLEAN, FAULTS
from .measured import SEEDS, coverage, coverage_table, fault_table

PAGE = Path(__file__).parents[2] / "docs" / "identify.md"
LOG = Path(__file__).parents[2] / "build" / "laboratory.jsonl"
"""A line for each set: what was interrupted goes on there, until the code is another."""
LEAST, LEAST_OF_ALL = 0.9, 0.93
"""Share of the intervals of each source, and of all, that hold the true value."""
MEASURE_PAGE = PAGE.with_name("measure.md")
MOST_WRONG = 3
"""Faults that `measure` names wrongly, at most."""


def main() -> int:
    """Exit with 1 where fewer intervals hold the true value than wanted."""
    parser = argparse.ArgumentParser(prog="python -m laboratory", description=__doc__)
    parser.add_argument("--sets", type=int, default=210, help="sets of known sliders, 210")
    parser.add_argument("--faults", type=int, default=4, help="sets of each imperfection, 4")
    parser.add_argument("--measure", type=int, default=SEEDS, help="records of each kind, 12")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--write", action="store_true", help="write the table into the page")
    given = parser.parse_args()
    whole = _run(given.sets, given.jobs)
    rows = table(whole)
    print("\n".join([*rows, "", *whole.failures]), end="\n\n")
    for part, (names, _) in PARTS.items():
        tallies: dict[str, Tally] = {}
        with ProcessPoolExecutor(given.jobs) as pool:
            jobs = [(part, name, seed) for name in names for seed in range(given.faults)]
            for job, tally in zip(jobs, pool.map(tallied, *zip(*jobs, strict=True)), strict=True):
                tallies.setdefault(job[1], Tally()).add(tally)
        print("\n".join([*faults(tallies), *(x for t in tallies.values() for x in t.unseen)]))
    if given.write:
        write("coverage", rows)
    bad = [source for source, _ in whole.given if whole.share(source) < LEAST]
    bad += ["all"] if whole.share("all") < LEAST_OF_ALL else []
    if given.measure:
        bad += _measured(given.measure, given.write)
    print(f"below {100 * LEAST:g} %: {', '.join(dict.fromkeys(bad)) or 'none'}")
    return 1 if bad else 0


def _measured(number: int, is_written: bool) -> list[str]:
    """Print the tables of `measure` on clean and faulty records; return what falls short."""
    found = coverage(CLEAN, range(number))
    rows = coverage_table(found)
    faults_found, verdicts = fault_table(FAULTS)
    print("\n".join([*rows, "", *faults_found]), flush=True)
    for held in found.values():
        print("\n".join(held.missed))
    if is_written:
        write("measure", rows, MEASURE_PAGE)
        write("faults", faults_found, MEASURE_PAGE)
    bad = [name for name, held in found.items() if held.is_short]
    wrong = verdicts["wrong"]
    return bad + [f"{wrong} faults with a wrong name"] * (wrong > MOST_WRONG)


def _run(sets: int, processes: int) -> Coverage:
    """Return the counts of all sets; those that this code has made before are read."""
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


_COUNTS = ("held", "given")


def _keyed(rows: list[list[str | int]]) -> Counter[tuple[str, str]]:
    return Counter({(str(source), str(name)): int(count) for source, name, count in rows})


def write(part: str, rows: list[str], page: Path = PAGE) -> None:
    """Put a table between its marks on the page."""
    text = page.read_text(encoding="utf-8")
    place = re.compile(rf"(<!-- laboratory: {part} -->\n).*?(<!-- end -->)", re.DOTALL)
    if not place.search(text):
        raise SystemExit(f"{page.name} has no place for the table {part!r}")
    body = "\n".join(rows)
    page.write_text(place.sub(rf"\1\n{body}\n\n\2", text), encoding="utf-8")


if __name__ == "__main__":
    raise SystemExit(main())
