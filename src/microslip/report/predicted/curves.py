"""Figures of quantities against amplitude: shared axes, legend and curves; energy and damping."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from microslip._core.quantities import QUANTITIES
from microslip._core.units import engineering
from microslip.figures.kit import (
    LOOKS,
    LineStyle,
    between,
    drawable,
    evenly,
    length_prefix,
    pale,
    visible_values,
)
from microslip.figures.plot import (
    Axis,
    Floats,
    Guide,
    Panel,
    Plot,
    Words,
    stacked,
)
from microslip.study.runs.columns import AmplitudeCurve
from microslip.study.runs.prediction import Prediction

MOST_LOADS = 6
_MOST_MARKS = 12

CurveValues = Callable[[AmplitudeCurve], Floats]


def drawn_loads(result: Prediction) -> list[tuple[int, LineStyle]]:
    """Return the index and the line style of each load that is drawn."""
    return list(zip(evenly(len(result.joints), MOST_LOADS), LOOKS, strict=False))


def add_legend(plot: Plot, result: Prediction, *, dashed: bool = False) -> Plot:
    """Add a legend of the loads, and the title of the study."""
    loads = drawn_loads(result)
    left_out = len(result.joints) - len(loads)
    plot.legend_title = "Normal load" + (f" ({left_out} more in the tables)" if left_out else "")
    plot.legend = tuple(
        look.entry(_label(result.joints[index]), line=dashed, marked=not dashed)
        for index, look in loads
    )
    plot.title = result.study.title
    return plot


class AmplitudeAxis(NamedTuple):
    """Displacement amplitude as abscissa."""

    unit: float
    """Divisor of its values [m]."""
    label: str
    low: float
    """Left end, divided by the unit."""
    high: float

    def of(self, curve: AmplitudeCurve) -> Floats:
        """Return the amplitudes of a curve in the unit of the axis."""
        return curve.amplitude / self.unit

    def panel(self, y: Axis, note: str = "") -> Panel:
        """Return a panel with this abscissa and the ordinate ``y``."""
        return Panel(Axis(self.label, self.low, self.high, log=True), y, note)


def displacement_axis(result: Prediction, name: str = "Displacement amplitude") -> AmplitudeAxis:
    """Return the axis of the displacement amplitude over the range of the curves."""
    curves = [result.curves[index] for index, _ in drawn_loads(result)]
    low = min(float(curve.amplitude[0]) for curve in curves)
    high = max(float(curve.amplitude[-1]) for curve in curves)
    unit, letter = length_prefix(high, low)
    low, high = (
        (low / unit, high / unit) if high > 1.01 * low else (low / 1.2 / unit, high * 1.2 / unit)
    )
    return AmplitudeAxis(unit, f"{name} [{letter}m]", low, high)


def some_drawn(values: Floats) -> Floats:
    """Return the values that can be drawn on a linear axis; a single NaN if there are none."""
    return finite if (finite := visible_values(values, False)).size else np.array([np.nan])


def draw_curves(
    panel: Panel, result: Prediction, axis: AmplitudeAxis, quantity: CurveValues
) -> Floats:
    """Draw a quantity for every load: a line, and markers at the amplitudes of the loops.

    Return the ordinates that can be drawn: positive ones on a logarithmic axis.
    """
    loads = drawn_loads(result)
    lines = [
        np.stack([axis.of(result.curves[i]), drawable(quantity(result.curves[i]), panel.y.log)])
        for i, _ in loads
    ]
    bands = [_band(panel, result, axis, quantity, number) for number in range(len(loads))]
    for number, (index, look) in enumerate(loads):
        curve, row = result.curves[index], result.rows[index]
        x, y = lines[number]
        panel.line(x, y, look.color)
        inside = (row.amplitude >= curve.amplitude[0]) & (row.amplitude <= curve.amplitude[-1])
        marked = np.flatnonzero(inside)
        if marked.size:
            marked = marked[evenly(marked.size, _MOST_MARKS)]
            x, y = axis.of(row)[marked], drawable(quantity(row), panel.y.log)[marked]
        else:  # markers distinguish loads in greyscale
            places = evenly(x.size, 7)
            x, y = x[places], y[places]
        panel.marks(x, y, look.color, marker=look.marker)
    return some_drawn(np.concatenate([*(line[1] for line in lines), *bands]))


def _band(
    panel: Panel, result: Prediction, axis: AmplitudeAxis, quantity: CurveValues, number: int
) -> Floats:
    """Shade the range between the outermost quantiles at load ``number``; return its ordinates."""
    scatter = result.scatter
    index, look = drawn_loads(result)[number]
    if scatter is None:
        return np.zeros(0)
    curve = result.curves[index]
    edges = [
        drawable(quantity(scatter.curve(end, index, curve.amplitude)), panel.y.log)
        for end in (0, scatter.quantiles.size - 1)
    ]
    area = between(axis.of(curve), edges[0], edges[1], pale(look.color))
    panel.items.insert(0, area)
    return area.y


def _label(joint: Any) -> str:
    if not hasattr(joint, "normal_load"):
        return type(joint).__name__
    return engineering(joint.normal_load, "N", trim=True)


MOST_EXPONENT = 6.0


def energy_damping(result: Prediction) -> Plot:
    """Plot energy, loss factor, damping ratio and energy exponent against displacement."""
    axis = displacement_axis(result)
    panels = [make(result, axis) for make in (_energy, _damping, _exponent)]
    return add_legend(stacked(panels, 8.9, (3.0, 2.0, 1.3)), result)


def _energy(result: Prediction, axis: AmplitudeAxis) -> Panel:
    panel = axis.panel(Axis("Dissipated energy per cycle [J]", log=True))
    energies = draw_curves(panel, result, axis, lambda curve: curve.dissipated_energy)
    if np.isfinite(energies).any():
        panel.y.low, panel.y.high = float(energies.min()) / 5.0, float(energies.max()) * 10.0
    return panel


def _damping(result: Prediction, axis: AmplitudeAxis) -> Panel:
    # Logarithmic like the energy, because loss factors are small in the usual range.
    panel = axis.panel(Axis(f"{QUANTITIES['loss_factor'].label} = 2ζ", log=True))
    top = 4.0 / math.pi
    factors = draw_curves(panel, result, axis, lambda curve: curve.loss_factor)
    drawable = np.isfinite(factors).any()
    largest, smallest = (
        (float(np.nanmax(factors)), float(np.nanmin(factors))) if drawable else (1.0, 0.1)
    )
    text = "full sliding (rigid–plastic): η = 4/π, ζ = 2/π"
    if largest > 0.1 * top:
        panel.items.insert(0, Guide(top))
        panel.y.high = 4.0 * max(top, largest)
    else:
        text += ", above this scale"
        panel.y.high = 4.0 * largest
    panel.y.low = max(0.5 * smallest, 1e-5 * panel.y.high)
    panel.add(Words(0.012, 0.98, text))
    return panel


def _exponent(result: Prediction, axis: AmplitudeAxis) -> Panel:
    panel = axis.panel(Axis("Local exponent\nd ln E / d ln δ"))
    panel.add(Guide(3.0), Guide(1.0))
    values = draw_curves(panel, result, axis, lambda curve: curve.dissipation_exponent)
    lowest, highest = (
        (float(values.min()), float(values.max())) if np.isfinite(values).any() else (1.0, 3.0)
    )
    panel.y.low = max(0.0, min(lowest, 1.0) - 0.3)
    panel.y.high = min(max(highest, 3.0) + 0.3, MOST_EXPONENT)
    return panel
