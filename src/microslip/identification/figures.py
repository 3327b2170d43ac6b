"""Figures of an identification: loops over each other, intervals, profiles of the likelihood."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import takewhile
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core.checks import Floats
from microslip._core.units import engineering, prefix
from microslip.figures.kit import evenly, length_prefix
from microslip.figures.picture import Picture
from microslip.figures.plot import COLORS, Axis, Band, Entry, Panel, Pixels, Plot, Rule, Words
from microslip.identification.caveats import label, short_symbol
from microslip.identification.fit_quality import RecordFit
from microslip.identification.verdicts import Fitted

MOST_PANELS = 6
MOST_PARAMETERS = 12
MOST_MARKS = 90  # of a loop
MOST_DOTS = 1500  # of a panel
_SAME_SIZE = 0.02  # of amplitudes of one colour, from one to the next
INK, BLUE, RED = COLORS[0], COLORS[1], COLORS[2]

_CAPTIONS = {
    "loops": (
        "The mean cycle of each record (circles) and the identified law with the rig in series "
        "(line), one pair of panels for each normal load, a colour for each amplitude; the line "
        "includes the fitted errors of displacement and load and other nuisances. Below, the "
        "residual over the noise of each record, towards larger (circles) and smaller "
        "displacements (triangles). Within the grey band it is noise.",
        "Measured and modelled loops, and the residual",
    ),
    "intervals": (
        "Best values and intervals; an arrow is an open end. Beside them the correlations of the "
        "errors.",
        "Interval of each parameter, and correlations",
    ),
    "profiles": (
        "Rise of χ² where a parameter is held at another value and all others are fitted again, "
        "over the factor by which intervals were widened. Values below the dashed level fit the "
        "loops; where the curve stays below it, the interval is open.",
        "Likelihood profile of each parameter",
    ),
}


def pictures(result: Any) -> tuple[Picture, ...]:
    """The figures of an identification."""
    plots = {"loops": lambda: loops(result)}
    if 1 <= len(result.names) <= MOST_PARAMETERS:
        plots["intervals"] = lambda: intervals(result)
        if profiled_names(result):
            plots["profiles"] = lambda: profiles(result)
    return tuple(
        Picture(name, _CAPTIONS[name][0], plot, _CAPTIONS[name][1]) for name, plot in plots.items()
    )


# -- loops ----------------------------------------------------------------------------------------


def cycles_by_load(result: Any) -> list[tuple[str, list[RecordFit]]]:
    """Cycles by their load, lightest first: what a panel is called, and its cycles."""
    by_load: dict[str, list[RecordFit]] = {}
    for r in sorted(result.records, key=lambda r: r.normal_load or math.inf):
        name = "Load unknown" if r.normal_load is None else f"N = {engineering(r.normal_load, 'N')}"
        by_load.setdefault(name, []).append(r)
    return list(by_load.items())


def loops(result: Any) -> Plot:
    """Measured and modelled loops over each other, and what is left below (as in Fig. 19.22)."""
    groups = cycles_by_load(result)
    cycles = [cycle for _, group in groups for cycle in group]
    panel_groups = [groups[i] for i in evenly(len(groups), MOST_PANELS)]
    columns = min(len(panel_groups), 3)
    rows = math.ceil(len(panel_groups) / columns)
    x_unit, x_letter = length_prefix(
        max(float(np.abs(c.displacement - c.displacement.mean()).max()) for c in cycles)
    )
    f_unit, f_letter = prefix(max(float(np.abs(c.measured).max()) for c in cycles))
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
            Axis(bare=True, unit=x_unit),
            Axis(
                f"Force [{f_letter}N]" if column == 0 else "",
                high=_upper_end(group, f_unit),
                unit=f_unit,
            ),
            note=name if named else "",
            cell=(row, row, column, column),
        )
        below = Panel(
            Axis(f"Displacement [{x_letter}m]", unit=x_unit),
            Axis("Over noise [–]" if column == 0 else "", ticks=ticks),
            cell=(row + 1, row + 1, column, column),
        )
        _draw_pair(above, below, group, x_unit, f_unit)
        panels += [above, below]
    rig = ", rig in series" if any(n.startswith("rig_stiffness") for n in result.parameters) else ""
    left_out = len(groups) - len(panel_groups)
    return Plot(
        panels,
        0.7 + (4.6 if columns == 1 else 3.3) * rows,
        heights=(2.2, 1.0) * rows,
        widths=(1.0,) * columns,
        legend=(
            Entry("measured; residual, displacement rising", BLUE, marker="o", line=False),
            Entry(f"identified: {result.law}{rig}", INK),
            Entry("residual, displacement falling", BLUE, marker="^", line=False),
            Entry("grey: noise, ±2 σ", "#cccccc"),
        ),
        legend_title=f"{left_out} more loads are in the tables" if left_out else "",
    )


def _upper_end(group: Sequence[RecordFit], unit: float) -> float:
    """Upper end of the forces of a panel, with room for the names of its amplitudes."""
    low, high = (
        float(end(np.concatenate([cycle.measured for cycle in group]))) for end in (np.min, np.max)
    )
    sizes = np.sort([float(np.ptp(cycle.displacement)) for cycle in group])
    count = int(_levels(sizes)[-1]) + 1
    lines = math.ceil(count / 3) if 1 < count < len(COLORS) else 0
    return (high + (0.06 + 0.11 * lines) * (high - low)) / unit


def _draw_pair(
    above: Panel, below: Panel, group: Sequence[RecordFit], x_unit: float, f_unit: float
) -> None:
    """The loops of one load, and what is left of them; a colour for each amplitude."""
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
        marks = _spaced_marks(x, force, MOST_MARKS)
        above.marks(x[marks], force[marks] / f_unit, hue, size=3.0)
        closed = np.append(np.arange(x.size), 0)
        above.line(x[closed], cycle.model[closed] / f_unit, INK, width=1.1)
        dots = np.array(evenly(x.size, dot_count))
        residual = cycle.residual[dots] / _noise(cycle)
        falling = np.gradient(cycle.displacement)[dots] < 0.0
        below.marks(x[dots][~falling], residual[~falling], hue, size=2.4)
        below.marks(x[dots][falling], residual[falling], hue, marker="^", size=2.4)
    above.cross()
    below.add(Rule(0.0, "y", "#888888", 0.6, ()))


def _noise(cycle: RecordFit) -> float:
    """Standard error of a measured force [N]."""
    return float(np.median(cycle.error)) or 1.0


def _levels(sizes: Floats) -> NDArray[np.int64]:
    """Numbers of amplitudes in their order, those within some per cent being one."""
    return np.cumsum(np.diff(np.log(sizes), prepend=math.log(sizes[0])) > _SAME_SIZE)


def _amplitude_names(amplitudes: Sequence[float]) -> list[str]:
    """Amplitudes with as few digits as tell them apart."""
    texts = [[engineering(size, "m", digits) for size in amplitudes] for digits in (2, 3, 4)]
    return next((names for names in texts if len(set(names)) == len(names)), texts[-1])


def _spaced_marks(x: Floats, y: Floats, count: int) -> NDArray[np.int64]:
    """Places that are evenly spaced along a curve, whatever the times between its samples."""
    steps = np.hypot(np.diff(x) / max(float(np.ptp(x)), 1e-300), np.diff(y) / float(np.ptp(y)))
    length = np.concatenate(([0.0], np.cumsum(steps)))
    return np.unique(np.searchsorted(length, np.linspace(0.0, length[-1], count)))


# -- intervals ------------------------------------------------------------------------------------


def intervals(result: Any) -> Plot:
    """The interval of each free parameter on a scale of its own, and the correlations."""
    names = result.names
    panels = [_strip(name, result.parameters[name], row) for row, name in enumerate(names)]
    several = len(names) > 1
    if several:
        symbols = [short_symbol(name, result.parameters[name].load) for name in names]
        panels.append(_heat_map(symbols, result.correlation, len(names)))
    return Plot(
        panels,
        1.3 + 0.62 * len(names),
        f"Best values and {100.0 * result.confidence:g} % intervals (arrow: no end)"
        + (", correlations of the errors" if several else ""),
        heights=(1.0,) * len(names),
        widths=(1.25, 1.0) if several else (1.0,),
    )


def _strip(name: str, fitted: Fitted, row: int) -> Panel:
    """One interval on its own axis, which reaches a little beyond it."""
    open_low, open_high = fitted.low_open, fitted.high_open
    scale_value = (
        fitted.high if open_low and not open_high else fitted.low if open_high else fitted.value
    )
    unit, in_unit = _scale(fitted, scale_value)
    value, low, high = (v / unit for v in (fitted.value, fitted.low, fitted.high))
    start, right = _line_ends(value, low, high, open_low, open_high)
    if 0.0 < start < 0.1 * right:
        reach = (right / start) ** 0.25
        axis = Axis("", start / reach, right * reach, log=True)
    else:
        width = (right - start) or max(abs(value), 1.0)
        axis = Axis("", start - 0.25 * width, right + 0.25 * width)
    verdict = "" if fitted.verdict == "identified" else f": {fitted.verdict}"
    panel = Panel(
        axis,
        Axis("", -1.0, 1.0, ticks=()),
        note=f"{label(name, fitted.load)}{in_unit}{verdict}",
        grid=False,
        cell=(row, row, 0, 0),
    )
    color = BLUE if fitted.verdict == "identified" else RED
    panel.line([start, right], [0.0, 0.0], color, width=2.0)
    for end, is_open, sign in ((start, open_low, "◂"), (right, open_high, "▸")):
        if is_open:
            panel.add(Words(end, 0.0, sign, "center", "middle", color, 12.0, data=True))
        else:
            panel.line([end, end], [-0.4, 0.4], color, width=1.5)
    if start <= value <= right and not (open_low and open_high):
        panel.marks([value], [0.0], color, filled=True, size=5.0)
    return panel


def _scale(fitted: Fitted, value: float) -> tuple[float, str]:
    """A unit that suits a value, and what an axis calls it."""
    if fitted.unit in ("", "-"):
        return 1.0, ""
    unit, letter = prefix(value)
    return unit, f" [{letter}{fitted.unit}]"


def _line_ends(
    value: float, low: float, high: float, open_low: bool, open_high: bool
) -> tuple[float, float]:
    """Ends of the line of an interval; an open end is drawn a little further."""
    if open_low and open_high:
        return (0.5 * value, 2.0 * value) if value > 0.0 else (value - 1.5, value + 1.5)
    if open_low:
        return (0.5 * high if high > 0.0 else high - 1.5), high
    if open_high:
        return low, (2.0 * low if low > 0.0 else low + 1.5)
    return low, high


def _heat_map(symbols: Sequence[str], matrix: Floats, rows: int) -> Panel:
    """Correlations as colours and numbers; the lower half, since both are the same."""
    count = len(symbols) - 1
    panel = Panel(
        Axis("", 0.0, count, ticks=[(i + 0.5, text) for i, text in enumerate(symbols[:-1])]),
        Axis("", 0.0, count, ticks=[(count - i - 0.5, text) for i, text in enumerate(symbols[1:])]),
        grid=False,
        cell=(0, rows - 1, 1, 1),
    )
    shades, texts = np.full((count, count, 3), 255, dtype=np.uint8), []
    for i, j in np.argwhere(np.tri(count)).tolist():
        value = float(matrix[i + 1, j])
        shades[i, j] = _shade(value)
        if math.isfinite(value):
            place, number = (j + 0.5, count - i - 0.5), f"{value:+.2f}".replace("-", "−")
            texts.append(Words(*place, number, "center", "middle", INK, 8.0, data=True))
    panel.add(Pixels(shades, 0.0, float(count), 0.0, float(count)))
    for text in texts:
        panel.add(text)
    return panel


def _shade(value: float) -> ArrayLike:
    """Orange for −1, white for 0, violet for 1; also for the colour-blind."""
    if not math.isfinite(value):
        return (255, 255, 255)
    end = np.array((45, 0, 75) if value > 0.0 else (127, 59, 8), dtype=float)
    return np.round(255.0 + (end - 255.0) * min(abs(value), 1.0)).astype(np.uint8)


# -- profiles -------------------------------------------------------------------------------------


def profiled_names(result: Any) -> list[str]:
    """Names of the parameters whose profile has more than the best value and an end."""
    return [name for name in result.names if len(result.parameters[name].profile) > 2]


def profiles(result: Any) -> Plot:
    """The likelihood profile of each free parameter: the rise of chi-squared over its value."""
    from scipy.special import chdtri

    level = float(chdtri(1, 1.0 - result.confidence))
    names = profiled_names(result)
    columns = min(len(names), 2 if len(names) == 4 else 3)
    rows = math.ceil(len(names) / columns)
    panels = []
    for index, name in enumerate(names):
        row, column = divmod(index, columns)
        panels.append(_curve(name, result.parameters[name], level, row, column))
    return Plot(
        panels,
        0.6 + 1.75 * rows,
        heights=(1.0,) * rows,
        widths=(1.0,) * columns,
        legend=(
            Entry("profile, and where it was computed", BLUE, marker="o", filled=True),
            Entry(f"level of {100.0 * result.confidence:g} %: {level:.2f}", RED, (4.0, 2.0)),
        ),
    )


def _curve(name: str, fitted: Fitted, level: float, row: int, column: int) -> Panel:
    """One profile, as far as a little above its level."""
    x, rise = np.array(fitted.profile).T
    unit, in_unit = _scale(fitted, fitted.value)
    # The root of the rise is nearly straight on either side: between points it is taken so.
    root = np.copysign(np.sqrt(rise), x - fitted.value)
    near = rise <= 2.0 * level
    if fitted.value > 0.0 and fitted.low >= 0.0:  # an open end may be decades away
        ends = [end for end in (fitted.low, fitted.value, fitted.high) if 0.0 < end < math.inf]
        near &= (x >= min(ends) / 4.0) & (x <= 4.0 * max(ends))
    first, last = float(x[near].min()), float(x[near].max())
    if last - first < 1e-6 * abs(last):  # the best value lies at a bound and nothing beside it
        first, last = 0.5 * fitted.value, 2.0 * fitted.value
    logarithmic = 0.0 < first < 0.05 * last
    if logarithmic:
        within = np.geomspace(first, last, 200)
        between = np.interp(np.log(within), np.log(x[x > 0.0]), root[x > 0.0])
    else:
        within = np.linspace(first, last, 200)
        between = np.interp(within, x, root)
    panel = Panel(
        Axis(f"{short_symbol(name, fitted.load)}{in_unit}", log=logarithmic),
        Axis("Rise of χ²" if column == 0 else "", 0.0, 1.8 * level, bare=column > 0),
        note="" if fitted.verdict == "identified" else fitted.verdict,
        cell=(row, row, column, column),
    )
    if fitted.low_open:
        panel.add(Words(0.03, 0.97, "◂ open", color=RED))
    if fitted.high_open:
        panel.add(Words(0.97, 0.97, "open ▸", "right", color=RED))
    panel.marks(x[near] / unit, rise[near], BLUE, filled=True, size=3.0)
    panel.line(within / unit, between**2, BLUE, width=1.0)
    panel.add(Rule(level, "y", RED, 0.9))
    return panel
