"""Floor 8: the power spectrum of a scan, and the band of waves that counts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np
from matplotlib.figure import Figure

from microslip._units import engineering
from microslip.study.drawing import DASHES, drawable, length_prefix, log_scale, new_figure, note

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from microslip.study.scanned import Findings

_MICRO = 1e-6
_REMOVED = "#e4e4e4"
_BLUE, _ORANGE, _BLACK = "#0072B2", "#D55E00", "#000000"


def draw(found: Findings) -> Figure:
    """Draw the spectrum of the levelled scan, and what the cut-offs leave of it.

    Parameters
    ----------
    found : Findings
        What was found.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, with a canvas: radial and along the axes; of a profile, along it.
    """
    whole, kept = found.whole_spectrum, found.spectrum
    profile = found.scan.is_profile
    figure = new_figure(3.7, found.title("Power spectrum"))
    panels = [figure.subplots()] if profile else list(figure.subplots(1, 2))
    unit, letter = length_prefix(max(found.scan.size), min(found.scan.pixel))
    cut = found.request.cutoff is not None or found.request.long_cutoff is not None
    if not profile:
        axes = panels[0]
        _line(axes, whole.wavelength / unit, whole.density / _MICRO**4, "levelled", *_under(cut))
        if cut:
            _line(axes, kept.wavelength / unit, kept.density / _MICRO**4, "cut off", _BLACK)
        axes.set_ylabel("Density C [µm⁴]")
        note(axes, "Mean of all directions")
    axes = panels[-1]
    names = ("along x", "along y") if not profile else ("along the profile",)
    looks = ((_BLUE, "-"), (_ORANGE, DASHES))
    for part in whole.axes if cut else ():
        _line(axes, part.wavelength / unit, part.density / _MICRO**3, None, *_under(cut))
    for name, part, (colour, line) in zip(names, kept.axes, looks, strict=False):
        _line(axes, part.wavelength / unit, part.density / _MICRO**3, name, colour, 1.4, line)
    axes.set_ylabel("Density of profiles [µm³]")
    note(
        axes,
        ("Along the profile" if profile else "Along the axes")
        + (", in grey before the cut-off" if cut else ""),
    )
    for axes in panels:
        _frame(axes, found, unit, letter)
    return figure


def _under(cut: bool) -> tuple[str, float]:
    """Colour and width of the spectrum that another one is drawn over."""
    return ("#8a8a8a", 2.4) if cut else (_BLACK, 1.4)


def _line(
    axes: Axes,
    x: np.ndarray,
    y: np.ndarray,
    label: str | None,
    colour: str,
    width: float = 1.4,
    line: object = "-",
) -> None:
    axes.plot(x, drawable(y, log=True), color=colour, linewidth=width, linestyle=line, label=label)


def _frame(axes: Axes, found: Findings, unit: float, letter: str) -> None:
    """Axes and legend, and the waves that are removed on grey ground."""
    log_scale(axes, "x")
    log_scale(axes, "y")
    # What the filter leaves at the far side of a cut-off is rounding.
    top = max(float(np.nanmax(line.get_ydata())) for line in axes.lines)
    low = min(float(np.nanmin(line.get_ydata())) for line in axes.lines)
    axes.set_ylim(max(low / 2.0, 1e-12 * top), 4.0 * top)
    left, right = 2.0 * min(found.scan.pixel) / unit, 1.05 * max(found.scan.size) / unit
    axes.set_xlim(left, right)
    axes.set_xlabel(f"Wavelength [{letter}m]")
    request = found.request
    if request.cutoff is not None:
        axes.axvspan(left, request.cutoff / unit, facecolor=_REMOVED, edgecolor="none", zorder=0)
        _name(axes, request.cutoff, unit, 3, "left")
    if request.long_cutoff is not None:
        axes.axvspan(
            request.long_cutoff / unit, right, facecolor=_REMOVED, edgecolor="none", zorder=0
        )
        _name(axes, request.long_cutoff, unit, -3, "right")
    axes.legend(loc="lower right", bbox_to_anchor=(0.99, 0.02))


def _name(
    axes: Axes, cutoff: float, unit: float, offset: float, side: Literal["left", "right"]
) -> None:
    """A line at a cut-off, and what it is."""
    axes.axvline(cutoff / unit, color="#444444", linewidth=0.9)
    axes.annotate(
        f"cut-off {engineering(cutoff, 'm', trim=True)}",
        (cutoff / unit, 0.03),
        (offset, 0),
        xycoords=axes.get_xaxis_transform(),
        textcoords="offset points",
        ha=side,
        va="bottom",
        fontsize=8,
        rotation=90,
    )
