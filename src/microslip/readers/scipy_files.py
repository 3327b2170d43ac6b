"""SciPy's readers of MAT and Matrix Market files, which run in a child process."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from microslip.errors import InputError
from microslip.readers.child import parsed
from microslip.readers.files import allowed_points

_LARGE = 1_000_000
_LARGE_ARRAY = "the shape of a large array"


def variables(path: Path, names: list[str] | None = None) -> dict[str, Any]:
    """Variables of a MAT-file up to version 7 by their names; nested by those of structs.

    Without `names` those that are no large arrays; of a large array its shape as a tuple.
    """
    content = parsed("MAT-file", path, read_mat, libraries=["scipy.io"], names=names)
    return {
        name: tuple(value[_LARGE_ARRAY])
        if isinstance(value, dict) and _LARGE_ARRAY in value
        else value
        for name, value in content.items()
    }


def whole_variables(path: Path) -> dict[str, Any]:
    """All variables, large ones too."""
    content = variables(path)
    large = [name for name, value in content.items() if isinstance(value, tuple)]
    return content | (variables(path, large) if large else {})


def market_matrix(path: Path) -> Any:
    """The matrix of a Matrix Market file."""
    return parsed("Matrix Market file", path, read_market, libraries=["scipy.io"])


# ------------------------------------------------------------------ what runs in the child


def read_mat(path: Path, names: list[str] | None) -> dict[str, Any]:
    """Variables by SciPy."""
    from scipy.io import loadmat, whosmat

    points, file = allowed_points(), str(path)
    sizes = {name: tuple(map(int, size)) for name, size, _ in whosmat(file)}
    large = set[str]()
    if names is None:
        large = {name for name, size in sizes.items() if math.prod(size) > min(points, _LARGE)}
        names = [name for name in sizes if name not in large]
    elif sum(math.prod(sizes[name]) for name in names if name in sizes) > points:
        raise InputError(f"holds more points than `limit={points}`")
    content = loadmat(file, variable_names=names, simplify_cells=True) if names else {}
    by_name = {name: value for name, value in content.items() if not name.startswith("__")}
    for name, value in by_name.items():
        if isinstance(value, np.ndarray) and value.dtype.kind in "iufcb":
            by_name[name] = value.reshape(sizes.get(name, value.shape))
    return {
        name: by_name.get(name, {_LARGE_ARRAY: sizes[name]})
        for name in sizes
        if name in by_name or name in large
    }


def read_market(path: Path) -> Any:
    """A matrix by SciPy, unless it declares too much."""
    from scipy.io import mminfo, mmread

    rows, columns, entries = mminfo(str(path))[:3]
    # A sparse matrix takes memory for each of its columns as well.
    if entries + 10 * max(rows, columns) > (points := allowed_points()):
        raise InputError(
            f"declares {rows} x {columns} with {entries} entries, more than `limit={points}`"
        )
    return mmread(str(path))
