"""The loops of a study whose normal load varies over the cycle."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from microslip._core.frozen import lock
from microslip._core.units import engineering
from microslip.friction import Interface
from microslip.loops import Loop
from microslip.results.predicted.columns import AmplitudeCurve, Columns, Floats
from microslip.study.schema import Excitation, LoadVariation

CYCLE = 1024
"""Steps of a cycle under a normal load of up to twice its frequency."""


def extremes(excitation: Excitation, normal_load: float) -> tuple[float, ...]:
    """Smallest and largest load [N] of a joint over the cycles and the history of a study."""
    if not excitation.load_varies:
        return (normal_load,)
    loads = [normal_load]
    if (variation := excitation.load_variation) is not None:
        share = variation.share_of(normal_load)
        loads += [normal_load * (1.0 - share), normal_load * (1.0 + share)]
    if excitation.history is not None and (record := excitation.history.loads) is not None:
        loads += [float(record.min()), float(record.max())]
    return min(loads), max(loads)


def in_words(variation: LoadVariation) -> str:
    """How a load varies over a cycle."""
    size = (
        f"{100.0 * variation.share:.6g} %"
        if variation.share is not None
        else engineering(variation.amplitude, "N", 6, trim=True)
    )
    phase = f"{math.degrees(variation.phase):.6g}".replace("-", "−")
    return f"±{size}, phase {phase}°, harmonic {variation.harmonic}"


@dataclass(frozen=True, eq=False, repr=False)
class VaryingLoop(Loop):
    """A settled cycle under a normal load that varies: a loop with the load at each sample.

    `dissipated_energy` is that of the cycle without the error of the polygon.
    """

    normal_load: Floats
    _energy: float

    def __init__(self, displacement: Floats, force: Floats, load: Floats, energy: float) -> None:
        super().__init__(displacement, force)
        object.__setattr__(self, "normal_load", lock(load.copy()))
        object.__setattr__(self, "_energy", energy)

    @property
    def dissipated_energy(self) -> float:
        """Energy dissipated in the cycle [J]."""
        return self._energy

    @classmethod
    def of(cls, joint: Interface, amplitude: float, variation: LoadVariation) -> VaryingLoop:
        """Follow a joint until its cycle repeats.

        From rest the load goes to where it begins; displacements a sin(w t) under the loads
        N + dN sin(n w t + phase) follow. Once every load and displacement has occurred the cycle
        repeats, so the second one is taken, from its largest displacement on.
        """
        mean = joint.normal_load
        share = variation.share_of(mean)
        if share == 1.0:  # whether or not a sample falls where the load is lost
            joint.coupled_force([0.0], normal_load=[0.0])
        n = variation.harmonic
        size = CYCLE * -(-n // 2)
        angle = 2.0 * np.pi / size * (np.arange(2 * size + size // 4 + 1) % size)
        load = mean * (1.0 + share * np.sin(n * angle + variation.phase))
        response = joint.coupled_response(amplitude * np.sin(angle), normal_load=load)
        energy = response.dissipated_energy[[-1 - size, -1]]
        last = slice(-1 - size, None)
        x, force = response.displacement[last], response.force[last]
        return cls(x, force, load[last], float(energy[1] - energy[0]))


@dataclass(frozen=True, eq=False, repr=False)
class VaryingCycles(Columns):
    """Cyclic quantities of one joint under a normal load that varies, from its settled loops.

    `force_amplitude` is half the range of the force, `energy_share` the dissipated energy over that
    at the constant normal load; the rest is as in :class:`AmplitudeCurve`.
    """

    amplitude: Floats
    smallest_normal_load: Floats
    largest_normal_load: Floats
    force_amplitude: Floats
    dissipated_energy: Floats
    energy_share: Floats
    energy_ratio: Floats
    loss_factor: Floats
    damping_ratio: Floats
    secant_stiffness: Floats

    @classmethod
    def of(cls, loops: tuple[VaryingLoop, ...], row: AmplitudeCurve) -> VaryingCycles:
        """Read loops."""
        force = np.array([loop.force_amplitude for loop in loops])
        energy = np.array([loop.dissipated_energy for loop in loops])
        # All of a loop whose force does not move is zero.
        full = 4.0 * row.amplitude * force
        ratio = np.divide(energy, full, out=np.zeros_like(full), where=full > 0.0)
        usual = row.dissipated_energy
        return cls(
            amplitude=row.amplitude.copy(),
            smallest_normal_load=np.array([loop.normal_load.min() for loop in loops]),
            largest_normal_load=np.array([loop.normal_load.max() for loop in loops]),
            force_amplitude=force,
            dissipated_energy=energy,
            energy_share=np.divide(
                energy, usual, out=np.full_like(usual, np.nan), where=usual > 0.0
            ),
            energy_ratio=ratio,
            loss_factor=4.0 / np.pi * ratio,
            damping_ratio=2.0 / np.pi * ratio,
            secant_stiffness=force / row.amplitude,
        )
