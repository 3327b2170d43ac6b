"""Figures of a bolted structure: curves with bands, maps of patches, shapes of modes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip._core.quantities import QUANTITIES, Quantity, dimensionless
from microslip.figures.kit import (
    axis_of,
    between,
    line_style,
    pale,
    scale_of_colours,
    with_scale,
)
from microslip.figures.plot import (
    COLORS,
    DOTTED,
    Area,
    Axis,
    Entry,
    Panel,
    Plot,
    Words,
    stacked,
)
from microslip.structures import ModalCurve, ModalTest
from microslip.structures.periodic_motion import POWERS
from microslip.study.runs.structure_prediction import Mode, StructurePrediction

_LIGHT, _DARK = np.array([240.0, 244.0, 248.0]), np.array([0.0, 76.0, 130.0])
BAND, _POSTERIOR = 0.2, 0.4
"""Strengths of the colours of bands, and of the narrower bands of curves fitted to tests."""
AT_SENSOR = "Amplitude at the sensor"
_MILLI = (1e-3, "m")


def curve_plot(prediction: StructurePrediction) -> Plot:
    """Plot frequency change relative to the linear frequency, and damping ratio."""
    quantity, largest = prediction.part.quantity, float(prediction.modes[0].curve.amplitude[-1])
    at_sensor = Quantity(prediction.part.unit, label=AT_SENSOR)

    def sensed(test: ModalTest | ModalCurve) -> Floats:
        """Convert displacement amplitudes to the sensor's quantity, in the unit of the axis."""
        omega = 2.0 * np.pi * test.frequency
        return np.asarray(test.amplitude * omega ** POWERS[quantity] / unit)

    upper, lower = (
        Panel(axis_of(at_sensor, largest, log=True, margin=0.0), axis)
        for axis in (
            axis_of(dimensionless("Frequency change"), (0.01, "%")),
            axis_of(QUANTITIES["damping_ratio"], log=True),
        )
    )
    unit, panels = upper.x.unit, ((upper, "frequency"), (lower, "damping_ratio"))

    def values(mode: Mode, curve: object, name: str, place: int | None = None) -> Floats:
        y = getattr(curve, name) if place is None else getattr(curve, name)[place]
        return scaled(mode, y, name)

    def scaled(mode: Mode, y: Floats, name: str) -> Floats:
        at_rest = mode.curve.linear_frequency
        return 100.0 * (y / at_rest - 1.0) if name == "frequency" else np.asarray(y)

    # All bands lie below all lines, and keep their edges where they overlap.
    for index, mode in enumerate(prediction.modes):
        for panel, name in panels if mode.bands is not None else ():
            low, high = (values(mode, mode.bands, name, end) for end in (0, -1))
            x = mode.curve.amplitude / unit
            panel.add(between(x, low, high, pale(line_style(index).color, BAND)))
            for edge in (low, high):
                panel.line(x, edge, line_style(index).color, width=0.6, dash=DOTTED)
    # The band that tests leave for the fitted curves, over the band of the uncertain inputs.
    numbers = [mode.number for mode in prediction.modes]
    fitted = [] if prediction.identified is None else [
        (numbers.index(curve.index + 1), np.argsort(curve.amplitude, kind="stable"), curve, band)
        for curve, band in zip(
            prediction.identified.curves, prediction.identified.bands, strict=True
        )
    ]  # fmt: skip
    for index, order, curve, band in fitted:
        for (panel, name), ends in zip(panels, band[:, :, order], strict=True):
            low, high = (scaled(prediction.modes[index], end, name) for end in ends)
            color = pale(line_style(index).color, _POSTERIOR)
            panel.add(between(sensed(curve)[order], low, high, color))
    legend = []
    for index, mode in enumerate(prediction.modes):
        color, x = line_style(index).color, mode.curve.amplitude / unit
        for panel, name in panels:
            panel.line(x, values(mode, mode.curve, name), color)
        text = f"mode {mode.number}, {mode.curve.linear_frequency:.5g} Hz at rest"
        legend.append(Entry(text, color))
    for test in prediction.tests:
        index = numbers.index(test.mode + 1)
        color, mode = line_style(index).color, prediction.modes[index]
        if test.motion == "decay":
            x = mode.curve.amplitude / unit
            lower.line(x, mode.curve.decay_damping_ratio, color, width=0.8)
        for panel, name in panels:
            panel.marks(sensed(test), values(mode, test, name), color)
        kind = "decay" if test.motion == "decay" else "test"
        legend.append(Entry(f"{kind} of mode {test.mode + 1}", color, marker="o", line=False))
    for test, (index, order, curve, _) in zip(prediction.tests, fitted, strict=False):
        change = values(prediction.modes[index], curve, "frequency")
        for panel, y in ((upper, change), (lower, test.damping_of(curve))):
            panel.line(sensed(curve)[order], y[order], line_style(index).color, dash=DOTTED)
    if fitted:
        legend.append(Entry("fitted to the tests", COLORS[0], DOTTED))
    return stacked([upper, lower], 6.2, (1.0, 1.3), legend)


