"""A prediction: all numbers of a study that was run."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from microslip._core.netcdf import Variable
from microslip._core.quantities import QUANTITIES
from microslip.errors import InputError
from microslip.friction import Interface
from microslip.friction.input_slopes import input_slopes
from microslip.loops import Loop
from microslip.runs.columns import (
    AmplitudeCurve,
    Columns,
    Floats,
    HistoryResponse,
    Limits,
    OscillatorCurve,
    VaryingCycles,
)
from microslip.runs.scatter import Scatter
from microslip.runs.structure_prediction import StructurePrediction
from microslip.study.description import StudyDescription
from microslip.study.scanned_surface import ScanSurface


@dataclass(frozen=True, eq=False, repr=False)
class Prediction:
    """All numbers of a study, as :class:`microslip.Result` tells them."""

    study: StudyDescription
    joints: tuple[Interface, ...]
    loops: tuple[tuple[Loop, ...], ...]
    rows: tuple[AmplitudeCurve, ...]
    curves: tuple[AmplitudeCurve, ...]
    limits: tuple[Limits, ...]
    histories: tuple[HistoryResponse, ...] = ()
    oscillators: tuple[OscillatorCurve, ...] = ()
    varying: tuple[VaryingCycles, ...] = ()
    structure: StructurePrediction | None = None
    scatter: Scatter | None = None
    summary: dict[str, Any] = field(default_factory=dict)
    """Its document, once made: see :class:`microslip.Result`."""

    def __repr__(self) -> str:
        parts = [
            *([repr(self.study.title)] if self.study.title else []),
            _count(len(self.joints), "load"),
            _count(len(self.rows[0].amplitude), "amplitude"),
            f"curves of {len(self.curves[0].amplitude)} points",
            *(f"history of {_count(len(h.force), 'sample')}" for h in self.histories[:1]),
            *("oscillator" for _ in self.oscillators[:1]),
            *("varying load" for _ in self.varying[:1]),
            *(["scatter"] if self.scatter is not None else []),
            *(["structure"] if self.structure is not None else []),
        ]
        return f"Result({', '.join(parts)})"


def _count(count: int, word: str) -> str:
    return f"{count} {word}" if count == 1 else f"{count} {word}s"


MEANINGS = {
    "history_dissipated_energy": "energy dissipated since rest",
    "varying_force_amplitude": "half the range of the force under the varying normal load",
    "varying_dissipated_energy": "energy dissipated in a cycle under the varying normal load",
    "varying_energy_ratio": "energy ratio under the varying normal load",
    "varying_loss_factor": "loss factor under the varying normal load",
    "varying_damping_ratio": "damping ratio under the varying normal load",
    "varying_secant_stiffness": "secant stiffness under the varying normal load",
    "oscillator_damping_ratio": "damping ratio of the mode, viscous damping and joint",
}
"""Meanings that differ from that of the quantity by itself."""


def variables(result: Prediction) -> dict[str, Variable]:
    """All numbers by their names, the verdicts left out."""
    driven = "amplitude" if result.study.excitation.force_amplitudes is None else "force_amplitude"
    arrays = {
        **_scalars(result),
        **_loops(result, driven),
        **_columns(result.rows, "", driven, leave_out=driven),
        **_columns(result.curves, "curve_", "point", leave_out="amplitude"),
    }
    if result.varying:
        arrays |= _columns(result.varying, "varying_", driven, leave_out="amplitude")
    if result.histories:
        arrays |= _columns(result.histories, "history_", "history_sample")
    if result.oscillators:
        arrays |= _columns(result.oscillators, "oscillator_", "point", leave_out="amplitude")
    return arrays


def labelled(dims: tuple[str, ...], values: Floats, name: str, meaning: str = "") -> Variable:
    """Values with the unit and the meaning of a quantity, or with a meaning of their own."""
    about = QUANTITIES[name].attributes
    return Variable(dims, values, {**about, "long_name": meaning} if meaning else about)


def _scalars(result: Prediction) -> dict[str, Variable]:
    """Numbers of each joint, without those that none has."""
    rows = [
        {**scalars(result.study, joint), **asdict(limits)}
        for joint, limits in zip(result.joints, result.limits, strict=True)
    ]
    variables = {
        name: labelled(("load",), np.array([row[name] for row in rows], dtype=float), name)
        for name in rows[0]
        if any(row[name] is not None for row in rows)
    }
    scale = variables["slip_scale"]
    comment = {"comment": result.joints[0]._slip_scale[1]}
    variables["slip_scale"] = scale._replace(attributes={**scale.attributes, **comment})
    return variables


def scalars(study: StudyDescription, joint: Interface) -> dict[str, float | None]:
    """Numbers that belong to a joint at rest; None for what is not known."""
    contact = getattr(joint, "contact_area", None)
    area = None if study.surface is None else study.surface.apparent_area
    return {
        "separation": getattr(joint, "separation", None),
        "standardised_separation": getattr(joint, "standardised_separation", None),
        "contact_count": getattr(joint, "contact_count", None),
        "contact_area": contact,
        "contact_area_fraction": contact / area if contact is not None and area else None,
        "mean_contact_pressure": joint.normal_load / contact if contact else None,
        "normal_stiffness": getattr(joint, "normal_stiffness", None),
        "tangential_stiffness": joint.tangential_stiffness,
        "force_limit": joint.force_limit,
        "slip_per_indentation": getattr(joint, "slip_per_indentation", None),
        "slip_scale": joint._slip_scale[0],
    }


def _loops(result: Prediction, driven: str) -> dict[str, Variable]:
    names = {"displacement": "displacement", "force": "force"}
    if result.varying:
        names["varying_normal_load"] = "normal_load"
    variables = {}
    for name, attribute in names.items():
        values = np.array([[getattr(loop, attribute) for loop in loops] for loops in result.loops])
        variables[name] = labelled(("load", driven, "sample"), values, name)
    return variables


def _columns(
    tables: Sequence[Columns], prefix: str, dim: str, leave_out: str = ""
) -> dict[str, Variable]:
    """Columns of one table for each load, by their names."""
    return {
        prefix + name: labelled(
            ("load", dim),
            _stacked([table.columns()[name] for table in tables]),
            name,
            MEANINGS.get(prefix + name, ""),
        )
        for name in tables[0].columns()
        if name != leave_out
    }


def _stacked(arrays: Sequence[Floats]) -> Floats:
    # One long array is not copied.
    return arrays[0][np.newaxis] if len(arrays) == 1 else np.stack(arrays)


# -- sensitivities of the answers of each joint to its inputs --------------------------------------

_STEP = 0.2
"""Half of the logarithm over which cut-offs are varied: summits come and go one by one."""


def leading_inputs(study: StudyDescription, joint: Any) -> dict[str, Any] | None:
    """Slopes of stiffness and loss factor over all inputs; None of a law without a surface."""
    if not isinstance(joint, Interface):
        return None
    amplitudes = study.excitation.amplitudes
    amplitude = joint._slip_scale[0]
    if amplitudes:
        amplitude = math.exp(math.fsum(map(math.log, amplitudes)) / len(amplitudes))
    slopes = input_slopes(joint, amplitude)
    if isinstance(study.surface, ScanSurface):
        for quantity, slope in _over_cutoff(study.surface, joint, amplitude).items():
            slopes[quantity]["cutoff"] = slope
    return {
        "amplitude": amplitude,
        **{
            name: dict(sorted(slopes_of_answer.items(), key=lambda pair: -abs(pair[1])))
            for name, slopes_of_answer in slopes.items()
        },
    }


def _over_cutoff(surface: ScanSurface, joint: Interface, amplitude: float) -> dict[str, float]:
    with suppress(InputError):  # a cut-off that leaves no summit, or none that carries the load
        ends = []
        for sign in (-1.0, 1.0):
            law = surface.law_at(joint.surface.pair, math.exp(sign * _STEP))
            if law is None or hasattr(joint.surface, "tightening_load"):
                return {}
            ends.append(Interface(law, joint.friction_coefficient, normal_load=joint.normal_load))
        pairs = {
            "tangential_stiffness": [end.tangential_stiffness for end in ends],
            "loss_factor": [float(end.loss_factor(amplitude)) for end in ends],
        }
        return {name: math.log(high / low) / (2.0 * _STEP) for name, (low, high) in pairs.items()}
    return {}
