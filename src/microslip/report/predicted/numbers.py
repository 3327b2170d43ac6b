"""Numbers of a prediction: data set with CSV tables, and summary.json."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from microslip._core.dataset import DataSet, Variable
from microslip._core.quantities import QUANTITY_UNITS, Quantity, json_value, named
from microslip._core.units import engineering, significant
from microslip.friction import Interface, PressedJoint
from microslip.report.files import header
from microslip.report.predicted.tables import scatter_numbers
from microslip.report.structure.data import AMPLITUDE, force_numbers, force_rows, structure_arrays
from microslip.report.structure.document import structure_numbers
from microslip.structures.bolt_tightening import BoltForces
from microslip.study.description import StudyDescription
from microslip.study.runs.columns import (
    AmplitudeCurve,
    HistoryResponse,
)
from microslip.study.runs.prediction import Prediction, variable_of, variables_of
from microslip.study.runs.rest import joint_entry, joint_verdicts

FLAGS = ("ok", "watch", "outside", "not judged")
"""Verdict words; a variable contains their index."""


def driven(result: Prediction) -> str:
    """Return the name of the amplitude that the study gives: "force_amplitude" or "amplitude".

    The data set has a dimension of this name, along which the loops are stored.
    """
    by_force = result.study.excitation.force_amplitudes is not None
    return "force_amplitude" if by_force else "amplitude"


def data_set(result: Prediction) -> DataSet:
    """Return all results of a prediction with dimensions, units and meanings."""
    rows, curves, by = result.rows, result.curves, driven(result)
    loads = np.array([getattr(joint, "normal_load", np.nan) for joint in result.joints])
    sizes = {
        "load": len(loads),
        by: rows[0].amplitude.size,
        "sample": result.loops[0][0].force.size,
        "point": curves[0].amplitude.size,
    }
    coords = {
        "load": variable_of(("load",), loads, "normal_load"),
        by: variable_of((by,), getattr(rows[0], by), by),
        "sample": _index("sample", sizes["sample"], "sample of a loop"),
        "point": _index("point", sizes["point"], "point of the curves"),
        "curve_amplitude": variable_of(("point",), curves[0].amplitude, "amplitude"),
    }
    arrays = {**variables_of(result), **_validity(result)}
    if result.histories:
        sizes["history_sample"] = size = result.histories[0].force.size
        coords["history_sample"] = _index("history_sample", size, "sample of the history")
    if result.scatter is not None:
        sizes["quantile"] = result.scatter.quantiles.size
        coords["quantile"] = variable_of(("quantile",), result.scatter.quantiles, "quantile")
        arrays |= {f"{name}_bands": band for name, band in result.scatter.bands.items()}
    if result.structure is not None:
        structure = structure_arrays(result.structure)
        sizes |= structure.sizes
        coords |= structure.coords
        arrays |= structure.variables
    return DataSet(sizes, coords, arrays)


def tables(result: Prediction, data: DataSet) -> dict[str, tuple[dict[str, str], tuple[str, ...]]]:
    """Return the columns and dimensions of each CSV table."""
    by, alone = driven(result), result.study.reports_joint
    load, curve, history = (
        {"normal_load": "load"},
        [item.name for item in fields(AmplitudeCurve)],
        [item.name for item in fields(HistoryResponse)],
    )
    bands = {"amplitude": "curve_amplitude", **{n: f"curve_{n}_bands" for n in curve[1:]}}
    modal = {name: name for name in data if name.startswith("modal_")}
    found = {
        "loops": (
            {**load, "amplitude": "amplitude", by: by, "displacement": "displacement",
             "force": "force"},
            ("load", by, "sample"),
        ),
        "curves": ({**load, **{name: f"curve_{name}" for name in curve}}, ("load", "point")),
        "history": (
            {**load, **{name: f"history_{name}" for name in history}}, ("load", "history_sample")
        ),
        "structure": ({"mode": "mode", "amplitude": AMPLITUDE, **modal}, ("mode", AMPLITUDE)),
        "bands": ({**load, "quantile": "quantile", **bands}, ("load", "quantile", "point")),
    }  # fmt: skip
    return {
        name: ({key: column for key, column in columns.items() if column in data}, dims)
        for name, (columns, dims) in found.items()
        if set(dims) <= set(data.sizes) and (alone or name not in ("loops", "curves"))
    }


def _index(dim: str, size: int, meaning: str) -> Variable:
    values = np.arange(size, dtype=np.int32)
    return Variable((dim,), values, Quantity("-", meaning))


def _validity(result: Prediction) -> dict[str, Variable]:
    arrays = {}
    judged = [joint_verdicts(result.study, joint) for joint in result.joints]
    for place, verdict in enumerate(judged[0][: len(getattr(result.joints[0], "validity", ()))]):
        name = "validity_" + re.sub(r"\W+", "_", verdict.name)
        of_loads = [of_load[place] for of_load in judged]
        values = np.array([np.nan if v.value is None else float(v.value) for v in of_loads])
        words = np.array([FLAGS.index(v.word) for v in of_loads], dtype=np.int8)
        about = Quantity("-", verdict.name)
        about_values = {"limit": float(verdict.limit), "comment": verdict.meaning}
        arrays[name] = Variable(("load",), values, about, about_values)
        flags = {
            "flag_values": np.arange(len(FLAGS), dtype=np.int8),
            "flag_meanings": " ".join(word.replace(" ", "_") for word in FLAGS),
        }
        arrays[f"{name}_word"] = Variable(("load",), words, about, flags)
    return arrays


# -- summary ---------------------------------------------------------------------------------------

SUMMARY_SCHEMA = 1
REMINDER = (
    "Loss factor and damping ratio describe the interface. In a structure the damping ratio of a "
    "mode is the dissipated energy of all joints over 4 pi times the energy of the mode."
)


def prediction_summary(result: Prediction, defaults: Sequence[str]) -> dict[str, Any]:
    """Return the contents of `summary.json`; ``defaults`` are notes on the default amplitudes."""
    study, joint = result.study, result.joints[0]
    surface, structure, scatter = study.surface, result.structure, result.scatter
    notes = [
        *(defaults if study.reports_joint else ()),
        *load_notes(study, joint),
        *study.notes,
        REMINDER,
    ]
    parts = {
        **({} if surface is None else surface.findings()),
        "pressure": pressure_numbers(joint),
        "bolts": force_numbers(_bolt_forces(study)),
        "structure": None if structure is None else structure_numbers(structure),
        "uncertainty": None if scatter is None else scatter_numbers(scatter),
    }
    numbers = {
        **header("result", SUMMARY_SCHEMA, study.title),
        "study": study.plain(),
        "notes": notes,
        **{name: numbers for name, numbers in parts.items() if numbers is not None},
        "joints": [_joint(result, index) for index in range(len(result.joints))],
        "units": QUANTITY_UNITS,
        "files": [],
    }
    return {name: json_value(value) for name, value in numbers.items()}


def _bolt_forces(study: StudyDescription) -> BoltForces | None:
    # A joint of a friction law has no pressure, and a pressure field has no bolts.
    forces: BoltForces | None = getattr(getattr(study.joint, "pressure", None), "bolt_forces", None)
    return forces


def pressure_numbers(joint: Any) -> dict[str, Any] | None:
    """Return the pressure distribution of a joint as plain values; None without one."""
    if not isinstance(joint, PressedJoint):
        return None
    spread = joint.pressure
    numbers = named(spread, "kind", "area", "concentration")
    return {**numbers, "largest_pressure": float(joint.pressures.max())}


def load_notes(study: StudyDescription, joint: Interface) -> list[str]:
    """Return notes on the scan, the tightening and the pressure distribution of a joint."""
    notes = [] if study.surface is None else study.surface.sentences()
    if (spread := pressure_numbers(joint)) is not None:
        notes.append(
            f"joint.pressure: {spread['kind']}, on {significant(1e6 * spread['area'])} mm², "
            f"largest pressure {significant(spread['concentration'])} times the mean, "
            f"{engineering(spread['largest_pressure'], 'Pa')} under "
            f"{engineering(joint.normal_load, 'N', 4, trim=True)}. Verdicts refer to that pressure."
        )
    if rows := force_rows(_bolt_forces(study)):
        words = "; ".join(f"{name[0].lower()}{name[1:]} {text}" for name, text in rows)
        notes.append(f"joint.pressure, each bolt: {words}.")
    index = joint.surface._assumptions(None).get("plasticity index") if study.structure else None
    if index is not None and index > 1.0:
        notes.append(
            "surface.law: the summits are elastic, although most would yield at a plasticity index "
            f"of {index:.3g}. Faces yield under the pressure of each patch: use "
            'law = "face", with rq and rdq of a drawing or with a scan.'
        )
    return notes


def _joint(result: Prediction, index: int) -> dict[str, Any]:
    joint, columns = result.joints[index], result.rows[index].columns()
    numbers = {
        **joint_entry(result.study, joint),
        "amplitudes": [
            dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)
        ],
    }
    if result.histories:
        response = result.histories[index]
        numbers["history"] = {
            "largest_displacement": abs(response.displacement).max(),
            "largest_force": abs(response.force).max(),
            "dissipated_energy": response.dissipated_energy[-1],
        }
    return numbers
