"""Mass on a spring with a joint in parallel."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, get_args

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import (
    Floats,
    plain,
    positive,
    show,
    whole_number,
)
from microslip._core.errors import InputError
from microslip._core.frozen import assign
from microslip._core.parameters import parameter, parameters_of
from microslip._core.wording import quoted
from microslip.friction import LAWS, BackboneLaw
from microslip.structures.periodic_motion import (
    HARMONICS,
    MOST_SAMPLES,
    ModeMethod,
    averaged_stiffness,
    harmonic_basis,
)
from microslip.structures.ring_down import RingDown, ring_down

MOST_CYCLES = 10_000_000
_BLOCK = 2000  # amplitudes a pass of the harmonic balance


@dataclass(frozen=True, eq=False)
class Oscillator:
    """Mass held by a spring and, in parallel, by a joint: the smallest jointed structure.

    Parameters
    ----------
    mass : float
        Mass m [kg], above zero.
    stiffness : float
        Stiffness k of the spring parallel to the joint [N/m], not negative.
    joint : BackboneLaw
        Any law given by its backbone, such as a :class:`microslip.Interface`.
    viscous_damping_ratio : float, optional
        Damping ratio without the joint [-], from 0 to below 1.

    Notes
    -----
    m q'' + c q' + k q + T[q] = 0 with the joint force T and c = 2 zeta_v m omega_0, where omega_0
    is the angular frequency with a sticking joint (with a sliding one if it is rigid at rest).
    T0(a) is the backbone, the joint force at first loading to a, and k_t = T0'(0) its stiffness at
    rest; E_d(a) is the energy that the joint dissipates per cycle.

    *Quasi-static* modal analysis (Festjens, Chevallier and Dion, Int. J. Mech. Sci. 75, 170, 2013;
    Lacayo and Allen 2019, DOI 10.1016/j.ymssp.2018.08.034) reads frequency and damping from one
    loading curve: at the amplitude a the joint has the secant stiffness k_joint(a) = T0(a)/a with
    k + k_joint(a) = m omega^2, and adds E_d/(4 pi U) to the damping ratio, where U = (k + T0(a)/a)
    a^2/2 is the energy of the *whole* mode. Nothing is integrated in time.

    *Harmonic balance* is that of :meth:`microslip.Structure.modes` with the same harmonics; a is
    then the amplitude of the fundamental harmonic. With the fundamental alone it has a closed form
    (equivalent linearisation; for hysteresis Caughey 1960, DOI 10.1115/1.3644075): k_joint(a) is
    that of the in-phase first harmonic of the loop, in place of the secant. The two methods agree
    to first order in microslip, where the backbone is a parabola and both stiffnesses are equal.
    They differ in gross slip: a joint that slides at its limit mu N hardly stiffens the mode in
    harmonic balance, while the secant includes mu N/a.
    """

    mass: float = field(metadata=parameter("m", "kg", "mass", above=0.0, example="2 kg"))
    stiffness: float = field(
        metadata=parameter(
            "k",
            "N/m",
            "stiffness of the spring parallel to the joint",
            least=0.0,
            example="1e6 N/m",
        )
    )
    joint: BackboneLaw
    viscous_damping_ratio: float = field(
        default=0.0,
        metadata=parameter(
            "zeta_v",
            meaning="damping ratio of the structure without the joint, at its frequency at rest",
            least=0.0,
            below=1.0,
            why="at 1 and above nothing oscillates",
            example=0.01,
        ),
    )

    def __post_init__(self) -> None:
        for declared in parameters_of(Oscillator):
            # -0.0 is 0.0 here
            value = declared.checked(getattr(self, declared.name)) + 0.0
            assign(self, **{declared.name: value})
        if not isinstance(self.joint, BackboneLaw):
            names = ", ".join(law.__name__ for law in LAWS)
            raise InputError(f"`joint` must be a backbone law ({names}), got {show(self.joint)}")

    @cached_property
    def _stuck(self) -> float:
        """Angular frequency to which the viscous damping ratio refers [rad/s]."""
        joint = self.joint.tangential_stiffness
        stiffness = self.stiffness + (joint if math.isfinite(joint) else 0.0)
        return math.sqrt(stiffness / self.mass)

    @property
    def viscous_coefficient(self) -> float:
        """Coefficient of the dashpot c = 2 zeta_v m omega_0 [N s/m]."""
        return 2.0 * self.viscous_damping_ratio * self.mass * self._stuck

    # -- the closed form --------------------------------------------------------------------------

    def frequency(
        self,
        amplitude: ArrayLike,
        *,
        method: ModeMethod = "quasi-static",
        harmonics: Sequence[int] = HARMONICS,
    ) -> Any:
        """Return the natural frequency of the mode at an amplitude.

        Parameters
        ----------
        amplitude : array_like
            Displacement amplitudes a [m], not negative, any shape.
        method : {"quasi-static", "harmonic-balance"}, optional
            Definition of the joint stiffness k_joint(a), see the notes of the class.
        harmonics : sequence of int, optional
            Orders for harmonic balance. ``[1]`` uses a closed form, 100 times faster; a joint that
            is rigid at rest always uses it.

        Returns
        -------
        float or ndarray
            omega/2 pi [Hz], omega = sqrt((k + k_joint(a))/m), shape of ``amplitude``: from
            omega = sqrt((k + k_t)/m) with a sticking joint (stiffness k_t at rest) down to
            sqrt(k/m) with a sliding one. NaN where harmonic balance did not converge.
        """
        return self._mode(amplitude, method, harmonics)[0] / (2.0 * math.pi)

    def damping_ratio(
        self,
        amplitude: ArrayLike,
        *,
        method: ModeMethod = "quasi-static",
        harmonics: Sequence[int] = HARMONICS,
    ) -> Any:
        """Return the damping ratio at an amplitude; arguments as :meth:`frequency`.

        Returns
        -------
        float or ndarray
            zeta = zeta_v + E_d(a)/(4 pi U(a)) [-], shape of ``amplitude``, with the loss per cycle
            E_d and the energy U = m omega(a)^2 a^2/2 of the whole mode. With harmonic balance
            c/(2 m omega(a)) replaces zeta_v, from which it differs by the frequency shift.

        Notes
        -----
        The contribution of the joint is its own damping ratio, ``joint.damping_ratio(a)``, times
        its fraction (T0(a)/a)/(k + T0(a)/a) of the stiffness. The logarithmic decrement of a
        ring-down is larger by the factor (k + T0(a)/a)/(k + T0'(a)), since the energy of the mode
        changes with its amplitude by the *tangent* stiffness T0' = dT0/da.
        """
        return self._mode(amplitude, method, harmonics)[1]

    def _mode(self, amplitude: ArrayLike, method: str, harmonics: Sequence[int]) -> tuple[Any, Any]:
        if method not in get_args(ModeMethod):
            raise InputError(f"`method` must be {quoted(get_args(ModeMethod))}, got {show(method)}")
        shaped = self.joint._amplitudes(amplitude, None)
        a = shaped.reshape(-1)
        alone = {0, *harmonic_basis(harmonics, MOST_SAMPLES).harmonics} == {0, 1}
        if method == "quasi-static":
            omega, ratio = self._closed(a, np.asarray(self.joint.secant_stiffness(a)))
            ratio = ratio + self.viscous_damping_ratio
        elif alone or not math.isfinite(self.joint.tangential_stiffness):
            omega, ratio = self._fundamental(a)
        else:
            omega, ratio = self._fundamental(np.zeros(a.size))
            moves = a > 0.0
            if moves.any():
                omega[moves], ratio[moves] = self._balanced(a[moves], harmonics)
        return plain(omega.reshape(shaped.shape)), plain(ratio.reshape(shaped.shape))

    def _closed(self, a: Floats, joint_stiffness: Floats) -> tuple[Floats, Floats]:
        stiffness = self.stiffness + joint_stiffness
        secant = np.asarray(self.joint.secant_stiffness(a))
        with np.errstate(invalid="ignore", divide="ignore"):
            share = np.where(np.isinf(stiffness), 1.0, secant / stiffness)
        ratio = np.asarray(self.joint.damping_ratio(a)) * np.where(a > 0.0, share, 0.0)
        return np.sqrt(stiffness / self.mass), ratio

    def _fundamental(self, a: Floats) -> tuple[Floats, Floats]:
        blocks = np.split(a, range(_BLOCK, a.size, _BLOCK)) if a.size else []
        parts = [averaged_stiffness(self.joint, block) for block in blocks]
        omega, ratio = self._closed(a, np.concatenate([np.zeros(0), *parts]))
        return omega, ratio + 0.5 * self.viscous_coefficient / (self.mass * omega)

    def _balanced(self, a: Floats, harmonics: Sequence[int]) -> tuple[Floats, Floats]:
        from microslip.structures.structure import Structure

        dashpot = self.viscous_coefficient
        structure = Structure([[self.mass]], [[self.stiffness]], [[dashpot]] if dashpot else None)
        mode = structure.attach(self.joint, directions=[1.0])
        curve = mode.modes(0, a * math.sqrt(self.mass), harmonics=harmonics)
        return 2.0 * math.pi * curve.frequency, curve.damping_ratio

    # -- the free oscillation ---------------------------------------------------------------------

    def ring_down(
        self,
        amplitude: float,
        *,
        cycles: int | None = None,
        duration: float | None = None,
        samples_per_cycle: int = 100,
    ) -> RingDown:
        """Integrate the free oscillation after a release at rest, with the state of the joint.

        Parameters
        ----------
        amplitude : float
            Displacement [m] to which the joint is loaded first, and at which the mass is released.
        cycles : int, optional
            Number of cycles, of two turning points each.
        duration : float, optional
            Duration [s], in place of ``cycles``.
        samples_per_cycle : int, optional
            Time steps per period with a sticking joint, the shortest period; at least 8. For a
            joint that is rigid at rest: per period with a sliding joint.

        Returns
        -------
        RingDown
            Times, displacements, velocities, joint forces and energies; turning points; and the
            amplitude, frequency and damping ratio of each cycle, from the turning points. It ends
            early when a joint that is rigid at rest stops the mass.

        Notes
        -----
        Each step integrates the linear oscillator with a sticking joint exactly (Nigam and
        Jennings, Bull. Seismol. Soc. Am. 59, 909, 1969). The joint force minus that of the sticking
        joint is a cubic in time through its values and rates at both ends of the step; the values
        at the end are found by iteration, with trials of the joint force. Steps are divided at
        turning points, where the joint reverses. The method is therefore symmetric in time, of
        fourth order for smooth backbones, exact while the joint sticks, and adds no numerical
        damping.
        """
        a = positive("amplitude", amplitude, "m", 1e-6)
        if (cycles is None) == (duration is None):
            came = "neither" if cycles is None else "both"
            raise InputError(
                f"ring_down needs cycles=... or duration=... [s], one of them, got {came}"
            )
        if duration is not None:
            duration = positive("duration", duration, "s")
        else:
            cycles = whole_number("cycles", cycles, 1, MOST_CYCLES)
        per_cycle = whole_number("samples_per_cycle", samples_per_cycle, 8, 1_000_000)
        system = self.joint, self.mass, self.stiffness, self.viscous_coefficient, self._stuck
        return ring_down(*system, a, cycles, duration, per_cycle)
