"""Document of an inverse design: the values found, their uncertainty, and the trade-off."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from microslip._core.units import FORCE, LENGTH, engineering
from microslip.report import cells
from microslip.report.document import Column, Document, Facts, Note, Picture, Section, Table
from microslip.report.files import header
from microslip.report.kit import look_of
from microslip.report.plot import Axis, Entry, Panel, Plot, Rule, stacked
from microslip.runs.design import KEYS, UNITS, DesignPoint, Search
from microslip.sweeps.quantiles import interval_of_share

KIND = "microslip-design"
SUMMARY_SCHEMA = 1


def _number(value: float) -> str:
    return f"{value:.4g}"


def _quantity(key: str, value: float) -> str:
    _, kind = KEYS.get(key, ("", None))
    return engineering(value, kind.unit, 4) if kind in (FORCE, LENGTH) else _number(value)


def _amount(quantity: str, value: float) -> str:
    return engineering(value, UNITS[quantity], 4) if quantity in UNITS else _number(value)


def document(search: Search, design: DesignPoint, curve: Sequence[DesignPoint]) -> Document:
    """A design as a document; its data is the summary."""
    target = search.target
    share = "" if search.is_certain else f" with {100.0 * search.probability:g} %"
    study = search.at(search.start, target.value)
    rows = tuple(
        (
            r.key,
            *(
                _quantity(r.key, value)
                for value in (float(search.middle[name]), design.values[r.key], r.low, r.high)
            ),
        )
        for r, name in zip(search.ranges, search.names, strict=True)
    )
    columns = (
        Column("key", "Key"),
        *(Column(name.lower(), name) for name in ("Study", "Design", "From", "To")),
    )

    def outcome_text(point: DesignPoint) -> str:
        number = _amount(target.quantity, point.reached)
        if search.is_certain:
            return number
        low, high = interval_of_share(point.probability, point.samples)
        return (
            f"{number}, met by {point.probability:.1%} of {point.samples} samples (of all draws "
            f"{low:.0%} to {high:.0%}, with 90 %)"
        )

    facts = Facts(
        "Target",
        (
            ("Target", target.written),
            *(() if search.is_certain else (("Probability", share.removeprefix(" with ")),)),
            ("Reached by the study", outcome_text(study)),
            ("Reached by the design", outcome_text(design)),
        ),
    )
    picture = Picture(
        "trade_off",
        "The design for each level of the target, as shares of the study’s values; hollow where no "
        "value of the ranges meets it.",
        lambda: plot(search, curve),
        "Trade-off between the target and the keys",
    )
    trade = Table(
        "Trade-off",
        (
            Column("level", "Level wanted", write=cells.ratio),
            Column("reached", "Reached", write=cells.ratio),
            Column("met", "Met by", write=cells.percent),
            *(Column(r.key, r.key, write=_number) for r in search.ranges),
        ),
        tuple((f.level, f.reached, f.probability, *f.values.values()) for f in curve),
        noun="levels",
    )
    remark = (
        "The design is the smallest change of the study, in logarithms of the keys; values are in "
        "SI units. Uncertain inputs scatter about the design by the same relative amounts."
    )
    values = ", ".join(f"{key} = {_quantity(key, v)}" for key, v in design.values.items())
    reached = "" if search.is_certain else f" with {100.0 * design.probability:.3g} %"
    answer = f"{values} gives {target.written}{reached}."
    if not design.feasible:
        answer = (
            f"No values in the ranges give {target.written}{share}; the nearest, {values}, "
            f"reach {_amount(target.quantity, design.reached)}."
        )
    data: dict[str, Any] = {
        **header(KIND, SUMMARY_SCHEMA, "Design"),
        "target": target._asdict(),
        "probability": search.probability,
        "feasible": design.feasible,
        "design": dict(design.values),
        "reached": design.reached,
        "met_by": design.probability,
        "met_by_interval": list(interval_of_share(design.probability, design.samples)),
        "study": {"reached": study.reached, "met_by": study.probability},
        "trade_off": [
            {"level": f.level, "reached": f.reached, "met_by": f.probability,
             "feasible": f.feasible, "design": dict(f.values)}
            for f in curve
        ],
        "files": [],
    }  # fmt: skip
    title = search.study.title or "Design"
    first = Section("Design", (facts, Table("Values", columns, rows), Note(remark, small=True)))
    sections = (Section("Trade-off", (trade, picture), brief=False),) if curve else ()
    return Document(KIND, title, answer, (first, *sections), data)


def plot(search: Search, curve: Sequence[DesignPoint]) -> Plot:
    """Values of the keys over the level wanted, and the probability with which it is met."""
    levels = np.array([f.level for f in curve])
    feasible = np.array([f.feasible for f in curve])
    label = search.target.quantity.replace("_", " ").capitalize()
    along = f"{label} wanted"
    values = Panel(Axis(along, log=True), Axis("Key over that of the study", log=True))
    probability = Panel(Axis(along, log=True), Axis("Samples that meet it [%]", 0.0, 104.0))
    entries = []
    for index, (r, name) in enumerate(zip(search.ranges, search.names, strict=True)):
        color, dash, _ = look_of(index)
        y = np.array([f.values[r.key] for f in curve]) / float(search.middle[name])
        values.line(levels, y, color, dash=dash)
        values.marks(levels[feasible], y[feasible], color, filled=True)
        values.marks(levels[~feasible], y[~feasible], color)
        entries.append(Entry(r.key, color, dash))
    probability.line(levels, [100.0 * f.probability for f in curve])
    probability.marks(levels, [100.0 * f.probability for f in curve])
    probability.add(Rule(100.0 * search.probability))
    for panel in (values, probability):
        panel.add(Rule(search.target.value, "x"))
    return stacked([values, probability], 6.0, (3.0, 2.0), entries, search.study.title)
