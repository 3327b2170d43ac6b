"""Content of summary.json of a prediction: its numbers under descriptive keys."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from microslip._core.quantities import UNITS, json_value, named
from microslip._core.units import engineering, significant
from microslip.friction import Interface, PressedJoint
from microslip.report.files import header
from microslip.report.predicted.scatter_document import scatter_numbers
from microslip.report.structure.bolts import force_numbers, force_rows
from microslip.report.structure.document import structure_numbers
from microslip.structures.bolt_tightening import BoltForces
from microslip.study.description import StudyDescription
from microslip.study.runs.columns import (
    HistoryResponse,
    ResultColumns,
)
from microslip.study.runs.prediction import Prediction
from microslip.study.runs.rest import joint_entry

KIND = "microslip-result"
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
    return {
        **header(KIND, SUMMARY_SCHEMA, study.title),
        "study": study.plain(),
        "notes": notes,
        **{name: numbers for name, numbers in parts.items() if numbers is not None},
        "joints": [_joint(result, index) for index in range(len(result.joints))],
        "units": dict(UNITS),
        "files": [],
    }


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
    joint, row = result.joints[index], result.rows[index]
    return {
        **joint_entry(result.study, joint),
        "amplitudes": _records(row),
        **({"history": _history(result.histories[index])} if result.histories else {}),
    }


def _records(columns: ResultColumns) -> list[dict[str, float | None]]:
    arrays = columns.columns()
    rows = zip(*(json_value(array) for array in arrays.values()), strict=True)
    return [dict(zip(arrays, row, strict=True)) for row in rows]


def _history(response: HistoryResponse) -> dict[str, float | None]:
    ends = {
        "largest_displacement": abs(response.displacement).max(),
        "largest_force": abs(response.force).max(),
        "dissipated_energy": response.dissipated_energy[-1],
    }
    return {name: json_value(value) for name, value in ends.items()}
