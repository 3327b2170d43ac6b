"""MATLAB files, version 4 to 7 by SciPy and 7.3 by h5py."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from microslip.readers.arrays import Arrays, arrays_in
from microslip.readers.child import parsed
from microslip.readers.files import refuse_beyond
from microslip.readers.hdf5 import group_members, leaf_of, opened, stored_arrays

# MATLAB stores tables, timetables and timeseries in an undocumented form.
_ADVICE = 'save vectors, or for a table T the struct S = table2struct(T, "ToScalar", true)'


def read_matlab(path: Path) -> Arrays:
    """Return the variables of a MAT-file; struct fields have names such as "data.force"."""
    with path.open("rb") as file:
        new = file.read(19) == b"MATLAB 7.3 MAT-file"
    if not new:
        content = parsed("MAT-file", path, read_mat, libraries=["scipy.io"])
        return Arrays("MAT-file", arrays_in(content), ".", _ADVICE)
    return Arrays(
        "MAT-file of version 7.3", stored_arrays(path, "MAT-file", read_new), ".", _ADVICE
    )


# ------------------------------------------------------------------ what runs in the child


def read_mat(path: Path) -> dict[str, Any]:
    """Read the variables of a MAT-file with SciPy, unless they are more numbers than the limit."""
    from scipy.io import loadmat, whosmat

    refuse_beyond(sum(math.prod(map(int, size)) for _, size, _ in whosmat(str(path))))
    content = loadmat(str(path), simplify_cells=True)
    return {name: value for name, value in content.items() if not name.startswith("__")}


def read_new(path: Path) -> Any:
    """Read variables of a MAT-file of version 7.3 (HDF5), in the child process."""
    with opened(path) as file:
        return {name: _hdf_node(file, item) for name, item in group_members(file, skip="#")}


def _hdf_node(file: Any, item: Any) -> Any:
    import h5py

    if isinstance(item, h5py.Group):
        fields = {name: _hdf_node(file, below) for name, below in group_members(item)}
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
