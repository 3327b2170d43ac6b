"""Data set of a prediction: all results by name, and its CSV tables."""

from __future__ import annotations

import re
from dataclasses import fields

import numpy as np

from microslip._core.dataset import DataSet, Variable
from microslip._core.quantities import Quantity
from microslip.report.structure.data import AMPLITUDE, structure_arrays
from microslip.study.runs.columns import AmplitudeCurve, HistoryResponse
from microslip.study.runs.prediction import Prediction, variable_of, variables_of
from microslip.study.runs.rest import joint_verdicts

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
