"""Every asperity by itself: the long way round to the force of a rough interface.

Each summit carries its own friction state (the reversals it still remembers, the offset of its
present branch, whether it slides as a whole) and follows the equations of chapter 19 of *The
Mechanics of Jointed Structures* (DOI 10.1007/978-3-319-56818-8_19), (19.15)-(19.24), with their
misprints removed:

- the compliance of (19.11) is 1/G*, so that delta_L = 3 mu N / (16 a G*), (19.12);
- the factor 1/2 of (19.13)-(19.23) stands inside the power 3/2;
- (19.13) ends with + T_max, like (19.20); the sliding force of (19.17) is + mu N;
- max|T_id| of (19.21) and (19.22) is -T_B with its sign, max(T_ic) of (19.23) and (19.24) is T_C
  with its sign.

The chapter stops before a small loop closes. Here an asperity that returns to its own previous
reversal forgets the loop and goes on along the branch that the loop had interrupted, and an
asperity that slides as a whole forgets everything (Madelung's rules, one asperity at a time).

It uses nothing that is known about the sum, hence it checks, and is timed against, methods that do.
"""

from __future__ import annotations

import math
from statistics import NormalDist
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


class ExplicitPopulation:
    """An interface of n asperities under constant normal load, each with a state of its own.

    Parameters
    ----------
    indentations : array_like, shape (n,)
        Indentation of each summit [m]. Summits at or below zero do not touch and are left out.
    normal_loads : array_like, shape (n,)
        Normal load N_i on each summit [N].
    slip_limits : array_like, shape (n,)
        Displacement delta_Li at which each summit starts to slide as a whole [m].
    friction_coefficient : float
        Coulomb coefficient mu [-].

    Raises
    ------
    ValueError
        If the shapes differ, nothing touches, or a load or a slip limit in contact is not positive.
    """

    def __init__(
        self,
        indentations: ArrayLike,
        normal_loads: ArrayLike,
        slip_limits: ArrayLike,
        friction_coefficient: float,
    ) -> None:
        indentation, load, limit = (
            np.array(values, dtype=np.float64, ndmin=1)
            for values in (indentations, normal_loads, slip_limits)
        )
        if not (indentation.ndim == 1 and indentation.shape == load.shape == limit.shape):
            raise ValueError(
                "indentations, normal_loads and slip_limits must be one-dimensional and of one"
                f" shape, got {indentation.shape}, {load.shape} and {limit.shape}"
            )
        touching = indentation > 0
        if not touching.any():
            raise ValueError("at least one indentation must be positive, got none")
        self.normal_loads: Floats = load[touching]
        self.slip_limits: Floats = limit[touching]
        if not (np.all(self.normal_loads > 0) and np.all(self.slip_limits > 0)):
            raise ValueError("normal_loads and slip_limits must be positive where summits touch")
        self._friction_forces: Floats = float(friction_coefficient) * self.normal_loads
        self.reset()

    @classmethod
    def from_heights(
        cls,
        heights: ArrayLike,
        radii: ArrayLike,
        *,
        composite_modulus: float,
        composite_shear_modulus: float,
        friction_coefficient: float,
        separation: float,
        summits_per_height: float = 1.0,
    ) -> ExplicitPopulation:
        """Build the interface from summit heights by Hertz and Mindlin.

        Contact radius (19.1), load (19.3) and slip limit (19.12) of each summit.

        Parameters
        ----------
        heights, radii : array_like, shape (n,) or scalar radii
            Summit heights [m] and radii [m].
        composite_modulus, composite_shear_modulus : float
            E* (19.4) and G* (19.11) [Pa].
        friction_coefficient : float
            Coulomb coefficient mu [-].
        separation : float
            Distance of the rigid plane from the zero of the heights [m].
        summits_per_height : float
            How many equal summits each height stands for [-].

        Returns
        -------
        ExplicitPopulation
            The interface at rest.
        """
        indentation = np.array(heights, dtype=np.float64, ndmin=1) - separation
        radius = np.broadcast_to(np.asarray(radii, dtype=np.float64), indentation.shape)
        touching = indentation > 0
        indentation, radius = indentation[touching], radius[touching]
        contact_radius = np.sqrt(radius * indentation)
        load = 4 / 3 * composite_modulus * np.sqrt(radius) * indentation**1.5
        limit = 3 / 16 * friction_coefficient * load / (contact_radius * composite_shear_modulus)
        return cls(indentation, summits_per_height * load, limit, friction_coefficient)

    @property
    def contact_count(self) -> int:
        """Number of asperities carried [-]."""
        return int(self.normal_loads.size)

    @property
    def normal_load(self) -> float:
        """Sum of the normal loads [N], (19.27)."""
        return float(self.normal_loads.sum())

    @property
    def force_limit(self) -> float:
        """Force at which everything slides [N]."""
        return float(self._friction_forces.sum())

    @property
    def asperity_forces(self) -> Floats:
        """Tangential force of each asperity in the present state [N], shape (n,)."""
        bracket = self._fill_bracket()
        return self._base + self._amplitude * bracket * np.sqrt(bracket)

    @property
    def open_reversals(self) -> NDArray[np.int64]:
        """Number of reversals each asperity still remembers [-], shape (n,)."""
        return self._depth.copy()

    @property
    def has_slid(self) -> NDArray[np.bool_]:
        """Whether each asperity had slid as a whole by its last reversal, shape (n,)."""
        return self._slid.copy()

    def reset(self) -> None:
        """Go back to rest: no displacement, no force, nothing remembered."""
        n = self.normal_loads.size
        self._displacement = 0.0
        self._direction = 0.0
        self._depth = np.zeros(n, dtype=np.int64)
        self._slid = np.zeros(n, dtype=np.bool_)
        # What an asperity remembers, one row of n a reversal: where it turned, and the two numbers
        # (see below) of the branch that it began there. Flat, since one index gathers faster.
        self._turned_at: Floats = np.empty(4 * n)
        self._constants: Floats = np.empty(4 * n)
        self._bases: Floats = np.empty(4 * n)
        # The present branch of each asperity: force = base + amplitude * bracket**1.5, with
        # bracket = constant + slope * displacement, and the displacement where the branch ends.
        self._constant: Floats = np.ones(n)
        self._slope: Floats = np.zeros(n)
        self._amplitude: Floats = np.zeros(n)
        self._base: Floats = np.zeros(n)
        self._end: Floats = np.full(n, np.inf)
        self._base_sum = 0.0
        self._next_end = math.inf
        self._column = np.arange(n)
        self._bracket: Floats = np.empty(n)
        self._work: Floats = np.empty(n)

    def step(self, displacement: float) -> float:
        """Move to a displacement and return the force of the interface, (19.28).

        Parameters
        ----------
        displacement : float
            Relative tangential displacement [m].

        Returns
        -------
        float
            Sum of the forces of all asperities [N].
        """
        target = float(displacement)
        if not math.isfinite(target):
            raise ValueError(f"displacement must be finite, got {displacement!r}")
        if target != self._displacement:
            direction = 1.0 if target > self._displacement else -1.0
            if direction != self._direction:
                self._turn(direction)
            self._displacement = target
            self._close_loops()
        bracket = self._fill_bracket()
        np.sqrt(bracket, out=self._work)
        self._work *= bracket
        self._work *= self._amplitude
        return self._base_sum + float(self._work.sum())

    def force(self, history: ArrayLike) -> Floats:
        """Force along a displacement history that starts from rest.

        Parameters
        ----------
        history : array_like, shape (m,)
            Displacements [m].

        Returns
        -------
        ndarray, shape (m,)
            Forces [N].
        """
        self.reset()
        record = np.asarray(history, dtype=np.float64)
        return np.array([self.step(value) for value in record.ravel()]).reshape(record.shape)

    def dissipated_energy(self, amplitude: ArrayLike) -> Any:
        """Energy lost in one cycle between +amplitude and -amplitude, asperity by asperity.

        The area (19.29) of one asperity's loop is, with r = 1 - T_m / mu N,

            (24/5) mu N delta_L {1 - r^(5/3) - (5/6) (1 - r) (1 + r^(2/3))},

        and 4 mu N (delta_m - delta_L) more beyond the slip limit. With w = r^(1/3) the brace is
        (1 - w)^3 (1 + 3 w + w^2) / 6, which keeps all digits at small amplitude.

        Parameters
        ----------
        amplitude : array_like
            Displacement amplitudes delta_m >= 0 [m].

        Returns
        -------
        float or ndarray, same shape as amplitude
            Energies [J].
        """
        amplitudes = np.asarray(amplitude, dtype=np.float64)
        energies = np.array([self._cycle_energy(value) for value in amplitudes.ravel()])
        return energies.reshape(amplitudes.shape)[()]

    def _cycle_energy(self, amplitude: float) -> float:
        fraction = np.minimum(amplitude / self.slip_limits, 1.0)
        w = np.sqrt(1.0 - fraction)
        loop = 0.8 * (fraction / (1.0 + w)) ** 3 * (1.0 + 3.0 * w + w * w) * self.slip_limits
        sliding = 4.0 * np.maximum(amplitude - self.slip_limits, 0.0)
        return float(np.sum(self._friction_forces * (loop + sliding)))

    def _fill_bracket(self) -> Floats:
        """What is raised to 3/2; zero when sliding, the second lines of (19.15)-(19.17)."""
        np.multiply(self._slope, self._displacement, out=self._bracket)
        self._bracket += self._constant
        np.maximum(self._bracket, 0.0, out=self._bracket)
        return self._bracket

    def _turn(self, direction: float) -> None:
        """Reverse all asperities; each remembers its own force and begins its own branch."""
        turned_at, before, self._direction = self._displacement, self._direction, direction
        if before == 0.0:
            self._load_first(self._column)
        else:
            forces, sliding = self.asperity_forces, self._bracket <= 0.0
            forces[sliding] = before * self._friction_forces[sliding]
            self._slid |= sliding
            self._depth[sliding] = 0
            self._branch_off(turned_at, forces)
            self._remember(turned_at)
        self._set_ends(self._column)
        self._update_sums()

    def _branch_off(self, turned_at: float, forces: Floats) -> None:
        """Branch of each asperity after a reversal at the displacement `turned_at`."""
        limit, friction = self.slip_limits, self._friction_forces
        if self._direction < 0.0:
            # Unloading from A or C, (19.20) and (19.23); (19.16) when T_C is the sliding force.
            stuck = np.cbrt(np.maximum(1.0 - forces / friction, 0.0)) ** 2
            delta_0 = (limit - limit * stuck) - turned_at  # (19.24)
            self._constant = 0.5 * (delta_0 / limit + stuck + 1.0)
            self._slope = 0.5 / limit
            self._amplitude = 2.0 * friction
            self._base = forces - 2.0 * friction
        else:
            # Reloading from B, (19.21) with -T_B for max|T_id|; (19.17) after sliding.
            stuck = np.cbrt(np.maximum(1.0 + forces / friction, 0.0)) ** 2
            delta_0 = turned_at - (-limit + limit * stuck)  # (19.22)
            self._constant = -0.5 * (-delta_0 / limit - stuck - 1.0)
            self._slope = -0.5 / limit
            self._amplitude = -2.0 * friction
            self._base = forces + 2.0 * friction

    def _remember(self, turned_at: float) -> None:
        place = self._depth * self._column.size + self._column
        if place.max() >= self._turned_at.size:
            for name in ("_turned_at", "_constants", "_bases"):
                old = getattr(self, name)
                setattr(self, name, np.concatenate([old, np.empty_like(old)]))
        self._turned_at[place] = turned_at
        self._constants[place] = self._constant
        self._bases[place] = self._base
        self._depth += 1

    def _close_loops(self) -> None:
        """Let each asperity forget the loops that it has closed."""
        sense = self._direction
        if (self._displacement - self._next_end) * sense < 0.0:
            return
        before = self._depth.copy()
        closed = np.flatnonzero((self._displacement - self._end) * sense >= 0.0)
        while closed.size:
            self._depth[closed] -= np.minimum(self._depth[closed], 2)
            self._set_ends(closed)
            closed = closed[(self._displacement - self._end[closed]) * sense >= 0.0]
        changed = np.flatnonzero(self._depth != before)
        self._load_first(changed[self._depth[changed] == 0])
        resumed = changed[self._depth[changed] > 0]
        place = (self._depth[resumed] - 1) * self._column.size + resumed
        self._constant[resumed] = self._constants[place]
        self._base[resumed] = self._bases[place]
        self._update_sums()

    def _load_first(self, index: NDArray[np.int64]) -> None:
        """Put asperities that remember no reversal on first loading, (19.19) and its mirror.

        One that slid before has no such curve to go back to: it slides on.
        """
        sense, friction = self._direction, self._friction_forces[index]
        sliding = self._slid[index]
        self._constant[index] = np.where(sliding, 0.0, 1.0)
        self._slope[index] = np.where(sliding, 0.0, -sense / self.slip_limits[index])
        self._amplitude[index] = -sense * friction
        self._base[index] = sense * friction

    def _set_ends(self, index: NDArray[np.int64]) -> None:
        """Find the displacement at which the present branch of each asperity closes a loop.

        That is the reversal before the last. Before the first reversal there is the first loading,
        met again at the mirror point; sliding as a whole ends in nothing.
        """
        depth = self._depth[index]
        end = self._turned_at[np.maximum(depth - 2, 0) * self._column.size + index]
        np.negative(end, out=end, where=depth == 1)
        endless = (depth == 0) | ((depth == 1) & self._slid[index])
        end[endless] = self._direction * np.inf
        self._end[index] = end

    def _update_sums(self) -> None:
        self._base_sum = float(self._base.sum())
        self._next_end = float(self._end.min() if self._direction > 0.0 else self._end.max())


