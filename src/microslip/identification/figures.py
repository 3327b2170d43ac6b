"""Figures of an identification: measured and fitted loops; force, energy, damping by amplitude."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import takewhile
from typing import Any

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip._core.quantities import QUANTITIES, dimensionless
from microslip._core.units import engineering
from microslip.figures.kit import axis_of, between, drawable, evenly, pale
from microslip.figures.picture import Picture
from microslip.figures.plot import (
    COLORS,
    Band,
    Entry,
    Guide,
    Panel,
    Plot,
    Words,
    stacked,
)
from microslip.identification.curves import CONFIDENCE, SHOWN, curves_of
from microslip.identification.record_fit import RecordFit

_MOST_PANELS = 6
_MOST_MARKS = 90  # of a loop
MOST_DOTS = 1500  # of a panel
_SAME_SIZE = 0.02  # of amplitudes of one colour, from one to the next
INK, BLUE = COLORS[0], COLORS[1]

_CAPTIONS = {
    "loops": (
        "The mean cycle of each record (circles) and the fitted law (line), one pair of panels for "
        "each normal load, a colour for each amplitude. Below, the residual over the noise of each "
        "record, towards larger (circles) and smaller displacements (triangles). Within the grey "
        "band it is noise.",
        "Measured and fitted loops, and the residual",
    ),
    "law": (
        "Force of first loading, energy of a cycle and damping ratio against amplitude, a colour "
        "for each normal load, with their {level} intervals (shaded). Circles: amplitudes of the "
        "records. Left of the grey line the amplitudes are smaller than the smallest measured one; "
        "beyond the largest the loops determine nothing, and no curve is drawn.",
        "Force, energy and damping ratio against amplitude, with intervals",
    ),
}


def pictures(result: Any) -> tuple[Picture, ...]:
    """Return the figures of an identification."""
    plots = {"loops": lambda: fitted_loops(result), "law": lambda: law(result)}
    level = f"{100.0 * CONFIDENCE:g} %"
    return tuple(
        Picture(name, _CAPTIONS[name][0].format(level=level), plot, _CAPTIONS[name][1])
        for name, plot in plots.items()
    )


# -- the law by amplitude -------------------------------------------------------------------------


def law(result: Any) -> Plot:
    """Plot force, energy and damping ratio against amplitude, with intervals."""
    tables = curves_of(result)
    drawn = [tables[i] for i in evenly(len(tables), _MOST_PANELS)]
    largest = max(float(table.amplitude[-1]) for table in drawn)
    panels = []
    for name in SHOWN:
        across = axis_of(QUANTITIES["amplitude"], largest, log=True)
        ends = {"log": True} if name == "dissipated_energy" else {"low": 0.0}
        panels.append(Panel(across, axis_of(QUANTITIES[name], **ends)))
    unit = panels[0].x.unit
    for table, color in zip(drawn, COLORS[1:], strict=False):
        x = table.amplitude / unit
        for panel, name in zip(panels, SHOWN, strict=True):
            value, low, high = (
                drawable(np.asarray(values), panel.y.log) for values in table.estimates[name]
            )
            panel.items.insert(0, between(x, low, high, pale(color)))
            panel.line(x, value, color)
            at = np.isin(table.amplitude, table.measured)
            panel.marks(x[at], value[at], color)
    smallest = min(float(table.measured[0]) for table in drawn) / unit
    for panel in panels:
        panel.items.insert(0, Guide(smallest, "x", "#888888", 0.8, ()))
    legend = tuple(
        Entry("law" if table.load is None else engineering(table.load, "N", trim=True), color)
        for table, color in zip(drawn, COLORS[1:], strict=False)
    )
    left_out = len(tables) - len(drawn)
    title = f"Normal load{f' ({left_out} more in the tables)' if left_out else ''}"
    plot = stacked(panels, 8.2, (1.2, 1.2, 1.0), legend, f"Law of the {result.series}")
    plot.legend_title = title if len(tables) > 1 else ""
    return plot


# -- loops ----------------------------------------------------------------------------------------


def cycles_by_load(result: Any) -> list[tuple[str, list[RecordFit]]]:
    """Return the title of the panel and the fitted records of each load, in order of the loads."""
    by_load: dict[str, list[RecordFit]] = {}
    for r in sorted(result.records, key=lambda r: r.normal_load or math.inf):
        name = "Load unknown" if r.normal_load is None else f"N = {engineering(r.normal_load, 'N')}"
        by_load.setdefault(name, []).append(r)
    return list(by_load.items())


def fitted_loops(result: Any) -> Plot:
    """Plot loops and fits, residuals below (Fig. 19.22, DOI 10.1007/978-3-319-56818-8_19)."""
    groups = cycles_by_load(result)
    cycles = [cycle for _, group in groups for cycle in group]
    panel_groups = [groups[i] for i in evenly(len(groups), _MOST_PANELS)]
    columns = min(len(panel_groups), 3)
    rows = math.ceil(len(panel_groups) / columns)
    centred = [c.displacement - c.displacement.mean() for c in cycles]
    longest = max(float(np.abs(displacement).max()) for displacement in centred)
    strongest = max(float(np.abs(c.measured).max()) for c in cycles)
    largest_residual = max(float(np.abs(c.residual).max()) / _noise(c) for c in cycles)
    # Of what is left only the size counts: two marks about zero, of a round number.
    rounded = (m * 10.0**e for e in range(12) for m in (1.0, 2.0, 5.0))
    round_step = max(takewhile(lambda size: size <= max(0.7 * largest_residual, 2.0), rounded))
    ticks = [(-round_step, f"−{round_step:g}"), (0.0, "0"), (round_step, f"{round_step:g}")]
    panels = []
    for index, (name, group) in enumerate(panel_groups):
        row, column = 2 * (index // columns), index % columns
        named = len(panel_groups) > 1 or group[0].normal_load is not None
        above = Panel(
            axis_of(QUANTITIES["displacement"], longest, bare=True),
            axis_of(QUANTITIES["force"], strongest),
            note=name if named else "",
            cell=(row, row, column, column),
        )
        above.y.high = _upper_end(group, above.y.unit)
        below = Panel(
            axis_of(QUANTITIES["displacement"], longest),
            axis_of(dimensionless("Residual\nover noise"), ticks=ticks),
            cell=(row + 1, row + 1, column, column),
        )
        if column > 0:
            above.y.label = below.y.label = ""
        _draw_pair(above, below, group)
        panels += [above, below]
    left_out = len(groups) - len(panel_groups)
    return Plot(
        panels,
        0.7 + (4.6 if columns == 1 else 3.3) * rows,
        heights=(2.2, 1.0) * rows,
        widths=(1.0,) * columns,
        legend=(
            Entry("measured; residual, displacement rising", BLUE, marker="o", line=False),
            Entry("fitted law", INK),
            Entry("residual, displacement falling", BLUE, marker="^", line=False),
            Entry("grey: noise, ±2 σ", "#cccccc"),
        ),
        legend_title=f"{left_out} more loads are in the tables" if left_out else "",
    )


def _upper_end(group: Sequence[RecordFit], unit: float) -> float:
    low, high = (
        float(end(np.concatenate([cycle.measured for cycle in group]))) for end in (np.min, np.max)
    )
    sizes = np.sort([float(np.ptp(cycle.displacement)) for cycle in group])
    count = int(_levels(sizes)[-1]) + 1
    lines = math.ceil(count / 3) if 1 < count < len(COLORS) else 0
    return (high + (0.06 + 0.11 * lines) * (high - low)) / unit


def _draw_pair(above: Panel, below: Panel, group: Sequence[RecordFit]) -> None:
    x_unit, f_unit = above.x.unit, above.y.unit
    below.add(Band(-2.0, 2.0, "y"))
    dot_count = max(MOST_DOTS // len(group), 40)
    hues = COLORS[1:]
    ordered = sorted(group, key=lambda c: float(np.ptp(c.displacement)))
    sizes = np.array([0.5 * float(np.ptp(cycle.displacement)) for cycle in ordered])
    numbers = _levels(sizes)
    firsts = np.unique(numbers, return_index=True)[1]
    if 1 < firsts.size <= len(hues):
        for number, name in enumerate(_amplitude_names(sizes[firsts].tolist())):
            place = (number % 3) / 3.0 + 0.02, 0.985 - 0.085 * (number // 3)
            above.add(Words(*place, name, color=hues[number]))
    # Small loops are drawn over large ones, which would hide them.
    for cycle, number in reversed(list(zip(ordered, numbers.tolist(), strict=True))):
        hue = hues[number % len(hues)]
        x, force = cycle.displacement, cycle.measured
        x = (x - 0.5 * (x.max() + x.min())) / x_unit
        marks = _spaced_marks(x, force, _MOST_MARKS)
        above.marks(x[marks], force[marks] / f_unit, hue, size=3.0)
        closed = np.append(np.arange(x.size), 0)
        above.line(x[closed], cycle.model[closed] / f_unit, INK, width=1.1)
        dots = np.array(evenly(x.size, dot_count))
        residual = cycle.residual[dots] / _noise(cycle)
        falling = np.gradient(cycle.displacement)[dots] < 0.0
        below.marks(x[dots][~falling], residual[~falling], hue, size=2.4)
        below.marks(x[dots][falling], residual[falling], hue, marker="^", size=2.4)
    above.cross()
    below.add(Guide(0.0, "y", "#888888", 0.6, ()))


def _noise(cycle: RecordFit) -> float:
    """Standard error of a measured force [N]."""
    return float(np.median(cycle.error)) or 1.0


def _levels(sizes: Floats) -> NDArray[np.int64]:
    return np.cumsum(np.diff(np.log(sizes), prepend=math.log(sizes[0])) > _SAME_SIZE)


def _amplitude_names(amplitudes: Sequence[float]) -> list[str]:
    texts = [[engineering(size, "m", digits) for size in amplitudes] for digits in (2, 3, 4)]
    return next((names for names in texts if len(set(names)) == len(names)), texts[-1])


def _spaced_marks(x: Floats, y: Floats, count: int) -> NDArray[np.int64]:
    """Return indices of points evenly spaced along a curve, whatever their spacing in time."""
    steps = np.hypot(np.diff(x) / max(float(np.ptp(x)), 1e-300), np.diff(y) / float(np.ptp(y)))
    length = np.concatenate(([0.0], np.cumsum(steps)))
    return np.unique(np.searchsorted(length, np.linspace(0.0, length[-1], count)))
