"""Measure the CPU time of the commands, start to end, beside that of another commit.

    python benchmarks/commands.py                     the commands of this environment
    python benchmarks/commands.py --against MICROSLIP and those of another one, in turns
    python benchmarks/commands.py ... --page        and the table in docs/timings.md

MICROSLIP is the command of another environment, such as one made from commit b048829, before
results were told once. Commands of both run one after the other, several times; the best of each
counts. Files are written as each version does by default.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from pages import write_section
from rough_faces import rough

RIG = "record.csv"

MAKE_INPUT = """
import microslip as ms
al = ms.Material(young_modulus=69e9, poisson_ratio=0.33)
surface = ms.GreenwoodWilliamson(
    ms.MaterialPair(al, al), ms.Gaussian(std=5e-7), radius=1e-3, density=1e8, area=2e-4
)
joint = ms.Interface(surface, 0.55, normal_load=2000.0)
noise = {"force": 1.0, "displacement": 1e-9}
rig = ms.VirtualTribometer(joint, noise=noise, seed=0)
rig.record(amplitude=1e-6, frequency=10.0, cycles=12).to_csv("record.csv")
"""
COMMANDS = {
    "predict, three loads": ("predict", "joint.toml", "-o", "predicted"),
    "measure, one record": ("measure", RIG, "-o", "measured"),
    "identify, one record": ("identify", RIG, "-o", "identified"),
    "surface, 256 by 256 points": (
        *("surface", "scan.npy", "--pixel", "1 um", "--unit", "m"),
        *("--cutoff", "4 um", "-o", "scanned"),
    ),
}


def cpu_time(command: str, words: tuple[str, ...], folder: Path) -> float:
    """CPU seconds of one run of a command, that of its children included."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    # The first run compiles, as after an installation; the best is of the others.
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    process = subprocess.run(
        [command, *words, "--overwrite"],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
    )
    if process.returncode:
        raise SystemExit(f"{command} {' '.join(words)}: {process.stderr}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def table(commands: list[str], repeats: int) -> list[str]:
    """Rows of the table: CPU time of each command, and its share of that of the other."""
    rows = ["| command | CPU time | of that before | wanted |", "| --- | ---: | ---: | ---: |"]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        python = Path(commands[-1]).with_name("python")
        subprocess.run([str(python), "-c", MAKE_INPUT], cwd=folder, check=True)
        scan = rough(256, 1e-6, 5e-7, longest=1.64e-4, shortest=2.1e-5, seed=0)
        np.save(folder / "scan.npy", scan)
        text = (Path(__file__).parents[1] / "examples" / "al2017.toml").read_text("utf-8")
        # What is written by default: before, pixels as well.
        (folder / "joint.toml").write_text(text[: text.index("[output]")], encoding="utf-8")
        for label, words in COMMANDS.items():
            best = [float("inf")] * len(commands)
            for _ in range(repeats):
                for number, command in enumerate(commands):
                    best[number] = min(best[number], cpu_time(command, words, folder))
            share = f"{best[0] / best[1]:.2f}" if len(best) > 1 else ""
            command, _, detail = label.partition(",")
            rows.append(f"| `{command}`,{detail} | {best[0]:.2f} s | {share} | ≤ 0.33 |")
            print(rows[-1], flush=True)
    return rows


def main() -> None:
    """Measure, print, and write into the page what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--against", help="command of another environment")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--page", action="store_true")
    options = parser.parse_args()
    here = str(Path(sys.executable).with_name("microslip"))
    rows = table([here, *([options.against] if options.against else [])], options.repeats)
    if options.page:
        write_section("timings.md", "commands", "commands.py", "\n".join(rows))


if __name__ == "__main__":
    main()
