"""Floor 8: the power spectrum of a scan, and the band of waves that counts."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from microslip._core.units import engineering
from microslip.study.drawing import DASHES, drawable, length_prefix, log_scale, new_figure, note

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from microslip.study.scanned import Findings

_MICRO = 1e-6
_REMOVED = "#e4e4e4"
_EDGE: dict[str, Any] = {"color": "#444444", "linewidth": 0.9}
_BLUE, _ORANGE, _BLACK = "#0072B2", "#D55E00", "#000000"
_BELOW = 1e-3
"""How far below the lowest density before the cut-off the axis goes."""


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
    figure = new_figure(4.1, found.title("Power spectrum"))
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
    # By the first lines, which are before the cut-off.
    counts = [1] if profile else [1, len(whole.axes)]
    for axes, count in zip(panels, counts, strict=True):
        _frame(axes, found, unit, letter, axes.lines[:count])
    shown = [
        line for axes in panels for line in axes.lines if not str(line.get_label()).startswith("_")
    ]
    request = found.request
    ends = [("short", request.cutoff), ("long", request.long_cutoff)]
    bounds = [
        f"{name}-wave {engineering(length, 'm', 4, trim=True)}" for name, length in ends if length
    ]
    if bounds:
        label = f"cut-off{'s' * (len(bounds) > 1)}: {', '.join(bounds)}"
        shown.append(Line2D([], [], label=label, **_EDGE))
    figure.legend(handles=shown, loc="outside lower center", ncols=3)
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


def _frame(axes: Axes, found: Findings, unit: float, letter: str, before: list[Line2D]) -> None:
    """Axes, and the waves that are removed on grey ground."""
    log_scale(axes, "x")
    log_scale(axes, "y")
    left, right = 2.0 * min(found.scan.pixel) / unit, 1.05 * max(found.scan.size) / unit
    low, high = _ends(axes.lines, left, right)
    # What the filter leaves far below all that there was is nothing to look at.
    axes.set_ylim(max(low, _BELOW * _ends(before, left, right)[0]) / 2.0, 4.0 * high)
    axes.set_xlim(left, right)
    axes.set_xlabel(f"Wavelength [{letter}m]")
    request = found.request
    if request.cutoff is not None:
        axes.axvspan(left, request.cutoff / unit, facecolor=_REMOVED, edgecolor="none", zorder=0)
        axes.axvline(request.cutoff / unit, **_EDGE)
    if request.long_cutoff is not None:
        axes.axvspan(
            request.long_cutoff / unit, right, facecolor=_REMOVED, edgecolor="none", zorder=0
        )
        axes.axvline(request.long_cutoff / unit, **_EDGE)


def _ends(lines: Iterable[Line2D], left: float, right: float) -> tuple[float, float]:
    """Lowest and highest value that is seen."""
    seen = []
    for line in lines:
        x, y = (np.asarray(part, dtype=float) for part in line.get_data())
        seen.append(y[(x >= left) & (x <= right) & np.isfinite(y)])
    values = np.concatenate(seen)
    return (float(values.min()), float(values.max())) if values.size else (1.0, 1.0)