def pressure_plot(prediction: StructurePrediction) -> Plot:
    """Plot the contact pressures of the patches after tightening."""
    pressures = prediction.state.pressures
    axis = axis_of(Quantity("Pa", label="Pressure"), float(pressures.max()))
    return _maps(prediction, [("", pressures)], axis)


def slip_plot(prediction: StructurePrediction) -> Plot:
    """Plot the tangential amplitude between the faces of each patch."""
    slips = [(f"Mode {mode.number}", mode.slip(prediction.joint)) for mode in prediction.modes]
    largest = max(float(slip.max()) for _, slip in slips)
    amplitude = Quantity("m", label="Relative tangential amplitude")
    return _maps(prediction, slips, axis_of(amplitude, largest))


def loss_plot(prediction: StructurePrediction) -> Plot:
    """Plot the fraction of the dissipated energy in each patch."""
    losses = [(f"Mode {mode.number}", mode.loss()) for mode in prediction.modes]
    axis = axis_of(dimensionless("Fraction of the loss"), (0.01, "%"))
    return _maps(prediction, losses, axis)


def _maps(prediction: StructurePrediction, maps: list[tuple[str, Floats]], colours: Axis) -> Plot:
    """Plot values [SI] of the patches in plan view with the bolts, on a common colour scale."""
    joint = prediction.joint
    largest = max(float(values.max()) for _, values in maps) or 1.0
    contacts = np.unique(joint.patch_contacts)
    boxes = 1e3 * joint.patch_boxes
    turn = np.linspace(0.0, 2.0 * np.pi, 49)
    rows = [(title, values, contact) for title, values in maps for contact in contacts]
    panels = []
    for row, (title, values, contact) in enumerate(rows):
        last = row == len(rows) - 1
        here = joint.patch_contacts == contact
        if len(contacts) > 1:
            title = f"{title}, contact {contact + 1}".removeprefix(", ")
        panel = Panel(
            _in_space("Along the lap", boxes[here, 0].min(), boxes[here, 1].max(), bare=not last),
            _in_space("Across", boxes[here, 2].min(), boxes[here, 3].max()),
            note=title,
            grid=False,
            equal=True,
            cell=(row, row, 0, 0),
        )
        for (x0, x1, y0, y1), value in zip(boxes[here], values[here], strict=True):
            color = _blend(min(max(value / largest, 0.0), 1.0))
            panel.add(Area(np.array([x0, x1, x1, x0]), np.array([y0, y0, y1, y1]), color))
        for x, y, diameter, number in prediction.part.holes:
            if number == contact:
                circle = 500.0 * diameter * np.array([np.cos(turn), np.sin(turn)])
                panel.add(Area(1e3 * x + circle[0], 1e3 * y + circle[1], "#ffffff"))
        panels.append(panel)
    wide = np.ptp(boxes[:, 2:]) / np.ptp(boxes[:, :2])
    high = min(max(6.0 * float(wide), 1.2), 3.5)
    share = np.linspace(0.0, 1.0, 256)[None, :, None]
    ramp = np.rint(_LIGHT + share * (_DARK - _LIGHT)).astype(np.uint8)
    colours.low, colours.high = 0.0, largest / colours.unit
    bar = scale_of_colours(colours, ramp, (len(rows), len(rows), 0, 0))
    return with_scale(panels, bar, high, 1.4)


def _in_space(label: str, low: float | None = None, high: float | None = None, **look: Any) -> Axis:
    return axis_of(Quantity("m", label=label), _MILLI, low=low, high=high, **look)


