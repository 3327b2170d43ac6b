"""Floor 8: the figure of the joint in an oscillator: what becomes of its damping in a mode."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import ScalarFormatter

from microslip.study.drawing import (
    DASHES,
    Axis,
    add_legend,
    common_prefix,
    displacement_axis,
    drawable,
    drawn_loads,
    far_apart,
    log_scale,
    new_figure,
    note,
)
from microslip.study.result import Floats, some

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from microslip.study.result import Result

_MARKS = 7
_DECADES = 8.0


def oscillator(result: Result) -> Figure:
    """Draw frequency and modal damping against the amplitude, with the interface's own damping.

    Parameters
    ----------
    result : Result
        What to draw, with oscillators.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, with a canvas.
    """
    figure = new_figure(7.4, result.study.title)
    above, middle, below = figure.subplots(3, 1, sharex=True, height_ratios=[2, 2, 3])
    axis = displacement_axis(result)
    for panel in (above, middle, below):
        axis.fit(panel)
    _frequency(above, middle, result, axis)
    _damping(below, result, axis)
    below.set_xlabel(axis.label)
    figure.align_ylabels([above, middle, below])
    add_legend(figure, result, "marker")
    return figure


def _frequency(above: Axes, middle: Axes, result: Result, axis: Axis) -> None:
    loads = drawn_loads(result, "marker")
    highest = [float(result.oscillators[i].frequency.max()) for i, _ in loads]
    unit, letter = common_prefix(highest)
    for index, look in loads:
        curve = result.oscillators[index]
        shift = 100.0 * (curve.frequency / curve.frequency[0] - 1.0)
        for panel, values in ((above, curve.frequency / unit), (middle, shift)):
            _line(panel, curve.amplitude / axis.unit, values, look)
    above.set_ylabel(f"Frequency [{letter}Hz]")
    middle.set_ylabel("Frequency shift [%]")
    note(middle, "from the smallest amplitude")
    if far_apart(highest):
        log_scale(above, "y")
    else:
        above.yaxis.set_major_formatter(ScalarFormatter(useOffset=False))
    middle.yaxis.set_major_formatter(ScalarFormatter(useOffset=False))


def _damping(axes: Axes, result: Result, axis: Axis) -> None:
    largest, least = [], []
    for index, look in drawn_loads(result, "marker"):
        curve = result.oscillators[index]
        x = curve.amplitude / axis.unit
        modal, own = (
            drawable(values, log=True)
            for values in (curve.damping_ratio, curve.interface_damping_ratio)
        )
        _line(axes, x, modal, look)
        axes.plot(x, own, color=look["color"], linestyle=DASHES, linewidth=0.9, zorder=1.9)
        for values in (modal, own):
            if np.isfinite(values).any():
                largest.append(float(np.nanmax(values)))
                least.append(float(np.nanmin(values)))
    log_scale(axes, "y")
    if largest:
        axes.set_ylim(max(0.5 * min(least), max(largest) * 10.0**-_DECADES), 3.0 * max(largest))
    axes.set_ylabel("Damping ratio ζ")
    note(axes, "solid: of the mode, dashed: of the interface alone, which is not the mode's")


def _line(axes: Axes, x: Floats, y: Floats, look: dict[str, Any]) -> None:
    """A line with a few markers, which tell the loads apart in grey."""
    axes.plot(x, y, **look, markerfacecolor="white", markevery=some(x.size, _MARKS))
