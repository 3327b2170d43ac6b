"""Figures of records, of their cycles, and of campaigns; titles are given by the caller."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from microslip._core.units import engineering, prefix
from microslip._core.wording import shorten
from microslip.figures.kit import evenly, far_apart, force_prefix, length_prefix, line_style
from microslip.figures.plot import COLORS, Axis, Panel, Plot, stacked

MOST_LOOPS = 6
_DECADES = 30.0
"""Ratio of mean energies above which their axis is logarithmic."""


def measured_loops(measurements: Sequence[Any]) -> Plot:
    """Draw mean loops (force over load if all records have a load) and the energy of each cycle."""
    drawn_records = [measurements[i] for i in evenly(len(measurements), MOST_LOOPS)]
    normalised = all("normal_load" in measured.mean for measured in drawn_records)
    x_unit, x_letter = length_prefix(max(m.mean["amplitude"].value for m in drawn_records))
    y_unit, y_letter = prefix(max(m.mean["force_amplitude"].value for m in drawn_records))
    energies = np.concatenate([m.cycles["dissipated_energy"] for m in drawn_records])
    e_unit, e_letter = prefix(float(np.abs(energies).max()))
    usual = [m.mean["dissipated_energy"].value for m in drawn_records]
    is_wide = min(float(energies.min()), min(usual)) > 0.0 and far_apart(usual, _DECADES)
    force_label = "Force / normal load, T/N [–]" if normalised else f"Force [{y_letter}N]"
    loop_panel = Panel(
        Axis(f"Displacement [{x_letter}m]", unit=x_unit),
        Axis(force_label, unit=1.0 if normalised else y_unit),
        note="Mean cycles without offsets",
        cell=(0, 0, 0, 0),
    )
    right = Panel(
        Axis("Cycle", integer=True),
        Axis(
            f"Dissipated energy [{e_letter}J]",
            low=None if is_wide else min(0.0, 1.1 * float(energies.min()) / e_unit),
            high=None if is_wide else max(0.0, 1.1 * float(energies.max()) / e_unit) or None,
            log=is_wide,
            unit=e_unit,
        ),
        note="Each cycle",
        cell=(0, 0, 1, 1),
    )
    loop_panel.cross()
    legend = []
    for i, measured in enumerate(drawn_records):
        style = line_style(i)
        color, dash = style.color, style.dash
        x, force = measured.loop
        x = x - measured.mean["displacement_offset"].value
        force = force - measured.mean["force_offset"].value
        scale = measured.mean["normal_load"].value if normalised else y_unit
        loop_panel.line(x / x_unit, force / scale, color, dash=dash)
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


_BLOCKS = 1500  # across the width of a figure; longer records show the range of each block


def envelope(time: Any, values: Any) -> tuple[Any, Any]:
    """Return the range of each block of a long record as a line through both ends, for drawing."""
    size = -(-len(values) // _BLOCKS)
    if size <= 2:
        return time, values
    starts = np.arange(0, len(values), size)
    low, high = (f.reduceat(values, starts) for f in (np.minimum, np.maximum))
    rising = np.r_[values[starts[1:]], values[-1]] >= values[starts]
    first, second = np.where(rising, low, high), np.where(rising, high, low)
    return np.repeat(time[starts], 2), np.stack((first, second), axis=1).ravel()


def record_figure(record: Any) -> Plot:
    """Draw displacement, force and load against time, or sample number if there is no time."""
    time, label, t_unit = record.seconds, "Sample", 1.0
    if time is None:
        time = np.arange(float(len(record)))
    else:
        t_unit, letter = prefix(float(time[-1])) if 0.0 < float(time[-1]) < 1.0 else (1.0, "")
        label = f"Time [{letter}s]"
    x_unit, x_letter = length_prefix(float(np.abs(record.displacement).max()) or 1.0)
    channels = [(f"Displacement [{x_letter}m]", x_unit, record.displacement)]
    for name, values in (("Force", record.force), ("Normal load", record.normal_load)):
        if np.ndim(values) == 1:
            unit, letter = force_prefix(values)
            channels.append((f"{name} [{letter}N]", unit, values))
    panels = []
    for name, unit, values in channels:
        panel = Panel(Axis(label, margin=0.0, unit=t_unit), Axis(name, unit=unit))
        across, along = envelope(time, np.asarray(values))
        panel.line(across / t_unit, along / unit, width=0.9)
        panels.append(panel)
    panels[0].note = shorten(record.name, 60)
    return stacked(panels, 0.9 + 1.8 * len(panels), (1.0,) * len(panels))


def worn(wear: Any) -> Plot:
    """Draw worn volume against dissipated energy, with the line of the wear coefficient."""
    unit, letter = prefix(float(wear.energy.max()))
    panel = Panel(
        Axis(f"Dissipated energy [{letter}J]", low=0.0, unit=unit),
        Axis("Worn volume [mm³]", low=0.0, unit=1e-9),
        note=f"α = {1e18 * wear.coefficient.value:.3g} µm³/J",
    )
    x = np.array([0.0, 1.1 * float(wear.energy.max())])
    panel.line(x / unit, wear.coefficient.value * x / 1e-9, COLORS[1])
    panel.marks(wear.energy / unit, wear.volume / 1e-9, COLORS[0], filled=True)
    return stacked([panel], 3.8)
