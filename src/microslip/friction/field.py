"""Contact field: many nodes on one surface, as in the contact between two finite-element meshes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.by_value import ByValue
from microslip._core.checks import (
    LARGEST,
    SMALLEST,
    Floats,
    check_one_of,
    exact,
    floats,
    positive,
    sized,
)
from microslip._core.errors import InputError
from microslip._core.frozen import Locked, assign, lock
from microslip.contact.base import NormalLaw
from microslip.contact.load_curve import LoadCurve, check_surface, shared_curve
from microslip.friction.base import BackboneLaw
from microslip.friction.field_backbone import FieldBackbone
from microslip.friction.field_cycles import SettledField
from microslip.friction.memory import FieldState, Nodes
from microslip.friction.memory.nodes import checked_separations
from microslip.friction.own_tightening import OwnTightening
from microslip.friction.two_directions import IsotropicField, two_directions

_UNITS = {
    "friction_coefficient": "", "areas": "m^2", "loads": "N", "pressures": "Pa",
    "separations": "m", "gaps": "m",
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class JointField(ByValue, SettledField, Locked):
    """Contact nodes on one surface, each with its own area, load and coefficient of friction.

    At the same separation a node of area A_i carries A_i/A times the load of the surface of area A,
    so all nodes share the load curve of the surface.

    Parameters
    ----------
    surface : NormalLaw
        Normal load law of the surface.
    friction_coefficient : array_like
        Coulomb's coefficient mu [-], above zero: a number or one per node.
    areas : array_like
        Apparent areas of the nodes [m^2], above zero: one per node, or a number.
    loads : array_like, optional
        Normal loads at rest [N], not negative. A node without load is open and may close later.
    pressures : array_like, optional
        Pressures at rest [Pa], given instead of the loads.
    separations : array_like, optional
        Separations at rest [m], given instead of the loads.
    gaps : array_like, optional
        Separations [m] before the joint is loaded, given instead; a static solution of the
        structure then determines the separations at rest.
    surface_area : float, optional
        Apparent area [m^2] of the surface, by default its attribute ``area``.

    Notes
    -----
    Each node follows the law of :class:`microslip.Interface` (DOI 10.1115/1.2833765), independent
    of the other nodes. The elastic deformation of the bodies beneath the summits is not included,
    since a finite-element model of the bodies contains it.

    On a face that yields (:class:`microslip.DrawnFace`, :class:`microslip.MeasuredContact`), nodes
    given by loads or pressures are assumed to have been tightened in proportion to their pressure:
    the node with the highest pressure to the tightening pressure of the surface. The law of a node
    is then that of the surface with load and separation multiplied by factors. The normal stiffness
    is nearly proportional to the pressure, and all nodes slide at nearly the same displacement.
    """

    surface: NormalLaw
    friction: Floats
    """Coefficients of friction [-], shape (nodes,)."""
    areas: Floats
    """Apparent areas [m^2]."""
    separations: Floats
    """Separations at rest [m]."""
    normal_loads: Floats
    """Normal loads at rest [N]."""
    gaps: Floats | None
    """Separations [m] before the joint is loaded, None if the state at rest was given."""
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
                "one of `loads` [N], `pressures` [Pa], `separations` [m] and `gaps` [m] must be "
                f"given, got {' and '.join(stated) or 'none'}"
            )
        kind = next(iter(stated))
        nodes = _arrays_of({"friction_coefficient": friction_coefficient, "areas": areas, **stated})
        for name, unit in (("friction_coefficient", ""), ("areas", " [m^2]")):
            _check_positive(name, unit, nodes[name])
        assign(
            self,
            surface=surface,
            friction=lock(nodes["friction_coefficient"]),
            areas=lock(nodes["areas"]),
            surface_area=_area_of(surface, surface_area),
            gaps=lock(nodes["gaps"]) if kind == "gaps" else None,
            _ratios=surface.stiffness_ratio,
            _own=None,
        )
        if kind in ("separations", "gaps"):
            self._set_separations(nodes[kind], None)
        else:
            self._set_loads(kind, nodes[kind], None)

    def _set_separations(self, separations: Floats, curve: LoadCurve | None) -> None:
        checked_separations(self.surface, separations)
        curve = curve or shared_curve(self.surface, float(separations.min()))
        own = self._own
        steps = separations - (curve.origin if own is None else own.origins)
        if own is not None:
            steps /= own.lengths
        loads = self._scale * curve.load(steps)[0]
        assign(self, separations=lock(separations), normal_loads=lock(loads))
        self._set_nodes(curve, steps, self._scale)

    def _set_loads(self, kind: str, values: Floats, curve: LoadCurve | None) -> None:
        unit = "N" if kind == "loads" else "Pa"
        sized(kind, values, unit)
        if values.min() < 0.0:
            i = int(np.argmax(values < 0.0))
            raise InputError(
                f"`{kind}` must not be negative [{unit}], got {exact(values[i])} at node {i}"
            )
        loads = values * self.areas if kind == "pressures" else values
        shares = loads / self._scale
        if curve is None:
            assign(self, surface=self.surface._under(float(shares.max())))
            heaviest = int(np.argmax(shares))
            nearest = self._separation_of(shares, heaviest) if shares[heaviest] > 0.0 else np.inf
            curve = shared_curve(self.surface, min(nearest, LARGEST))
            own = OwnTightening.in_proportion(self.surface, curve, shares)
            if own is not None:
                self.__dict__.pop("_scale")  # cached without the tightening
                assign(self, _own=own)
                shares = shares / own.shares
        carried = shares > 0.0
        try:
            if carried.all():
                separations = curve.steps_of(shares, numbered=False)
            else:
                separations = np.full(shares.size, curve.parting())
                if carried.any():
                    separations[carried] = curve.steps_of(shares[carried], numbered=False)
        except InputError:
            # Raise the error for the node with the lightest or the heaviest load.
            light = np.where(carried, shares, np.inf)
            for i in (int(np.argmin(light)), int(np.argmax(shares))):
                self._separation_of(shares, i)
            raise
        own = self._own
        if own is not None:
            rests = separations
            separations = own.origins + own.lengths * rests
        else:
            separations += curve.origin
            rests = separations - curve.origin
        normal_loads = loads.copy() if loads is values else loads
        assign(self, separations=lock(separations), normal_loads=lock(normal_loads))
        # Scale each node so that its limit is exactly mu N despite the rounded separation.
        scale = curve.load(rests)[0]
        carried &= scale > 0.0
        np.divide(shares, scale, out=scale, where=carried)
        scale[~carried] = 1.0
        scale *= self._scale
        self._set_nodes(curve, rests, scale)

    def _set_nodes(self, curve: LoadCurve, rests: Floats, scale: Floats) -> None:
        slips, own = self.friction * self._ratios, self._own
        nodes = Nodes(curve, self.friction * scale, self._scale, slips, rests)
        if own is not None:
            nodes = replace(
                nodes, slips=slips * own.lengths, origins=own.origins, lengths=own.lengths
            )
        assign(self, _nodes=nodes)

    def _separation_of(self, shares: Floats, node: int) -> float:
        try:
            separation: float = self.surface.separation(float(shares[node]))
        except InputError as error:
            wording = str(error).partition(", got ")[0]
            share = self._scale[node]
            raise InputError(
                f"{wording}, on the whole area of the surface; node {node} is {share:.3g} of it, "
                f"got {exact(shares[node] * share)} N"
            ) from None
        return separation

    _nodes: Nodes
    _own: OwnTightening | None
    _ratios: Any
    """Ratio of normal to tangential stiffness [-], a number or one per node."""

    @property
    def size(self) -> int:
        """Number of nodes."""
        return self.areas.size

    @cached_property
    def _scale(self) -> Floats:
        scale = self.areas / self.surface_area
        return scale if self._own is None else scale * self._own.shares

    def _with(self, **changes: Any) -> JointField:
        """Return a field with the same nodes and changed attributes; its state at rest is unset."""
        field = object.__new__(JointField)
        names = ("surface", "friction", "areas", "surface_area", "gaps", "_ratios", "_own")
        assign(field, **{name: getattr(self, name) for name in names} | changes)
        return field

    def _tightened_at(self, separations: Floats, loads: Floats) -> JointField:
        """Return the field in which the face has yielded at each node under the load of the node.

        Nodes carry their loads ``loads`` [N] at ``separations`` [m]. If the face does not yield,
        the laws of the nodes do not change.
        """
        curve = self._nodes.curve
        own = OwnTightening.at_rest(self.surface, curve, separations, loads / self._scale)
        field = self._with(_own=own)
        field._set_separations(separations if self.gaps is None else self.gaps, curve)
        return field

    @cached_property
    def force_limits(self) -> Floats:
        """Forces of gross slip mu N at rest [N], shape (nodes,)."""
        return lock(self.friction * self.normal_loads)

    @cached_property
    def tangential_stiffnesses(self) -> Floats:
        """Tangential stiffnesses at rest [N/m], shape (nodes,)."""
        nodes = self._nodes
        return lock(nodes.weights / nodes.slips * nodes.curve.load(nodes.rests)[1])

    def at(
        self, *, separations: ArrayLike | None = None, loads: ArrayLike | None = None
    ) -> JointField:
        """Return the field at rest under other separations [m] or other normal loads [N].

        Either has the shape (nodes,) or is a number. The ``gaps`` of the field do not change.
        """
        check_one_of("separations [m] or loads [N]", separations, loads)
        field, curve = self._with(), self._nodes.curve
        if separations is not None:
            field._set_separations(
                self._nodes.per_node("separations", separations, "m").copy(), curve
            )
        else:
            new_loads = self._nodes.per_node("loads", loads, "N")  # type: ignore[arg-type]
            field._set_loads("loads", new_loads, curve)
        return field

    def along(self, directions: ArrayLike) -> JointField:
        """Return the field with a direction of motion in the tangential plane for each node.

        Parameters
        ----------
        directions : array_like
            Direction vectors [-], shape (nodes, 2), of any length: components along and across the
            ``direction`` of the surface. They have an effect only if the stiffness depends on the
            direction, see :class:`microslip.MeasuredContact`.
        """
        lines = floats("directions", directions)
        if lines.shape != (self.size, 2):
            raise InputError(
                f"`directions` must have the shape ({self.size}, 2), got {lines.shape}"
            )
        squares = (lines**2).sum(axis=1)
        if not squares.min() > 0.0:
            raise InputError(
                f"`directions` must not be zero, got zero at node {int(np.argmin(squares))}"
            )
        lay = self.surface._lay
        if lay is None:
            return self
        nodes = self._nodes
        stiffnesses = np.einsum("ni,ij,nj->n", lines, lay, lines) / squares
        ratios = self.surface.stiffness_ratio / stiffnesses
        slips = nodes.slips * (ratios / self._ratios)
        return self._with(
            separations=self.separations, normal_loads=self.normal_loads, _ratios=ratios,
            _nodes=replace(nodes, slips=slips),
        )  # fmt: skip

    # -- without memory -------------------------------------------------------------------------

    def load(self, separations: ArrayLike) -> tuple[Floats, Floats]:
        """Compute normal loads N [N] and slopes dN/dd [N/m] at separations d [m].

        Separations are a number or one-dimensional, one per node. Slopes are zero or negative.
        """
        nodes = self._nodes
        load, fall = nodes.curve.load(nodes.steps_at("separations", separations))
        return nodes.scales * load, -nodes.per_length(nodes.scales * fall)

    def dissipated_energy(self, amplitude: ArrayLike) -> Floats:
        """Compute the energy [J] of a closed cycle of each node at its separation at rest.

        Displacement amplitudes [m] are not negative: a number, shape (nodes,), or (cycles, nodes)
        for many cycles at once. Energies have the shape (nodes,) or (cycles, nodes). The formula is
        that of :meth:`microslip.Interface.dissipated_energy`.
        """
        a = sized("amplitude", amplitude)
        several = a.ndim == 2
        nodes = self._nodes
        a = a if several else nodes.per_node("amplitude", a, "m")[None]
        if a.shape[1] != self.size:
            raise InputError(
                f"`amplitude` must have the shape ({self.size},) or (cycles, {self.size}), got "
                f"{a.shape}"
            )
        if a.min() < 0.0:
            i, j = np.unravel_index(np.argmin(a), a.shape)
            raise InputError(
                f"`amplitude` must not be negative [m], got {exact(a[i, j])} at node {j}"
            )
        energy = np.zeros(a.shape)
        loaded = self.normal_loads > 0.0
        if loaded.any():
            slip = nodes.slips[loaded]
            reach = a[:, loaded] / slip
            steps = np.broadcast_to(nodes.rests[loaded], reach.shape)
            excess = nodes.curve.excess("excess", steps.ravel(), reach.ravel())
            energy[:, loaded] = 8.0 * nodes.weights[loaded] * slip * excess.reshape(reach.shape)
        return energy if several else energy[0]

    def rigid(self) -> BackboneLaw:
        """Return the law of the whole field for nodes that all have the same displacement.

        It is the sum of the laws of all nodes, each at its separation at rest, as in
        :class:`microslip.Parallel` but at the cost of a single joint.
        """
        if not np.any(self.normal_loads > 0.0):
            raise InputError("the field must have a node with a normal load above zero, got none")
        loaded, nodes = self.normal_loads > 0.0, self._nodes
        weights, slips, rests = (
            lock(part[loaded]) for part in (nodes.weights, nodes.slips, nodes.rests)
        )
        return FieldBackbone(nodes.curve, weights, slips, rests, float(np.sum(self.force_limits)))

    # -- with memory ----------------------------------------------------------------------------

    def start(self, *, energies: bool = False, depth: int | None = None) -> FieldState:
        """Return a state of all nodes at rest.

        Parameters
        ----------
        energies : bool, optional
            Accumulate the energy dissipated by each node.
        depth : int, optional
            Largest number of rows of the memory diagram of a node [-], at least four. Further rows
            are merged; ``error_bound`` bounds the resulting error. Unlimited by default.
        """
        return FieldState(self._nodes, bool(energies), depth)

    # -- two directions -------------------------------------------------------------------------

    def two_directions(self, sliders: int = 128, *, nearest: float | None = None) -> IsotropicField:
        """Return the field for motion in two tangential directions with varying separations.

        The stiffness is isotropic, except for a measured surface with a ``direction``: the first
        displacement is along this direction, and the tangential stiffness is a 2 x 2 tensor, which
        contains the effect of the lay (the direction of machining marks).

        Parameters
        ----------
        sliders : int, optional
            Number of sliders [-], 2 to 100 000, common to all nodes. Each is out of contact beyond
            its own separation.
        nearest : float, optional
            Smallest separation [m] that any node may reach, by default below the smallest
            separation at rest by one decay length N/|N'| of the load.

        Returns
        -------
        IsotropicField
            Field with the methods ``start``, ``periodic`` and ``harmonics``. Its attributes
            ``load_error`` and ``resolution`` measure the error of the finite number of sliders.
        """
        return two_directions(self, sliders, nearest)

    def __repr__(self) -> str:
        return (
            f"JointField({type(self.surface).__name__}, {self.size} "
            f"{'node' if self.size == 1 else 'nodes'}, area={self.areas.sum():g}, "
            f"normal_load={self.normal_loads.sum():g})"
        )


def _arrays_of(values: dict[str, Any]) -> dict[str, Floats]:
    arrays = {name: floats(name, value, _UNITS[name]) for name, value in values.items()}
    for name, array in arrays.items():
        if array.ndim > 1:
            raise InputError(f"`{name}` must be one-dimensional, got shape {array.shape}")
    lengths = {name: array.size for name, array in arrays.items() if array.ndim}
    size = max(lengths.values(), default=1)
    if any(length != size for length in lengths.values()):
        came = ", ".join(f"{length} {name}" for name, length in lengths.items())
        raise InputError(f"arrays must have one value per node or be numbers, got {came}")
    return {
        name: np.array(np.broadcast_to(array.reshape(-1), (size,)), order="C")
        for name, array in arrays.items()
    }


def _check_positive(name: str, unit: str, values: Floats) -> None:
    off = (values <= 0.0) | (values < SMALLEST) | (values > LARGEST)
    if off.any():
        i = int(np.argmax(off))
        bounds = "above zero" if values[i] <= 0.0 else f"between {SMALLEST:g} and {LARGEST:g}"
        raise InputError(f"`{name}` must be {bounds}{unit}, got {exact(values[i])} at node {i}")


def _area_of(surface: NormalLaw, area: float | None) -> float:
    if area is not None:
        return positive("surface_area", area, "m^2", 2e-4)
    surface_area = getattr(surface, "area", None)
    if surface_area is None:
        raise InputError(
            f"`surface_area` must be given, since {type(surface).__name__} has no apparent "
            "area; write surface_area=2e-4 [m^2]"
        )
    return positive("surface_area", surface_area, "m^2")
