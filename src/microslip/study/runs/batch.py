"""Batches of studies, with one outcome file per item for restarts."""

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

Outcome = dict[str, Any]

ITEMS = "items"
"""Folder of the outcome files."""
_TRIES = 3  # attempts for an item whose worker process died
DASK_PATIENCE = "30s"
"""Time limit for the connection to a Dask scheduler."""
_MOST = 1_000_000
"""Largest number of items of a batch."""
_WINDOW = 4  # submitted items per worker


@dataclass(frozen=True)
class BatchItem:
    """Item of a batch: its name, the file of its study and changes to the study."""

    name: str
    study: str
    changes: tuple[str, ...] = ()

    @property
    def file_name(self) -> str:
        """Unique name of the outcome file."""
        plain = "".join(c if c.isalnum() or c in "-_." else "_" for c in self.name)[:80]
        return f"{plain}-{hashlib.sha256(os.fsencode(self.name)).hexdigest()[:8]}.json"

    @property
    def mark(self) -> str:
        """Hash of program version, item and study file; detects outdated outcomes."""
        parts: list[Any] = [__version__, asdict(self)]
        with suppress(OSError):  # a missing file is reported when it is read
            stat = Path(self.study).stat()
            parts.append([stat.st_size, stat.st_mtime_ns])
        return hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:16]


def items_of(source: Path, study: Path | None) -> list[BatchItem]:
    """Return the items of a folder of studies, or of a CSV table of changes to ``study``."""
    if source.is_dir():
        items = [BatchItem(p.name, str(p.resolve())) for p in sorted(source.glob("*.toml"))]
    elif not source.exists():
        raise InputError(f"{source}: no such file or folder")
    elif study is None:
        raise InputError(f"`study` must be given: {source} is a table of changes to it")
    else:
        with reading(source, "a table"):
            rows = read_rows(source, None)
        if len(rows) > _MOST:
            raise InputError(f"{source}: wanted at most {_MOST} items, got {len(rows)}")
        items = list(_of_table(source, rows, str(study.resolve())))
    if not items:
        raise InputError(f"{source}: wanted studies, got none")
    name, count = Counter(item.name for item in items).most_common(1)[0]
    if count > 1:
        raise InputError(f"{source}: wanted each item once, got {name} twice")
    return items


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
        yield BatchItem(name, study, tuple(f"{k}={cell}" for k, cell in cells.items()))


def run_item(item: BatchItem) -> Outcome:
    """Return the outcome of an item: rows of numbers, or the reason of its failure."""
    from microslip.study.description import StudyDescription
    from microslip.study.runs.prediction import amplitude_rows

    begin = time.perf_counter()
    try:
        rows = amplitude_rows(StudyDescription.load(item.study, item.changes))
        outcome = {"status": "done", "rows": json_value(rows)}
    except InputError as error:
        outcome = {"status": "failed", "reason": one_line(str(error))}
    except Exception as error:  # an item that fails must not stop the others
        outcome = {"status": "failed", "reason": one_line(f"{type(error).__name__}: {error}")}
    return {**_heading(item), **outcome, "seconds": round(time.perf_counter() - begin, 4)}


def _heading(item: BatchItem) -> Outcome:
    return {"item": item.name, "mark": item.mark}


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
