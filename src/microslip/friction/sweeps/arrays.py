"""Labelled arrays of a sweep and their export to files and data sets.

Equation numbers (19.x) are those of chapter 19, DOI 10.1007/978-3-319-56818-8_19.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from microslip._core import netcdf
from microslip._core.checks import show
from microslip._core.dataset import DataSet, Variable
from microslip._core.errors import InputError
from microslip._core.files import atomic_file
from microslip._core.frozen import lock
from microslip._core.units import engineering, prefix
from microslip.figures.kit import evenly
from microslip.figures.plot import COLORS, DASHES, Axis, Entry, Panel, Plot

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, eq=False)
class Sweep:
    """Named arrays with dimensions and coordinates, the result of :func:`microslip.sweep`.

    Parameters
    ----------
    coords : mapping of str to Variable
        Coordinates by name: values along the dimension of that name, or a single number.
    variables : mapping of str to Variable
        Results by name. A Variable has ``dims``, ``values`` and ``attributes`` (unit, long name).
    attributes : mapping of str to str
        Description of the sweep and version of the package.

    Notes
    -----
    Damping is that of the interface alone, ``loss_factor`` as in (19.30). For a mode of a structure
    see :class:`microslip.Oscillator`.
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
        """Lengths of the dimensions by name, in order."""
        return {
            name: variable.values.size for name, variable in self.coords.items() if variable.dims
        }

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions, in the common order of all arrays."""
        return tuple(self.sizes)

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions."""
        return tuple(self.sizes.values())

    def __getitem__(self, name: str) -> Any:
        """Values of a result or a coordinate by name, a float if it has no dimension."""
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
        """Draw a quantity, in its unit [SI], along one dimension.

        ``along`` defaults to the longest dimension. Each line is one combination of values of the
        other dimensions; at most six are drawn. ``ax``, ``color`` and ``label`` (of the first line)
        are as for :meth:`microslip.BackboneLaw.plot`.
        """
        from microslip.figures import draw

        return draw(sweep_figure(self, quantity, along), ax, color=color, label=label)

    def to_xarray(self) -> xarray.Dataset:
        """Convert to an ``xarray.Dataset``."""
        instead = "to_netcdf(...) and to_csv(...) do not need it"
        data: xarray.Dataset = self._data.to_xarray(instead)
        return data

    @property
    def _data(self) -> DataSet:
        return DataSet(self.sizes, self.coords, self.variables, self.attributes)

    def to_netcdf(self, path: str | Path, overwrite: bool = False) -> Path:
        """Write a netCDF-4 file and return its path.

        The write is atomic. An existing file is replaced only with ``overwrite``.
        """
        with atomic_file(path, overwrite) as stage:
            netcdf.store(stage, self._data)
        return Path(path)

    def to_csv(self, path: str | Path, overwrite: bool = False) -> Path:
        """Write a CSV table in SI units, one line per point, coordinates first.

        Numbers are written exactly. Parameters and errors are as for :meth:`to_netcdf`.
        """
        data = self._data
        with (
            atomic_file(path, overwrite) as stage,
            stage.open("w", encoding="utf-8", newline="") as file,
        ):
            file.writelines(text for _, text in data.csv_lines({n: n for n in data}, self.dims))
        return Path(path)


def _range(values: NDArray[Any]) -> tuple[float, float]:
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if finite.size else (math.nan, math.nan)


MOST_LINES = 6
_MOST_POINTS = 5000


def sweep_figure(sweep: Any, quantity: Any, along: Any) -> Plot:
    """Return the plot of a quantity along one dimension, with a line per value of the others."""
    if not isinstance(quantity, str) or quantity not in sweep.variables:
        names = ", ".join(sweep.variables)
        raise InputError(f"`quantity` must be one of {names}, got {show(quantity)}")
    dims, values, about = sweep.variables[quantity]
    if not dims:
        raise InputError(f"`quantity` must have a dimension, got {quantity}, which is a number")
    if along is None:
        along = max(dims, key=lambda dim: sweep.sizes[dim])
    if along not in dims:
        raise InputError(f"`along` must be one of {', '.join(dims)}, got {show(along)}")
    place = dims.index(along)
    lines = np.moveaxis(values, place, -1).reshape(-1, values.shape[place])
    rows = [dim for dim in dims if dim != along]
    selection = evenly(len(lines), MOST_LINES)
    x = np.asarray(sweep.coords[along].values, dtype=float)
    order = np.argsort(x)[evenly(x.size, _MOST_POINTS)]
    x_axis, x_unit = _axis(along, x, sweep.coords[along].attributes["units"])
    y_axis, y_unit = _axis(quantity, lines[selection], about["units"])
    panel = Panel(x_axis, y_axis)
    legend = []
    for number, line in enumerate(selection):
        look = COLORS[number % 6], DASHES[number % 6]
        panel.line(x[order] / x_unit, lines[line][order] / y_unit, look[0], dash=look[1])
        index = np.unravel_index(line, [sweep.sizes[dim] for dim in rows]) if rows else ()
        legend.append(Entry(_named(sweep, rows, index), *look))
    left_out = len(lines) - len(selection)
    return Plot(
        [panel],
        4.4,
        legend=tuple(legend) if rows else (),
        legend_title=f"{left_out} more are in the arrays" if left_out else "",
    )


def _axis(name: str, values: Any, unit: str) -> tuple[Axis, float]:
    fine = values[np.isfinite(values)]
    largest = float(np.abs(fine).max(initial=0.0))
    simple = unit in ("m", "N", "J", "Hz", "Pa", "N/m")
    scale, letter = prefix(largest) if simple and largest > 0.0 else (1.0, "")
    text = name.replace("_", " ").capitalize()
    label = f"{text} [{letter}{unit}]" if unit not in ("", "1", "-") else text
    log = bool(fine.size and fine.min() > 0.0 and largest > 10.0 * fine.min())
    return Axis(label, log=log, margin=0.02, unit=scale), scale


def _named(sweep: Any, dims: list[str], index: Any) -> str:
    parts = []
    for dim, i in zip(dims, index, strict=True):
        coordinate = sweep.coords[dim]
        value, unit = coordinate.values[i], coordinate.attributes["units"]
        if unit in ("m", "N", "J", "Hz", "Pa", "N/m"):
            parts.append(f"{dim.replace('_', ' ')} {engineering(float(value), unit, trim=True)}")
        else:
            parts.append(f"{dim.replace('_', ' ')} {value:g} {unit if unit != '1' else ''}".strip())
    return ", ".join(parts)
