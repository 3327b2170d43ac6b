"""Exported C, compiled and run."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from usual import JOINT

import microslip as ms
from microslip import export

COMPILER = shutil.which(os.environ.get("CC", "cc"))
# "CC=false" stands for a machine that has none.
needs_compiler = pytest.mark.skipif(
    COMPILER is None or COMPILER.endswith("false"), reason="no C compiler"
)
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O2")


def records(scale: float, samples: int, seed: int = 0) -> dict[str, np.ndarray]:
    """A sine, noise, a random walk, reversals on few places, and ties of equal size."""
    rng = np.random.default_rng(seed)
    t = np.arange(samples)
    return {
        "sine": scale * (1.0 + 0.5 * np.sin(t / 9e3)) * np.sin(t / 37.3),
        "noise": scale * rng.standard_normal(samples),
        "walk": scale * 0.02 * np.cumsum(rng.standard_normal(samples)),
        "reversals": scale * 0.25 * rng.integers(-8, 9, samples),
        "ties": scale * np.array([1.0, -1.0, 0.5, -0.5, 0.5, 1.0, 1.0, -1.0, 0.0])[t % 9],
    }


# Any element by arrays, each step through save and restore: forces, tangents, energies, bound.
DRIVER = """
long NAME_go(const double *u, double *f, double *k, double *told, long n)
{
    static NAME_state s, t;
    double numbers[NAME_SAVED], far[3];
    enum { C = NAME_COMPONENTS, T = NAME_TANGENTIAL };
    long limited = 0;
    NAME_start(&s);
    for (long i = 0; i < n; i++) {
        for (int c = 0; c < C; c++) far[c] = (c < T ? 2.0 : 1.0) * u[C * (n - 1 - i) + c];
        if (NAME_move(&s, far, NULL, NULL) < 0) return -1; /* a trial that is thrown away */
        if (i % 3 == 0) NAME_rollback(&s);
        int answer = NAME_move(&s, u + C * i, f + C * i, k + C * C * i);
        if (answer < 0) return -2;
        limited += answer;
        NAME_copy(&s, &t);
        if (NAME_commit(&t) < 0) return -3;
        NAME_save(&t, numbers);
        if (NAME_restore(&s, numbers) < 0) return -4;
        told[3 * i] = NAME_dissipated(&s);
        told[3 * i + 1] = NAME_stored(&s);
        told[3 * i + 2] = NAME_error(&s);
    }
    return limited;
}
"""


def library_of(folder: Path, *flags: str, main: str = "", **elements: dict[str, object]) -> Path:
    """Elements of the joint by their names, with what they are written with, in one library."""
    source = "#include <stddef.h>\n"
    for name, options in elements.items():
        export.write("c", options.pop("law", JOINT), folder / f"{name}.c", name=name, **options)
        source += f'#include "{name}.c"\n' + DRIVER.replace("NAME", name)
    (folder / "all.c").write_text(source + main)
    product = folder / ("main" if main else "all.so")
    kind = [] if main else ["-shared", "-fPIC"]
    command = [str(COMPILER), *STRICT, *flags, *kind, "-o", str(product), "all.c", "-lm"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return product


def compiled(laws: Sequence[ms.BackboneLaw], folder: Path, depth: int) -> ctypes.CDLL:
    """All laws, named joint0, joint1, ..., in one library."""
    elements = {f"joint{i}": {"law": law, "depth": depth} for i, law in enumerate(laws)}
    return ctypes.CDLL(str(library_of(folder, **elements)))


def run(library: ctypes.CDLL, index: int, x: np.ndarray) -> tuple[np.ndarray, ...]:
    """Forces, stiffnesses and told errors along a record, and how often the depth was too small."""
    force, stiffness, told, limited = go(library, f"joint{index}", x)
    return force[:, 0], stiffness[:, 0, 0], told[:, 2], limited


def go(library: ctypes.CDLL, name: str, u: np.ndarray) -> tuple[np.ndarray, ...]:
    """Forces, tangents, (dissipated, stored, bound) and how often the memory was too small."""
    u = np.ascontiguousarray(u.reshape(len(u), -1), dtype=float)
    n, c = u.shape
    out = np.empty((n, c)), np.empty((n, c, c)), np.empty((n, 3))
    function = getattr(library, f"{name}_go")
    function.restype = ctypes.c_long
    pointers = (ctypes.c_void_p(array.ctypes.data) for array in (u, *out))
    limited = function(*pointers, ctypes.c_long(n))
    assert limited >= 0, limited
    return (*out, limited)
