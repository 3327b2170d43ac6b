"""The figures of one contact, 19.2, 19.3 and 19.10, all from `Asperity`."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch, Wedge

from microslip._core.checks import Floats
from microslip._core.units import engineering
from microslip.chapter.plate import (
    BACK,
    BLUE,
    DASHES,
    DOTS,
    GREEN,
    GREY,
    HATCH,
    INK,
    LIGHT,
    MEGA,
    MICRO,
    RED,
    SLIP,
    STICK,
    STUCK,
    Drawing,
    Plate,
    arrow,
    as_plate,
    cross,
    mark,
    subscripts,
    words,
)
from microslip.friction import Asperity, AsperityFields, Zone
from microslip.materials import Material, MaterialPair


def summit() -> Asperity:
    """A summit of the chapter's milled aluminium, under about its share of the load."""
    aluminium = Material(young_modulus=69e9, poisson_ratio=0.33)
    pair = MaterialPair(aluminium, aluminium)
    return Asperity(pair, radius=1e-3, friction_coefficient=0.55, normal_load=0.25)


def assumed(addition: str = "") -> str:
    """Assumptions of the figures of one asperity, in a sentence."""
    joint = summit()
    metal = joint.pair.first
    return (
        f"One summit of Al 2017 on Al 2017: E = {engineering(metal.young_modulus, 'Pa')}, "
        f"ν = {metal.poisson_ratio:g}, μ = {joint.friction_coefficient:g}, "
        f"ρ = {engineering(joint.radius, 'm', trim=True)}, "
        f"N = {engineering(joint.normal_load, 'N')}, so a = "
        f"{engineering(joint.contact_radius, 'm')}, μN = {engineering(joint.force_limit, 'N')}, "
        f"slip limit δL = {engineering(joint.slip_limit, 'm')}. {addition}"
    ).strip()


def path(*corners: float, samples: int = 80) -> Floats:
    """A record through the corners, denser near them, as a sine is."""
    rise = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, samples))
    pieces = [low + (high - low) * rise for low, high in pairwise(corners)]
    return np.concatenate([pieces[0], *(piece[1:] for piece in pieces[1:])])


# -- tractions -------------------------------------------------------------------------------------


def section(joint: Asperity, *states: AsperityFields) -> Floats:
    """Places along a diameter, close at the edges, with those of all zones among them."""
    a = joint.contact_radius
    half = np.concatenate((a * np.sin(np.linspace(0.0, np.pi / 2.0, 250)), [1.12 * a]))
    edges = [zone.outer for fields in states for zone in fields.zones]
    half = np.unique(np.concatenate((half, edges)))
    return np.concatenate((-half[:0:-1], half))


def _look(zone: Zone) -> dict[str, Any]:
    """Fill of a zone; slip against the first loading is grey and hatched the other way."""
    if zone.kind == "stick":
        return {"facecolor": STICK}
    if zone.kind == "stuck":
        return {"facecolor": STUCK, "edgecolor": LIGHT, "hatch": "..."}
    if zone.direction == 1:
        return {"facecolor": SLIP, "edgecolor": HATCH, "hatch": "///"}
    return {"facecolor": BACK, "edgecolor": LIGHT, "hatch": "\\\\\\"}


def shade(axes: Axes, fields: AsperityFields) -> None:
    """The zones behind a section."""
    for zone in fields.zones:
        for low, high in ((zone.inner, zone.outer), (-zone.outer, -zone.inner)):
            axes.axvspan(low / MICRO, high / MICRO, linewidth=0.0, zorder=0, **_look(zone))


def zone_handles() -> list[Patch]:
    """A legend of the fills."""
    kinds = (
        (Zone("stick", 0.0, 1.0, 0), "stick"),
        (Zone("slip", 0.0, 1.0, 1), "slip"),
        (Zone("stuck", 0.0, 1.0, 1), "stuck again after slip"),
        (Zone("slip", 0.0, 1.0, -1), "reversed slip"),
    )
    return [Patch(**_look(zone), linewidth=0.0, label=text) for zone, text in kinds]


