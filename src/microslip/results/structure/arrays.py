"""The numbers of a bolted structure as labelled arrays, for `result.nc` and xarray."""

from __future__ import annotations

import numpy as np

from microslip._core.checks import Floats
from microslip._core.netcdf import Variable
from microslip._core.quantities import QUANTITIES
from microslip.results.structure.document import columns
from microslip.results.structure.prediction import StructurePrediction

AMPLITUDE, PATCH = "structure_amplitude", "patch"
"""Dimensions beside `mode`."""

Labelled = dict[str, Variable]


def labelled(prediction: StructurePrediction) -> tuple[dict[str, int], Labelled, Labelled]:
    """Dimensions, coordinates and variables."""
    table = columns(prediction)
    modes, amplitude = len(prediction.modes), prediction.modes[0].curve.amplitude
    joint, state = prediction.joint, prediction.state
    dims = {"mode": modes, AMPLITUDE: amplitude.size, PATCH: joint.patches}
    numbers = np.array([mode.number for mode in prediction.modes], dtype=np.int32)
    coords = {
        "mode": Variable(("mode",), numbers, QUANTITIES["mode"].attributes),
        AMPLITUDE: _named((AMPLITUDE,), amplitude, "m", "displacement amplitude at the sensor"),
        "patch_x": _named((PATCH,), joint.patch_centres[:, 0], "m", "place along the lap"),
        "patch_y": _named((PATCH,), joint.patch_centres[:, 1], "m", "place across the lap"),
    }
    variables = {
        name: Variable(("mode", AMPLITUDE), values.reshape(modes, -1), QUANTITIES[name].attributes)
        for name, values in table.items()
        if name not in ("mode", "amplitude")
    }
    for name, by_patch, unit, meaning in (
        ("patch_area", joint.patch_areas, "m^2", "area of a patch"),
        ("patch_gap", joint.patch_gaps, "m", "gap of a patch where nothing presses"),
        ("patch_normal_load", state.normal_loads, "N", "normal load of a patch after tightening"),
    ):
        variables[name] = _named((PATCH,), by_patch, unit, meaning)
    loss = np.stack([mode.loss() for mode in prediction.modes])
    slip = np.stack([mode.slip(joint) for mode in prediction.modes])
    dims_of_patches = ("mode", PATCH)
    variables["patch_loss_share"] = _named(
        dims_of_patches,
        loss,
        "1",
        "share of a patch in the loss of a cycle at the largest amplitude",
    )
    variables["patch_slip"] = _named(
        dims_of_patches,
        slip,
        "m",
        "relative tangential amplitude of a patch at the largest amplitude",
    )
    return dims, coords, variables


def _named(dims: tuple[str, ...], values: Floats, unit: str, meaning: str) -> Variable:
    return Variable(dims, np.ascontiguousarray(values), {"units": unit, "long_name": meaning})
