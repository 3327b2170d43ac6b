"""Commands that are killed, or whose disk is full at any byte: a whole result or none."""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
from functools import partial
from pathlib import Path

import microslip as ms

from .campaign import Random, Tally, demand
from .seeds import STUDY

SOURCES = str(Path(ms.__file__).parents[1])


def attack_disks(rng: Random, tally: Tally) -> None:
    """One run of ``microslip predict`` that may write so many bytes a file, or so many seconds."""
    if rng.random() < 0.5:
        most = int(10.0 ** rng.uniform(1.0, 6.5))
        tally.attempt(f"a disk full at {most} bytes", partial(ends_well, most, None))
    else:
        after = float(rng.uniform(0.2, 3.0))
        tally.attempt(f"killed after {after:.2f} s", partial(ends_well, None, after))


def ends_well(most: int | None, killed_after: float | None) -> None:
    """The folder holds a whole result or is not there, and the error is one line."""
    with tempfile.TemporaryDirectory() as place:
        study, folder = Path(place, "study.toml"), Path(place, "result")
        study.write_text(STUDY, encoding="utf-8")
        code, errors = predict(study, folder, most, killed_after)
        demand("Traceback" not in errors, errors[-300:])
        if killed_after is None:
            demand(code in (0, 2), f"exit code {code}: {errors[-300:]}")
            demand((code == 0) == folder.exists(), f"exit code {code}, folder {folder.exists()}")
            demand(len(errors.splitlines()) <= 1 or code == 0, errors[-300:])
        if folder.exists():
            json.loads((folder / "summary.json").read_text(encoding="utf-8"))
        left = [path.name for path in Path(place).iterdir() if not path.name.startswith(".")]
        demand(set(left) <= {"study.toml", "result"}, f"left behind: {left}")


def predict(
    study: Path, folder: Path, most: int | None, killed_after: float | None
) -> tuple[int, str]:
    """Exit code and standard error of the command."""

    def limit() -> None:
        if most is not None:
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))

    process = subprocess.Popen(
        [sys.executable, "-m", "microslip", "predict", str(study), "-o", str(folder)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": SOURCES, "PYTHONDONTWRITEBYTECODE": "1"},
        preexec_fn=limit,
    )
    try:
        _, errors = process.communicate(timeout=killed_after)
    except subprocess.TimeoutExpired:
        process.kill()
        _, errors = process.communicate()
    return process.returncode, errors
