"""Figures of the response to a history, and of the pressure distribution."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from microslip._core.quantities import QUANTITIES, Quantity, dimensionless
from microslip._core.units import engineering
from microslip.figures.kit import axis_of, envelope, evenly, far_apart, line_style
from microslip.figures.plot import GREY, THIN, WIDTH, Axis, Entry, Floats, Panel, Plot
from microslip.friction import PressedJoint
from microslip.report.predicted.figures import add_legend, drawn_loads
from microslip.report.predicted.tables import TOTAL_ENERGY
from microslip.study.runs.prediction import Prediction

MOST_DRAWN_SAMPLES = 20_000
"""Largest number of samples per load that is drawn in full."""
_QUANTITIES = {
    "displacement": QUANTITIES["displacement"],
    "force": QUANTITIES["force"],
    "dissipated_energy": TOTAL_ENERGY,
}
_THIN_FROM = 3000


def history(result: Prediction) -> Plot:
    """Plot displacement, force and dissipated energy over samples, and force over displacement."""
    names = [*_QUANTITIES]
    loads = drawn_loads(result)
    count = result.histories[0].force.size
    record = result.study.excitation.history
    columns: dict[str, list[Floats]] = {}
    panels: dict[str, Panel] = {}
    for row, name in enumerate(names):
        columns[name], up = _scaled([getattr(result.histories[i], name) for i, _ in loads], name)
        along = Axis("Sample", integer=True, bare=row < len(names) - 1)
        panels[name] = Panel(along, up, cell=(row, row, 0, 0))
    cell = (0, len(names) - 1, 1, 1)
    path_panel = Panel(panels["displacement"].y, panels["force"].y, cell=cell)
    # The given quantity is the same for all loads and is drawn in grey.
    common = record.quantity if record is not None and len(loads) > 1 else None
    if common is not None:
        given = columns[common][0]
        panels[common].line(drawn := envelope(given), given[drawn], GREY, width=THIN)
    responses = columns["displacement" if common == "force" else "force"]
    sizes = [float(np.abs(response).max()) for response in responses]
    width = 0.7 if count > _THIN_FROM else WIDTH
    # Draw large responses first, so that they do not hide small ones.
    for number in sorted(range(len(loads)), key=lambda i: -sizes[i]):
        look = loads[number][1]
        dash = (
            () if count > MOST_DRAWN_SAMPLES else look.dash
        )  # strokes would be shorter than a dash
        for name, values in columns.items():
            if name != common:
                y = values[number]
                panels[name].line(
                    drawn := envelope(y), y[drawn], look.color, width=width, dash=dash
                )
        ends = slice(-MOST_DRAWN_SAMPLES, None)
        x, y = (columns[name][number][ends] for name in ("displacement", "force"))
        path_panel.line(x, y, look.color, width=width, dash=dash)
    path_panel.cross()
    if count > MOST_DRAWN_SAMPLES:
        path_panel.note = f"the last {MOST_DRAWN_SAMPLES} samples"
    plot = Plot(
        [*panels.values(), path_panel],
        5.4,
        heights=(1.0,) * len(names),
        widths=(1.0, 1.05),
    )
    return add_legend(plot, result, dashed=True)


def _scaled(values: list[Floats], name: str) -> tuple[list[Floats], Axis]:
    """Return a quantity of all loads, scaled for one axis, and the axis.

    The curves share a unit. If their maxima differ by more than a factor of 50, each curve is
    divided by its maximum instead.
    """
    quantity = _QUANTITIES[name]
    sizes = [float(np.abs(column).max()) for column in values]
    if far_apart(sizes, 50.0):
        ratios = [column / (size or 1.0) for column, size in zip(values, sizes, strict=True)]
        return ratios, axis_of(dimensionless(f"{quantity.label} over largest"))
    axis = axis_of(quantity, max(sizes))
    return [column / axis.unit for column in values], axis


MOST_AMPLITUDES = 6


def pressure(result: Prediction) -> Plot:
    """Plot the pressure and the ratio of local friction force to slip limit, both over position."""
    every: Sequence[object] = result.joints
    joints = [
        (joint, look)
        for i, look in drawn_loads(result)
        if isinstance(joint := every[i], PressedJoint)
    ]
    first = joints[0][0]
    places, axis = _places(first)
    largest = max(float(joint.pressures.max()) for joint, _ in joints)
    over = Panel(axis, axis_of(Quantity("Pa", label="Pressure"), largest, low=0.0))
    unit = over.y.unit
    for joint, look in joints:
        over.line(*_by_position(places, joint.pressures / unit), look.color, dash=look.dash)
        if joint.pressure.areas.size <= 1:
            over.marks(places, joint.pressures / unit, look.color, marker=look.marker)
    slip = Panel(
        axis,
        axis_of(dimensionless("Local force over slip limit T/μN"), low=0.0, high=1.05),
        f"at displacements from rest, under {engineering(first.normal_load, 'N', 4, trim=True)}: "
        "1 slides",
    )
    amplitudes = result.rows[0].amplitude
    indices = evenly(amplitudes.size, MOST_AMPLITUDES)
    entries = []
    for number, index in enumerate(indices):
        color, dash, _ = line_style(number)
        shares = first.slip_shares(float(amplitudes[index]))
        slip.line(*_by_position(places, shares), color, dash=dash)
        if shares.size <= 1:
            slip.marks(places, shares, color)
        label = engineering(float(amplitudes[index]), "m", 3, trim=True)
        entries.append(Entry(label, color, dash, None))
    if len(joints) > 1:
        loads = ", ".join(engineering(joint.normal_load, "N", 4, trim=True) for joint, _ in joints)
        over.note = f"from below: {loads}"
    over.cell, slip.cell = (0, 0, 0, 0), (1, 1, 0, 0)
    plot = Plot([over, slip], 6.4, heights=(1.0, 1.2))
    plot.legend_title, plot.legend = "Displacement below", tuple(entries)
    plot.title = result.study.title
    return plot


def _places(joint: PressedJoint) -> tuple[Floats, Axis]:
    """Return the abscissae of the areas of a pressure distribution, and their axis.

    They are distances from the axis of symmetry or, without one, the cumulative area in order of
    decreasing pressure [%].
    """
    spread = joint.pressure
    if spread.distances is not None:
        distance = Quantity("m", label="Distance from the axis")
        axis = axis_of(distance, float(spread.distances.max()))
        return spread.distances / axis.unit, axis
    order = np.argsort(-joint.pressures, kind="stable")
    reach = np.empty(order.size)
    reach[order] = np.cumsum(spread.areas[order]) - 0.5 * spread.areas[order]
    area = dimensionless("Area in order of decreasing pressure")
    return 100.0 * reach / spread.area, axis_of(area, (0.01, "%"))


def _by_position(places: Floats, values: Floats) -> tuple[Floats, Floats]:
    order = np.argsort(places, kind="stable")
    return places[order], values[order]
