"""Tables of a prediction: joints at rest, cycles, history, scatter."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from functools import partial
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip._core.dataset import DataSet
from microslip._core.quantities import QUANTITIES, Quantity, count, json_value, named
from microslip._core.units import engineering, significant
from microslip.friction import Interface
from microslip.report import cells
from microslip.report.document import Block, Note, Section, Table, Verdicts
from microslip.study.description import StudyDescription
from microslip.study.runs.prediction import Prediction
from microslip.study.runs.rest import joint_verdicts
from microslip.study.runs.scatter import RANKED, PredictionScatter

_SCALES = {
    "slip_per_indentation * heights.std": "κ times the standard deviation of the heights",
    "slip_per_indentation * heights.scale": "κ times the mean height",
    "slip_per_indentation * spread of the heights": (
        "κ times the spread of the heights (the standard deviation, where that is finite)"
    ),
    "force_limit / tangential_stiffness": "the force limit over the stiffness at rest",
}

_INPUTS = {
    "friction_coefficient": "μ",
    "normal_load": "N",
    "young_modulus": "E",
    "heights": "spread of heights",
    "rms_slope": "rms slope",
    "copies": "number of summits",
    "cutoff": "short-wave cut-off",
    "hardness": "hardness",
    "tightening_pressure": "tightening pressure",
}
_MOST_INPUTS = 3

TOTAL_ENERGY = Quantity("J", label="Dissipated energy", symbol="dissipated energy", form="3")
"""Energy dissipated along a history."""
JointRows = Sequence[dict[str, Any]]


def joint_table(joints: JointRows, title: str = "Joint") -> Table:
    """Return the table of joints at rest, one row per load."""
    share_known = joints[0]["contact_area_fraction"] is not None
    at_rig = joints[0]["rig_tangential_stiffness"] is not None
    names = (
        "normal_load",
        "contact_count",
        "contact_area_fraction" if share_known else "contact_area",
        "mean_contact_pressure",
        "normal_stiffness",
        "first_loading_stiffness",
        "tangential_stiffness",
        *(("rig_normal_stiffness", "rig_tangential_stiffness") if at_rig else ()),
        "force_limit",
        "slip_scale",
        "standardised_separation",
    )
    hidden = ("mean_contact_pressure", *(name for name in names if "normal_stiffness" in name))
    hidden += ("first_loading_stiffness",)
    scale = joints[0]["slip_scale_meaning"]
    h = joints[0]["standardised_separation"] is not None
    caption = (
        "kₙ and kₜ are the stiffnesses of the contact alone, in full stick. "
        + "As a rig measures them next to a small contact, they include the compliance of two "
        "half-spaces behind the contact, round or as joint.pressure gives it (Johnson 1985). "
        * at_rig
        + (
            "kₙ is that of unloading, as ultrasound measures it; a load-deflection test measures "
            "first loading. "
            if joints[0]["first_loading_stiffness"] is not None
            else ""
        )
        + "μN is the force of gross slip. "
        f"The slip scale is {_SCALES.get(scale, scale)}"
        + ("; h is the separation of the surfaces over the spread of the heights." if h else ".")
    )
    data = cells.of_records(joints, names)
    return Table(title, data, caption=caption, noun="loads", hidden=hidden)


def rest_section(joints: JointRows) -> Section:
    """Return the section on the joint at rest, with its sensitivities to the inputs."""
    return Section("Joint at rest", (joint_table(joints), *sensitivity_table(joints)))


def sensitivity_table(joints: JointRows) -> tuple[Table, ...]:
    """Return the largest sensitivities of each joint to inputs; empty without a surface."""
    rows = []
    for joint in joints:
        if not (slopes := joint.get("sensitivities")):
            continue
        amplitude = engineering(slopes["amplitude"], "m", 3, trim=True)
        labels = {"tangential_stiffness": "kₜ", "loss_factor": f"η at {amplitude}"}
        for name, label in labels.items():
            steepest = [
                f"{_INPUTS.get(key, key)}: {significant(slope, 2)}"
                for key, slope in list(slopes[name].items())[:_MOST_INPUTS]
                if abs(slope) >= 0.01
            ]
            rows.append((joint["normal_load"], label, ", ".join(steepest) or "none"))
    caption = (
        "d ln quantity/d ln input, the largest first: with 0.5 an error of 10 % in the input "
        "causes an error of 5 % in the quantity. Moduli change for both bodies, density and area "
        "for the whole joint."
    )
    if not rows:
        return ()
    loads, quantities, inputs = zip(*rows, strict=True)
    data = DataSet.of_rows(
        {
            "normal_load": (QUANTITIES["normal_load"], loads),
            "quantity": (count("Quantity"), quantities),
            "inputs": (count("Largest sensitivities"), inputs),
        }
    )
    table = Table("Sensitivities", data, keys=2, caption=caption, brief=False, noun="quantities")
    return (table,)


def cycle_table(joints: JointRows, by: str) -> Table:
    """Return the table of cycles, one row per load and amplitude.

    The first amplitude column is ``by``, the one that the study gives.
    """
    amplitudes = dict.fromkeys((by, "amplitude", "force_amplitude"))
    more = ("secant_stiffness", "dissipation_exponent", "stick_share")
    names = (
        "normal_load", *amplitudes, "force_ratio", "dissipated_energy", "loss_factor",
        "damping_ratio", *more,
    )  # fmt: skip
    hidden = more if by == "force_amplitude" else ("force_amplitude", *more)
    caption = (
        "T/μN is the force amplitude over the force limit. The exponent is the local exponent of "
        "the energy in the amplitude"
    )
    if joints[0]["amplitudes"][0].get("stick_share") is not None:
        caption += ", and the sticking fraction that of the contact area after first loading"
    rows = [{**joint, **row} for joint in joints for row in joint["amplitudes"]]
    data = cells.of_records(rows, names)
    return Table("Cycles", data, keys=2, caption=f"{caption}.", noun="loops", hidden=hidden)


def history_table(joints: JointRows) -> Table:
    """Return the extreme values of the response to a history, one row per load."""
    names = ("normal_load", "largest_displacement", "largest_force", "dissipated_energy")
    rows = [{**joint, **joint["history"]} for joint in joints]
    data = cells.of_records(rows, names, dissipated_energy=TOTAL_ENERGY)
    return Table("History", data, noun="loads")


def validity_verdicts(study: StudyDescription, joints: Sequence[Interface]) -> Verdicts:
    """Return the verdicts on the joints, each with the load to which it refers."""
    judgements, places = [], []
    newtons = partial(engineering, unit="N", digits=4, trim=True)
    for joint in joints:
        for verdict in joint_verdicts(study, joint):
            judgements.append(verdict)
            places.append(newtons(getattr(joint, "normal_load", 0.0)))
    caption = (
        "The limits are conventions of contact mechanics (Greenwood and Williamson 1966). Watch: "
        "the result depends on the assumption. Outside: do not rely on it."
    )
    return Verdicts(
        tuple(judgements), tuple(places), frozenset({"real over apparent area"}), caption=caption
    )


# -- scatter ---------------------------------------------------------------------------------------

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
        "quantiles": scatter.quantiles,
        "bands": {
            name: {
                "quantiles": scatter.bands[name].values,
                **({"intervals": scatter.intervals[name]} if name in scatter.intervals else {}),
            }
            for name in (*RANKED, "force_amplitude", "damping_ratio", "tangential_stiffness")
            if name in scatter.bands and (name in scatter.intervals or not scatter.inputs)
        },
        "decisions": [
            {
                "quantity": d.name,
                **named(d, "load", "amplitude"),
                "standard_deviation_of_logarithm": d.scatter,
                "explained": d.explained,
                "inputs": {
                    entry.key: {"share": share}
                    for entry, share in zip(scatter.inputs, d.shares, strict=True)
                },
            }
            for d in scatter.decisions
        ],
        "notes": scatter.notes,
    }
