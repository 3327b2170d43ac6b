"""Data set of a result: named arrays with dimensions and units; lines for CSV."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.errors import InputError
from microslip._core.packages import needed_for
from microslip._core.wording import quote

_BLOCK = 20_000  # rows of a CSV file formatted at once


class Variable(NamedTuple):
    """Array with the names of its dimensions and its attributes (``units``, ``long_name``)."""

    dims: tuple[str, ...]
    values: NDArray[Any]
    attributes: Mapping[str, Any]

    @property
    def unit(self) -> str:
        """Unit for tables, "-" for a dimensionless number."""
        unit = str(self.attributes["units"])
        return "-" if unit == "1" else unit


@dataclass(frozen=True, eq=False, repr=False)
class DataSet(Mapping[str, Variable]):
    """Variables and coordinates of a result by name.

    Parameters
    ----------
    sizes : mapping of str to int
        Length of each dimension.
    coords, variables : mapping of str to Variable
        Coordinates and results by name.
    attributes : mapping of str to object
        Description of the data set.
    """

    sizes: Mapping[str, int]
    coords: Mapping[str, Variable]
    variables: Mapping[str, Variable]
    attributes: Mapping[str, Any] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Variable:
        for group in (self.variables, self.coords):
            if isinstance(name, str) and name in group:
                return group[name]
        raise InputError(f"`name` must be one of {', '.join(self)}, got {quote(name)}")

    def __contains__(self, name: object) -> bool:
        return name in self.variables or name in self.coords

    def __iter__(self) -> Iterator[str]:
        return iter({**self.coords, **self.variables})

    def __len__(self) -> int:
        return len({**self.coords, **self.variables})

    def spread(self, name: str, dims: tuple[str, ...]) -> NDArray[Any]:
        """Return a view of a variable along ``dims``, broadcast along missing dimensions."""
        variable = self[name]
        order = [variable.dims.index(dim) for dim in dims if dim in variable.dims]
        places = tuple(slice(None) if dim in variable.dims else None for dim in dims)
        values = variable.values.transpose(order)[places] if places else variable.values
        return np.broadcast_to(values, tuple(self.sizes[dim] for dim in dims))

    def csv_lines(
        self, columns: Mapping[str, str], dims: tuple[str, ...]
    ) -> Iterator[tuple[int, str]]:
        """Yield the parts of a CSV table as pairs of number of rows and text.

        The first part is the header, with 0 rows. ``columns`` maps the heading of each column to
        the name of its variable. There is one row per point along ``dims``, of which the first
        varies slowest. Numbers have the fewest digits from which they can be restored exactly.
        """
        yield 0, ",".join(f"{key} [{self[name].unit}]" for key, name in columns.items()) + "\n"
        arrays = [np.asarray(self.spread(name, dims), dtype=float) for name in columns.values()]
        for start in range(0, self.count(dims), _BLOCK):
            texts = (map(repr, a.flat[start : start + _BLOCK].tolist()) for a in arrays)
            lines = [",".join(row) + "\n" for row in zip(*texts, strict=True)]
            yield len(lines), "".join(lines)

    def count(self, dims: tuple[str, ...]) -> int:
        """Return the number of points along ``dims``, the product of their lengths."""
        return math.prod(self.sizes[dim] for dim in dims)

    def to_xarray(self, instead: str) -> Any:
        """Convert to ``xarray.Dataset``; without xarray the error recommends ``instead``."""
        with needed_for("to_xarray needs", "xarray", instead):
            import xarray
        coords, variables = (
            {name: (v.dims, v.values, dict(v.attributes)) for name, v in group.items()}
            for group in (self.coords, self.variables)
        )
        return xarray.Dataset(variables, coords, attrs=dict(self.attributes))
