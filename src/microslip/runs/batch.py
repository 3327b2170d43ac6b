"""Batches of studies, records or scans: one small file each, from which a restart continues."""

from __future__ import annotations

import hashlib
import json
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from concurrent.futures.process import BrokenProcessPool, ProcessPoolExecutor
from contextlib import suppress
from dataclasses import asdict, dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from microslip._core.checks import Progress
from microslip._core.files import reason, whole_file
from microslip._core.packages import needed_for
from microslip._core.quantities import json_value
from microslip._core.wording import one_line
from microslip._version import __version__
from microslip.errors import InputError
from microslip.readers.files import reading
from microslip.readers.laboratory import rows_of
from microslip.readers.text import whole_text
from microslip.study.toml_text import tables_of, text_of

Outcome = dict[str, Any]

ITEMS = "items"
"""Folder of the small files."""
_TRIES = 3  # of an item whose worker died
DASK_PATIENCE = "30s"
"""Longest time that a scheduler may take to answer."""
_MOST = 1_000_000
"""Items of a batch."""
_WINDOW = 4  # items in flight a worker
STUDIES = ".toml"


@dataclass(frozen=True)
class Item:
    """One piece of a batch: what it is called, what is done, to which file, with which changes."""

    name: str
    work: str
    """"predict", "measure" or "scan"."""
    path: str
    study: str = ""
    changes: tuple[str, ...] = ()

    @property
    def file_name(self) -> str:
        """Name of its small file, which no other item has."""
        plain = "".join(c if c.isalnum() or c in "-_." else "_" for c in self.name)[:80]
        return f"{plain}-{hashlib.sha256(os.fsencode(self.name)).hexdigest()[:8]}.json"

    @property
    def mark(self) -> str:
        """Changes where anything does that its numbers come from."""
        parts: list[Any] = [__version__, asdict(self)]
        for path in (self.path, self.study):
            if path:
                with suppress(OSError):  # one that is gone has its reason told when it is read
                    stat = Path(path).stat()
                    parts.append([stat.st_size, stat.st_mtime_ns])
        return hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:16]


def items_of(source: Path, study: Path | None) -> list[Item]:
    """The items of a folder, of a list with a path a line, or of a CSV table of changes to a study.

    The study is that of a table, of scans, or of the joint that tells the regimes of records apart.
    """
    base = "" if study is None else str(study.resolve())
    if source.is_dir():
        paths = sorted(p for p in source.iterdir() if p.is_file() and not p.name.startswith("."))
        items = [_of_file(path, base) for path in paths]
    elif not source.exists():
        raise InputError(f"{source}: no such file or folder")
    elif source.suffix.lower() == ".csv":
        items = list(_of_table(source, base))
    else:
        lines = _listed(source, lambda path: whole_text(path).splitlines())
        named = [line.strip() for line in lines if line.strip() and not line.startswith("#")]
        items = [_of_file(source.parent / line, base, line) for line in named]
    if not items:
        raise InputError(f"{source}: wanted studies, records or scans, got none")
    names = [item.name for item in items]
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise InputError(f"{source}: wanted each item once, got {twice} twice")
    return items


def _listed(source: Path, read: Callable[[Path], list[Any]]) -> list[Any]:
    """Lines or rows of a list."""
    with reading(source, "a list"):
        listed = read(source)
    if len(listed) > _MOST:
        raise InputError(f"{source}: wanted at most {_MOST} items, got {len(listed)}")
    return listed


def _of_file(path: Path, study: str, name: str = "") -> Item:
    if path.suffix.lower() == STUDIES:
        return Item(name or path.name, "predict", str(path.resolve()))
    work = "scan" if study and _has_scan(study) else "measure"
    return Item(name or path.name, work, str(path.resolve()), study)


def _has_scan(study: str) -> bool:
    try:
        data = tables_of(text_of(Path(study)))
    except ValueError:
        return False
    surface = data.get("surface")
    return isinstance(surface, dict) and surface.get("law") == "scan"


