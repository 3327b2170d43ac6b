"""Floor 8: dissipated energy, damping and local exponent against either amplitude."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import ScalarFormatter

from microslip.study.drawing import (
    DASHES,
    MOST_MARKS,
    Axis,
    add_legend,
    displacement_axis,
    draw_curves,
    drawable,
    drawn_loads,
    force_axis,
    new_figure,
    note,
    settle,
)
from microslip.study.result import AmplitudeCurve, Floats, some
from microslip.study.varying import in_words

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.axes import Axes

    from microslip.study.result import Result
    from microslip.study.varying import VaryingCycles

CUBIC = r"cubic limit, $\propto\delta_m^{\,3}$"
CUBIC_IN_FORCE = r"cubic limit, $\propto T_m^{\,3}$"
LINEAR = r"linear limit, $4\mu N\,\delta_m$"
MOST_EXPONENT = 6.0


def energy_damping(result: Result) -> Figure:
    """Draw energy, loss factor, damping ratio and exponent against the displacement amplitude.

    Parameters
    ----------
    result : Result
        What to draw.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, with a canvas.
    """
    return _draw(result, displacement_axis(result))


def force_damping(result: Result) -> Figure:
    """Draw energy, loss factor, damping ratio and exponent against the force amplitude.

    Parameters
    ----------
    result : Result
        What to draw.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, with a canvas.
    """
    return _draw(result, force_axis(result))


def _draw(result: Result, axis: Axis) -> Figure:
    figure = new_figure(8.9, result.study.title)
    panels = figure.subplots(3, 1, sharex=True, height_ratios=[3, 2, 1.3])
    for panel in panels:
        axis.fit(panel)
        if axis.column == "force_amplitude":
            _mark_force_limits(panel, result, axis)
    _energy(panels[0], result, axis)
    _damping(panels[1], result, axis)
    _exponent(panels[2], result, axis)
    panels[2].set_xlabel(axis.label)
    figure.align_ylabels(panels)
    add_legend(figure, result, "marker")
    if (variation := result.study.excitation.load_variation) is not None:
        note(panels[0], f"hollow: constant load, filled: load varies by {in_words(variation)}")
    settle(figure)  # the slopes on paper are known once the layout is
    _name_limits(panels[0], result, axis)
    return figure


def _draw_varying(
    axes: Axes,
    result: Result,
    axis: Axis,
    constant: Floats,
    quantity: Callable[[VaryingCycles], Floats],
) -> Floats:
    """Mark the loops of a load that varies; ordinates drawn, with those at constant load."""
    if not result.varying:
        return constant
    drawn = [constant[np.isfinite(constant)]]
    for index, look in drawn_loads(result, "marker"):
        cycles = result.varying[index]
        marked = some(cycles.amplitude.size, MOST_MARKS)
        x, y = axis.of(cycles)[marked], drawable(quantity(cycles)[marked], log=True)
        seen = np.isfinite(y) & (x >= axis.low) & (x <= axis.high)
        axes.plot(x[seen], y[seen], linestyle="none", zorder=3.1, **look)
        drawn.append(y[seen])
    return np.concatenate(drawn)


def _mark_force_limits(axes: Axes, result: Result, axis: Axis) -> None:
    for index, look in drawn_loads(result, "marker"):
        axes.axvline(
            result.joints[index].force_limit / axis.unit,
            color=look["color"],
            linestyle=(0, (1, 2)),
            linewidth=1.0,
            zorder=1.8,
        )


# -- energy --------------------------------------------------------------------------------------


def _energy(axes: Axes, result: Result, axis: Axis) -> None:
    energies = draw_curves(axes, result, axis, lambda curve: curve.dissipated_energy, log=True)
    energies = _draw_varying(axes, result, axis, energies, lambda cycles: cycles.dissipated_energy)
    axes.set_ylabel("Dissipated energy per cycle [J]")
    if np.isfinite(energies).any():
        axes.set_ylim(energies.min() / 5.0, energies.max() * 10.0)
    for index, look in drawn_loads(result, "marker"):
        style = {"color": look["color"], "linestyle": DASHES, "linewidth": 0.9, "zorder": 1.9}
        for x, y, _ in _limit_lines(result, index, axis):
            axes.plot(x, y, **style)


def _limit_lines(result: Result, index: int, axis: Axis) -> list[tuple[Floats, Floats, str]]:
    """Where the energy tends to at small and at large amplitudes, with a name each."""
    curve, limit, joint = result.curves[index], result.limits[index], result.joints[index]
    a, energy = curve.amplitude, curve.dissipated_energy
    lines = []
    if axis.column == "force_amplitude":
        if limit.cubic_coefficient is not None:
            # At small amplitudes the displacement is the force over the stiffness at rest.
            force = curve.force_amplitude
            cubic = limit.cubic_coefficient * (force / joint.tangential_stiffness) ** 3
            lines.append((force / axis.unit, cubic, CUBIC_IN_FORCE))
        return lines
    if limit.cubic_coefficient is not None:
        cubic = limit.cubic_coefficient * a**3
        near = cubic < 30.0 * energy
        lines.append((a[near] / axis.unit, cubic[near], CUBIC))
    if limit.linear_offset is not None:
        linear = 4.0 * joint.force_limit * a
        near = linear < 30.0 * energy
        lines.append((a[near] / axis.unit, linear[near], LINEAR))
    return lines


def _name_limits(axes: Axes, result: Result, axis: Axis) -> None:
    """Write the names of the limits above the uppermost line of each kind."""
    to_axes = axes.transAxes.inverted()
    upper: dict[str, Floats] = {}
    for index, _ in drawn_loads(result, "marker"):
        for x, y, name in _limit_lines(result, index, axis):
            seen = (x > 0.0) & (y > 0.0)
            points = axes.transData.transform(np.column_stack([x[seen], y[seen]]))
            points = points[[bool(axes.bbox.contains(*point)) for point in points]]
            if len(points) > 1 and (name not in upper or _above(points, upper[name])):
                upper[name] = points
    for name, points in upper.items():
        along = points[-1] - points[0]
        length = math.hypot(*along)
        if length < 0.4 * axes.bbox.height:
            continue
        angle = math.atan2(along[1], along[0])
        left = name != LINEAR
        place = points[0] + 0.08 * along if left else points[-1] - 0.03 * along
        axes.annotate(
            name,
            tuple(to_axes.transform(place)),
            xycoords="axes fraction",
            xytext=(-5.0 * math.sin(angle), 5.0 * math.cos(angle)),
            textcoords="offset points",
            rotation=math.degrees(angle),
            rotation_mode="anchor",
            ha="left" if left else "right",
            va="bottom",
            fontsize=8.5,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5, "alpha": 0.8},
        ).set_in_layout(False)


def _above(points: Floats, others: Floats) -> bool:
    """Whether a line on paper, drawn out, lies above another that is all but parallel to it."""
    (x, y), (across, up) = points[0] - others[0], others[-1] - others[0]
    return bool(y * across > x * up)


# -- damping -------------------------------------------------------------------------------------


def _damping(axes: Axes, result: Result, axis: Axis) -> None:
    factors = draw_curves(axes, result, axis, lambda curve: curve.loss_factor)
    factors = _draw_varying(axes, result, axis, factors, lambda cycles: cycles.loss_factor)
    top = 4.0 / math.pi
    largest = float(np.nanmax(factors)) if np.isfinite(factors).any() else 0.0
    left = min(float(result.curves[i].loss_factor[0]) for i, _ in drawn_loads(result, "marker"))
    text = "full sliding (rigid–plastic): η = 4/π, ζ = 2/π"
    if largest > 0.2 * top:
        axes.axhline(top, color="#333333", linestyle=DASHES, linewidth=0.9, zorder=1.9)
        axes.set_ylim(0.0, 1.1 * top)
        y = (top if left < 0.6 * top else 0.9 * left) / (1.1 * top)
    else:
        text += ", above this scale"
        axes.set_ylim(0.0, 1.3 * largest if largest > 0.0 else 1.0)
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
    for side in (axes.yaxis, right.yaxis):  # both with a power of ten or both without
        side.set_major_formatter(_formatter(largest))
    right.set_ylabel("Damping ratio ζ = η/2")


def _formatter(largest: float) -> ScalarFormatter:
    formatter = ScalarFormatter(useMathText=0.0 < largest < 0.02)
    formatter.set_powerlimits((0, 0) if 0.0 < largest < 0.02 else (-9, 9))
    return formatter


def _half(y: Any) -> Any:
    return y / 2.0


def _twice(y: Any) -> Any:
    return 2.0 * y


# -- exponent ------------------------------------------------------------------------------------


def force_exponent(curve: AmplitudeCurve) -> Floats:
    """Local exponent of the energy in the force amplitude, d ln E / d ln T_m [-].

    The one in the displacement times d ln delta_m / d ln T_m, the secant over the tangent
    stiffness; infinite where the force no longer grows.
    """
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        return curve.dissipation_exponent * (curve.secant_stiffness / curve.tangent_stiffness)


def _exponent(axes: Axes, result: Result, axis: Axis) -> None:
    by_force = axis.column == "force_amplitude"
    values = draw_curves(
        axes, result, axis, force_exponent if by_force else lambda curve: curve.dissipation_exponent
    )
    for level in (3.0,) if by_force else (3.0, 1.0):
        axes.axhline(level, color="#333333", linestyle=DASHES, linewidth=0.9, zorder=1.9)
    lowest, highest = (values.min(), values.max()) if np.isfinite(values).any() else (1.0, 3.0)
    axes.set_ylim(
        max(0.0, min(float(lowest), 3.0 if by_force else 1.0) - 0.3),
        min(max(float(highest), 3.0) + 0.3, MOST_EXPONENT),
    )
    axes.set_ylabel(f"Local exponent\nd ln E / d ln {'T' if by_force else 'δ'}")
