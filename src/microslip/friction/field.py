"""Thousands of small joints at once: the nodes of a contact between two meshes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import (
    LARGEST,
    Floats,
    beyond,
    check_one_of,
    exact,
    floats,
    number,
    sized,
)
from microslip._core.frozen import Locked, assign, lock
from microslip.errors import InputError
from microslip.friction.base import BackboneLaw
from microslip.friction.coupled import check_surface
from microslip.friction.field_backbone import FieldBackbone
from microslip.friction.field_curve import FieldCurve, field_curve
from microslip.friction.field_cycles import SettledField
from microslip.friction.field_nodes import area_of, at, check_positive, nodes_of
from microslip.friction.isotropic import check_sliders
from microslip.friction.isotropic_field import IsotropicField, knots_of
from microslip.memory import FieldResponse, FieldState
from microslip.normal.base import NormalLaw


@dataclass(frozen=True, eq=False)
class JointField(SettledField, Locked):
    """Many joints on one kind of surface, each with its area, load and friction: *nodes*.

    A law depends on the pressure alone and scales with the area, so that all nodes share one load
    curve: a node of area A_i has A_i/A times the load of a surface of area A at the same
    separation, and its force likewise.

    Parameters
    ----------
    surface : NormalLaw
        The normal load law of the surface.
    friction_coefficient : array_like
        Coulomb's coefficient mu [-], above zero: one number, or one a node.
    areas : array_like
        Apparent areas of the nodes [m^2], above zero: one a node, or one number for all.
    loads : array_like, optional
        Normal loads at rest [N], not negative. A node without load touches nothing, and may close.
    pressures : array_like, optional
        Pressures at rest [Pa] instead.
    separations : array_like, optional
        Separations at rest [m] instead.
    gaps : array_like, optional
        Separations [m] instead, where a static solution begins that will find those at rest.
    surface_area : float, optional
        Apparent area [m^2] that the law of the surface stands for; its own ``area`` where it has
        one.

    Notes
    -----
    Each node follows :class:`microslip.Interface`; nodes know of each other only through what
    carries them. The elastic half space beneath the summits is no part of a node: a finite-element
    model has that compliance already.
    """

    surface: NormalLaw
    friction: Floats
    """Coefficients of friction [-], one a node."""
    areas: Floats
    """Apparent areas [m^2]."""
    separations: Floats
    """Separations at rest [m]."""
    normal_loads: Floats
    """Normal loads at rest [N]."""
    gaps: Floats | None
    """Separations where a static solution begins [m]; None where those at rest were given."""
    surface_area: float

    def __init__(
        self,
        surface: NormalLaw,
        friction_coefficient: ArrayLike,
        *,
        areas: ArrayLike,
        loads: ArrayLike | None = None,
        pressures: ArrayLike | None = None,
        separations: ArrayLike | None = None,
        gaps: ArrayLike | None = None,
        surface_area: float | None = None,
    ) -> None:
        check_surface(surface)
        conditions = {
            "loads": loads, "pressures": pressures, "separations": separations, "gaps": gaps,
        }  # fmt: skip
        stated = {name: value for name, value in conditions.items() if value is not None}
        if len(stated) != 1:
            raise InputError(
                "one of loads [N], pressures [Pa], separations [m] and gaps [m] must be given, "
                f"got {' and '.join(stated) or 'none'}"
            )
        kind = next(iter(stated))
        nodes = nodes_of({"friction_coefficient": friction_coefficient, "areas": areas, **stated})
        for name, unit in (("friction_coefficient", ""), ("areas", " [m^2]")):
            check_positive(name, unit, nodes[name])
        assign(
            self,
            surface=surface,
            friction=lock(nodes["friction_coefficient"]),
            areas=lock(nodes["areas"]),
            surface_area=area_of(surface, surface_area),
            gaps=lock(nodes["gaps"]) if kind == "gaps" else None,
        )
        if kind in ("separations", "gaps"):
            self._rest_at(nodes[kind], None)
        else:
            self._rest_under(kind, nodes[kind], None)

    def _rest_at(self, separations: Floats, curve: FieldCurve | None) -> None:
        self._check_separations(separations)
        curve = curve or field_curve(self.surface, float(separations.min()))
        assign(self, separations=lock(separations), _curve=curve)
        loads = self._scale * curve.load(self._steps)[0]
        assign(self, normal_loads=lock(loads), _weights=self.friction * self._scale)

    def _rest_under(self, kind: str, values: Floats, curve: FieldCurve | None) -> None:
        sized(kind, values, "N" if kind == "loads" else "Pa")
        if values.min() < 0.0:
            i = int(np.argmax(values < 0.0))
            unit = "N" if kind == "loads" else "Pa"
            raise InputError(f"{kind} must not be negative [{unit}], got {exact(values[i])}{at(i)}")
        loads = values * self.areas if kind == "pressures" else values
        shares = loads / self._scale
        if curve is None:
            heaviest = int(np.argmax(shares))
            nearest = self._separation_of(shares, heaviest) if shares[heaviest] > 0.0 else np.inf
            curve = field_curve(self.surface, min(nearest, LARGEST))
        assign(self, _curve=curve)
        steps = np.full(shares.size, np.nan)
        carried = shares > 0.0
        steps[~carried] = curve.parting() if not carried.all() else 0.0
        if carried.any():
            try:
                steps[carried] = curve.steps_of(shares[carried])
            except InputError:
                # What refuses one refuses the lightest or the heaviest.
                light = np.where(carried, shares, np.inf)
                for i in (int(np.argmin(light)), int(np.argmax(shares))):
                    self._separation_of(shares, i)
                raise
        assign(self, separations=lock(steps + curve.origin), normal_loads=lock(loads.copy()))
        # With it the limit mu N is met exactly, however coarse a number the separation is.
        there = self._scale * curve.load(self._steps)[0]
        exactly = np.divide(loads, there, out=np.ones(loads.size), where=there > 0.0)
        assign(self, _weights=self.friction * self._scale * exactly)

    def _separation_of(self, shares: Floats, node: int) -> float:
        """Separation of one node, whose load is ``shares`` on the whole surface."""
        try:
            separation: float = self.surface.separation(float(shares[node]))
        except InputError as error:
            wording = str(error).partition(", got ")[0]
            share = self._scale[node]
            raise InputError(
                f"{wording}, which for its share {share:.3g} of the surface's area is not so of "
                f"the {exact(shares[node] * share)} N{at(node)}"
            ) from None
        return separation

    _curve: FieldCurve
    _weights: Floats

    @property
    def size(self) -> int:
        """Number of nodes."""
        return self.areas.size

    @cached_property
    def _scale(self) -> Floats:
        return self.areas / self.surface_area

    @cached_property
    def _slip(self) -> Floats:
        """Kappa of each node."""
        return self.friction * self.surface.stiffness_ratio

    @cached_property
    def _steps(self) -> Floats:
        """Separations at rest from the origin of the curve."""
        return self.separations - self._curve.origin

    @cached_property
    def force_limits(self) -> Floats:
        """Forces of gross slip mu N at rest [N], one a node."""
        return lock(self.friction * self.normal_loads)

    @cached_property
    def tangential_stiffnesses(self) -> Floats:
        """Tangential stiffnesses at rest [N/m], one a node."""
        return lock(self._weights / self._slip * self._curve.load(self._steps)[1])

    def at(
        self, *, separations: ArrayLike | None = None, loads: ArrayLike | None = None
    ) -> JointField:
        """The same nodes in another state of rest, with the gaps of this field.

        By separations [m] or by normal loads [N], shape (nodes,) or one number.
        """
        check_one_of("separations [m] or loads [N]", separations, loads)
        field = object.__new__(JointField)
        names = ("surface", "friction", "areas", "surface_area", "gaps")
        assign(field, **{name: getattr(self, name) for name in names})
        if separations is not None:
            field._rest_at(self._per_node("separations", separations).copy(), self._curve)
        else:
            field._rest_under("loads", self._per_node("loads", loads), self._curve)
        return field

    # -- without memory -------------------------------------------------------------------------

    def load(self, separations: ArrayLike) -> tuple[Floats, Floats]:
        """Normal loads N [N] at separations [m], and their slopes dN/dd [N/m], not positive.

        Separations are one-dimensional, one a node, or one number.
        """
        load, fall = self._curve.load(self._step_array(separations))
        return self._scale * load, -self._scale * fall

    def first_loading(self, displacement: ArrayLike, separation: ArrayLike) -> FieldResponse:
        """The end of a straight path from rest, with its tangents, in closed form.

        Tangential displacements [m] and separations [m], one-dimensional, one a node, or one
        number. What comes back is ``force`` [N], ``load`` [N] and ``tangent`` [N/m], its shape
        (nodes, 2, 2), by the formulas of :func:`microslip.first_loading` (Jaeger 1998, DOI
        10.1115/1.2833765).
        """
        place = beyond(self._per_node("displacement", displacement), self._slip)
        step = self._step_array(separation, "separation")
        return self._first_loading(place, step)

    def _first_loading(self, place: Floats, step: Floats) -> FieldResponse:
        curve = self._curve
        size, sign = np.abs(place), np.where(place < 0.0, -1.0, 1.0)
        approach = self._steps - step
        sticks = (approach > 0.0) & (size <= approach)
        width = np.where(sticks, approach, size)
        load, fall = curve.load(step)
        drop = curve.drop(step, width)
        front = curve.load(step + size)[1]
        density = np.where(sticks, place / np.where(sticks, approach, 1.0), sign)
        by_place = np.where(sticks, drop / np.where(sticks, approach, 1.0), front)
        by_step = np.where(sticks, density * (by_place - fall), sign * (front - fall))
        tangent = np.zeros((self.size, 2, 2))
        tangent[:, 0, 0] = self._weights / self._slip * by_place
        tangent[:, 0, 1] = self._weights * by_step
        tangent[:, 1, 1] = -self._scale * fall
        return FieldResponse(self._weights * density * drop, self._scale * load, tangent)

    def dissipated_energy(self, amplitude: ArrayLike) -> Floats:
        """Energy [J] of a closed cycle about rest, at the separations of rest.

        Amplitudes [m] are not negative: shape (nodes,), one number, or (cycles, nodes) for many
        cycles at once, which is quicker than one after the other. Energies, one a node, have the
        shape (nodes,) or (cycles, nodes), as of :meth:`microslip.Interface.dissipated_energy`.
        """
        a = sized("amplitude", amplitude)
        several = a.ndim == 2
        a = a if several else self._per_node("amplitude", a)[None]
        if a.shape[1] != self.size:
            raise InputError(
                f"amplitude must have the shape ({self.size},), one a node, or (cycles, "
                f"{self.size}), got {a.shape}"
            )
        if a.min() < 0.0:
            i, j = np.unravel_index(np.argmin(a), a.shape)
            raise InputError(
                f"amplitude must not be negative [m], got {exact(a[i, j])}{at(int(j))}"
            )
        energy = np.zeros(a.shape)
        loaded = self.normal_loads > 0.0
        if loaded.any():
            slip = self._slip[loaded]
            reach = a[:, loaded] / slip
            steps = np.broadcast_to(self._steps[loaded], reach.shape)
            excess = self._curve.excess("excess", steps.ravel(), reach.ravel())
            energy[:, loaded] = 8.0 * self._weights[loaded] * slip * excess.reshape(reach.shape)
        return energy if several else energy[0]

    def rigid(self) -> BackboneLaw:
        """The law of all nodes that move together, each at its own separation.

        Returns
        -------
        BackboneLaw
            What :class:`microslip.Parallel` of all nodes is, and as quick as one joint.
        """
        if not np.any(self.normal_loads > 0.0):
            raise InputError("rigid needs a node that carries a load, got none")
        loaded = self.normal_loads > 0.0
        return FieldBackbone(
            self._curve,
            lock(self._weights[loaded]),
            lock(self._slip[loaded]),
            lock(self._steps[loaded]),
            float(np.sum(self.force_limits)),
        )

    # -- with memory ----------------------------------------------------------------------------

    def start(self, *, energies: bool = False) -> FieldState:
        """A state of all nodes at rest; with ``energies`` it counts what each dissipates."""
        return FieldState(self, bool(energies))

    # -- two directions -------------------------------------------------------------------------

    def two_directions(self, sliders: int = 128, *, nearest: float | None = None) -> IsotropicField:
        """The nodes in two tangential directions, the same in all, while separations vary.

        Parameters
        ----------
        sliders : int, optional
            Sliders [-] over the separations, 2 to 100 000, that all nodes share.
        nearest : float, optional
            Smallest separation [m] that any node reaches; without it one decay length of the load
            below the smallest at rest.

        Returns
        -------
        IsotropicField
            With ``start``, ``periodic`` and ``harmonics``; its ``load_error`` and ``resolution``
            say how good it is.
        """
        check_sliders(sliders, 2)
        smallest = float(self.separations.min())
        if nearest is None:
            load, fall = self._curve.load(np.array([self._curve.origin * 0.0]))
            near = min(smallest, self._curve.origin) - float(load[0] / fall[0])
            near = max(near, self._lowest)
        else:
            near = number("nearest", nearest, "m")
            if near > smallest:
                raise InputError(
                    f"nearest must not be above the smallest separation at rest, {smallest:g} m, "
                    f"got {exact(near)}"
                )
            self.surface._separations(np.array([near]))
        return IsotropicField(self, knots_of(self, int(sliders), near))

    @property
    def _lowest(self) -> float:
        """Separation below which the surface has no answer."""
        lowest = float(self.surface._span[0])
        try:
            self.surface._separations(np.array([lowest - 1e-3 * abs(lowest) - 1e-12]))
        except InputError:
            return lowest
        return -LARGEST

    # -- what comes in --------------------------------------------------------------------------

    def _per_node(self, name: str, value: Any) -> Floats:
        """One number a node."""
        array = floats(name, value)
        if array.ndim > 1 or array.size not in (1, self.size):
            raise InputError(
                f"`{name}` must be one number or one for each of the {self.size} nodes, got "
                f"shape {array.shape}"
            )
        return np.ascontiguousarray(np.broadcast_to(array.reshape(-1), (self.size,)))

    def _step_array(self, separations: Any, name: str = "separations") -> Floats:
        return self._check_separations(self._per_node(name, separations)) - self._curve.origin

    def _check_separations(self, separations: Floats) -> Floats:
        try:
            return self.surface._separations(separations)
        except InputError as error:
            node = np.unravel_index(np.argmin(separations), separations.shape)[0]
            where = at(int(node)) if self.size > 1 else ""
            raise InputError(f"{error}{where}") from None

    def __repr__(self) -> str:
        return (
            f"JointField({type(self.surface).__name__}, {self.size} "
            f"{'node' if self.size == 1 else 'nodes'}, area={self.areas.sum():g}, "
            f"normal_load={self.normal_loads.sum():g})"
        )
