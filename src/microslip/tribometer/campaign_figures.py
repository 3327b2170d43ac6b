"""Figures of campaigns: evolution on logarithmic axes, fretting map, worn volume."""

from __future__ import annotations

import numpy as np

from microslip._core.units import prefix, significant
from microslip._core.wording import shorten
from microslip.report.plot import COLORS, DASHES, MARKERS, Axis, Entry, Marker, Panel, Plot
from microslip.report.scales import evenly, length_prefix
from microslip.tribometer.campaign import Campaign, Wear

MOST = len(COLORS)
_REGIMES: dict[str, tuple[Marker, str]] = {
    "stick": ("o", COLORS[1]),
    "partial slip": ("s", COLORS[3]),
    "mixed": ("D", COLORS[5]),
    "gross slip": ("^", COLORS[2]),
}


def evolution(campaign: Campaign) -> Plot:
    """Friction, stiffness and energy of each cycle, over cycles and over cumulative energy."""
    measurements = campaign.measurements
    drawn_rows = evenly(len(measurements), MOST)
    totals = campaign.cumulative()
    largest = max(float(np.abs(totals[i]).max()) for i in drawn_rows)
    unit, letter = prefix(largest)
    loaded = all("friction_peak" in measurements[i].cycles for i in drawn_rows)
    rows = [
        ("friction_peak", "Friction T_m/N [–]") if loaded else ("force_amplitude", "Force"),
        ("reversal_stiffness", "Stiffness"),
        ("dissipated_energy", "Energy per cycle"),
    ]
    panels = []
    for row, (name, label) in enumerate(rows):
        values = [np.abs(measurements[i].cycles[name]) for i in drawn_rows]
        finite = np.concatenate([value[np.isfinite(value)] for value in values])
        si = {"force_amplitude": "N", "reversal_stiffness": "N/m", "dissipated_energy": "J"}
        scale = 1.0
        if name in si:
            scale, letters = prefix(float(np.median(finite)) if finite.size else 1.0)
            label = f"{label} [{letters}{si[name]}]"
        for column in range(2):
            panel = Panel(
                Axis(
                    ("Cycle", f"Dissipated so far [{letter}J]")[column],
                    log=True,
                    bare=row < len(rows) - 1,
                    unit=(1.0, unit)[column],
                ),
                Axis(label if column == 0 else "", log=name != "friction_peak", unit=scale),
                cell=(row, row, column, column),
            )
            for at, i in enumerate(drawn_rows):
                color, dash = COLORS[at % MOST], DASHES[at % len(DASHES)]
                x = np.arange(1.0, values[at].size + 1.0) if column == 0 else totals[i] / unit
                y = values[at] / scale
                if x.size < 4:
                    panel.marks(x, y, color, marker=MARKERS[at % len(MARKERS)])
                panel.line(x, y, color, dash=dash)
            panels.append(panel)
    runs = campaign.runs
    names = [m.name if runs is None else f"{runs[i]}: {m.name}" for i, m in enumerate(measurements)]
    legend = tuple(
        Entry(shorten(names[i], 40), COLORS[at % MOST], DASHES[at % len(DASHES)])
        for at, i in enumerate(drawn_rows)
    )
    undrawn = len(measurements) - len(drawn_rows)
    title = f"{undrawn} more records are in the tables" if undrawn else ""
    return Plot(
        panels, 7.2, heights=(1.0,) * 3, widths=(1.0, 1.0), legend=legend, legend_title=title
    )


def fretting_map(campaign: Campaign) -> Plot:
    """Regimes over amplitude and load."""
    points = campaign.fretting_map()
    unit, letter = length_prefix(max(point.amplitude for point in points))
    scale, load_letter = prefix(max(point.normal_load for point in points))
    panel = Panel(
        Axis(f"Amplitude [{letter}m]", log=True, margin=0.12, unit=unit),
        Axis(f"Normal load [{load_letter}N]", log=True, margin=0.12, unit=scale),
    )
    legend = []
    for regime, (marker, color) in _REGIMES.items():
        of = [point for point in points if point.regime == regime]
        if of:
            x, y = [p.amplitude / unit for p in of], [p.normal_load / scale for p in of]
            panel.marks(x, y, color, marker=marker, filled=True, size=6.0)
            legend.append(Entry(regime, color, marker=marker, filled=True, line=False))
    return Plot([panel], 4.4, legend=tuple(legend))


def worn(wear: Wear) -> Plot:
    """Worn volume over dissipated energy, with the line through zero."""
    unit, letter = prefix(float(wear.energy.max()))
    panel = Panel(
        Axis(f"Dissipated energy [{letter}J]", low=0.0, unit=unit),
        Axis("Worn volume [mm³]", low=0.0, unit=1e-9),
        note=f"α = {significant(1e18 * wear.coefficient.value, 4)} µm³/J",
    )
    x = np.array([0.0, 1.1 * float(wear.energy.max())])
    panel.line(x / unit, wear.coefficient.value * x / 1e-9, COLORS[1])
    panel.marks(wear.energy / unit, wear.volume / 1e-9, COLORS[0], filled=True)
    return Plot([panel], 3.8)
