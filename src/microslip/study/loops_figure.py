"""Floor 8: the figure of the hysteresis loops."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from microslip._core.units import engineering, prefix
from microslip.study.drawing import (
    add_legend,
    drawn_loads,
    far_apart,
    new_figure,
)
from microslip.study.result import some
from microslip.study.varying import in_words

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from microslip.study.result import Result

MOST_PANELS = 6


def loops(result: Result) -> Figure:
    """Draw the hysteresis loops, one panel for each amplitude, one loop for each load.

    Parameters
    ----------
    result : Result
        What to draw.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, with a canvas.
    """
    count = len(result.rows[0].amplitude)
    shown = some(count, MOST_PANELS)
    columns = 1 if len(shown) == 1 else 2 if len(shown) <= 4 else 3
    lines = math.ceil(len(shown) / columns)
    figure = new_figure(0.9 + (3.6 if columns == 1 else 2.5) * lines, result.study.title)
    panels = figure.subplots(lines, columns, squeeze=False).ravel()
    largest_x = max(float(row.amplitude[shown].max()) for row in result.rows)
    rows = result.varying or result.rows
    largest_y = max(float(row.force_amplitude[shown].max()) for row in rows)
    # Loops far apart share no axis: then each is drawn over its own amplitude, in all panels alike.
    loads = drawn_loads(result, "linestyle")
    over_amplitude = any(
        far_apart([float(result.rows[i].amplitude[index]) for i, _ in loads]) for index in shown
    )
    for panel, index in zip(panels, shown, strict=False):
        _loops_at(panel, result, index, (largest_x, largest_y), over_amplitude)
    for panel in panels[len(shown) :]:
        panel.set_visible(False)
    figure.align_ylabels(panels[: len(shown)])
    variation = result.study.excitation.load_variation
    mean = "" if variation is None else f"Mean normal load, which varies by {in_words(variation)}"
    add_legend(figure, result, "linestyle", mean)
    return figure


def _prefix(value: float, largest: float, least: float = 0.0) -> tuple[float, str]:
    """Prefix of the largest panel where it still suits this one, else its own."""
    unit, letter = prefix(largest)
    return (unit, letter) if value >= 0.0999 * unit else prefix(max(value, least))


def _loops_at(
    axes: Axes, result: Result, index: int, largest: tuple[float, float], over_amplitude: bool
) -> None:
    # No markers: they would pass for measured points.
    loads = drawn_loads(result, "linestyle")
    amplitudes = [float(result.rows[i].amplitude[index]) for i, _ in loads]
    limits = [result.joints[i].force_limit for i, _ in loads]
    rows = result.varying or result.rows
    forces = [float(rows[i].force_amplitude[index]) for i, _ in loads]
    by_force = result.study.excitation.force_amplitudes is not None
    # As the amplitudes, force limits far apart share no axis.
    over_limit = far_apart(limits) and not by_force
    x_unit, x_letter = _prefix(max(amplitudes), largest[0], min(1e-9, largest[0]))
    y_unit, y_letter = _prefix(max(forces), largest[1])
    for (i, look), amplitude, limit in zip(loads, amplitudes, limits, strict=True):
        loop = result.loops[i][index]
        axes.plot(
            loop.displacement / (amplitude if over_amplitude else x_unit),
            loop.force / (limit if over_limit else y_unit),
            **look,
        )
    if by_force:
        axes.set_title(f"Force amplitude {engineering(forces[0], 'N', 6, trim=True)}")
    else:
        axes.set_title(f"Amplitude {amplitudes[0] / x_unit:.6g} {x_letter}m")
    if result.varying:
        axes.set_title(f"{axes.get_title()}, load varies")
    axes.set_xlabel(
        r"Displacement / amplitude, $\delta/\delta_m$"
        if over_amplitude
        else f"Displacement [{x_letter}m]"
    )
    axes.set_ylabel(r"Force / force limit, $T/\mu N$" if over_limit else f"Force [{y_letter}N]")
    axes.margins(0.06)
    axes.axhline(0.0, color="#888888", linewidth=0.6, zorder=1)
    axes.axvline(0.0, color="#888888", linewidth=0.6, zorder=1)
