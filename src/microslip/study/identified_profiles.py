"""Floor 8: likelihood profiles of an identification, a small panel for each parameter."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from microslip._core.units import prefix
from microslip.study.drawing import log_scale, new_figure
from microslip.study.identified_figure import BLUE, RED, short

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from microslip.identification import Fitted, Identification


def profiles(result: Identification) -> Figure:
    """Draw the likelihood profile of each free parameter: the rise of chi-squared over its value.

    Parameters
    ----------
    result : Identification
        What was identified, with a profile of one parameter at least.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, with a canvas.
    """
    from scipy.special import chdtri

    level = float(chdtri(1, 1.0 - result.confidence))
    names = profiled(result)
    columns = min(len(names), 4 if len(names) == 4 else 3)
    rows = math.ceil(len(names) / columns)
    figure = new_figure(0.6 + 1.75 * rows, "")
    panels = np.ravel(figure.subplots(rows, columns, squeeze=False, sharey=True))
    for axes, name in zip(panels, names, strict=False):
        _curve(axes, name, result.parameters[name], level)
    for axes in panels[len(names) :]:
        axes.set_axis_off()
    for axes in panels[: len(names) : columns]:
        axes.set_ylabel("Rise of χ²")
    figure.legend(
        handles=[
            Line2D([], [], color=BLUE, marker="o", markersize=3.0, linewidth=1.0,
                   label="profile, and where it was computed"),
            Line2D([], [], color=RED, linestyle="--", linewidth=0.9,
                   label=f"level of {100.0 * result.confidence:g} %: {level:.2f}"),
        ],
        loc="outside lower center",
        ncols=2,
    )  # fmt: skip
    return figure


def profiled(result: Identification) -> list[str]:
    """Names of the parameters whose profile has more than the best value and an end.

    Parameters
    ----------
    result : Identification
        What was identified.

    Returns
    -------
    list of str
        Their names, in the order of the parameters.
    """
    return [name for name in result.names if len(result.parameters[name].profile) > 2]


def _curve(axes: Axes, name: str, one: Fitted, level: float) -> None:
    """One profile, as far as a little above its level."""
    x, rise = np.array(one.profile).T
    unit, letter = (1.0, "") if one.unit in ("", "-") else prefix(one.value)
    # The root of the rise is nearly straight on either side: between points it is taken so.
    root = np.copysign(np.sqrt(rise), x - one.value)
    near = rise <= 2.0 * level
    if one.value > 0.0 and one.low >= 0.0:  # an open end may be decades away
        known = [end for end in (one.low, one.value, one.high) if 0.0 < end < math.inf]
        near &= (x >= min(known) / 4.0) & (x <= 4.0 * max(known))
    first, last = float(x[near].min()), float(x[near].max())
    if last - first < 1e-6 * abs(last):  # the best value lies at a bound and nothing beside it
        first, last = 0.5 * one.value, 2.0 * one.value
    if 0.0 < first < 0.05 * last:
        log_scale(axes, "x")
        within = np.geomspace(first, last, 200)
        between = np.interp(np.log(within), np.log(x[x > 0.0]), root[x > 0.0])
    else:
        axes.locator_params(axis="x", nbins=3)
        axes.ticklabel_format(axis="x", useOffset=False)
        within = np.linspace(first, last, 200)
        between = np.interp(within, x, root)
    axes.plot(x[near] / unit, rise[near], "o", color=BLUE, markersize=3.0)
    axes.plot(within / unit, between**2, color=BLUE, linewidth=1.0)
    axes.axhline(level, color=RED, linestyle="--", linewidth=0.9)
    axes.set_ylim(0.0, 1.8 * level)
    unit_text = f" [{letter}{one.unit}]" if one.unit not in ("", "-") else ""
    axes.set_xlabel(f"{short(name, one.load)}{unit_text}")
