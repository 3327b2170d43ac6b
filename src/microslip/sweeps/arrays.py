"""Labelled arrays, and their export to files and data sets."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import show
from microslip._core.files import whole_file
from microslip._core.frozen import lock
from microslip._core.netcdf import Variable
from microslip._core.netcdf import write as write_netcdf
from microslip._core.packages import needed_for
from microslip.errors import InputError

if TYPE_CHECKING:
    import xarray

_BLOCK = 20_000  # lines of a table at a time


@dataclass(frozen=True, eq=False)
class Sweep:
    """Arrays with names, dimensions and coordinates, as :func:`microslip.sweep` makes them.

    Parameters
    ----------
    coords : mapping of str to Variable
        Coordinates by name: along a dimension of that name, or one number.
    variables : mapping of str to Variable
        Results by name. A Variable is a tuple of ``dims``, ``values`` and ``attributes`` (units
        and what it is).
    attributes : mapping of str to str
        Description of the sweep, and the version.

    Notes
    -----
    What an interface says of itself, for many at once: ``loss_factor`` is (19.30), and none of the
    damping ratios is that of a mode, see :class:`microslip.Oscillator`.
    """

    coords: Mapping[str, Variable]
    variables: Mapping[str, Variable]
    attributes: Mapping[str, str]

    def __post_init__(self) -> None:
        for name in ("coords", "variables", "attributes"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))
        for variable in (*self.coords.values(), *self.variables.values()):
            lock(variable.values)

    def __getstate__(self) -> dict[str, Any]:
        return {name: dict(getattr(self, name)) for name in ("coords", "variables", "attributes")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.__post_init__()

    @property
    def sizes(self) -> dict[str, int]:
        """Lengths of the dimensions by name, in their order."""
        return {
            name: variable.values.size for name, variable in self.coords.items() if variable.dims
        }

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions, in the order that all arrays have them in."""
        return tuple(self.sizes)

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions."""
        return tuple(self.sizes.values())

    def __getitem__(self, name: str) -> Any:
        """Values of a variable or a coordinate; a float where it has no dimension."""
        for group in (self.variables, self.coords):
            if isinstance(name, str) and name in group:
                values = group[name].values
                return float(values) if values.ndim == 0 else values
        names = ", ".join((*self.variables, *self.coords))
        raise InputError(f"`name` must be one of {names}, got {show(name)}")

    def __contains__(self, name: object) -> bool:
        return name in self.variables or name in self.coords

    def __iter__(self) -> Iterator[str]:
        return iter(self.variables)

    def __len__(self) -> int:
        return len(self.variables)

    def __repr__(self) -> str:
        lines = [f"Sweep({', '.join(f'{name}: {size}' for name, size in self.sizes.items())})"]
        width = max(len(name) for name in (*self.coords, *self.variables))
        for head, group in (("coordinates", self.coords), ("variables", self.variables)):
            lines.append(f"  {head}")
            for name, (dims, values, about) in group.items():
                low, high = _range(values)
                span = f"{low:g}" if low == high or values.ndim == 0 else f"{low:g} … {high:g}"
                over = f"({', '.join(dims)})" if dims else ""
                lines.append(f"    {name:<{width}}  {span} [{about['units']}] {over}".rstrip())
        return "\n".join(lines)

    def plot(
        self,
        ax: Any = None,
        quantity: str = "loss_factor",
        along: str | None = None,
        *,
        color: str | None = None,
        label: str = "",
    ) -> Any:
        """Draw a quantity in its unit [SI] along one dimension, a few lines for the others.

        By default along the longest. Axes, colour and label, those of the first line, are as of
        :meth:`microslip.BackboneLaw.plot`.
        """
        from microslip.report import draw
        from microslip.sweeps.figure import sweep_figure

        return draw(sweep_figure(self, quantity, along), ax, color=color, label=label)

    def to_xarray(self) -> xarray.Dataset:
        """The same as an ``xarray.Dataset``."""
        instead = "to_netcdf(...) and to_csv(...) need nothing more"
        with needed_for("to_xarray needs", "xarray", instead):
            import xarray
        variables, coords = (
            {name: (v.dims, v.values, dict(v.attributes)) for name, v in group.items()}
            for group in (self.variables, self.coords)
        )
        return xarray.Dataset(variables, coords, attrs=dict(self.attributes))

    def to_netcdf(self, path: str | Path, overwrite: bool = False) -> Path:
        """Write one netCDF-4 file, whole or not at all, and return its path.

        A file in its place is replaced only with ``overwrite``.
        """
        with whole_file(path, overwrite) as stage:
            write_netcdf(stage, self.sizes, self.coords, self.variables, self.attributes)
        return Path(path)

    def to_csv(self, path: str | Path, overwrite: bool = False) -> Path:
        """Write one table, whole or not at all: a line a point, coordinates first, in SI units.

        Parameters and errors as :meth:`to_netcdf`; numbers read back bit for bit.
        """
        shape = self.shape
        columns = {}
        for name, (dims, values, about) in {**self.coords, **self.variables}.items():
            places = [slice(None) if dim in dims else None for dim in self.dims]
            column = np.broadcast_to(values[tuple(places)] if self.dims else values, shape)
            unit = "-" if about["units"] == "1" else about["units"]
            columns[f"{name} [{unit}]"] = column.reshape(-1)
        count = math.prod(shape)
        with (
            whole_file(path, overwrite) as stage,
            stage.open("w", encoding="utf-8", newline="") as file,
        ):
            file.write(",".join(columns) + "\n")
            for start in range(0, count, _BLOCK):
                # repr is the shortest text that reads back as the same double.
                texts = [map(repr, c[start : start + _BLOCK].tolist()) for c in columns.values()]
                file.writelines(",".join(row) + "\n" for row in zip(*texts, strict=True))
        return Path(path)


def _range(values: NDArray[Any]) -> tuple[float, float]:
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if finite.size else (math.nan, math.nan)
