"""Labelled arrays as one netCDF-4 file, the same bytes for the same numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.packages import needed_for

_COMPRESSED = 4096  # bytes, from which on an array is


class Variable(NamedTuple):
    """An array with the names of its dimensions and its attributes (``units``, ``long_name``)."""

    dims: tuple[str, ...]
    values: NDArray[Any]
    attributes: Mapping[str, Any]


def write(
    path: str | Path,
    dims: Mapping[str, int],
    coords: Mapping[str, Variable],
    variables: Mapping[str, Variable],
    attributes: Mapping[str, Any],
    progress: Callable[[float], None] | None = None,
) -> None:
    """Write a new netCDF-4 file that xarray, netCDF4, h5py and MATLAB read."""
    with needed_for("netCDF files need"):
        import h5netcdf

    auxiliary = {name: set(v.dims) for name, v in coords.items() if v.dims != (name,)}
    total, written = sum(v.values.nbytes for v in (*coords.values(), *variables.values())), 0
    with h5netcdf.File(path, "x", track_order=True) as file:
        file.dimensions = dict(dims)
        for name, value in attributes.items():
            _set(file, name, value)
        for group in (coords, variables):
            for name, (names, values, about) in group.items():
                data = np.asarray(values)
                text = data.dtype.kind not in "iufb"
                if data.dtype.kind == "b":
                    data = data.astype(np.int8)
                packed = {"compression": "gzip", "compression_opts": 4, "shuffle": True}
                variable = file.create_variable(
                    name,
                    names,
                    dtype=_text() if text else data.dtype,
                    data=data.astype(object) if text else data,
                    **(packed if data.nbytes > _COMPRESSED and not text else {}),
                )
                for key, value in about.items():
                    _set(variable, key, value)
                near = [key for key, its in auxiliary.items() if its <= set(names)]
                if group is variables and near:
                    _set(variable, "coordinates", " ".join(near))
                written += data.nbytes
                if progress is not None:
                    progress(min(written / total, 1.0))


def _set(owner: Any, name: str, value: Any) -> None:
    """Set an attribute; text as an array of characters, the only kind that all readers know.

    Strings of varying length are what h5py makes of text. MATLAB and Fortran programs that expect
    characters refuse them.
    """
    import h5py

    if isinstance(value, str):
        data = value.encode()
        value = np.array(data, dtype=h5py.string_dtype("utf-8", len(data)))
    owner.attrs[name] = value


def _text() -> Any:
    import h5py

    return h5py.string_dtype()


class Contents(NamedTuple):
    """Labelled content of a result."""

    dims: dict[str, int]
    coords: dict[str, Variable]
    variables: dict[str, Variable]
    attributes: dict[str, Any]


def dataset(contents: Contents) -> Any:
    """The same as an `xarray.Dataset`: what xarray reads from the file."""
    with needed_for("to_xarray needs", "xarray", "save(...) and its result.nc need nothing more"):
        import xarray
    return xarray.Dataset(
        data_vars={name: tuple(variable) for name, variable in contents.variables.items()},
        coords={name: tuple(variable) for name, variable in contents.coords.items()},
        attrs=contents.attributes,
    )
