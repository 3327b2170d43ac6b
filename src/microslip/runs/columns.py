"""The columns of a prediction: cyclic quantities, histories and oscillators of one joint."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from typing import Literal, TypeVar

import numpy as np

from microslip._core.checks import Floats, Progress
from microslip._core.frozen import Locked, lock
from microslip._core.units import engineering
from microslip.friction import Interface
from microslip.friction.energies import dissipated_along
from microslip.loops import Loop
from microslip.structures import Oscillator
from microslip.study.schema import LoadVariation

_Columns = TypeVar("_Columns", bound="Columns")

_BLOCK = 20_000


def blocks(size: int, progress: Progress | None = None, largest: int = _BLOCK) -> Iterator[slice]:
    """Pieces of so many things; small ones first, for those who wait to see progress."""
    start, length = 0, min(largest, 64)
    while start < size:
        yield slice(start, min(start + length, size))
        start, length = start + length, min(largest, 2 * length)
        if progress is not None:
            progress(min(start / size, 1.0))


@dataclass(frozen=True, eq=False, repr=False)
class Columns(Locked):
    """Arrays of one length by their names; None for what is not known."""

    def __post_init__(self) -> None:
        for array in self.columns().values():
            lock(array)

    def columns(self) -> dict[str, Floats]:
        """Arrays by name, without those that are not known."""
        named = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: array for name, array in named.items() if isinstance(array, np.ndarray)}

    def __repr__(self) -> str:
        columns = self.columns()
        size = len(next(iter(columns.values())))
        return f"{type(self).__name__}({size} of {', '.join(columns)})"

    @classmethod
    def _by_pieces(
        cls: type[_Columns], make: Callable[[slice], _Columns], size: int, progress: Progress | None
    ) -> _Columns:
        """Make a long one piece by piece."""
        arrays: dict[str, Floats] = {}
        for piece in blocks(size, progress):
            for name, array in make(piece).columns().items():
                arrays.setdefault(name, np.empty(size))[piece] = array
        return cls(**{field.name: arrays.get(field.name) for field in fields(cls)})


_BY_METHOD = (
    "dissipated_energy", "energy_ratio", "loss_factor", "damping_ratio", "secant_stiffness",
    "dissipation_exponent",
)  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class AmplitudeCurve(Columns):
    """Cyclic quantities of one joint against the displacement amplitude, as equal-length arrays.

    `force_ratio` is the force amplitude over the force limit, `tangent_stiffness` the slope
    :meth:`~microslip.Interface.backbone_stiffness` of the first loading curve, `slider_density` the
    density of :meth:`~microslip.Interface.sliders` and `stick_share` the stick area over the real
    contact area; the last and `stick_area` are None where the normal law does not know its
    contacts. The rest is what the methods of :class:`microslip.Interface` of the same name return.
    """

    amplitude: Floats
    force_amplitude: Floats
    force_ratio: Floats
    dissipated_energy: Floats
    energy_ratio: Floats
    loss_factor: Floats
    damping_ratio: Floats
    secant_stiffness: Floats
    tangent_stiffness: Floats
    dissipation_exponent: Floats
    slider_density: Floats
    stick_area: Floats | None
    stick_share: Floats | None

    @classmethod
    def of(
        cls, joint: Interface, amplitude: Floats, progress: Progress | None = None
    ) -> AmplitudeCurve:
        """Evaluate a joint."""
        return cls._by_pieces(
            lambda piece: cls._at(joint, amplitude[piece]), amplitude.size, progress
        )

    @classmethod
    def of_forces(cls, joint: Interface, force_amplitude: Floats) -> AmplitudeCurve:
        """The same at force amplitudes [N], one-dimensional, above zero."""
        amplitude = np.asarray(joint.backbone_displacement(force_amplitude))
        return cls._at(joint, amplitude, force_amplitude)

    @classmethod
    def _at(
        cls, joint: Interface, amplitude: Floats, force: Floats | None = None
    ) -> AmplitudeCurve:
        if force is None:
            force = np.asarray(joint.backbone(amplitude))
        contact = getattr(joint, "contact_area", None)  # a law alone has no contacts
        stick = None if contact is None else np.asarray(joint.stick_area(amplitude))
        return cls(
            amplitude=amplitude.copy(),
            force_amplitude=force.copy(),
            force_ratio=force / joint.force_limit,
            tangent_stiffness=np.asarray(joint.backbone_stiffness(amplitude)),
            **{name: np.asarray(getattr(joint, name)(amplitude)) for name in _BY_METHOD},
            slider_density=np.asarray(joint.sliders().density(amplitude)),
            stick_area=stick,
            stick_share=None if stick is None else stick / contact,
        )


@dataclass(frozen=True, eq=False, repr=False)
class HistoryResponse(Columns):
    """Response of one joint to the history of the study, from rest, as equal-length arrays.

    Parameters
    ----------
    displacement : ndarray
        Displacements [m]: those given, or those that the given forces lead to.
    force : ndarray
        Forces that hold them [N]: those given, or those that the given displacements lead to.
    dissipated_energy : ndarray
        Energy dissipated since rest [J].
    varying_normal_load : ndarray, optional
        Normal loads [N] where the history gives them; None where the load is that of the joint.
    """

    displacement: Floats
    force: Floats
    dissipated_energy: Floats
    varying_normal_load: Floats | None = None

    @classmethod
    def of(
        cls,
        joint: Interface,
        values: Floats,
        quantity: Literal["displacement", "force"],
        loads: Floats | None = None,
    ) -> HistoryResponse:
        """Follow a history."""
        if loads is not None:
            response = joint.coupled_response(**{quantity: values}, normal_load=loads)
            energy = response.dissipated_energy
            return cls(response.displacement, response.force, energy, loads.copy())

        if quantity == "displacement":
            displacement, force = values.copy(), np.asarray(joint.force(values))
        else:
            displacement, force = np.asarray(joint.displacement(values)), values.copy()
        return cls(displacement, force, dissipated_along(joint, displacement, values))


@dataclass(frozen=True, eq=False, repr=False)
class OscillatorCurve(Columns):
    """The oscillator of the study, held by one joint, against its displacement amplitude.

    Parameters
    ----------
    amplitude : ndarray
        Displacement amplitudes [m], those of the curves.
    frequency : ndarray
        Natural frequencies [Hz].
    damping_ratio : ndarray
        Damping ratios of the mode [-]: viscous damping and joint.
    interface_damping_ratio : ndarray
        Damping ratios of the interface [-], which are not those of the mode.
    """

    amplitude: Floats
    frequency: Floats
    damping_ratio: Floats
    interface_damping_ratio: Floats

    @classmethod
    def of(
        cls, oscillator: Oscillator, amplitude: Floats, progress: Progress | None = None
    ) -> OscillatorCurve:
        """Evaluate an oscillator at displacement amplitudes [m], one-dimensional, above zero."""

        def make(piece: slice) -> OscillatorCurve:
            a = amplitude[piece]
            names = ("frequency", "damping_ratio", "interface_damping_ratio")
            return cls(a.copy(), *(np.asarray(getattr(oscillator, name)(a)) for name in names))

        return cls._by_pieces(make, amplitude.size, progress)


@dataclass(frozen=True)
class Limits:
    """Limits of the dissipated energy E: c a^3 at small amplitudes a, 4 mu N (a - b) at large.

    `cubic_coefficient` c [J/m^3] and `linear_offset` b [m]; None where the joint has no such limit.
    """

    cubic_coefficient: float | None
    linear_offset: float | None


CYCLE = 1024
"""Steps of a cycle under a normal load of up to twice its frequency."""


def in_words(variation: LoadVariation) -> str:
    """Variation of the load over a cycle, in words."""
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