@as_plate(
    "19.2",
    "cattaneo-traction",
    "tangential traction in partial slip (Cattaneo)",
    "In the slip ring the traction is μp, the limit of friction; in the stick circle it is less "
    "by μ times the pressure of the circle alone.",
    assumed("Displacement 0.6 δL from rest."),
)
def _cattaneo(plate: Plate) -> Drawing:
    joint = summit()
    fields = joint.fields(0.6 * joint.slip_limit)
    x = section(joint, fields)
    r = np.abs(x)
    bound, q = joint.friction_coefficient * joint.pressure(r), fields.traction(r)
    a, c = joint.contact_radius / MICRO, fields.stick_radius / MICRO
    figure, body, axes = plate.sheet(4.1)
    shade(axes, fields)
    axes.plot(x / MICRO, bound / MEGA, color=INK, linestyle=DASHES, label="μp")
    axes.plot(x / MICRO, q / MEGA, color=BLUE, linewidth=2.0, label="q in partial slip")
    top = 1.18 * bound.max() / MEGA
    words(axes, "stick: q < μp", 0.0, 0.94 * top)
    for side in (-1.0, 1.0):
        words(axes, "slip:\nq = μp", side * 0.5 * (a + c), 0.92 * top)
    axes.set(xlabel="Place along the force x [µm]", ylabel="Tangential traction [MPa]")
    axes.set(xlim=(x[0] / MICRO, x[-1] / MICRO), ylim=(0.0, top))
    above = axes.secondary_xaxis("top")
    above.set_xticks([-a, -c, 0.0, c, a], ["−a", "−c", "0", "c", "a"])
    body.legend(loc="outside lower center", ncols=2)
    columns = {"x [m]": x, "friction times pressure [Pa]": bound, "tangential traction [Pa]": q}
    return Drawing(figure, columns)


@as_plate(
    "19.3",
    "pressure-and-traction",
    "pressure and tangential traction on the surface (Mindlin)",
    "As the force grows, the slip ring with the traction μp grows inwards. Without slip the "
    "traction would be infinite at the edge under any force.",
    assumed("First loading."),
)
def _mindlin(plate: Plate) -> Drawing:
    joint = summit()
    shares = (0.25, 0.5, 0.75)
    states = [joint.fields(force=share * joint.force_limit) for share in shares]
    x = section(joint, *states)
    r, a = np.abs(x), joint.contact_radius
    inside = r < a * (1.0 - 1e-9)
    welded = np.full_like(x, np.nan)
    welded[inside] = states[1].force / (2.0 * np.pi * a * np.sqrt(a * a - r[inside] ** 2))
    columns = {"x [m]": x, "pressure [Pa]": joint.pressure(r)}
    columns["friction times pressure [Pa]"] = joint.friction_coefficient * columns["pressure [Pa]"]
    figure, body, axes = plate.sheet(4.6)
    axes.plot(x / MICRO, columns["pressure [Pa]"] / MEGA, color=INK, linewidth=2.0, label="p")
    bound = columns["friction times pressure [Pa]"]
    axes.plot(x / MICRO, bound / MEGA, color=INK, linestyle=DASHES, label="μp: q at T = μN")
    looks = ((GREEN, (0, (6, 2, 1, 2))), (BLUE, "-"), (RED, (0, (5, 1))))
    for share, fields, (color, line) in zip(shares, states, looks, strict=True):
        q = fields.traction(r)
        columns[f"tangential traction at T = {share:g} mu N [Pa]"] = q
        axes.plot(x / MICRO, q / MEGA, color=color, linestyle=line, label=f"q at T = {share:g} μN")
    columns["without slip at T = 0.5 mu N [Pa]"] = welded
    label = "q at T = 0.5 μN, were there no slip"
    axes.plot(x / MICRO, welded / MEGA, color=BLUE, linestyle=DOTS, label=label)
    axes.set(xlabel="Place along the force x [µm]", ylabel="Traction [MPa]")
    axes.set(xlim=(x[0] / MICRO, x[-1] / MICRO), ylim=(0.0, 1.12 * joint.peak_pressure / MEGA))
    above = axes.secondary_xaxis("top")
    above.set_xticks([-a / MICRO, 0.0, a / MICRO], ["−a", "0", "a"])
    body.legend(loc="outside lower center", ncols=3)
    return Drawing(figure, columns)


