"""Figures 19.19 to 19.24 of the chapter: the whole interface."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.figure import SubFigure

from microslip._core.checks import Floats
from microslip._core.units import engineering
from microslip.chapter.contact import contact_note as one_summit
from microslip.chapter.contact import path, summit
from microslip.chapter.plate import (
    BLUE,
    DOTS,
    GOLD,
    GREY,
    INK,
    KILO,
    LIGHT,
    MICRO,
    PENS,
    RED,
    STROKE,
    Columns,
    as_plate,
    cross,
    words,
)
from microslip.chapter.surface import SPREAD, worked_example
from microslip.contact import GreenwoodWilliamson
from microslip.friction import Interface, Iwan


def joint_note(addition: str = "") -> str:
    """Return the assumptions of the figures of the interface as text, then ``addition``."""
    joint = worked_example()
    length = joint.slip_per_indentation * SPREAD
    return (
        "The worked example: Al 2017 on itself, E = 69 GPa, ν = 0.33, μ = 0.55, Gaussian heights "
        f"of σ = {engineering(SPREAD, 'm', trim=True)}, ρ = 1 mm, 1e8 summits per m² on 2 cm², "
        f"N = {engineering(joint.normal_load, 'N')}. μN = {engineering(joint.force_limit, 'N')}, "
        f"κσ = {engineering(length, 'm')}. {addition}"
    ).strip()


@as_plate(
    "19.19",
    4.3,
    "force against displacement of the whole interface",
    "Without the kinks of single summits: some slip while others stick, and the transition to "
    "gross slip is smooth.",
    joint_note(),
)
def _interface_loops(body: SubFigure) -> Columns:
    joint = worked_example()
    amplitudes = (0.15e-6, 0.4e-6, 1e-6, 2e-6)
    axes = body.subplots()
    columns: dict[str, Floats] = {}
    for top, look in zip(amplitudes, PENS, strict=False):
        name = f"±{engineering(top, 'm', trim=True)}"
        record = path(0.0, top, -top, top, samples=200)
        force = joint.force(record)
        columns[f"displacement to {top:g} m [m]"] = record
        columns[f"force to {top:g} m [N]"] = force
        axes.plot(record / MICRO, force / KILO, label=name, **look)
    cross(axes)
    for sign, text in ((1.0, "μN"), (-1.0, "−μN")):
        axes.axhline(sign * joint.force_limit / KILO, color=LIGHT, linestyle=STROKE, linewidth=0.9)
        words(axes, text, -2.33, 0.91 * sign * joint.force_limit / KILO, color=GREY)
    axes.set(xlabel="Tangential displacement δ [µm]", ylabel="Tangential force T [kN]")
    axes.set_xlim(-2.55, 2.55)
    body.legend(loc="outside lower center", ncols=4)
    return columns


def with_summits(joint: Interface, count: float) -> Interface:
    """Return the joint with another number of summits N_a on the same area, at the same load."""
    surface = joint.surface
    if not isinstance(surface, GreenwoodWilliamson):
        raise TypeError(type(surface).__name__)
    changed = GreenwoodWilliamson(
        surface.pair, surface.heights, surface.radius, count / surface.area, surface.area
    )
    return Interface(changed, joint.friction_coefficient, joint.normal_load)


@as_plate(
    "19.20",
    4.6,
    "number of asperities in contact at one normal load",
    "One asperity that carries the whole load is soft, and 1 µm is far below its slip limit. The "
    "more asperities share the load, the stiffer the joint is, and the closer its loop is to "
    "Coulomb's rectangle. From one asperity to the 5700 of 20 000 that touch in the worked example "
    "the stiffness grows 271-fold, and the energy over that of Coulomb friction, E_d/4μNδ, grows "
    "from 0.001 to 0.670.",
    joint_note("Amplitude 1 µm. The density of summits is changed, nothing else."),
)
def _number_of_asperities(body: SubFigure) -> Columns:
    joint = worked_example()
    top = 1e-6
    axes = body.subplots()
    record = path(top, -top, top, samples=200)
    columns = {"displacement [m]": record}
    for count, look in zip((1.0, 100.0, 500.0, 2000.0, 20000.0), PENS, strict=True):
        law = with_summits(joint, count)
        force = law.force(record)
        columns[f"force with {count:g} asperities [N]"] = force
        touching = round(law.contact_count or 0.0)
        label = f"{touching}" if touching == count else f"{touching} of {count:.0f}"
        axes.plot(record / MICRO, force / KILO, label=label, **look)
    box = joint.force_limit / KILO
    axes.plot(
        [-1.0, 1.0, 1.0, -1.0, -1.0], [box, box, -box, -box, box],
        color=GOLD, linewidth=1.1, label="Coulomb", zorder=1.9,
    )  # fmt: skip
    cross(axes)
    axes.set(xlabel="Tangential displacement δ [µm]", ylabel="Tangential force T [kN]")
    body.legend(loc="outside lower center", ncols=3, title="Asperities in contact")
    return columns


@as_plate(
    "19.21",
    4.6,
    "Coulomb's law, Iwan's cells and one asperity",
    "The distribution of the cells matters, not their number. Cells fitted to the sliders of the "
    "asperity converge to it with their number; evenly spread cells of the same stiffness and "
    "limit converge to a parabola that differs by 7 % of μN. Every EGM is an Iwan model, also "
    "that of a single asperity.",
    one_summit("Amplitude 1.6 δL; 1, 3 and 12 cells as Asperity.to_iwan gives them."),
)
def _iwan_and_coulomb(body: SubFigure) -> Columns:
    joint = summit()
    top = 1.6 * joint.slip_limit
    axes = body.subplots()
    record = path(top, -top, top, samples=300)
    columns = {"displacement [m]": record}
    box = np.array([-1.0, 1.0, 1.0, -1.0, -1.0]), np.array([1.0, 1.0, -1.0, -1.0, 1.0])
    axes.plot(
        box[0] * top / MICRO, box[1] * joint.force_limit, color=GOLD, linewidth=1.1, label="Coulomb"
    )
    for cells, look in ((1, PENS[3]), (3, PENS[2]), (12, PENS[1])):
        force = joint.to_iwan(cells).force(record)
        columns[f"force of {cells} cells [N]"] = force
        label = f"Iwan, {cells} cells" if cells > 1 else "Jenkins: one cell"
        # The asperity nearly covers the line of 12 cells, which is therefore wider.
        width = 2.8 if cells == 12 else 1.4
        axes.plot(record / MICRO, force, linewidth=width, label=label, **look)
    # Cells of the same stiffness and force limit, with evenly spaced yield displacements.
    share = joint.tangential_stiffness / 1000
    yields = (np.arange(1000) + 0.5) / 1000 * 2.0 * joint.force_limit / joint.tangential_stiffness
    even = Iwan(np.full(1000, share), share * yields).force(record)
    columns["force of 1000 even cells [N]"] = even
    axes.plot(record / MICRO, even, label="Iwan, 1000 cells, evenly spread", **PENS[4])
    columns["force of one asperity [N]"] = joint.force(record)
    axes.plot(
        record / MICRO, columns["force of one asperity [N]"], color=INK, linewidth=1.0,
        label="one asperity",
    )  # fmt: skip
    cross(axes)
    axes.set(xlabel="Tangential displacement δ [µm]", ylabel="Tangential force T [N]")
    axes.set_ylim(-1.15 * joint.force_limit, 1.15 * joint.force_limit)
    body.legend(loc="outside lower center", ncols=3)
    return columns


@as_plate(
    "19.23",
    5.4,
    "dissipated energy against amplitude",
    "Cubic for small amplitudes, linear in full sliding. The local exponent falls from 3 to 1 and "
    "passes the chapter's parabola, exponent 2, at one amplitude only.",
    joint_note(),
)
def _dissipated_energy(body: SubFigure) -> Columns:
    joint = worked_example()
    a: Floats = np.geomspace(1e-9, 1e-4, 400)
    lost, exponent = joint.dissipated_energy(a), joint.dissipation_exponent(a)
    cubic = 2.0 / 3.0 * joint.sliders().density(0.0) * a**3
    linear = 4.0 * joint.force_limit * a
    above, below = body.subplots(2, 1, sharex=True, height_ratios=[2.0, 1.0])
    above.plot(a / MICRO, lost, color=BLUE, linewidth=2.0, label="the model")
    near = cubic < 30.0 * lost
    above.plot(
        a[near] / MICRO, cubic[near], color=INK, linestyle=STROKE, linewidth=1.0,
        label="cubic, small amplitudes",
    )  # fmt: skip
    near = linear < 300.0 * lost
    above.plot(
        a[near] / MICRO, linear[near], color=RED, linestyle=DOTS,
        label=r"4$\,$μN$\,δ_m$, full sliding",
    )  # fmt: skip
    above.set_xscale("log")
    above.set_yscale("log")
    above.set(ylabel="Energy per cycle [J]")
    below.plot(a / MICRO, exponent, color=BLUE, linewidth=2.0)
    below.axhline(2.0, color=LIGHT, linestyle=STROKE, linewidth=0.9)
    words(below, "a parabola", 2e-3, 2.0, color=GREY)
    below.set(xlabel=r"Displacement amplitude $δ_m$ [µm]", ylabel="Local exponent [–]")
    below.set_ylim(0.8, 3.2)
    body.align_ylabels([above, below])
    body.legend(loc="outside lower center", ncols=3)
    columns = {"amplitude [m]": a, "dissipated energy [J]": lost, "local exponent": exponent}
    return columns


@as_plate(
    "19.24",
    4.2,
    "the chapter's damping ratio, which is the loss factor",
    "It grows with the amplitude towards 4/π, the value of Coulomb friction. It is "
    "the loss factor; the ratio to critical damping is half of it (scale on the right).",
    joint_note("Other loads: the same surface."),
)
def _damping_ratio(body: SubFigure) -> Columns:
    a = np.geomspace(1e-9, 1e-4, 400)
    axes = body.subplots()
    columns = {"amplitude [m]": a}
    for load, look in zip((500.0, 2000.0, 5000.0), PENS, strict=False):
        eta = columns[f"loss factor at {load:g} N"] = worked_example(load).loss_factor(a)
        axes.plot(a / MICRO, eta, label=engineering(load, "N", trim=True), **look)
    top = 4.0 / math.pi
    axes.axhline(top, color=LIGHT, linestyle=STROKE, linewidth=0.9)
    words(axes, "rigid–plastic: 4/π", 3e-3, top, color=GREY)
    axes.set_xscale("log")
    axes.set(xlabel=r"Displacement amplitude $δ_m$ [µm]", ylabel="ξ of (19.30): loss factor η [–]")
    axes.set_ylim(0.0, 1.4)
    to_ratio: Any = (lambda y: 0.5 * y, lambda y: 2.0 * y)
    right = axes.secondary_yaxis("right", functions=to_ratio)
    right.set_ylabel("Damping ratio ζ = η/2 [–]")
    body.legend(loc="outside lower center", ncols=3, title="Normal load")
    return columns
