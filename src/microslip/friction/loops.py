"""Closed hysteresis loops and their measures.

Equation numbers (19.x) are those of chapter 19, DOI 10.1007/978-3-319-56818-8_19.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core.checks import Floats, record, show, sized, whole_number
from microslip._core.errors import InputError
from microslip._core.frozen import Locked, assign, lock
from microslip.figures.plottable import Plottable

if TYPE_CHECKING:
    from microslip.figures.plot import Plot

MOST_LOOP_SAMPLES = 10_000_000


@dataclass(frozen=True, eq=False)
class Loop(Locked, Plottable):
    """Sampled closed cycle of displacement and force; the first sample is repeated at the end.

    Parameters
    ----------
    displacement : array_like
        Displacements [m], one-dimensional, at least four, in time order.
    force : array_like
        Forces [N], one for each displacement.

    Notes
    -----
    The amplitudes delta_m and T_m are half the range of displacement and force, so measures do not
    depend on the mean. The energy has an error of second order in the sample spacing. Methods of
    the law, such as ``joint.dissipated_energy(amplitude)``, do not have this error.
    """

    displacement: NDArray[np.float64]
    force: NDArray[np.float64]

    def __init__(self, displacement: ArrayLike, force: ArrayLike) -> None:
        x, t = record("displacement", displacement, "m"), record("force", force, "N")
        if x.ndim != 1 or x.shape != t.shape or x.size < 4:
            raise InputError(
                "`displacement` and `force` must have the same length, at least four samples, "
                f"got {x.size} and {t.size}"
            )
        if x.min() == x.max():
            raise InputError(f"`displacement` must vary, got {x[0]:g} m throughout")
        assign(self, displacement=lock(x.copy()), force=lock(t.copy()))

    @cached_property
    def displacement_amplitude(self) -> float:
        """Amplitude of the displacement [m], half its range."""
        return 0.5 * float(np.ptp(self.displacement))

    @cached_property
    def force_amplitude(self) -> float:
        """Amplitude of the force [N], half its range."""
        return 0.5 * float(np.ptp(self.force))

    @cached_property
    def energy_ratio(self) -> float:
        """Energy ratio E_d/(4 delta_m T_m) [-]: 1 for a rigid-plastic loop, 0 without loss."""
        if self.force_amplitude == 0.0:
            return 0.0
        x = (self.displacement - self.displacement[0]) / self.displacement_amplitude
        t = (self.force - self.force[0]) / self.force_amplitude
        # An open cycle is closed by the chord from the last to the first sample.
        area = 0.5 * (np.dot(t[1:] + t[:-1], np.diff(x)) - (t[-1] + t[0]) * (x[-1] - x[0]))
        return 0.25 * float(area)

    @property
    def dissipated_energy(self) -> float:
        """Area of the loop E_d [J] (19.29), positive if force leads displacement."""
        return 4.0 * self.energy_ratio * self.displacement_amplitude * self.force_amplitude

    @property
    def loss_factor(self) -> float:
        """Loss factor E_d/(pi delta_m T_m) [-]; (19.30) calls it the damping ratio."""
        return 4.0 / math.pi * self.energy_ratio

    @property
    def damping_ratio(self) -> float:
        """Equivalent viscous damping ratio [-], half the loss factor."""
        return 0.5 * self.loss_factor

    @property
    def secant_stiffness(self) -> float:
        """Secant stiffness [N/m]: force amplitude over displacement amplitude."""
        return self.force_amplitude / self.displacement_amplitude

    @cached_property
    def sliding_ratio(self) -> float:
        """Sliding ratio D [-]: width of the loop at its mean force over the range of displacement.

        Mean force is the middle of the range. After Fouvry, Kapsa and Vincent (Wear 185, 35, 1995):
        0 for an elastic loop, 1 for a rigid-plastic loop.
        """
        middle = 0.5 * (float(self.force.max()) + float(self.force.min()))
        t = np.append(self.force, self.force[0]) - middle
        x = np.append(self.displacement, self.displacement[0])
        crossing = np.flatnonzero((t[:-1] < 0.0) != (t[1:] < 0.0))
        if crossing.size < 2:
            return 0.0
        share = t[crossing] / (t[crossing] - t[crossing + 1])
        places = x[crossing] + share * (x[crossing + 1] - x[crossing])
        return float(np.ptp(places)) / float(np.ptp(self.displacement))

    @cached_property
    def closure_error(self) -> float:
        """Difference of the first and the last force over the range of force [-]."""
        gap, span = abs(float(self.force[-1] - self.force[0])), float(np.ptp(self.force))
        return gap / span if span > 0.0 else 0.0

    def _figure(self) -> Plot:
        from microslip._core.quantities import QUANTITIES
        from microslip.figures.kit import axis_of
        from microslip.figures.plot import Panel, Plot

        panel = Panel(
            axis_of(QUANTITIES["displacement"], float(np.abs(self.displacement).max())),
            axis_of(QUANTITIES["force"], float(np.abs(self.force).max())),
        )
        panel.line(self.displacement / panel.x.unit, self.force / panel.y.unit)
        panel.cross()
        return Plot([panel], 4.2)

    def __repr__(self) -> str:
        return (
            f"Loop({self.displacement.size} samples, "
            f"displacement_amplitude={self.displacement_amplitude:g}, "
            f"force_amplitude={self.force_amplitude:g})"
        )


@lru_cache(maxsize=32)
def unit_cycle(samples: int) -> tuple[Floats, int]:
    """Return a cycle of displacements with amplitude 1, and the index of its sample at -1.

    Samples go from +1 to -1 and back, denser at the turning points.
    """
    turn = (samples - 1) // 2
    down = np.cos(math.pi * np.arange(turn + 1) / turn)
    back = samples - 1 - turn
    up = -np.cos(math.pi * np.arange(1, back + 1) / back)
    down[turn], up[-1] = -1.0, 1.0
    return lock(np.concatenate((down, up))), turn


@lru_cache(maxsize=32)
def halves_of(samples: int) -> Floats:
    """Return half the distance of each sample of the unit cycle from the preceding reversal."""
    shape, turn = unit_cycle(samples)
    return lock(0.5 * np.concatenate((1.0 - shape[: turn + 1], 1.0 + shape[turn + 1 :])))


def checked_cycle(amplitude: float, samples: int) -> tuple[float, Floats, int]:
    """Check the amplitude [m]; return it and the results of :func:`unit_cycle`."""
    count = whole_number("samples", samples, 5, MOST_LOOP_SAMPLES)
    a = sized("amplitude", amplitude)
    if a.ndim > 0 or a <= 0.0:
        raise InputError(f"`amplitude` must be one number above zero [m], got {show(amplitude)}")
    return (float(a), *unit_cycle(count))
