"""Floor 8: measured and modelled loops over each other, in the manner of Fig. 19.22."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib import style
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from microslip._core.units import engineering, prefix
from microslip.identification.verdicts import AT_A_LOAD
from microslip.study.drawing import STYLE, length_prefix, log_scale, new_figure, note, settle
from microslip.study.identified_tables import label
from microslip.study.result import some

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from microslip.identification import Fitted, Identification

Floats = NDArray[np.float64]

MOST_PANELS = 6
MOST_PARAMETERS = 12
MOST_MARKS = 90  # of a loop
MOST_DOTS = 1500  # of a panel
_SYMBOLS = {
    "friction_coefficient": "μ",
    "slip_scale": "κσ",
    "standardised_separation": "h",
    "rig_stiffness": "rig",
    "force_limit": "μN",
    "contact_area": "area",
}
BLUE, _INK, RED, _GREY, _BAND = "#0072B2", "#000000", "#D55E00", "#888888", "#e6e6e6"


class Shown(NamedTuple):
    """What is drawn of one record."""

    load: float | None
    x: Floats
    """Displacement of a cycle [m]."""
    force: Floats
    """Measured force [N]."""
    model: Floats
    """Force of the model [N]."""
    residual: Floats
    """Measured minus model [N]."""
    error: float
    """Standard error of a measured force [N]."""


def shown(result: Identification) -> list[Shown]:
    """What is drawn of the records of an identification."""
    return [
        Shown(
            record.normal_load,
            record.displacement,
            record.measured,
            record.model,
            record.residual,
            float(np.median(record.error)),
        )
        for record in result.records
    ]


def panels(records: Sequence[Shown]) -> list[tuple[str, list[Shown]]]:
    """Records by their load, lightest first: what a panel is called, and its records."""
    by_load: dict[str, list[Shown]] = {}
    for record in sorted(records, key=lambda r: math.inf if r.load is None else r.load):
        name = "Load unknown" if record.load is None else f"N = {engineering(record.load, 'N')}"
        by_load.setdefault(name, []).append(record)
    return list(by_load.items())


def loops(result: Identification) -> Figure:
    """Draw measured and modelled loops over each other, and what is left below.

    Parameters
    ----------
    result : Identification
        What was identified.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, with a canvas: one pair of panels for each normal load.
    """
    records = shown(result)
    groups = panels(records)
    drawn = [groups[i] for i in some(len(groups), MOST_PANELS)]
    columns = min(len(drawn), 3)
    rows = math.ceil(len(drawn) / columns)
    figure = new_figure(0.7 + (4.6 if columns == 1 else 3.3) * rows, "")
    ratios = [2.2, 1.0] * rows
    axes = np.atleast_2d(
        figure.subplots(2 * rows, columns, height_ratios=ratios, squeeze=False, sharex="col")
    )
    x_unit, x_letter = length_prefix(max(float(np.abs(r.x - r.x.mean()).max()) for r in records))
    f_unit, f_letter = prefix(max(float(np.abs(r.force).max()) for r in records))
    rest = max(float(np.abs(r.residual).max()) for r in records)
    r_unit, r_letter = prefix(max(rest, *(3.0 * r.error for r in records)))
    for index, (name, group) in enumerate(drawn):
        above, below = axes[2 * (index // columns) : 2 * (index // columns) + 2, index % columns]
        _pair(above, below, group, x_unit, f_unit, r_unit)
        note(above, name if len(drawn) > 1 or group[0].load is not None else "")
        below.set_xlabel(f"Displacement [{x_letter}m]")
        above.tick_params(labelbottom=False)
        if index % columns == 0:
            above.set_ylabel(f"Force [{f_letter}N]")
            below.set_ylabel(f"Residual [{r_letter}N]")
    for index in range(len(drawn), rows * columns):
        for row in (0, 1):
            axes[2 * (index // columns) + row, index % columns].set_axis_off()
    figure.align_ylabels(list(axes[:, 0]))
    left_out = len(groups) - len(drawn)
    figure.legend(
        handles=[
            Line2D([], [], linestyle="none", marker="o", color=BLUE, markerfacecolor="none",
                   markersize=3.5, label="measured, mean cycle"),
            Line2D([], [], color=_INK, label=f"identified: {result.law}, rig in series"
                   if _has_rig(result) else f"identified: {result.law}"),
            *(
                Line2D([], [], linestyle="none", marker=marker, color=color, markersize=3.0,
                       markerfacecolor="none", label=f"residual, displacement {way}")
                for marker, color, way in (("o", BLUE, "rising"), ("^", RED, "falling"))
            ),
            Patch(facecolor=_BAND, edgecolor=_GREY, linewidth=0.5, label="noise, ±2 σ"),
        ],
        loc="outside lower center",
        ncols=3,
        title=f"{left_out} more loads are in the tables" if left_out else None,
        title_fontsize=8.5,
    )  # fmt: skip
    return figure


def _has_rig(result: Identification) -> bool:
    return any(name.startswith("rig_stiffness") for name in result.parameters)


def _pair(
    above: Axes, below: Axes, group: Sequence[Shown], x_unit: float, f_unit: float, r_unit: float
) -> None:
    """The loops of one load, and what is left of them."""
    most = max(MOST_DOTS // len(group), 40)
    for record in group:
        x = (record.x - 0.5 * (record.x.max() + record.x.min())) / x_unit
        marks = _along(x, record.force, MOST_MARKS)
        above.plot(
            x[marks], record.force[marks] / f_unit, "o", color=BLUE, markersize=3.0,
            markerfacecolor="none", markeredgewidth=0.7,
        )  # fmt: skip
        closed = np.append(np.arange(x.size), 0)
        above.plot(x[closed], record.model[closed] / f_unit, color=_INK, linewidth=1.1)
        dots = some(x.size, most)
        rest = record.residual[dots] / r_unit
        turn = np.gradient(record.x)[dots] < 0.0
        for part, color, marker in ((~turn, BLUE, "o"), (turn, RED, "^")):
            below.plot(
                x[dots][part], rest[part], marker, color=color, markersize=2.4,
                markerfacecolor="none", markeredgewidth=0.5,
            )  # fmt: skip
    band = 2.0 * max(record.error for record in group) / r_unit
    below.axhspan(-band, band, facecolor=_BAND, edgecolor="none", zorder=0)
    for axes in (above, below):
        axes.axhline(0.0, color=_GREY, linewidth=0.6, zorder=1)
    above.axvline(0.0, color=_GREY, linewidth=0.6, zorder=1)
    above.margins(0.06)


def _along(x: Floats, y: Floats, count: int) -> NDArray[np.int64]:
    """Places that are evenly spaced along a curve, whatever the times between its samples."""
    steps = np.hypot(np.diff(x) / max(float(np.ptp(x)), 1e-300), np.diff(y) / float(np.ptp(y)))
    length = np.concatenate(([0.0], np.cumsum(steps)))
    return np.unique(np.searchsorted(length, np.linspace(0.0, length[-1], count)))


def intervals(result: Identification) -> Figure:
    """Draw the interval of each free parameter on a scale of its own, and the correlations.

    Parameters
    ----------
    result : Identification
        What was identified, with at least one free parameter and at most MOST_PARAMETERS.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, with a canvas.
    """
    names = result.names
    figure = new_figure(1.3 + 0.62 * len(names), "")
    several = len(names) > 1
    parts = np.ravel(
        np.asarray(figure.subfigures(1, 1 + several, width_ratios=[1.25, 1.0][: 1 + several]))
    )
    strips = np.ravel(parts[0].subplots(len(names), 1, squeeze=False))
    for axes, name in zip(strips, names, strict=True):
        _strip(axes, name, result.parameters[name])
    parts[0].suptitle(
        f"Best values and {100.0 * result.confidence:g} % intervals (arrow: no end)", fontsize=8.5
    )
    if several:
        symbols = [short(name, result.parameters[name].load) for name in names]
        _heat_map(parts[1].subplots(), symbols, result.correlation)
        parts[1].suptitle("Correlations of the errors", fontsize=8.5)
    return figure


def _strip(axes: Axes, name: str, one: Fitted) -> None:
    """One interval on its own axis, which reaches a little beyond it."""
    open_low, open_high = one.low_open, one.high_open
    known = one.high if open_low and not open_high else one.low if open_high else one.value
    unit, letter = (1.0, "") if one.unit in ("", "-") else prefix(known)
    value, low, high = (v / unit for v in (one.value, one.low, one.high))
    left, right = _ends(value, low, high, open_low, open_high)
    logarithmic = 0.0 < left < 0.1 * right
    color = BLUE if one.verdict == "identified" else RED
    axes.plot([left, right], [0.0, 0.0], color=color, linewidth=2.0, solid_capstyle="butt")
    for end, is_open, way in ((left, open_low, "<"), (right, open_high, ">")):
        axes.plot([end], [0.0], way if is_open else "|", color=color, markersize=7.0,
                  markeredgewidth=1.5)  # fmt: skip
    if left <= value <= right and not (open_low and open_high):
        axes.plot([value], [0.0], "o", color=color, markerfacecolor="white", markersize=5.0)
    if logarithmic:
        log_scale(axes, "x")
        axes.set_xlim(left / (right / left) ** 0.25, right * (right / left) ** 0.25)
    else:
        width = (right - left) or max(abs(value), 1.0)
        axes.set_xlim(left - 0.25 * width, right + 0.25 * width)
        axes.locator_params(axis="x", nbins=4)
        axes.ticklabel_format(axis="x", useOffset=False)
    axes.set_ylim(-1.0, 1.0)
    axes.set_yticks([])
    for side in ("left", "right", "top"):
        axes.spines[side].set_visible(False)
    unit_text = f" [{letter}{one.unit}]" if one.unit not in ("", "-") else ""
    verdict = "" if one.verdict == "identified" else f": {one.verdict}"
    note(axes, f"{label(name, one.load)}{unit_text}{verdict}")


def _ends(
    value: float, low: float, high: float, open_low: bool, open_high: bool
) -> tuple[float, float]:
    """Where the line of an interval begins and ends; without an end it goes on for a while."""
    if open_low and open_high:
        return (0.5 * value, 2.0 * value) if value > 0.0 else (value - 1.5, value + 1.5)
    if open_low:
        return (0.5 * high if high > 0.0 else high - 1.5), high
    if open_high:
        return low, (2.0 * low if low > 0.0 else low + 1.5)
    return low, high


def _heat_map(axes: Axes, symbols: Sequence[str], matrix: Floats) -> None:
    """Correlations as colours and numbers; the lower half, since both are the same."""
    shown_part = np.where(np.tri(len(symbols), k=-1) > 0.0, matrix, np.nan)[1:, :-1]
    axes.imshow(shown_part, cmap="PuOr", vmin=-1.0, vmax=1.0)
    for i, j in np.argwhere(np.isfinite(shown_part)):
        value = float(shown_part[i, j])
        axes.text(
            j, i, f"{value:+.2f}".replace("-", "−"), ha="center", va="center", fontsize=8.0,
            color="white" if abs(value) > 0.7 else "black",
        )  # fmt: skip
    axes.set_xticks(range(len(symbols) - 1), symbols[:-1], rotation=30.0, ha="right")
    axes.set_yticks(range(len(symbols) - 1), symbols[1:])
    axes.grid(visible=False)
    axes.tick_params(length=0.0)
    for spine in axes.spines.values():
        spine.set_visible(False)


def short(name: str, load: float | None = None) -> str:
    """The symbol of a parameter, or its words, with the load [N] it belongs to."""
    text = label(name, load)
    key, _, rest = name.partition(" ")
    if load is not None and not rest and key in AT_A_LOAD:
        rest = f"at {engineering(load, 'N', 4, trim=True)}"
    symbol = _SYMBOLS.get(key)
    return text if symbol is None else f"{symbol} {rest}".rstrip()


def write(result: Identification, folder: Path) -> list[str]:
    """Draw the figures and write them as SVG and PNG.

    Parameters
    ----------
    result : Identification
        What was identified.
    folder : pathlib.Path
        An existing folder.

    Returns
    -------
    list of str
        The names of the files.

    Raises
    ------
    OSError
        If a file cannot be written.
    """
    names = []
    # From matplotlib's own defaults, whatever the user's matplotlibrc says.
    with style.context(["default", STYLE]):
        for stem, figure in drawings(result):
            settle(figure)
            # No dates: the same records give the same files.
            figure.savefig(folder / f"{stem}.svg", metadata={"Date": None, "Creator": None})
            figure.savefig(folder / f"{stem}.png", metadata={"Software": None})
            names += [f"{stem}.svg", f"{stem}.png"]
    return names


def drawings(result: Identification) -> list[tuple[str, Figure]]:
    """The figures of an identification and the stems of their files."""
    from microslip.study.identified_profiles import profiled, profiles

    found = [("loops", loops(result))]
    if 1 <= len(result.names) <= MOST_PARAMETERS:
        found.append(("intervals", intervals(result)))
        if profiled(result):
            found.append(("profiles", profiles(result)))
    return found
