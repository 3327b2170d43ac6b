"""What a prediction says of its scatter: bands, how sure they are, and what to measure next."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip.report import cells
from microslip.report.document import Block, Column, Facts, Note, Picture, Section, Table
from microslip.report.files import plain
from microslip.report.plot import Area, Axis, Panel, Plot
from microslip.results.predicted.prediction import Prediction
from microslip.results.predicted.scatter import RANKED, Decision, Scatter

_WORDS = {
    "loss_factor": "Loss factor η",
    "dissipated_energy": "Dissipated energy",
    "secant_stiffness": "Secant stiffness",
}
_UNITS = {"loss_factor": "", "dissipated_energy": "J", "secant_stiffness": "N/m"}
_MOST_BARS = 10
FIGURES = ("tornado",)
"""Names of the figures."""


def sections(result: Prediction) -> tuple[Section, ...]:
    """The part of a document that is about the scatter."""
    scatter = result.scatter
    if scatter is None:
        return ()
    blocks: list[Block] = [
        Facts(
            "Not known exactly",
            (
                *((entry.key, entry.written) for entry in scatter.inputs),
                ("Samples", str(scatter.samples)),
            ),
        ),
        *(_bands(result, scatter, name) for name in RANKED[:2]),
        _ranking(result, scatter),
        Note(_remark(scatter), small=True),
        *(Note(note, small=True) for note in scatter.notes),
    ]
    pictures = Section("Scatter in figures", (_picture(result, scatter),), brief=False)
    return Section("Scatter", tuple(blocks)), pictures


def _places(result: Prediction) -> list[tuple[int, int, float, float]]:
    """Load and amplitude indices, with their values."""
    return [
        (i, j, float(getattr(joint, "normal_load", math.nan)), float(a))
        for i, (joint, row) in enumerate(zip(result.joints, result.rows, strict=True))
        for j, a in enumerate(row.amplitude)
    ]


def _bands(result: Prediction, scatter: Scatter, name: str) -> Table:
    percent = [f"{100.0 * q:g} %" for q in scatter.quantiles]
    unit = _UNITS[name]
    write = cells.ratio if not unit else None
    columns = [
        Column("normal_load", "Normal load", "N", 4, short="load"),
        Column("amplitude", "Amplitude", "m", 4, short="amplitude"),
        *(Column(f"q{i}", text, unit, 3, write=write) for i, text in enumerate(percent)),
        Column("error", "Error of these", "", write=cells.percent, short="error"),
    ]
    band, error = scatter.bands[name].values, scatter.errors[name]
    rows = []
    for i, j, load, a in _places(result):
        values = band[:, i, j]
        with np.errstate(divide="ignore", invalid="ignore"):
            relative = float(np.max(error[:, i, j] / values))
        error_share = relative if math.isfinite(relative) else None
        rows.append((load if math.isfinite(load) else None, a, *values.tolist(), error_share))
    return Table(_WORDS[name], tuple(columns), tuple(rows), keys=2, noun="loops")


def _ranking(result: Prediction, scatter: Scatter) -> Table:
    """Who is to be measured next, for the loss factor."""
    indexed = scatter.decisions[0].first is not None
    columns = [
        Column("normal_load", "Normal load", "N", 4, short="load"),
        Column("amplitude", "Amplitude", "m", 4, short="amplitude"),
        Column("input", "Not known exactly", short="input"),
        Column("share", "Share in the scatter of ln η", "", write=cells.percent, short="share"),
        *(
            (
                Column("first", "Sobol’ index, first", "", write=cells.ratio, short="first"),
                Column("total", "Sobol’ index, total", "", write=cells.ratio, short="total"),
            )
            if indexed
            else ()
        ),
        Column("low", "η at its 5 %", "", write=cells.ratio),
        Column("high", "η at its 95 %", "", write=cells.ratio),
    ]
    rows = []
    for i, j, load, a in _places(result):
        decision = scatter.decision("loss_factor", i, j)
        for k in np.argsort(-decision.shares)[:4].tolist():
            row: list[Any] = [
                load if math.isfinite(load) else None, a, scatter.inputs[k].key,
                float(decision.shares[k]),
            ]  # fmt: skip
            if decision.first is not None and decision.total is not None:
                row += [float(decision.first[k]), float(decision.total[k])]
            rows.append((*row, float(decision.low[k]), float(decision.high[k])))
    return Table("What to measure next", tuple(columns), tuple(rows), keys=2, noun="inputs")


def _remark(scatter: Scatter) -> str:
    """How the delta method sees it."""
    decisions = [d for d in scatter.decisions if d.name == "loss_factor"]
    worst = max(decisions, key=_disagreement)
    return (
        f"Standard deviation of ln η over the samples and by the delta method: "
        f"{worst.scatter:.3g} and {worst.delta:.3g} where they differ most; a regression on the "
        f"inputs explains {min(d.explained for d in decisions):.0%} or more. Errors are of the "
        "quantiles, over eight scramblings of the points."
    )


def _disagreement(decision: Decision) -> float:
    return abs(decision.scatter - decision.delta)


def _picture(result: Prediction, scatter: Scatter) -> Picture:
    return Picture(
        "tornado",
        "The loss factor with one input at its 5 % and 95 % and the others at their medians, at "
        "the amplitude of each loop where it scatters most: the longest bar is what to measure "
        "next.",
        lambda: tornado(result, scatter),
        "What each input does to the loss factor",
    )


def tornado(result: Prediction, scatter: Scatter) -> Plot:
    """Bars of what each input does, for the load and amplitude whose loss factor scatters most."""
    decision = max(
        (d for d in scatter.decisions if d.name == "loss_factor"), key=lambda d: d.scatter
    )
    middle = float(result.rows[decision.load].loss_factor[decision.amplitude])
    reach: Floats = np.abs(np.log(decision.high / decision.low))
    order = np.argsort(reach)[::-1][:_MOST_BARS][::-1]
    ticks = [(float(place), scatter.inputs[k].key) for place, k in enumerate(order.tolist())]
    joint, row = result.joints[decision.load], result.rows[decision.load]
    from microslip._core.units import engineering

    at = engineering(float(row.amplitude[decision.amplitude]), "m", 3, trim=True)
    load = getattr(joint, "normal_load", None)
    at += f", {engineering(load, 'N', 3, trim=True)}" if load is not None else ""
    panel = Panel(
        Axis("Loss factor η"),
        Axis(low=-0.6, high=len(ticks) - 0.4, ticks=ticks),
        note=f"at {at}; pale: 5 % of the input, dark: 95 %",
    )
    for place, k in enumerate(order.tolist()):
        for value, color in ((decision.low[k], "#9ecae1"), (decision.high[k], "#2b7bba")):
            x = np.array([middle, value, value, middle])
            panel.add(Area(x, place + np.array([-0.32, -0.32, 0.32, 0.32]), color))
    panel.line([middle, middle], [-0.6, len(ticks) - 0.4], "#333333", width=0.8)
    return Plot([panel], 1.2 + 0.42 * len(ticks), title=result.study.title)


def numbers(scatter: Scatter) -> dict[str, Any]:
    """What the summary holds of it: plain values in SI units."""
    return {
        "inputs": {entry.key: entry.written for entry in scatter.inputs},
        "samples": scatter.samples,
        "quantiles": scatter.quantiles.tolist(),
        "bands": {
            name: {
                "quantiles": plain(scatter.bands[name].values),
                "errors": plain(scatter.errors[name]),
            }
            for name in (*RANKED, "force_amplitude", "damping_ratio", "tangential_stiffness")
            if name in scatter.errors
        },
        "decisions": [
            {
                "quantity": d.name,
                "load": d.load,
                "amplitude": d.amplitude,
                "standard_deviation_of_logarithm": plain(d.scatter),
                "delta_method": plain(d.delta),
                "explained": plain(d.explained),
                "inputs": {
                    entry.key: {
                        "share": plain(d.shares[k]),
                        "low": plain(d.low[k]),
                        "high": plain(d.high[k]),
                        **(
                            {"first": plain(d.first[k]), "total": plain(d.total[k])}
                            if d.first is not None and d.total is not None
                            else {}
                        ),
                    }
                    for k, entry in enumerate(scatter.inputs)
                },
            }
            for d in scatter.decisions
        ],
        "notes": list(scatter.notes),
    }