def shape_plot(prediction: StructurePrediction) -> Plot:
    """Plot each exaggerated mode shape over the structure at rest, seen from the side or above."""
    panels = [_shape(prediction, mode) for mode in prediction.modes]
    for side in ("x", "y"):  # equal ranges, so that equal scales align the panels
        values = np.concatenate(
            [getattr(i, side) for p in panels for i in p.items if type(i) is Area]
        )
        for panel in panels:
            axis = getattr(panel, side)
            free = 0.05 * float(np.ptp(values))
            axis.low, axis.high = float(values.min()) - free, float(values.max()) + free
    return stacked(panels, 1.5 * len(panels) + 0.7)


def _shape(prediction: StructurePrediction, mode: Mode) -> Panel:
    outside = prediction.joint.surface
    solved = mode.last
    shape = mode.curve.shape[solved]
    turned = (shape * np.exp(-1j * np.angle(shape[np.argmax(abs(shape))]))).real
    motion = outside.motion.astype(float) @ turned
    points = outside.points.astype(float)
    if prediction.part.mesh is not None:
        return _isometric(points, motion, outside.facets, mode)
    # Drawings lie along x. Seen from the side, or from above.
    along, first, second = 0, 1, 2
    up = second if np.ptp(motion[:, second]) >= np.ptp(motion[:, first]) else first
    hidden = 3 - along - up
    near = points[:, hidden].min() if hidden < up else points[:, hidden].max()
    size = np.ptp(points[:, along])
    facets = outside.facets
    depth = points[facets][:, :, hidden]
    visible = facets[(abs(depth - near) < 1e-6).all(axis=1)]
    flat = np.ptp(depth, axis=1) < 1e-6
    if hidden > up and flat.any():  # heads hide the plates: take the plane where most facets lie
        heights = np.round(depth.mean(axis=1), 6)
        levels, counts = np.unique(heights[flat], return_counts=True)
        visible = facets[flat & (heights == levels[np.argmax(counts)])]
    if not len(visible):  # nothing is flat that way
        visible = facets
    scale = 0.08 * size / float(abs(motion).max())
    grown = points + scale * motion
    panel = Panel(
        _in_space("Along"),
        _in_space("Up" if up == second else "Across"),
        note=_shape_note(mode, scale),
        equal=True,
        grid=False,
    )
    for places, color in ((points, "#e4e4e4"), (grown, "#4c8fc0")):
        for facet in visible:
            panel.add(Area(1e3 * places[facet, along], 1e3 * places[facet, up], color))
    return panel


def _shape_note(mode: Mode, scale: float) -> str:
    """Return frequency and magnification of a shape, whose modal amplitude of 1 is scaled."""
    factor = scale / float(mode.curve.modal_amplitude[mode.last])
    return (
        f"Mode {mode.number}, {mode.curve.frequency[mode.last]:.5g} Hz, displacements at the "
        f"largest amplitude enlarged {float(f'{factor:.2g}'):g} times"
    )


def _isometric(points: Floats, motion: Floats, facets: NDArray[np.int32], mode: Mode) -> Panel:
    view = np.array([[-0.866, 0.866, 0.0], [-0.5, -0.5, 1.0]])
    eye = np.array([1.0, 1.0, 1.0])
    size = float(np.ptp(points, axis=0).max())
    moved = np.linalg.norm(motion, axis=1)
    scale = 0.08 * size / float(moved.max())
    grown = points + scale * motion
    depth = grown[facets].mean(axis=1) @ eye
    # Cells behind others are drawn first.
    order = np.argsort(depth)
    flat = 1e3 * grown @ view.T
    share = moved[facets].mean(axis=1) / moved.max()
    panel = Panel(
        _in_space("Isometric view"),
        Axis(),
        note=_shape_note(mode, scale),
        equal=True,
        grid=False,
    )
    for facet in order:
        corners = flat[facets[facet]]
        panel.add(Area(corners[:, 0], corners[:, 1], _blend(float(share[facet]))))
    origin = 1e3 * (points.min(axis=0) - 0.05 * size)
    for axis, name in enumerate("xyz"):
        end = origin.copy()
        end[axis] += 1e3 * 0.25 * size
        (x0, y0), (x1, y1) = view @ origin, view @ end
        panel.line([x0, x1], [y0, y1], COLORS[0], width=1.0)
        panel.add(Words(x1, y1, name, data=True))
    return panel


def _blend(share: float) -> str:
    """Return the colour for a displacement, given as a fraction of the largest."""
    red, green, blue = (round(v) for v in _LIGHT + share * (_DARK - _LIGHT))
    return f"#{red:02x}{green:02x}{blue:02x}"
