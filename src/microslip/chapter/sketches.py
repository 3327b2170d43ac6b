"""Sketches of chapter 19 without scale and data: figures 19.1, 19.4, 19.8 and 19.9."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import SubFigure
from matplotlib.patches import Circle, Polygon, Rectangle

from microslip._core.checks import Floats
from microslip.chapter.plate import (
    BLUE,
    GREY,
    INK,
    LIGHT,
    RED,
    STROKE,
    Columns,
    arrow,
    as_plate,
    words,
)

METAL, DARK, PALE = "#e3e3e3", "#bdbdbd", "#f4f4f4"
_EDGE = {"edgecolor": INK, "linewidth": 0.9}


def _blank(axes: Axes, width: float, height: float, title: str = "", bottom: float = 0.0) -> None:
    axes.set(xlim=(0.0, width), ylim=(bottom, height), title=title)
    axes.set_aspect("equal")
    axes.axis("off")


def _box(
    axes: Axes, x: float, y: float, width: float, height: float, color: str = METAL, **look: object
) -> None:
    options = {"facecolor": color, **_EDGE, **look}
    axes.add_patch(Rectangle((x, y), width, height, **options))  # type: ignore[arg-type]


def _support(axes: Axes, x: float, y: float, width: float) -> None:
    depth = 0.18
    _box(axes, x, y - depth, width, depth, "none", linewidth=0.0, hatch="////")
    axes.plot([x, x + width], [y, y], color=INK, linewidth=1.2)


def _rigid(axes: Axes, x: float, y: float, width: float, height: float) -> None:
    look = {"linewidth": 0.0, "hatch": "///", "edgecolor": LIGHT, "zorder": 0.5}
    _box(axes, x, y, width, height, "none", **look)


def _interface(axes: Axes, start: tuple[float, float], end: tuple[float, float]) -> None:
    axes.plot(
        *zip(start, end, strict=True), color=RED, linewidth=2.6, solid_capstyle="butt", zorder=3
    )


@as_plate(
    "19.1",
    2.45,
    "joints that damp",
    "Wherever two clamped surfaces (red) are sheared, they slip at their edges long before "
    "they slide.",
    "A sketch.",
)
def _joints(body: SubFigure) -> Columns:
    first, second, third = body.subplots(1, 3)

    _blank(first, 6.0, 4.95, "(a) bolted lap joint", 1.05)
    _box(first, 0.9, 2.5, 2.9, 0.6)
    _box(first, 2.2, 1.9, 2.9, 0.6)
    _interface(first, (2.2, 2.5), (3.8, 2.5))
    for x in (2.65, 3.35):
        _box(first, x - 0.1, 1.72, 0.2, 1.56, DARK)
        _box(first, x - 0.22, 3.1, 0.44, 0.22, DARK)
        _box(first, x - 0.22, 1.68, 0.44, 0.22, DARK)

    _blank(second, 6.0, 4.95, "(b) press fit", 1.05)
    _box(second, 2.55, 1.3, 0.9, 2.7)
    for x, sign in ((1.35, 1.0), (3.45, -1.0)):
        _box(second, x, 1.5, 1.2, 1.7)
        edge = x + (1.2 if sign > 0 else 0.0)
        _interface(second, (edge, 1.5), (edge, 3.2))
        outer = x if sign > 0 else x + 1.2
        for y in (1.8, 2.35, 2.9):
            arrow(second, (outer - 0.75 * sign, y), (outer, y))
        words(second, "p", outer - 0.45 * sign, 3.25)
        _support(second, x, 1.5, 1.2)
    arrow(second, (3.0, 4.85), (3.0, 4.0))
    words(second, "F", 3.35, 4.5)

    _blank(third, 6.0, 4.95, "(c) lap shear joint", 1.05)
    _box(third, 0.9, 2.5, 3.1, 0.6)
    _box(third, 2.0, 1.9, 3.1, 0.6)
    _interface(third, (2.0, 2.5), (4.0, 2.5))
    for x in np.linspace(2.15, 3.85, 5):
        arrow(third, (x, 3.85), (x, 3.1))
        arrow(third, (x, 1.15), (x, 1.9))
    words(third, "p", 4.2, 3.55)
    words(third, "p", 1.8, 1.45)
    for axes in (first, third):
        arrow(axes, (0.9, 2.8), (0.1, 2.8))
        arrow(axes, (5.1, 2.2), (5.9, 2.2))
        words(axes, "F", 0.5, 3.1)
        words(axes, "F", 5.5, 2.5)
    return {}


@as_plate(
    "19.4",
    3.7,
    "the tribometer",
    "The jack moves the lower sample under the fixed upper one. The sensors enclose more "
    "than the contact, so every record includes the compliance of the rig.",
    "A sketch of the principle after the chapter's section 2.1, not of the machine; the place "
    "of the force cell is assumed.",
)
def _tribometer(body: SubFigure) -> Columns:
    axes = body.subplots()
    _blank(axes, 12.0, 5.6)
    _support(axes, 0.3, 0.55, 11.4)
    # In line: the jack with its transducer, the force cell and the moving sample.
    _box(axes, 0.5, 1.35, 2.7, 1.3, METAL)
    _box(axes, 0.9, 0.55, 0.5, 0.8, DARK)
    _box(axes, 2.3, 0.55, 0.5, 0.8, DARK)
    _box(axes, 1.75, 1.35, 0.25, 1.3, DARK)
    _box(axes, 2.0, 1.86, 2.2, 0.28, DARK)
    _box(axes, 0.15, 1.9, 1.6, 0.2, PALE, linestyle="--")
    _box(axes, 4.2, 1.55, 0.9, 0.9, "#cfe3f1")
    _box(axes, 5.1, 1.86, 0.6, 0.28, DARK)
    _box(axes, 5.7, 1.5, 3.1, 0.95, METAL)
    for x in (6.0, 6.75, 7.5, 8.25):
        axes.add_patch(Circle((x + 0.12, 1.36), 0.14, facecolor="white", **_EDGE))
    _box(axes, 5.5, 0.55, 3.5, 0.67, DARK)
    # Above: the fixed sample under a constant load.
    _box(axes, 6.75, 2.45, 1.0, 0.3, PALE)
    _box(axes, 6.75, 2.75, 1.0, 0.3, PALE)
    _interface(axes, (6.75, 2.75), (7.75, 2.75))
    _box(axes, 6.3, 3.05, 1.9, 0.7, METAL)
    _box(axes, 8.2, 3.2, 1.9, 0.35, DARK)
    _box(axes, 10.1, 0.55, 0.6, 3.6, DARK)
    arrow(axes, (7.25, 4.85), (7.25, 3.75), linewidth=1.8)
    arrow(axes, (4.2, 2.95), (5.1, 2.95), double=True, linewidth=1.6)
    words(axes, "static normal load $F_n$", 7.25, 5.15)
    words(axes, "tangential load $F_t$", 4.3, 3.3)
    words(axes, "hydraulic jack", 2.1, 3.05)
    words(axes, "LVDT", 0.75, 2.35, fontsize=8)
    words(axes, "force cell", 4.65, 1.2, fontsize=8)
    words(axes, "guide", 5.0, 0.85, fontsize=8)
    words(axes, "frame, stiff along the motion", 10.35, 4.45, fontsize=8)
    axes.annotate(
        "contact of the samples, 2 cm²", (6.75, 2.75), (5.9, 4.3), fontsize=8, ha="right",
        arrowprops={"arrowstyle": "-", "color": RED, "linewidth": 0.9},
        bbox={"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none"},
    )  # fmt: skip
    return {}


def _cap(center: float, top: float, radius: float, floor: float) -> tuple[Floats, Floats]:
    reach = math.sqrt(2.0 * radius * (top - floor))
    x = np.linspace(-reach, reach, 121)
    return center + x, top - x**2 / (2.0 * radius)


@as_plate(
    "19.8",
    3.1,
    "a rough surface against a rigid plane",
    "Only summits above the separation touch; each is indented by its height above it.",
    "A sketch: heights are exaggerated against widths.",
)
def _rough_surface(body: SubFigure) -> Columns:
    axes = body.subplots()
    _blank(axes, 12.0, 4.3)
    plane, mean, floor, radius = 2.9, 1.75, 0.7, 0.55
    tops = (1.35, 2.2, 3.2, 1.9, 2.55, 3.35, 1.6, 2.45, 3.1, 1.95)
    centers = np.linspace(1.25, 10.75, len(tops)) + 0.1 * np.array(
        [0, 2, -1, 1, -2, 1, 2, -1, 0, -1]
    )
    grid = np.linspace(0.3, 11.7, 4000)
    surface = np.full_like(grid, floor)
    for center, top in zip(centers, tops, strict=True):
        surface = np.maximum(surface, top - (grid - center) ** 2 / (2.0 * radius))
    # The undeformed outline of indented summits is dashed above the plane.
    for center, top in zip(centers, tops, strict=True):
        if top > plane:
            x, y = _cap(center, top, radius, plane)
            axes.plot(x, y, color=GREY, linestyle=STROKE, linewidth=1.0, zorder=5)
            half = math.sqrt(2.0 * radius * (top - plane))
            _interface(axes, (center - half, plane), (center + half, plane))
    pressed = np.minimum(surface, plane)
    outline = np.column_stack((np.r_[grid[0], grid, grid[-1]], np.r_[0.15, pressed, 0.15]))
    axes.add_patch(Polygon(outline, closed=True, facecolor=METAL, edgecolor="none"))
    axes.plot(grid, pressed, color=INK, linewidth=1.1)
    _rigid(axes, 0.3, plane, 11.4, 0.85)
    axes.plot([0.3, 11.7], [plane, plane], color=INK, linewidth=1.3, zorder=2.5)
    axes.plot([0.3, 11.7], [mean, mean], color=BLUE, linestyle=STROKE, linewidth=1.1)
    words(axes, "rigid plane", 1.5, plane + 0.5)
    words(axes, "zero of the heights", 9.3, mean - 0.25, color=BLUE, fontsize=8)
    arrow(axes, (0.62, mean), (0.62, plane), double=True, linewidth=0.9)
    words(axes, "$δ_n$", 0.62, 0.5 * (mean + plane))
    middle = float(centers[5])
    arrow(axes, (middle, mean), (middle, tops[5]), double=True, linewidth=0.9)
    words(axes, "$y_i$", middle, 0.5 * (mean + plane))
    arrow(axes, (middle + 0.85, tops[5] + 0.35), (middle + 0.85, tops[5]), linewidth=0.9)
    arrow(axes, (middle + 0.85, plane - 0.35), (middle + 0.85, plane), linewidth=0.9)
    axes.plot([middle, middle + 1.0], [tops[5]] * 2, color=INK, linewidth=0.6, zorder=4)
    words(axes, "$δ_{ni}$", middle + 1.2, 0.5 * (tops[5] + plane))
    low = float(centers[7])
    arrow(axes, (low, tops[7] - radius), (low + 0.3, tops[7] - 0.075), linewidth=0.9)
    words(axes, "ρ", low - 0.08, tops[7] - 0.35)
    return {}


@as_plate(
    "19.9",
    3.9,
    "the contact of one asperity",
    "The sphere is pressed in by δ_ni over a circle of radius a_i, which is narrower than "
    "where the plane would cut it.",
    "A sketch.",
)
def _single_asperity(body: SubFigure) -> Columns:
    axes = body.subplots()
    _blank(axes, 10.0, 5.6)
    radius, plane, depth, center = 2.6, 3.3, 0.42, 4.6
    angle = np.linspace(math.radians(205.0), math.radians(-25.0), 400)
    x = center + radius * np.cos(angle)
    y = plane + depth - radius + radius * np.sin(angle)
    outline = np.column_stack((x, np.minimum(y, plane)))
    axes.add_patch(Polygon(outline, closed=True, facecolor=METAL, edgecolor="none"))
    axes.plot(x, np.minimum(y, plane), color=INK, linewidth=1.2)
    above = y > plane
    axes.plot(x[above], y[above], color=GREY, linestyle=STROKE, linewidth=1.0, zorder=5)
    # Hertz: the contact radius is that of the undeformed cut over the square root of two.
    half = math.sqrt(radius * depth)
    _rigid(axes, 0.6, plane, 8.4, 0.75)
    axes.plot([0.6, 9.0], [plane, plane], color=INK, linewidth=1.3)
    _interface(axes, (center - half, plane), (center + half, plane))
    bottom = plane + depth - radius
    arrow(axes, (center, bottom), (center - 2.17, bottom + 1.43), linewidth=0.9)
    axes.plot([center], [bottom], "+", color=INK, markersize=7)
    words(axes, "ρ", center - 1.2, bottom + 0.8)
    for sign in (-1.0, 1.0):
        axes.plot([center + sign * half] * 2, [plane - 0.1, plane - 0.75], color=INK, linewidth=0.6)
    axes.plot([center] * 2, [plane - 0.1, plane - 0.75], color=INK, linewidth=0.6)
    arrow(axes, (center, plane - 0.6), (center + half, plane - 0.6), double=True, linewidth=0.9)
    words(axes, "$a_i$", center + 0.5 * half, plane - 0.6)
    axes.plot([center, center + 3.1], [plane + depth] * 2, color=INK, linewidth=0.6)
    arrow(axes, (center + 2.9, plane + depth + 0.5), (center + 2.9, plane + depth), linewidth=0.9)
    arrow(axes, (center + 2.9, plane - 0.5), (center + 2.9, plane), linewidth=0.9)
    words(axes, "$δ_{ni}$", center + 3.35, plane + 0.5 * depth)
    arrow(axes, (center, 5.4), (center, plane + depth + 0.25), linewidth=1.8)
    words(axes, "$N_i$", center + 0.4, 5.0)
    arrow(axes, (1.0, 4.45), (2.5, 4.45), linewidth=1.8)
    words(axes, "$T_i, δ_{ti}$", 1.7, 4.8)
    words(axes, "rigid plane", 1.7, 3.68)
    arrow(axes, (0.9, 0.7), (1.9, 0.7), linewidth=0.9)
    arrow(axes, (0.9, 0.7), (0.9, 1.7), linewidth=0.9)
    words(axes, "x", 2.1, 0.7)
    words(axes, "y", 0.9, 1.95)
    return {}