def gaussian_population(
    sample_count: int, *, std: float, mean: float = 0.0, separation: float = -math.inf
) -> tuple[Floats, float]:
    """Heights that stand for a Gaussian surface, without chance: mid-points of equal quantiles.

    The part of the distribution above `separation` is cut into `sample_count` strata of equal
    probability and each is represented by its median. A surface of N_a summits is then
    ``summits_per_height = N_a * probability / sample_count`` summits at each height, and sums over
    the heights converge to the integrals (19.6)-(19.8).

    Parameters
    ----------
    sample_count : int
        Number of heights.
    std, mean : float
        Standard deviation [m] and mean [m] of all summits.
    separation : float
        Only summits above this height are represented [m]; by default all are.

    Returns
    -------
    heights : ndarray, shape (sample_count,)
        Heights in ascending order [m].
    probability : float
        Probability (19.5) that a summit is above `separation` [-].
    """
    h = (separation - mean) / std
    probability = 0.5 * math.erfc(h / math.sqrt(2.0))
    quantile = NormalDist().inv_cdf
    # Counted from the upper tail, where a probability near one would lose its digits.
    tails = (np.arange(sample_count, 0, -1) - 0.5) * (probability / sample_count)
    return mean - std * np.array([quantile(float(p)) for p in tails]), probability
