"""Response of a structure to a harmonic force: table, figure, columns and numbers."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from microslip._core.dataset import DataSet
from microslip._core.quantities import Quantity, hertz, named
from microslip._core.units import engineering, prefix
from microslip.figures.kit import axis_of, between, line_style, pale
from microslip.figures.plot import Entry, Panel, Plot, stacked
from microslip.report.document import Note, Section, Table
from microslip.report.structure.pictures import AT_SENSOR, BAND
from microslip.study.runs.structure_prediction import (
    ForcedMode,
    StructurePrediction,
)

FORCED_FIGURE = "forced_response"
"""Name of the figure and of its CSV file."""


def forced_table(prediction: StructurePrediction) -> DataSet:
    """Return the responses to all forces near all modes."""
    pairs = [(mode, forced) for mode in prediction.modes for forced in mode.forced]
    sizes, unit = [forced.frequency.size for _, forced in pairs], Quantity(prediction.part.unit)
    columns = {
        "mode": (Quantity("-"), np.repeat([float(mode.number) for mode, _ in pairs], sizes)),
        "force_amplitude": (Quantity("N"), np.repeat([forced.force for _, forced in pairs], sizes)),
        "frequency": (Quantity("Hz"), np.concatenate([forced.frequency for _, forced in pairs])),
        "amplitude": (unit, np.concatenate([forced.response for _, forced in pairs])),
    }
    if prediction.inputs:
        none = [np.full((3, size), math.nan) for size in sizes]
        bands = [
            other if f.bands is None else f.bands for (_, f), other in zip(pairs, none, strict=True)
        ]
        columns |= {name: (unit, row) for name, row in zip(_BAND, np.hstack(bands), strict=True)}
    return DataSet.of_rows(columns)


_BAND = ("amplitude_low", "amplitude_median", "amplitude_high")


def response_numbers(forced: ForcedMode) -> dict[str, Any]:
    """Return the response near a mode as plain values in SI units."""
    peak = ("amplitude", "frequency")
    result: dict[str, Any] = {
        "peak": dict(zip(peak, forced.peak, strict=True)),
        **named(forced, "force", "largest_force", "frequency"),
        "amplitude": forced.response,
    }
    if forced.bands is not None and forced.peak_bands is not None:
        result["amplitude_bands"] = forced.bands
        result["peak_bands"] = dict(zip(peak, forced.peak_bands.T, strict=True))
        result["sampling_error"] = forced.error
    if forced.bands is not None or forced.beyond:
        result["beyond"] = forced.beyond
    return result


def force_section(prediction: StructurePrediction) -> Section:
    """Return the section on the peaks of the response to each force, with bands."""
    unit = prediction.part.unit
    modes = [(mode, forced) for mode in prediction.modes for forced in mode.forced]
    peaks = np.array([forced.peak for _, forced in modes])
    columns: dict[str, tuple[Quantity, Any]] = {
        "mode": (Quantity("", label="Mode"), [mode.number for mode, _ in modes]),
        "force": (Quantity("N", label="Force", form="3"), [forced.force for _, forced in modes]),
        "peak_amplitude": (Quantity(unit, label="Peak at the sensor", form="3"), peaks[:, 0]),
        "peak_frequency": (Quantity("Hz", label="at", form=".5g"), peaks[:, 1]),
    }
    if any(forced.peak_bands is not None for _, forced in modes):
        none = np.full((3, 2), math.nan)
        bands = np.array([none if f.peak_bands is None else f.peak_bands for _, f in modes])
        columns["peak_low"] = Quantity(unit, label="Peak, 5 %", form="3"), bands[:, 0, 0]
        columns["peak_high"] = Quantity(unit, label="95 %", form="3"), bands[:, 2, 0]
    remarks = [
        "Computed near each resonance from its modal curve, without other modes; if a frequency "
        "has several solutions, the largest one is given."
    ]
    for mode, forced in modes:
        name = f"Mode {mode.number} under {engineering(forced.force, 'N', 3)}"
        if not np.isfinite(forced.peak[0]):
            most = engineering(forced.largest_force, "N", 2)
            remarks.append(
                f"{name} exceeds the largest amplitude, which a force of about {most} reaches: "
                "increase amplitude.to."
                + (
                    " No sample stays below it, so there are no bands."
                    if prediction.inputs and forced.bands is None
                    else ""
                )
            )
        elif forced.beyond:
            remarks.append(
                f"{name}: {100.0 * forced.beyond:.0f} % of the samples exceed the largest "
                "amplitude, which limits the bands: increase amplitude.to."
            )
        if np.isfinite(forced.error):
            remarks.append(
                f"{name}: the sampling error of the quantiles of the peak is at most "
                f"±{100.0 * forced.error:.1f} % (90 %)."
            )
    table = Table("Response to the force", DataSet.of_rows(columns), noun="peaks")
    return Section("Response to the force", (table, Note(" ".join(remarks), small=True)))


def force_plot(prediction: StructurePrediction) -> Plot:
    """Plot the amplitude at the sensor against the frequency of the force, one panel per mode."""
    at_sensor = Quantity(prediction.part.unit, label=AT_SENSOR)
    panels, legend = [], []
    for mode in prediction.modes:
        highest = [forced.response for forced in mode.forced]
        highest += [forced.bands[2] for forced in mode.forced if forced.bands is not None]
        largest = float(np.nanmax(np.concatenate(highest), initial=0.0))
        note = f"Mode {mode.number}"
        if any(forced.beyond or not np.isfinite(forced.peak[0]) for forced in mode.forced):
            note += ", responses limited by the largest amplitude (amplitude.to)"
        panel = Panel(
            axis_of(hertz("Frequency of the force"), margin=0.0),
            axis_of(at_sensor, largest, log=True),
            note=note,
        )
        unit = panel.y.unit
        for index, forced in enumerate(mode.forced):
            if forced.bands is not None:
                low, high = forced.bands[[0, 2]] / unit
                color = pale(line_style(index).color, BAND)
                panel.add(between(forced.frequency, low, high, color))
        for index, forced in enumerate(mode.forced):
            look = line_style(index)
            panel.line(forced.frequency, forced.response / unit, look.color, dash=look.dash)
        panels.append(panel)
    for index, force in enumerate(prediction.part.force.amplitude if prediction.part.force else ()):
        look = line_style(index)
        scale, letter = prefix(force)
        legend.append(Entry(f"{force / scale:g} {letter}N", look.color, look.dash))
    return stacked(panels, 2.9 * len(panels) + 0.5, legend=legend)
