"""Batches of studies, records or scans, with one outcome file per item for restarts."""

from __future__ import annotations

import hashlib
import json
import os
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from concurrent.futures.process import BrokenProcessPool, ProcessPoolExecutor
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import asdict, dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from microslip._core.checks import Progress
from microslip._core.errors import InputError
from microslip._core.files import atomic_file, reason
from microslip._core.packages import needed_for
from microslip._core.quantities import json_value
from microslip._core.wording import one_line
from microslip._version import __version__
from microslip.readers.files import reading
from microslip.readers.laboratory import read_rows
from microslip.readers.text import whole_text
from microslip.study.toml_text import read_text, tables_of

Outcome = dict[str, Any]

ITEMS = "items"
"""Folder of the outcome files."""
_TRIES = 3  # attempts for an item whose worker process died
DASK_PATIENCE = "30s"
"""Time limit for the connection to a Dask scheduler."""
_MOST = 1_000_000
"""Largest number of items of a batch."""
_WINDOW = 4  # submitted items per worker
STUDIES = ".toml"


@dataclass(frozen=True)
class BatchItem:
    """Item of a batch: its name, kind of work, input file and changes to the study."""

    name: str
    work: str
    """"predict", "measure" or "scan"."""
    path: str
    study: str = ""
    changes: tuple[str, ...] = ()

    @property
    def file_name(self) -> str:
        """Unique name of the outcome file."""
        plain = "".join(c if c.isalnum() or c in "-_." else "_" for c in self.name)[:80]
        return f"{plain}-{hashlib.sha256(os.fsencode(self.name)).hexdigest()[:8]}.json"

    @property
    def mark(self) -> str:
        """Hash of program version, item and input files; detects outdated outcomes."""
        parts: list[Any] = [__version__, asdict(self)]
        for path in (self.path, self.study):
            if path:
                with suppress(OSError):  # a missing file is reported when it is read
                    stat = Path(path).stat()
                    parts.append([stat.st_size, stat.st_mtime_ns])
        return hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:16]


def items_of(source: Path, study: Path | None) -> list[BatchItem]:
    """Return the items of a folder, a list of paths, or a CSV table of changes to a study.

    A table requires ``study``. In a folder or list, a file that is not a study is read as a
    measured record or, if the surface of ``study`` is a scan, as a scan that takes its place.
    """
    base = "" if study is None else str(study.resolve())
    if source.is_dir():
        paths = sorted(p for p in source.iterdir() if p.is_file() and not p.name.startswith("."))
        items = [_of_file(path, base, path.name) for path in paths]
    elif not source.exists():
        raise InputError(f"{source}: no such file or folder")
    else:
        is_table = source.suffix.lower() == ".csv"
        if is_table and not base:
            raise InputError(f"`study` must be given: {source} is a table of changes to it")
        with reading(source, "a list"):
            rows: list[Any] = (
                read_rows(source, None) if is_table else whole_text(source).splitlines()
            )
        if len(rows) > _MOST:
            raise InputError(f"{source}: wanted at most {_MOST} items, got {len(rows)}")
        if is_table:
            items = list(_of_table(source, rows, base))
        else:
            lines = [row.strip() for row in rows if row.strip() and not row.startswith("#")]
            items = [_of_file(source.parent / line, base, line) for line in lines]
    if not items:
        raise InputError(f"{source}: wanted studies, records or scans, got none")
    name, count = Counter(item.name for item in items).most_common(1)[0]
    if count > 1:
        raise InputError(f"{source}: wanted each item once, got {name} twice")
    return items


def _of_file(path: Path, study: str, name: str) -> BatchItem:
    if path.suffix.lower() == STUDIES:
        return BatchItem(name, "predict", str(path.resolve()))
    surface: Any = None
    if study:
        with suppress(ValueError):  # the error is reported when the study is run
            surface = tables_of(read_text(Path(study))).get("surface")
    work = "scan" if isinstance(surface, dict) and "scan" in surface else "measure"
    return BatchItem(name, work, str(path.resolve()), study)


def _of_table(source: Path, rows: list[list[str]], study: str) -> Iterator[BatchItem]:
    keys = rows[0] if rows else []
    for number, row in enumerate(rows[1:], start=1):
        if not any(row):
            continue
        if len(row) != len(keys):
            raise InputError(
                f"{source}: wanted {len(keys)} columns, got {len(row)} in row {number}"
            )
        cells = dict(zip(keys, row, strict=True))
        name = cells.pop("name", "") or f"{number:06d}"
        yield BatchItem(
            name, "predict", "", study, tuple(f"{k}={cell}" for k, cell in cells.items())
        )


def run_item(item: BatchItem) -> Outcome:
    """Return the outcome of an item: rows of numbers, or the reason of its failure."""
    begin = time.perf_counter()
    try:
        outcome = {"status": "done", "rows": json_value(_rows(item))}
    except InputError as error:
        outcome = {"status": "failed", "reason": one_line(str(error))}
    except Exception as error:  # an item that fails must not stop the others
        outcome = {"status": "failed", "reason": one_line(f"{type(error).__name__}: {error}")}
    return {**_heading(item), **outcome, "seconds": round(time.perf_counter() - begin, 4)}