def _of_table(source: Path, study: str) -> Iterator[Item]:
    if not study:
        raise InputError(f"`study` must be given: {source} is a table of changes to it")
    rows = iter(_listed(source, lambda path: rows_of(path, None)))
    keys: list[str] = next(rows, [])
    for number, row in enumerate(rows, start=1):
        if not any(row):
            continue
        if len(row) != len(keys):
            raise InputError(
                f"{source}: wanted {len(keys)} columns, got {len(row)} in row {number}"
            )
        cells = list(zip(keys, row, strict=True))
        name = dict(cells).get("name") or f"{number:06d}"
        changes = tuple(f"{key}={cell}" for key, cell in cells if key != "name")
        yield Item(name, "predict", "", study, changes)


# -- one item --------------------------------------------------------------------------------------


def run_item(item: Item) -> Outcome:
    """Result of an item: rows of plain numbers, or the reason why there are none."""
    begin = time.perf_counter()
    try:
        rows = _measured(item) if item.work == "measure" else _predicted(item)
        outcome = {"status": "done", "rows": rows}
    except InputError as error:
        outcome = {"status": "failed", "reason": one_line(str(error))}
    except Exception as error:  # one item must not stop the others, whatever it meets
        outcome = {"status": "failed", "reason": one_line(f"{type(error).__name__}: {error}")}
    return {**_heading(item), **outcome, "seconds": round(time.perf_counter() - begin, 4)}


def _heading(item: Item) -> Outcome:
    return {"item": item.name, "mark": item.mark, "work": item.work}


def _predicted(item: Item) -> list[dict[str, float | None]]:
    from microslip.runs.prediction import rows_of
    from microslip.study.description import StudyDescription

    changes = item.changes
    if item.work == "scan":
        changes = (*changes, f"surface.scan={json.dumps(item.path)}")
    study = StudyDescription.load(item.study or item.path, changes)
    return json_value(rows_of(study))  # type: ignore[no-any-return]


def _measured(item: Item) -> list[dict[str, float | None]]:
    from microslip.tribometer import Record, measure

    joint = None
    if item.study:
        from microslip.study.build import build_joints
        from microslip.study.description import StudyDescription

        joint = build_joints(StudyDescription.load(item.study))[0]
    measurement = measure(Record.read(item.path), model=joint)
    return [{name: json_value(float(mean.value)) for name, mean in measurement.mean.items()}]


# -- all items -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Batch:
    """Results of a batch so far."""

    items: tuple[Item, ...]
    outcomes: Mapping[str, Outcome]
    computed: int
    """Number of items computed in this run; the others existed already."""

    def _by_status(self, is_done: bool) -> list[Outcome]:
        outcomes = (self.outcomes.get(item.name) for item in self.items)
        return [o for o in outcomes if o is not None and (o["status"] == "done") == is_done]

    @property
    def done(self) -> list[Outcome]:
        """Outcomes with numbers, in the order of the items."""
        return self._by_status(True)

    def of_all(self, items: Sequence[Item], outcomes: Mapping[str, Outcome]) -> Batch:
        """The same with the outcomes of other shards."""
        return Batch(tuple(items), {**outcomes, **self.outcomes}, self.computed)

    @property
    def failed(self) -> list[Outcome]:
        """Outcomes without numbers."""
        return self._by_status(False)


def prepare(folder: Path) -> None:
    """Make the folder of a batch, or see that it is one."""
    if folder.exists() and not (folder / ITEMS).is_dir() and any(folder.iterdir()):
        raise InputError(f"{folder}: exists and is no batch; name another folder with -o")
    try:
        (folder / ITEMS).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be written: {reason(error)}") from None


