"""Craig and Bampton's reduction; means over patches and bolts replace boundary displacements."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np

from microslip._core.checks import Floats, floats, positive, show, whole_number
from microslip._core.errors import InputError
from microslip._core.threads import single_threaded
from microslip.structures.matrices import factorised
from microslip.structures.mesh import JointMesh, check_count, facets_of, outer
from microslip.structures.reduction_elements import Elements
from microslip.structures.reduction_model import ReducedJoint
from microslip.structures.reduction_patches import Surface, merging, patches_of

_COLUMNS = 32  # forces at once, and
_ROWS = 4096  # rows at once: bounds on memory
_INDEPENDENT = 1e-9  # of the largest compliance, both scaled
_DIRECTIONS = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


class ElasticBody:
    """Static response of the meshed bodies to forces, without rigid motion if not grounded."""

    def __init__(self, elements: Elements, masses: Any) -> None:
        from scipy import linalg

        self.stiffness, mass = elements.matrices()
        self.mass = mass + masses if masses is not None else mass
        self._free = np.ones(elements.size, dtype=bool)
        self._free[elements.grounded] = False
        self.rigid: Floats = elements.rigid_motion[:, : 0 if elements.grounded.size else 6]
        self._heavy = self.mass @ self.rigid
        self._inertia = self.rigid.T @ self._heavy
        if self.rigid.size:
            # Six displacements that hold the body and no more: the best of them by pivoting.
            _, _, order = linalg.qr(self.rigid.T, mode="economic", pivoting=True)
            self._free[order[:6]] = False
        self._factors = factorised(self.stiffness[self._free][:, self._free], 0.0)

    def solve(self, forces: Any) -> Floats:
        """Return displacements under forces (columns), both without their rigid part."""
        result = np.zeros(forces.shape)
        for start in range(0, forces.shape[1], _COLUMNS):
            part = forces[:, start : start + _COLUMNS]
            part = part if isinstance(part, np.ndarray) else part.toarray()
            part = part - self._heavy @ np.linalg.solve(self._inertia, self.rigid.T @ part)
            moved = np.zeros(part.shape)
            moved[self._free] = self._factors.solve(part[self._free])
            moved -= self.rigid @ np.linalg.solve(self._inertia, self._heavy.T @ moved)
            result[:, start : start + _COLUMNS] = moved
        return result


class Reducer:
    """Meshed joint with added masses, factorised once for any patches."""

    @single_threaded
    def __init__(
        self, mesh: JointMesh, masses: Mapping[Any, float] | None, along: Floats | None
    ) -> None:
        # A node of tetrahedra belongs to five times as many of them.
        count = len(mesh.cells) // (5 if mesh.kind == "tetra" else 1)
        check_count(count, np.ptp(mesh.points, axis=0))
        _check_joined(mesh)
        self.mesh, self.along = mesh, along
        self.elements = Elements(mesh)
        self.shanks = [_axial(mesh, self.elements, shank) for shank in mesh.shanks]
        self._masses = _point_masses(self.elements, masses)

    @cached_property
    def body(self) -> ElasticBody:
        """Bodies with their factorised stiffness, computed at the first access."""
        return ElasticBody(self.elements, self._masses)

    def check_sensors(self, sensors: Mapping[str, Any] | None) -> None:
        """Raise InputError for sensors outside the bodies, before the model is solved."""
        _sensors(self.elements, sensors)

    @single_threaded
    def reduce(
        self,
        *,
        tension: Any,
        patches: Any,
        kept_modes: int = 14,
        sensors: Mapping[str, Any] | None = None,
    ) -> ReducedJoint:
        """Reduce the joint to its patches, its bolts and a few modes."""
        from scipy import sparse

        kept_modes = whole_number("kept_modes", kept_modes, 1, 1000)
        elements = self.elements
        patched = patches_of(self.mesh, elements, patches, self.along)
        names, sensing = _sensors(elements, sensors)
        body = self.body  # last, for it takes longest
        bolts = len(self.shanks)
        elongations = [sparse.csr_matrix(elongation) for elongation, _ in self.shanks]
        functionals = sparse.vstack([patched.functionals, *elongations]).tocsr()
        static = body.solve(functionals.T.tocsc())
        compliance = functionals @ static
        while (boundary := _inverse(compliance)) is None:  # patches finer than the elements
            patched, turn = merging(patched, _dependence(compliance, len(patched.areas)))
            every = sparse.block_diag(
                [sparse.kron(turn, sparse.identity(3)), sparse.identity(bolts)]
            )
            functionals, static = (every @ functionals).tocsr(), (every @ static.T).T
            compliance = every @ (every @ compliance).T
        squares, modes = _fixed_modes(body, functionals, static, boundary, kept_modes)
        for start in range(0, len(static), _ROWS):  # in place: these are large
            static[start : start + _ROWS] = static[start : start + _ROWS] @ boundary
        shapes = (static, modes)
        stiffness = np.zeros((len(boundary) + len(squares),) * 2)
        stiffness[: len(boundary), : len(boundary)] = boundary
        inner = np.arange(len(boundary), len(stiffness))
        stiffness[inner, inner] = squares
        heavy = body.mass @ modes
        upper = [static.T @ (body.mass @ static), static.T @ heavy]
        mass = np.block([upper, [heavy.T @ static, modes.T @ heavy]])
        base: dict[str, Any] = {}
        if elements.grounded.size:  # what stands on ground may be shaken with it
            rigid = elements.rigid_motion[:, :3].copy()
            rigid[elements.grounded] = 0.0  # the ground's own inertia is not the structure's
            heavy = body.mass @ rigid
            inertia = [*(part.T @ heavy for part in shapes), rigid.T @ heavy]
            base = {
                "base_inertia": np.concatenate(inertia),
                "sensor_base": sensing @ elements.rigid_motion[:, :3],
            }
        return ReducedJoint(
            **base,
            mass=0.5 * (mass + mass.T),
            stiffness=stiffness,
            patch_areas=patched.areas,
            patch_gaps=np.zeros(len(patched.areas)),
            patch_boxes=patched.boxes,
            patch_contacts=patched.contacts,
            bolt_stiffness=np.array([stiff for _, stiff in self.shanks]),
            bolt_tension=np.broadcast_to(floats("tension", tension, "N"), (bolts,)).copy(),
            sensor_names=names,
            sensor_rows=np.concatenate([sensing @ part for part in shapes], axis=1),
            samples=patched.samples,
            surface=_surface(self.mesh, elements, shapes),
            full_size=elements.size,
            left_out=patched.left_out,
        )


def _scaled_modes(compliance: Floats) -> tuple[Floats, Floats, Floats]:
    scale = 1.0 / np.sqrt(np.diag(compliance))
    scaled = compliance * scale * scale[:, None]
    values, vectors = np.linalg.eigh(0.5 * (scaled + scaled.T))
    return scale, values, vectors


def _inverse(compliance: Floats) -> Floats | None:
    """Return the stiffness of a compliance; None if displacements depend on each other."""
    scale, values, vectors = _scaled_modes(compliance)
    if values[0] < _INDEPENDENT * values[-1]:
        return None
    result: Floats = (vectors / values) @ vectors.T * scale * scale[:, None]
    return 0.5 * (result + result.T)


def _dependence(compliance: Floats, patches: int) -> Floats:
    """Return the squared participation of each patch in dependent displacements [-].

    Displacements of patches depend on each other in the eigenvectors of the compliance whose
    eigenvalues are nearly zero. Raise InputError if those of bolts do.
    """
    _, values, vectors = _scaled_modes(compliance)
    idle = vectors[: 3 * patches, values < _INDEPENDENT * values[-1]] ** 2
    if (idle.sum(axis=0) < 0.5).all():
        raise InputError(
            "bolts must stretch independently of each other; give each bolt a shank of cells that "
            "belong to no other bolt"
        )
    return np.asarray(idle.reshape(patches, -1).sum(axis=1))


def _check_joined(mesh: JointMesh) -> None:
    from scipy import sparse
    from scipy.sparse.csgraph import connected_components

    width = mesh.cells.shape[1]
    rows = np.repeat(np.arange(len(mesh.cells)), width)
    graph = sparse.coo_matrix(
        (np.ones(rows.size), (rows, mesh.cells.ravel())), (len(mesh.cells), len(mesh.points))
    ).tocsr()
    parts, label = connected_components(graph @ graph.T, directed=False)
    if parts > 1:
        first = label[mesh.bodies[0].cells[0]]
        loose = [body.name for body in mesh.bodies if (label[body.cells] != first).any()]
        raise InputError(
            f"all bodies must be joined by corners that they share, got {parts} separate parts: "
            f"not connected to {mesh.bodies[0].name}: {', '.join(loose) or 'a part of it'}"
        )


def _axial(mesh: JointMesh, elements: Elements, shank: Any) -> tuple[Floats, float]:
    """Return the elongation of a shank, as a functional of displacements, and its stiffness [N/m].

    The elongation is the mean axial stress of the finite elements times the cross-section, divided
    by the stiffness of the shank under uniaxial strain.
    """
    owner = next(b for b in mesh.bodies if np.isin(shank.cells[:1], b.cells).all())
    heights = mesh.points[mesh.cells[shank.cells]] @ shank.axis
    length = float(np.ptp(heights))
    force = elements.axial_force(shank.cells, owner.material, shank.axis, length)
    modulus = owner.material
    shear, ratio = modulus.shear_modulus, modulus.poisson_ratio
    constrained_modulus = 2.0 * shear * (1.0 - ratio) / (1.0 - 2.0 * ratio)
    stiff = constrained_modulus * elements.volume(shank.cells) / length**2
    return force / stiff, stiff


def _fixed_modes(
    body: ElasticBody, functionals: Any, answers: Floats, boundary: Floats, count: int
) -> tuple[Floats, Floats]:
    """Return squared angular frequencies and shapes of modes with fixed patches and bolts.

    ``functionals`` give the displacements of patches and bolts, ``answers`` are the static
    responses to unit forces on them, and ``boundary`` is the stiffness matrix of these
    displacements, the inverse of their compliance matrix.
    """
    from scipy.sparse.linalg import LinearOperator, eigsh

    size = len(answers)

    def answer(force: Floats) -> Floats:
        free = body.solve(force.reshape(-1, 1))
        return np.asarray(free - answers @ (boundary @ (functionals @ free)))

    inverse = LinearOperator((size, size), matvec=answer, dtype=float)
    start = answer(np.random.default_rng(0).standard_normal(size))
    squares, modes = eigsh(
        body.stiffness, count, body.mass, sigma=0.0, OPinv=inverse, v0=start.ravel()
    )
    return squares, modes


def _place(raw_place: Any, label: str) -> Floats:
    place = floats(label, raw_place)
    if place.shape != (3,):
        raise InputError(f"{label} must be a position (x, y, z) [m], got {show(raw_place)}")
    return place


def _point_rows(elements: Elements, place: Floats, label: str) -> Any:
    every = np.arange(len(elements.mesh.cells))
    point = elements.locate(place[None], every, nearest=24)
    extent = float(np.ptp(elements.mesh.points, axis=0).max())
    if point.distances[0] > 1e-3 * extent:
        raise InputError(
            f"{label} must lie on the bodies, got {tuple(map(float, place))}, "
            f"{float(point.distances[0]):.3g} m away from them"
        )
    return elements.rows(point, np.ones(1), np.zeros(1, dtype=np.int64), 1)


def _point_masses(elements: Elements, masses: Mapping[Any, float] | None) -> Any:
    parts = []
    for place, value in (masses or {}).items():
        rows = _point_rows(elements, _place(place, "an added mass"), "an added mass")
        parts.append(positive("an added mass", value, "kg", 0.01) * (rows.T @ rows))
    return sum(parts[1:], parts[0]).tocsc() if parts else None


def _sensors(elements: Elements, sensors: Mapping[str, Any] | None) -> tuple[tuple[str, ...], Any]:
    from scipy import sparse

    names, rows = [], []
    for name, position in (sensors or {}).items():
        label = f'sensor "{name}"'
        try:
            place, direction = position
        except (TypeError, ValueError):
            raise InputError(
                f'{label} must be a position and a direction, such as ((0.36, 0, 0), "z"), '
                f"got {show(position)}"
            ) from None
        if isinstance(direction, str):
            if direction not in _DIRECTIONS:
                raise InputError(
                    f'the direction of {label} must be "x", "y", "z" or three numbers, got '
                    f"{show(direction)}"
                )
            direction = _DIRECTIONS[direction]
        way = _place(direction, f"the direction of {label}")
        length = math.sqrt(float(way @ way))
        if length == 0.0:
            raise InputError(f"the direction of {label} must not be zero")
        point = _point_rows(elements, _place(place, label), label)
        rows.append(sparse.csr_matrix(way / length) @ point)
        names.append(str(name))
    return tuple(names), sparse.vstack([sparse.csr_matrix((0, elements.size)), *rows]).tocsr()


def _surface(mesh: JointMesh, elements: Elements, shapes: tuple[Floats, Floats]) -> Surface:
    outside = outer(facets_of(mesh.cells, mesh.kind))
    corners, inverse = np.unique(outside, return_inverse=True)
    index = elements.corner_dofs(corners)
    motion = np.concatenate([part.reshape(-1, 3, part.shape[1])[index] for part in shapes], axis=2)
    return Surface(
        mesh.points[corners].astype(np.float32),
        inverse.reshape(outside.shape).astype(np.int32),
        motion.astype(np.float32),
    )
