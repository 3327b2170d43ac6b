"""Files from strangers: nothing of another file, no crash, and no more memory than was declared."""

from __future__ import annotations

import io
import re
import signal
import struct
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from laps import small_joint
from scipy import sparse
from scipy.io import savemat

import microslip as ms
from microslip.readers import arrays, child, hdf5, text

h5py = pytest.importorskip("h5py")
TIME = np.linspace(0.0, 1.0, 400)
MOTION = 1e-5 * np.sin(40.0 * TIME)
FORCE = 50.0 * np.sign(np.gradient(MOTION))
UNITS: Any = {"units": {"displacement": "m", "force": "N", "time": "s"}}


@pytest.fixture(autouse=True)
def elsewhere(here: Path) -> None:
    with h5py.File("other.h5", "w") as file:
        file["displacement"] = np.arange(5.0) + 100.0
        file["group/x"] = np.arange(3.0)


def external(file: Any) -> None:
    file["displacement"] = np.arange(5.0)
    file["run2/displacement"] = h5py.ExternalLink("other.h5", "/displacement")


def through(file: Any) -> None:
    file["a/soft"] = h5py.SoftLink("/b/group/x")
    file["b"] = h5py.ExternalLink("other.h5", "/")


def raw(file: Any) -> None:
    file.create_dataset("x", (5,), dtype="f8", external=[("other.h5", 0, 40)])


def virtual(file: Any) -> None:
    layout = h5py.VirtualLayout((5,), dtype="f8")
    layout[:] = h5py.VirtualSource("other.h5", "displacement", (5,))
    file.create_virtual_dataset("x", layout)


@pytest.mark.parametrize("write", [external, through, raw, virtual])
def test_nothing_of_another_file_is_read(write: Callable[[Any], None]) -> None:
    with h5py.File("main.h5", "w") as file:
        write(file)
    for read in (ms.Record.read, ms.Scan.read):
        with pytest.raises(ms.InputError, match=r"is stored in another file, \"other.h5\""):
            read("main.h5")


def test_links_within_a_file_are_followed() -> None:
    with h5py.File("main.h5", "w") as file:
        file["a"], file["group/b"] = np.arange(5.0), np.arange(6.0)
        file["group/link"] = h5py.SoftLink("/a")
        file["hard"], file["group/up"] = file["a"], h5py.SoftLink("/")
        file["nowhere"] = h5py.SoftLink("/nothing")
        layout = h5py.VirtualLayout((5,), dtype="f8")
        layout[:] = h5py.VirtualSource(".", "a", (5,))
        file.create_virtual_dataset("view", layout)
    named = arrays.leaves(hdf5.read_hdf5(Path("main.h5")))
    assert {name: leaf.shape[0] for name, leaf in named.items()} == {
        "a": 5,
        "group/b": 6,
        "group/link": 5,
        "hard": 5,
        "view": 5,
    }
    for name in ("group/link", "hard", "view"):
        np.testing.assert_array_equal(named[name].get(), np.arange(5.0))


def unsound() -> list[Any]:
    by_columns = sparse.csc_matrix(np.eye(6))
    by_columns.indices[2] = 10**8
    pointers = sparse.csr_matrix(np.eye(6))
    pointers.indptr[3] = 10**7
    places = sparse.coo_matrix(np.eye(6))
    places.row[1] = -5
    rows = sparse.lil_matrix(np.eye(6))
    rows.rows[2] = [77]
    return [by_columns, pointers, places, rows]


@pytest.mark.parametrize("at", range(4))
def test_sparse_matrices_with_indices_outside_are_refused(at: int) -> None:
    with pytest.raises(ms.InputError, match="valid sparse matrix"):
        ms.Structure(np.eye(6), unsound()[at])


def test_the_death_of_a_reader_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    savemat("x.mat", {"time": TIME, "displacement": MOTION, "force": FORCE})
    died = ((-signal.SIGSEGV, ".*SIGSEGV"), (-signal.SIGXCPU, ".*10 s"), (None, ""))
    for status, words in died:
        with monkeypatch.context() as patch:
            patch.setattr(child._server, "run", lambda _, status=status: status)
            with pytest.raises(ms.InputError, match=rf"^x.mat: not a usable MAT-file: {words}"):
                ms.Record.read("x.mat", **UNITS)
    child._server.run({"seconds": 0.1})  # breaks it
    assert ms.Record.read("x.mat", **UNITS).force.size == TIME.size


def hdf5_bomb() -> str:
    with h5py.File("bomb.h5", "w") as file:
        for name in ("time", "displacement", "force"):
            options = {"chunks": (1_000_000,), "compression": "gzip"}
            file.create_dataset(name, (150_000_000,), dtype="f8", **options)
        file.create_dataset("note", (), dtype="S1500000000")
    return "bomb.h5"


