"""Response of a structure to a harmonic force: table, figure, columns and numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip._core.dataset import DataSet, Variable
from microslip._core.quantities import json_value, named
from microslip._core.units import engineering, prefix
from microslip.figures.kit import between, line_style
from microslip.figures.plot import Axis, Entry, Panel, Plot, stacked
from microslip.report.document import Column, Note, Section, Table
from microslip.report.structure.pictures import PALE
from microslip.structures.forced import response_columns
from microslip.study.runs.structure_prediction import (
    ForcedMode,
    StructurePrediction,
)

FORCED_FIGURE = "forced_response"
"""Name of the figure."""
RESPONSES = "frf.uff"
"""Universal file of the responses over the force."""
FORCED_TABLES = ("forced_response", "frf")
"""Names of the CSV files: near each mode with bands, and of all modes together."""


def forced_tables(prediction: StructurePrediction) -> dict[str, DataSet]:
    """Return the columns of the CSV tables of responses to forces, by the name of the table."""
    if not (responses := prediction.frequency_responses):
        return {}
    unit = prediction.part.unit
    parts = []
    for mode in prediction.modes:
        for forced in mode.forced:
            size = forced.frequency.size
            bands = np.full((3, size), math.nan) if forced.bands is None else forced.bands
            parts.append(
                {
                    "mode": np.full(size, float(mode.number)),
                    "force_amplitude": np.full(size, forced.force),
                    "frequency": forced.frequency,
                    "amplitude": forced.response,
                    **(dict(zip(_BAND, bands, strict=True)) if prediction.inputs else {}),
                }
            )
    units = {"mode": "1", "force_amplitude": "N", "frequency": "Hz"}
    near = {
        name: (units.get(name, unit), np.concatenate([part[name] for part in parts]))
        for name in parts[0]
    }
    tables = zip(FORCED_TABLES, (near, response_columns(responses)), strict=True)
    return {name: _table_of(columns) for name, columns in tables}


def _table_of(columns: Mapping[str, tuple[str, Floats]]) -> DataSet:
    variables = {
        name: Variable(("row",), values, {"units": unit})
        for name, (unit, values) in columns.items()
    }
    return DataSet({"row": len(next(iter(variables.values())).values)}, {}, variables)


_BAND = ("amplitude_low", "amplitude_median", "amplitude_high")


def response_numbers(forced: ForcedMode) -> dict[str, Any]:
    """Return the response near a mode as plain values in SI units."""
    result: dict[str, Any] = {
        "force": forced.force,
        "peak": dict(zip(("amplitude", "frequency"), json_value(forced.peak), strict=True)),
        **json_value(named(forced, "largest_force", "frequency")),
        "amplitude": json_value(forced.response),
    }
    if forced.bands is not None and forced.peak_bands is not None:
        result["amplitude_bands"] = json_value(forced.bands)
        result["peak_bands"] = dict(
            zip(("amplitude", "frequency"), json_value(forced.peak_bands.T), strict=True)
        )
        result["sampling_error"] = json_value(forced.error)
    if forced.bands is not None or forced.beyond:
        result["beyond"] = forced.beyond
    return result


def force_section(prediction: StructurePrediction) -> Section:
    """Return the section on the peaks of the response to each force, with bands."""
    unit = prediction.part.unit
    listed = [
        Column("mode", "Mode"),
        Column("force", "Force", "N", 3),
        Column("peak_amplitude", "Peak at the sensor", unit, 3),
        Column("peak_frequency", "at", "Hz", write=lambda f: f"{f:.5g}"),
    ]
    modes = [(mode, forced) for mode in prediction.modes for forced in mode.forced]
    banded = any(forced.peak_bands is not None for _, forced in modes)
    if banded:
        listed += [Column("peak_low", "Peak, 5 %", unit, 3), Column("peak_high", "95 %", unit, 3)]
    rows = []
    remarks = [
        "Computed near each resonance from its modal curve, without other modes; if a frequency "
        "has several motions, the largest is given. frf.csv has the response per unit force, with "
        "the other modes linear."
    ]
    for mode, forced in modes:
        ends = [] if forced.peak_bands is None else forced.peak_bands[[0, 2], 0].tolist()
        ends += [math.nan] * (2 * banded - len(ends))
        rows.append(
            (mode.number, forced.force, *json_value(forced.peak), *json_value(np.array(ends)))
        )
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
                f"{name}: {forced.beyond:.0%} of the samples exceed the largest amplitude, which "
                "limits the bands: increase amplitude.to."
            )
        if np.isfinite(forced.error):
            remarks.append(
                f"{name}: the sampling error of the quantiles of the peak is at most "
                f"±{forced.error:.1%} (90 %)."
            )
    table = Table("Response to the force", tuple(listed), tuple(rows), noun="peaks")
    return Section("Response to the force", (table, Note(" ".join(remarks), small=True)))


def force_plot(prediction: StructurePrediction) -> Plot:
    """Plot the amplitude at the sensor against the frequency of the force, one panel per mode."""
    si = prediction.part.unit.replace("^2", "²")
    panels, legend = [], []
    for mode in prediction.modes:
        highest = [forced.response for forced in mode.forced]
        highest += [forced.bands[2] for forced in mode.forced if forced.bands is not None]
        unit, letter = prefix(float(np.nanmax(np.concatenate(highest), initial=0.0)) or 1.0)
        panel = Panel(
            Axis("Frequency of the force [Hz]", margin=0.0),
            Axis(f"Amplitude at the sensor [{letter}{si}]", log=True),
            note=f"Mode {mode.number}",
        )
        for index, forced in enumerate(mode.forced):
            if forced.bands is not None:
                low, high = forced.bands[[0, 2]] / unit
                pale = PALE[index % len(PALE)]
                panel.add(between(forced.frequency, low, high, pale))
        for index, forced in enumerate(mode.forced):
            look = line_style(index)
            panel.line(forced.frequency, forced.response / unit, look.color, dash=look.dash)
        panels.append(panel)
    for index, force in enumerate(prediction.part.force.amplitude if prediction.part.force else ()):
        look = line_style(index)
        scale, letter = prefix(force)
        legend.append(Entry(f"{force / scale:g} {letter}N", look.color, look.dash))
    return stacked(panels, 2.9 * len(panels) + 0.5, legend=legend)
