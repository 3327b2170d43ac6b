"""Floor 8: the figure of the joint as Iwan's sliders."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from microslip._core.units import prefix
from microslip.study.drawing import (
    Axis,
    add_legend,
    displacement_axis,
    draw_curves,
    drawn_loads,
    new_figure,
    note,
)
from microslip.study.result import AmplitudeCurve, Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from microslip.friction import Sliders
    from microslip.study.result import Result

_DECADES = 6.0


def slider_density(result: Result) -> Figure:
    """Draw the density of sliders, their share of the force limit, and discrete sliders as stems.

    Parameters
    ----------
    result : Result
        What to draw.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, with a canvas.
    """
    sliders = {i: result.joints[i].sliders() for i, _ in drawn_loads(result, "marker")}
    axis = displacement_axis(result)
    discrete = any(s.yield_displacements.size for s in sliders.values())
    spread = any(_peak(result.curves[i]) > 0.0 for i in sliders)
    kinds = ["density"] * spread + ["stems"] * discrete + ["share"]
    figure = new_figure(1.2 + 2.9 * len(kinds), result.study.title)
    panels = dict(
        zip(kinds, figure.subplots(len(kinds), 1, sharex=True, squeeze=False)[:, 0], strict=True)
    )
    for panel in panels.values():
        axis.fit(panel)
    _share(panels["share"], result, axis)
    if spread:
        _density(panels["density"], result, axis)
    if discrete:
        _stems(panels["stems"], result, axis, sliders)
    panels[kinds[-1]].set_xlabel(
        axis.label.replace("Displacement amplitude", "Yield displacement of the slider")
    )
    figure.align_ylabels(list(panels.values()))
    add_legend(figure, result, "marker")
    return figure


def _peak(curve: AmplitudeCurve) -> float:
    """Largest density that can be drawn; it is infinite at the slip limits of given summits."""
    density = curve.slider_density
    return float(density[np.isfinite(density)].max(initial=0.0))


def _density(axes: Axes, result: Result, axis: Axis) -> None:
    values = draw_curves(axes, result, axis, lambda curve: curve.slider_density, log=True)
    peaks = [_peak(result.curves[i]) for i, _ in drawn_loads(result, "marker")]
    floor = 10.0**-_DECADES * min(peak for peak in peaks if peak > 0.0)
    axes.set_ylim(max(0.3 * float(values.min()), floor), 3.0 * max(peaks))
    axes.set_ylabel(r"Slider density $-T_0''$ [N/m²]")
    note(axes, "stiffness of the spread sliders per yield displacement")


def _share(axes: Axes, result: Result, axis: Axis) -> None:
    draw_curves(axes, result, axis, slipping_share)
    axes.set_ylim(0.0, 1.05)
    axes.set_ylabel("Share of the force limit")
    note(axes, "what the sliders up to this yield displacement carry when all slip")


def slipping_share(curve: AmplitudeCurve) -> Floats:
    """Share of the force limit that sliders up to a yield displacement carry [-].

    (T0 - u T0')/mu N, unlike the density finite for every surface; discrete sliders are its jumps.
    """
    share = curve.force_ratio * (1.0 - curve.tangent_stiffness / curve.secant_stiffness)
    return np.maximum(share, 0.0)


def _stems(axes: Axes, result: Result, axis: Axis, sliders: dict[int, Sliders]) -> None:
    unit, letter = prefix(
        max(float(s.stiffnesses.max()) for s in sliders.values() if s.stiffnesses.size)
    )
    for index, look in drawn_loads(result, "marker"):
        found = sliders[index]
        x, y = found.yield_displacements / axis.unit, found.stiffnesses / unit
        axes.vlines(x, 0.0, y, color=look["color"], linewidth=1.0)
        axes.plot(x, y, linestyle="none", markerfacecolor="white", zorder=3, **look)
    axes.set_ylim(bottom=0.0)
    axes.set_ylabel(f"Slider stiffness [{letter}N/m]")
    note(axes, "discrete sliders")
