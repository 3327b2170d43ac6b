"""Bolts in results: forces from tightening to service, and effects of slack bolts."""

from __future__ import annotations

from typing import Any

from microslip._core.dataset import DataSet
from microslip._core.quantities import Quantity, dimensionless, hertz, json_value
from microslip._core.units import engineering
from microslip.report import cells
from microslip.report.document import Section
from microslip.structures.bolt_tightening import BoltForces, tension_band
from microslip.study.runs.structure_prediction import StructurePrediction, TightMode


def slack_names(prediction: StructurePrediction) -> str:
    """Format the numbers of the slack bolts."""
    slack = prediction.part.bolts.slack
    listed = ", ".join(str(number) for number in sorted(slack))
    return f"bolt{'s' if len(slack) > 1 else ''} {listed}" if slack else ""


def force_rows(forces: BoltForces | None) -> list[tuple[str, str]]:
    """Return rows on the forces of a bolt, from tightening to service; none if they are unknown."""
    if forces is None:
        return []
    low, high = tension_band(forces.tightening_factor)
    tightened = engineering(forces.assembly, "N", 4)
    if high > low:
        ends = " to ".join(engineering(end * forces.assembly, "N", 4) for end in (low, high))
        tightened += f", {ends} by a tightening factor of {forces.tightening_factor:g}"
    rows = [("Tension after tightening", tightened)]
    if forces.utilisation is not None:
        rows.append(("Stress of tightening", f"{forces.utilisation:.2f} of the proof stress"))
    if forces.embedding:
        lost = f"{engineering(forces.loss, 'N', 3)} at an embedding of"
        rows.append(("Lost after tightening", f"{lost} {engineering(forces.embedding, 'm', 3)}"))
    if forces.load_factor is not None:
        rows.append(("Load factor of an axial load", f"{forces.load_factor:.3g}"))
    if forces.axial_load:
        pulls = f"{engineering(forces.axial_load, 'N', 4)} pulls, "
        adds = f"{engineering(forces.added, 'N', 3)} of it as bolt load"
        rows.append(("Axial load of a bolt", pulls + adds))
    if forces.clamping != forces.assembly:
        left = engineering(forces.clamping, "N", 4)
        if high > low:
            left += ", " + " to ".join(engineering(end, "N", 4) for end in forces.ends)
        rows.append(("Clamp force between the plates, per bolt", left))
    return rows


def force_numbers(forces: BoltForces | None) -> dict[str, Any] | None:
    """Return the forces of a bolt as plain values in SI units."""
    if forces is None:
        return None
    return {**vars(forces), "clamping": forces.clamping, "clamping_range": list(forces.ends)}


def comparison(prediction: StructurePrediction) -> Section:
    """Compare each mode with the corresponding mode with all bolts tight, in words."""
    unit = prediction.part.unit
    quantities = {
        "amplitude": Quantity(unit, "", "Amplitude at the sensor", "amplitude", "3"),
        "slack_frequency": hertz("Slack"),
        "tight_frequency": hertz("All tight"),
        "slack_damping_ratio": dimensionless("ζ, slack"),
        "tight_damping_ratio": dimensionless("ζ, all tight"),
    }
    tables = []
    for mode, beside in zip(prediction.modes, prediction.tight, strict=True):
        curves = (
            mode.curve.amplitude, mode.curve.frequency, beside.curve.frequency,
            mode.curve.damping_ratio, beside.curve.damping_ratio,
        )  # fmt: skip
        columns = zip(quantities.values(), curves, strict=True)
        data = DataSet.of_rows(dict(zip(quantities, columns, strict=True)))
        title = (
            f"Mode {mode.number} with {slack_names(prediction)} slack, "
            f"mode {beside.number} with all tight"
        )
        last = engineering(float(mode.curve.amplitude[mode.last]), unit, 3)
        change = mode.curve.frequency[mode.last] / beside.curve.frequency[mode.last] - 1.0
        factor = mode.curve.damping_ratio[mode.last] / beside.curve.damping_ratio[mode.last]
        caption = (
            f"At {last} the frequency changes by {100.0 * change:+.2f} % and the damping ratio by "
            f"a factor of {factor:.3g}. The MAC of the two shapes is {beside.mac:.3f}."
        )
        tables.append(cells.table(title, data, caption=caption, noun="amplitudes"))
    return Section("Slack bolts", tuple(tables))


def tight_numbers(tight: tuple[TightMode, ...]) -> list[dict[str, Any]]:
    """Return the modes with all bolts tight as plain values in SI units."""
    return [
        {
            "mode": beside.of,
            "tight_mode": beside.number,
            "mac": beside.mac,
            "linear_frequency": beside.curve.linear_frequency,
            "modal_frequency": json_value(beside.curve.frequency),
            "modal_damping_ratio": json_value(beside.curve.damping_ratio),
        }
        for beside in tight
    ]
