"""MATLAB's files: version 4 to 7 by SciPy, version 7.3 by h5py, structs included."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from microslip.tribometer.readers.arrays import Leaf, is_number, table
from microslip.tribometer.readers.base import Reader, Table, first_line

# MATLAB keeps tables, time tables and timeseries in a form of its own, which nobody else reads.
_ADVICE = 'save vectors, or of a table T the struct S = table2struct(T, "ToScalar", true)'


def _described(kind: str, tree: Mapping[str, Any]) -> Table:
    try:
        return table(kind, tree, ".")
    except ValueError as error:
        raise ValueError(f"{error}; {_ADVICE}") from None


class Mat(Reader):
    """Version 4 to 7."""

    name = "mat"

    def knows(self, head: bytes, suffix: str) -> bool:
        """By its header; version 4 has none."""
        return head.startswith(b"MATLAB 5.0 MAT-file") or (suffix == ".mat" and b"\0" in head[:128])

    def open(self, path: Path) -> Table:
        """Variables, and fields of structs as "data.force"."""
        from scipy.io import loadmat

        try:
            with path.open("rb") as raw:
                content = loadmat(raw, simplify_cells=True)
        except MemoryError:
            raise
        except Exception as error:  # SciPy raises many kinds on what is no MAT-file
            raise ValueError(f"not a usable MAT-file: {first_line(error)}") from None
        tree = {name: _node(value) for name, value in content.items() if name[:2] != "__"}
        return _described("MAT-file", tree)


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


class Mat73(Reader):
    """Version 7.3, which is HDF5 with habits of its own."""

    name = "mat"

    def knows(self, head: bytes, suffix: str) -> bool:
        """By its header."""
        return head.startswith(b"MATLAB 7.3 MAT-file")

    def open(self, path: Path) -> Table:
        """Variables, and fields of structs as "data.force"."""
        import h5py

        try:
            with h5py.File(path, "r") as file:
                tree = {
                    name: _hdf_node(path, file, item)
                    for name, item in file.items()
                    if not name.startswith("#")
                }
        except OSError as error:
            raise ValueError(f"not a usable MAT-file: {first_line(error)}") from None
        return _described("MAT-file of version 7.3", tree)


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
    where = item.name

    def get() -> Any:
        with h5py.File(path, "r") as again:
            return again[where][()]

    return Leaf(item.shape, get)
