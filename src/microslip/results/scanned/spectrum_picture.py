"""The power spectrum of a scan, and the band of waves that counts."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from microslip._core.checks import Floats
from microslip._core.units import engineering
from microslip.report.plot import COLORS, DASHED, Area, Axis, Band, Entry, Line, Panel, Plot, Rule
from microslip.report.scales import length_prefix
from microslip.results.scanned.findings import Findings
from microslip.results.scanned.texture import self_affine

_MICRO = 1e-6
_REMOVED = "#e4e4e4"
_EDGE = "#444444"
_UNDER = "#8a8a8a"
_SCATTER = "#c6dbef"
_BELOW = 1e-3
"""How far below the lowest density before the cut-off the axis goes."""
_LOOKS: tuple[tuple[str, tuple[float, ...]], ...] = ((COLORS[1], ()), (COLORS[2], DASHED))


def spectrum_plot(findings: Findings) -> Plot:
    """The spectrum of the levelled scan and what the cut-offs leave of it.

    Radial and along the axes; of a profile, along it.
    """
    unfiltered_spectrum, filtered_spectrum = findings.whole_spectrum, findings.spectrum
    profile, cut = findings.scan.is_profile, findings.request.is_filtered
    unit, letter = length_prefix(max(findings.scan.size), min(findings.scan.pixel))
    under = (_UNDER, 2.4) if cut else (COLORS[0], 1.4)
    panels: list[Panel] = []
    legend: list[Entry] = []
    if not profile:
        before = [
            _line(
                unfiltered_spectrum.wavelength / unit,
                unfiltered_spectrum.density / _MICRO**4,
                *under,
            )
        ]
        legend.append(Entry("levelled", under[0]))
        after = []
        if cut:
            after = [
                _line(
                    filtered_spectrum.wavelength / unit,
                    filtered_spectrum.density / _MICRO**4,
                    COLORS[0],
                )
            ]
            legend.append(Entry("cut off", COLORS[0]))
        panel = Panel(_wavelength(letter), Axis("Density C [µm⁴]", log=True))
        panel.note = "Mean of all directions"
        part = 1.0 + np.minimum(unfiltered_spectrum.relative_error, 0.9) * np.array([[1.0], [-1.0]])
        x = unfiltered_spectrum.wavelength / unit
        edges = unfiltered_spectrum.density / _MICRO**4 * part
        panel.add(
            Area(np.concatenate([x, x[::-1]]), np.concatenate([edges[0], edges[1][::-1]]), _SCATTER)
        )
        legend.append(Entry("± its uncertainty", _SCATTER))
        if (fit := self_affine(findings)) is not None:
            at = np.array([fit.shortest, fit.longest])
            after_law = _line(at / unit, fit.density(at) / _MICRO**4, COLORS[3], 1.6, DASHED)
            legend.append(Entry(f"H = {fit.hurst:.2f}", COLORS[3], DASHED))
        _fill(panel, findings, unit, before, after)
        if fit is not None:
            panel.add(after_law)
        panels.append(panel)
    before = [
        _line(p.wavelength / unit, p.density / _MICRO**3, *under) for p in unfiltered_spectrum.axes
    ]
    after = []
    names = ("along the profile",) if profile else ("along x", "along y")
    for name, part, (color, dash) in zip(names, filtered_spectrum.axes, _LOOKS, strict=False):
        after.append(_line(part.wavelength / unit, part.density / _MICRO**3, color, 1.4, dash))
        legend.append(Entry(name, color, dash))
    panel = Panel(_wavelength(letter), Axis("Density of profiles [µm³]", log=True))
    panel.note = "Along the profile" if profile else "Along the axes"
    panel.note += ", in grey before the cut-off" if cut else ""
    _fill(panel, findings, unit, before if cut else [], after, before)
    panels.append(panel)
    for place, panel in enumerate(panels):
        panel.cell = (0, 0, place, place)
    request = findings.request
    ends = [("short", request.cutoff), ("long", request.long_cutoff)]
    bounds = [
        f"{name}-wave {engineering(length, 'm', 4, trim=True)}" for name, length in ends if length
    ]
    if bounds:
        legend.append(Entry(f"cut-off{'s' * (len(bounds) > 1)}: {', '.join(bounds)}", _EDGE))
    title = findings.title("Power spectrum")
    return Plot(panels, 4.1, title, widths=(1.0,) * len(panels), legend=tuple(legend))


def _wavelength(letter: str) -> Axis:
    return Axis(f"Wavelength [{letter}m]", log=True)


def _line(
    x: Floats, y: Floats, color: str, width: float = 1.4, dash: tuple[float, ...] = ()
) -> Line:
    return Line(x, np.where(y > 0.0, y, np.nan), color, width, dash)


def _fill(
    panel: Panel,
    findings: Findings,
    unit: float,
    before: list[Line],
    after: list[Line],
    unfiltered: list[Line] | None = None,
) -> None:
    """Lines in a panel, and the waves that are removed on grey ground."""
    low_x, right = 2.0 * min(findings.scan.pixel) / unit, 1.05 * max(findings.scan.size) / unit
    low, high = _ends([*before, *after], low_x, right)
    # What the filter leaves far below all that there was is nothing to look at.
    lowest = _BELOW * _ends(unfiltered or before, low_x, right)[0]
    panel.y.low, panel.y.high = max(low, lowest) / 2.0, 4.0 * high
    panel.x.low, panel.x.high = low_x, right
    request = findings.request
    for cutoff, ends in (
        (request.cutoff, (low_x, (request.cutoff or low_x) / unit)),
        (request.long_cutoff, ((request.long_cutoff or right) / unit, right)),
    ):
        if cutoff is not None:
            panel.items[:0] = [Band(*ends, "x", _REMOVED)]
            panel.add(Rule(cutoff / unit, "x", _EDGE, 0.9, ()))
    panel.add(*before, *after)


def _ends(lines: Iterable[Line], low_x: float, right: float) -> tuple[float, float]:
    """Lowest and highest value that is seen."""
    ordinates = [
        line.y[(line.x >= low_x) & (line.x <= right) & np.isfinite(line.y)] for line in lines
    ]
    values = np.concatenate(ordinates)
    return (float(values.min()), float(values.max())) if values.size else (1.0, 1.0)
