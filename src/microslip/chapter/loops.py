"""Figures 19.11 to 19.17 of the book chapter: load cycles of a single contact, by `Asperity`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import SubFigure

from microslip.chapter.contact import contact_note, path, section, shade, summit, zone_handles
from microslip.chapter.plate import (
    BLUE,
    GREEN,
    GREY,
    INK,
    LIGHT,
    MEGA,
    MICRO,
    RED,
    STROKE,
    Columns,
    arrow,
    as_plate,
    cross,
    mark,
    subscripts,
    words,
)
from microslip.friction import Asperity


def _level(axes: Axes, place: float, text: str) -> None:
    axes.axhline(place, color=LIGHT, linestyle=STROKE, linewidth=0.9, zorder=1)
    axes.annotate(
        text, (0.0, place), (5, 1), fontsize=8.5, color=GREY,
        xycoords=axes.get_yaxis_transform(), textcoords="offset points",
        ha="left", va="bottom",
    )  # fmt: skip


def _loop_axes(axes: Axes, joint: Asperity, reach: float, levels: bool = True) -> None:
    axes.set(xlabel="Tangential displacement δ [µm]", ylabel="Tangential force T [N]")
    cross(axes)
    axes.set_xlim(-reach * joint.slip_limit / MICRO, reach * joint.slip_limit / MICRO)
    axes.set_ylim(-1.25 * joint.force_limit, 1.25 * joint.force_limit)
    for sign, text in ((-1.0, "−μN"), (1.0, "μN")):
        _level(axes, sign * joint.force_limit, text)
    for sign, text in ((-1.0, "−δL"), (1.0, "δL")) if levels else ():
        place = sign * joint.slip_limit / MICRO
        axes.axvline(place, color=LIGHT, linestyle=STROKE, linewidth=0.9, zorder=1)
        axes.annotate(
            subscripts(text), (place, 0.0), (3 * sign, 4), fontsize=8.5, color=GREY,
            xycoords=axes.get_xaxis_transform(), textcoords="offset points",
            ha="left" if sign > 0 else "right", va="bottom",
        )  # fmt: skip


def _draw_loop(
    body: SubFigure,
    corners: Sequence[float],
    reach: float,
    *pieces: tuple[int, int, dict[str, Any], str],
    samples: int = 160,
) -> tuple[Axes, Columns]:
    """Draw the force over a displacement history with corners in slip limits.

    Each piece is the number of its first corner, that of its last corner, the style of the line and
    its label. Return the axes and the data.
    """
    joint, axes = summit(), body.subplots()
    record = path(*(corner * joint.slip_limit for corner in corners), samples=samples)
    force = joint.force(record)
    for start, stop, look, label in pieces:
        part = slice((samples - 1) * start, (samples - 1) * stop + 1)
        axes.plot(record[part] / MICRO, force[part], label=label, **look)
    _loop_axes(axes, joint, reach)
    body.legend(loc="outside lower center", ncols=len(pieces))
    return axes, {"displacement [m]": record, "force [N]": force}


_FIRST, _BACK, _AGAIN, _CLOSING = (
    {"color": color, "linestyle": line}
    for color, line in (
        (INK, STROKE), (BLUE, "-"), (RED, (0, (6, 1.5))), (GREEN, (0, (6, 2, 1, 2))),
    )
)  # fmt: skip


@as_plate(
    "19.11",
    4.6,
    "a cycle of force with its tractions (after Johnson)",
    "At B the force is zero, but self-equilibrated tractions and a residual displacement remain. "
    "C is the mirror image of A.",
    contact_note("Force between −0.95 × μN and 0.95 × μN."),
)
def _load_displacement_cycle(body: SubFigure) -> Columns:
    joint = summit()
    peak = 0.95 * joint.force_limit
    top = joint.backbone_displacement(peak)
    corners = {
        "A": [peak],
        "B": [peak, 0.0],
        "C": [peak, -peak],
        "D": [peak, -peak, 0.0],
    }
    record = path(0.0, top, -top, top)
    force = joint.force(record)
    grid = body.add_gridspec(3, 2, width_ratios=[1.35, 1.0])
    axes = body.add_subplot(grid[:, 0])
    axes.plot(record / MICRO, force, color=BLUE)
    _loop_axes(axes, joint, 1.25, levels=False)
    states = {name: joint.fields(force=forces) for name, forces in corners.items()}
    offsets = {"A": (8, 8), "B": (11, -8), "C": (-8, -8), "D": (-11, 8)}
    for name, fields in states.items():
        mark(axes, name, fields.displacement / MICRO, fields.force, *offsets[name])
    mark(axes, "O", 0.0, 0.0, 2, -12)
    r_of = section(joint, *states.values())
    bound = joint.friction_coefficient * joint.pressure(np.abs(r_of))
    columns = {"x [m]": r_of, "friction times pressure [Pa]": bound}
    panel = None
    for row, name in enumerate("ABC"):
        panel = body.add_subplot(grid[row, 1], sharex=panel)
        fields = states[name]
        q = fields.traction(np.abs(r_of))
        columns[f"tangential traction at {name} [Pa]"] = q
        shade(panel, fields)
        for sign in (-1.0, 1.0):
            panel.plot(
                r_of / MICRO, sign * bound / MEGA, color=INK, linestyle=STROKE, linewidth=0.9
            )
        panel.plot(r_of / MICRO, q / MEGA, color=BLUE, linewidth=1.8)
        panel.set_ylim(-1.25 * bound.max() / MEGA, 1.25 * bound.max() / MEGA)
        panel.set_xlim(r_of[0] / MICRO, r_of[-1] / MICRO)
        panel.set_ylabel("q [MPa]")
        panel.text(
            0.015, 0.93, name, transform=panel.transAxes, fontsize=10, fontweight="bold", va="top"
        )
        if row < 2:
            panel.tick_params(labelbottom=False)
        else:
            panel.set_xlabel("Position along the force x [µm]")
    body.legend(handles=zone_handles(), loc="outside lower center", ncols=4)
    return columns


def _draw_path(axes: Axes, corners: Sequence[float], *letters: tuple[str, float, int]) -> Columns:
    """Draw a displacement history over time, and return its data.

    A letter is given with the time of its point [half cycles], and +1 or -1 for a letter above or
    below the line.
    """
    joint = summit()
    record = path(*(corner * joint.slip_limit for corner in corners))
    time = np.linspace(0.0, len(corners) - 1.0, record.size)
    axes.plot(time, record / MICRO, color=BLUE)
    axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
    axes.set(ylabel="Displacement δ [µm]", xlabel="Time [half cycles]")
    reach = 1.35 * max(1.0, *(abs(v) for v in corners)) * joint.slip_limit / MICRO
    axes.set_ylim(-reach, reach)
    axes.set_xlim(-0.12, len(corners) - 1 + 0.25)
    for sign, text in ((-1.0, "−δL"), (1.0, "δL")):
        _level(axes, sign * joint.slip_limit / MICRO, subscripts(text))
    for name, at, side in letters:
        mark(axes, name, at, float(np.interp(at, time, record)) / MICRO, 0, 11 * side)
    return {"time [half cycles]": time, "displacement [m]": record}


@as_plate(
    "19.12",
    3.3,
    "loading path of constant amplitude",
    "The displacement of Fig. 19.13: from rest at O, then cycles between A and C.",
    contact_note("Amplitude 0.8 δL."),
)
def _constant_amplitude_path(body: SubFigure) -> Columns:
    return _draw_path(
        body.subplots(), (0.0, 0.8, -0.8, 0.8, -0.8, 0.8), ("O", 0.0, 1), ("A", 1.0, -1),
        ("B", 1.5, 1), ("C", 2.0, 1), ("D", 2.5, 1), ("A", 3.0, -1),
    )  # fmt: skip


@as_plate(
    "19.13",
    4.3,
    "force against displacement in partial slip",
    "First loading O–A, then the closed loop A–B–C–D: two copies of the first-loading curve at "
    "twice its size. The force does not reach μN, yet the loop dissipates energy.",
    contact_note("Amplitude 0.8 δL."),
)
def _partial_slip_loop(body: SubFigure) -> Columns:
    axes, columns = _draw_loop(
        body, (0.0, 0.8, -0.8, 0.8), 1.2, (0, 1, _FIRST, "O–A, first loading"),
        (1, 2, _BACK, "A–B–C, unloading"), (2, 3, _AGAIN, "C–D–A, reloading"), samples=80,
    )  # fmt: skip
    joint = summit()
    top = 0.8 * joint.slip_limit
    at_b = joint.force([top, 0.0])[-1]
    for name, x, y, dx, dy in (
        ("O", 0.0, 0.0, -10, -4),
        ("A", top, joint.backbone(top), 9, 7),
        ("B", 0.0, at_b, 10, -8),
        ("C", -top, -joint.backbone(top), -9, -7),
        ("D", 0.0, -at_b, -10, 8),
    ):
        mark(axes, name, x / MICRO, y, dx, dy)
    return columns


@as_plate(
    "19.14",
    4.3,
    "force against displacement with total slip",
    "Beyond the slip limit the force stays at μN and the asperity slides by δ₀. A reversal "
    "has to cover 2 δL before it slides back.",
    contact_note("Amplitude 1.7 δL, of which δ₀ = 0.7 δL is sliding."),
)
def _total_slip_loop(body: SubFigure) -> Columns:
    axes, columns = _draw_loop(
        body, (0.0, 1.7, -1.7, 1.7), 2.1, (0, 1, _FIRST, "first loading"),
        (1, 2, _BACK, "unloading"), (2, 3, _AGAIN, "reloading"),
    )  # fmt: skip
    joint = summit()
    limit = joint.slip_limit
    top = 1.7 * limit
    high = 1.13 * joint.force_limit
    arrow(axes, (limit / MICRO, high), (top / MICRO, high), double=True, linewidth=0.9)
    words(axes, "δ₀", 0.5 * (limit + top) / MICRO, high)
    words(axes, "sliding", 0.5 * (limit + top) / MICRO, 0.87 * joint.force_limit, color=GREY)
    words(axes, "sliding", -0.5 * (limit + top) / MICRO, -0.87 * joint.force_limit, color=GREY)
    return columns


@as_plate(
    "19.15",
    4.2,
    "growing amplitude: (a) path, (b) loops from partial to total slip",
    "The tips of all loops lie on the first-loading curve; from the third on there is gross slip.",
    contact_note("Amplitudes 0.35, 0.7, 1.05 and 1.6 δL."),
)
def _growing_amplitude(body: SubFigure) -> Columns:
    joint = summit()
    levels = (0.35, 0.7, 1.05, 1.6)
    corners = [0.0, *(v for level in levels for v in (level, -level)), levels[-1]]
    path_axes, right = body.subplots(1, 2, width_ratios=[1.0, 1.15])
    columns = _draw_path(path_axes, corners)
    record = columns["displacement [m]"]
    force = columns["force [N]"] = joint.force(record)
    right.plot(record / MICRO, force, color=BLUE)
    _loop_axes(right, joint, 2.4)
    path_axes.set_title("(a)")
    right.set_title("(b)")
    return columns


VARIABLE = (0.0, 0.95, -0.6, 0.6, -0.85, 1.5, -1.5)


@as_plate(
    "19.16",
    3.3,
    "loading path of variable amplitude",
    "The displacement of Fig. 19.17: two small cycles, then larger ones.",
    contact_note("Turns at 0.95, −0.6, 0.6, −0.85, 1.5 and −1.5 δL."),
)
def _variable_amplitude_path(body: SubFigure) -> Columns:
    letters = ("O", 0.0, -1), ("A", 1.0, -1), ("B", 2.0, 1), ("C", 3.0, -1), ("D", 4.0, 1)
    return _draw_path(body.subplots(), VARIABLE, *letters)


@as_plate(
    "19.17",
    4.6,
    "force against displacement, from partial to total slip",
    "At B the branch C–D closes the loop B–C and continues on the branch A–B as if the loop had "
    "not occurred. From D the curve passes A, follows the first-loading curve and slides at μN.",
    contact_note("Turns at 0.95, −0.6, 0.6, −0.85, 1.5 and −1.5 δL."),
)
def _variable_amplitude_loops(body: SubFigure) -> Columns:
    rest = {"color": LIGHT, "zorder": 1.9}
    axes, columns = _draw_loop(
        body, VARIABLE, 1.75, (0, 1, _FIRST, "O–A"), (1, 2, _BACK, "A–B"), (2, 3, _AGAIN, "B–C"),
        (3, 4, _CLOSING, "C–D"), (4, 6, rest, "gross slip in both directions"),
    )  # fmt: skip
    offsets = {"O": (-9, 8), "A": (5, 10), "B": (10, -6), "C": (8, -8), "D": (-8, 9)}
    for index, (name, (dx, dy)) in enumerate(offsets.items()):
        x, y = (values[159 * index] for values in columns.values())
        mark(axes, name, x / MICRO, y, dx, dy)
    return columns
