"""Floor 8: the figure of the contacts: how many, how large, and which share of them sticks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from microslip.errors import InputError
from microslip.study.drawing import (
    add_legend,
    common_prefix,
    displacement_axis,
    draw_curves,
    drawn_loads,
    log_scale,
    new_figure,
)
from microslip.study.result import AmplitudeCurve, Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from microslip.study.result import Result

_POINTS = 80
_AREAS = ((1.0, "m²"), (1e-6, "mm²"), (1e-12, "µm²"), (1e-18, "nm²"))


def contact_state(result: Result) -> Figure:
    """Draw contacts and real area against the load, and the sticking share of the area.

    Parameters
    ----------
    result : Result
        What to draw, of a surface that knows its contacts.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, with a canvas.
    """
    figure = new_figure(6.6, result.study.title)
    surface = result.joints[0].surface
    loads, separations = _loads(result)
    counts = np.asarray(surface.contact_count(separations))
    # A single sphere has one contact whatever the load.
    names = ["area"] if np.ptp(counts) == 0.0 else ["count", "area"]
    layout: Any = [names, ["stick"] * len(names)]
    panels = figure.subplot_mosaic(layout, height_ratios=[1.0, 1.25])
    unit, letter = common_prefix([joint.normal_load for joint in result.joints])
    for name in names:
        panels[name].set_xlabel(f"Normal load [{letter}N]")
    if "count" in names:
        marks = [joint.contact_count for joint in result.joints]
        _over_load(panels["count"], result, loads / unit, counts, marks, unit)
        panels["count"].set_ylabel("Contacts")
    areas = np.asarray(surface.contact_area(separations))
    scale, label = _area_scale(result, float(areas.max()))
    marks = [joint.contact_area for joint in result.joints]
    _over_load(panels["area"], result, loads / unit, areas, marks, unit, scale)
    panels["area"].set_ylabel(label)
    _stick(panels["stick"], result)
    add_legend(figure, result, "marker")
    return figure


def _loads(result: Result) -> tuple[Floats, Floats]:
    """Normal loads [N] from below the lightest to above the heaviest, and their separations [m]."""
    joints = result.joints
    low = min(joint.normal_load for joint in joints)
    high = max(joint.normal_load for joint in joints)
    loads = np.geomspace(low / 3.0, 3.0 * high, _POINTS)
    try:
        return loads, np.asarray(joints[0].surface.separation(loads))
    except InputError:  # one of the loads is at the end of what the surface can answer
        order = np.argsort([joint.normal_load for joint in joints])
        own = [(joints[i].normal_load, joints[i].separation) for i in order]
        return np.array([load for load, _ in own]), np.array([place for _, place in own])


def _area_scale(result: Result, largest: float) -> tuple[float, str]:
    """What real areas [m²] are divided by, and the label of their axis."""
    apparent = getattr(result.study.surface, "area", None)
    if apparent is not None:
        return 0.01 * apparent, "Real over apparent area [%]"
    scale, name = next(((s, n) for s, n in _AREAS if largest >= 0.01 * s), _AREAS[-1])
    return scale, f"Contact area [{name}]"


def _over_load(
    axes: Axes,
    result: Result,
    loads: Floats,
    values: Floats,
    marks: list[float | None],
    unit: float,
    scale: float = 1.0,
) -> None:
    """A line over the loads, and a marker at each load of the study that is drawn."""
    axes.plot(loads, values / scale, color="#666666", zorder=1.9)
    for index, look in drawn_loads(result, "marker"):
        joint, mark = result.joints[index], marks[index]
        if mark is not None:
            axes.plot(joint.normal_load / unit, mark / scale, **look, markerfacecolor="white")
    log_scale(axes, "x")
    log_scale(axes, "y")


def _stick(axes: Axes, result: Result) -> None:
    axis = displacement_axis(result)
    axis.fit(axes)
    draw_curves(axes, result, axis, _share)
    axes.set_ylim(0.0, 1.05)
    axes.set_xlabel(axis.label.replace("Displacement amplitude", "Displacement from rest"))
    axes.set_ylabel("Sticking share of the contact area")


def _share(curve: AmplitudeCurve) -> Floats:
    share = curve.stick_share
    return np.full_like(curve.amplitude, np.nan) if share is None else share
