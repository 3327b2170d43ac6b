"""The figure of a pressure that is spread: what presses where, and how slip reaches outwards."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from microslip._core.units import engineering, prefix
from microslip.friction import PressedJoint
from microslip.report.kit import look_of
from microslip.report.plot import Axis, Entry, Floats, Panel, Plot
from microslip.report.scales import common_prefix, evenly
from microslip.results.predicted.curves import drawn_loads
from microslip.runs.prediction import Prediction

MOST_AMPLITUDES = 6


def pressure(result: Prediction) -> Plot:
    """Pressure over the place, and how near each place is to sliding at the amplitudes."""
    every: Sequence[object] = result.joints
    joints = [
        (joint, look)
        for i, look in drawn_loads(result)
        if isinstance(joint := every[i], PressedJoint)
    ]
    first = joints[0][0]
    places, axis = _places(first)
    unit, letter = common_prefix([float(joint.pressures.max()) for joint, _ in joints])
    over = Panel(Axis(axis), Axis(f"Pressure [{letter}Pa]", 0.0))
    for joint, look in joints:
        over.line(*_stepped(places, joint.pressures / unit), look.color, dash=look.dash)
        if joint.pressure.areas.size <= 1:
            over.marks(places, joint.pressures / unit, look.color, marker=look.marker)
    slip = Panel(
        Axis(axis),
        Axis("Share of the slip limit, T/μN", 0.0, 1.05),
        f"at displacements from rest, under {engineering(first.normal_load, 'N', 4, trim=True)}: "
        "1 slides",
    )
    amplitudes = result.rows[0].amplitude
    indices = evenly(amplitudes.size, MOST_AMPLITUDES)
    entries = []
    for number, index in enumerate(indices):
        color, dash, _ = look_of(number)
        shares = first.slip_shares(float(amplitudes[index]))
        slip.line(*_stepped(places, shares), color, dash=dash)
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


def _places(joint: PressedJoint) -> tuple[Floats, str]:
    """Where each area is: its distance from the axis, or its rank by pressure as area."""
    spread = joint.pressure
    if spread.distances is not None:
        unit, letter = prefix(float(spread.distances.max()))
        return spread.distances / unit, f"Distance from the axis [{letter}m]"
    order = np.argsort(-joint.pressures, kind="stable")
    reach = np.empty(order.size)
    reach[order] = np.cumsum(spread.areas[order]) - 0.5 * spread.areas[order]
    return 100.0 * reach / spread.area, "Pressed area, the most pressed first [%]"


def _stepped(places: Floats, values: Floats) -> tuple[Floats, Floats]:
    """A line through the values in the order of their places."""
    order = np.argsort(places, kind="stable")
    return places[order], values[order]
