"""All numbers of a result as labelled arrays: `result.nc` and xarray's data set."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from microslip._core.kernel_choice import kernel_name
from microslip._core.netcdf import Variable
from microslip._core.quantities import QUANTITIES
from microslip._version import __version__
from microslip.report.netcdf import Contents
from microslip.results.predicted.columns import Columns, Floats
from microslip.results.predicted.numbers import (
    KIND,
    SUMMARY_SCHEMA,
    scalars,
    verdicts,
)
from microslip.results.predicted.prediction import Prediction
from microslip.results.structure.document import labelled

WORDS = ("ok", "watch", "outside", "not judged")
"""Words of the verdicts; a variable holds their index, which is that of older files."""

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
"""What differs from the meaning of the quantity by itself."""


def contents(result: Prediction) -> Contents:
    """Label the arrays of a result."""
    by_force = result.study.excitation.force_amplitudes is not None
    driven = "force_amplitude" if by_force else "amplitude"
    rows, curves = result.rows, result.curves
    loads = np.array([getattr(joint, "normal_load", np.nan) for joint in result.joints])
    dims = {
        "load": len(loads),
        driven: rows[0].amplitude.size,
        "sample": result.loops[0][0].force.size,
        "point": curves[0].amplitude.size,
    }
    coords = {
        "load": _variable(("load",), loads, "normal_load"),
        driven: _variable((driven,), getattr(rows[0], driven), driven),
        "sample": _index("sample", dims["sample"], "sample of a loop"),
        "point": _index("point", dims["point"], "point of the curves"),
        "curve_amplitude": _variable(("point",), curves[0].amplitude, "amplitude"),
    }
    arrays = {**variables(result), **_validity(result)}
    if result.histories:
        dims["history_sample"] = size = result.histories[0].force.size
        coords["history_sample"] = _index("history_sample", size, "sample of the history")
    if result.scatter is not None:
        dims["quantile"] = result.scatter.quantiles.size
        coords["quantile"] = Variable(
            ("quantile",),
            result.scatter.quantiles,
            {"units": "1", "long_name": "share of the samples below"},
        )
        arrays |= {f"{name}_bands": band for name, band in result.scatter.bands.items()}
    if result.structure is not None:
        sizes, labels, curves_of_modes = labelled(result.structure)
        dims |= sizes
        coords |= labels
        arrays |= curves_of_modes
    return Contents(dims, coords, arrays, _attributes(result))


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


def _variable(dims: tuple[str, ...], values: Floats, name: str, meaning: str = "") -> Variable:
    about = QUANTITIES[name].attributes
    return Variable(dims, values, {**about, "long_name": meaning} if meaning else about)


def _index(dim: str, size: int, meaning: str) -> Variable:
    """Numbers from 0, to label what has no other label."""
    values = np.arange(size, dtype=np.int32)
    return Variable((dim,), values, {"units": "1", "long_name": meaning})


def _scalars(result: Prediction) -> dict[str, Variable]:
    """Numbers of each joint, without those that none has."""
    rows = [
        {**scalars(result.study, joint), **asdict(limits)}
        for joint, limits in zip(result.joints, result.limits, strict=True)
    ]
    variables = {
        name: _variable(("load",), np.array([row[name] for row in rows], dtype=float), name)
        for name in rows[0]
        if any(row[name] is not None for row in rows)
    }
    scale = variables["slip_scale"]
    comment = {"comment": result.joints[0]._slip_scale[1]}
    variables["slip_scale"] = scale._replace(attributes={**scale.attributes, **comment})
    return variables


def _validity(result: Prediction) -> dict[str, Variable]:
    """Verdicts: of each its value, the index of its word and, where it varies, the load."""
    variables = {}
    judged = [verdicts(result.study, joint) for joint in result.joints]
    for place, (verdict, _) in enumerate(
        judged[0][: len(getattr(result.joints[0], "validity", ()))]
    ):
        name = "validity_" + re.sub(r"\W+", "_", verdict.name)
        verdicts_of_loads, loads = zip(
            *(verdict_of_load[place] for verdict_of_load in judged), strict=True
        )
        values = np.array(
            [
                np.nan if verdict_of_load.value is None else float(verdict_of_load.value)
                for verdict_of_load in verdicts_of_loads
            ]
        )
        words = np.array(
            [WORDS.index(verdict_of_load.word) for verdict_of_load in verdicts_of_loads],
            dtype=np.int8,
        )
        about = {"units": "1", "long_name": verdict.name}
        about_values = {"limit": float(verdict.limit), "comment": verdict.meaning}
        variables[name] = Variable(("load",), values, {**about, **about_values})
        flags = {
            "flag_values": np.arange(len(WORDS), dtype=np.int8),
            "flag_meanings": " ".join(word.replace(" ", "_") for word in WORDS),
        }
        variables[f"{name}_word"] = Variable(("load",), words, {**about, **flags})
        if result.study.excitation.load_varies:
            at = np.array([np.nan if load is None else load for load in loads])
            of = {"comment": "NaN where the verdict is the same at all loads"}
            label = f"normal load at which {verdict.name} is worst"
            about = {"units": "N", "long_name": label, **of}
            variables[f"{name}_normal_load"] = Variable(("load",), at, about)
    return variables


def _loops(result: Prediction, driven: str) -> dict[str, Variable]:
    names = {"displacement": "displacement", "force": "force"}
    if result.varying:
        names["varying_normal_load"] = "normal_load"
    variables = {}
    for name, attribute in names.items():
        values = np.array([[getattr(loop, attribute) for loop in loops] for loops in result.loops])
        variables[name] = _variable(("load", driven, "sample"), values, name)
    return variables


def _columns(
    tables: Sequence[Columns], prefix: str, dim: str, leave_out: str = ""
) -> dict[str, Variable]:
    """Columns of one table for each load, by their names."""
    return {
        prefix + name: _variable(
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


def _attributes(result: Prediction) -> dict[str, Any]:
    texts: Mapping[str, str] = {
        "title": result.study.title,
        "kind": KIND,
        "source": f"microslip {__version__}",
        "kernel": kernel_name(),
        "study": result.study.text,
        "notes": "\n".join(result.summary["notes"]),
    }
    schema = {"schema": np.int32(SUMMARY_SCHEMA)}
    return {**{name: text for name, text in texts.items() if text}, **schema}
