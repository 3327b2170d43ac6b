"""A quantity of a sweep along one of its dimensions."""

from __future__ import annotations

from typing import Any

import numpy as np

from microslip._core.checks import show
from microslip._core.units import engineering, prefix
from microslip.errors import InputError
from microslip.report.kit import evenly
from microslip.report.plot import COLORS, DASHES, Axis, Entry, Panel, Plot

MOST_LINES = 6
_MOST_POINTS = 5000


def sweep_figure(sweep: Any, quantity: Any, along: Any) -> Plot:
    """Lines along one dimension; a few, evenly, of all combinations of the others."""
    if not isinstance(quantity, str) or quantity not in sweep.variables:
        names = ", ".join(sweep.variables)
        raise InputError(f"`quantity` must be one of {names}, got {show(quantity)}")
    dims, values, about = sweep.variables[quantity]
    if not dims:
        raise InputError(f"`quantity` must have a dimension, {quantity} is one number")
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
    """An axis in a suitable prefix; logarithmic where values span more than a decade."""
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
