"""A fit for each specimen, or each stage: their parameters, how these scatter or change."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import Any

import numpy as np

from microslip._core.units import prefix
from microslip._core.verdicts import Word
from microslip._core.wording import shorten
from microslip.errors import InputError
from microslip.figures.picture import Picture
from microslip.figures.plot import COLORS, GREY, Axis, Panel, Plot, stacked
from microslip.identification import Identification
from microslip.identification.caveats import HAS_VALUE, label, number_text
from microslip.report.document import Block, Column, Judged, Section, Table
from microslip.report.identified import numbers
from microslip.tribometer import Record
from microslip.tribometer.campaign_laws import Pooled, pooled
from microslip.tribometer.estimates import Estimate

_ORDER = ("identified", "fixed", "in doubt", "extrapolated", "apparent")
"""Verdicts with a value, the best first: what several say together is no better than the worst."""
_MOST_PANELS = 5


@dataclass(frozen=True)
class Groups:
    """Fits of the records of each value of a column, each by itself."""

    column: str
    fits: Mapping[str, Identification]
    failed: Mapping[str, str]
    """Groups that could not be fitted, and why."""
    values: Mapping[str, float]
    """Numbers of a numeric column, over which results are then drawn and not pooled."""

    @classmethod
    def of(
        cls,
        column: str,
        labels: Sequence[str],
        values: Sequence[Any],
        records: Sequence[Record],
        fit: Callable[[list[Record]], Identification],
        accept_unconverged: bool = False,
    ) -> Groups | None:
        """Fit the records of each label; None where all have the same.

        Fits that have not converged count as failed, unless they are accepted.
        """
        if len(set(labels)) < 2:
            return None
        fits, failed = {}, {}
        for group_label in dict.fromkeys(labels):
            of_one = [r for r, other in zip(records, labels, strict=True) if other == group_label]
            try:
                result = fit(of_one)
            except InputError as error:
                failed[group_label] = str(error)
                continue
            if result.converged or accept_unconverged:
                fits[group_label] = result
            else:
                failed[group_label] = result.status
        is_numeric = all(isinstance(value, float) for value in values)
        by_label = dict(zip(labels, values, strict=True)) if is_numeric else {}
        return cls(column, MappingProxyType(fits), failed, by_label)

    def names(self) -> list[str]:
        """Parameters that are free in any of the fits."""
        every = (name for fit in self.fits.values() for name in fit.parameters)
        return [n for n in dict.fromkeys(every) if any(n in f.names for f in self.fits.values())]

    def pooled(self, confidence: float) -> list[tuple[Pooled, str]]:
        """Parameters of specimens together, where each tells them, and the worst verdict."""
        found = []
        for name in self.names() if not self.values else []:
            fitted = [
                (group_label, fit.parameters.get(name)) for group_label, fit in self.fits.items()
            ]
            known = [
                (group_label, number)
                for group_label, number in fitted
                if number is not None and number.verdict in _ORDER and math.isfinite(number.value)
            ]
            if len(known) < 2 or len(known) < len(self.fits):
                continue
            estimates = [
                (group_label, Estimate(f.value, f.low, f.high, f.standard_error, 2))
                for group_label, f in known
            ]
            verdict = max((f.verdict for _, f in known), key=_ORDER.index)
            found.append((pooled(name, estimates, confidence), verdict))
        return found

    def unit(self, name: str) -> str:
        """Unit of a parameter."""
        fits = (fit.parameters.get(name) for fit in self.fits.values())
        return next(number.unit for number in fits if number is not None)


def section(groups: Groups, confidence: float) -> Section:
    """Results of each group, and of all together."""
    noun = groups.column.replace("_", " ")
    names = groups.names()
    columns = (
        Column(groups.column, noun.capitalize(), short=noun),
        Column("status", "Fit", short="fit"),
        *(Column(name, label(name), short=label(name)) for name in names),
    )
    rows = [
        (shorten(group_label, 40), fit.status, *(_cell(fit.summary(), name) for name in names))
        for group_label, fit in groups.fits.items()
    ]
    rows += [
        (group_label, shorten(why, 120), *("–",) * len(names))
        for group_label, why in groups.failed.items()
    ]
    caption = (
        f"The records of each {noun} fitted by themselves; {100.0 * confidence:g} % intervals."
    )
    blocks: list[Block] = [Table(f"Each {noun} by itself", columns, tuple(rows), caption=caption)]
    if pools := groups.pooled(confidence):
        heads = (
            Column("parameter", "Parameter", short="parameter"),
            Column("mean", "Mean of all (interval)", short="mean of all (interval)"),
            Column("between", "Scatter between", short="scatter between"),
            Column("verdict", "Verdict", short="verdict"),
        )
        caption = (
            f"The {len(groups.fits)} {noun}s are taken as a random sample: the interval includes "
            "the scatter between them and the error of each. The verdict is the worst of theirs."
        )
        blocks.append(
            Table(
                "Together",
                heads,
                tuple(_pooled_row(groups, pool, verdict) for pool, verdict in pools),
                caption=caption,
            )
        )
    blocks.append(
        Picture(
            "groups",
            f"Parameters of each {noun} with their intervals.",
            partial(figure, groups),
            f"Parameters over {noun}",
        )
    )
    return Section(f"Over {noun}" if groups.values else f"Each {noun}", tuple(blocks))


def _cell(fit: numbers.Summary, name: str) -> Any:
    number = fit["parameters"].get(name)
    if number is None:
        return "–"
    text = f"{numbers.value_and_interval(number)}, {number['verdict']}"
    return Judged(numbers.word_of(number), text)


def _pooled_row(groups: Groups, pool: Pooled, verdict: str) -> tuple[Any, ...]:
    write = partial(number_text, unit=groups.unit(pool.quantity))
    mean = pool.mean
    text = f"{write(mean.value)} ({write(mean.low)} … {write(mean.high)})"
    word: Word = "ok" if verdict in ("identified", "fixed") else "watch"
    return label(pool.quantity), text, write(pool.between), Judged(word, verdict)


def figure(groups: Groups) -> Plot:
    """Parameters of the groups, over the column where it is of numbers."""
    labels = list(groups.fits)
    x = [groups.values.get(group_label, float(at + 1)) for at, group_label in enumerate(labels)]
    ticks = None
    if not groups.values:
        ticks = [(float(at + 1), shorten(group_label, 12)) for at, group_label in enumerate(labels)]
    panels = []
    for name in groups.names()[:_MOST_PANELS]:
        of_name = [groups.fits[group_label].parameters.get(name) for group_label in labels]
        known = [
            (place, number)
            for place, number in zip(x, of_name, strict=True)
            if number is not None and number.verdict in HAS_VALUE
        ]
        if not known:
            continue
        unit, letter = prefix(max(abs(number.value) for _, number in known))
        si = groups.unit(name)
        if not si or si == "-":
            unit, letter = 1.0, ""
        across = Axis(groups.column.replace("_", " ").capitalize(), margin=0.1, ticks=ticks)
        panel = Panel(across, Axis(f"{label(name)} [{letter}{si or '–'}]", unit=unit))
        for place, number in known:
            ends = np.array([number.low, number.high])
            if np.isfinite(ends).all():
                panel.line([place, place], ends / unit, GREY, width=1.0)
            is_sure = number.verdict == "identified"
            panel.marks([place], [number.value / unit], COLORS[1], filled=is_sure)
        panels.append(panel)
    return stacked(panels, 0.9 + 1.7 * len(panels))


def data_of(groups: Groups, confidence: float) -> dict[str, Any]:
    """The same as plain values."""
    return {
        "column": groups.column,
        "fits": {group_label: fit.summary() for group_label, fit in groups.fits.items()},
        "failed": dict(groups.failed),
        "pooled": {
            pool.quantity: {**pool.mean._asdict(), "between": pool.between, "verdict": verdict}
            for pool, verdict in groups.pooled(confidence)
        },
    }
