"""A bolted lap joint from its drawing."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import exact, positive, record, show
from microslip._core.frozen import assign
from microslip._core.parameters import parameter, parameters_of
from microslip.errors import InputError
from microslip.materials import Material
from microslip.normal import NormalLaw
from microslip.structures.bolts import Bolts
from microslip.structures.mesh import (
    SIDE,
    Body,
    ContactFaces,
    JointMesh,
    Shank,
    Solids,
    check_count,
    check_elastic,
    lines,
    plan,
    square_half,
    widening,
)

if TYPE_CHECKING:
    from microslip.structures.reduction_convergence import Convergence
    from microslip.structures.reduction_model import ReducedJoint

Style = Literal["half-lap", "single-lap"]


def _size(symbol: str, meaning: str, example: float) -> dict[str, Any]:
    return parameter(symbol, "m", meaning, above=0.0, example=example)


@dataclass(frozen=True, eq=False)
class LapJoint:
    """Two beams or plates, bolted where they overlap.

    The lap is centred at the origin and lies in the plane z = 0: x runs along the joint, y across,
    z from the left, lower part into the right, upper one. Nothing holds the ends.

    Parameters
    ----------
    length : float
        Length of the whole, from end to end [m].
    width : float
        Width, across [m].
    thickness : float
        Thickness of the parts outside the lap [m].
    lap : float
        Length of the overlap [m].
    bolts : Bolts
        The bolts through it.
    style : {"half-lap", "single-lap"}
        In a half lap each part is half as thick in the overlap, so that the whole is straight; in
        a single lap whole plates lie on each other.

    Examples
    --------
    >>> import microslip as ms
    >>> bolts = ms.Bolts([-0.03, 0.0, 0.03], shank=0.008, hole=0.009, washer=0.018, tension=12e3)
    >>> ms.LapJoint(length=0.72, width=0.025, thickness=0.025, lap=0.12, bolts=bolts).style
    'half-lap'
    """

    length: float = field(metadata=_size("L", "length from end to end", 0.72))
    width: float = field(metadata=_size("b", "width, across", 0.0254))
    thickness: float = field(metadata=_size("t", "thickness of each part outside the lap", 0.0254))
    lap: float = field(metadata=_size("l", "length of the overlap", 0.12))
    bolts: Bolts
    style: Style = "half-lap"

    def __post_init__(self) -> None:
        for size in parameters_of(LapJoint):
            assign(self, **{size.name: size.checked(getattr(self, size.name))})
        if not self.lap < self.length:
            raise InputError(
                f"lap must be shorter than the length {exact(self.length)} m, got "
                f"{exact(self.lap)} m"
            )
        if not isinstance(self.bolts, Bolts):
            raise InputError(f"bolts must be ms.Bolts(...), got {show(self.bolts)}")
        if self.style not in ("half-lap", "single-lap"):
            raise InputError(f'style must be "half-lap" or "single-lap", got {show(self.style)}')
        square_half(self.bolts, self.lap, self.width)

    @property
    def face_area(self) -> float:
        """Area of the contact faces, without the holes [m^2]."""
        holes = len(self.bolts) * 0.25 * np.pi * self.bolts.hole**2
        return float(self.lap * self.width - holes)

    def mesh(
        self, material: Material, density: float, element_size: float | None = None
    ) -> JointMesh:
        """Hexahedra for the two parts, the shanks and what presses at both their ends.

        Parameters
        ----------
        material : Material
            Of the two parts.
        density : float
            Theirs [kg/m^3].
        element_size : float, optional
            Size of the elements in the lap [m]; a 24th of the lap or a quarter of the width, what
            is less, unless given. Outside the lap they grow.
        """
        density = positive("density", density, "kg/m^3", 7800.0)
        for body in (material, self.bolts.material or material):
            check_elastic(body)
        return self._mesh(material, density, self.size_of_elements(element_size))

    def _mesh(self, material: Material, density: float, size: float, side: int = SIDE) -> JointMesh:
        """The same with so many cells along the squares around bolts, and layers to match."""
        bolts = self.bolts
        half = square_half(bolts, self.lap, self.width)
        end, edge = 0.5 * self.lap, 0.5 * self.width
        marks = [
            [(c - half, c + half) for c in np.unique(bolts.positions[:, axis])] for axis in (0, 1)
        ]
        arm = 0.5 * self.thickness if self.style == "half-lap" else self.thickness
        longest = max(self.lap, self.width, arm)
        check_count(math.ceil(max(longest - 2.0 * half * len(bolts), 0.8 * arm) / size))
        columns = lines(-end, end, marks[0], size, side)
        rows = lines(-edge, edge, marks[1], size, side)
        layers = max(side // 2, round(0.8 * arm / size))
        check_count(4 * layers * (len(columns) - 1) * (len(rows) - 1))
        scale = 1e-7 * min(self.lap, self.width, self.thickness)
        lap = plan(columns, rows, bolts, half, scale, side)
        below, above = np.linspace(-arm, 0.0, layers + 1), np.linspace(0.0, arm, layers + 1)
        solids = Solids(scale)
        arm_cells = [*lap.plate, *(quad for ring in lap.washer for quad in ring)]
        left_cells = list(solids.extrude(lap.points, arm_cells, below, ["left"] * len(below)))
        right_cells = list(solids.extrude(lap.points, arm_cells, above, ["right"] * len(above)))
        full_height = np.concatenate([below, above[1:]]) if self.style == "half-lap" else None
        for sign, body_cells, name, half_height in (
            (-1.0, left_cells, "left", below),
            (1.0, right_cells, "right", above),
        ):
            heights = half_height if full_height is None else full_height
            grid = widening(sign * end, sign * 0.5 * self.length, size, 5.0 * size)
            points, quads = _grid(np.sort(grid), rows)
            body_cells += solids.extrude(points, quads, heights, [name] * len(heights))
        fixings: list[int] = []
        head = bolts.head or 0.0
        shanks = []
        grip = np.linspace(-arm, arm, 2 * layers + 1)
        for k in range(len(bolts)):
            ends = [*lap.washer[k], *lap.clearance[k], *lap.shank[k]]
            for level, end_face in ((-arm - head, "left"), (arm, "right")):
                heights = np.array([level, level + head])
                fixings += solids.extrude(lap.points, ends, heights, [end_face] * 2)
            sides = ["left"] + ["shank"] * (2 * layers - 1) + ["right"]
            shank = solids.extrude(lap.points, lap.shank[k], grip, sides)
            fixings += shank
            shanks.append(Shank(f"bolt {k + 1}", np.array(shank), np.array([0.0, 0.0, 1.0])))
        cells = np.array(solids.cells)
        arms = len(arm_cells) * layers
        tops, bottoms = cells[left_cells[:arms]], cells[right_cells[:arms]]
        contact = ContactFaces("lap", tops[layers - 1 :: layers, 4:], bottoms[::layers, :4])
        bodies = (
            Body("left", np.array(left_cells), material, density),
            Body("right", np.array(right_cells), material, density),
            Body("bolts", np.array(fixings), bolts.material or material, bolts.density or density),
        )
        return JointMesh(solids.points, cells, "hexahedron", bodies, (contact,), tuple(shanks))

    def reduce(
        self,
        material: Material,
        density: float,
        patches: Any = (15, 2),
        *,
        form: Any = None,
        kept_modes: int = 14,
        element_size: float | None = None,
        sensors: Mapping[str, Any] | None = None,
        masses: Mapping[Any, float] | None = None,
    ) -> ReducedJoint:
        """The joint as a small linear model with contact patches, by finite elements.

        Parameters
        ----------
        material : Material
            Of the two parts.
        density : float
            Theirs [kg/m^3].
        patches : (int, int) or array_like
            Patches along and across the lap; or their boxes, one row of x from, x to, y from, y
            to [m] each.
        form : array_like or callable, optional
            Gap between the faces where they are not pressed, see :meth:`ReducedJoint.with_form`;
            flat unless given.
        kept_modes : int
            Modes with immovable patches that are kept beside the static ones.
        element_size : float, optional
            Size of the elements in the lap [m].
        sensors : mapping, optional
            Places and directions by name, such as ``{"tip": ((0.36, 0, 0), "z")}`` [m].
        masses : mapping, optional
            Added masses [kg] by their places (x, y, z) [m].

        Returns
        -------
        ReducedJoint
            Mass, stiffness, patches, bolts and sensors; without the contact and without rigid
            motion.

        Notes
        -----
        Quadratic hexahedra of 20 nodes. Craig and Bampton (1968, DOI 10.2514/3.4741) with the mean
        relative displacement of each patch and the mean axial stress of each shank in the place of
        the boundary's degrees of freedom.
        """
        from microslip.structures.reduction import Reducer

        mesh = self.mesh(material, density, element_size)
        return Reducer(mesh, masses, np.array([1.0, 0.0, 0.0])).reduce(
            tension=self.bolts.tension,
            patches=patches,
            form=form,
            kept_modes=kept_modes,
            sensors=sensors,
        )

    def converge(
        self,
        material: Material,
        density: float,
        surface: NormalLaw,
        friction_coefficient: ArrayLike,
        amplitudes: ArrayLike,
        *,
        mode: int = 0,
        patches: Any = (15, 2),
        form: Any = None,
        tolerance: float = 0.02,
        most_patches: int = 150,
        element_size: float | None = None,
        sensors: Mapping[str, Any] | None = None,
        masses: Mapping[Any, float] | None = None,
    ) -> Convergence:
        """Refine the patches where a mode loses its energy, and say how good the model is.

        Parameters
        ----------
        material : Material
            Of the two parts.
        density : float
            Theirs [kg/m^3].
        surface : NormalLaw
            The normal load law of the surface.
        friction_coefficient : array_like
            Coulomb's coefficient [-], one number (of shape ()).
        amplitudes : array_like
            Modal amplitudes [m kg^(1/2)] at which it is to be good, one-dimensional.
        mode : int
            Which mode, from 0.
        patches : (int, int) or array_like
            The patches to begin with.
        form : array_like or callable, optional
            See :meth:`ReducedJoint.with_form`; not one gap a patch.
        tolerance : float
            Change of the damping ratio by finer patches at which it ends [-].
        most_patches : int
            Patches beyond which it ends at the latest.
        element_size, sensors, masses : optional
            As for :meth:`reduce`.

        Returns
        -------
        Convergence
            The reduced joint, and what finer patches, a finer mesh, more kept modes and more
            harmonics would change.

        Notes
        -----
        Of all patches those that lose 80 % of the energy together are halved, along or across as
        it matters more. A step takes three reductions of the same factors. The mesh is compared
        with one of half as many elements in all directions, rings and layers included.
        """
        from microslip.structures.reduction_convergence import converge

        size = self.size_of_elements(element_size)

        def mesh_of(coarse: bool) -> JointMesh:
            if coarse:
                return self._mesh(material, density, 2.0 * size, SIDE // 2)
            return self.mesh(material, density, element_size)

        return converge(
            mesh_of,
            size,
            np.array([1.0, 0.0, 0.0]),
            surface,
            friction_coefficient,
            tension=self.bolts.tension,
            mode=mode,
            amplitudes=record("amplitudes", amplitudes),
            patches=patches,
            form=form,
            tolerance=positive("tolerance", tolerance, "", 0.02),
            most_patches=most_patches,
            sensors=sensors,
            masses=masses,
        )

    def size_of_elements(self, element_size: float | None = None) -> float:
        """Size of the elements in the lap [m], as given or as usual."""
        usual = min(self.lap / 24.0, self.width / 4.0)
        return usual if element_size is None else positive("element_size", element_size, "m", 5e-3)


def _grid(columns: np.ndarray[Any, Any], rows: np.ndarray[Any, Any]) -> tuple[Any, Any]:
    """Points and quadrilaterals of a grid in plan."""
    xs, ys = np.meshgrid(columns, rows, indexing="ij")
    index = np.arange(xs.size).reshape(xs.shape)
    corners = (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:])
    quads = np.stack([part.ravel() for part in corners], axis=1)
    return np.stack([xs.ravel(), ys.ravel()], axis=1), [tuple(quad) for quad in quads.tolist()]
