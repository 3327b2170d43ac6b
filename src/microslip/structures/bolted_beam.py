"""Structures of beams and plates in a row, with bolted laps between them and to the ground."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, exact, members, positive, record, show
from microslip._core.errors import InputError
from microslip._core.frozen import assign
from microslip._core.parameters import parameter, parameters_of
from microslip._core.wording import quoted
from microslip.contact import NormalLaw
from microslip.contact.materials import Material
from microslip.structures.beam_mesh import Lap, Stretch, Style, beam_mesh
from microslip.structures.bolts import Bolts, metres
from microslip.structures.geometry import Bending, Sizes, Strip, strip_sensors
from microslip.structures.mesh import (
    SIDE,
    JointMesh,
    bolt_block_half_width,
    check_elastic,
)

if TYPE_CHECKING:
    from microslip.structures.reduction_convergence import Convergence
    from microslip.structures.reduction_model import ReducedJoint

GROUNDS = ("left", "right")
_ALONG = np.array([1.0, 0.0, 0.0])


class Drawing:
    """Base class of beams given by their dimensions: parts in a row with at least one lap."""

    length: float
    width: float
    thickness: float
    style: Style

    laps: Sequence[Lap]
    """The laps along the beam."""
    ground: Sequence[str] = ()
    """Ends that are bolted to rigid ground."""
    rise: float = 0.0
    """Height of the middle of each part between two laps above its ends [m]."""
    _names: tuple[str, ...] = ()

    def _check(self) -> None:
        for declared in parameters_of(type(self)):
            assign(self, **{declared.name: declared.checked(getattr(self, declared.name))})
        if self.style not in ("half-lap", "single-lap"):
            raise InputError(f'style must be "half-lap" or "single-lap", got {show(self.style)}')
        for lap in self.laps:
            bolt_block_half_width(lap.bolts, lap.length, self.width)

    @property
    def tension(self) -> Floats:
        """Tension of each bolt [N], lap by lap."""
        return np.concatenate([lap.bolts.tension for lap in self.laps])

    @property
    def face_area(self) -> float:
        """Area of the contact faces without the holes [m^2]."""
        holes = sum(len(lap.bolts) * 0.25 * np.pi * lap.bolts.hole**2 for lap in self.laps)
        return float(sum(lap.length for lap in self.laps) * self.width - holes)

    @property
    def parts(self) -> tuple[str, ...]:
        """Names of the parts from left to right, without the ground."""
        return tuple(part.name for part in self.stretches if "ground" not in part.name)

    @property
    def stretches(self) -> tuple[Stretch, ...]:
        """Parts of the beam and the ground from left to right, alternately lower and upper ones.

        Neighbours overlap at a lap, where the lower part is below the contact face.
        """
        laps = self.laps
        # The ground lies below, where it can.
        first = 1 if self.ground == ("right",) and len(laps) % 2 else 0
        edges = [-0.5 * self.length, *(x for lap in laps for x in lap.ends), 0.5 * self.length]
        grounds = {0: "left", len(laps): "right"}
        parts, number = [], 0
        for k, (start, stop) in enumerate(zip(edges[::2], edges[1::2], strict=True)):
            lower = (k + first) % 2 == 0
            if grounds.get(k) in self.ground:
                parts.append(Stretch(f"{grounds[k]} ground", lower, ()))
                continue
            number += 1
            name = self._names[k] if self._names else f"part {number}"
            free = ((start, stop, k > 0, k < len(laps)),)
            rise = self.rise if 0 < k < len(laps) else 0.0
            parts.append(Stretch(name, lower, free if stop > start else (), rise))
        return tuple(parts)

    def mesh(self, material: Any, density: Any, element_size: float | None = None) -> JointMesh:
        """Return a mesh of hexahedra of the parts, shanks, heads, nuts and washers.

        Parameters
        ----------
        material : Material or sequence of Material
            Material of all parts, or of each part from left to right, without the ground.
        density : float or sequence of float
            Density of all parts, or of each part [kg/m^3].
        element_size : float, optional
            Size of the elements in the laps [m]; by default a 24th of the shortest lap or a quarter
            of the width, whichever is smaller. Outside the laps elements are larger.
        """
        return self._mesh(material, density, self._element_size(element_size))

    def _bodies(self, material: Any, density: Any) -> dict[str, tuple[Material, float]]:
        names = self.parts
        listed: dict[str, list[Any]] = {}
        for name, value in (("material", material), ("density", density)):
            several = isinstance(value, (list, tuple)) or (
                isinstance(value, np.ndarray) and value.ndim > 0
            )
            given = list(value) if several else [value] * len(names)
            if len(given) != len(names):
                raise InputError(
                    f"{name} must be one, or one for each of the {len(names)} parts from left to "
                    f"right, got {len(given)}"
                )
            listed[name] = given
        for body in listed["material"]:
            check_elastic(body)
        heavy = [positive("density", value, "kg/m^3", 7800.0) for value in listed["density"]]
        return dict(zip(names, zip(listed["material"], heavy, strict=True), strict=True))

    def _mesh(self, material: Any, density: Any, size: float, side: int = SIDE) -> JointMesh:
        bodies = self._bodies(material, density)
        for lap in self.laps:
            check_elastic(lap.bolts.material or next(iter(bodies.values()))[0])
        sizes = self.width, self.thickness
        return beam_mesh(self.laps, self.stretches, bodies, sizes, self.style, size, side)

    def reduce(
        self,
        material: Any,
        density: Any,
        patches: Any = None,
        *,
        kept_modes: int = 14,
        element_size: float | None = None,
        sensors: Mapping[str, Any] | None = None,
        masses: Mapping[Any, float] | None = None,
    ) -> ReducedJoint:
        """Reduce the joint by finite elements to a small linear model with contact patches.

        Parameters
        ----------
        material : Material or sequence of Material
            Material of all parts, or of each part from left to right.
        density : float or sequence of float
            Density of all parts, or of each part [kg/m^3].
        patches : (int, int) or array_like, optional
            Number of patches along and across each lap, or the bounds of each patch: rows of
            x from, x to, y from, y to [m]. By default some 60 patches a lap, such as 30 x 2.
            Patches that the elements cannot resolve are merged with their neighbours.
        kept_modes : int
            Number of modes with immovable patches and bolts, besides the static shapes.
        element_size : float, optional
            Size of the elements in the laps [m].
        sensors : mapping, optional
            Position [m] and direction of each sensor, such as ``{"tip": ((0.36, 0, 0), "z")}``.
        masses : mapping, optional
            Added point masses [kg] by position (x, y, z) [m].

        Returns
        -------
        ReducedJoint
            Mass, stiffness, patches, bolts and sensors; without contact forces and without
            rigid-body motion. Its faces are flat, see :meth:`ReducedJoint.with_form`.

        Notes
        -----
        Quadratic hexahedra of 20 nodes. Reduction of Craig and Bampton (1968, DOI 10.2514/3.4741),
        whose boundary degrees of freedom are here the mean relative displacements of each patch
        and the elongation of each shank, defined by its mean axial stress.
        """
        from microslip.structures.reduction import Reducer

        mesh = self.mesh(material, density, element_size)
        return Reducer(mesh, masses, _ALONG).reduce(
            tension=self.tension,
            patches=patches,
            kept_modes=kept_modes,
            sensors=sensors,
        )

    def converge(
        self,
        material: Any,
        density: Any,
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
        progress: Callable[[float], None] | None = None,
    ) -> Convergence:
        """Refine the patches that dissipate most energy in a mode, and estimate the model error.

        Parameters
        ----------
        material, density : Material, float or sequence
            As for :meth:`reduce` [kg/m^3].
        surface, friction_coefficient : NormalLaw, array_like
            The law of the surface, and Coulomb's coefficient [-] as a single number, shape ().
        amplitudes : array_like
            Modal amplitudes [m kg^(1/2)] at which the mode is computed, one-dimensional.
        mode : int
            Index of the elastic mode, from 0.
        patches, form : optional
            Initial patches, and a form as for :meth:`ReducedJoint.with_form`: a function or a
            table, but not an array of one gap per patch, since the patches change.
        tolerance : float
            Refinement ends when halving the patches changes the damping ratio by less than this
            fraction [-].
        most_patches : int
            Largest number of patches.
        element_size, sensors, masses : optional
            As for :meth:`reduce`.
        progress : callable, optional
            Called with the approximate completed fraction [-].

        Returns
        -------
        Convergence
            Refined joint, and the changes of frequency and damping by finer patches, a finer mesh,
            more kept modes and more harmonics.

        Notes
        -----
        Each refinement halves the patches that together dissipate 80 % of the energy, along or
        across, whichever changes the damping more. Each refinement needs three reductions, which
        share one factorised stiffness matrix. The error of the mesh is estimated from a mesh with
        half as many elements in each direction: along, across, through the thickness, and in the
        rings around the bolts.
        """
        from microslip.structures.reduction_convergence import converge

        return converge(
            partial(self._mesh, material, density),
            self._element_size(element_size),
            _ALONG,
            surface,
            friction_coefficient,
            tension=self.tension,
            mode=mode,
            amplitudes=record("amplitudes", amplitudes, "m"),
            patches=patches,
            form=form,
            tolerance=positive("tolerance", tolerance, "", 0.02),
            most_patches=most_patches,
            progress=progress,
            sensors=sensors,
            masses=masses,
        )

    def _element_size(self, element_size: float | None) -> float:
        usual = min(min(lap.length for lap in self.laps) / 24.0, self.width / 4.0)
        return usual if element_size is None else positive("element_size", element_size, "m", 5e-3)


@dataclass(frozen=True, eq=False)
class LapJoint(Drawing):
    """Two beams or plates, bolted where they overlap.

    The lap is centred at the origin and lies in the plane z = 0: x runs along the joint, y across,
    z upwards. In the lap the left part is the lower one. Both ends are free. For several laps, or
    ends bolted to the ground, see :class:`BoltedBeam`.

    Parameters
    ----------
    length : float
        Total length, from end to end [m].
    width : float
        Width, across [m].
    thickness : float
        Thickness of the parts outside the lap [m].
    lap : float
        Length of the overlap [m].
    bolts : Bolts
        Bolts through the overlap.
    style : {"half-lap", "single-lap"}
        In a half lap each part is half as thick in the overlap, so that the whole is straight; in
        a single lap whole plates lie on each other.

    Notes
    -----
    Elements and reduction: :meth:`reduce`, after Craig and Bampton (1968, DOI 10.2514/3.4741).

    Examples
    --------
    >>> import microslip as ms
    >>> bolts = ms.Bolts([-0.03, 0.0, 0.03], shank=0.008, hole=0.009, washer=0.018, tension=12e3)
    >>> ms.LapJoint(length=0.72, width=0.025, thickness=0.025, lap=0.12, bolts=bolts).style
    'half-lap'
    """

    length: float = field(metadata=metres("L", "length from end to end", 0.72))
    width: float = field(metadata=metres("b", "width, across", 0.0254))
    thickness: float = field(metadata=metres("t", "thickness of each part outside the lap", 0.0254))
    lap: float = field(metadata=metres("l", "length of the overlap", 0.12))
    bolts: Bolts
    style: Style = "half-lap"

    _names = ("left", "right")

    def __post_init__(self) -> None:
        self._check()
        if not self.lap < self.length:
            raise InputError(
                f"lap must be shorter than the length {exact(self.length)} m, got "
                f"{exact(self.lap)} m"
            )

    @property
    def laps(self) -> tuple[Lap, ...]:  # type: ignore[override]
        """Single lap of the joint."""
        return (Lap(0.0, self.lap, self.bolts),)


@dataclass(frozen=True, eq=False)
class BoltedBeam(Drawing):
    """Row of beams or plates, bolted where they overlap; its ends may be bolted to the ground.

    x runs along the beam from its middle, y across, z upwards from the faces of the laps. Parts lie
    in turn below and above their neighbours, so that a beam with two laps can be symmetric. A
    :class:`LapJoint` has a single lap in the middle.

    Parameters
    ----------
    length : float
        Total length, from end to end [m].
    width : float
        Width, across [m].
    thickness : float
        Thickness of the parts outside the laps [m].
    laps : sequence of Lap
        Laps from left to right; a part connects each lap with the next one.
    style : {"half-lap", "single-lap"}
        In a half lap each part is half as thick in the overlap, so that the whole is straight; in
        a single lap whole plates lie on each other.
    ground : sequence of str, optional
        "left", "right" or both: the outer lap on that side reaches to the end of the beam, and its
        other face is rigid ground.
    rise : float, optional
        Height of the middle of each part between two laps above its ends [m], in the form of a
        raised cosine: a curved panel.

    Notes
    -----
    Elements and reduction: :meth:`reduce`, after Craig and Bampton (1968, DOI 10.2514/3.4741).

    Examples
    --------
    >>> import microslip as ms
    >>> bolts = ms.Bolts([0.0], shank=0.006, hole=0.0066, washer=0.012, tension=5e3)
    >>> laps = [ms.Lap(-0.1, 0.03, bolts), ms.Lap(0.1, 0.03, bolts)]
    >>> beam = ms.BoltedBeam(length=0.3, width=0.02, thickness=0.012, laps=laps)
    >>> beam.parts
    ('part 1', 'part 2', 'part 3')
    """

    length: float = field(metadata=metres("L", "length from end to end", 0.72))
    width: float = field(metadata=metres("b", "width, across", 0.0254))
    thickness: float = field(
        metadata=metres("t", "thickness of each part outside the laps", 0.0254)
    )
    laps: Sequence[Lap]
    style: Style = "half-lap"
    ground: Sequence[str] = ()
    rise: float = field(
        default=0.0,
        metadata=parameter(
            "h", "m", "height of the middle of a part between two laps above its ends",
            least=0.0, example="2 mm",
        ),
    )  # fmt: skip

    def __post_init__(self) -> None:
        laps = members("laps", self.laps, Lap, "a list of ms.Lap(...)")
        ground = (self.ground,) if isinstance(self.ground, str) else tuple(self.ground)
        if not set(ground) <= set(GROUNDS) or len(set(ground)) < len(ground):
            raise InputError(f"ground must be among {quoted(GROUNDS, 'and')}, got {show(ground)}")
        assign(self, laps=tuple(laps), ground=tuple(g for g in GROUNDS if g in ground))
        self._check()
        reach, tolerance = 0.5 * self.length, 1e-9 * self.length
        ends = [x for lap in self.laps for x in lap.ends]
        for side, end, outer in ((-1.0, ends[0], "left"), (1.0, ends[-1], "right")):
            beyond = side * end - reach
            if outer in self.ground:
                if abs(beyond) > tolerance:
                    lap = self.laps[0 if side < 0.0 else -1]
                    raise InputError(
                        f"the lap on the {outer} ground must reach to the end of the beam, at "
                        f"{exact(side * reach)} m: write at={side * (reach - 0.5 * lap.length):.6g}"
                    )
            elif beyond > -tolerance:
                raise InputError(
                    f"laps must lie within the beam, which reaches to ±{exact(reach)} m, got one "
                    f"to {end:.6g} m"
                )
        for number, (stop, start) in enumerate(zip(ends[1:-1:2], ends[2::2], strict=True), 1):
            if not start - stop > tolerance:
                raise InputError(
                    f"laps must follow each other from left to right with room between them; lap "
                    f"{number} ends at {stop:.6g} m and lap {number + 1} begins at {start:.6g} m"
                )
        if len(self.laps) == 1 and len(self.ground) == 2:
            raise InputError("ground on both sides needs two laps, got one")

    def bending(self, material: Material, reach: float | None = None) -> Bending:
        """Return the arguments of :meth:`ReducedJoint.with_geometry` for large deflections.

        Parameters
        ----------
        material : Material
            Material of the part between the two grounded supports.
        reach : float, optional
            Largest deflection of its middle [m]; 1.5 thicknesses by default.

        Returns
        -------
        Bending
            Sensors, static cases, and weights of the sensors in the mean deflection and the
            elongation, to be used as ``joint = beam.reduce(..., sensors=bending.sensors)``, then
            ``joint.with_geometry(*bending)``.

        Notes
        -----
        The static cases prescribe the mean deflection and the elongation of the part; the forces on
        it are computed with 32 von Karman elements and clamped ends (shallow arches and plates:
        Amabili, *Nonlinear Vibrations and Stability of Shells and Plates*, 2008).
        """
        check_elastic(material)
        if len(self.laps) != 2 or self.ground != GROUNDS:
            raise InputError(
                "a drawing bends between two clamps: write two laps and ground on the left and on "
                "the right, or give static cases of a finite-element code"
            )
        part = self.stretches[1]
        ((start, stop, _, _),) = part.free
        height = (-0.5 if part.lower else 0.5) * self.thickness * (self.style == "single-lap")
        sizes = Sizes(stop - start, self.width, self.thickness, self.rise)
        far = 1.5 * sizes.thickness if reach is None else positive("reach", reach, "m", 2e-3)
        sensors, weights = strip_sensors(sizes, start, height)
        return Bending(sensors, Strip(sizes, material).cases(far), weights)
