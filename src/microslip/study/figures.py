"""Floor 8: the figures of a result, through matplotlib's object interface alone."""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from typing import TYPE_CHECKING

from matplotlib import style
from matplotlib.figure import Figure

from microslip.study.drawing import STYLE, add_legend, drawn_loads, new_figure
from microslip.study.energy_figure import energy_damping
from microslip.study.result import some
from microslip.study.units import prefix

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from microslip.study.result import Result

MOST_PANELS = 6


def write(result: Result, path: Path) -> None:
    """Draw one figure and write it; name and suffix of the file say which and how.

    Parameters
    ----------
    result : Result
        What to draw.
    path : pathlib.Path
        `loops` or `energy_damping`, with the suffix `.svg` or `.png`.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    # From matplotlib's own defaults, whatever the user's matplotlibrc says, and back afterwards.
    with style.context(["default", STYLE]), warnings.catch_warnings():
        # The summary says it, once.
        warnings.filterwarnings("ignore", "Glyph .* missing from", UserWarning)
        figure = {"loops": loops, "energy_damping": energy_damping}[path.stem](result)
        metadata = {"Date": None} if path.suffix == ".svg" else {}
        figure.savefig(path, metadata={"Creator": None, **metadata} if metadata else None)


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
    amplitudes = result.rows[0].amplitude
    shown = some(len(amplitudes), MOST_PANELS)
    columns = 1 if len(shown) == 1 else 2 if len(shown) <= 4 else 3
    lines = math.ceil(len(shown) / columns)
    figure = new_figure(0.9 + (3.6 if columns == 1 else 2.5) * lines, result.study.title)
    panels = figure.subplots(lines, columns, squeeze=False).ravel()
    largest_x = float(amplitudes[shown].max())
    largest_y = max(float(r.force_amplitude[shown].max()) for r in result.rows)
    for panel, index in zip(panels, shown, strict=False):
        _loops_at(panel, result, index, largest_x, largest_y)
    for panel in panels[len(shown) :]:
        panel.set_visible(False)
    figure.align_ylabels(panels[: len(shown)])
    add_legend(figure, result, "linestyle")
    return figure


def _common_prefix(value: float, largest: float, least: float = 0.0) -> tuple[float, str]:
    """Prefix of the largest panel where it still suits this one, else its own."""
    unit, letter = prefix(largest)
    return (unit, letter) if value >= 0.0999 * unit else prefix(max(value, least))


def _loops_at(axes: Axes, result: Result, index: int, largest_x: float, largest_y: float) -> None:
    amplitude = float(result.rows[0].amplitude[index])
    # No markers: they would pass for measured points.
    loads = drawn_loads(result, "linestyle")
    limits = [result.joints[i].force_limit for i, _ in loads]
    # Loads far apart share no axis: then each loop is drawn over its own force limit.
    relative = max(limits) > 20.0 * min(limits)
    force = max(float(result.rows[i].force_amplitude[index]) for i, _ in loads)
    x_unit, x_letter = _common_prefix(amplitude, largest_x, 1e-9)
    y_unit, y_letter = _common_prefix(force, largest_y)
    for (i, look), limit in zip(loads, limits, strict=True):
        loop = result.loops[i][index]
        axes.plot(loop.displacement / x_unit, loop.force / (limit if relative else y_unit), **look)
    axes.set_title(f"Amplitude {amplitude / x_unit:.6g} {x_letter}m")
    axes.set_xlabel(f"Displacement [{x_letter}m]")
    axes.set_ylabel(r"Force / force limit, $T/\mu N$" if relative else f"Force [{y_letter}N]")
    axes.margins(0.06)
    axes.axhline(0.0, color="#888888", linewidth=0.6, zorder=1)
    axes.axvline(0.0, color="#888888", linewidth=0.6, zorder=1)
