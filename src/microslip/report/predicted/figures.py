"""Figures of a prediction, as plot descriptions, and their captions."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from microslip._core.quantities import QUANTITIES, Quantity, dimensionless
from microslip._core.units import engineering, prefix
from microslip.figures.kit import axis_of, common_prefix, evenly, far_apart
from microslip.figures.picture import Picture
from microslip.figures.plot import (
    DASHED,
    THIN,
    Floats,
    Guide,
    Panel,
    Plot,
    stacked,
)
from microslip.report.predicted.curves import (
    add_legend,
    amplitude_panel,
    draw_curves,
    drawn_loads,
    energy_damping,
)
from microslip.report.predicted.history_figure import history, pressure
from microslip.study.measured_face import MeasuredFace
from microslip.study.runs.prediction import Prediction
from microslip.study.surfaces import TableSurface

MOST_LOOP_PANELS = 6


# -- loops ---------------------------------------------------------------------------------------


def loops(result: Prediction) -> Plot:
    """Plot hysteresis loops, one panel for each amplitude, one loop for each load."""
    indices = evenly(len(result.rows[0].amplitude), MOST_LOOP_PANELS)
    columns = 1 if len(indices) == 1 else 2 if len(indices) <= 4 else 3
    largest_x = max(float(row.amplitude[indices].max()) for row in result.rows)
    largest_y = max(float(row.force_amplitude[indices].max()) for row in result.rows)
    # Loops of very different size are drawn relative to their amplitudes, in all panels.
    loads = drawn_loads(result)
    over_amplitude = any(
        far_apart([float(result.rows[i].amplitude[index]) for i, _ in loads]) for index in indices
    )
    panels = [_loops_at(result, i, (largest_x, largest_y), over_amplitude) for i in indices]
    for number, panel in enumerate(panels):
        row, column = divmod(number, columns)
        panel.cell = (row, row, column, column)
    rows = panels[-1].cell[0] + 1
    height = 0.9 + (3.6 if columns == 1 else 2.5) * rows
    plot = Plot(panels, height, heights=(1.0,) * rows, widths=(1.0,) * columns)
    return add_legend(plot, result, dashed=True)


def _loops_at(
    result: Prediction, index: int, largest: tuple[float, float], over_amplitude: bool
) -> Panel:
    # No markers, which would look like measured points.
    loads = drawn_loads(result)
    amplitudes = [float(result.rows[i].amplitude[index]) for i, _ in loads]
    limits = [result.joints[i].force_limit for i, _ in loads]
    forces = [float(result.rows[i].force_amplitude[index]) for i, _ in loads]
    by_force = result.study.excitation.force_amplitudes is not None
    # Likewise for very different force limits.
    over_limit = far_apart(limits) and not by_force
    x_scale = _prefix(max(amplitudes), largest[0], min(1e-9, largest[0]))
    x = axis_of(QUANTITIES["displacement"], x_scale)
    y = axis_of(QUANTITIES["force"], _prefix(max(forces), largest[1]))
    if over_amplitude:
        x = axis_of(dimensionless("Displacement over amplitude δ/δₘ"))
    if over_limit:
        y = axis_of(dimensionless("Force over force limit T/μN"))
    note = f"Amplitude {amplitudes[0] / x_scale[0]:.6g} {x_scale[1]}m"
    if by_force:
        note = f"Force amplitude {engineering(forces[0], 'N', 6, trim=True)}"
    panel = Panel(x, y, note)
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


def _prefix(value: float, largest: float, smallest: float = 0.0) -> tuple[float, str]:
    """Return factor and letter of the unit prefix for one panel.

    The prefix is that for ``largest``, the maximum of all panels, unless ``value``, the maximum of
    this panel, is then a number below 0.1. In that case the prefix is that for the larger of
    ``value`` and ``smallest``.
    """
    unit, letter = prefix(largest)
    return (unit, letter) if value >= 0.0999 * unit else prefix(max(value, smallest))


# -- first loading -------------------------------------------------------------------------------


def backbone(result: Prediction) -> Plot:
    """Plot the force, tangent stiffness and secant stiffness on first loading."""
    panels = [_force(result), _stiffness(result)]
    return add_legend(stacked(panels, 7.4, (3.0, 2.0)), result)


def _force(result: Prediction) -> Panel:
    loads = drawn_loads(result)
    limits = [result.joints[i].force_limit for i, _ in loads]
    panel = amplitude_panel(
        result,
        axis_of(QUANTITIES["force"], common_prefix(limits), log=True),
        "dashed: full stick, T = kₜ δ, and gross slip, T = μN",
        QUANTITIES["displacement"],
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
    unit, letter = common_prefix(at_rest)
    log = far_apart(at_rest)
    low, high = (1e-3 * min(at_rest), 3.0 * max(at_rest)) if log else (0.0, 1.08 * max(at_rest))
    ends = {"low": low / unit, "high": high / unit}
    panel = amplitude_panel(
        result,
        axis_of(Quantity("N/m", label="Stiffness"), (unit, letter), log=log, **ends),
        "solid: tangent dT/dδ, dashed: secant T/δ",
        QUANTITIES["displacement"],
    )
    draw_curves(panel, result, lambda curve: curve.tangent_stiffness / unit)
    for index, look in loads:
        curve = result.curves[index]
        x, secant = curve.amplitude / panel.x.unit, curve.secant_stiffness / unit
        panel.line(x, secant, look.color, width=THIN, dash=DASHED)
    return panel


# -- contact ------------------------------------------------------------------------------------


def contact_state(result: Prediction) -> Plot:
    """Plot the sticking fraction of the contact area against displacement."""
    sticking = axis_of(QUANTITIES["stick_share"], low=0.0, high=1.05)
    panel = amplitude_panel(result, sticking, x=QUANTITIES["displacement"])
    draw_curves(panel, result, lambda curve: np.asarray(curve.stick_share))
    return add_legend(stacked([panel], 4.0), result)


def face(result: Prediction) -> Plot:
    """Plot maps of pressure and contact of a measured face, and its load against separation."""
    from microslip.contact.figures import face_plot
    from microslip.study.build import build_surface

    return face_plot(build_surface(result.study))


def _drawn(result: Prediction) -> dict[Callable[[Prediction], Plot], bool]:
    """Return every figure in reading order, and whether it is drawn for a result."""
    study = result.study
    # A tabulated normal law has no contacts.
    has_contacts = study.surface is not None and not isinstance(study.surface, TableSurface)
    is_pressed = has_contacts and study.joint.pressure is not None
    alone = study.reports_joint
    return {
        **dict.fromkeys((loops, backbone, energy_damping), alone),
        contact_state: has_contacts and not is_pressed and alone,
        pressure: is_pressed,
        history: bool(result.histories),
        face: isinstance(study.surface, MeasuredFace),
    }


def prediction_pictures(result: Prediction) -> tuple[Picture, ...]:
    """Return the figures of a result, in reading order."""
    pictures = []
    for figure, is_drawn in _drawn(result).items():
        if not is_drawn:
            continue
        name = figure.__name__
        alternative, caption = _CAPTIONS[name]
        if result.scatter is not None:
            between = " to ".join(f"{100.0 * end:g}" for end in result.scatter.quantiles[[0, -1]])
            edges = "Dashed" if name == "loops" else "Shaded"
            if name in ("loops", "backbone", "energy_damping", "contact_state"):
                of = "uncertain inputs" if result.scatter.inputs else "identified law"
                caption += f" {edges}: the {between} % band of the {of}."
        pictures.append(Picture(name, caption, partial(figure, result), alternative))
    return tuple(pictures)


_PANELS = "one panel for each amplitude and one loop for each load"
_CAPTIONS = {
    "loops": (
        "Hysteresis loops, force against displacement",
        f"Closed hysteresis loops, {_PANELS}. Thin "
        "and pointed: most contacts stick (microslip). A parallelogram with flat ends: gross slip. "
        "The area is the energy dissipated per cycle.",
    ),
    "backbone": (
        "Force and stiffness of first loading against displacement",
        "First loading from rest (the backbone), which determines every loop: its initial slope "
        "is kₜ, and it ends at the force limit μN. Below, the tangent stiffness and the secant "
        "stiffness, which is the stiffness of an equivalent linear joint at that amplitude.",
    ),
    "energy_damping": (
        "Dissipated energy, loss factor and exponent against displacement amplitude",
        "Energy dissipated per cycle, loss factor η with damping ratio ζ = η/2, and local exponent "
        "of the energy, against the displacement amplitude; markers are the loops. The exponent "
        "is 3 in the microslip of a smooth backbone and 1 in gross slip.",
    ),
    "contact_state": (
        "Sticking fraction of the contact area against displacement",
        "Fraction of the contact area that sticks after a displacement from rest.",
    ),
    "face": (
        "Pressures and contacts on a piece of the face, and its loads against the separation",
        "Point-by-point solution of the face: pressures on its first piece at the tightening load, "
        "contacts at this and two lighter loads, and mean pressure against separation; the pieces "
        "of the scan lie within the grey band.",
    ),
    "pressure": (
        "Pressure over the faces, and local force over the local slip limit",
        "Distribution of the normal load over the faces; below, the local force over the local "
        "slip limit after a displacement from rest: regions of low pressure slide first, and "
        "slip spreads from there as the displacement grows.",
    ),
    "history": (
        "Displacement, force and dissipated energy along the history, and its path",
        "Response to the given history from rest: displacement, force and cumulative dissipated "
        "energy, and force against displacement.",
    ),
}
