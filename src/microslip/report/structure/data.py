"""Data of a bolted structure: curves of its modes, results of each contact patch, forces of bolts.

Patches are the areas into which the model divides the contact faces.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip._core.dataset import DataSet, Variable
from microslip._core.quantities import QUANTITIES, Quantity
from microslip._core.units import engineering
from microslip.structures.bolt_tightening import BoltForces, tension_band
from microslip.study.runs.structure_prediction import Mode, StructurePrediction

AMPLITUDE, PATCH = "structure_amplitude", "patch"
"""Dimensions in addition to `mode`."""


def curves(mode: Mode) -> dict[str, Floats]:
    """Return the curves of a mode by quantity name."""
    columns = {
        "amplitude": mode.curve.amplitude,
        "modal_frequency": mode.curve.frequency,
        "modal_damping_ratio": mode.curve.damping_ratio,
    }
    for name in ("frequency", "damping_ratio") if mode.bands is not None else ():
        for word, row in zip(("low", "median", "high"), getattr(mode.bands, name), strict=True):
            columns[f"modal_{name}_{word}"] = row
    return columns


def structure_arrays(prediction: StructurePrediction) -> DataSet:
    """Return the data set of all modes and patches."""
    modes, joint, state = prediction.modes, prediction.joint, prediction.state
    amplitude = modes[0].curve.amplitude
    sizes = {"mode": len(modes), AMPLITUDE: amplitude.size, PATCH: joint.patches}
    numbers = np.array([mode.number for mode in modes], dtype=np.int32)
    part, centres = prediction.part, joint.patch_centres
    coords = {
        "mode": Variable(("mode",), numbers, QUANTITIES["mode"]),
        AMPLITUDE: _named(
            (AMPLITUDE,), amplitude, part.unit, f"{part.quantity} amplitude at the sensor"
        ),
        "patch_x": _named((PATCH,), centres[:, 0], "m", "position along the lap"),
        "patch_y": _named((PATCH,), centres[:, 1], "m", "position across the lap"),
    }
    of_modes = [curves(mode) for mode in modes]
    variables = {
        name: Variable(
            ("mode", AMPLITUDE),
            np.stack([columns[name] for columns in of_modes]),
            QUANTITIES[name],
        )
        for name in of_modes[0]
        if name != "amplitude"
    }
    loss = np.stack([mode.loss() for mode in modes])
    slip = np.stack([mode.slip(joint) for mode in modes])
    largest = "at the largest amplitude"
    for name, values, unit, meaning in (
        ("area", joint.patch_areas, "m^2", "area of a patch"),
        ("gap", joint.patch_gaps, "m", "gap of a patch between the unloaded faces"),
        ("normal_load", state.normal_loads, "N", "normal load of a patch after tightening"),
        ("loss_share", loss, "-", f"fraction of the loss per cycle in a patch {largest}"),
        ("slip", slip, "m", f"relative tangential amplitude of a patch {largest}"),
    ):
        along = ("mode", PATCH)[2 - values.ndim :]
        variables[f"patch_{name}"] = _named(along, values, unit, meaning)
    return DataSet(sizes, coords, variables)


def _named(dims: tuple[str, ...], values: Floats, unit: str, meaning: str) -> Variable:
    return Variable(dims, np.ascontiguousarray(values), Quantity(unit, meaning))


# -- bolts -----------------------------------------------------------------------------------------


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