def _heading(item: BatchItem) -> Outcome:
    return {"item": item.name, "mark": item.mark, "work": item.work}


def _rows(item: BatchItem) -> Any:
    from microslip.laboratory import Record, measure
    from microslip.study.description import StudyDescription
    from microslip.study.runs.prediction import amplitude_rows as rows_at_amplitudes

    if item.work != "measure":
        scan = (f"surface.scan={json.dumps(item.path)}",) * (item.work == "scan")
        study = StudyDescription.load(item.study or item.path, (*item.changes, *scan))
        return rows_at_amplitudes(study)
    means = measure(Record.read(item.path)).mean
    return [{name: float(mean.value) for name, mean in means.items()}]


@dataclass(frozen=True)
class Batch:
    """Outcomes of all items of a batch, in the order of the items."""

    outcomes: tuple[Outcome, ...]
    computed: int
    """Number of items computed in this run; the others existed already."""

    @property
    def done(self) -> list[Outcome]:
        """Outcomes of the successful items."""
        return [outcome for outcome in self.outcomes if outcome["status"] == "done"]

    @property
    def failed(self) -> list[Outcome]:
        """Outcomes of the failed items."""
        return [outcome for outcome in self.outcomes if outcome["status"] != "done"]


def prepare(folder: Path) -> None:
    """Create the folder of a batch, or check that an existing folder is one."""
    if folder.exists() and not (folder / ITEMS).is_dir() and any(folder.iterdir()):
        raise InputError(f"{folder}: exists and is not a batch; give another folder with -o")
    try:
        (folder / ITEMS).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be written: {reason(error)}") from None


def earlier_outcomes(folder: Path, items: Sequence[BatchItem]) -> dict[str, Outcome]:
    """Return the valid outcomes of an earlier run, without those of failed items."""
    outcomes = {}
    for item in items:
        try:
            outcome = json.loads((folder / ITEMS / item.file_name).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            continue
        if outcome.get("status") == "done" and _heading(item).items() <= outcome.items():
            outcomes[item.name] = outcome
    return outcomes


def run_batch(
    items: Sequence[BatchItem],
    folder: Path,
    workers: int = 1,
    dask: str | None = None,
    progress: Progress | None = None,
) -> Batch:
    """Run the items that have no valid outcome, and save each outcome as soon as it is known.

    Items run in processes of this machine, or on the Dask scheduler at the address ``dask``.
    """
    prepare(folder)
    outcomes = earlier_outcomes(folder, items)
    remaining = [item for item in items if item.name not in outcomes]
    report = progress or (lambda share: None)
    if workers == 1 and dask is None:
        work: Iterator[tuple[BatchItem, Outcome]] = ((item, run_item(item)) for item in remaining)
    else:
        work = _in_parallel(remaining, lambda: _pool(workers, dask))
    for count, (item, outcome) in enumerate(work, start=1):
        with atomic_file(folder / ITEMS / item.file_name, overwrite=True) as stage:
            stage.write_text(json.dumps(outcome), encoding="utf-8")
        outcomes[item.name] = outcome
        report(count / len(remaining))
    return Batch(tuple(outcomes[item.name] for item in items), len(remaining))


@contextmanager
def _pool(workers: int, dask: str | None) -> Iterator[tuple[Executor, int]]:
    """Open an executor; yield it and the number of items that it runs at the same time."""
    if dask is None:
        with ProcessPoolExecutor(workers) as pool:
            yield pool, workers
        return
    with needed_for("`dask` needs", "dask"):
        distributed: Any = import_module("distributed")
    try:
        client = distributed.Client(dask, timeout=DASK_PATIENCE)
    except (OSError, ValueError, TimeoutError) as error:
        message = f"`dask` must be the address of a scheduler: {one_line(str(error))}"
        raise InputError(message) from None
    with client:
        several = len(client.scheduler_info().get("workers", {}))
        yield client.get_executor(pure=False), max(1, several)


def _in_parallel(
    items: Sequence[BatchItem], pool_of: Callable[[], AbstractContextManager[tuple[Executor, int]]]
) -> Iterator[tuple[BatchItem, Outcome]]:
    """Run items in an executor; if a process dies, run its items again in a new one."""
    waiting, tries = list(reversed(items)), dict.fromkeys(items, 0)
    while waiting:
        running: dict[Future[Outcome], BatchItem] = {}
        with pool_of() as (pool, workers):
            try:
                while waiting or running:
                    while waiting and len(running) < _WINDOW * workers:
                        item = waiting.pop()
                        running[pool.submit(run_item, item)] = item
                    for future in wait(running, return_when=FIRST_COMPLETED).done:
                        try:
                            outcome = future.result()
                        except BrokenProcessPool:
                            raise
                        except Exception:  # Dask has already tried several workers
                            outcome = _lost_worker(running[future])
                        yield running.pop(future), outcome
            except BrokenProcessPool:
                for item in running.values():
                    tries[item] += 1
                    if tries[item] < _TRIES:
                        waiting.append(item)
                    else:
                        yield item, _lost_worker(item)


def _lost_worker(item: BatchItem) -> Outcome:
    cause = f"the worker process died {_TRIES} times (out of memory, or killed)"
    return {**_heading(item), "status": "failed", "reason": cause, "seconds": 0.0}
