"""HDF5: data sets, tables of several fields, and netCDF-4 with them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from microslip.tribometer.readers.arrays import Leaf, is_number, rate_by, table
from microslip.tribometer.readers.base import Reader, Table, first_line


class Hdf5(Reader):
    """Any HDF5 file; units from the attribute "units" or "unit" of a data set."""

    name = "hdf5"

    def knows(self, head: bytes, suffix: str) -> bool:
        """By its first bytes, which may come after a block of the user's."""
        return any(head.startswith(b"\x89HDF\r\n\x1a\n", start) for start in (0, 512))

    def open(self, path: Path) -> Table:
        """Data sets by their paths, such as "run1/force"."""
        import h5py

        try:
            with h5py.File(path, "r") as file:
                tree = _node(path, file, set())
        except OSError as error:
            raise ValueError(f"not a usable HDF5 file: {first_line(error)}") from None
        return table("HDF5 file", tree, "/")


def _node(path: Path, item: Any, seen: set[int]) -> Any:
    """A group as a tree, a data set as numbers; groups that hold themselves are met once."""
    import h5py

    if isinstance(item, h5py.Group):
        address = h5py.h5o.get_info(item.id).addr
        if address in seen:
            return None
        seen.add(address)
        tree = {name: _attribute(value) for name, value in item.attrs.items()}
        # A link may lead nowhere, or out of the file.
        links = {name: item.get(name) for name in item}
        return tree | {name: _node(path, below, seen) for name, below in links.items() if below}
    where, fields = item.name, item.dtype.names
    if fields:
        plain = [name for name in fields if item.dtype[name].kind in "iuf"]
        return {name: Leaf(item.shape, _getter(path, where, name)) for name in plain}
    if item.dtype.kind not in "iuf" or not item.shape:
        return _attribute(item[()]) if item.shape == () else None
    found = {name.casefold(): _attribute(value) for name, value in item.attrs.items()}
    unit = found.get("units", found.get("unit"))
    rate = next(filter(None, (rate_by(name, value) for name, value in found.items())), None)
    return Leaf(
        item.shape,
        _getter(path, where, None),
        unit if isinstance(unit, str) else None,
        rate.value if rate else None,
    )


def _getter(path: Path, where: str, field: str | None) -> Any:
    def get() -> Any:
        import h5py

        with h5py.File(path, "r") as file:
            return file[where][()] if field is None else file[where][field]

    return get


def _attribute(value: Any) -> Any:
    """A text or a number, or None."""
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.flat[0]
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    return value if isinstance(value, str) or is_number(value) else None
