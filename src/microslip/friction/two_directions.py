"""Joints in two tangential directions, at a held load or while separations vary."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import (
    LARGEST,
    Floats,
    exact,
    floats,
    number,
    plain,
    show,
    sized,
    whole_number,
)
from microslip._core.errors import InputError
from microslip._core.frozen import Locked, lock
from microslip.contact.base import NormalLaw
from microslip.friction.base import BackboneLaw, CellModel
from microslip.friction.field_cycles import FieldOfNodes
from microslip.friction.field_harmonics import FieldHarmonics
from microslip.friction.memory import SliderBank, VectorState
from microslip.friction.vector_cycles import SETTLED, VectorCycle, settled_cycle, settled_harmonics

_MOST_SLIDERS = 100_000
_MOST_IN_STATE = 100_000_000  # sliders of all joints of a state
_GRID = 4000  # places at which the load curve is looked at
_LIGHTEST_SHARE = 1e-3  # of the lightest node's load: knots are laid evenly down to it

# -- at a held load -------------------------------------------------------------------------------


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
        whole_number("sliders", self.sliders, 1, _MOST_SLIDERS)
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

    @cached_property
    def _bank(self) -> SliderBank:
        sliders = self.line.sliders()
        tops, weights = np.array(sliders.yield_displacements), np.array(sliders.stiffnesses)
        return SliderBank(lock(tops), lock(weights), None, 1)

    def start(
        self,
        nodes: int | None = None,
        *,
        energies: bool = False,
        arrays: Mapping[str, ArrayLike] | None = None,
    ) -> VectorState:
        """A state at rest, of this joint or of many that move each by itself.

        Without a number of ``nodes`` [-] there is one, without an axis of its own. With
        ``energies`` it counts what is dissipated, which takes its time. With the ``arrays`` that
        ``to_arrays`` of a state gave [m, J], shapes there, it goes on as that would.
        """
        if nodes is not None:
            whole_number("nodes", nodes, 1, _MOST_IN_STATE // self._bank.tops.size)
        bank = replace(self._bank, size=int(nodes or 1))
        if arrays is not None:
            return VectorState._from_arrays(bank, nodes is None, arrays)
        return VectorState(bank, nodes is None, bool(energies))

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
        bank = self._bank
        squares = np.maximum(a[..., None] ** 2 - bank.tops**2, 0.0)
        return plain(np.asarray(2.0 * math.pi * np.sqrt(squares) @ (bank.weights * bank.tops)))

    def periodic(
        self, displacement_cycle: ArrayLike, *, tolerance: float = SETTLED, start: str = "farthest"
    ) -> VectorCycle:
        """The settled cycle of a periodic path.

        Parameters
        ----------
        displacement_cycle : array_like
            One period of displacements [m], shape (samples, 2), its first sample not repeated.
        tolerance : float, optional
            Share of the force limit [-] that forces may be off those after infinitely many periods.
            Each slider is taken around until its own share is reached, for 2000 periods at most:
            ``converged`` and ``residual`` of the result tell where that was not enough.
        start : {"farthest", "first"}, optional
            Sample to which the joint goes from rest in a straight line, before it follows the
            cycle again and again: the one farthest from rest, or the first one, as a state that
            begins at rest. Sliders that hardly slip keep what that path left, so the mean force
            of a cycle with a mean displacement depends on it: by some 5e-4 of the force limit.

        Returns
        -------
        VectorCycle
            ``force`` [N], shape (samples, 2), and ``derivative``, see there.
        """
        x = _path("displacement_cycle", displacement_cycle)[None]
        return settled_cycle(
            self._bank, x, None, np.zeros(x.shape[:2]), tolerance, start, single=True
        )

    def harmonics(
        self,
        coefficients: ArrayLike,
        harmonics: Any = (0, 1),
        *,
        samples: int = 64,
        tolerance: float = SETTLED,
        start: str = "farthest",
    ) -> FieldHarmonics:
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
            As for :meth:`periodic`; the Jacobian is that of the settled cycle.
        start : {"farthest", "first"}, optional
            As for :meth:`periodic`; the first sample is at time 0.

        Returns
        -------
        FieldHarmonics
            ``force`` [N], shape (2, coefficients), and ``jacobian`` [N/m], derivatives of the
            coefficients of force i by those of displacement k: shape (2, 2, coefficients,
            coefficients), in the order i, k, row, column; ``converged`` and ``residual`` [N],
            shape (1,). No finite motion is refused.
        """
        return settled_harmonics(
            self._bank, coefficients, harmonics, None, samples, tolerance, start, single=True
        )

    def __repr__(self) -> str:
        return f"IsotropicJoint({self.joint!r}, sliders={self._bank.tops.size})"


