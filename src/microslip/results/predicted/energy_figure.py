"""The figures of energy and damping over displacement and over force amplitudes."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from microslip.report.plot import (
    DASHED,
    DOTTED,
    THIN,
    Axis,
    Floats,
    LineName,
    Panel,
    Plot,
    Rule,
    Words,
    stacked,
)
from microslip.report.scales import evenly
from microslip.results.predicted.columns import AmplitudeCurve
from microslip.results.predicted.curves import (
    MOST_MARKS,
    AmplitudeAxis,
    add_legend,
    displacement_axis,
    draw_curves,
    drawn_loads,
    finite,
    force_axis,
)
from microslip.results.predicted.prediction import Prediction
from microslip.results.predicted.varying import VaryingCycles, in_words

CUBIC = "cubic limit, ∝ δₘ³"
CUBIC_IN_FORCE = "cubic limit, ∝ Tₘ³"
LINEAR = "linear limit, 4μN δₘ"
MOST_EXPONENT = 6.0


def energy_damping(result: Prediction) -> Plot:
    """Energy, loss factor, damping ratio and exponent against the displacement amplitude."""
    return _figure(result, displacement_axis(result))


def force_damping(result: Prediction) -> Plot:
    """Energy, loss factor, damping ratio and exponent against the force amplitude."""
    return _figure(result, force_axis(result))


def _figure(result: Prediction, axis: AmplitudeAxis) -> Plot:
    panels = [make(result, axis) for make in (_energy, _damping, _exponent)]
    if axis.column == "force_amplitude":
        for panel in panels:
            for index, look in drawn_loads(result):
                limit = result.joints[index].force_limit / axis.unit
                panel.items.insert(0, Rule(limit, "x", look.color, 1.0, DOTTED))
    if (variation := result.study.excitation.load_variation) is not None:
        panels[0].note = f"hollow: constant load, filled: load varies by {in_words(variation)}"
    return add_legend(stacked(panels, 8.9, (3.0, 2.0, 1.3)), result)


def _draw_varying(
    panel: Panel,
    result: Prediction,
    axis: AmplitudeAxis,
    constant: Floats,
    quantity: Callable[[VaryingCycles], Floats],
) -> Floats:
    """Mark the loops of a load that varies; ordinates drawn, with those at constant load."""
    ordinates = [constant]
    for index, look in drawn_loads(result) if result.varying else ():
        cycles = result.varying[index]
        marked = evenly(cycles.amplitude.size, MOST_MARKS)
        x, y = axis.of(cycles)[marked], quantity(cycles)[marked]
        inside = np.isfinite(y) & (y > 0.0) & (x >= axis.low) & (x <= axis.high)
        panel.marks(x[inside], y[inside], look.color, marker=look.marker, filled=True)
        ordinates.append(y[inside])
    return finite(np.concatenate(ordinates))


# -- energy --------------------------------------------------------------------------------------


def _energy(result: Prediction, axis: AmplitudeAxis) -> Panel:
    panel = axis.panel(Axis("Dissipated energy per cycle [J]", log=True))
    uppermost: dict[str, tuple[float, LineName]] = {}
    for index, look in drawn_loads(result):
        for x, y, name, height in _limit_lines(result, index, axis):
            panel.line(x, y, look.color, width=THIN, dash=DASHED)
            if name not in uppermost or height > uppermost[name][0]:
                uppermost[name] = height, LineName(x, y, name, at_end=name == LINEAR)
    energies = draw_curves(panel, result, axis, lambda curve: curve.dissipated_energy)
    energies = _draw_varying(panel, result, axis, energies, lambda cycles: cycles.dissipated_energy)
    if np.isfinite(energies).any():
        panel.y.low, panel.y.high = float(energies.min()) / 5.0, float(energies.max()) * 10.0
    panel.add(*(name for _, name in uppermost.values()))
    return panel


def _limit_lines(
    result: Prediction, index: int, axis: AmplitudeAxis
) -> list[tuple[Floats, Floats, str, float]]:
    """Where the energy tends to at small and at large amplitudes: lines, names, coefficients.

    Of parallel lines the one with the largest coefficient is uppermost.
    """
    curve, limit, joint = result.curves[index], result.limits[index], result.joints[index]
    a, energy = curve.amplitude, curve.dissipated_energy
    lines = []
    if axis.column == "force_amplitude":
        if limit.cubic_coefficient is not None:
            # At small amplitudes the displacement is the force over the stiffness at rest.
            force = curve.force_amplitude
            coefficient = limit.cubic_coefficient / joint.tangential_stiffness**3
            lines.append((force / axis.unit, coefficient * force**3, CUBIC_IN_FORCE, coefficient))
        return lines
    if limit.cubic_coefficient is not None:
        cubic = limit.cubic_coefficient * a**3
        near = cubic < 30.0 * energy
        lines.append((a[near] / axis.unit, cubic[near], CUBIC, limit.cubic_coefficient))
    if limit.linear_offset is not None:
        linear = 4.0 * joint.force_limit * a
        near = linear < 30.0 * energy
        lines.append((a[near] / axis.unit, linear[near], LINEAR, joint.force_limit))
    return lines


# -- damping -------------------------------------------------------------------------------------


def _damping(result: Prediction, axis: AmplitudeAxis) -> Panel:
    """Over decades, as the energy: where joints live the loss factor is small."""
    panel = axis.panel(Axis("Loss factor η", log=True))
    panel.second = ("Damping ratio ζ = η/2", 0.5)
    top = 4.0 / math.pi
    factors = draw_curves(panel, result, axis, lambda curve: curve.loss_factor)
    factors = _draw_varying(panel, result, axis, factors, lambda cycles: cycles.loss_factor)
    drawable = np.isfinite(factors).any()
    largest, smallest = (
        (float(np.nanmax(factors)), float(np.nanmin(factors))) if drawable else (1.0, 0.1)
    )
    text = "full sliding (rigid–plastic): η = 4/π, ζ = 2/π"
    if largest > 0.1 * top:
        panel.items.insert(0, Rule(top))
        panel.y.high = 4.0 * max(top, largest)
    else:
        text += ", above this scale"
        panel.y.high = 4.0 * largest
    panel.y.low = max(0.5 * smallest, 1e-5 * panel.y.high)
    panel.add(Words(0.012, 0.98, text))
    return panel


# -- exponent ------------------------------------------------------------------------------------


def force_exponent(curve: AmplitudeCurve) -> Floats:
    """Local exponent of the energy in the force amplitude, d ln E / d ln T_m [-].

    The one in the displacement times d ln delta_m / d ln T_m, the secant over the tangent
    stiffness; infinite where the force no longer grows.
    """
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        return curve.dissipation_exponent * (curve.secant_stiffness / curve.tangent_stiffness)


def _exponent(result: Prediction, axis: AmplitudeAxis) -> Panel:
    by_force = axis.column == "force_amplitude"
    panel = axis.panel(Axis(f"Local exponent\nd ln E / d ln {'T' if by_force else 'δ'}"))
    panel.add(*(Rule(level) for level in ((3.0,) if by_force else (3.0, 1.0))))
    values = draw_curves(
        panel,
        result,
        axis,
        force_exponent if by_force else lambda curve: curve.dissipation_exponent,
    )
    lowest, highest = (
        (float(values.min()), float(values.max())) if np.isfinite(values).any() else (1.0, 3.0)
    )
    panel.y.low = max(0.0, min(lowest, 3.0 if by_force else 1.0) - 0.3)
    panel.y.high = min(max(highest, 3.0) + 0.3, MOST_EXPONENT)
    return panel
