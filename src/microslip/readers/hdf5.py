"""HDF5 data sets, structured data sets and netCDF-4; links to other files are rejected.

A child process reads, because a damaged file can put the HDF5 library into an endless loop.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import numpy as np

from microslip._core.errors import InputError
from microslip._core.packages import needed_for
from microslip._core.wording import shorten
from microslip.readers.arrays import Arrays, Leaf, is_numeric, rate_by
from microslip.readers.child import parsed
from microslip.readers.files import refuse_beyond

_LEAF: Final = "a data set"
_TEXT: Final = 1 << 16  # largest size of a text attribute [bytes]


def read_hdf5(path: Path) -> Arrays:
    """Return data sets by path, such as "run1/force", with units from the attribute "units"."""
    return Arrays("HDF5 file", stored_arrays(path, "HDF5 file", hdf5_tree), "/")


def stored_arrays(path: Path, kind: str, reader: Callable[[Path], Any]) -> Any:
    """Return the arrays that a child process finds in a file; numbers are loaded on demand."""

    def leaf(shape: list[int], where: str, field: str | None, unit: Any, rate: Any) -> Leaf:
        turned = reader is not hdf5_tree  # MATLAB stores columns first

        def get() -> Any:
            values = parsed(kind, path, values_at, libraries=["h5py"], where=where, field=field)
            return values.T if turned else values

        return Leaf(tuple(shape[::-1] if turned else shape), get, unit, rate)

    def known(node: Any) -> Any:
        if isinstance(node, dict):
            if _LEAF in node:
                return leaf(*node[_LEAF])
            return {name: known(below) for name, below in node.items()}
        return [known(below) for below in node] if isinstance(node, list) else node

    return known(parsed(kind, path, reader, libraries=["h5py"]))


# ------------------------------------------------------------------ what runs in the child


def hdf5_tree(path: Path) -> Any:
    """Return the groups of a file as nested mappings, and descriptions of its data sets."""
    with opened(path) as file:
        return _node(file, set())


@contextmanager
def opened(path: Path) -> Iterator[Any]:
    """Open an HDF5 file for reading."""
    with needed_for("HDF5 files are read by"):
        import h5py
    with h5py.File(path, "r") as file:
        yield file


def leaf_of(item: Any, field: str | None = None, unit: Any = None, rate: Any = None) -> Any:
    """Describe a data set for the parent process: shape, path, field, unit and sampling rate."""
    return {_LEAF: [list(item.shape), item.name, field, unit, rate]}


def group_members(group: Any, skip: str = "\0") -> Iterator[tuple[str, Any]]:
    """Yield name and object of each member of a group; skip dangling links.

    Links to other files are an error.
    """
    import h5py

    home = h5py.h5o.get_info(group.id).fileno
    for name in group:
        if name.startswith(skip):
            continue
        link = group.get(name, getlink=True)
        if isinstance(link, h5py.ExternalLink):
            raise _elsewhere(f"{group.name}/{name}", link.filename)
        item = group.get(name)
        if not isinstance(item, (h5py.Group, h5py.Dataset)):
            continue
        if (
            h5py.h5o.get_info(item.id).fileno != home
        ):  # soft link that passes through an external link
            raise _elsewhere(f"{group.name}/{name}", Path(item.file.filename).name)
        if isinstance(item, h5py.Dataset):
            _check_storage(item)
        yield name, item


def _check_storage(item: Any) -> None:
    outside = [source[0] for source in item.external or ()]
    if item.is_virtual:
        outside += [s.file_name for s in item.virtual_sources() if s.file_name != "."]
    if outside:
        raise _elsewhere(item.name, outside[0])


def _elsewhere(name: str, file: object) -> InputError:
    path = f"/{name.lstrip('/')}"
    return InputError(
        f'"{shorten(path, 60)}" is stored in another file, "{shorten(str(file), 60)}"; read '
        "that file, or copy the data into this one"
    )


def _node(item: Any, visited: set[int]) -> Any:
    import h5py

    if isinstance(item, h5py.Group):
        address = h5py.h5o.get_info(item.id).addr
        if address in visited:
            return None
        visited.add(address)
        below = {name: _node(child, visited) for name, child in group_members(item)}
        return _attributes(item) | below
    fields = item.dtype.names
    if fields:
        plain = [name for name in fields if item.dtype[name].kind in "iuf"]
        return {name: leaf_of(item, name) for name in plain}
    if item.dtype.kind not in "iuf" or not item.shape:
        small = item.shape == () and item.dtype.itemsize <= _TEXT
        return _attribute(item[()]) if small else None
    about = {name.casefold(): value for name, value in _attributes(item).items()}
    unit = about.get("units", about.get("unit"))
    rate = next(filter(None, (rate_by(name, value) for name, value in about.items())), None)
    return leaf_of(
        item, None, unit if isinstance(unit, str) else None, rate.value if rate else None
    )


def values_at(path: Path, where: str, field: str | None) -> Any:
    """Load the numbers of a data set, or of one field of a structured data set."""
    with opened(path) as file:
        item = file[where]
        refuse_beyond(*item.shape)
        return item[()] if field is None else item[field]


def _attributes(item: Any) -> dict[str, Any]:
    sizes = {name: item.attrs.get_id(name) for name in item.attrs}
    return {
        name: _attribute(item.attrs[name])
        for name, entry in sizes.items()
        if entry.get_storage_size() <= _TEXT
    }


def _attribute(value: Any) -> Any:
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.flat[0]
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    return value if isinstance(value, str) or is_numeric(value) else None
