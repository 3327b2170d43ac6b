"""How the tests run the command, and the study that they run it on."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from click.testing import CliRunner, Result
from studies import LOADS, edited

from microslip.cli import main

STUDY = edited(
    ("A joint", "A [bold] joint"),
    ("poisson_ratio = 0.33", 'poisson_ratio = 0.33\nhardness = "1.2 GPa"'),
    (LOADS, '"2 kN"'),
    ('["csv"]', '["csv"]\nreport = false'),
)


def run(*arguments: str) -> Result:
    return CliRunner().invoke(main, arguments, prog_name="microslip")


def names() -> list[str]:
    return sorted(path.name for path in Path.cwd().iterdir())


def fails(*arguments: str, code: int = 2) -> str:
    """The one line on standard error of a command that fails and leaves no trace."""
    before = names()
    outcome = run(*arguments)
    assert outcome.exit_code == code, outcome.output
    assert outcome.stdout == ""
    assert outcome.stderr.count("\n") == 1
    assert names() == before
    return outcome.stderr.rstrip("\n")


def process(
    *arguments: str,
    stdout: Any = subprocess.PIPE,
    stderr: Any = subprocess.PIPE,
    **environment: str,
) -> subprocess.CompletedProcess[bytes]:
    """The command as a process of its own."""
    return subprocess.run(
        [sys.executable, "-m", "microslip", *arguments],
        stdout=stdout,
        stderr=stderr,
        env={**os.environ, "PYTHONUTF8": "0", "PYTHONIOENCODING": "utf-8", **environment},
        check=False,
    )
