"""How the tests run the command, and the study that they run it on."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from click.testing import CliRunner, Result

from microslip.cli import main

STUDY = """\
schema = 1
title = "A [bold] joint"
material.al = { young_modulus = "69 GPa", poisson_ratio = 0.33, hardness = "1.2 GPa" }

[surface]
materials = ["al", "al"]
law = "greenwood-williamson"
heights = { kind = "gaussian", std = "0.5 um" }
radius = "1 mm"
density = "100 1/mm^2"
area = "2 cm^2"

[joint]
friction_coefficient = 0.55
normal_load = "2 kN"

[excitation]
amplitudes = ["0.1 um", "1 um"]
curve = { from = "1 nm", to = "100 um", points = 20 }

[output]
formats = ["csv"]
report = false
"""


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
        [sys.executable, "-m", "microslip.cli", *arguments],
        stdout=stdout,
        stderr=stderr,
        env={**os.environ, "PYTHONUTF8": "0", "PYTHONIOENCODING": "utf-8", **environment},
        check=False,
    )
