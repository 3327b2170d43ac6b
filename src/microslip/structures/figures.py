"""Figures of modes, responses and motions in time; titles come from the caller."""

from __future__ import annotations

from typing import Any

import numpy as np

from microslip._core.checks import Floats, whole_number
from microslip._core.units import prefix
from microslip.figures.kit import force_prefix, length_prefix
from microslip.figures.plot import COLORS, DASHED, Axis, Panel, Plot, stacked


def modal_figure(curve: Any) -> Plot:
    """Plot frequency and damping ratio against the requested amplitudes."""
    solved = curve.amplitude[np.isfinite(curve.amplitude)]
    unit, letter = prefix(float(solved.max()))
    at_sensor = not np.array_equal(curve.amplitude, curve.modal_amplitude)
    label = "Amplitude at the sensor [{}m]" if at_sensor else "Modal amplitude [{}m kg^½]"
    panels = []
    for axis, values in (
        (Axis("Frequency [Hz]"), curve.frequency),
        (Axis("Damping ratio ζ of the mode", log=True), curve.damping_ratio),
    ):
        panel = Panel(Axis(label.format(letter), log=True, margin=0.02, unit=unit), axis)
        panel.line(curve.amplitude / unit, values)
        panels.append(panel)
    above = panels[0]
    above.note = (
        f"Mode {curve.index + 1}, dashed: with sticking joints, {curve.linear_frequency:.5g} Hz"
    )
    above.line(
        curve.amplitude / unit, np.full_like(curve.amplitude, curve.linear_frequency),
        width=0.9, dash=DASHED,
    )  # fmt: skip
    return stacked(panels, 5.2, (1.0, 1.3))


def response_figure(response: Any, sensor: Floats | None) -> Plot:
    """Plot the amplitude of the fundamental harmonic against frequency."""
    if sensor is None:
        first = np.abs(response.displacement[:, :, response.harmonics.index(1)])
        sensor = np.zeros(first.shape[1])
        place = int(np.argmax(first.max(axis=0)))
        sensor[place] = 1.0
        note = f"degree of freedom {place}, which moves most"
    else:
        note = "at the sensor"
    amplitude = response.amplitude(sensor)
    unit, letter = length_prefix(float(amplitude.max()))
    panel = Panel(
        Axis("Frequency [Hz]", margin=0.0),
        Axis(f"Amplitude of the fundamental [{letter}m]", unit=unit),
        note=f"Forced response, {note}",
    )
    if not response.stable.all():
        panel.line(response.frequency, amplitude / unit, width=0.9, dash=DASHED)
        panel.note += "; dashed: not stable"
    # Each stable stretch with the points that end it.
    ends = response.stable | np.append(response.stable[1:], False)
    ends |= np.append(False, response.stable[:-1])
    panel.line(response.frequency, np.where(ends, amplitude / unit, np.nan))
    turns = response.turning_points
    if turns.size:
        panel.marks(response.frequency[turns], amplitude[turns] / unit, COLORS[2])
        panel.note += "; circles: turning points"
    return Plot([panel], 4.2)


def motion_figure(motion: Any, sensor: int | None) -> Plot:
    """Plot displacement and energies against time."""
    count = motion.displacement.shape[1]
    if sensor is None:
        place = int(np.abs(motion.displacement).max(axis=0).argmax())
    else:
        place = whole_number("at", sensor, 0, count - 1)
    note = f"Degree of freedom {place}, energy error {motion.energy_error:.1e}"
    path = motion.displacement[:, place]
    return _in_time(motion.time, path, note, motion.dissipated_energy)


def ring_down_figure(motion: Any) -> Plot:
    """Plot displacement and dissipated energy against time."""
    lost = motion.dissipated_energy + motion.viscous_energy
    return _in_time(motion.time, motion.displacement, "Free oscillation", lost)


def _in_time(time: Floats, displacement: Floats, note: str, lost: Floats) -> Plot:
    t_unit, t_letter = prefix(float(time[-1])) if float(time[-1]) < 1.0 else (1.0, "")
    x_unit, x_letter = length_prefix(float(np.abs(displacement).max()) or 1.0)
    e_unit, e_letter = force_prefix(lost)
    panels = []
    for label, unit, values in (
        (f"Displacement [{x_letter}m]", x_unit, displacement),
        (f"Energy lost [{e_letter}J]", e_unit, lost),
    ):
        panel = Panel(Axis(f"Time [{t_letter}s]", margin=0.0, unit=t_unit), Axis(label, unit=unit))
        panel.line(time / t_unit, values / unit, width=0.9)
        panels.append(panel)
    panels[0].note = note
    return stacked(panels, 5.0, (1.5, 1.0))
