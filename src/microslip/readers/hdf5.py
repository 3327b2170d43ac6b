"""HDF5: data sets, tables of several fields, and netCDF-4 with them."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from microslip._core.packages import needed_for
from microslip.readers.arrays import Arrays, Leaf, is_number, rate_by
from microslip.readers.files import decoded


def read_arrays(path: Path) -> Arrays:
    """Data sets by their paths, such as "run1/force"; units from their attribute "units"."""
    with needed_for("HDF5 files are read by"):
        import h5py

    with decoded("HDF5 file"), h5py.File(path, "r") as file:
        return Arrays("HDF5 file", _node(path, file, set()), "/")


def _node(path: Path, item: Any, visited: set[int]) -> Any:
    """A group as a tree, a data set as numbers; groups that hold themselves are met once."""
    import h5py

    if isinstance(item, h5py.Group):
        address = h5py.h5o.get_info(item.id).addr
        if address in visited:
            return None
        visited.add(address)
        tree = {name: _attribute(value) for name, value in item.attrs.items()}
        # A link may lead nowhere, or out of the file.
        links = {name: item.get(name) for name in item}
        return tree | {name: _node(path, below, visited) for name, below in links.items() if below}
    where, fields = item.name, item.dtype.names
    if fields:
        plain = [name for name in fields if item.dtype[name].kind in "iuf"]
        return {name: Leaf(item.shape, partial(values_at, path, where, name)) for name in plain}
    if item.dtype.kind not in "iuf" or not item.shape:
        return _attribute(item[()]) if item.shape == () else None
    about = {name.casefold(): _attribute(value) for name, value in item.attrs.items()}
    unit = about.get("units", about.get("unit"))
    rate = next(filter(None, (rate_by(name, value) for name, value in about.items())), None)
    return Leaf(
        item.shape,
        partial(values_at, path, where),
        unit if isinstance(unit, str) else None,
        rate.value if rate else None,
    )


def values_at(path: Path, where: str, field: str | None = None) -> Any:
    """Values of a data set, or of one field of a table."""
    import h5py

    with h5py.File(path, "r") as file:
        return file[where][()] if field is None else file[where][field]


def _attribute(value: Any) -> Any:
    """A text or a number, or None."""
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.flat[0]
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    return value if isinstance(value, str) or is_number(value) else None
