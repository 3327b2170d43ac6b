"""MATLAB's files: version 4 to 7 by SciPy, version 7.3 by h5py, structs included."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from microslip.readers.arrays import Arrays, Leaf, arrays_in
from microslip.readers.files import refuse_beyond
from microslip.readers.hdf5 import leaf_of, members, opened, stored
from microslip.readers.scipy_files import variables

# MATLAB stores tables, time tables and timeseries in a form of its own that is not documented.
_ADVICE = 'save vectors, or of a table T the struct S = table2struct(T, "ToScalar", true)'


def read_arrays(path: Path) -> Arrays:
    """Variables, and fields of structs as "data.force"; large arrays are not read yet."""
    with path.open("rb") as file:
        new = file.read(19) == b"MATLAB 7.3 MAT-file"
    if not new:
        tree = {name: _in_file(path, name, value) for name, value in variables(path).items()}
        return Arrays("MAT-file", tree, ".", _ADVICE)
    return Arrays("MAT-file of version 7.3", stored(path, "MAT-file", read_new), ".", _ADVICE)


def _in_file(path: Path, name: str, value: Any) -> Any:
    """A variable as a tree; a shape alone is that of a large array."""
    if isinstance(value, tuple):
        return Leaf(value, lambda: variables(path, [name])[name])
    return arrays_in(value)


# ------------------------------------------------------------------ what runs in the child


def read_new(path: Path) -> Any:
    """Variables of version 7.3."""
    with opened(path) as file:
        return {name: _hdf_node(file, item) for name, item in members(file, skip="#")}


def _hdf_node(file: Any, item: Any) -> Any:
    """A variable of version 7.3 as a tree; arrays of structs are references to elsewhere."""
    import h5py

    if isinstance(item, h5py.Group):
        fields = {name: _hdf_node(file, below) for name, below in members(item)}
        lists = {name: node for name, node in fields.items() if isinstance(node, list)}
        if lists and len(lists) == len(fields) and len({*map(len, lists.values())}) == 1:
            rows = zip(*lists.values(), strict=True)
            return [dict(zip(lists, row, strict=True)) for row in rows]
        return fields
    if item.attrs.get("MATLAB_empty", 0):
        return None
    if item.dtype == h5py.ref_dtype:
        refuse_beyond(*item.shape)
        return [_hdf_node(file, file[ref]) for ref in np.ravel(item[()])]
    if item.attrs.get("MATLAB_class", b"") == b"char":
        refuse_beyond(*item.shape)
        return "".join(map(chr, np.ravel(item[()])))
    if item.dtype.kind not in "iuf" or not item.size:
        return None
    if item.size == 1:
        return np.ravel(item[()])[0].item()
    return leaf_of(item)