@as_plate(
    "19.10",
    "contact-area",
    "stick circle and slip ring of the contact",
    "Slip starts at the edge. After a reversal it starts there again in the other direction, "
    "while the ring that slipped before moves with the stick circle.",
    assumed(),
)
def _contact_area(plate: Plate) -> Drawing:
    joint = summit()
    a = joint.contact_radius
    top, down = 0.75, 0.0
    peak = top * joint.force_limit
    states = (
        ("Loaded to T = 0.75 μN", joint.fields(force=peak)),
        ("Unloaded to T = 0", joint.fields(force=[peak, down])),
        ("Loaded again to T = 0.4 μN", joint.fields(force=[peak, down, 0.4 * joint.force_limit])),
    )
    figure, body = plate.page(3.5)
    rows = []
    for index, (axes, (title, fields)) in enumerate(zip(body.subplots(1, 3), states, strict=True)):
        for zone in fields.zones:
            ring: dict[str, Any] = {
                "width": (zone.outer - zone.inner) / a,
                "linewidth": 0.0,
                "edgecolor": "none",
            }
            for look in (
                ring | _look(zone),
                {"fill": False, "linewidth": 0.9, "edgecolor": INK},
            ):
                axes.add_patch(Wedge((0.0, 0.0), zone.outer / a, 0.0, 360.0, **look))
            slips = float(zone.kind == "slip")
            rows.append((index, zone.inner, zone.outer, zone.direction, slips))
        axes.set_aspect("equal")
        axes.set(xlim=(-1.12, 1.12), ylim=(-1.12, 1.12), title=title)
        axes.axis("off")
        if fields.force > 1e-9 * joint.force_limit:
            arrow(axes, (-0.28, 0.0), (0.28, 0.0), linewidth=1.6)
            words(axes, "T", 0.0, 0.17)
        for degrees, radius, text in (
            (62.0, a, "a"),
            (118.0, fields.stick_radius, ("c", "c′", "c″")[index]),
        ):
            end = radius / a * np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
            arrow(axes, (0.0, 0.0), (float(end[0]), float(end[1])), linewidth=0.8)
            words(axes, text, *(0.72 * end))
    body.legend(handles=zone_handles(), loc="outside lower center", ncols=4)
    names = ("state", "inner radius [m]", "outer radius [m]", "direction", "slips now")
    columns = dict(zip(names, np.array(rows, dtype=float).T, strict=True))
    return Drawing(figure, columns)


def _levels(axes: Axes, joint: Asperity, horizontal: bool) -> None:
    """Lines at plus and minus the slip limit."""
    for sign, text in ((-1.0, "−δL"), (1.0, "δL")):
        place = sign * joint.slip_limit / MICRO
        if horizontal:
            _level(axes, place, subscripts(text))
        else:
            axes.axvline(place, color=LIGHT, linestyle=DASHES, linewidth=0.9, zorder=1)
            axes.annotate(
                subscripts(text), (place, 0.0), (3 * sign, 4), fontsize=8.5, color=GREY,
                xycoords=axes.get_xaxis_transform(), textcoords="offset points",
                ha="left" if sign > 0 else "right", va="bottom",
            )  # fmt: skip


def _level(axes: Axes, place: float, text: str) -> None:
    """A line across with its name above its beginning."""
    axes.axhline(place, color=LIGHT, linestyle=DASHES, linewidth=0.9, zorder=1)
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
    if levels:
        _levels(axes, joint, horizontal=False)


def _branches(
    axes: Axes, record: Floats, force: Floats, *pieces: tuple[int, int, dict[str, Any], str]
) -> None:
    """Runs of a record from one corner to another; all have as many samples."""
    size = (record.size - 1) // max(stop for _, stop, *_ in pieces)
    for start, stop, look, label in pieces:
        part = slice(size * start, size * stop + 1)
        axes.plot(record[part] / MICRO, force[part], label=label, **look)


_FIRST, _BACK, _AGAIN, _CLOSING = (
    {"color": color, "linestyle": line}
    for color, line in (
        (INK, DASHES), (BLUE, "-"), (RED, (0, (6, 1.5))), (GREEN, (0, (6, 2, 1, 2))),
    )
)  # fmt: skip


