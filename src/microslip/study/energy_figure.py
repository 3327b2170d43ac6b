"""Floor 8: the figure of dissipated energy and damping against the amplitude."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import ScalarFormatter

from microslip.study.drawing import add_legend, drawn_loads, new_figure
from microslip.study.result import AmplitudeCurve, Floats
from microslip.study.units import prefix

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from microslip.study.result import Result

CUBIC = r"cubic limit, $\propto\delta_m^{\,3}$"
LINEAR = r"linear limit, $4\mu N\,\delta_m$"
DASHES = (0, (4, 2))


def energy_damping(result: Result) -> Figure:
    """Draw dissipated energy, loss factor and damping ratio against the amplitude.

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
    x_unit, x_letter = _length_prefix(result.curves[0].amplitude)
    _energy(above, result, x_unit)
    _damping(below, result, x_unit)
    below.set_xlabel(f"Displacement amplitude [{x_letter}m]")
    below.set_xlim(result.curves[0].amplitude[0] / x_unit, result.curves[0].amplitude[-1] / x_unit)
    figure.align_ylabels([above, below])
    add_legend(figure, result, "marker")
    _name_limits(figure, above, result, x_unit)
    return figure


def _length_prefix(amplitude: Any) -> tuple[float, str]:
    """Micrometres wherever they suit, since amplitudes of joints are read in them."""
    if amplitude[0] < 1e-3 and amplitude[-1] > 1e-7:
        return 1e-6, "µ"
    return prefix(float(amplitude[-1]))


def _curve(
    axes: Axes,
    curve: AmplitudeCurve,
    row: AmplitudeCurve,
    name: str,
    x_unit: float,
    look: dict[str, Any],
) -> None:
    """A line for the curve, and a marker where there is a loop."""
    axes.plot(curve.amplitude / x_unit, getattr(curve, name), color=look["color"])
    inside = (row.amplitude >= curve.amplitude[0]) & (row.amplitude <= curve.amplitude[-1])
    axes.plot(
        row.amplitude[inside] / x_unit,
        getattr(row, name)[inside],
        linestyle="none",
        markerfacecolor="white",
        zorder=3,
        **look,
    )


def _energy(axes: Axes, result: Result, x_unit: float) -> None:
    loads = drawn_loads(result, "marker")
    for index, look in loads:
        _curve(axes, result.curves[index], result.rows[index], "dissipated_energy", x_unit, look)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_ylabel("Dissipated energy per cycle [J]")
    energies = np.concatenate([result.curves[i].dissipated_energy for i, _ in loads])
    if (energies > 0.0).any():
        axes.set_ylim(energies[energies > 0.0].min() / 5.0, energies.max() * 10.0)
    for index, look in loads:
        style = {"color": look["color"], "linestyle": DASHES, "linewidth": 0.9, "zorder": 1.9}
        for line in _limit_lines(result, index):
            axes.plot(line[0] / x_unit, line[1], **style)


def _limit_lines(result: Result, index: int) -> list[tuple[Floats, Floats, str]]:
    """Where the energy tends to at small and at large amplitudes, with a name each."""
    curve, limit, joint = result.curves[index], result.limits[index], result.joints[index]
    a, energy = curve.amplitude, curve.dissipated_energy
    lines = []
    if limit.cubic_coefficient is not None:
        cubic = limit.cubic_coefficient * a**3
        near = cubic < 30.0 * energy
        lines.append((a[near], cubic[near], CUBIC))
    if limit.linear_offset is not None:
        linear = 4.0 * joint.force_limit * a
        near = linear < 30.0 * energy
        lines.append((a[near], linear[near], LINEAR))
    return lines


def _damping(axes: Axes, result: Result, x_unit: float) -> None:
    loads = drawn_loads(result, "marker")
    for index, look in loads:
        _curve(axes, result.curves[index], result.rows[index], "loss_factor", x_unit, look)
    top = 4.0 / math.pi
    factors = [result.curves[index].loss_factor for index, _ in loads]
    largest = max(float(np.nanmax(eta)) for eta in factors)
    left = min(float(eta[0]) for eta in factors)
    text = "full sliding (rigid–plastic): η = 4/π, ζ = 2/π"
    if largest > 0.2 * top:
        axes.axhline(top, color="#333333", linestyle=DASHES, linewidth=0.9, zorder=1.9)
        axes.set_ylim(0.0, 1.1 * top)
        y = (top if left < 0.6 * top else 0.9 * left) / (1.1 * top)
    else:
        text += ", above this scale"
        axes.set_ylim(0.0, 1.3 * largest)
        y = 1.0
    axes.annotate(
        text,
        (0.012, y),
        xycoords="axes fraction",
        xytext=(0, -3),
        textcoords="offset points",
        va="top",
        fontsize=8.5,
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.0},
    )
    axes.set_ylabel("Loss factor η")
    right = axes.secondary_yaxis("right", functions=(_half, _twice))
    for axis in (axes.yaxis, right.yaxis):  # both with a power of ten or both without
        axis.set_major_formatter(_formatter(largest))
    right.set_ylabel("Damping ratio ζ = η/2")


def _formatter(largest: float) -> ScalarFormatter:
    formatter = ScalarFormatter(useMathText=True)
    formatter.set_powerlimits((0, 0) if largest < 0.02 else (-9, 9))
    return formatter


def _half(y: Any) -> Any:
    return y / 2.0


def _twice(y: Any) -> Any:
    return 2.0 * y


def _name_limits(figure: Figure, axes: Axes, result: Result, x_unit: float) -> None:
    """Write the names of the limits above the uppermost line of each kind."""
    figure.draw_without_rendering()  # the slopes on paper are known once the layout is
    to_axes = axes.transAxes.inverted()
    upper: dict[str, Floats] = {}
    for index, _ in drawn_loads(result, "marker"):
        for a, energy, name in _limit_lines(result, index):
            points = axes.transData.transform(np.column_stack([a / x_unit, energy]))
            points = points[[bool(axes.bbox.contains(*point)) for point in points]]
            end = 0 if name == CUBIC else -1
            if len(points) > 1 and (name not in upper or points[end, 1] > upper[name][end, 1]):
                upper[name] = points
    for name, points in upper.items():
        along = points[-1] - points[0]
        length = math.hypot(*along)
        if length < 0.4 * axes.bbox.height:
            continue
        angle = math.atan2(along[1], along[0])
        cubic = name == CUBIC
        place = points[0] + 0.08 * along if cubic else points[-1] - 0.03 * along
        axes.annotate(
            name,
            tuple(to_axes.transform(place)),
            xycoords="axes fraction",
            xytext=(-5.0 * math.sin(angle), 5.0 * math.cos(angle)),
            textcoords="offset points",
            rotation=math.degrees(angle),
            rotation_mode="anchor",
            ha="left" if cubic else "right",
            va="bottom",
            fontsize=8.5,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5, "alpha": 0.8},
        ).set_in_layout(False)
