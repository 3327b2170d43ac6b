"""Data set of a bolted structure: curves of its modes, and results of each contact patch.

Patches are the areas into which the model divides the contact faces.
"""

from __future__ import annotations

import numpy as np

from microslip._core.checks import Floats
from microslip._core.dataset import DataSet, Variable
from microslip._core.quantities import QUANTITIES, Quantity
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