def earlier_outcomes(
    folder: Path, items: Sequence[Item], failures: bool = False
) -> dict[str, Outcome]:
    """Outcomes of an earlier run that still hold; failures only where they are asked for."""
    outcomes = {}
    for item in items:
        try:
            outcome = json.loads((folder / ITEMS / item.file_name).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            continue
        unchanged = outcome.get("mark") == item.mark and outcome.get("item") == item.name
        if unchanged and (failures or outcome.get("status") == "done"):
            outcomes[item.name] = outcome
    return outcomes


def run(
    items: Sequence[Item],
    folder: Path,
    workers: int = 1,
    dask: str | None = None,
    progress: Progress | None = None,
) -> Batch:
    """Run what is not there yet, and keep each outcome at once in a small file of its own.

    On so many processes of this machine, or on a Dask scheduler at an address; "local" for a
    cluster of so many workers here.
    """
    prepare(folder)
    outcomes = earlier_outcomes(folder, items)
    remaining = [item for item in items if item.name not in outcomes]
    total = len(remaining)
    report = progress or (lambda share: None)
    work = _on_dask(remaining, workers, dask) if dask is not None else _here(remaining, workers)
    for count, (item, outcome) in enumerate(work, start=1):
        with whole_file(folder / ITEMS / item.file_name, overwrite=True) as stage:
            stage.write_text(json.dumps(outcome), encoding="utf-8")
        outcomes[item.name] = outcome
        report(count / total)
    return Batch(tuple(items), outcomes, total)


def _here(items: Sequence[Item], workers: int) -> Iterator[tuple[Item, Outcome]]:
    """On processes of this machine; where one dies, the rest goes on with new ones."""
    if workers == 1:
        yield from ((item, run_item(item)) for item in items)
        return
    waiting, tries = list(reversed(items)), dict.fromkeys(items, 0)
    while waiting:
        running: dict[Future[Outcome], Item] = {}
        with ProcessPoolExecutor(workers) as pool:
            try:
                while waiting or running:
                    while waiting and len(running) < _WINDOW * workers:
                        item = waiting.pop()
                        running[pool.submit(run_item, item)] = item
                    for future in wait(running, return_when=FIRST_COMPLETED).done:
                        outcome = future.result()
                        yield running.pop(future), outcome
            except BrokenProcessPool:
                for item in running.values():
                    tries[item] += 1
                    if tries[item] < _TRIES:
                        waiting.append(item)
                    else:
                        yield item, _lost_worker(item)


def _lost_worker(item: Item) -> Outcome:
    cause = f"its worker died {_TRIES} times (out of memory, or killed)"
    return {**_heading(item), "status": "failed", "reason": cause, "seconds": 0.0}


def _on_dask(
    items: Sequence[Item], workers: int, address: str | None
) -> Iterator[tuple[Item, Outcome]]:
    """On a Dask cluster, which gives the work of a worker that dies to another one."""
    with needed_for("`dask` needs", "dask"):
        distributed: Any = import_module("distributed")
    cluster = None
    if address == "local":
        cluster = distributed.LocalCluster(
            n_workers=workers, threads_per_worker=1, dashboard_address=None
        )
    try:
        client = distributed.Client(cluster or address, timeout=DASK_PATIENCE)
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError(
            f"`dask` must be the address of a scheduler: {one_line(str(error))}"
        ) from None
    try:
        waiting = list(reversed(items))
        several = max(1, len(client.scheduler_info().get("workers", {})))
        first = [waiting.pop() for _ in range(min(_WINDOW * several, len(waiting)))]
        queued = {client.submit(run_item, item, pure=False): item for item in first}
        completed = distributed.as_completed(list(queued))
        for future in completed:
            item = queued.pop(future)
            try:
                outcome = future.result()
            except distributed.KilledWorker:
                outcome = _lost_worker(item)
            future.release()
            if waiting:
                following = waiting.pop()
                submitted = client.submit(run_item, following, pure=False)
                queued[submitted] = following
                completed.add(submitted)
            yield item, outcome
    finally:
        client.close()
        if cluster is not None:
            cluster.close()
