"""Floor 8: the figure of the answer to an own record of displacements or forces."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from microslip._core.units import prefix
from microslip.study.drawing import (
    add_legend,
    drawn_loads,
    far_apart,
    length_prefix,
    new_figure,
)
from microslip.study.result import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from microslip.study.result import Result

MOST_VECTORS = 6000
"""Samples, of all loads, up to which an SVG file has lines; beyond there is a picture in it."""
MOST_SAMPLES = 20_000
"""Samples of a load up to which each of them is drawn."""
_STRETCHES, _GRID = 750, 1500
_LABELS = {
    "displacement": ("Displacement", "m"),
    "force": ("Force", "N"),
    "varying_normal_load": ("Normal load", "N"),
    "dissipated_energy": ("Dissipated energy", "J"),
}
_MANY = 3000
_RASTER = 2.4  # between the curves, from 2 on, and the frame


def history(result: Result) -> Figure:
    """Draw displacement, force and dissipated energy over the samples, and force on displacement.

    A normal load that varies is drawn as well.

    Parameters
    ----------
    result : Result
        What to draw, with histories.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, with a canvas.
    """
    names = [name for name in _LABELS if name in result.histories[0].columns()]
    figure = new_figure(5.4 + 1.5 * (len(names) - 3), result.study.title)
    panels = figure.subplot_mosaic(
        [[name, "path"] for name in names],
        width_ratios=[1.0, 1.05],
    )
    loads = drawn_loads(result, "linestyle")
    count = result.histories[0].force.size
    columns: dict[str, list[Floats]] = {}
    for name in names:
        columns[name], label = _scaled([getattr(result.histories[i], name) for i, _ in loads], name)
        panels[name].set_ylabel(label)
    # What was given is the same for all loads, and has the colour of none.
    given = result.study.excitation.history
    common = given.quantity if given is not None and len(loads) > 1 else None
    alike = {common, "varying_normal_load"} & set(names) if common is not None else set()
    for name in alike:
        panels[name].plot(*envelope(columns[name][0]), color="#666666", linewidth=0.9)
    answers = columns["displacement" if common == "force" else "force"]
    for number, (_, look) in enumerate(loads):
        # The smaller in front of the larger, which would hide it.
        look |= {"zorder": 2.0 + 0.1 / (1.0 + float(np.abs(answers[number]).max()))}
        if count > _MANY:
            look |= {"linewidth": 0.7}
        if count > MOST_SAMPLES:  # of strokes shorter than a dash
            look |= {"linestyle": "-"}
        for name, values in columns.items():
            if name not in alike:
                panels[name].plot(*envelope(values[number]), **look)
        panels["path"].plot(*path(*(columns[k][number] for k in ("displacement", "force"))), **look)
    if count * len(loads) > MOST_VECTORS:
        for panel in panels.values():
            panel.set_rasterization_zorder(_RASTER)
    _dress(panels)
    figure.align_ylabels([panels[name] for name in columns])
    # Beside a load that varies it is no more than where that begins.
    starts = "Normal load, starts at" if "varying_normal_load" in names else "Normal load"
    add_legend(figure, result, "linestyle", starts)
    return figure


def _scaled(values: list[Floats], name: str) -> tuple[list[Floats], str]:
    """Columns of all loads in one unit, or each over its own largest value; and their label."""
    label, symbol = _LABELS[name]
    sizes = [float(np.abs(column).max()) for column in values]
    if far_apart(sizes, 50.0):
        own = [column / (size or 1.0) for column, size in zip(values, sizes, strict=True)]
        return own, f"{label} / largest"
    unit, letter = length_prefix(max(sizes)) if symbol == "m" else prefix(max(sizes))
    return [column / unit for column in values], f"{label} [{letter}{symbol}]"


def _dress(panels: dict[str, Axes]) -> None:
    for name in set(panels) - {"dissipated_energy", "path"}:
        panels[name].tick_params(labelbottom=False)
        panels[name].sharex(panels["dissipated_energy"])
    panels["dissipated_energy"].set_xlabel("Sample")
    panels["dissipated_energy"].ticklabel_format(axis="x", scilimits=(-9, 9))
    panels["dissipated_energy"].locator_params(axis="x", nbins=4, integer=True)
    beside = panels["path"]
    beside.set_xlabel(panels["displacement"].get_ylabel())
    beside.set_ylabel(panels["force"].get_ylabel())
    beside.yaxis.set_label_position("right")
    beside.yaxis.tick_right()
    for draw in (beside.axhline, beside.axvline):
        draw(0.0, color="#888888", linewidth=0.6, zorder=1)


def envelope(values: Floats) -> tuple[Floats, Floats]:
    """Places and values of a record; of a long one only the extremes of each stretch."""
    if values.size <= MOST_SAMPLES:
        return np.arange(values.size, dtype=np.float64), values
    width = -(-values.size // _STRETCHES)
    whole = values[: values.size // width * width].reshape(-1, width)
    starts = width * np.arange(len(whole))
    ends = np.sort(np.stack([whole.argmin(axis=1), whole.argmax(axis=1)]), axis=0) + starts
    places = np.concatenate(([0], ends.T.ravel(), np.arange(whole.size, values.size)))
    return places.astype(np.float64), values[places]


def path(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """A path; of a long one each stroke on a fine grid once, since cycles repeat themselves."""
    if x.size <= MOST_SAMPLES:
        return x, y
    cells = np.stack([np.round((v - v.min()) / (np.ptp(v) or 1.0) * _GRID) for v in (x, y)])
    strokes = np.concatenate((cells[:, :-1], cells[:, 1:])).astype(np.int64)
    keys = ((strokes[0] * 2048 + strokes[1]) * 2048 + strokes[2]) * 2048 + strokes[3]
    first = np.sort(np.unique(keys, return_index=True)[1])
    # A run of strokes that follow each other is one line, and a gap parts it from the next.
    ends = np.flatnonzero(np.diff(first, append=x.size + 1) > 1)
    places = np.repeat(ends + 1, 2)
    lines = []
    for values in (x, y):
        gaps = np.full(2 * ends.size, np.nan)
        gaps[::2] = values[first[ends] + 1]
        lines.append(np.insert(values[first], places, gaps))
    return lines[0], lines[1]