@as_plate(
    "19.11",
    "load-displacement-cycle",
    "a cycle of force with its tractions (after Johnson)",
    "At B the force is zero, but self-equilibrated tractions and a residual displacement remain. "
    "C is the mirror image of A.",
    assumed("Force between ±0.95 μN."),
)
def _johnson(plate: Plate) -> Drawing:
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
    figure, body = plate.page(4.6)
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
                r_of / MICRO, sign * bound / MEGA, color=INK, linestyle=DASHES, linewidth=0.9
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
            panel.set_xlabel("Place along the force x [µm]")
    body.legend(handles=zone_handles(), loc="outside lower center", ncols=4)
    return Drawing(figure, columns)


def _draw_path(
    axes: Axes, joint: Asperity, corners: list[float], letters: Mapping[str, tuple[float, float]]
) -> tuple[Floats, Floats]:
    """A displacement path over time; letters by their time and offset sign."""
    record = path(*(corner * joint.slip_limit for corner in corners))
    time = np.linspace(0.0, len(corners) - 1.0, record.size)
    axes.plot(time, record / MICRO, color=BLUE)
    axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
    axes.set(ylabel="Displacement δ [µm]", xlabel="Time [half cycles]")
    reach = 1.35 * max(1.0, *(abs(v) for v in corners)) * joint.slip_limit / MICRO
    axes.set_ylim(-reach, reach)
    axes.set_xlim(-0.12, len(corners) - 1 + 0.25)
    _levels(axes, joint, horizontal=True)
    for name, (at, side) in letters.items():
        mark(axes, name, at, float(np.interp(at, time, record)) / MICRO, 0, 11 * side)
    return time, record


@as_plate(
    "19.12",
    "constant-amplitude-path",
    "loading path of constant amplitude",
    "The displacement of Fig. 19.13: from rest at O, then cycles between A and C.",
    assumed("Amplitude 0.8 δL."),
)
def _constant_path(plate: Plate) -> Drawing:
    joint = summit()
    letters = {"O": (0.0, 1), "A": (1.0, -1), "B": (1.5, 1), "C": (2.0, 1), "D": (2.5, 1)}
    figure, _, axes = plate.sheet(3.3)
    time, record = _draw_path(axes, joint, [0.0, 0.8, -0.8, 0.8, -0.8, 0.8], letters)
    mark(axes, "A", 3.0, record.max() / MICRO, 0, -11)
    return Drawing(figure, {"time [half cycles]": time, "displacement [m]": record})


@as_plate(
    "19.13",
    "partial-slip-loop",
    "force against displacement in partial slip",
    "First loading O–A, then the closed loop A–B–C–D: two copies of the first-loading curve at "
    "twice its size. The force does not reach μN, yet the loop dissipates energy.",
    assumed("Amplitude 0.8 δL."),
)
def _partial_loop(plate: Plate) -> Drawing:
    joint = summit()
    top = 0.8 * joint.slip_limit
    record = path(0.0, top, -top, top)
    force = joint.force(record)
    figure, body, axes = plate.sheet(4.3)
    _branches(
        axes, record, force, (0, 1, _FIRST, "O–A, first loading"),
        (1, 2, _BACK, "A–B–C, unloading"), (2, 3, _AGAIN, "C–D–A, reloading"),
    )  # fmt: skip
    _loop_axes(axes, joint, 1.2)
    at_b = joint.force([top, 0.0])[-1]
    for name, x, y, dx, dy in (
        ("O", 0.0, 0.0, -10, -4),
        ("A", top, joint.backbone(top), 9, 7),
        ("B", 0.0, at_b, 10, -8),
        ("C", -top, -joint.backbone(top), -9, -7),
        ("D", 0.0, -at_b, -10, 8),
    ):
        mark(axes, name, x / MICRO, y, dx, dy)
    body.legend(loc="outside lower center", ncols=3)
    return Drawing(figure, {"displacement [m]": record, "force [N]": force})


