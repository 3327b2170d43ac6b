"""Floor 8: every parameter of a scan against the short-wave cut-off, in small panels."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import Formatter, FuncFormatter
from numpy.typing import NDArray

from microslip._core.units import prefix
from microslip.study.drawing import DASHES, drawable, length_prefix, log_scale, new_figure, note

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from microslip.scans.cutoffs import CutoffTable
    from microslip.study.scanned import Findings

_CHOSEN: dict[str, Any] = {"color": "#444444", "linewidth": 0.9, "linestyle": (0, (1, 1))}
_LOOKS: dict[str, dict[str, Any]] = {
    "mccool": {"color": "#0072B2", "marker": "o", "markerfacecolor": "white"},
    "counted": {
        "color": "#D55E00",
        "linestyle": DASHES,
        "marker": "s",
        "markerfacecolor": "white",
    },
    "": {"color": "#000000", "marker": "o", "markerfacecolor": "white"},
}


class _Panel(NamedTuple):
    """What a panel shows: columns of the table by their look, and the unit."""

    what: str
    columns: dict[str, str]
    unit: str


_PANELS = (
    _Panel("Summit density", {k: f"{k}_density" for k in ("mccool", "counted")}, "1/mm²"),
    _Panel("Summit radius", {k: f"{k}_radius" for k in ("mccool", "counted")}, "m"),
    _Panel("Std of summit heights", {k: f"{k}_std" for k in ("mccool", "counted")}, "m"),
    _Panel("Rms height Sq", {"": "rms"}, "m"),
    _Panel("Rms slope", {"": "m2"}, "–"),
    _Panel("Nayak's α", {"": "nayak"}, "–"),
)


def draw(found: Findings) -> Figure:
    """Draw density, radius, spread and the moments against the cut-off; none is at the left.

    Parameters
    ----------
    found : Findings
        What was found.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, with a canvas.
    """
    table, scan = found.table, found.scan
    figure = new_figure(5.4, found.title("Cut-off dependence"))
    panels = figure.subplots(2, 3)
    unit, letter = length_prefix(max(scan.size) / 8.0, min(scan.pixel))
    # No cut-off has its place at the left, where a pixel is.
    least = min(scan.pixel) / unit
    x = np.where(table.cutoff > 0.0, table.cutoff / unit, least)
    for axes, panel in zip(panels.flat, _PANELS, strict=True):
        lines = {look: _column(table, name) for look, name in panel.columns.items()}
        scale, own = _scale(list(lines.values()), panel.unit)
        for look, values in lines.items():
            y = drawable(values / scale, log=True)
            # The step from none to the first cut-off is not to scale: no line there.
            axes.plot(x[1:], y[1:], **_LOOKS[look])
            axes.plot(x[:1], y[:1], **{**_LOOKS[look], "linestyle": "none"})
        note(axes, f"{panel.what} [{own}]")
        _frame(axes, found, least, unit)
    for axes in panels[1]:
        axes.set_xlabel(f"Cut-off [{letter}m]")
    handles = [
        Line2D([], [], label="McCool's moments", **_LOOKS["mccool"]),
        *(() if scan.is_profile else (Line2D([], [], label="counted", **_LOOKS["counted"]),)),
        Line2D([], [], label=found.cutoff_text(), **_CHOSEN),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return figure


def _column(table: CutoffTable, name: str) -> NDArray[np.float64]:
    values: NDArray[np.float64] = getattr(table, name)
    return np.sqrt(values) if name == "m2" else values


def _scale(lines: list[NDArray[np.float64]], unit: str) -> tuple[float, str]:
    """What values are divided by, and the unit that is left."""
    if unit != "m":
        return (1e6 if unit == "1/mm²" else 1.0), unit
    values = np.concatenate(lines)
    values = values[np.isfinite(values) & (values > 0.0)]
    if not values.size:
        return 1.0, unit
    factor, letter = prefix(math.sqrt(float(values.min()) * float(values.max())))
    return factor, f"{letter}m"


def _frame(axes: Axes, found: Findings, least: float, unit: float) -> None:
    """Axes, with the place of no cut-off at the left, and the one that was asked for."""
    log_scale(axes, "x")
    log_scale(axes, "y")
    cutoffs = found.table.cutoff / unit
    axes.set_xlim(0.75 * least, max(1.3 * float(cutoffs[-1]), 4.0 * least))
    first = float(cutoffs[1]) if cutoffs.size > 1 else math.inf
    side = axes.xaxis
    side.set_major_formatter(FuncFormatter(_from(side.get_major_formatter(), 0.8 * first)))
    side.set_minor_formatter(FuncFormatter(_from(side.get_minor_formatter(), 0.8 * first)))
    axes.annotate(
        "none",
        (least, 0.0),
        (0, -5),
        xycoords=axes.get_xaxis_transform(),
        textcoords="offset points",
        ha="center",
        va="top",
        fontsize=8.5,
    )
    chosen = least if found.request.cutoff is None else found.request.cutoff / unit
    axes.axvline(chosen, **_CHOSEN, zorder=1)


def _from(own: Formatter, least: float) -> Callable[[float, int | None], str]:
    """Labels from a value on; below it there are no cut-offs."""
    return lambda x, position: own(x, position) if x >= least else ""