def _path(name: str, value: ArrayLike) -> Floats:
    array = floats(name, value, "m")
    if array.ndim != 2 or array.shape[1] != 2:
        raise InputError(f"{name} must have the shape (samples, 2), got {array.shape}")
    return array


# -- while separations vary -----------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class IsotropicField(Locked):
    """The nodes of a field in two directions, made by :meth:`microslip.JointField.two_directions`.

    Notes
    -----
    The memory of a varying load is, on a line, that of sliders over the separations eta: one holds
    g = integral of D from d to eta, of size eta - d at most, and T = mu times the integral of
    N''(eta) g over eta (the method of memory diagrams, DOI 10.3389/fmech.2020.00030, by parts).
    Here g is a vector that follows every step and slips along itself where its radius eta - d would
    be left. Assumed is what :class:`microslip.IsotropicJoint` assumes, and that a slider whose
    radius shrinks as contact is lost slips along what it holds. Along a line it is the coupled
    joint, at held separations the isotropic one, both with the load curve drawn as a polygon.

    On a :class:`microslip.MeasuredContact` with a ``direction``, which is that of the first
    displacement, stiffness is the tensor of its lay, and what slips still moves along what it
    holds. The end of a step is then found in eight pieces: exactly along a line, and to 0.015 of
    what a slider holds where it turns in one long step.
    """

    field: FieldOfNodes
    knots: Floats
    """Separations [m] between which the load curve is straight."""

    @cached_property
    def load_error(self) -> float:
        """Largest relative error of the polygon, which lies above the load curve [-].

        From the nearest separation to that of the lightest node at rest; forces err by no more
        than that of mu N at both ends of slip.
        """
        last = float(self.field.separations[self.field.normal_loads > 0.0].max())
        inner = self.knots[:-1][self.knots[1:] <= last]
        if not inner.size:
            inner = self.knots[:1]
        width = np.diff(self.knots)[: inner.size]
        middle = inner + 0.5 * width
        curve = self.field._nodes.curve
        origin = curve.origin
        load = curve.load(middle - origin)[0]
        ends = curve.load(self.knots[: inner.size + 1] - origin)[0]
        return float(np.max(0.5 * (ends[:-1] + ends[1:]) / load - 1.0))

    @cached_property
    def resolution(self) -> Floats:
        """Amplitudes [m] below which a node dissipates next to nothing: kappa times a knot's step.

        Small cycles need more sliders: a cycle is met well from ten times that on.
        """
        at = np.clip(np.searchsorted(self.knots, self.field.separations), 1, self.knots.size - 1)
        return lock((self.knots[at] - self.knots[at - 1]) * self.field._nodes.slips)

    @cached_property
    def _bank(self) -> SliderBank:
        nodes = self.field._nodes
        steps = self.knots - nodes.curve.origin
        # Bends of the polygon: what each slider adds to N of a separation before it.
        loads = nodes.curve.load(steps)[0]
        slopes = -np.diff(np.append(loads[:-1], 0.0)) / np.diff(self.knots)
        bends = slopes - np.append(slopes[1:], 0.0)
        return SliderBank(
            lock(steps[1:].copy()), lock(bends), nodes, nodes.size, float(steps[0]),
            nodes.curve.surface._lay,
        )  # fmt: skip

    def start(
        self, *, energies: bool = False, arrays: Mapping[str, ArrayLike] | None = None
    ) -> VectorState:
        """A state of all nodes at rest, which may count ``energies``.

        With the ``arrays`` that ``to_arrays`` of a state gave [m, J], shapes there, it goes on.
        """
        if arrays is not None:
            return VectorState._from_arrays(self._bank, False, arrays)
        return VectorState(self._bank, False, bool(energies))

    def periodic(
        self,
        displacements: ArrayLike,
        separations: ArrayLike | None = None,
        *,
        tolerance: float = SETTLED,
        start: str = "farthest",
    ) -> VectorCycle:
        """The settled cycles of all nodes, as one is of :meth:`microslip.IsotropicJoint.periodic`.

        Parameters
        ----------
        displacements : array_like
            One period of displacements [m], shape (nodes, samples, 2), its first sample not
            repeated.
        separations : array_like, optional
            Separations [m] at the same samples, shape (nodes, samples).
        tolerance : float, optional
            Share of the force limit [-], see there.
        start : {"farthest", "first"}, optional
            Path from rest to the cycle, see there.

        Returns
        -------
        VectorCycle
            ``force`` and ``load`` [N], and ``derivative``, see there.
        """
        x, bank = floats("displacements", displacements, "m"), self._bank
        if x.ndim != 3 or x.shape[::2] != (bank.size, 2):
            raise InputError(
                f"displacements must have the shape ({bank.size}, samples, 2), got {x.shape}"
            )
        steps = np.repeat(bank.rests[:, None], x.shape[1], axis=1)
        if separations is not None:
            d = floats("separations", separations, "m")
            if d.shape != x.shape[:2]:
                raise InputError(f"separations must have the shape {x.shape[:2]}, got {d.shape}")
            steps = bank.steps_at(d)
        return settled_cycle(bank, x, lock(bank.loads(steps)[0]), steps, tolerance, start)

    def harmonics(
        self,
        coefficients: ArrayLike,
        harmonics: Any = (0, 1),
        *,
        separations: ArrayLike | None = None,
        samples: int = 64,
        tolerance: float = SETTLED,
        start: str = "farthest",
    ) -> FieldHarmonics:
        """Fourier coefficients of the settled forces with their Jacobians.

        Parameters
        ----------
        coefficients : array_like
            Coefficients of both displacements [m], shape (nodes, 2, coefficients), in the order of
            ``harmonics``: [mean,] cos 1, sin 1, cos 3, sin 3 for (0, 1, 3).
        separations : array_like, optional
            Coefficients of the separations [m], shape (nodes, coefficients).
        harmonics, samples, tolerance, start : optional
            As those of :meth:`microslip.IsotropicJoint.harmonics`.

        Returns
        -------
        FieldHarmonics
            ``force`` [N], shape (nodes, 2, coefficients); ``load`` [N], (nodes, coefficients),
            with ``separations``; ``jacobian`` [N/m], shape (nodes, 2, 2, coefficients,
            coefficients), with ``separations`` (nodes, 3, 3, ...), of (T1, T2, N) by both
            displacements and the separation; ``converged`` and ``residual`` [N], shape (nodes,).
            No finite motion is refused: a node that has not settled gives its last period.
        """
        return settled_harmonics(
            self._bank, coefficients, harmonics, separations, samples, tolerance, start
        )

    def __repr__(self) -> str:
        return f"IsotropicField({self.field!r}, sliders={self._bank.tops.size})"


