"""Normal laws of entire faces that were tightened once to a pressure and are elastic below it."""

from __future__ import annotations

import math
from abc import abstractmethod
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, exact, number
from microslip._core.errors import InputError
from microslip._core.frozen import assign
from microslip._core.verdicts import Verdict
from microslip.contact.base import NormalLaw
from microslip.contact.materials import MaterialPair
from microslip.contact.table import TabulatedNormalLaw
from microslip.contact.validity import surface_verdicts

_SAMPLES = 24  # points of the table above the heaviest load
_DEEP = 1e-2  # depth [m] of a straight end for trial steps
_BEYOND = 1e6  # times the heaviest load, to which steps of static solutions go


class FirstLoading(NamedTuple):
    """First-loading curve of a face up to its tightening pressure, from light to heavy.

    A load-deflection test measures the slope of this curve; ultrasound measures the larger
    stiffness of unloading.
    """

    pressure: Floats
    """Mean pressures [Pa]."""
    separation: Floats
    """Distances of the mean planes [m]."""
    stiffness: Floats
    """Slopes -dN/dd of the load on the area [N/m]."""


class FaceErrors(NamedTuple):
    """Standard deviations of ln k_n [-] due to the table, to the limited area and to the inputs."""

    table: float
    """Error of the table against boundary elements."""
    realisation: float
    """Difference between a face of the area of the law and the mean of many such faces."""
    inputs: float
    """Effect of the uncertainty of the inputs, such as the rms height and the hardness."""

    @property
    def total(self) -> float:
        """Root of the sum of squares of the three errors [-]."""
        return math.hypot(*self)


