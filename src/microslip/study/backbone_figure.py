"""Floor 8: the figure of the first loading curve and of its stiffness."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from microslip.study.drawing import (
    DASHES,
    Axis,
    add_legend,
    common_prefix,
    displacement_axis,
    draw_curves,
    drawable,
    drawn_loads,
    far_apart,
    new_figure,
    note,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from microslip.study.result import Result


def backbone(result: Result) -> Figure:
    """Draw the force of first loading, and its tangent and secant stiffness.

    Parameters
    ----------
    result : Result
        What to draw.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, with a canvas.
    """
    figure = new_figure(7.4, result.study.title)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[3, 2])
    axis = displacement_axis(result)
    for panel in (above, below):
        axis.fit(panel)
    _force(above, result, axis)
    _stiffness(below, result, axis)
    below.set_xlabel(axis.label.replace("Displacement amplitude", "Displacement"))
    figure.align_ylabels([above, below])
    add_legend(figure, result, "marker")
    return figure


def _force(axes: Axes, result: Result, axis: Axis) -> None:
    loads = drawn_loads(result, "marker")
    limits = [result.joints[i].force_limit for i, _ in loads]
    unit, letter = common_prefix(limits)
    forces = draw_curves(axes, result, axis, lambda curve: curve.force_amplitude / unit, log=True)
    if np.isfinite(forces).any():
        axes.set_ylim(0.5 * forces.min(), 3.0 * max(limits) / unit)
    for (index, look), limit in zip(loads, limits, strict=True):
        joint, curve = result.joints[index], result.curves[index]
        style = {"color": look["color"], "linestyle": DASHES, "linewidth": 0.9, "zorder": 1.9}
        stuck = joint.tangential_stiffness * curve.amplitude
        near = stuck < 6.0 * limit
        axes.plot(axis.of(curve)[near], stuck[near] / unit, **style)
        axes.axhline(limit / unit, **style)
    axes.set_ylabel(f"Force of first loading [{letter}N]")
    note(axes, r"dashed: all stick, $T = k_t\,\delta$, and all slip, $T = \mu N$")


def _stiffness(axes: Axes, result: Result, axis: Axis) -> None:
    loads = drawn_loads(result, "marker")
    rest = [result.joints[i].tangential_stiffness for i, _ in loads]
    unit, letter = common_prefix(rest)
    log = far_apart(rest)
    draw_curves(axes, result, axis, lambda curve: curve.tangent_stiffness / unit, log=log)
    for index, look in loads:
        curve = result.curves[index]
        secant = drawable(curve.secant_stiffness / unit, log)
        axes.plot(axis.of(curve), secant, color=look["color"], linestyle=DASHES, linewidth=0.9)
    if log:
        axes.set_ylim(1e-3 * min(rest) / unit, 3.0 * max(rest) / unit)
    else:
        axes.set_ylim(0.0, 1.08 * max(rest) / unit)
    axes.set_ylabel(f"Stiffness [{letter}N/m]")
    note(axes, r"solid: tangent $\mathrm{d}T/\mathrm{d}\delta$, dashed: secant $T/\delta$")
