"""Computation of all results of a study."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from microslip._core.checks import Floats, Progress
from microslip._core.dataset import Variable
from microslip._core.quantities import QUANTITIES
from microslip._core.units import engineering
from microslip._core.wording import plural
from microslip.friction import Interface, LawBand
from microslip.friction.loops import Loop
from microslip.study.build import build_joints, is_uncertain, naming_key
from microslip.study.description import StudyDescription
from microslip.study.joints import LawJoint
from microslip.study.measured_face import MeasuredFace
from microslip.study.runs.columns import (
    AmplitudeCurve,
    HistoryResponse,
    ResultColumns,
)
from microslip.study.runs.rest import scalars
from microslip.study.runs.scatter import PredictionScatter, scatter
from microslip.study.runs.structure import run_structure
from microslip.study.runs.structure_prediction import StructurePrediction
from microslip.study.schema import CurveRange, ExcitationTable
from microslip.study.uncertain import at_central_values


@dataclass(frozen=True, eq=False, repr=False)
class Prediction:
    """All results of a study; :class:`microslip.Result` adds files and figures."""

    study: StudyDescription
    joints: tuple[Interface, ...]
    loops: tuple[tuple[Loop, ...], ...]
    rows: tuple[AmplitudeCurve, ...]
    curves: tuple[AmplitudeCurve, ...]
    histories: tuple[HistoryResponse, ...] = ()
    structure: StructurePrediction | None = None
    scatter: PredictionScatter | None = None
    summary: dict[str, Any] = field(default_factory=dict)
    """Summary of the result, see :class:`microslip.Result`."""

    def __repr__(self) -> str:
        parts = [
            *([repr(self.study.title)] if self.study.title else []),
            plural(len(self.joints), "load"),
            plural(len(self.rows[0].amplitude), "amplitude"),
            f"curves of {len(self.curves[0].amplitude)} points",
            *(f"history of {plural(len(h.force), 'sample')}" for h in self.histories[:1]),
            *(["scatter"] if self.scatter is not None else []),
            *(["structure"] if self.structure is not None else []),
        ]
        return f"Result({', '.join(parts)})"


MEANINGS = {"history_dissipated_energy": "energy dissipated since rest"}
"""Descriptions of variables that differ from the description of their quantity."""


def variables_of(result: Prediction) -> dict[str, Variable]:
    """Return all numerical results by name, as arrays with units."""
    driven = "amplitude" if result.study.excitation.force_amplitudes is None else "force_amplitude"
    arrays = {
        **_scalars(result),
        **_samples(result, driven),
        **_columns(result.rows, "", driven, leave_out=driven),
        **_columns(result.curves, "curve_", "point", leave_out="amplitude"),
    }
    if result.histories:
        arrays |= _columns(result.histories, "history_", "history_sample")
    return arrays


def variable_of(dims: tuple[str, ...], values: Floats, name: str, meaning: str = "") -> Variable:
    """Return values with the unit and description of a quantity, for a data set.

    ``meaning`` replaces the description, if given.
    """
    return Variable(dims, values, QUANTITIES[name], {"long_name": meaning} if meaning else {})


def _scalars(result: Prediction) -> dict[str, Variable]:
    """Return the scalar results of the joint at rest, such as stiffness, shape (loads,).

    Quantities that are unknown at all normal loads are left out.
    """
    rows = [scalars(result.study, joint) for joint in result.joints]
    variables = {
        name: variable_of(("load",), np.array([row[name] for row in rows], dtype=float), name)
        for name in rows[0]
        if any(row[name] is not None for row in rows)
    }
    comment = {"comment": result.joints[0]._slip_scale[1]}
    variables["slip_scale"] = variables["slip_scale"]._replace(more=comment)
    return variables


def _samples(result: Prediction, driven: str) -> dict[str, Variable]:
    return {
        name: variable_of(
            ("load", driven, "sample"),
            np.array([[getattr(loop, name) for loop in loops] for loops in result.loops]),
            name,
        )
        for name in ("displacement", "force")
    }


def _columns(
    tables: Sequence[ResultColumns], prefix: str, dim: str, leave_out: str = ""
) -> dict[str, Variable]:
    return {
        prefix + name: variable_of(
            ("load", dim),
            _stacked([table.columns()[name] for table in tables]),
            name,
            MEANINGS.get(prefix + name, ""),
        )
        for name in tables[0].columns()
        if name != leave_out
    }


def _stacked(arrays: Sequence[Floats]) -> Floats:
    # A single array is not copied, since it may be large.
    return arrays[0][np.newaxis] if len(arrays) == 1 else np.stack(arrays)


DEFAULT_AMPLITUDES = (0.1, 0.3, 1.0, 10.0)
DEFAULT_RANGE = (1e-3, 1e2)
"""Default range of the curves, relative to the slip scale like the amplitudes above."""


def with_defaults(
    study: StudyDescription, joints: Sequence[Interface]
) -> tuple[StudyDescription, list[str]]:
    """Return the study with amplitudes of loops and of curves, and notes on those it did not give.

    Defaults are multiples of the largest slip scale of the joints, rounded to two digits.
    """
    excitation, changes, notes = study.excitation, dict[str, Any](), []
    scale = float(f"{max(joint._slip_scale[0] for joint in joints):.1e}")
    words = engineering(scale, "m", trim=True)
    of = f"times the slip scale, {words} when rounded to two digits"
    if excitation.amplitudes is None and excitation.force_amplitudes is None:
        changes["amplitudes"] = tuple(float(f"{x * scale:.3g}") for x in DEFAULT_AMPLITUDES)
        factors = ", ".join(f"{factor:g}" for factor in DEFAULT_AMPLITUDES)
        notes.append(f"excitation.amplitudes is not given: {factors} {of}.")
    if excitation.curve is None:
        low, high = (float(f"{factor * scale:.3g}") for factor in DEFAULT_RANGE)
        changes["curve"] = CurveRange.of(start=low, to=high)
        ends = " to ".join(f"{factor:g}" for factor in DEFAULT_RANGE)
        notes.append(f"excitation.curve is not given: {ends} {of}.")
    return study.copy(excitation=excitation.copy(**changes)), notes


_STRUCTURE = 0.95  # fraction of the computing time of a structure


def run_prediction(
    study: StudyDescription, progress: Progress | None = None
) -> tuple[Prediction, list[str]]:
    """Compute a study; also return notes on defaults. See :meth:`microslip.Study.run`."""
    if study.structure is not None:
        structure = run_structure(study, _part(progress, 0.0, _STRUCTURE))
        result, notes = _computed(study, _part(progress, _STRUCTURE, 1.0))
        result = replace(result, structure=structure)
    elif is_uncertain(study):
        result, notes = _scattered(study, progress)
    else:
        result, notes = _computed(study, progress)
        if isinstance(study.joint, LawJoint) and study.joint.band is not None:
            result = replace(result, scatter=_measured_scatter(result, study.joint.band))
    return result, notes


def _measured_scatter(result: Prediction, band: LawBand) -> PredictionScatter:
    """Return the bands of an identified law; NaN for quantities that were not identified."""
    law = result.joints[0]
    bands = {
        name: variable._replace(
            dims=("quantile", *variable.dims), values=np.full((2, *variable.values.shape), np.nan)
        )
        for name, variable in variables_of(result).items()
        if variable.values.dtype.kind == "f" and "sample" not in variable.dims[-1]
    }
    for prefix, (table,) in (("", result.rows[:1]), ("curve_", result.curves[:1])):
        a = table.amplitude
        ends = band.of(law, a)
        columns = {
            "force_amplitude": ends["force"],
            "force_ratio": ends["force"] / law.force_limit,
            "secant_stiffness": ends["force"] / a,
            "dissipated_energy": ends["dissipated_energy"],
            "damping_ratio": ends["damping_ratio"],
            "loss_factor": 2.0 * ends["damping_ratio"],
        }
        for name, values in columns.items():
            if prefix + name in bands:
                bands[prefix + name].values[:, 0] = values
    low, high = (engineering(float(end), "m", 3, trim=True) for end in band.amplitude[[0, -1]])
    tail = 0.5 * (1.0 - band.confidence)
    notes = (
        f"Intervals ({100.0 * band.confidence:g} % confidence each) are those of the identified "
        f"law. They exist for amplitudes from {low} to {high}, the range of its records.",
    )
    return PredictionScatter((), 0, np.array([tail, 1.0 - tail]), bands, {}, (), notes)


def _scattered(study: StudyDescription, progress: Progress | None) -> tuple[Prediction, list[str]]:
    """Return the results at the central values of the inputs, with bands over the samples."""
    begin = _solving(study)
    result, notes = _computed(at_central_values(study), _part(progress, 0.0, begin))
    bands = scatter(
        with_defaults(study, result.joints)[0].copy(structure=None),
        variables_of(result),
        lambda sample: variables_of(_computed(sample)[0]),
        _part(progress, begin, 1.0),
    )
    return replace(result, study=study, scatter=bands), notes


def amplitude_rows(study: StudyDescription) -> list[dict[str, float]]:
    """Return results at the amplitudes of the loops, one row per load and amplitude."""
    study = at_central_values(study)
    joints = build_joints(study)
    excitation = with_defaults(study, joints)[0].excitation
    rows = []
    for joint in joints:
        at_rest = {
            "normal_load": getattr(joint, "normal_load", math.nan),
            "tangential_stiffness": joint.tangential_stiffness,
            "force_limit": joint.force_limit,
        }
        columns = _row(study, joint, excitation).columns()
        for numbers in zip(*(column.tolist() for column in columns.values()), strict=True):
            rows.append({**at_rest, **dict(zip(columns, numbers, strict=True))})
    return rows


def _computed(
    study: StudyDescription, progress: Progress | None = None
) -> tuple[Prediction, list[str]]:
    begin = _solving(study)
    joints = build_joints(study, _part(progress, 0.0, begin))
    progress = _part(progress, begin, 1.0)
    excited, notes = with_defaults(study, joints)
    excitation, history = excited.excitation, study.excitation.history
    curve = excitation.curve
    assert curve is not None
    grid = np.geomspace(curve.start, curve.to, curve.points)
    loops: list[tuple[Loop, ...]] = []
    rows, curves = [], []
    histories = []
    for index, joint in enumerate(joints):
        row = _row(study, joint, excitation)
        rows.append(row)
        with naming_key(study, "excitation.amplitudes"):
            loops.append(tuple(joint.loop(a) for a in row.amplitude.tolist()))
        with naming_key(study, "excitation.curve"):
            curves.append(AmplitudeCurve.of(joint, grid))
        if history is not None:
            with naming_key(study, "excitation.history"):
                histories.append(HistoryResponse.of(joint, history.values, history.quantity))
        progress((index + 1) / len(joints))
    result = Prediction(
        study=study,
        joints=tuple(joints),
        loops=tuple(loops),
        rows=tuple(rows),
        curves=tuple(curves),
        histories=tuple(histories),
    )
    return result, notes


def _solving(study: StudyDescription) -> float:
    """Return the estimated fraction of the computing time spent on solving the surface [-]."""
    return 0.8 if isinstance(study.surface, MeasuredFace) else 0.0


def _part(progress: Progress | None, begin: float, end: float) -> Progress:
    """Return a callback for the completed fraction of a part from ``begin`` to ``end`` [-]."""
    report = progress or (lambda share: None)
    return lambda share: report(begin + (end - begin) * share)


def _row(study: StudyDescription, joint: Interface, excitation: ExcitationTable) -> AmplitudeCurve:
    if excitation.force_amplitudes is None:
        with naming_key(study, "excitation.amplitudes"):
            return AmplitudeCurve.of(joint, np.array(excitation.amplitudes))
    with naming_key(study, "excitation.force_amplitudes"):
        forces = np.array(excitation.force_amplitudes)
        return AmplitudeCurve.of(joint, np.asarray(joint.backbone_displacement(forces)), forces)
