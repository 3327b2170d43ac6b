"""Figures of a prediction, as plot descriptions, and their captions."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from microslip._core.quantities import QUANTITIES, Quantity, dimensionless
from microslip._core.units import engineering
from microslip.figures.kit import (
    LineStyle,
    axis_of,
    between,
    drawable,
    evenly,
    far_apart,
    length_prefix,
    line_style,
    pale,
)
from microslip.figures.plot import (
    DASHED,
    THIN,
    Axis,
    Floats,
    Guide,
    Panel,
    Plot,
    Words,
    stacked,
)
from microslip.report.predicted.numbers import driven
from microslip.study.runs.columns import AmplitudeCurve
from microslip.study.runs.prediction import Prediction

MOST_LOADS = 6
_MOST_MARKS = 12

_FROM_REST = Quantity("m", label="Displacement from rest")
_FIRST_FORCE = Quantity("N", label="Force of first loading")

CurveValues = Callable[[AmplitudeCurve], Floats]


def drawn_loads(result: Prediction) -> list[tuple[int, LineStyle]]:
    """Return the index and the line style of each load that is drawn."""
    places = evenly(len(result.joints), MOST_LOADS)
    return [(index, line_style(number)) for number, index in enumerate(places)]


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


def amplitude_panel(
    result: Prediction, y: Axis, note: str = "", x: Quantity = QUANTITIES["amplitude"]
) -> Panel:
    """Return a panel over the amplitudes of the curves, with the ordinate ``y``."""
    curves = [result.curves[index] for index, _ in drawn_loads(result)]
    low = min(float(curve.amplitude[0]) for curve in curves)
    high = max(float(curve.amplitude[-1]) for curve in curves)
    scale = length_prefix(high, low)
    if high <= 1.01 * low:
        low, high = low / 1.2, high * 1.2
    ends = {"low": low / scale[0], "high": high / scale[0]}
    return Panel(axis_of(x, scale, log=True, **ends), y, note)


def draw_curves(panel: Panel, result: Prediction, quantity: CurveValues) -> Floats:
    """Draw a quantity for every load: a line, and markers at the amplitudes of the loops.

    Return the ordinates that can be drawn: positive ones on a logarithmic axis; a single NaN if
    there are none.
    """
    loads = drawn_loads(result)
    lines = [
        (
            result.curves[i].amplitude / panel.x.unit,
            drawable(quantity(result.curves[i]), panel.y.log),
        )
        for i, _ in loads
    ]
    bands = [_band(panel, result, quantity, index, look.color) for index, look in loads]
    for (index, look), (x, y) in zip(loads, lines, strict=True):
        curve, row = result.curves[index], result.rows[index]
        panel.line(x, y, look.color)
        inside = (row.amplitude >= curve.amplitude[0]) & (row.amplitude <= curve.amplitude[-1])
        marked = np.flatnonzero(inside)
        if marked.size:
            marked = marked[evenly(marked.size, _MOST_MARKS)]
            x, y = (
                row.amplitude[marked] / panel.x.unit,
                drawable(quantity(row), panel.y.log)[marked],
            )
        else:  # markers distinguish loads in greyscale
            places = evenly(x.size, 7)
            x, y = x[places], y[places]
        panel.marks(x, y, look.color, marker=look.marker)
    drawn = np.concatenate([*(line[1] for line in lines), *bands])
    finite = drawn[np.isfinite(drawn)]
    return finite if finite.size else np.array([np.nan])


def _band(
    panel: Panel, result: Prediction, quantity: CurveValues, index: int, color: str
) -> Floats:
    """Shade the range between the outermost quantiles at a load; return its ordinates."""
    scatter = result.scatter
    if scatter is None:
        return np.zeros(0)
    curve = result.curves[index]
    edges = [
        drawable(quantity(scatter.curve(end, index, curve.amplitude)), panel.y.log)
        for end in (0, scatter.quantiles.size - 1)
    ]
    area = between(curve.amplitude / panel.x.unit, edges[0], edges[1], pale(color))
    panel.items.insert(0, area)
    return area.y


def _label(joint: Any) -> str:
    if not hasattr(joint, "normal_load"):
        return type(joint).__name__
    return engineering(joint.normal_load, "N", trim=True)


MOST_EXPONENT = 6.0


def energy_damping(result: Prediction) -> Plot:
    """Plot energy, loss factor, damping ratio and energy exponent against displacement."""
    panels = [_energy(result), _damping(result), _exponent(result)]
    return add_legend(stacked(panels, 8.9, (3.0, 2.0, 1.3)), result)


def _energy(result: Prediction) -> Panel:
    panel = amplitude_panel(result, axis_of(QUANTITIES["dissipated_energy"], log=True))
    energies = draw_curves(panel, result, lambda curve: curve.dissipated_energy)
    if np.isfinite(energies).any():
        panel.y.low, panel.y.high = float(energies.min()) / 5.0, float(energies.max()) * 10.0
    return panel


def _damping(result: Prediction) -> Panel:
    # Logarithmic like the energy, because loss factors are small in the usual range.
    panel = amplitude_panel(result, axis_of(QUANTITIES["loss_factor"], log=True))
    top = 4.0 / math.pi
    factors = draw_curves(panel, result, lambda curve: curve.loss_factor)
    largest, smallest = 1.0, 0.1
    if np.isfinite(factors).any():
        largest, smallest = float(factors.max()), float(factors.min())
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


def _exponent(result: Prediction) -> Panel:
    panel = amplitude_panel(result, axis_of(dimensionless("Local exponent\nd ln E / d ln δ")))
    panel.add(Guide(3.0), Guide(1.0))
    values = draw_curves(panel, result, lambda curve: curve.dissipation_exponent)
    lowest, highest = 1.0, 3.0
    if np.isfinite(values).any():
        lowest, highest = float(values.min()), float(values.max())
    panel.y.low = max(0.0, min(lowest, 1.0) - 0.3)
    panel.y.high = min(max(highest, 3.0) + 0.3, MOST_EXPONENT)
    return panel


MOST_LOOP_PANELS = 6


# -- loops -----------------------------------------------------------------------------------------


def loops(result: Prediction) -> Plot:
    """Plot hysteresis loops, one panel for each amplitude, one loop for each load."""
    indices = evenly(len(result.rows[0].amplitude), MOST_LOOP_PANELS)
    columns = 1 if len(indices) == 1 else 2 if len(indices) <= 4 else 3
    # Loops of very different size are drawn relative to their amplitudes, in all panels.
    loads = drawn_loads(result)
    over_amplitude = any(
        far_apart([float(result.rows[i].amplitude[index]) for i, _ in loads]) for index in indices
    )
    panels = [_loops_at(result, i, over_amplitude) for i in indices]
    for number, panel in enumerate(panels):
        row, column = divmod(number, columns)
        panel.cell = (row, row, column, column)
    rows = panels[-1].cell[0] + 1
    height = 0.9 + (3.6 if columns == 1 else 2.5) * rows
    plot = Plot(panels, height, heights=(1.0,) * rows, widths=(1.0,) * columns)
    return add_legend(plot, result, dashed=True)


def _loops_at(result: Prediction, index: int, over_amplitude: bool) -> Panel:
    # No markers, which would look like measured points.
    loads = drawn_loads(result)
    amplitudes = [float(result.rows[i].amplitude[index]) for i, _ in loads]
    limits = [result.joints[i].force_limit for i, _ in loads]
    forces = [float(result.rows[i].force_amplitude[index]) for i, _ in loads]
    by = driven(result)
    # Likewise for very different force limits.
    over_limit = far_apart(limits) and by == "amplitude"
    x = axis_of(QUANTITIES["displacement"], max(amplitudes))
    y = axis_of(QUANTITIES["force"], max(forces))
    if over_amplitude:
        x = axis_of(dimensionless("Displacement over amplitude δ/δₘ"))
    if over_limit:
        y = axis_of(dimensionless("Force over force limit T/μN"))
    given = (forces if by == "force_amplitude" else amplitudes)[0]
    amplitude_text = engineering(given, QUANTITIES[by].unit, 6, trim=True)
    panel = Panel(x, y, f"{QUANTITIES[by].label} {amplitude_text}")
    for (i, look), amplitude, limit in zip(loads, amplitudes, limits, strict=True):
        loop = result.loops[i][index]
        across = loop.displacement / (amplitude if over_amplitude else x.unit)
        unit = limit if over_limit else y.unit
        for band in _loop_bands(result, i, index):
            panel.line(across, band / unit, look.color, width=0.6, dash=DASHED)
        panel.line(across, loop.force / unit, look.color, dash=look.dash)
    panel.cross()
    return panel


def _loop_bands(result: Prediction, load: int, index: int) -> list[Floats]:
    """Return the lowest and the highest quantile of the force at each point of a loop."""
    if result.scatter is None or "force" not in result.scatter.bands:
        return []
    band = result.scatter.bands["force"].values
    return [band[0, load, index], band[-1, load, index]]


# -- first loading ---------------------------------------------------------------------------------


def backbone(result: Prediction) -> Plot:
    """Plot the force, tangent stiffness and secant stiffness on first loading."""
    panels = [_force(result), _stiffness(result)]
    return add_legend(stacked(panels, 7.4, (3.0, 2.0)), result)


def _force(result: Prediction) -> Panel:
    loads = drawn_loads(result)
    limits = [result.joints[i].force_limit for i, _ in loads]
    panel = amplitude_panel(
        result,
        axis_of(_FIRST_FORCE, max(limits), log=True),
        "dashed: full stick, T = kₜ δ, and gross slip, T = μN",
        _FROM_REST,
    )
    unit = panel.y.unit
    for (index, look), limit in zip(loads, limits, strict=True):
        joint, curve = result.joints[index], result.curves[index]
        stuck = joint.tangential_stiffness * curve.amplitude
        near = stuck < 6.0 * limit
        x = curve.amplitude[near] / panel.x.unit
        panel.line(x, stuck[near] / unit, look.color, width=THIN, dash=DASHED)
        panel.add(Guide(limit / unit, "y", look.color))
    forces = draw_curves(panel, result, lambda curve: curve.force_amplitude / unit)
    if np.isfinite(forces).any():
        panel.y.low, panel.y.high = 0.5 * float(forces.min()), 3.0 * max(limits) / unit
    return panel


def _stiffness(result: Prediction) -> Panel:
    loads = drawn_loads(result)
    # A law that is rigid at rest is scaled by its largest secant stiffness.
    at_rest = [
        k
        if (k := result.joints[i].tangential_stiffness) < np.inf
        else float(result.curves[i].secant_stiffness[0])
        for i, _ in loads
    ]
    stiffness = axis_of(Quantity("N/m", label="Stiffness"), max(at_rest))
    unit = stiffness.unit
    log = far_apart(at_rest)
    low, high = (1e-3 * min(at_rest), 3.0 * max(at_rest)) if log else (0.0, 1.08 * max(at_rest))
    stiffness.log, stiffness.low, stiffness.high = log, low / unit, high / unit
    panel = amplitude_panel(
        result,
        stiffness,
        "solid: tangent dT/dδ, dashed: secant T/δ",
        _FROM_REST,
    )
    draw_curves(panel, result, lambda curve: curve.tangent_stiffness / unit)
    for index, look in loads:
        curve = result.curves[index]
        x, secant = curve.amplitude / panel.x.unit, curve.secant_stiffness / unit
        panel.line(x, secant, look.color, width=THIN, dash=DASHED)
    return panel


# -- contact ---------------------------------------------------------------------------------------


def contact_state(result: Prediction) -> Plot:
    """Plot the sticking fraction of the contact area against displacement."""
    fraction = QUANTITIES["stick_share"]._replace(label="Sticking fraction of the contact area")
    panel = amplitude_panel(result, axis_of(fraction, low=0.0, high=1.05), x=_FROM_REST)
    draw_curves(panel, result, lambda curve: np.asarray(curve.stick_share))
    return add_legend(stacked([panel], 4.0), result)


def face(result: Prediction) -> Plot:
    """Plot maps of pressure and contact of a measured face, and its load against separation."""
    from microslip.contact.figures import face_plot
    from microslip.study.build import build_surface

    return face_plot(build_surface(result.study))