@as_plate(
    "19.14",
    "total-slip-loop",
    "force against displacement with total slip",
    "Beyond the slip limit the force stays at μN and the asperity slides by δ₀. A reversal "
    "has to cover 2 δL before it slides back.",
    assumed("Amplitude 1.7 δL, of which δ₀ = 0.7 δL is sliding."),
)
def _total_loop(plate: Plate) -> Drawing:
    joint = summit()
    limit = joint.slip_limit
    top = 1.7 * limit
    record = path(0.0, top, -top, top, samples=160)
    force = joint.force(record)
    figure, body, axes = plate.sheet(4.3)
    _branches(
        axes, record, force, (0, 1, _FIRST, "first loading"), (1, 2, _BACK, "unloading"),
        (2, 3, _AGAIN, "reloading"),
    )  # fmt: skip
    _loop_axes(axes, joint, 2.1)
    high = 1.13 * joint.force_limit
    arrow(axes, (limit / MICRO, high), (top / MICRO, high), double=True, linewidth=0.9)
    words(axes, "δ₀", 0.5 * (limit + top) / MICRO, high)
    words(axes, "sliding", 0.5 * (limit + top) / MICRO, 0.87 * joint.force_limit, color=GREY)
    words(axes, "sliding", -0.5 * (limit + top) / MICRO, -0.87 * joint.force_limit, color=GREY)
    body.legend(loc="outside lower center", ncols=3)
    return Drawing(figure, {"displacement [m]": record, "force [N]": force})


@as_plate(
    "19.15",
    "growing-amplitude",
    "growing amplitude: (a) path, (b) loops from partial to total slip",
    "The tips of all loops lie on the first-loading curve; from the third on there is gross slip.",
    assumed("Amplitudes 0.35, 0.7, 1.05 and 1.6 δL."),
)
def _growing(plate: Plate) -> Drawing:
    joint = summit()
    levels = (0.35, 0.7, 1.05, 1.6)
    corners = [0.0, *(v for level in levels for v in (level, -level)), levels[-1]]
    figure, body = plate.page(4.2)
    path_axes, right = body.subplots(1, 2, width_ratios=[1.0, 1.15])
    time, record = _draw_path(path_axes, joint, corners, {})
    force = joint.force(record)
    right.plot(record / MICRO, force, color=BLUE)
    _loop_axes(right, joint, 2.4)
    path_axes.set_title("(a)")
    right.set_title("(b)")
    columns = {"time [half cycles]": time, "displacement [m]": record, "force [N]": force}
    return Drawing(figure, columns)


VARIABLE = (0.0, 0.95, -0.6, 0.6, -0.85, 1.5, -1.5)


@as_plate(
    "19.16",
    "variable-amplitude-path",
    "loading path of variable amplitude",
    "The displacement of Fig. 19.17: two small cycles, then larger ones.",
    assumed("Turns at 0.95, −0.6, 0.6, −0.85, 1.5 and −1.5 δL."),
)
def _variable_path(plate: Plate) -> Drawing:
    joint = summit()
    letters = {"O": (0.0, -1), "A": (1.0, -1), "B": (2.0, 1), "C": (3.0, -1), "D": (4.0, 1)}
    figure, _, axes = plate.sheet(3.3)
    time, record = _draw_path(axes, joint, list(VARIABLE), letters)
    return Drawing(figure, {"time [half cycles]": time, "displacement [m]": record})


@as_plate(
    "19.17",
    "variable-amplitude-loops",
    "force against displacement, from partial to total slip",
    "C–D passes B on the curve that A–B had begun: the loop B–C has closed and left no trace. "
    "From D on the curve runs through A into that of first loading, and slides at μN.",
    assumed("Turns at 0.95, −0.6, 0.6, −0.85, 1.5 and −1.5 δL."),
)
def _variable_loop(plate: Plate) -> Drawing:
    joint = summit()
    corners = [v * joint.slip_limit for v in VARIABLE]
    record = path(*corners, samples=160)
    force = joint.force(record)
    figure, body, axes = plate.sheet(4.6)
    rest = {"color": LIGHT, "zorder": 1.9}
    _branches(
        axes, record, force, (0, 1, _FIRST, "O–A"), (1, 2, _BACK, "A–B"), (2, 3, _AGAIN, "B–C"),
        (3, 4, _CLOSING, "C–D"), (4, 6, rest, "on to gross slip, both ways"),
    )  # fmt: skip
    _loop_axes(axes, joint, 1.75)
    offsets = {"O": (-9, 8), "A": (5, 10), "B": (10, -6), "C": (8, -8), "D": (-8, 9)}
    for index, (name, (dx, dy)) in enumerate(offsets.items()):
        mark(axes, name, corners[index] / MICRO, force[159 * index], dx, dy)
    body.legend(loc="outside lower center", ncols=5)
    return Drawing(figure, {"displacement [m]": record, "force [N]": force})
