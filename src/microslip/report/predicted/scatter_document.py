"""Scatter of a prediction: bands, their sampling error, and the most influential inputs."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip._core.dataset import DataSet
from microslip._core.quantities import QUANTITIES, Quantity, json_value, named
from microslip.report import cells
from microslip.report.document import Block, Note, Section, Table
from microslip.study.runs.prediction import Prediction
from microslip.study.runs.scatter import RANKED, PredictionScatter

_BANDS = ("loss_factor", "dissipated_energy")


def scatter_sections(result: Prediction) -> tuple[Section, ...]:
    """Return the sections on the scatter of the results: bands, sampling errors, leading inputs."""
    scatter = result.scatter
    if scatter is None:
        return ()
    if not scatter.inputs:  # the interval of an identified law
        tables = (_bands(result, scatter, name) for name in _BANDS)
        words = (Note(note, small=True) for note in scatter.notes)
        return (Section("Scatter", (*tables, *words)),)
    inputs = ((entry.key, entry.written) for entry in scatter.inputs)
    blocks: list[Block] = [
        cells.texts("Uncertain inputs", (*inputs, ("Samples", str(scatter.samples)))),
        *(_bands(result, scatter, name) for name in _BANDS),
        _ranking(result, scatter),
        Note(_remark(scatter), small=True),
        *(Note(note, small=True) for note in scatter.notes),
    ]
    return (Section("Scatter", tuple(blocks)),)


def _places(result: Prediction) -> list[tuple[int, int, float | None, float]]:
    return [
        (i, j, json_value(getattr(joint, "normal_load", None)), float(a))
        for i, (joint, row) in enumerate(zip(result.joints, result.rows, strict=True))
        for j, a in enumerate(row.amplitude)
    ]


def _loop_columns(loads: Iterable[float | None], amplitudes: Iterable[float]) -> dict[str, Any]:
    return {
        "normal_load": (QUANTITIES["normal_load"], loads),
        "amplitude": (QUANTITIES["amplitude"], amplitudes),
    }


def _bands(result: Prediction, scatter: PredictionScatter, name: str) -> Table:
    band, quantity = scatter.bands[name].values, QUANTITIES[name]
    first, second, loads, amplitudes = zip(*_places(result), strict=True)
    columns = _loop_columns(loads, amplitudes)
    for q, values in zip(scatter.quantiles, band, strict=True):
        label = f"{100.0 * q:g} %"
        columns[label] = quantity._replace(label=label, symbol=""), values[first, second]
    if name in scatter.intervals:
        label = "90 % interval of the quantiles, ±"
        error = Quantity("-", label=label, symbol="± (90 %)", form="percent")
        columns["error"] = error, np.max(_half_widths(scatter, name), axis=0)[first, second]
    return Table(quantity.label, DataSet.of_rows(columns), keys=2, noun="loops")


def _half_widths(scatter: PredictionScatter, name: str) -> Floats:
    """Return the half-widths of the confidence intervals of quantiles, relative to them [-].

    For an asymmetric interval it is the larger distance to an end. Unknown ends give infinity.
    """
    band, (low, high) = scatter.bands[name].values, scatter.intervals[name]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.maximum(band - low, high - band) / np.abs(band))


def _ranking(result: Prediction, scatter: PredictionScatter) -> Table:
    rows = []
    for i, j, load, a in _places(result):
        shares = scatter.decision("loss_factor", i, j).shares
        rows += [(load, a, scatter.inputs[k].key, shares[k]) for k in np.argsort(-shares)[:4]]
    loads, amplitudes, inputs, parts = zip(*rows, strict=True)
    columns = _loop_columns(loads, amplitudes)
    columns["input"] = Quantity("", label="Uncertain inputs", symbol="input"), inputs
    label = "Fraction of the variance of ln η"
    columns["share"] = Quantity("-", label=label, symbol="share", form="percent"), parts
    return Table("What to measure next", DataSet.of_rows(columns), keys=2, noun="inputs")


def _remark(scatter: PredictionScatter) -> str:
    """Describe how much scatter the regression explains, and sampling errors of the quantiles."""
    decisions = [d for d in scatter.decisions if d.name == "loss_factor"]
    return (
        "A regression on the inputs explains "
        f"{100.0 * min(d.explained for d in decisions):.0f} % or more of the variance of ln η. "
        f"{_confidence_text(scatter)}"
    )


def _confidence_text(scatter: PredictionScatter) -> str:
    widths = _half_widths(scatter, "loss_factor")
    widest, count = float(np.max(widths, initial=0.0)), scatter.samples
    text = (
        "Intervals contain the quantiles of an infinite sample with 90 % confidence, from order "
        "statistics over eight scrambled point sets"
    )
    if not math.isfinite(widest):
        tail = min(min(q, 1.0 - q) for q in scatter.quantiles.tolist())
        # Eight times a power of two with at least twelve samples in a tail.
        enough = 8 << max(3, math.ceil(math.log2(12.0 / tail / 8.0)))
        return (
            f"{text}; {count} samples are too few for an outer quantile: use about {enough} "
            "(uncertainty.samples)."
        )
    if widest <= _FINE:
        return f"{text}."
    # The error halves with four times the samples; quasi-random points do better.
    enough = math.ceil(count * (widest / _FINE) ** 2)
    return f"{text}; ±{100.0 * _FINE:.0f} % needs at most {enough} samples."


_FINE = 0.01


def scatter_numbers(scatter: PredictionScatter) -> dict[str, Any]:
    """Return the scatter as plain values in SI units, for the summary."""
    return {
        "inputs": {entry.key: entry.written for entry in scatter.inputs},
        "samples": scatter.samples,
        "quantiles": scatter.quantiles.tolist(),
        "bands": {
            name: {
                "quantiles": json_value(scatter.bands[name].values),
                **(
                    {"intervals": json_value(scatter.intervals[name])}
                    if name in scatter.intervals
                    else {}
                ),
            }
            for name in (*RANKED, "force_amplitude", "damping_ratio", "tangential_stiffness")
            if name in scatter.bands and (name in scatter.intervals or not scatter.inputs)
        },
        "decisions": [
            {
                "quantity": d.name,
                **named(d, "load", "amplitude"),
                "standard_deviation_of_logarithm": json_value(d.scatter),
                "explained": json_value(d.explained),
                "inputs": {
                    entry.key: {"share": json_value(share)}
                    for entry, share in zip(scatter.inputs, d.shares, strict=True)
                },
            }
            for d in scatter.decisions
        ],
        "notes": list(scatter.notes),
    }
