"""Labelled arrays of a result, as a netCDF file and as xarray's data set."""

from __future__ import annotations

from typing import Any, NamedTuple

from microslip._core.netcdf import Variable
from microslip._core.packages import needed_for


class Contents(NamedTuple):
    """What a result has to say, labelled."""

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
