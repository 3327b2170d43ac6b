"""Joint of a scan: its face solved point by point under the load that tightened it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from microslip._core.checks import Progress
from microslip._core.errors import InputError
from microslip._core.units import engineering
from microslip.contact import MeasuredContact
from microslip.contact.materials import MaterialPair
from microslip.contact.measured_face import ENERGY_AMPLITUDES, ContactNumbers
from microslip.friction import Interface
from microslip.surfaces.scan import Scan

WHOLE = 512 * 512
"""Largest number of points solved in one piece, which takes some ten seconds."""
_SIDE = 384  # approximate side of the pieces of larger scans [points]
_SMALLEST = 24  # smallest side of pieces that only serve to estimate the scatter [points]
_RELATIVE_AMPLITUDE = 0.3  # default amplitude over mu N / k_t
_NAMES = ("normal_stiffness", "tangential_stiffness", "loss_factor")


@dataclass(frozen=True)
class FaceJoint:
    """Joint of a measured face at one load, with its uncertainty due to the scan."""

    joint: Interface
    law: MeasuredContact
    amplitude: float
    """Amplitude [m] of the loss factor."""
    piece: int | None
    """Approximate side of the pieces [points]; None if the face was solved in one piece."""
    pieces: MeasuredContact | None = field(repr=False)
    """Law in several pieces, used for the intervals; None for a very small scan."""

    @cached_property
    def values(self) -> dict[str, float]:
        """Stiffnesses at rest, k_n and k_t [N/m], and loss factor at the amplitude [-]."""
        return _values(self.joint, self.amplitude)

    @property
    def first_loading_stiffness(self) -> float:
        """Slope of the load over the separation on first loading, at the tightening load [N/m]."""
        return float(self.law.first_loading.stiffness[-1])

    @property
    def slip_length(self) -> float:
        """Friction limit over tangential stiffness, mu N/k_t [m]."""
        return self.joint.force_limit / self.joint.tangential_stiffness

    @property
    def unresolved_amplitude(self) -> float | None:
        """Amplitude [m] up to which doubling the pixel changes the energy by 25 % or more."""
        share = self.law.numbers.unresolved_amplitude
        return None if share is None else share * self.slip_length

    @property
    def _energy_change(self) -> float:
        """Mean square of ln(energy for twice the pixel over that for the pixel) [-]."""
        ratios = self.law.numbers.coarser_energies
        if ratios is None:
            return 0.0
        at, wanted = np.log(ENERGY_AMPLITUDES), math.log(self.amplitude / self.slip_length)
        octave = wanted + math.log(2.0) * np.array([-1.0, -0.5, 0.0, 0.5, 1.0])
        return float(np.mean(np.interp(octave, at, np.log(ratios)) ** 2))

    @cached_property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """90 % intervals of :attr:`values`; empty if the scan was solved in a single piece.

        The standard error of the logarithm of each value is a jackknife estimate over the
        separately solved pieces of the face. It is combined with the change of the logarithm when
        the pixel is doubled, taken as the half-width of a rectangular distribution (GUM 4.3.7). For
        the loss factor this is the rms change of the energy from half to twice the amplitude.
        """
        from scipy.special import stdtrit

        law = self.pieces
        if law is None:
            return {}
        count = law.solution.pressure.shape[1]
        numbers = range(count)
        logs = []
        for left_out in numbers:
            part = law.of_pieces([k for k in numbers if k != left_out])
            joint = Interface(
                part, self.joint.friction_coefficient, normal_load=self.joint.normal_load
            )
            logs.append([math.log(value) for value in _values(joint, self.amplitude).values()])
        variance = (count - 1) * np.var(np.array(logs), axis=0)
        stiffness = math.log(self.law.numbers.coarser or 1.0) ** 2
        pixel = np.array([stiffness, stiffness, self._energy_change]) / 3.0
        width = float(stdtrit(count - 1, 0.95)) * np.sqrt(variance + pixel)
        return {
            name: (value * math.exp(-w), value * math.exp(w))
            for (name, value), w in zip(self.values.items(), width.tolist(), strict=True)
        }


def _values(joint: Interface, amplitude: float) -> dict[str, float]:
    values = joint.normal_stiffness, joint.tangential_stiffness, joint.loss_factor(amplitude)
    return dict(zip(_NAMES, map(float, values), strict=True))


def solve_joint(
    scan: Scan,
    pair: MaterialPair,
    normal_load: float,
    *,
    area: float | None = None,
    friction_coefficient: float = 0.5,
    amplitude: float | None = None,
    direction: float | None = None,
    report: Progress,
) -> FaceJoint:
    """Solve a scan point by point under a load [N], and again with twice the pixel.

    Parameters
    ----------
    scan : Scan
        The conditioned scan.
    area : float, optional
        Apparent area [m^2] of the joint; by default that of the scan.
    amplitude : float, optional
        Amplitude [m] of the loss factor; by default 0.3 mu N / k_t.
    direction : float, optional
        Direction of the motion from x of the scan [rad]; None is the mean over all directions.

    Raises
    ------
    InputError
        If the load brings too few points into contact, or if most of the face yields under it.
    """
    scan = scan.solvable()
    pressure = _rounded_up(normal_load / (area or scan.area))
    piece = None if scan.heights.size <= WHOLE else _SIDE

    def solved(size: int | None, start: float, share: float, *, coarser: bool) -> MeasuredContact:
        return MeasuredContact(
            scan, pair, tightening_pressure=pressure, area=area, piece=size, direction=direction,
            coarser=coarser, progress=lambda done, total: report(start + share * done / total),
        )  # fmt: skip

    try:
        law = solved(piece, 0.0, 1.0 if piece else 0.8, coarser=True)
    except InputError as error:
        message = error.text.replace("`tightening_pressure`", "`normal_load` over the area")
        raise InputError(message) from None
    pieces: MeasuredContact | None = law
    half = min(scan.heights.shape) // 2
    if law.numbers.pieces == 1:
        pieces = solved(half, 0.8, 0.2, coarser=False) if half >= _SMALLEST else None
    joint = Interface(law, friction_coefficient, normal_load=normal_load)
    if amplitude is None:
        amplitude = _RELATIVE_AMPLITUDE * joint.force_limit / joint.tangential_stiffness
    return FaceJoint(joint, law, amplitude, piece, pieces)


def contact_words(numbers: ContactNumbers) -> str:
    """Describe the solution of a face in one sentence."""
    n = numbers
    state = f"elastic up to {engineering(n.pressure, 'Pa')}"
    if n.hardness is not None:
        state = (
            f"tightened to {engineering(n.pressure, 'Pa')} at a hardness of "
            f"{engineering(n.hardness, 'Pa')}, {100.0 * n.hard_share:.0f} % of the contact yielding"
        )
    scatter = ""
    if n.scatter is not None:
        scatter = f", whose stiffness scatters by {100.0 * n.scatter:.0f} %"
    low, high = n.stiffness_ratios
    changes = [
        f"{round(100.0 * (value - 1.0)):d} % {how}"
        for value, how in (
            (n.coarser, "by twice the pixel"),
            (n.smoother, f"without waves below {engineering(n.cutoff or 0.0, 'm')}"),
        )
        if value is not None
    ]
    resolution = f"; its stiffness changes by {' and '.join(changes)}" if changes else ""
    if n.unresolved_amplitude is not None:
        resolution += (
            "; if the pixel is doubled, the energy of cycles changes by 25 % or more up to an "
            f"amplitude of {n.unresolved_amplitude:g} μN/k_t"
        )
    return (
        f"{state}; {n.points} points in contact, {100.0 * n.contact_share:.1f} % of the face; "
        f"p/E*h' {n.relative_pressure:.2g}, h' {n.slope:.2g}; {n.pieces} "
        f"piece{'s' if n.pieces > 1 else ''}{scatter}; normal over tangential stiffness "
        f"{low:.3f} to {high:.3f} by direction{resolution}"
    )


def _rounded_up(value: float) -> float:
    """Round upwards to four significant digits.

    A tightening pressure that is rounded down would be below the pressure of the load.
    """
    scale = 10.0 ** (math.floor(math.log10(value)) - 3)
    return math.ceil(value / scale) * scale
