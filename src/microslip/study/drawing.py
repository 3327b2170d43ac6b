"""Floor 8: what the figures share: style, page, colours, axes, curves and legend."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from microslip._core.units import engineering
from microslip.report.drawing import DASHES as DASHES
from microslip.report.drawing import STYLE as STYLE
from microslip.report.drawing import log_scale as log_scale
from microslip.report.drawing import missing_glyphs as missing_glyphs
from microslip.report.drawing import new_figure as new_figure
from microslip.report.drawing import note as note
from microslip.report.drawing import settle as settle
from microslip.report.scales import common_prefix as common_prefix
from microslip.report.scales import far_apart as far_apart
from microslip.report.scales import length_prefix as length_prefix
from microslip.study.result import AmplitudeCurve, Floats, some

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from microslip.study.result import Result
    from microslip.study.varying import VaryingCycles

MOST_LOADS = 6
MOST_MARKS = 12
_MARKERS = ("o", "s", "^", "D", "v", "P")
_LINES = ("-", (0, (6, 2)), (0, (1, 1)), (0, (6, 2, 1, 2)), (0, (3, 1)), (0, (5, 1, 1, 1, 1, 1)))

By = Literal["marker", "linestyle"]
Quantity = Callable[[AmplitudeCurve], Floats]


# -- loads ---------------------------------------------------------------------------------------


def drawn_loads(result: Result, by: By) -> list[tuple[int, dict[str, Any]]]:
    """Loads that are drawn: their index, and colour and marker or line style of their curve."""
    cycle = matplotlib.rcParams["axes.prop_cycle"].by_key()["color"]
    shown = some(len(result.joints), MOST_LOADS)
    looks: tuple[Any, ...] = _MARKERS if by == "marker" else _LINES
    return [
        (index, {"color": cycle[i % len(cycle)], by: looks[i % len(looks)]})
        for i, index in enumerate(shown)
    ]


def add_legend(figure: Figure, result: Result, by: By, title: str = "") -> None:
    """Name the loads below the panels.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The figure.
    result : Result
        What was drawn.
    by : {"marker", "linestyle"}
        How the loads differ in it besides their colour.
    title : str, optional
        What the loads are; by default normal loads and, in a study with others that vary, constant
        ones.
    """
    if not title:
        title = "Constant normal load" if result.study.excitation.load_varies else "Normal load"
    loads = drawn_loads(result, by)
    handles = [
        Line2D(
            [],
            [],
            **look,
            markerfacecolor="white",
            label=engineering(result.joints[i].normal_load, "N", trim=True),
        )
        for i, look in loads
    ]
    left_out = len(result.joints) - len(loads)
    title += f" ({left_out} more in the tables)" if left_out else ""
    figure.legend(
        handles=handles,
        loc="outside lower center",
        ncols=len(handles),
        title=title,
        title_fontsize=8.5,
    )


# -- axes ----------------------------------------------------------------------------------------


class Axis(NamedTuple):
    """The amplitude that curves are drawn against."""

    column: str
    """Name of the column in :class:`~microslip.study.result.AmplitudeCurve`."""
    unit: float
    """What its values are divided by [SI unit]."""
    label: str
    """What stands at the axis."""
    low: float
    """Its left end, divided by the unit."""
    high: float
    """Its right end, divided by the unit."""

    def of(self, curve: AmplitudeCurve | VaryingCycles) -> Floats:
        """Values of a curve on this axis."""
        values: Floats = getattr(curve, self.column)
        return values / self.unit

    def fit(self, axes: Axes) -> None:
        """Make the horizontal axis of a panel this one."""
        log_scale(axes, "x")
        axes.set_xlim(self.low, self.high)


def displacement_axis(result: Result) -> Axis:
    """The displacement amplitude, over the range of the curves."""
    curves = [result.curves[i] for i, _ in drawn_loads(result, "marker")]
    low = min(float(curve.amplitude[0]) for curve in curves)
    high = max(float(curve.amplitude[-1]) for curve in curves)
    unit, letter = length_prefix(high, low)
    return Axis(
        "amplitude", unit, f"Displacement amplitude [{letter}m]", *_apart(low / unit, high / unit)
    )


def force_axis(result: Result) -> Axis:
    """The force amplitude, over the range of the curves and past the largest force limit.

    Loops under a load that varies reach further than the limit at its mean.
    """
    loads = [i for i, _ in drawn_loads(result, "marker")]
    largest = max(result.joints[i].force_limit for i in loads)
    forces = np.concatenate([result.curves[i].force_amplitude for i in loads])
    least = float(forces[forces > 0.0].min()) if (forces > 0.0).any() else 0.1 * largest
    unit, letter = common_prefix([result.joints[i].force_limit for i in loads])
    if 1.6 * largest < 10.0 * least:  # so that nothing lies on the edge
        least /= 1.6
    varying = [float(result.varying[i].force_amplitude.max()) for i in loads if result.varying]
    most = max([1.6 * largest, *(1.2 * force for force in varying)])
    return Axis("force_amplitude", unit, f"Force amplitude [{letter}N]", least / unit, most / unit)


def _apart(low: float, high: float) -> tuple[float, float]:
    """Two ends of a log axis that leave something between them."""
    return (low, high) if high > 1.01 * low else (low / 1.2, high * 1.2)


# -- curves --------------------------------------------------------------------------------------


def drawable(values: Floats, log: bool = False) -> Floats:
    """Values with gaps where nothing can be drawn: not finite or, on a log axis, not above zero."""
    fine = np.isfinite(values) & (values > 0.0) if log else np.isfinite(values)
    return np.where(fine, values, np.nan)


def draw_curves(
    axes: Axes, result: Result, axis: Axis, quantity: Quantity, *, log: bool = False
) -> Floats:
    """Draw a quantity of every load: a line, and markers where there are loops.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where.
    result : Result
        What to draw.
    axis : Axis
        The horizontal axis.
    quantity : callable
        Takes a curve, gives its ordinates.
    log : bool
        Whether the vertical axis is logarithmic.

    Returns
    -------
    ndarray
        The ordinates of all lines that can be drawn; one NaN if there is none.
    """
    drawn = [np.array([np.nan])]
    loads = drawn_loads(result, "marker")
    lines = [
        np.stack([axis.of(result.curves[i]), drawable(quantity(result.curves[i]), log)])
        for i, _ in loads
    ]
    width = float(matplotlib.rcParams["lines.linewidth"])
    for number, (index, look) in enumerate(loads):
        curve, row = result.curves[index], result.rows[index]
        x, y = lines[number]
        # A line that others will hide is so wide that it shows on both sides of them.
        above = sum(_coincide(lines[number], other) for other in lines[number + 1 :])
        axes.plot(x, y, color=look["color"], linewidth=width + 1.3 * above)
        drawn.append(y[np.isfinite(y)])
        inside = (row.amplitude >= curve.amplitude[0]) & (row.amplitude <= curve.amplitude[-1])
        marked = np.flatnonzero(inside)
        if marked.size:
            marked = marked[some(marked.size, MOST_MARKS)]
            x, y = axis.of(row)[marked], drawable(quantity(row), log)[marked]
        else:  # markers also tell the loads apart in grey
            places = some(x.size, 7)
            x, y = x[places], y[places]
        axes.plot(x, y, linestyle="none", markerfacecolor="white", zorder=3, **look)
    if log:
        log_scale(axes, "y")
    values = np.concatenate(drawn)
    return values[1:] if values.size > 1 else values


def _coincide(line: Floats, other: Floats) -> bool:
    """Whether one of two lines would hide the other."""
    if line.shape != other.shape:
        return False
    both = np.isfinite(line[1]) & np.isfinite(other[1])
    near = np.allclose(line[:, both], other[:, both], rtol=5e-3, atol=0.0)
    return bool(both.any() and near)
