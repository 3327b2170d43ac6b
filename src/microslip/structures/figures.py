"""Figures of modes, responses and motions in time; titles come from the caller."""

from __future__ import annotations

from typing import Any

import numpy as np

from microslip._core.checks import Floats, whole_number
from microslip._core.quantities import QUANTITIES, Quantity, hertz
from microslip.figures.kit import axis_of, time_axis
from microslip.figures.plot import COLORS, DASHED, Panel, Plot, stacked


def modal_figure(curve: Any) -> Plot:
    """Plot frequency and damping ratio against the requested amplitudes."""
    solved = curve.amplitude[np.isfinite(curve.amplitude)]
    quantity = Quantity("m", label="Amplitude at the sensor")
    if np.array_equal(curve.amplitude, curve.modal_amplitude):
        quantity = Quantity("m kg^½", label="Modal amplitude")
    panels = []
    for axis, values in (
        (axis_of(hertz("Frequency")), curve.frequency),
        (axis_of(QUANTITIES["damping_ratio"], log=True), curve.damping_ratio),
    ):
        panel = Panel(axis_of(quantity, float(solved.max()), log=True, margin=0.02), axis)
        panel.line(curve.amplitude / panel.x.unit, values)
        panels.append(panel)
    above = panels[0]
    above.note = (
        f"Mode {curve.index + 1}, dashed: with sticking joints, {curve.linear_frequency:.5g} Hz"
    )
    above.line(
        curve.amplitude / above.x.unit, np.full_like(curve.amplitude, curve.linear_frequency),
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
    panel = Panel(
        axis_of(hertz("Frequency"), margin=0.0),
        axis_of(Quantity("m", label="Amplitude of the fundamental"), float(amplitude.max())),
        note=f"Forced response, {note}",
    )
    unit = panel.y.unit
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
    panels = []
    for quantity, values in (
        (QUANTITIES["displacement"], displacement),
        (Quantity("J", label="Energy lost"), lost),
    ):
        panel = Panel(time_axis(time), axis_of(quantity, float(np.abs(values).max())))
        panel.line(time / panel.x.unit, values / panel.y.unit, width=0.9)
        panels.append(panel)
    panels[0].note = note
    return stacked(panels, 5.0, (1.5, 1.0))
