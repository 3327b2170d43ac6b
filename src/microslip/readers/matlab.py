"""MATLAB's files: version 4 to 7 by SciPy, version 7.3 by h5py, structs included."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from microslip._core.files import sparse_of_either_kind
from microslip._core.packages import needed_for
from microslip.readers.arrays import Arrays, Leaf, is_number
from microslip.readers.files import decoded
from microslip.readers.hdf5 import values_at

# MATLAB keeps tables, time tables and timeseries in a form of its own, which nobody else reads.
_ADVICE = 'save vectors, or of a table T the struct S = table2struct(T, "ToScalar", true)'
_NUMBERS = {"double", "single"} | {f"{sign}int{n}" for sign in ("", "u") for n in (8, 16, 32, 64)}


def read_arrays(path: Path) -> Arrays:
    """Variables, and fields of structs as "data.force"; arrays are not read yet."""
    with path.open("rb") as file:
        new = file.read(19) == b"MATLAB 7.3 MAT-file"
    if not new:
        return Arrays("MAT-file", _tree(path), ".", _ADVICE)
    with needed_for("MAT-files of version 7.3 are read by"):
        import h5py

    with decoded("MAT-file"), h5py.File(path, "r") as file:
        tree = {
            name: _hdf_node(path, file, item)
            for name, item in file.items()
            if not name.startswith("#")
        }
    return Arrays("MAT-file of version 7.3", tree, ".", _ADVICE)


def _by_scipy(path: Path, action: Callable[[Any], Any]) -> Any:
    with decoded("MAT-file"), path.open("rb") as file, sparse_of_either_kind():
        return action(file)


def _tree(path: Path) -> dict[str, Any]:
    """Arrays by their sizes only; structs, texts and single numbers as they are."""
    from scipy.io import loadmat, whosmat

    sizes = {name: (tuple(size), kind) for name, size, kind in _by_scipy(path, whosmat)}
    tree: dict[str, Any] = {
        name: Leaf(size, partial(_variable, path, name))
        for name, (size, kind) in sizes.items()
        if kind in _NUMBERS and math.prod(size) != 1
    }
    composite = [name for name in sizes if name not in tree]
    if composite:
        content = _by_scipy(path, partial(loadmat, variable_names=composite, simplify_cells=True))
        tree |= {name: _node(content[name]) for name in composite if name in content}
    return {name: tree[name] for name in sizes if name in tree}


def _variable(path: Path, name: str) -> Any:
    from scipy.io import loadmat

    return _by_scipy(path, partial(loadmat, variable_names=[name]))[name]


def _node(value: Any) -> Any:
    """What SciPy made of a variable, as a tree."""
    if isinstance(value, dict):
        return {str(key): _node(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_node(item) for item in value]
    if isinstance(value, np.ndarray):
        if value.dtype == object:
            return [_node(item) for item in value.flat]
        if value.dtype.kind in "iuf":
            return value.item() if value.size == 1 else Leaf(value.shape, lambda: value)
        return None
    return value if isinstance(value, str) or is_number(value) else None


def _hdf_node(path: Path, file: Any, item: Any) -> Any:
    """A variable of version 7.3 as a tree; arrays of structs are references to elsewhere."""
    import h5py

    if isinstance(item, h5py.Group):
        fields = {name: _hdf_node(path, file, below) for name, below in item.items()}
        lists = {name: node for name, node in fields.items() if isinstance(node, list)}
        if lists and len(lists) == len(fields) and len({*map(len, lists.values())}) == 1:
            rows = zip(*lists.values(), strict=True)
            return [dict(zip(lists, row, strict=True)) for row in rows]
        return fields
    if item.attrs.get("MATLAB_empty", 0):
        return None
    if item.dtype == h5py.ref_dtype:
        return [_hdf_node(path, file, file[ref]) for ref in np.ravel(item[()])]
    if item.attrs.get("MATLAB_class", b"") == b"char":
        return "".join(map(chr, np.ravel(item[()])))
    if item.dtype.kind not in "iuf" or not item.size:
        return None
    if item.size == 1:
        return np.ravel(item[()])[0].item()
    # MATLAB's order is the other one.
    return Leaf(item.shape[::-1], partial(_hdf_values, path, item.name))


def _hdf_values(path: Path, where: str) -> Any:
    return values_at(path, where).T
