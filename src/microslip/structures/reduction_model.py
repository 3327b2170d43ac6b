"""A bolted joint as a small linear model with patches, bolts and sensors."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core.checks import Floats, floats, number, positive, show
from microslip._core.errors import InputError
from microslip._core.files import atomic_file
from microslip._core.frozen import LockedArrays, lock
from microslip._core.threads import single_threaded
from microslip._core.wording import quoted
from microslip.contact import NormalLaw
from microslip.friction import JointField
from microslip.readers.array_files import archived
from microslip.readers.files import POINTS, reading
from microslip.structures.bolts import each_bolt
from microslip.structures.geometry import GeometryAttachment
from microslip.structures.joint_groups import change_rows
from microslip.structures.matrices import vector
from microslip.structures.reduction_files import NEWER, arrays_of, check_arrays
from microslip.structures.reduction_patches import Samples, Surface, gaps_at, mean_over
from microslip.structures.static import base_damping
from microslip.structures.structure import Preload, Structure

_TIGHTENINGS, _ABOVE = 8, 1.01  # tightenings of a face until none is heavier; a margin
_NESTED = ("samples", "surface", "geometry")


@dataclass(frozen=True, eq=False)
class ReducedJoint(LockedArrays):
    """Bolted structure without its contact: mass, stiffness, patches and bolts.

    Created by :meth:`LapJoint.reduce` and :meth:`MeshedJoint.reduce`. The degrees of freedom are,
    for each patch p from 0, the mean displacement of the upper face relative to the lower face
    along (3p), across (3p + 1) and opening (3p + 2); then the elongation of each bolt; then the
    coordinates of modes with immovable patches and bolts. Rigid-body motion is excluded. The law
    of the surface, its friction, the tension of the bolts and the form of the faces are given
    afterwards, so that one reduction serves all their values.

    After Craig and Bampton (1968), DOI 10.2514/3.4741.
    """

    mass: Floats
    """Mass matrix [kg]."""
    stiffness: Floats
    """Stiffness matrix [N/m], with the bolts and without the contact."""
    patch_areas: Floats
    """Areas of the patches [m^2]."""
    patch_gaps: Floats
    """Mean gap of each patch without load [m], the form of the faces; the smallest is zero."""
    patch_boxes: Floats
    """Bounds x from, x to, y from, y to of each patch [m], x along and y across its contact."""
    patch_contacts: NDArray[np.int64]
    """Number [-] of the contact that each patch belongs to."""
    bolt_stiffness: Floats
    """Axial stiffness of the shank of each bolt: force per elongation [N/m]."""
    bolt_tension: Floats
    """Tension of each bolt after tightening [N]."""
    sensor_names: tuple[str, ...]
    """Names of the sensors."""
    sensor_rows: Floats
    """Displacement at each sensor per degree of freedom [-], (sensors, degrees of freedom)."""
    samples: Samples
    """Sample points of the patches."""
    surface: Surface
    """Surface of the bodies, for figures."""
    full_size: int
    """Degrees of freedom before the reduction."""
    left_out: float
    """Fraction of the faces without an opposite face [-]."""
    base_inertia: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    """Mass coupling [kg] of the degrees of freedom with unit ground motions along x, y and z,
    (size + 3, 3); the last three rows are the mass of the rigid motion. Empty without ground."""
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
        """Directions of the patches for :meth:`Structure.attach`, (size, patches, 3)."""
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
        """Contact [-] and bounds [m] of each patch, (patches, 5); valid as argument ``patches``."""
        return np.column_stack([self.patch_contacts, self.patch_boxes])

    @property
    def _bolts(self) -> slice:
        start = 3 * self.patches
        return slice(start, start + len(self.bolt_stiffness))

    def sensor(self, name: str, base: bool = False) -> Floats:
        """Return the direction b of a sensor: its displacement is b^T x [m].

        Parameters
        ----------
        name : str
            One of :attr:`sensor_names`.
        base : bool
            Whether x includes the three displacements of the ground, see :meth:`on_base`.

        Returns
        -------
        ndarray
            Vector b [-], one entry for each degree of freedom. A force F at the sensor in its
            direction acts on the degrees of freedom as F b.
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
            Gap between the unloaded faces: a function of arrays x and y [m], along and across as
            in :attr:`patch_centres`, that returns gaps [m]; a table with the columns x, y and gap
            [m], NaN where unknown, for example from scans of both faces; or one gap [m] for each
            patch, of the shape (patches,).
        factor : float
            Factor on all gaps [-], such as 0 for flat faces or -1 for the reversed form.

        Returns
        -------
        ReducedJoint
            New joint. A gap common to all patches has no effect and is removed.

        Notes
        -----
        The gap of a patch is the mean over its sample points.
        """
        factor = number("factor", factor)
        if not callable(form):
            form = floats("form", form, missing=True)
        if callable(form) or form.ndim != 1:
            gaps = mean_over(self.samples, gaps_at(form, self.samples.places), self.patches)
        elif form.shape == (self.patches,):
            gaps = form
        else:
            raise InputError(
                f"form must have one gap for each of the {self.patches} patches, got shape "
                f"{form.shape}"
            )
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
            New joint with these tensions.
        """
        bolts = len(self.bolt_stiffness)
        return replace(self, bolt_tension=each_bolt("tension", tension, bolts, "N"))

    def field(
        self, surface: NormalLaw, friction_coefficient: ArrayLike, surface_area: float | None = None
    ) -> JointField:
        """Return the field of patches with gaps [m], shape (patches,); see :class:`JointField`."""
        return JointField(
            surface, friction_coefficient, areas=self.patch_areas, gaps=self.patch_gaps,
            surface_area=surface_area,
        )  # fmt: skip

    def with_geometry(
        self, sensors: Iterable[str], cases: Any, weights: ArrayLike | None = None
    ) -> ReducedJoint:
        """Return the joint with a stiffness that depends on the bending of its thin parts.

        Parameters
        ----------
        sensors : iterable of str
            Names of sensors. Their displacements, or the sums of them by ``weights``, are the
            coordinates z of :meth:`Structure.with_geometry`, at most six.
        cases : (array_like, array_like)
            Static cases: coordinates z relative to the tightened state [m] and the forces that
            hold them [N], each of the shape (cases, coordinates), with all other displacements
            free.
        weights : array_like, optional
            Weight of each sensor in each coordinate [-], of the shape (sensors, coordinates). By
            default each sensor is a coordinate.

        Returns
        -------
        ReducedJoint
            New joint, which :meth:`save` rejects because it has a geometry.
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
            As for :meth:`tightened`, one number or of shape (patches,).
        damping_ratio : float
            Damping ratio of each mode without the joints [-]; its dashpots move with the ground.

        Returns
        -------
        Preload
            Static state. Its methods ``base_response``, ``random_response`` and ``shock`` need
            the arguments ``**joint.base("z")``.
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
            padded = change_rows(joints, lambda x: np.pad(x, [(0, 3)] + [(0, 0)] * (x.ndim - 1)))
            shaken = shaken.with_attachment(padded)
        return shaken.preload(np.pad(state.static_force, (0, 3)))

    def base(self, direction: str) -> dict[str, Any]:
        """Return the arguments of ``base_response``, ``random_response`` and ``shock``.

        Parameters
        ----------
        direction : {"x", "y", "z"}
            Axis of the mesh along which the ground moves.

        Returns
        -------
        dict
            Keyword arguments ``supports`` and ``directions``.
        """
        if not len(self.base_inertia):
            raise InputError("the structure has no base: give its mesh a ground")
        if direction not in ("x", "y", "z"):
            raise InputError(f'direction must be "x", "y" or "z", got {show(direction)}')
        way = np.array([float(axis == direction) for axis in "xyz"])
        return {"supports": list(range(self.size, self.size + 3)), "directions": way}

    def _pulled(self, surface: NormalLaw, law: NormalLaw, start: Any) -> tuple[Preload, Floats]:
        """Return the static state with bolt tensions as constant forces, and the static force.

        The force [N] is zero except for the elongations e of the bolts, where it is k_b e - F, with
        the bolt stiffness k_b and the tension F: with it each bolt has its tension in equilibrium.
        ``law`` is the normal law of the contact: ``surface`` or its law of first loading; ``start``
        are displacements near the state [m].
        """
        pull = np.zeros(self.size)
        pull[self._bolts] = -self.bolt_tension
        index = np.arange(self.size)[self._bolts]
        loose = self.stiffness.copy()
        loose[index, index] -= self.bolt_stiffness
        field = self.field(law, 1.0, None if law is surface else getattr(surface, "area", None))
        structure = Structure(self.mass, loose).attach(field, directions=self.directions)
        state = structure._preload(pull, start)
        pull[self._bolts] += self.bolt_stiffness * state.displacement[self._bolts]
        return state, pull

    @single_threaded
    def tightened(self, surface: NormalLaw, friction_coefficient: ArrayLike) -> Preload:
        """Return the joint with its contact and its bolts tightened.

        Parameters
        ----------
        surface : NormalLaw
            The normal load law of the surface.
        friction_coefficient : array_like
            Coulomb's coefficient [-], one number or of shape (patches,).

        Returns
        -------
        Preload
            The static state, with its pressures, ``modes``, ``forced_response`` and ``integrate``.
            Its ``static_force`` are the forces of the bolts, excluding their elastic forces.

        Notes
        -----
        The state is found first with each bolt replaced by its tension alone, without its axial
        stiffness.

        If the surface yields, pressures follow its curve of first loading, and each patch is taken
        to be tightened by its own pressure. The tangential stiffness of a patch is then
        proportional to that pressure, and all patches begin to slide at nearly the same
        displacement. For a surface described by roughness values the law is computed up to the
        largest pressure of any patch; the table of a measured surface must extend to this pressure.
        """
        start = None
        for _ in range(_TIGHTENINGS):
            loosely, force = self._pulled(surface, surface._first, start)
            start = loosely.displacement
            field = self.field(surface, friction_coefficient)
            largest = float(loosely.pressures.max()) * field.surface_area
            if surface._under(largest) is surface:
                break
            surface = surface._under(_ABOVE * largest)
        surface._check_rest(np.array([largest]))
        if surface._first is not surface:
            field = field._tightened_at(loosely.gaps, loosely.normal_loads)
        structure = Structure(self.mass, self.stiffness).attach(field, directions=self.directions)
        state = structure._preload(force, start)
        structure._check_rest(state)
        if self.geometry is None:
            return state
        bending = replace(self.geometry, rest=state.displacement)  # the cases are of what is tight
        return structure.with_attachment(bending).preload(force)

    def tensions(self, displacement: ArrayLike, static_force: ArrayLike) -> Floats:
        """Return the tensions of the bolts in a static state [N].

        Parameters
        ----------
        displacement, static_force : array_like
            Static displacements [m] and applied forces [N], both of shape (degrees of freedom,).

        Returns
        -------
        ndarray
            Tensions [N], one per bolt.
        """
        moved = vector("displacement", displacement, self.size)[self._bolts]
        pushed = vector("static_force", static_force, self.size)[self._bolts]
        return self.bolt_stiffness * moved - pushed

    def scaled(self, stiffness: float = 1.0, mass: float = 1.0) -> ReducedJoint:
        """Return the joint with stiffness and mass multiplied by factors.

        Parameters
        ----------
        stiffness : float
            Factor on the stiffness of all bodies [-].
        mass : float
            Factor on their mass [-].

        Returns
        -------
        ReducedJoint
            New joint, equal to a reduction of the mesh with the scaled materials (Craig and
            Bampton 1968, DOI 10.2514/3.4741).
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
        values = {f.name: getattr(self, f.name) for f in fields(self) if f.name != "geometry"}
        with atomic_file(file, overwrite) as stage, stage.open("wb") as stream:
            np.savez_compressed(stream, **arrays_of(values))

    @classmethod
    def load(cls, path: str | os.PathLike[str], *, limit: int = POINTS) -> ReducedJoint:
        """Read a model written by :meth:`save`.

        Parameters
        ----------
        path : str or path
            The file.
        limit : int, optional
            Largest permitted count of numbers in the file.

        Returns
        -------
        ReducedJoint
            Joint with the saved arrays.
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