def npz_bomb() -> str:
    with zipfile.ZipFile("bomb.npz", "w") as archive:
        for name in ("time", "displacement", "force", "M", "K"):
            header = io.BytesIO()
            np.lib.format.write_array_header_1_0(
                header, {"descr": "<f8", "fortran_order": False, "shape": (500_000_000,)}
            )
            with archive.open(f"{name}.npy", "w") as entry:
                entry.write(header.getvalue())
    return "bomb.npz"


def mat_bomb() -> str:
    """A version 5 file of columns of 600 million compressed zeros, cut after the first part."""
    import zlib

    count = 600_000_000
    flags = struct.pack("<IIII", 6, 8, 6, 0)
    size = struct.pack("<IIii", 5, 8, count, 1)
    data = struct.pack("<II", 9, 2**32 - 1)
    file = b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<HH", 0x0100, 0x4D49)
    for word in (b"time", b"x", b"F"):
        name = struct.pack("<II", 1, len(word)) + word.ljust(8, b"\0")
        body = flags + size + name + data + bytes(10_000_000)
        packed = zlib.compress(struct.pack("<II", 14, 2**32 - 9) + body)
        file += struct.pack("<II", 15, len(packed)) + packed
    Path("bomb.mat").write_bytes(file)
    return "bomb.mat"


def text_bomb() -> str:
    """Cells without numbers, for a closer look at every row, and the last is wrong."""
    rows = "1,2,-\n" * 3_800_000 + "1,2,x\n"
    Path("bomb.csv").write_text(f"time,displacement,force\n1,2,3\n{rows}")
    return "bomb.csv"


def line_bomb() -> str:
    Path("bomb.csv").write_text("0 " * 30_000_000)
    return "bomb.csv"


BOMBS = {
    "text": text_bomb,
    "line": line_bomb,
    "hdf5": hdf5_bomb,
    "npz": npz_bomb,
    "mat": mat_bomb,
}


@pytest.mark.parametrize(
    "kinds",
    [[k for k in BOMBS if k != "text"], pytest.param(["text"], marks=pytest.mark.slow)],
    ids=["quick", "text"],
)
def test_files_that_declare_too_much_are_refused_before_reading(kinds: list[str]) -> None:
    """In less than 2 GB, and in 2 s but for a text whose last of 3.8 million lines is wrong."""
    pytest.importorskip("resource")
    seconds = 60 if kinds == ["text"] else 20
    script = (
        "import resource, microslip as ms, h5py, scipy.sparse\n"
        "resource.setrlimit(resource.RLIMIT_AS, (2_000_000_000,) * 2)\n"
        f"resource.setrlimit(resource.RLIMIT_CPU, ({seconds}, {seconds}))\n"
    )
    for kind in kinds:
        script += (
            f"try: ms.Record.read({BOMBS[kind]()!r}, **{UNITS!r})\n"
            "except ms.InputError as error: print(error)\n"
        )
    run = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False, timeout=120
    )
    assert run.returncode == 0, run.stderr
    said = run.stdout.splitlines()
    assert len(said) == len(kinds)
    for line in said:
        assert re.search('limit|not a usable|too large|a number, got "x"|lines of numbers', line)


def test_the_limit_is_the_users() -> None:
    np.savez("run.npz", time=TIME, displacement=MOTION, force=FORCE)
    with pytest.raises(ms.InputError, match="contains 1200 points"):
        ms.Record.read("run.npz", **UNITS, limit=1000)
    assert ms.Record.read("run.npz", **UNITS, limit=1200).force.size == TIME.size
    small_joint().save(Path("reduced.npz"))
    with pytest.raises(ms.InputError, match="more than limit=100"):
        ms.ReducedJoint.load("reduced.npz", limit=100)
    with pytest.raises(ms.InputError, match="limit must be a number of points"):
        ms.Record.read("run.npz", **UNITS, limit=0)


@pytest.mark.parametrize("size", [1, 7, 60])
def test_texts_are_read_alike_in_blocks_of_any_size(
    size: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Against what stands in the cells, written out by hand."""
    rows = ["1,2", '"3","4e1"', "", "# a remark", "-,5", "6,\N{MINUS SIGN}7", '8,"9"', ",", "1,"]
    Path("run.csv").write_text("\n".join(["a,b", *rows * 3, "7"]), encoding="utf-8")
    monkeypatch.setattr(text, "_BLOCK", size)
    nan = np.nan
    values = [(1, 2), (3, 40), (nan, 5), (6, -7), (8, 9), (nan, nan), (1, nan)] * 3
    table = text.text_table(Path("run.csv"))
    np.testing.assert_array_equal(np.transpose(table.load([0, 1])), [*values, (nan, nan)])
    assert [table.where(row) for row in (1, 2, 14)] == ["line 3", "line 6", "line 20"]
