"""Figures of records, of their cycles, and of campaigns; titles are given by the caller."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from microslip._core.quantities import QUANTITIES, Quantity, dimensionless
from microslip._core.units import engineering
from microslip._core.wording import shorten
from microslip.figures.kit import axis_of, envelope, evenly, far_apart, line_style, time_axis
from microslip.figures.plot import COLORS, Axis, Panel, Plot, stacked

MOST_LOOPS = 6
_DECADES = 30.0
"""Ratio of mean energies above which their axis is logarithmic."""


def measured_loops(measurements: Sequence[Any]) -> Plot:
    """Draw mean loops (force over load if all records have a load) and the energy of each cycle."""
    drawn_records = [measurements[i] for i in evenly(len(measurements), MOST_LOOPS)]
    normalised = all("normal_load" in measured.mean for measured in drawn_records)
    length, largest = (
        max(m.mean[name].value for m in drawn_records) for name in ("amplitude", "force_amplitude")
    )
    force = dimensionless("Force over normal load T/N") if normalised else QUANTITIES["force"]
    energies = np.concatenate([m.cycles["dissipated_energy"] for m in drawn_records])
    usual = [m.mean["dissipated_energy"].value for m in drawn_records]
    is_wide = min(float(energies.min()), min(usual)) > 0.0 and far_apart(usual, _DECADES)
    loop_panel = Panel(
        axis_of(QUANTITIES["displacement"], length),
        axis_of(force, largest),
        note="Mean cycles without offsets",
        cell=(0, 0, 0, 0),
    )
    right = Panel(
        Axis("Cycle", integer=True),
        axis_of(QUANTITIES["dissipated_energy"], float(np.abs(energies).max()), log=is_wide),
        note="Each cycle",
        cell=(0, 0, 1, 1),
    )
    e_unit = right.y.unit
    if not is_wide:
        right.y.low = min(0.0, 1.1 * float(energies.min()) / e_unit)
        right.y.high = max(0.0, 1.1 * float(energies.max()) / e_unit) or None
    loop_panel.cross()
    legend = []
    for i, measured in enumerate(drawn_records):
        style = line_style(i)
        color, dash = style.color, style.dash
        x, forces = measured.loop
        x = x - measured.mean["displacement_offset"].value
        forces = forces - measured.mean["force_offset"].value
        unit = measured.mean["normal_load"].value if normalised else loop_panel.y.unit
        loop_panel.line(x / loop_panel.x.unit, forces / unit, color, dash=dash)
        energy = measured.cycles["dissipated_energy"] / e_unit
        places = np.arange(1, energy.size + 1)
        if energy.size == 1:
            right.marks(places, energy, color)
        right.line(places, energy, color, dash=dash)
        load = measured.mean.get("normal_load")
        label = shorten(measured.name, 40)
        if load is not None:
            label += f", {engineering(load.value, 'N')}"
        legend.append(style.entry(label, marked=False))
    undrawn = len(measurements) - len(drawn_records)
    return Plot(
        [loop_panel, right],
        3.9,
        widths=(1.5, 1.0),
        legend=tuple(legend),
        legend_title=f"{undrawn} more records are in the tables" if undrawn else "",
    )


def record_figure(record: Any) -> Plot:
    """Draw displacement, force and load against time, or sample number if there is no time."""
    time = record.seconds
    panels = []
    for name, quantity in (
        ("displacement", QUANTITIES["displacement"]),
        ("force", QUANTITIES["force"]),
        ("normal_load", Quantity("N", label="Normal load")),
    ):
        values = np.asarray(getattr(record, name))
        if values.ndim != 1:
            continue
        across = Axis("Sample", margin=0.0) if time is None else time_axis(time)
        panel = Panel(across, axis_of(quantity, float(np.abs(values).max())))
        drawn = envelope(values)
        x = drawn if time is None else time[drawn]
        panel.line(x / across.unit, values[drawn] / panel.y.unit, width=0.9)
        panels.append(panel)
    panels[0].note = shorten(record.name, 60)
    return stacked(panels, 0.9 + 1.8 * len(panels), (1.0,) * len(panels))


def worn(wear: Any) -> Plot:
    """Draw worn volume against dissipated energy, with the line of the wear coefficient."""
    largest = float(wear.energy.max())
    panel = Panel(
        axis_of(Quantity("J", label="Dissipated energy"), largest, low=0.0),
        axis_of(Quantity("m^3", label="Worn volume"), (1e-9, "m"), low=0.0),
        note=f"α = {1e18 * wear.coefficient.value:.3g} µm³/J",
    )
    unit, x = panel.x.unit, np.array([0.0, 1.1 * largest])
    panel.line(x / unit, wear.coefficient.value * x / 1e-9, COLORS[1])
    panel.marks(wear.energy / unit, wear.volume / 1e-9, COLORS[0])
    return stacked([panel], 3.8)