def two_directions(field: FieldOfNodes, sliders: Any, nearest: Any) -> IsotropicField:
    """See :meth:`microslip.JointField.two_directions`."""
    count = whole_number("sliders", sliders, 2, _MOST_SLIDERS)
    curve, surface = field._nodes.curve, field._nodes.curve.surface
    smallest = float(field.separations.min())
    if nearest is None:
        load, fall = curve.load(np.zeros(1))
        near = min(smallest, curve.origin) - float(load[0] / fall[0])
        near = max(near, _lowest(surface))
    else:
        near = number("nearest", nearest, "m")
        if near > smallest:
            raise InputError(
                f"nearest must not be above the smallest separation at rest, {smallest:g} m, "
                f"got {exact(near)}"
            )
        surface._separations(np.array([near]))
    return IsotropicField(field, _knots_of(field, count, near))


def _lowest(surface: NormalLaw) -> float:
    """Separation below which the surface has no answer."""
    lowest = float(surface._span[0])
    try:
        surface._separations(np.array([lowest - 1e-3 * abs(lowest) - 1e-12]))
    except InputError:
        return lowest
    return -LARGEST


def _knots_of(field: FieldOfNodes, sliders: int, nearest: float) -> Floats:
    """Knots from the nearest separation to where nothing is left, even in relative error.

    A chord of width h lies above N by h^2 N''/8 at most: knots that part the integral of
    sqrt(N''/N) evenly make that one share of N, down to where next to no load is left; a last
    chord ends the load.
    """
    curve = field._nodes.curve
    origin = curve.origin
    parting = curve.parting() + origin
    grid = np.linspace(nearest, parting, _GRID + 1)
    load, fall = curve.load(grid - origin)
    loaded = field.normal_loads > 0.0
    last = field.separations[loaded].max() if loaded.any() else nearest
    lightest = _LIGHTEST_SHARE * float(curve.load(np.array([last - origin]))[0][0])
    loaded_places = np.flatnonzero(load > lightest)
    end = grid[min(loaded_places[-1] + 1, _GRID)] if loaded_places.size else parting
    grid = np.linspace(nearest, end, _GRID + 1)
    load, fall = curve.load(grid - origin)
    middle = np.maximum(0.5 * (load[:-1] + load[1:]), lightest)
    masses = np.sqrt(np.diff(grid) * np.maximum(fall[:-1] - fall[1:], 0.0) / middle)
    parts = np.append(0.0, np.cumsum(masses))
    count = sliders if end < parting else sliders + 1
    knots = np.interp(np.linspace(0.0, parts[-1], count), parts, grid)
    knots[0] = nearest
    return lock(np.append(knots, parting) if end < parting else knots)
