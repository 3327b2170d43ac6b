"""Batches and big sweeps: nothing lost, nothing doubled, and how much faster more workers are.

    python benchmarks/batches.py [--predictions 10000] [--workers 2] [--dask] [--page]

Runs the command `microslip batch` on so many changes to a study, kills it in the middle and starts
it again; with --dask the same on a local Dask cluster of which a worker is killed. --page writes
the table into docs/batches.md. Wall times are those of a machine that may be busy; CPU times hold
on any.
"""

from __future__ import annotations

import argparse
import csv
import os
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
from pages import write_section

_EXAMPLE = Path(__file__).parents[1] / "examples" / "al2017.toml"
AMPLITUDES = '[excitation]\namplitudes = ["0.1 um", "1 um"]\n'


def table(folder: Path, count: int) -> Path:
    """So many changes to the study."""
    rng = np.random.default_rng(0)
    path = folder / "changes.csv"
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(["name", "joint.normal_load", "joint.friction_coefficient"])
        for i in range(count):
            load, mu = 2e3 * rng.lognormal(0.0, 0.3), rng.uniform(0.2, 0.8)
            rows.writerow([f"p{i:05d}", f"{load:.6g} N", f"{mu:.4f}"])
    return path


def command(*words: str) -> list[str]:
    """The command line of this package."""
    return [sys.executable, "-m", "microslip", "batch", *words]


def outcome_of(folder: Path, count: int) -> str:
    """One outcome an item, and one row block each in the table over all."""
    outcomes = kept_in(folder / "items")
    with (folder / "items.csv").open(encoding="utf-8") as file:
        names = [row[0] for row in csv.reader(file)][1:]
    different = len(set(names))
    right = outcomes == different == count
    return f"{outcomes:,} outcomes, {different:,} items in the table: " + (
        "none lost, none doubled" if right else "WRONG"
    )


def kept_in(items: Path) -> int:
    """Outcomes that are there."""
    return sum(1 for _ in items.glob("*.json"))


def interrupted(words: list[str], folder: Path, share: float, count: int) -> None:
    """Run, kill in the middle, run again."""
    process = subprocess.Popen(command(*words), stdout=subprocess.DEVNULL, start_new_session=True)
    items = folder / "items"
    while process.poll() is None:
        if items.is_dir() and kept_in(items) > share * count:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            print(f"  killed with {kept_in(items)} outcomes kept")
            break
        time.sleep(0.05)
    subprocess.run(command(*words), check=True, stdout=subprocess.DEVNULL)


def on_dask(words: list[str], folder: Path, count: int) -> None:
    """A scheduler and two workers, of which one is killed in the middle."""
    from distributed import LocalCluster

    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        victim = next(iter(cluster.workers.values())).pid
        items = folder / "items"

        def kill() -> None:
            while not (items.is_dir() and kept_in(items) > 0.3 * count):
                time.sleep(0.02)
            os.kill(victim, signal.SIGKILL)
            print("  killed a worker")

        thread = threading.Thread(target=kill, daemon=True)
        thread.start()
        address = cluster.scheduler_address
        subprocess.run(command(*words, "--dask", address), check=True, stdout=subprocess.DEVNULL)


def speed_up(folder: Path, study: list[str], workers: int, count: int) -> tuple[str, str]:
    """Wall times of one process over those of several, in turns: others may use the machine."""
    here = folder / "turns"
    here.mkdir()
    changes, times = table(here, count), {1: [], workers: []}
    for turn in range(5):
        for number, seconds in times.items():
            words = [str(changes), *study, "-o", str(here / f"{turn}-{number}")]
            begin = time.perf_counter()
            subprocess.run(
                command(*words, "--workers", str(number)), check=True, stdout=subprocess.DEVNULL
            )
            seconds.append(time.perf_counter() - begin)
    ratios = np.sort(np.array(times[1]) / np.array(times[workers]))
    return (
        f"{count:,} predictions five times, with 1 and {workers} processes in turns",
        f"{workers} are {ratios[2]:.2f} times as fast as one ({ratios[0]:.2f} to {ratios[-1]:.2f})",
    )


class Report:
    """Rows of the table, each told at once, with wall and CPU times of all processes."""

    def __init__(self) -> None:
        self.rows: list[tuple[str, str, str, str]] = []
        self.begin()

    def begin(self) -> None:
        """Start the clocks."""
        self.wall, self.cpu = time.perf_counter(), self._children()

    @staticmethod
    def _children() -> float:
        spent = resource.getrusage(resource.RUSAGE_CHILDREN)
        return spent.ru_utime + spent.ru_stime

    def add(self, task: str, outcome: str, *, has_cpu: bool = True) -> float:
        """Close a row; its wall time."""
        wall, cpu = time.perf_counter() - self.wall, self._children() - self.cpu
        row = (task, f"{wall:.3g} s", f"{cpu:.3g} s" if has_cpu else "", outcome)
        self.rows.append(row)
        print(" | ".join(row), flush=True)
        return wall

    def page(self) -> None:
        """Write the table into its page."""
        rows = [("what", "wall", "CPU", "outcome"), ("---", "---:", "---:", "---"), *self.rows]
        text = "\n".join(f"| {' | '.join(row)} |" for row in rows)
        write_section("batches.md", "batches", "batches.py", text)


def main() -> None:
    """Print what was found."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--predictions", type=int, default=10_000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--dask", action="store_true")
    parser.add_argument("--page", action="store_true", help="write the table into docs/batches.md")
    options = parser.parse_args()
    report = Report()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        joint = _EXAMPLE.read_text(encoding="utf-8").partition("[excitation]")[0]
        (folder / "study.toml").write_text(joint + AMPLITUDES, encoding="utf-8")
        study = ["--study", str(folder / "study.toml")]
        changes, count = table(folder, options.predictions), options.predictions
        predictions = f"{count:,} predictions"
        for workers in (1, options.workers):
            out = folder / f"once-{workers}"
            words = [str(changes), *study, "-o", str(out), "--workers", str(workers)]
            report.begin()
            subprocess.run(command(*words), check=True, stdout=subprocess.DEVNULL)
            process = "process" if workers == 1 else "processes"
            report.add(f"{predictions}, {workers} {process}", outcome_of(out, count))
        report.begin()
        report.add(*speed_up(folder, study, options.workers, max(50, count // 10)))
        out, parallel = folder / "killed", ["--workers", str(options.workers)]
        report.begin()
        interrupted([str(changes), *study, "-o", str(out), *parallel], out, 0.4, count)
        report.add(f"{predictions}, the command killed at 40 % and started again",
                   outcome_of(out, count))  # fmt: skip
        if options.dask:
            out = folder / "dask"
            report.begin()
            on_dask([str(changes), *study, "-o", str(out)], out, count)
            report.add(f"{predictions}, on a local Dask cluster of two whose worker was killed at "
                       "30 %", outcome_of(out, count), has_cpu=False)  # fmt: skip
    if options.page:
        report.page()


if __name__ == "__main__":
    main()
