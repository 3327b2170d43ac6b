"""Floor 8: roughness and its density in the manner of Fig. 19.6 of the chapter."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from microslip._core.units import prefix, significant
from microslip.study.drawing import DASHES, length_prefix, log_scale, new_figure, note

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from microslip.study.scanned import Findings

_BLUE, _ORANGE, _GREEN, _BLACK = "#0072B2", "#D55E00", "#009E73", "#000000"
_SOFT = "#bcd9ea"
MOST_BINS = 160
_FINE = 301
_NARROW = 0.4
"""Share of the range below which the bulk of the heights has a range of its own."""
_LOOKS = ((_ORANGE, DASHES), (_GREEN, (0, (1, 1))))


def draw(found: Findings) -> Figure:
    """Draw a trace and the density of all heights with its fits, in percent and its logarithm.

    Parameters
    ----------
    found : Findings
        What was found.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, with a canvas.
    """
    fit, scan = found.fit, found.scan
    mean = fit.statistics.mean
    low, high = _range(scan.heights)
    unit, letter = prefix(max(high - mean, mean - low))
    figure = new_figure(3.9, found.title("Heights and their density"))
    left, middle, right = figure.subplots(1, 3, width_ratios=[1.9, 1.0, 1.0])
    row = scan.heights if scan.is_profile else scan.heights[scan.heights.shape[0] // 2]
    x_unit, x_letter = length_prefix(scan.size[0])
    places = scan.pixel[0] / x_unit * np.arange(row.size)
    left.plot(places, (row - mean) / unit, color=_BLUE, linewidth=0.8)
    left.margins(x=0.0)
    left.set_xlabel(f"Position [{x_letter}m]")
    left.set_ylabel(f"Height above the mean [{letter}m]")
    beyond = np.count_nonzero((scan.heights < low) | (scan.heights > high))
    share = significant(100.0 * beyond / fit.statistics.count, 2)
    where = "(a) trace" if scan.is_profile else "(a) middle row"
    note(left, where + (f"; {share} % beyond" if beyond else ""))
    percent = 100.0 * unit
    others = [one for one in fit.fits if one is not fit.gaussian]
    best = sorted(others, key=lambda one: one.share)[:2]
    bulk = _bulk(scan.heights, low, high)
    for axes, (bottom, top) in ((middle, bulk or (low, high)), (right, (low, high))):
        edges = np.linspace(bottom, top, _bins(fit.statistics.count) + 1)
        counts, _ = np.histogram(scan.heights, edges)
        density = percent * counts / (fit.statistics.count * np.diff(edges))
        steps = (edges - mean) / unit
        height = np.linspace(bottom, top, _FINE)
        y = (height - mean) / unit
        axes.set_ylim(steps[0], steps[-1])
        most = float(density.max())
        if axes is middle:
            axes.set_xlim(0.0, 1.1 * max(most, float(fit.gaussian.density(mean)) * percent))
        else:
            log_scale(axes, "x")
            axes.set_xlim(1e-4 * most, 2.0 * most)
            left.set_ylim(axes.get_ylim())
        axes.stairs(density, steps, orientation="horizontal", fill=True, facecolor=_SOFT,
                    edgecolor="none", label="all heights")  # fmt: skip
        axes.plot(fit.gaussian.density(height) * percent, y, color=_BLACK,
                  label=f"Gaussian ({100.0 * fit.gaussian.share:.2g} % missed)")  # fmt: skip
        for one, (colour, line) in zip(best, _LOOKS, strict=False):
            name = one.name.replace("weibull", "Weibull").replace("student", "Student")
            name = f"{'mirrored ' if one.mirrored else ''}{name}"
            axes.plot(one.density(height) * percent, y, color=colour, linestyle=line,
                      label=f"{name} ({100.0 * one.share:.2g} %)")  # fmt: skip
        axes.set_xlabel(f"Density [%/{letter}m]")
    note(middle, "(b) density" if bulk is None else "(b) density, middle part")
    note(right, "(c) its tails (log)")
    # The heights of the trace are those of the tails; of the density, too, if it fills them.
    right.tick_params(labelleft=False)
    middle.tick_params(labelleft=bulk is not None)
    if bulk is not None:
        for at in bulk:
            left.axhline((at - mean) / unit, color="#444444", linewidth=0.7, linestyle=(0, (1, 2)))
    handles, labels = middle.get_legend_handles_labels()
    word = {"ok": "Gaussian", "watch": "roughly Gaussian", "outside": "not Gaussian"}
    figure.legend(
        handles,
        labels,
        loc="outside lower center",
        ncols=min(len(handles), 2),
        title=f"Verdict: {word[fit.gaussian.word]}",
        title_fontsize=8.5,
    )
    return figure


def _bins(count: int) -> int:
    return min(MOST_BINS, max(12, round(math.sqrt(count))))


def _bulk(heights: NDArray[np.float64], low: float, high: float) -> tuple[float, float] | None:
    """Heights of nearly all points, if they would be a spike in the whole range; else None."""
    bottom, top = np.nanquantile(heights, (0.02, 0.98)).tolist()
    reach = 0.5 * (top - bottom)
    if 3.0 * reach > _NARROW * (high - low) or not reach > 0.0:
        return None
    return max(bottom - 0.5 * reach, low), min(top + 0.5 * reach, high)


def _range(heights: NDArray[np.float64]) -> tuple[float, float]:
    """Heights that are drawn: all, unless a few of them would leave no room for the rest."""
    low, high = np.nanquantile(heights, (0.002, 0.998)).tolist()
    reach = 0.5 * (high - low)
    return max(low - reach, float(np.nanmin(heights))), min(high + reach, float(np.nanmax(heights)))
