"""A bolted joint as a small linear model with patches, bolts and sensors."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core.checks import Floats, floats, number, positive, show
from microslip._core.errors import InputError
from microslip._core.files import atomic_file
from microslip._core.frozen import LockedArrays, lock
from microslip._core.wording import quoted
from microslip.contact import NormalLaw
from microslip.friction import JointField
from microslip.readers.array_files import archived
from microslip.readers.files import POINTS, reading
from microslip.structures.bolts import each_bolt
from microslip.structures.geometry import GeometryAttachment
from microslip.structures.matrices import vector
from microslip.structures.reduction_files import KIND, NEWER, check_arrays
from microslip.structures.reduction_patches import Samples, gaps_at, mean_over
from microslip.structures.static import base_damping
from microslip.structures.structure import Preload, Structure

_TIGHTENINGS, _ABOVE = 8, 1.01  # tightenings of a face until none is heavier; a margin
_NESTED = ("samples", "surface", "geometry")


class Surface(NamedTuple):
    """Surface of the bodies, and its motion with each degree of freedom."""

    points: NDArray[np.float32]
    facets: NDArray[np.int32]
    motion: NDArray[np.float32]
    """Displacements of the points per degree of freedom, (points, 3, degrees of freedom)."""


@dataclass(frozen=True, eq=False)
class ReducedJoint(LockedArrays):
    """Bolted structure without its contact: mass, stiffness, patches and bolts.

    :meth:`LapJoint.reduce` and :meth:`MeshedJoint.reduce` make it. Its degrees of freedom are, for
    patch p, the mean relative displacement of its two faces along (3p), across (3p + 1) and apart
    (3p + 2); then one elongation a bolt; then modes with immovable patches. Rigid motion is no part
    of it. The law of the surface, its friction, the tension of the bolts and the form of the faces
    come afterwards: one reduced model serves them all.

    After Craig and Bampton (1968), DOI 10.2514/3.4741.
    """

    mass: Floats
    """Mass matrix [kg]."""
    stiffness: Floats
    """Stiffness matrix [N/m], with the bolts and without the contact."""
    patch_areas: Floats
    """Areas of the patches [m^2]."""
    patch_gaps: Floats
    """Form: gaps of the unloaded patches, the smallest one zero [m]."""
    patch_boxes: Floats
    """x from, x to, y from, y to of each patch, along and across its contact [m]."""
    patch_contacts: NDArray[np.int64]
    """Number [-] of the contact that each patch belongs to."""
    bolt_stiffness: Floats
    """Stiffness that relieves the axial stress of each bolt [N/m]."""
    bolt_tension: Floats
    """Tension of each bolt after tightening [N]."""
    sensor_names: tuple[str, ...]
    """Names of the sensors."""
    sensor_rows: Floats
    """Displacement of each sensor [-] by the degrees of freedom, (sensors, degrees of freedom)."""
    samples: Samples
    """Sample points of the patches."""
    surface: Surface
    """Surface of the bodies, for figures."""
    full_size: int
    """Degrees of freedom before the reduction."""
    left_out: float
    """Fraction of the faces without an opposite face [-]."""
    base_inertia: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    """Inertia [kg] of the degrees of freedom, and of all as one piece in the last three rows, for a
    ground that moves along x, y, z; none of a structure that floats."""
    sensor_base: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    """Motion of each sensor per unit motion of the ground [-], (sensors, 3)."""
    geometry: GeometryAttachment | None = None
    """Nonlinear stiffness in large bending, see :meth:`with_geometry`."""

    @property
    def size(self) -> int:
        """Number of degrees of freedom."""
        return len(self.mass)

    @property
    def patches(self) -> int:
        """Number of patches."""
        return len(self.patch_areas)

    @cached_property
    def directions(self) -> Floats:
        """Motions of the patches (degrees of freedom, patches, 3): along, across, opening."""
        result = np.zeros((self.size, self.patches, 3))
        index = np.arange(3 * self.patches)
        result[index, index // 3, index % 3] = 1.0
        return lock(result)

    @property
    def patch_centres(self) -> Floats:
        """Centres of the patches along and across [m]."""
        boxes = self.patch_boxes
        return 0.5 * (boxes[:, [0, 2]] + boxes[:, [1, 3]])

    @property
    def layout(self) -> Floats:
        """Contact [-] and box [m] of each patch, one row each, valid as ``patches`` again."""
        return np.column_stack([self.patch_contacts, self.patch_boxes])

    @property
    def _bolts(self) -> slice:
        start = 3 * self.patches
        return slice(start, start + len(self.bolt_stiffness))

    def sensor(self, name: str, base: bool = False) -> Floats:
        """Return the displacement at a sensor [m] as a vector over the degrees of freedom.

        Parameters
        ----------
        name : str
            One of :attr:`sensor_names`.
        base : bool
            Whether the motion of the ground is among them, see :meth:`on_base`.

        Returns
        -------
        ndarray
            Row that multiplies displacements; it is also the unit force at the sensor.
        """
        if name not in self.sensor_names:
            there = quoted(self.sensor_names) if self.sensor_names else "no sensor"
            raise InputError(f"sensor must be {there}, got {show(name)}")
        index = self.sensor_names.index(name)
        row: Floats = self.sensor_rows[index]
        return np.concatenate([row, self.sensor_base[index]]) if base else row

    def with_form(self, form: ArrayLike | Any, factor: float = 1.0) -> ReducedJoint:
        """Return the joint with another form of its faces.

        Parameters
        ----------
        form : callable or array_like
            Gap between the faces where nothing presses: a function of x and y (arrays, along and
            across the lap from its middle [m]) that gives gaps [m]; a table with the columns x, y
            and gap [m], NaN where unknown, for example from two scans of the faces; or
            one gap [m] for each patch, of the shape (patches,).
        factor : float
            Factor on all gaps, such as 0 for flat faces or -1 for the reversed
            form.

        Returns
        -------
        ReducedJoint
            New joint. A gap common to all patches has no effect and is removed.

        Notes
        -----
        A patch has the mean gap over its sample points.
        """
        factor = number("factor", factor)
        table = None if callable(form) else floats("form", form, missing=True)
        if table is not None and table.ndim == 1:
            if table.shape != (self.patches,):
                raise InputError(
                    f"form must have one gap for each of the {self.patches} patches, got shape "
                    f"{table.shape}"
                )
            gaps = table
        else:
            gaps = mean_over(self.samples, gaps_at(form, self.samples.places), self.patches)
        unknown = np.flatnonzero(~np.isfinite(gaps))
        if unknown.size:
            x, y = self.patch_centres[unknown[0]]
            raise InputError(
                f"form must give a gap to each patch, but gives none to {unknown.size} of "
                f"{self.patches}, the first at ({x:.4g}, {y:.4g}) m"
            )
        gaps = factor * gaps
        return replace(self, patch_gaps=gaps - gaps.min())

    def with_tension(self, tension: ArrayLike) -> ReducedJoint:
        """Return the joint with other bolt tensions [N], one number or one per bolt.

        Parameters
        ----------
        tension : array_like
            Tensions [N], above zero; one number, or of shape (bolts,).

        Returns
        -------
        ReducedJoint
            A new one.
        """
        bolts = len(self.bolt_stiffness)
        return replace(self, bolt_tension=each_bolt("tension", tension, bolts, "N"))

    def field(
        self, surface: NormalLaw, friction_coefficient: ArrayLike, surface_area: float | None = None
    ) -> JointField:
        """Return the patches as nodes of a field with their gaps [m] (one-dimensional)."""
        return JointField(
            surface, friction_coefficient, areas=self.patch_areas, gaps=self.patch_gaps,
            surface_area=surface_area,
        )  # fmt: skip

    def structure(self, surface: NormalLaw, friction_coefficient: ArrayLike) -> Structure:
        """Return the joint with its contact, before the bolts are tightened.

        Parameters
        ----------
        surface : NormalLaw
            The normal load law of the surface.
        friction_coefficient : array_like
            Coulomb's coefficient [-], one number or of shape (patches,).

        Returns
        -------
        Structure
            The reduced matrices with the field attached.
        """
        field = self.field(surface, friction_coefficient)
        structure = Structure(self.mass, self.stiffness).attach(field, directions=self.directions)
        return structure if self.geometry is None else structure.with_attachment(self.geometry)

    def with_geometry(
        self, sensors: Iterable[str], cases: Any, weights: ArrayLike | None = None
    ) -> ReducedJoint:
        """Return the joint with a stiffness that depends on the bending of its thin parts.

        Parameters
        ----------
        sensors : iterable of str
            Sensors whose displacements are the coordinates, at most six.
        cases : (array_like, array_like)
            Static cases: displacements of these [m] and the forces that hold them there [N], each
            of the shape (cases, sensors), all else free; see :meth:`Structure.with_geometry`. They
            count from the tightened state.
        weights : array_like, optional
            Coordinates that are sums over sensors: what each counts in each, of the shape
            (sensors, coordinates).

        Returns
        -------
        ReducedJoint
            A new one; it is not saved with the geometry.
        """
        rows = np.array([self.sensor(name) for name in sensors])
        if weights is not None:
            shares = floats("weights", weights)
            if shares.ndim != 2 or len(shares) != len(rows):
                raise InputError(
                    f"weights must be of the shape ({len(rows)} sensors, coordinates), got "
                    f"{shares.shape}"
                )
            rows = shares.T @ rows
        bent = Structure(self.mass, self.stiffness).with_geometry(rows.T, cases=cases)
        (attachment,) = bent.attachments
        return replace(self, geometry=cast(GeometryAttachment, attachment))

    def on_base(
        self, surface: NormalLaw, friction_coefficient: ArrayLike, damping_ratio: float = 0.0
    ) -> Preload:
        """Return the tightened joint with the ground motion as three more degrees of freedom.

        Parameters
        ----------
        surface : NormalLaw
            The normal load law of the surface.
        friction_coefficient : array_like
            As for :meth:`structure`, one number or of shape (patches,).
        damping_ratio : float
            Base damping of each mode [-], of dashpots that move with the ground.

        Returns
        -------
        Preload
            With ``base_response``, ``random_response`` and ``shock``, to be given
            ``**joint.base("z")``.
        """
        self.base("z")
        state = self.tightened(surface, friction_coefficient)
        ratio, model = base_damping(damping_ratio), state.model
        carried = np.asarray(self.mass @ model.shapes)
        drag = (carried * (2.0 * ratio * np.sqrt(model.squares))) @ carried.T
        mass, stiffness, damping = (
            np.pad(part, (0, 3)) for part in (self.mass, self.stiffness, drag)
        )
        mass[:, self.size :] = self.base_inertia
        mass[self.size :] = self.base_inertia.T
        shaken = Structure(mass, stiffness, damping if ratio else None)
        for joints in state.attachments:  # the ground carries them as one piece
            rows: dict[str, Any] = {
                part.name: np.pad(value, [(0, 3)] + [(0, 0)] * (value.ndim - 1))
                for part in fields(joints)
                if part.name != "reach"
                and (value := np.asarray(getattr(joints, part.name))).shape[:1] == (self.size,)
            }
            shaken = shaken.with_attachment(replace(joints, **rows))
        return shaken.preload(np.pad(state.static_force, (0, 3)))

    def base(self, direction: str) -> dict[str, Any]:
        """Return the arguments of ``base_response``, ``random_response`` and ``shock``.

        Parameters
        ----------
        direction : {"x", "y", "z"}
            Along which axis of the mesh.

        Returns
        -------
        dict
            ``supports`` and ``directions``.
        """
        if not len(self.base_inertia):
            raise InputError("the structure has no base: give its mesh a ground")
        if direction not in ("x", "y", "z"):
            raise InputError(f'direction must be "x", "y" or "z", got {show(direction)}')
        way = np.array([float(axis == direction) for axis in "xyz"])
        return {"supports": list(range(self.size, self.size + 3)), "directions": way}

    def static_force(self, surface: NormalLaw) -> Floats:
        """Return the bolt forces on the tightened joint [N], without their elastic forces.

        Parameters
        ----------
        surface : NormalLaw
            As for :meth:`structure`.

        Returns
        -------
        ndarray
            One force a degree of freedom: with them :meth:`Structure.preload` comes to the
            tensions of the bolts. While bolts are tightened they pull without an axial stiffness,
            which is put back in the state so found.
        """
        state, pull = self._pulled(surface, surface)
        surface._check_rest(state.pressures * self.field(surface, 1.0).surface_area)
        return pull

    def _pulled(self, surface: NormalLaw, law: NormalLaw) -> tuple[Preload, Floats]:
        """Return the state under bolt tensions without bolt stiffness, and the bolt forces [N].

        The contact law ``law`` is that of the surface, or its first loading.
        """
        pull = np.zeros(self.size)
        pull[self._bolts] = -self.bolt_tension
        index = np.arange(self.size)[self._bolts]
        loose = self.stiffness.copy()
        loose[index, index] -= self.bolt_stiffness
        field = self.field(law, 1.0, None if law is surface else getattr(surface, "area", None))
        state = Structure(self.mass, loose).attach(field, directions=self.directions)._preload(pull)
        pull[self._bolts] += self.bolt_stiffness * state.displacement[self._bolts]
        return state, pull

    def tightened(self, surface: NormalLaw, friction_coefficient: ArrayLike) -> Preload:
        """Return the joint with its bolts tightened; arguments as :meth:`structure`.

        Returns
        -------
        Preload
            The static state, with its pressures, ``modes``, ``forced_response`` and ``integrate``.

        Notes
        -----
        On a face that yields the pressures are those of first loading, and each patch was tightened
        by its own: its stiffness is proportional to it, and all patches begin to slide at nearly
        the same displacement. A drawn face needs no tightening pressure for that; a measured one
        must have been solved up to the largest.
        """
        for _ in range(_TIGHTENINGS):
            loosely, force = self._pulled(surface, surface._first)
            field = self.field(surface, friction_coefficient)
            largest = float(loosely.pressures.max()) * field.surface_area
            if surface._under(largest) is surface:
                break
            surface = surface._under(_ABOVE * largest)
        surface._check_rest(np.array([largest]))
        if surface._first is not surface:
            field = field._tightened_at(loosely.gaps, loosely.normal_loads)
        structure = Structure(self.mass, self.stiffness).attach(field, directions=self.directions)
        state = structure.preload(force)
        if self.geometry is None:
            return state
        bending = replace(self.geometry, rest=state.displacement)  # the cases are of what is tight
        return structure.with_attachment(bending).preload(force)

    def tensions(self, displacement: ArrayLike, static_force: ArrayLike) -> Floats:
        """Return the tensions of the bolts in a static state [N].

        Parameters
        ----------
        displacement, static_force : array_like
            Displacements and forces of the state [m], [N], of shape (degrees of freedom,).

        Returns
        -------
        ndarray
            Tensions [N], one per bolt.
        """
        moved = vector("displacement", displacement, self.size)[self._bolts]
        pushed = vector("static_force", static_force, self.size)[self._bolts]
        return self.bolt_stiffness * moved - pushed

    def scaled(self, stiffness: float = 1.0, mass: float = 1.0) -> ReducedJoint:
        """Return the joint of a material that is stiffer or heavier by factors.

        Parameters
        ----------
        stiffness : float
            Factor on the stiffness of all bodies [-].
        mass : float
            Factor on their mass [-].

        Returns
        -------
        ReducedJoint
            Exactly what its mesh reduces to (Craig and Bampton 1968, DOI 10.2514/3.4741).
        """
        stiffness = positive("stiffness", stiffness, "", 1.1)
        mass = positive("mass", mass, "", 1.1)
        if stiffness == mass == 1.0:
            return self
        return replace(
            self,
            mass=mass * self.mass,
            base_inertia=mass * self.base_inertia,
            stiffness=stiffness * self.stiffness,
            bolt_stiffness=stiffness * self.bolt_stiffness,
        )

    def save(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
        """Write the model to an ``.npz`` file.

        Parameters
        ----------
        path : str or path
            The file, ending in ``.npz``.
        overwrite : bool, optional
            Replace an existing file.
        """
        file = Path(path)
        if file.suffix.lower() != ".npz":
            raise InputError(f"{file.name}: a reduced joint is written to an .npz file")
        if self.geometry is not None:
            raise InputError(f"{file.name}: save the joint before with_geometry, which is not kept")
        arrays: dict[str, Any] = {"kind": np.array(KIND)}
        for part in (f for f in fields(self) if f.name != "geometry"):
            value = getattr(self, part.name)
            if isinstance(value, (Samples, Surface)):
                arrays |= {f"{part.name}_{k}": v for k, v in value._asdict().items()}
            else:
                arrays[part.name] = np.asarray(value)
        arrays["sensor_names"] = np.array(self.sensor_names, dtype=np.str_)
        with atomic_file(file, overwrite) as stage, stage.open("wb") as stream:
            np.savez_compressed(stream, **arrays)

    @classmethod
    def load(cls, path: str | os.PathLike[str], *, limit: int = POINTS) -> ReducedJoint:
        """Read a model written by :meth:`save`.

        Parameters
        ----------
        path : str or path
            The file.
        limit : int, optional
            Numbers that it may hold.

        Returns
        -------
        ReducedJoint
            The same numbers.
        """
        file = Path(path)
        with reading(file, "a reduced joint", limit):
            arrays = archived(file)
            check_arrays(arrays)
        samples = Samples(*(arrays[f"samples_{k}"] for k in Samples._fields))
        surface = Surface(*(arrays[f"surface_{k}"] for k in Surface._fields))
        values: dict[str, Any] = {
            f.name: arrays[f.name]
            for f in fields(cls)
            if f.name not in _NESTED and (f.name in arrays or f.name not in NEWER)
        }
        values["sensor_names"] = tuple(str(name) for name in values["sensor_names"])
        values |= {"full_size": int(values["full_size"]), "left_out": float(values["left_out"])}
        return cls(**values, samples=samples, surface=surface)
