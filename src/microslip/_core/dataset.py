"""Data set of a result: named, labelled columns, from which all tables and files are written."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.errors import InputError
from microslip._core.packages import needed_for
from microslip._core.quantities import Quantity, json_value
from microslip._core.wording import one_line, quote

_BLOCK = 20_000  # rows of a CSV file formatted at once
_FORMULAS = tuple(
    "=+-@\N{FULLWIDTH EQUALS SIGN}\N{FULLWIDTH PLUS SIGN}"
    "\N{FULLWIDTH HYPHEN-MINUS}\N{FULLWIDTH COMMERCIAL AT}"
)


class Variable(NamedTuple):
    """Column of a data set: an array, the names of its dimensions, and the quantity it holds."""

    dims: tuple[str, ...]
    values: NDArray[Any]
    quantity: Quantity
    more: Mapping[str, Any] = {}
    """Attributes in files, besides the unit and the meaning of the quantity."""

    @property
    def attributes(self) -> dict[str, Any]:
        """Attributes in files (``units``, ``long_name`` and others)."""
        return {**self.quantity.attributes, **self.more}


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

    @classmethod
    def of_rows(cls, columns: Mapping[str, tuple[Quantity, Iterable[Any]]]) -> DataSet:
        """Return the data set of columns of equal length, along the dimension "row".

        A column of text has a quantity without unit, "". None is an unknown value: NaN in a column
        of numbers, an empty cell in one of text.
        """
        variables = {}
        for name, (quantity, values) in columns.items():
            if not isinstance(values, np.ndarray):
                listed = list(values)
                text = any(isinstance(value, str) for value in listed)
                if not text:
                    listed = [math.nan if value is None else value for value in listed]
                values = np.array(listed, dtype=object if text else None)
            variables[name] = Variable(("row",), values, quantity)
        return cls({"row": len(next(iter(variables.values())).values)}, {}, variables)

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

    def rows(self, names: Iterable[str] = ()) -> list[tuple[Any, ...]]:
        """Return the rows of the named columns along "row", all by default.

        Numbers that are not finite are None.
        """
        columns = (json_value(self[name].values) for name in names or self)
        return list(zip(*columns, strict=True))

    def records(self, names: Iterable[str] = ()) -> list[dict[str, Any]]:
        """Return the rows of a data set along "row" as dictionaries, for summary.json."""
        names = tuple(names or self)
        return [dict(zip(names, row, strict=True)) for row in self.rows(names)]

    def csv_lines(self, columns: Mapping[str, str], dims: tuple[str, ...]) -> Iterator[str]:
        """Yield the parts of a CSV table, the header first.

        ``columns`` maps headings to names of variables. There is one row per point along ``dims``,
        the first varying slowest. Numbers have the fewest digits that restore them exactly.
        """
        yield ",".join(map(self._heading, columns, columns.values())) + "\n"
        arrays = [self.spread(name, dims) for name in columns.values()]
        # Columns without a unit are text and counts.
        arrays = [
            array if self[name].quantity.unit == "" else np.asarray(array, dtype=float)
            for name, array in zip(columns.values(), arrays, strict=True)
        ]
        writers = [_cell if array.dtype == object else repr for array in arrays]
        for start in range(0, math.prod(self.sizes[dim] for dim in dims), _BLOCK):
            texts = (
                map(write, array.flat[start : start + _BLOCK].tolist())
                for write, array in zip(writers, arrays, strict=True)
            )
            yield "".join([",".join(row) + "\n" for row in zip(*texts, strict=True)])

    def _heading(self, key: str, name: str) -> str:
        unit = self[name].quantity.unit
        return f"{key} [{unit}]" if unit else key

    def to_xarray(self, instead: str) -> Any:
        """Convert to ``xarray.Dataset``; without xarray the error recommends ``instead``."""
        with needed_for("to_xarray needs", "xarray", instead):
            import xarray
        coords, variables = (
            {name: (v.dims, v.values, dict(v.attributes)) for name, v in group.items()}
            for group in (self.coords, self.variables)
        )
        return xarray.Dataset(variables, coords, attrs=dict(self.attributes))


def _cell(value: Any) -> str:
    return "" if value is None else text_cell(value)


def text_cell(text: str) -> str:
    """Quote a name as a one-line CSV cell that spreadsheets do not interpret as a formula.

    A name that starts with =, +, - or @, or the full-width form of one, gets a leading apostrophe.
    """
    text = one_line(text)
    if text.lstrip()[:1] in _FORMULAS:
        text = f"'{text}"
    return '"' + text.replace('"', '""') + '"'
