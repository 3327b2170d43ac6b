"""A joint in two tangential directions."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, floats, plain, show, sized, whole_number
from microslip._core.frozen import Locked, lock
from microslip.errors import InputError
from microslip.friction.base import BackboneLaw, CellModel
from microslip.friction.field_cycles import _orders, _samples, _transform
from microslip.friction.vector_cycles import SETTLED, VectorCycle, settle, transform_slopes
from microslip.memory.vector_state import VectorState

MOST_SLIDERS = 100_000
_MOST_IN_STATE = 100_000_000  # sliders of all joints of a state


@dataclass(frozen=True, eq=False)
class IsotropicJoint(Locked):
    """A joint that moves in two tangential directions, the same in all, at a held normal load.

    Parameters
    ----------
    joint : BackboneLaw
        The law along any line, of finite stiffness at rest.
    sliders : int, optional
        Number of sliders [-] that stand for its density, 1 to 100 000.
    smallest_amplitude, largest_amplitude : float, optional
        Range of amplitudes [m] that they are for, see :meth:`BackboneLaw.to_iwan`; without it 0.01
        to 10 times the displacement at which the first tangent meets the force limit.

    Notes
    -----
    No closed law exists in two directions: even for one sphere the answer depends on the path
    (Mindlin and Deresiewicz 1953, DOI 10.1115/1.4010702). Assumed here is that every slider of the
    law's density (Iwan 1966, DOI 10.1115/1.3625199) has the same limit in all directions, slips
    along the force that it holds, and knows of no other. Along a line that is the joint itself, to
    the error in ``line.fit``; the force limit is exact. A straight step, however long, ends
    exactly where many small ones do, and the stiffness is that of the step.
    """

    joint: BackboneLaw
    sliders: int = 64
    smallest_amplitude: float | None = field(default=None, kw_only=True)
    largest_amplitude: float | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        if not isinstance(self.joint, BackboneLaw):
            raise InputError(f"joint must be a backbone law, got {show(self.joint)}")
        check_sliders(self.sliders, 1)
        _ = self.line  # which refuses what it cannot be

    @cached_property
    def line(self) -> CellModel:
        """The law along any line: its sliders as Iwan's cells, whose ``fit`` tells their errors."""
        reach = self.joint.force_limit / self.joint.tangential_stiffness
        low = self.smallest_amplitude
        if low is None and self.largest_amplitude is None and math.isfinite(reach) and reach > 0.0:
            low = 0.01 * reach
        return self.joint.to_iwan(
            int(self.sliders), smallest_amplitude=low, largest_amplitude=self.largest_amplitude
        )

    @property
    def force_limit(self) -> float:
        """Force of gross slip in any direction [N]."""
        return self.line.force_limit

    # What the state of sliders asks for.

    @cached_property
    def _tops(self) -> Floats:
        return lock(np.array(self.line.sliders().yield_displacements))

    @cached_property
    def _weights(self) -> Floats:
        return lock(np.array(self.line.sliders().stiffnesses))

    def start(self, nodes: int | None = None, *, energies: bool = False) -> VectorState:
        """A state at rest, of this joint or of many that move each by itself.

        Without a number of ``nodes`` [-] there is one, without an axis of its own. With
        ``energies`` it counts what is dissipated, which takes its time.
        """
        if nodes is not None:
            whole_number("nodes", nodes, 1, _MOST_IN_STATE // self._tops.size)
        return VectorState(_ConstantLoad(self, int(nodes or 1)), nodes is None, bool(energies))

    def force(self, displacement: ArrayLike) -> Floats:
        """Forces [N] along a path [m] of straight lines from rest, both of shape (samples, 2)."""
        x = _path("displacement", displacement)
        state, forces = self.start(), np.empty(x.shape)
        for i, row in enumerate(x):
            forces[i], _ = state.try_(row)
            state.commit()
        return forces

    def circle_energy(self, amplitude: ArrayLike) -> Any:
        """Energy [J] that a turn around a circle dissipates once it has settled, in closed form.

        For radii [m] of any shape the sum of 2 pi k u sqrt(a^2 - u^2) over the sliders that yield
        at u < a.
        """
        a = sized("amplitude", amplitude)
        if a.min() < 0.0:
            raise InputError(f"amplitude must not be negative, got {a.min():g}")
        squares = np.maximum(a[..., None] ** 2 - self._tops**2, 0.0)
        return plain(np.asarray(2.0 * math.pi * np.sqrt(squares) @ (self._weights * self._tops)))

    def periodic(self, displacement_cycle: ArrayLike, *, tolerance: float = SETTLED) -> VectorCycle:
        """The settled cycle of a periodic path.

        Parameters
        ----------
        displacement_cycle : array_like
            One period of displacements [m], shape (samples, 2), its first sample not repeated.
        tolerance : float, optional
            Share of the force limit [-]: a cycle that changes by less from one period to the next
            counts as settled. Sliders that hardly slip near their end change like the inverse
            square of the number of periods, so that less takes long.

        Returns
        -------
        VectorCycle
            ``force`` [N], shape (samples, 2), and ``derivative``, see there.
        """
        places = _path("displacement_cycle", displacement_cycle)[None]
        steps, nothing = np.zeros(places.shape[:2]), np.zeros((places.shape[1], 0))
        bank = _ConstantLoad(self, 1)
        force, _, passes = settle(bank, places, steps, nothing, nothing, tolerance)
        return VectorCycle(lock(force[0]), None, passes, bank, places, steps, tolerance)

    def harmonics(
        self,
        coefficients: ArrayLike,
        harmonics: Any = (0, 1),
        *,
        samples: int = 64,
        tolerance: float = SETTLED,
    ) -> tuple[Floats, Floats]:
        """Fourier coefficients of the settled force with their Jacobian.

        Parameters
        ----------
        coefficients : array_like
            Coefficients of both displacements [m], shape (2, coefficients), in the order of
            ``harmonics``: [mean,] cos 1, sin 1, cos 3, sin 3 for (0, 1, 3).
        harmonics : sequence of int, optional
            Numbers of the harmonics, rising; 0 is the mean.
        samples : int, optional
            Equidistant samples of the period [-]; the error falls with their square.
        tolerance : float, optional
            As for :meth:`periodic`; the Jacobian is exactly that of the cycle so reached.

        Returns
        -------
        force : ndarray
            Coefficients of both forces [N], shape (2, coefficients).
        jacobian : ndarray
            Derivatives [N/m] of coefficients of force i by those of displacement k: shape (2, 2,
            coefficients, coefficients), in the order i, k, row, column.
        """
        numbers = _orders(harmonics)
        basis, analysis = _transform(numbers, _samples(samples, numbers))
        values = floats("coefficients", coefficients)
        if values.shape != (2, basis.shape[1]):
            raise InputError(
                f"coefficients must have the shape (2, {basis.shape[1]}), a row a direction, "
                f"got {values.shape}"
            )
        places = (basis @ values.T)[None]
        nothing = np.zeros((basis.shape[0], 0))
        force, slopes, _ = settle(
            _ConstantLoad(self, 1), places, np.zeros(places.shape[:2]), basis, nothing, tolerance
        )
        jacobian, _ = transform_slopes(slopes, analysis, basis.shape[1], 0)
        return force[0].T @ analysis, jacobian[0]

    def __repr__(self) -> str:
        return f"IsotropicJoint({self.joint!r}, sliders={self._tops.size})"


class _ConstantLoad:
    """Nodes that share the sliders of a joint whose load is held."""

    def __init__(self, joint: IsotropicJoint, nodes: int) -> None:
        self._tops, self._weights = joint._tops, joint._weights
        self._scales = self._slips = np.ones(nodes)
        self._rests = np.zeros(nodes)

    def _loads(self, step: Floats) -> tuple[Floats, Floats]:
        return np.full(step.size, np.nan), np.full(step.size, np.nan)  # a law knows none

    def _step_array(self, separations: ArrayLike) -> Floats:
        raise InputError(
            "separations have no meaning for a joint whose load is held; "
            "write JointField(...).two_directions() for nodes whose separation varies"
        )


def check_sliders(sliders: Any, fewest: int) -> None:
    """A number of sliders."""
    whole_number("sliders", sliders, fewest, MOST_SLIDERS)


def _path(name: str, value: ArrayLike) -> Floats:
    array = floats(name, value)
    if array.ndim != 2 or array.shape[1] != 2:
        raise InputError(f"{name} must have the shape (samples, 2), got {array.shape}")
    return array