class FaceLaw(TabulatedNormalLaw):
    """Law of a face that was tightened: a table of N(d) on unloading from the tightening load."""

    area: float
    direction: float | None

    def _set_curve(
        self, pair: MaterialPair, separation: Floats, share: Floats, heaviest: float, rate: float
    ) -> None:
        """Set the table of the law.

        ``share`` are the loads over ``heaviest`` [N] at ``separation`` [m], decreasing from 1, and
        ``rate`` is -d ln N/dd [1/m] at the heaviest load. The table is extrapolated beyond this
        load for trial steps of static solutions.
        """
        beyond = np.log(_BEYOND) * (np.arange(_SAMPLES, 0, -1) / _SAMPLES) ** 2
        steepest = max(rate, (share[0] - share[1]) / (separation[1] - separation[0]))
        d = np.concatenate([separation[0] - beyond / steepest, separation])
        loads = np.concatenate([np.exp(beyond), share]) * heaviest
        TabulatedNormalLaw.__init__(self, pair, d, loads, tail="exponential")

    @property
    @abstractmethod
    def first_loading(self) -> FirstLoading:
        """First-loading curve up to tightening: pressures, separations, stiffnesses."""

    @property
    @abstractmethod
    def _tightening(self) -> float:
        """Tightening pressure [Pa]."""

    @property
    @abstractmethod
    def _tangential(self) -> Floats:
        """Ratio of tangential to normal stiffness [-], a (2, 2) tensor in the plane."""

    def slip_per_indentation(self, direction: float | None = None) -> float:
        """Return k_n/k_t [-], the slip per indentation for a friction coefficient of one.

        This ratio of normal to tangential stiffness times the friction coefficient is kappa: the
        tangential displacement at which a contact slips, over its indentation.

        Parameters
        ----------
        direction : float, optional
            Direction of the motion [rad] from x of the face; None is the mean of all directions.
        """
        if direction is None:
            return 2.0 / float(np.trace(self._tangential))
        direction = number("direction", direction, "rad")
        e = np.array([math.cos(direction), math.sin(direction)])
        return 1.0 / float(e @ self._tangential @ e)

    @property
    def validity(self) -> tuple[Verdict, ...]:
        """Verdicts on the assumptions of the law at the tightening load."""
        return surface_verdicts(self, self.closest)

    @cached_property
    def _first(self) -> NormalLaw:
        if self._length_factors(np.ones(1)) is None:
            return self
        loading = self.first_loading
        d, loads = loading.separation[::-1], loading.pressure[::-1] * self.area
        # A table of few secants is made convex, from its light end.
        slopes = np.maximum.accumulate((-np.diff(loads) / np.diff(d))[::-1])
        loads = loads[-1] + np.append(np.cumsum(slopes * np.diff(d)[::-1])[::-1], 0.0)
        # Beyond the tightening it goes on for the trial steps of static solutions.
        beyond = np.log(_BEYOND) * (np.arange(_SAMPLES, 0, -1) / _SAMPLES) ** 2
        d = np.concatenate([d[0] - beyond * loads[0] / slopes[-1], d])
        loads = np.concatenate([loads[0] * np.exp(beyond), loads])
        slope = (loads[0] - loads[1]) / (d[1] - d[0])
        d, loads = np.append(d[0] - _DEEP, d), np.append(loads[0] + 1.1 * slope * _DEEP, loads)
        return TabulatedNormalLaw(self.pair, d, loads, tail="exponential")

    def _length_factors(self, shares: Floats) -> Floats | None:
        """Return the lengths p/k_n of differently tightened areas, over that of this face [-].

        p is the tightening pressure and k_n the normal stiffness per area on unloading. ``shares``
        are the tightening loads of the areas over that of this face [-]. None for an elastic face.
        """
        return None

    def _tightened_by(self, shares: Floats) -> tuple[Floats, Floats] | None:
        lengths = self._length_factors(shares)
        if lengths is None:
            return None
        # Under its tightening load a place is at the separation of first loading.
        loading = self.first_loading
        pressures, separations = np.log(loading.pressure), loading.separation
        at = np.interp(np.log(shares * self._tightening), pressures, separations)
        slope = (separations[1] - separations[0]) / (pressures[1] - pressures[0])
        lightest = np.log(shares * self._tightening) - pressures[0]
        at += np.minimum(lightest, 0.0) * slope
        return lengths, at - lengths * self.closest

    @property
    def stiffness_ratio(self) -> float:
        """Ratio of normal to tangential stiffness in the direction of motion [-]."""
        return self.slip_per_indentation(self.direction)

    @property
    def _lay(self) -> Floats | None:
        if self.direction is None:
            return None
        c, s = math.cos(self.direction), math.sin(self.direction)
        turn = np.array([[c, -s], [s, c]])
        tensor = turn.T @ self._tangential @ turn
        return np.asarray(tensor / tensor[0, 0])

    @property
    def _heaviest(self) -> float:
        return self._tightening * self.area

    @property
    def closest(self) -> float:
        """Separation of the mean planes [m] under the tightening load."""
        return float(np.asarray(self.separations)[_SAMPLES])

    @property
    def _span(self) -> tuple[float, float]:
        return self.closest, TabulatedNormalLaw._span.fget(self)[1]  # type: ignore[attr-defined]

    def _separations(self, value: ArrayLike) -> Floats:
        return NormalLaw._separations(self, value)  # also closer, for steps of static solutions

    def _check_rest(self, loads: Floats) -> None:
        share = float(np.max(loads, initial=0.0)) / self._heaviest
        if share > 1.0 + 1e-6:
            raise InputError(
                f"`tightening_pressure` must be at least {share * self._tightening:.4g} "
                f"Pa, the pressure of the most loaded area, got "
                f"{exact(self._tightening)} Pa: solve the face with a higher one"
            )

    def _solve(self, loads: Floats) -> Floats:
        heaviest = self._heaviest
        if loads.max() > heaviest * (1.0 + 1e-9):
            raise InputError(
                f"`load` must be at most the tightening load or the heaviest that was solved, "
                f"{heaviest:.8g} N, above which the face yields again, got {exact(loads.max())} N; "
                "use a higher `tightening_pressure`"
            )
        return super()._solve(np.minimum(loads, heaviest))


def checked_direction(law: FaceLaw, direction: float | None) -> None:
    """Validate a direction [rad], and set it as the attribute ``direction`` of ``law``."""
    if direction is not None:
        direction = number("direction", direction, "rad")
    assign(law, direction=direction)
