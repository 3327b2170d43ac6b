"""Studies, records and scans with bytes changed, cut, doubled and put in."""

from __future__ import annotations

import contextlib
import io
import json
import re
import tempfile
import zipfile
from collections.abc import Callable, Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

import h5py
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
        *_binary_seeds(time, motion, force, heights),
    )


def _binary_seeds(
    time: Any, motion: Any, force: Any, heights: Any
) -> Iterator[tuple[str, bytes, Callable[[Path], Any]]]:
    """Sound files of the formats that other libraries write, those that are installed."""
    from scipy import io as scipy_io
    from scipy import sparse

    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        columns = {"time": time, "displacement": motion, "force": force}
        in_micrometres = {
            "displacement": {"unit": "um", "data": motion * 1e6},
            "force": {"unit": "N", "data": force},
            "fs": 100.0,
        }
        scipy_io.savemat(here / "record.mat", in_micrometres)
        scipy_io.savemat(here / "record4.mat", columns, format="4")
        stiffness = sparse.csc_matrix(1e6 * np.array([[2.0, -1.0], [-1.0, 2.0]]))
        scipy_io.savemat(here / "matrices.mat", {"M": np.diag([2.0, 3.0]), "K": stiffness})
        (here / "record.json").write_text(
            json.dumps({
                "displacement [um]": (motion * 1e6).tolist(),
                "force [N]": force.tolist(),
                "sample_rate": 100.0,
            })
        )  # fmt: skip
        with h5py.File(here / "record.h5", "w") as file:
            for name, unit in (("time", "s"), ("displacement", "m"), ("force", "N")):
                file[f"run/{name}"] = columns[name]
                file[f"run/{name}"].attrs["units"] = unit
            file["run/linked"] = h5py.SoftLink("/run/force")
        with h5py.File(here / "scan.h5", "w") as file:
            file["z"] = heights
        parts = {f"K.{name}": getattr(stiffness, name) for name in ("data", "indices", "indptr")}
        shape = np.array(stiffness.shape)
        np.savez(here / "sparse.npz", M=np.diag([2.0, 3.0]), **parts, **{"K.shape": shape})
        with contextlib.suppress(ModuleNotFoundError):
            from nptdms import ChannelObject, TdmsWriter

            with TdmsWriter(here / "record.tdms") as writer:
                writer.write_segment([
                    ChannelObject("run", "displacement", motion * 1e6, {"unit_string": "um"}),
                    ChannelObject("run", "force", force, {"unit_string": "N"}),
                ])  # fmt: skip
        with contextlib.suppress(ModuleNotFoundError):
            import pyarrow
            from pyarrow import parquet

            parquet.write_table(
                pyarrow.table({"displacement [um]": motion * 1e6, "force [N]": force}),
                here / "record.parquet",
            )
        for path in sorted(here.iterdir()):
            read = {
                "scan": _read_scan,
                "record4": _read_arrays,
                "matrices": ms.Structure.load,
                "sparse": ms.Structure.load,
            }
            yield path.name, path.read_bytes(), read.get(path.stem, ms.Record.read)
    yield "market/stiffness.mtx", MARKET, lambda path: ms.Structure.load(path.parent)


def _read_scan(path: Path) -> ms.Scan:
    return ms.Scan.read(path, "hdf5", pixel=1e-6, unit="m")


def _read_arrays(path: Path) -> ms.Record:
    return ms.Record.read(path, units={"time": "s", "displacement": "m", "force": "N"})


_READERS: dict[str, Callable[[Path], Any]] = {
    "scan": _read_scan,
    "record4": _read_arrays,
    "matrices": ms.Structure.load,
    "sparse": ms.Structure.load,
}
MARKET = b"%%MatrixMarket matrix coordinate real symmetric\n2 2 3\n1 1 2e6\n2 1 -1e6\n2 2 2e6\n"


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


def mutant_of(rng: Random, name: str, content: bytes) -> bytes:
    """A changed file; of an archive an entry half of the time, packed again around the change."""
    if not name.endswith(".npz") or rng.integers(2):
        return mutated(rng, content)
    packed = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(content)) as whole, zipfile.ZipFile(packed, "w") as archive:
        names = whole.namelist()
        chosen = names[rng.integers(len(names))]
        for entry in names:
            part = whole.read(entry)
            archive.writestr(entry, mutated(rng, part) if entry == chosen else part)
    return packed.getvalue()


def placed(folder: Path, name: str, content: bytes) -> Path:
    """A file in a folder, and beside it what is read with it."""
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(content)
    if path.suffix == ".mtx":
        (path.parent / "mass.mtx").write_bytes(MARKET)
    return path


def attack_files(rng: Random, tally: Tally) -> None:
    """Twenty mutants of one of the seeds, or two."""
    name, content, read = seeds()[rng.integers(len(seeds()))]
    with tempfile.TemporaryDirectory() as folder:
        path = placed(Path(folder), name, content)
        # A child process parses these, and takes half a second.
        slow = path.suffix in (".mat", ".mtx")
        for _ in range(2 if slow else 20):
            mutant = mutant_of(rng, name, content)
            path.write_bytes(mutant)
            tally.attempt(f"{name} {mutant[:40]!r}… of {len(mutant)}", lambda: read(path))
