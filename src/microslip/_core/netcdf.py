"""Data sets as netCDF-4 files, byte for byte reproducible."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np

from microslip._core.dataset import DataSet
from microslip._core.packages import needed_for

_COMPRESSED = 4096  # size in bytes from which arrays are compressed


def store(path: str | Path, data: DataSet) -> None:
    """Write a data set to a new netCDF-4 file, readable by xarray, netCDF4, h5py and MATLAB.

    The file is made in memory, because HDF5 can crash where a disk is full.
    """
    coords, variables = data.coords, data.variables
    with needed_for("netCDF files need"):
        import h5netcdf
        from h5py import string_dtype

    def set_attribute(owner: Any, name: str, value: Any) -> None:
        # MATLAB and Fortran programs cannot read the variable-length strings that h5py writes by
        # default, so text becomes a fixed-length string.
        if isinstance(value, str):
            encoded = value.encode()
            value = np.array(encoded, dtype=string_dtype("utf-8", len(encoded)))
        owner.attrs[name] = value

    auxiliary = {name: set(v.dims) for name, v in coords.items() if v.dims != (name,)}
    made = io.BytesIO()
    with h5netcdf.File(made, "w", track_order=True) as file:
        file.dimensions = dict(data.sizes)
        for name, value in data.attributes.items():
            set_attribute(file, name, value)
        for group in (coords, variables):
            for name, column in group.items():
                names, array = column.dims, np.asarray(column.values)
                text = array.dtype.kind not in "iufb"
                if array.dtype.kind == "b":
                    array = array.astype(np.int8)
                packed = {"compression": "gzip", "compression_opts": 4, "shuffle": True}
                variable = file.create_variable(
                    name,
                    names,
                    dtype=string_dtype() if text else array.dtype,
                    data=array.astype(object) if text else array,
                    **(packed if array.nbytes > _COMPRESSED and not text else {}),
                )
                for key, value in column.attributes.items():
                    set_attribute(variable, key, value)
                near = [key for key, its in auxiliary.items() if its <= set(names)]
                if group is variables and near:
                    set_attribute(variable, "coordinates", " ".join(near))
    with Path(path).open("xb") as stored:
        stored.write(made.getbuffer())
