"""Every parameter of a scan against the short-wave cut-off, in small panels."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip._core.units import prefix
from microslip.report.plot import COLORS, DASHED, Axis, Entry, Marker, Panel, Plot, Rule
from microslip.report.scales import length_prefix
from microslip.report.ticks import logarithmic
from microslip.results.scanned.findings import Findings
from microslip.scans.cutoffs import CutoffTable

_CHOSEN = "#444444"
_SHORT_DASH = (1.0, 1.0)


class _Look(NamedTuple):
    color: str
    marker: Marker
    dash: tuple[float, ...] = ()


_LOOKS = {
    "mccool": _Look(COLORS[1], "o"),
    "counted": _Look(COLORS[2], "s", DASHED),
    "": _Look(COLORS[0], "o"),
}


class _Shown(NamedTuple):
    """What a panel shows: columns of the table by their look, and the unit."""

    what: str
    columns: dict[str, str]
    unit: str


_SHOWN = (
    _Shown("Summit density", {k: f"{k}_density" for k in ("mccool", "counted")}, "1/mm²"),
    _Shown("Summit radius", {k: f"{k}_radius" for k in ("mccool", "counted")}, "m"),
    _Shown("Std of summit heights", {k: f"{k}_std" for k in ("mccool", "counted")}, "m"),
    _Shown("Rms height Sq", {"": "rms"}, "m"),
    _Shown("Rms slope", {"": "m2"}, "–"),
    _Shown("Nayak's α", {"": "nayak"}, "–"),
)


def cutoff_plot(findings: Findings) -> Plot:
    """Density, radius, spread and the moments against the cut-off; none is at the left."""
    table, scan = findings.table, findings.scan
    unit, letter = length_prefix(max(scan.size) / 8.0, min(scan.pixel))
    # No cut-off has its place at the left, where a pixel is.
    place_of_none = min(scan.pixel) / unit
    cutoffs = table.cutoff / unit
    x = np.where(table.cutoff > 0.0, cutoffs, place_of_none)
    high = max(1.3 * float(cutoffs[-1]), 4.0 * place_of_none)
    first = float(cutoffs[1]) if cutoffs.size > 1 else math.inf
    ticks = logarithmic(min(0.8 * first, high), high, 4)
    places = [(at, text) for at, text in (*ticks.major, *ticks.minor) if text and at >= 0.8 * first]
    place = place_of_none if findings.request.cutoff is None else findings.request.cutoff / unit
    panels = []
    for number, content in enumerate(_SHOWN):
        row, column = divmod(number, 3)
        lines = {look: _column(table, name) for look, name in content.columns.items()}
        scale, label = _scale(list(lines.values()), content.unit)
        panel = Panel(
            Axis(
                f"Cut-off [{letter}m]",
                0.75 * place_of_none,
                high,
                log=True,
                ticks=[(place_of_none, "none"), *places],
                bare=row == 0,
            ),
            Axis(log=True),
            note=f"{content.what} [{label}]",
            cell=(row, row, column, column),
        )
        panel.add(Rule(place, "x", _CHOSEN, 0.9, _SHORT_DASH))
        for name, values in lines.items():
            look = _LOOKS[name]
            y = np.where(values > 0.0, values / scale, np.nan)
            # The step from none to the first cut-off is not to scale: no line there.
            panel.line(x[1:], y[1:], look.color, dash=look.dash)
            panel.marks(x, y, look.color, marker=look.marker)
        panels.append(panel)
    legend = [Entry("McCool's moments", COLORS[1], (), "o")]
    if not scan.is_profile:
        legend.append(Entry("counted", COLORS[2], DASHED, "s"))
    legend.append(Entry(findings.cutoff_text(), _CHOSEN, _SHORT_DASH))
    return Plot(
        panels,
        5.4,
        findings.title("Cut-off dependence"),
        heights=(1.0, 1.0),
        widths=(1.0, 1.0, 1.0),
        legend=tuple(legend),
    )


def _column(table: CutoffTable, name: str) -> Floats:
    values: Floats = getattr(table, name)
    return np.sqrt(values) if name == "m2" else values


def _scale(lines: list[Floats], unit: str) -> tuple[float, str]:
    """What values are divided by, and the unit that is left."""
    if unit != "m":
        return (1e6 if unit == "1/mm²" else 1.0), unit
    values = np.concatenate(lines)
    values = values[np.isfinite(values) & (values > 0.0)]
    if not values.size:
        return 1.0, unit
    factor, letter = prefix(math.sqrt(float(values.min()) * float(values.max())))
    return factor, f"{letter}m"
