"""Figures 19.2, 19.3 and 19.10 of the chapter: a single contact, computed with `Asperity`."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import SubFigure
from matplotlib.patches import Patch, Wedge

from microslip._core.checks import Floats
from microslip._core.units import engineering
from microslip.chapter.plate import (
    BACK,
    BLUE,
    DOTS,
    GREEN,
    HATCH,
    INK,
    LIGHT,
    MEGA,
    MICRO,
    RED,
    SLIP,
    STICK,
    STROKE,
    STUCK,
    Columns,
    arrow,
    as_plate,
    words,
)
from microslip.contact.materials import Material, MaterialPair
from microslip.friction import Asperity, AsperityFields, Zone


def summit() -> Asperity:
    """Return one summit of the milled aluminium of chapter 19, with a typical normal load."""
    aluminium = Material(young_modulus=69e9, poisson_ratio=0.33)
    pair = MaterialPair(aluminium, aluminium)
    return Asperity(pair, radius=1e-3, friction_coefficient=0.55, normal_load=0.25)


def contact_note(addition: str = "") -> str:
    """Return the assumptions of the figures of a single asperity as text, then ``addition``."""
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
    """Return displacements [m] from corner to corner, with cosine-spaced samples in between."""
    rise = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, samples))
    pieces = [low + (high - low) * rise for low, high in pairwise(corners)]
    return np.concatenate([pieces[0], *(piece[1:] for piece in pieces[1:])])


# -- tractions -------------------------------------------------------------------------------------


def section(joint: Asperity, *states: AsperityFields) -> Floats:
    """Return positions [m] along a contact diameter, refined at the edge and zone boundaries."""
    a = joint.contact_radius
    half = np.concatenate((a * np.sin(np.linspace(0.0, np.pi / 2.0, 250)), [1.12 * a]))
    edges = [zone.outer for fields in states for zone in fields.zones]
    half = np.unique(np.concatenate((half, edges)))
    return np.concatenate((-half[:0:-1], half))


def _fill_style(zone: Zone) -> dict[str, Any]:
    """Return the fill style of a zone; reversed slip is grey with the opposite hatch."""
    if zone.kind == "stick":
        return {"facecolor": STICK}
    if zone.kind == "stuck":
        return {"facecolor": STUCK, "edgecolor": LIGHT, "hatch": "..."}
    if zone.direction == 1:
        return {"facecolor": SLIP, "edgecolor": HATCH, "hatch": "///"}
    return {"facecolor": BACK, "edgecolor": LIGHT, "hatch": "\\\\\\"}


def shade(axes: Axes, fields: AsperityFields) -> None:
    """Fill the stick and slip zones of a contact in the background of a diagram."""
    for zone in fields.zones:
        for low, high in ((zone.inner, zone.outer), (-zone.outer, -zone.inner)):
            axes.axvspan(low / MICRO, high / MICRO, linewidth=0.0, zorder=0, **_fill_style(zone))


def zone_handles() -> list[Patch]:
    """Return legend handles of the zone fills."""
    kinds = (
        (Zone("stick", 0.0, 1.0, 0), "stick"),
        (Zone("slip", 0.0, 1.0, 1), "slip"),
        (Zone("stuck", 0.0, 1.0, 1), "stuck again after slip"),
        (Zone("slip", 0.0, 1.0, -1), "reversed slip"),
    )
    return [Patch(**_fill_style(zone), linewidth=0.0, label=text) for zone, text in kinds]


@as_plate(
    "19.2",
    4.1,
    "tangential traction in partial slip (Cattaneo)",
    "In the slip ring the traction is μp, the limit of friction; in the stick circle it is less "
    "by μ times the pressure of the circle alone.",
    contact_note("Displacement 0.6 δL from rest."),
)
def _cattaneo_traction(body: SubFigure) -> Columns:
    joint = summit()
    fields = joint.fields(0.6 * joint.slip_limit)
    x = section(joint, fields)
    r = np.abs(x)
    bound, q = joint.friction_coefficient * joint.pressure(r), fields.traction(r)
    a, c = joint.contact_radius / MICRO, fields.stick_radius / MICRO
    axes = body.subplots()
    shade(axes, fields)
    axes.plot(x / MICRO, bound / MEGA, color=INK, linestyle=STROKE, label="μp")
    axes.plot(x / MICRO, q / MEGA, color=BLUE, linewidth=2.0, label="q in partial slip")
    top = 1.18 * bound.max() / MEGA
    words(axes, "stick: q < μp", 0.0, 0.94 * top)
    for side in (-1.0, 1.0):
        words(axes, "slip:\nq = μp", side * 0.5 * (a + c), 0.92 * top)
    axes.set(xlabel="Position along the force x [µm]", ylabel="Tangential traction [MPa]")
    axes.set(xlim=(x[0] / MICRO, x[-1] / MICRO), ylim=(0.0, top))
    above = axes.secondary_xaxis("top")
    above.set_xticks([-a, -c, 0.0, c, a], ["−a", "−c", "0", "c", "a"])
    body.legend(loc="outside lower center", ncols=2)
    columns = {"x [m]": x, "friction times pressure [Pa]": bound, "tangential traction [Pa]": q}
    return columns


@as_plate(
    "19.3",
    4.6,
    "pressure and tangential traction on the surface (Mindlin)",
    "As the force grows, the slip ring with the traction μp grows inwards. Without slip the "
    "traction would be infinite at the edge under any force.",
    contact_note("First loading."),
)
def _pressure_and_traction(body: SubFigure) -> Columns:
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
    axes = body.subplots()
    axes.plot(x / MICRO, columns["pressure [Pa]"] / MEGA, color=INK, linewidth=2.0, label="p")
    bound = columns["friction times pressure [Pa]"]
    axes.plot(x / MICRO, bound / MEGA, color=INK, linestyle=STROKE, label="μp: q at T = μN")
    looks = ((GREEN, (0, (6, 2, 1, 2))), (BLUE, "-"), (RED, (0, (5, 1))))
    for share, fields, (color, line) in zip(shares, states, looks, strict=True):
        q = fields.traction(r)
        columns[f"tangential traction at T = {share:g} mu N [Pa]"] = q
        axes.plot(x / MICRO, q / MEGA, color=color, ls=line, label=f"q at T = {share:g} × μN")
    columns["without slip at T = 0.5 mu N [Pa]"] = welded
    label = "q at T = 0.5 × μN without slip"
    axes.plot(x / MICRO, welded / MEGA, color=BLUE, linestyle=DOTS, label=label)
    axes.set(xlabel="Position along the force x [µm]", ylabel="Traction [MPa]")
    axes.set(xlim=(x[0] / MICRO, x[-1] / MICRO), ylim=(0.0, 1.12 * joint.peak_pressure / MEGA))
    above = axes.secondary_xaxis("top")
    above.set_xticks([-a / MICRO, 0.0, a / MICRO], ["−a", "0", "a"])
    body.legend(loc="outside lower center", ncols=3)
    return columns


@as_plate(
    "19.10",
    3.5,
    "stick circle and slip ring of the contact",
    "Slip starts at the edge. After a reversal it starts there again in the other direction, "
    "while the ring that slipped before moves with the stick circle.",
    contact_note(),
)
def _contact_area(body: SubFigure) -> Columns:
    joint = summit()
    a = joint.contact_radius
    top, down = 0.75, 0.0
    peak = top * joint.force_limit
    states = (
        ("Loaded to T = 0.75 × μN", joint.fields(force=peak)),
        ("Unloaded to T = 0", joint.fields(force=[peak, down])),
        ("Loaded again to T = 0.4 × μN", joint.fields(force=[peak, down, 0.4 * joint.force_limit])),
    )
    rows = []
    for index, (axes, (title, fields)) in enumerate(zip(body.subplots(1, 3), states, strict=True)):
        for zone in fields.zones:
            ring: dict[str, Any] = {
                "width": (zone.outer - zone.inner) / a,
                "linewidth": 0.0,
                "edgecolor": "none",
            }
            for look in (
                ring | _fill_style(zone),
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
    return columns
