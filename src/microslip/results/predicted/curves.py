"""What the figures of a prediction share: the loads drawn, their looks, the amplitude axis."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from microslip._core.units import engineering
from microslip.report.plot import (
    COLORS,
    DASHES,
    MARKERS,
    WIDTH,
    Area,
    Axis,
    Entry,
    Floats,
    Marker,
    Panel,
    Plot,
)
from microslip.report.scales import common_prefix, evenly, length_prefix
from microslip.results.predicted.columns import AmplitudeCurve
from microslip.results.predicted.prediction import Prediction
from microslip.results.predicted.varying import VaryingCycles

MOST_LOADS = 6
MOST_MARKS = 12

Quantity = Callable[[AmplitudeCurve], Floats]


class Look(NamedTuple):
    """How the curves of a load look; either dashes or markers tell them apart in grey."""

    color: str
    marker: Marker
    dash: tuple[float, ...]


def drawn_loads(result: Prediction) -> list[tuple[int, Look]]:
    """Loads that are drawn: their index and look."""
    looks = map(Look, COLORS, MARKERS, DASHES)
    return list(zip(evenly(len(result.joints), MOST_LOADS), looks, strict=False))


def add_legend(plot: Plot, result: Prediction, *, dashed: bool = False, title: str = "") -> Plot:
    """Name the loads below the panels, and the study above them.

    Without a title these are normal loads or, in a study with others that vary, constant ones.
    """
    if not title:
        title = "Constant normal load" if result.study.excitation.load_varies else "Normal load"
    loads = drawn_loads(result)
    left_out = len(result.joints) - len(loads)
    plot.legend_title = title + (f" ({left_out} more in the tables)" if left_out else "")
    plot.legend = tuple(
        Entry(
            _label(result.joints[index]),
            look.color,
            look.dash if dashed else (),
            None if dashed else look.marker,
        )
        for index, look in loads
    )
    plot.title = result.study.title
    return plot


class AmplitudeAxis(NamedTuple):
    """The amplitude that curves are drawn against."""

    column: str
    """Name of the column in :class:`~microslip.results.predicted.result.AmplitudeCurve`."""
    unit: float
    """What its values are divided by [SI unit]."""
    label: str
    low: float
    """Its left end, divided by the unit."""
    high: float

    def of(self, curve: AmplitudeCurve | VaryingCycles) -> Floats:
        """Values of a curve on this axis."""
        values: Floats = getattr(curve, self.column)
        return values / self.unit

    def panel(self, y: Axis, note: str = "", label: str = "") -> Panel:
        """A panel over this axis."""
        return Panel(Axis(label or self.label, self.low, self.high, log=True), y, note)


def displacement_axis(result: Prediction) -> AmplitudeAxis:
    """The displacement amplitude, over the range of the curves."""
    curves = [result.curves[index] for index, _ in drawn_loads(result)]
    low = min(float(curve.amplitude[0]) for curve in curves)
    high = max(float(curve.amplitude[-1]) for curve in curves)
    unit, letter = length_prefix(high, low)
    low, high = (
        (low / unit, high / unit) if high > 1.01 * low else (low / 1.2 / unit, high * 1.2 / unit)
    )
    return AmplitudeAxis("amplitude", unit, f"Displacement amplitude [{letter}m]", low, high)


def force_axis(result: Prediction) -> AmplitudeAxis:
    """The force amplitude, over the range of the curves and past the largest force limit.

    Loops under a load that varies reach further than the limit at its mean.
    """
    loads = [index for index, _ in drawn_loads(result)]
    largest = max(result.joints[i].force_limit for i in loads)
    forces = np.concatenate([result.curves[i].force_amplitude for i in loads])
    smallest = float(forces[forces > 0.0].min()) if (forces > 0.0).any() else 0.1 * largest
    unit, letter = common_prefix([result.joints[i].force_limit for i in loads])
    if 1.6 * largest < 10.0 * smallest:  # so that nothing lies on the edge
        smallest /= 1.6
    varying = [float(result.varying[i].force_amplitude.max()) for i in loads if result.varying]
    high = max([1.6 * largest, *(1.2 * force for force in varying)])
    return AmplitudeAxis(
        "force_amplitude", unit, f"Force amplitude [{letter}N]", smallest / unit, high / unit
    )


def finite(values: Floats) -> Floats:
    """The values that can be drawn; one NaN if there is none."""
    values_drawn = values[np.isfinite(values)]
    return values_drawn if values_drawn.size else np.array([np.nan])


def draw_curves(
    panel: Panel, result: Prediction, axis: AmplitudeAxis, quantity: Quantity
) -> Floats:
    """Draw a quantity of every load: a line, and markers where there are loops.

    Gives the ordinates of all lines that can be drawn, above zero on a log axis.
    """
    loads = drawn_loads(result)
    lines = [
        np.stack([axis.of(result.curves[i]), _drawable(quantity(result.curves[i]), panel.y.log)])
        for i, _ in loads
    ]
    bands = [_band(panel, result, axis, quantity, number) for number in range(len(loads))]
    for number, (index, look) in enumerate(loads):
        curve, row = result.curves[index], result.rows[index]
        x, y = lines[number]
        # A line that others will hide is so wide that it shows on both sides of them.
        above = sum(_coincide(lines[number], other) for other in lines[number + 1 :])
        panel.line(x, y, look.color, width=WIDTH + 1.3 * above)
        inside = (row.amplitude >= curve.amplitude[0]) & (row.amplitude <= curve.amplitude[-1])
        marked = np.flatnonzero(inside)
        if marked.size:
            marked = marked[evenly(marked.size, MOST_MARKS)]
            x, y = axis.of(row)[marked], _drawable(quantity(row), panel.y.log)[marked]
        else:  # markers also tell the loads apart in grey
            places = evenly(x.size, 7)
            x, y = x[places], y[places]
        panel.marks(x, y, look.color, marker=look.marker)
    return finite(np.concatenate([*(line[1] for line in lines), *bands]))


def _band(
    panel: Panel, result: Prediction, axis: AmplitudeAxis, quantity: Quantity, number: int
) -> Floats:
    """Shade between the outer quantiles of a load, below all lines; its ordinates."""
    scatter = result.scatter
    index, look = drawn_loads(result)[number]
    if scatter is None:
        return np.zeros(0)
    curve = result.curves[index]
    edges = [
        _drawable(quantity(scatter.curve(end, index, curve.amplitude)), panel.y.log)
        for end in (0, scatter.quantiles.size - 1)
    ]
    x = axis.of(curve)
    finite_points = np.isfinite(edges[0]) & np.isfinite(edges[1]) & np.isfinite(x)
    low, high = (edge[finite_points] for edge in edges)
    outline = np.concatenate([x[finite_points], x[finite_points][::-1]])
    panel.items.insert(0, Area(outline, np.concatenate([low, high[::-1]]), pale(look.color)))
    return np.concatenate([low, high])


def pale(color: str) -> str:
    """A colour thinned with white, as areas behind lines have it."""
    parts = (int(color[i : i + 2], 16) for i in (1, 3, 5))
    return "#" + "".join(f"{round(255 - 0.3 * (255 - part)):02x}" for part in parts)


def _drawable(values: Floats, log: bool) -> Floats:
    fine = np.isfinite(values) & (values > 0.0) if log else np.isfinite(values)
    return np.where(fine, values, np.nan)


def _coincide(line: Floats, cover: Floats) -> bool:
    """Whether one of two lines would hide the other."""
    if line.shape != cover.shape:
        return False
    overlap = np.isfinite(line[1]) & np.isfinite(cover[1])
    near = np.allclose(line[:, overlap], cover[:, overlap], rtol=5e-3, atol=0.0)
    return bool(overlap.any() and near)


def _label(joint: Any) -> str:
    """Its normal load; the name of a law that knows none."""
    if not hasattr(joint, "normal_load"):
        return type(joint).__name__
    return engineering(joint.normal_load, "N", trim=True)
