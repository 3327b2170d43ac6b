"""An interface at many loads, amplitudes and coefficients of friction, all at once."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from microslip._core.checks import Floats, exact
from microslip.errors import InputError
from microslip.friction import Interface
from microslip.normal.grids import inverse_on_grid, on_grid, separations

Progress = Callable[[float], None]


class Grid:
    """An interface on the grid of coefficients, loads and amplitudes (i, j, k)."""

    def __init__(
        self, joint: Interface, axes: Mapping[str, Floats], name: str, progress: Progress | None
    ) -> None:
        self.surface = joint.surface
        self.friction = axes["friction_coefficient"].reshape(-1)
        self.load = axes["normal_load"].reshape(-1)
        self.given = axes[name].reshape(-1)
        self.by_force = name == "force_amplitude"
        if np.all(self.load == joint.normal_load):
            # Of a joint that was given by its separation that very one.
            self.separation = np.full(self.load.size, joint.separation)
        else:
            self.separation = separations(self.surface, self.load)
        self.kappa = self.friction * self.surface.stiffness_ratio
        self.limit = self.friction[:, None] * self.load
        # As in an interface: with it the limit is met exactly.
        self.factor = self.limit / self.surface._derivative(self.separation, 0)
        self.done = 0
        self.passes = 1
        self.progress = progress

    def values(self, names: Sequence[str]) -> dict[str, Floats]:
        """The quantities of these names."""
        needed = set(names)
        ratios = needed & {"energy_ratio", "loss_factor", "damping_ratio"}
        backbone = bool(ratios or needed & {"force_amplitude", "secant_stiffness"})
        energy = bool(ratios or needed & {"dissipated_energy", "dissipation_exponent"})
        self.passes = (
            self.by_force
            + (backbone and not self.by_force)
            + energy
            + len(needed & {"dissipation_exponent", "tangent_stiffness"})
        ) or 1
        if self.by_force:
            self.amplitude = self._amplitudes()
            force = np.broadcast_to(self.given, self.amplitude.shape)
        else:
            shape = self.friction.size, self.load.size, self.given.size
            self.amplitude = np.broadcast_to(self.given, shape)
            if backbone:
                force = np.minimum(
                    self.factor[..., None] * self._sum("drop"), self.limit[..., None]
                )
        a = self.amplitude
        if energy:
            lost = 8.0 * (self.factor * self.kappa[:, None])[..., None] * self._sum("excess")
        result: dict[str, Floats] = {}
        for name in names:
            if name == "amplitude":
                result[name] = a
            elif name == "force_amplitude":
                result[name] = force
            elif name == "dissipated_energy":
                result[name] = lost
            elif name in ratios:
                box = 4.0 * a * force
                ratio = np.divide(lost, box, out=np.zeros(a.shape), where=box > 0.0)
                scale = {"energy_ratio": 1.0, "loss_factor": 4.0, "damping_ratio": 2.0}[name]
                result[name] = ratio if scale == 1.0 else scale / math.pi * ratio
            elif name == "secant_stiffness":
                stiffness = np.broadcast_to(self._stiffness()[:, None], a.shape).copy()
                result[name] = np.divide(force, a, out=stiffness, where=a > 0.0)
            elif name == "dissipation_exponent":
                result[name] = self._exponent(lost)
            elif name == "tangent_stiffness":
                slope = (self.factor / self.kappa[:, None])[..., None]
                result[name] = slope * self._sum("fall")
            else:
                result[name] = self._scalar(name)
        if self.progress is not None:
            self.progress(1.0)
        return result

    def _scalar(self, name: str) -> Floats:
        if name == "separation":
            return self.separation
        if name == "normal_stiffness":
            return np.asarray(self.surface.stiffness(self.separation))
        if name == "tangential_stiffness":
            return self._stiffness()
        if name == "force_limit":
            return self.limit
        if name == "slip_per_indentation":
            return self.kappa
        if name == "stick_area":
            steps = np.minimum(self.amplitude, 1e200) / self.kappa[:, None, None]
            return np.asarray(self.surface.contact_area(self.separation[:, None] + steps))
        return np.asarray(getattr(self.surface, name)(self.separation))

    def _stiffness(self) -> Floats:
        return np.asarray(self.surface.stiffness(self.separation) / self.surface.stiffness_ratio)

    def _report(self, share: float) -> None:
        if self.progress is not None:
            self.progress(min((self.done + share) / self.passes, 1.0))

    def _sum(self, kind: Any) -> Floats:
        """A sum of the normal law over the whole grid."""
        if self.by_force:
            steps = np.minimum(self.amplitude, 1e200) / self.kappa[:, None, None]
            rows = np.tile(self.separation, self.friction.size)
            flat = on_grid(self.surface, kind, rows, steps.reshape(rows.size, -1), self._report)
            result = flat.reshape(self.amplitude.shape)
        else:
            # All loads share the steps, those of every coefficient of friction side by side.
            steps = np.minimum(self.given, 1e200) / self.kappa[:, None]
            flat = on_grid(self.surface, kind, self.separation, steps.reshape(-1), self._report)
            result = np.moveaxis(flat.reshape(self.load.size, *steps.shape), 0, 1)
        self.done += 1
        return result

    def _amplitudes(self) -> Floats:
        """Displacement amplitudes that belong to the given forces."""
        i, j = np.unravel_index(int(np.argmin(self.limit)), self.limit.shape)
        largest = float(self.given.max())
        if largest >= self.limit[i, j]:
            raise InputError(
                "`force_amplitude` must stay below the force limit at every load, and at "
                f"{exact(self.load[j])} N it is {self.limit[i, j]:.10g} N; got {largest:.10g} N"
            )
        drops = self.given / self.factor[..., None]
        rows = np.tile(self.separation, self.friction.size)
        steps = inverse_on_grid(self.surface, drops.reshape(rows.size, -1), rows, self._report)
        self.done += 1
        return np.asarray(self.kappa[:, None, None] * steps.reshape(drops.shape))

    def _exponent(self, lost: Floats) -> Floats:
        slope = 8.0 * self.factor[..., None] * self._sum("excess_slope")
        nothing = np.full(lost.shape, np.nan)
        exponent = np.divide(self.amplitude * slope, lost, out=nothing, where=lost > 0.0)
        # Where the energy underflows the limit of small amplitudes holds, if there is one.
        bends = self.surface._derivative(self.separation, 2) > 0.0
        return np.where(np.isnan(exponent) & bends[:, None], 3.0, exponent)
