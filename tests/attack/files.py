"""Studies, records and scans with bytes changed, cut, doubled and put in."""

from __future__ import annotations

import io
import re
import tempfile
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

import microslip as ms

from .campaign import Random, Tally

TOKENS = (
    b"nan", b"-inf", b"1e999", b"-1", b"0", b"", b'"', b"'''", b"\x00", b"\xff\xfe", b"[[", b"]]",
    b"{", b"}", b"=", b"\n", b"\r", b",", b";", b"\t", b"1" * 400, "µ".encode(), b"a.b.c",
    b"9999-12-31", b"true", b"\x1b[2J", b"<script>", b"=1+1", b"%s", b"../../etc", b"1e-320",
    b"a" * 5000, b"[" * 2000, "\u202e".encode(), b"#", b"mm", b"kN", b"GPa",
)  # fmt: skip

NUMBER = re.compile(rb"\d+(\.\d+)?(e-?\d+)?")
VALUES = (
    b"0", b"1", b"2", b"3", b"7", b"10", b"1e3", b"1e-3", b"0.3", b"1e9", b"1e-12", b"1e30",
    b"-1", b"-0.0", b"1e300", b"1e-300", b"nan", b"inf", b"99999999999999999999", b"1.5.2",
)  # fmt: skip


@lru_cache
def seeds() -> tuple[tuple[str, bytes, Callable[[Path], Any]], ...]:
    """Small sound files and what reads them."""
    time = np.linspace(0.0, 2.0, 200)
    motion = 1e-5 * np.sin(2.0 * np.pi * 3.0 * time)
    force = 50.0 * np.sign(np.gradient(motion)) + 1e5 * motion
    columns = np.column_stack([time, motion * 1e6, force, np.full_like(time, 100.0)])
    text = io.BytesIO()
    np.savetxt(text, columns, delimiter=",", comments="", fmt="%.6g",
               header="time [s],displacement [um],force [N],normal load [N]")  # fmt: skip
    packed = io.BytesIO()
    np.savez(packed, time=time, displacement=motion, force=force)
    heights = np.random.default_rng(1).standard_normal((24, 20)) * 1e-7
    array = io.BytesIO()
    np.save(array, heights)
    grid = io.BytesIO()
    y, x = np.mgrid[:12, :10] * 1e-6
    np.savetxt(grid, np.column_stack([x.ravel(), y.ravel(), heights[:12, :10].ravel()]))
    matrices = io.BytesIO()
    np.savez(matrices, M=np.diag([2.0, 3.0]), K=1e6 * np.array([[2.0, -1.0], [-1.0, 2.0]]))
    return (
        ("study.toml", STUDY.encode(), ms.Study.load),
        ("structure.toml", BEAM.encode(), ms.Study.load),
        ("matrices.npz", matrices.getvalue(), ms.Structure.load),
        ("record.csv", text.getvalue(), ms.Record.read),
        ("record.npz", packed.getvalue(), _read_arrays),
        ("scan.npy", array.getvalue(), lambda path: ms.Scan.read(path, pixel=1e-6, unit="m")),
        ("scan.xyz", grid.getvalue(), lambda path: ms.Scan.read(path, unit="m")),
    )


def _read_arrays(path: Path) -> ms.Record:
    return ms.Record.read(path, units={"time": "s", "displacement": "m", "force": "N"})


STUDY = """schema = 1
title = "A milled joint"

[material.al]
young_modulus = "69 GPa"
poisson_ratio = 0.33
hardness = "1.2 GPa"

[surface]
law = "greenwood-williamson"
materials = ["al", "al"]
radius = "1 mm"
density = "100 1/mm^2"
area = "2 cm^2"
heights = { kind = "gaussian", std = "0.5 um" }

[joint]
friction_coefficient = 0.55
normal_load = ["100 N", "2 kN"]

[excitation]
amplitudes = ["0.1 um", "1 um"]
"""


BEAM = """schema = 1

[surface]
law = "greenwood-williamson"
materials = ["steel", "steel"]
heights = { kind = "gaussian", std = "1 um" }
radius = "1 mm"
density = "50 1/mm^2"
area = "2 cm^2"

[joint]
friction_coefficient = { low = 0.1, high = 0.6 }

[structure]
length = "200 mm"
width = "20 mm"
thickness = "12 mm"
lap = "30 mm"
density = "7800 kg/m^3"
patches = [3, 2]
modes = [1, 3]
amplitude = { from = "0.1 um", to = "10 um", points = 3 }
base_damping_ratio = 0.0005
sensor = { at = ["0.1 m", "0 m", "0 m"], direction = "z" }

[structure.bolts]
positions = ["0 mm"]
shank = "6 mm"
hole = "6.6 mm"
washer = "12 mm"
torque = { mean = "10 N m", cv = 0.15 }
thread = "6 mm"
nut_factor = 0.2
"""


def mutated(rng: Random, content: bytes) -> bytes:
    """One to four changes of a file, half of them of a number in it."""
    for _ in range(int(rng.integers(1, 5))):
        size = len(content)
        at, length = int(rng.integers(size + 1)), int(rng.integers(1, 60))
        kind = rng.integers(12)
        if kind > 5:
            numbers = list(NUMBER.finditer(content))
            if numbers:
                found = numbers[rng.integers(len(numbers))]
                value = VALUES[rng.integers(len(VALUES))]
                content = content[: found.start()] + value + content[found.end() :]
        elif kind == 0 and size:
            at = min(at, size - 1)
            content = content[:at] + bytes([int(rng.integers(256))]) + content[at + 1 :]
        elif kind == 1:
            content = content[:at] + content[at + length :]
        elif kind == 2:
            content = content[: at + length] + content[at:]
        elif kind == 3:
            content = content[:at] + TOKENS[rng.integers(len(TOKENS))] + content[at:]
        elif kind == 4:
            content = content[:at]
        else:
            other = int(rng.integers(size + 1))
            content = content[:at] + content[other : other + length] + content[at:]
    return content


def attack_files(rng: Random, tally: Tally) -> None:
    """Twenty mutants of one of the seeds."""
    name, content, read = seeds()[rng.integers(len(seeds()))]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, name)
        for _ in range(20):
            mutant = mutated(rng, content)
            path.write_bytes(mutant)
            tally.attempt(f"{name} {mutant[:40]!r}… of {len(mutant)}", lambda: read(path))
