"""All numbers of a result as labelled arrays: `result.nc` and xarray's data set."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from microslip import kernels
from microslip._core.netcdf import Variable
from microslip._version import __version__
from microslip.report.netcdf import Contents
from microslip.results.predicted.numbers import (
    KIND,
    SUMMARY_SCHEMA,
    verdicts,
)
from microslip.results.structure.document import labelled as structure_arrays
from microslip.runs.dataset import labelled, variables
from microslip.runs.prediction import Prediction

WORDS = ("ok", "watch", "outside", "not judged")
"""Words of the verdicts; a variable holds their index, which is that of older files."""


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
        "load": labelled(("load",), loads, "normal_load"),
        driven: labelled((driven,), getattr(rows[0], driven), driven),
        "sample": _index("sample", dims["sample"], "sample of a loop"),
        "point": _index("point", dims["point"], "point of the curves"),
        "curve_amplitude": labelled(("point",), curves[0].amplitude, "amplitude"),
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
        sizes, labels, curves_of_modes = structure_arrays(result.structure)
        dims |= sizes
        coords |= labels
        arrays |= curves_of_modes
    return Contents(dims, coords, arrays, _attributes(result))


def _index(dim: str, size: int, meaning: str) -> Variable:
    """Numbers from 0, to label what has no other label."""
    values = np.arange(size, dtype=np.int32)
    return Variable((dim,), values, {"units": "1", "long_name": meaning})


def _validity(result: Prediction) -> dict[str, Variable]:
    """Verdicts: of each its value, the index of its word and, where it varies, the load."""
    arrays = {}
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
        arrays[name] = Variable(("load",), values, {**about, **about_values})
        flags = {
            "flag_values": np.arange(len(WORDS), dtype=np.int8),
            "flag_meanings": " ".join(word.replace(" ", "_") for word in WORDS),
        }
        arrays[f"{name}_word"] = Variable(("load",), words, {**about, **flags})
        if result.study.excitation.load_varies:
            at = np.array([np.nan if load is None else load for load in loads])
            of = {"comment": "NaN where the verdict is the same at all loads"}
            label = f"normal load at which {verdict.name} is worst"
            about = {"units": "N", "long_name": label, **of}
            arrays[f"{name}_normal_load"] = Variable(("load",), at, about)
    return arrays


def _attributes(result: Prediction) -> dict[str, Any]:
    texts: Mapping[str, str] = {
        "title": result.study.title,
        "kind": KIND,
        "source": f"microslip {__version__}",
        "kernel": kernels.NAME,
        "study": result.study.text,
        "notes": "\n".join(result.summary["notes"]),
    }
    schema = {"schema": np.int32(SUMMARY_SCHEMA)}
    return {**{name: text for name, text in texts.items() if text}, **schema}
