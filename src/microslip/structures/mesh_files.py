"""A bolted joint from a user's own mesh, with named bodies, contact faces and bolts."""

from __future__ import annotations

import io
import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, floats, positive, show
from microslip._core.errors import InputError
from microslip._core.frozen import Locked
from microslip._core.packages import needed_for
from microslip._core.wording import did_you_mean, plural, quoted, shorten
from microslip.contact.materials import Material
from microslip.readers.child import parsed
from microslip.readers.files import POINTS, first_line, reading, refuse_beyond
from microslip.structures.mesh import (
    Body,
    ContactFaces,
    Indices,
    JointMesh,
    Shank,
    check_elastic,
    facets_of,
    outer,
)

if TYPE_CHECKING:
    from microslip.structures.reduction_model import ReducedJoint

_KINDS = {
    "hexahedron": ("hexahedron", 8), "hexahedron20": ("hexahedron", 8),
    "hexahedron27": ("hexahedron", 8), "tetra": ("tetra", 4), "tetra10": ("tetra", 4),
    "quad": ("quad", 4), "quad8": ("quad", 4), "quad9": ("quad", 4),
    "triangle": ("triangle", 3), "triangle6": ("triangle", 3),
}  # fmt: skip
"""Kind without midside nodes, and number of corners, of meshio's cells and facets."""
Cells = dict[str, Indices]
"""Corners of cells, or numbers of cells, by kind."""
_TAGS = "gmsh:physical"
_NASTRAN = (".bdf", ".nas", ".fem")
_MOST_GROUPS = 1000  # of one array of cell data; more are results, not groups
_BYTES_A_SECOND = 2e5  # of meshio, which reads text in Python
_LARGEST = 100.0  # metres, beyond which a mesh is taken to be in millimetres


@dataclass(frozen=True, eq=False)
class MeshedJoint(Locked):
    """Bolted structure with a mesh from a file, created by :meth:`read`."""

    mesh: JointMesh
    """Bodies, contact faces and shanks."""
    tension: tuple[float, ...]
    """Tension of each bolt [N]."""

    @classmethod
    def read(
        cls,
        path: str | os.PathLike[str],
        *,
        bodies: Mapping[str, tuple[Material, float]],
        contacts: Iterable[tuple[str, str]],
        bolts: Mapping[str, float],
        ground: Iterable[str] = (),
        scale: float = 1.0,
        limit: int = POINTS,
    ) -> MeshedJoint:
        """Read a mesh of hexahedra or of tetrahedra by meshio.

        Parameters
        ----------
        path : str or path
            Any file with groups that meshio reads: Gmsh's ``.msh`` with physical groups,
            Abaqus' or CalculiX' ``.inp`` with sets, Salome's ``.med`` with groups. Formats that
            number their groups, such as Nastran's ``.bdf`` by properties and VTK's ``.vtu`` by
            integer cell data, give names such as ``"nastran:ref 3"``.
        bodies : mapping
            Material and density [kg/m^3] of each named volume. Bodies that touch are joined where
            they share nodes, and only there: so heads are joined to plates, and the two sides of a
            contact are not.
        contacts : iterable of pairs
            Names of the two faces of each contact, the lower first: named surfaces, or sets of
            nodes. Their meshes need not match.
        bolts : mapping
            Tension [N] by the name of the volume of each shank, which is a body or a part of one.
            Its axis is normal to the nearest contact.
        ground : iterable of str, optional
            Names of volumes or faces that do not move.
        scale : float
            Metres per unit of the file, such as 1e-3 for millimetres.
        limit : int, optional
            Largest permitted count of numbers in the file.

        Returns
        -------
        MeshedJoint
            Joint that :meth:`reduce` reduces to a small model.

        Notes
        -----
        Only corner nodes are used: cells with midside nodes become straight. Displacements are
        quadratic in all cells.
        """
        from microslip.structures.reduction_patches import contact_frame

        file = Path(path)
        bodies, contacts, bolts = dict(bodies), list(contacts), dict(bolts)
        scale = positive("scale", scale, "m", 1e-3)
        for role, names in (("bodies", bodies), ("contacts", contacts), ("bolts", bolts)):
            if not names:
                raise InputError(f"{role} must be named, got none")
        with reading(file, "a mesh", limit):
            content = parsed(
                "mesh", file, read_mesh, libraries=["meshio"], bytes_a_second=_BYTES_A_SECOND
            )
        named = _Names(file, content)
        kind, cells = named.kind, named.cells
        used, inverse = np.unique(cells, return_inverse=True)
        points = content["points"] * scale
        extent = float(np.ptp(points[used], axis=0).max())
        if extent > _LARGEST:
            raise InputError(
                f"{file.name}: reaches over {extent:.4g} m; if it is in millimetres, write "
                "scale=1e-3"
            )
        renamed = np.full(len(points), -1, dtype=np.int64)
        renamed[used] = np.arange(len(used))
        solids = inverse.reshape(cells.shape).astype(np.int64)
        parts, owner = [], np.full(len(cells), -1)
        for number, (name, properties) in enumerate(bodies.items()):
            try:
                material, density = properties
            except (TypeError, ValueError):
                raise InputError(
                    f'body "{name}" must have a material and a density [kg/m^3], such as (steel, '
                    f"7850.0), got {show(properties)}"
                ) from None
            check_elastic(material)
            members = named.volume(name)
            if (owner[members] >= 0).any():
                raise InputError(f'{file.name}: body "{name}" shares cells with another body')
            owner[members] = number
            density = positive(f'the density of body "{name}"', density, "kg/m^3", 7850.0)
            parts.append(Body(name, members, material, density))
        if (owner < 0).any():
            raise InputError(
                f"{file.name}: {int((owner < 0).sum())} of {len(owner)} cells belong to none "
                f"of the bodies {quoted(bodies, 'and')}; the file has {named.listed()}"
            )
        faces = []
        for pair in contacts:
            if isinstance(pair, str) or len(tuple(pair)) != 2:
                raise InputError(f"a contact must be two names of faces, got {show(pair)}")
            lower, upper = (renamed[named.face(name)] for name in pair)
            if np.intersect1d(lower, upper).size:
                raise InputError(
                    f"{file.name}: the faces {quoted(pair, 'and')} share nodes; a contact "
                    "needs its own nodes on each side"
                )
            faces.append(ContactFaces(f"{pair[0]} on {pair[1]}", lower, upper))
        corners = [renamed[named.nodes(name)].ravel() for name in ground]
        fixed = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *corners]))
        mesh = JointMesh(points[used], solids, kind, tuple(parts), tuple(faces), (), fixed)
        volumes = {name: named.volume(name) for name in bolts}
        shanks = []
        for name, members in volumes.items():
            nearest = _nearest(mesh, mesh.points[mesh.cells[members]].mean(axis=(0, 1)))
            axis = contact_frame(mesh, mesh.contacts[nearest], None).axes[2]
            shanks.append(Shank(name, members, axis))
        tension = tuple(
            positive(f'the tension of bolt "{name}"', value, "N", 12e3)
            for name, value in bolts.items()
        )
        return cls(replace(mesh, shanks=tuple(shanks)), tension)

    def __repr__(self) -> str:
        mesh = self.mesh
        bodies = quoted([body.name for body in mesh.bodies], "and")
        return (
            f"MeshedJoint({len(mesh.cells)} cells of {len(mesh.points)} nodes, bodies {bodies}, "
            f"{plural(len(mesh.contacts), 'contact')}, bolt tensions {self.tension} N)"
        )

    @property
    def face_area(self) -> float:
        """Area of the lower faces of its contacts [m^2]."""
        from microslip.structures.reduction_patches import sample

        points = self.mesh.points
        return float(sum(sample(points[c.lower])[1].sum() for c in self.mesh.contacts))

    def shank_sections(
        self, along: ArrayLike | None = None
    ) -> list[tuple[float, float, float, int]]:
        """Return the sections of the shanks through their contacts, for figures.

        Parameters
        ----------
        along : array_like, optional
            As for :meth:`reduce`, of shape (3,) [-].

        Returns
        -------
        list of tuple
            For each shank its position along and across the contact [m], the diameter of a circle
            with its mean cross-section [m], and the number of the contact.
        """
        from microslip.structures.reduction_elements import Elements
        from microslip.structures.reduction_patches import contact_frame

        direction = _direction(along)
        elements, sections = Elements(self.mesh), []
        for shank in self.mesh.shanks:
            corners = self.mesh.points[self.mesh.cells[shank.cells]]
            number = _nearest(self.mesh, corners.mean(axis=(0, 1)))
            frame = contact_frame(self.mesh, self.mesh.contacts[number], direction)
            x, y, _ = frame.axes @ (corners.mean(axis=(0, 1)) - frame.origin)
            section = elements.volume(shank.cells) / float(np.ptp(corners @ shank.axis))
            sections.append((float(x), float(y), float(np.sqrt(4.0 / np.pi * section)), number))
        return sections

    def reduce(
        self,
        patches: Any = None,
        *,
        kept_modes: int = 14,
        sensors: Mapping[str, Any] | None = None,
        masses: Mapping[Any, float] | None = None,
        along: ArrayLike | None = None,
    ) -> ReducedJoint:
        """Reduce the joint to a small linear model with contact patches.

        Parameters
        ----------
        patches, kept_modes, sensors, masses : optional
            As for :meth:`LapJoint.reduce`; patches are those of each contact.
        along : array_like, optional
            Direction x along the contacts [-], of shape (3,); by default that in which the faces
            are longest. Positions in ``patches`` are relative to the origin if ``along`` is given,
            otherwise to the middle of the faces.

        Returns
        -------
        ReducedJoint
            Mass, stiffness, patches, bolts and sensors; without the contact and without rigid
            motion.

        Notes
        -----
        Reduction of Craig and Bampton (1968), DOI 10.2514/3.4741, to mean displacements of patches.
        Each sample point of one face is compared with the opposite point of the other face, so that
        rigid-body motion deforms no patch even if the meshes of the faces do not match.
        """
        from microslip.structures.reduction import Reducer

        return Reducer(self.mesh, masses, _direction(along)).reduce(
            tension=self.tension,
            patches=patches,
            kept_modes=kept_modes,
            sensors=sensors,
        )


def _direction(along: ArrayLike | None) -> Floats | None:
    if along is None:
        return None
    direction = floats("along", along)
    if direction.shape != (3,):
        raise InputError(f"along must be three numbers, got {show(along)}")
    # Its length does not matter, and huge numbers cannot be squared.
    return np.asarray(direction / (np.abs(direction).max() or 1.0))


def _nearest(mesh: JointMesh, place: Floats) -> int:
    middles = (mesh.points[contact.lower].mean(axis=1) for contact in mesh.contacts)
    return int(np.argmin([np.linalg.norm(m - place, axis=1).min() for m in middles]))


def read_mesh(path: Path) -> dict[str, Any]:
    """Read a mesh by meshio in a child process; validate all node and cell numbers."""
    with needed_for("meshes are read by"):
        import meshio
    try:
        source = _as_meshio_reads(path)
        kind = {".inp": "abaqus"}.get(path.suffix.lower(), "nastran")
        mesh = meshio.read(source) if source is path else meshio.read(source, kind)
    except MemoryError:
        raise
    except (Exception, SystemExit) as error:  # meshio exits for suffixes that it does not know
        if path.suffix.lower() in (".msh", ".unv"):
            raise ValueError(
                f"convert it by: gmsh {path.name} -save -format msh22 -o new.msh; meshio does not "
                f"read it: {first_line(error)}"
            ) from None
        if isinstance(error, SystemExit):
            raise ValueError("of no format that meshio can read") from None
        raise
    points = np.asarray(mesh.points, dtype=float)
    if points.ndim != 2 or not len(points) or points.shape[1] != 3 or not np.isfinite(points).all():
        raise ValueError("its points are not three finite numbers each")
    refuse_beyond(points.size + sum(np.size(block.data) for block in mesh.cells))
    sizes = [len(block.data) for block in mesh.cells]
    numbers = [(block.data, len(points)) for block in mesh.cells]
    numbers += [(nodes, len(points)) for nodes in mesh.point_sets.values()]
    # Gmsh's own sets hold signed tags of entities, not numbers of cells.
    cell_sets = {n: blocks for n, blocks in mesh.cell_sets.items() if not n.startswith("gmsh:")}
    for blocks in cell_sets.values():
        pairs = zip(blocks, sizes, strict=True)
        numbers += [(block, size) for block, size in pairs if block is not None]
    for index, size in numbers:
        index = np.asarray(index)
        if index.size and (index.dtype.kind not in "iu" or index.min() < 0 or index.max() >= size):
            raise ValueError("names nodes or cells that it does not have")
    # Gmsh writes a block of cells for each part of the geometry. One for each kind is kept.
    known = [_KINDS.get(block.type, (block.type, None)) for block in mesh.cells]
    kinds = [kind for kind, _ in known]

    def by_kind(blocks: Any, numbers: bool = False) -> Cells:
        merged: dict[str, list[Any]] = {kind: [] for kind in kinds}
        start = dict.fromkeys(kinds, 0)
        for kind, size, block in zip(kinds, sizes, blocks, strict=True):
            block = np.zeros(0, dtype=int) if block is None else np.asarray(block)
            merged[kind].append(block + start[kind] if numbers else block)
            start[kind] += size
        return {kind: np.concatenate(parts) for kind, parts in merged.items()}

    data = {name: by_kind(blocks) for name, blocks in mesh.cell_data.items()}
    tags = getattr(mesh, "cell_tags", {})
    named = [("cell_tags", number, name) for number, names in tags.items() for name in names]
    if _TAGS in data:
        named += [(_TAGS, number, name) for name, (number, _) in mesh.field_data.items()]
    groups = _numbered_groups(data, named)
    groups |= {name: by_kind(blocks, numbers=True) for name, blocks in cell_sets.items()}
    return {
        "points": points,
        "cells": by_kind(
            [np.asarray(b.data)[:, :count] for b, (_, count) in zip(mesh.cells, known, strict=True)]
        ),
        "cell_sets": groups,
        "point_sets": {name: np.asarray(nodes) for name, nodes in mesh.point_sets.items()},
    }


def _as_meshio_reads(path: Path) -> io.StringIO | Path:
    """Return the text of a Nastran or Abaqus mesh, changed so that meshio reads it; else the path.

    The line ``BEGIN BULK`` is added to Nastran files of Gmsh, which omits it. Plane elements in
    Abaqus files, which Gmsh writes for faces of second order, are renamed to shells.
    """
    suffix = path.suffix.lower()
    if suffix not in (*_NASTRAN, ".inp"):
        return path
    text = path.read_text(encoding="latin-1")
    if suffix == ".inp":
        for plane, shell in (("CPS6", "STRI65"), ("CPS8", "S8R")):
            text = re.sub(rf"(?i)(\*ELEMENT,\s*TYPE\s*=\s*){plane}\b", rf"\g<1>{shell}", text)
    elif not re.search(r"(?im)^\s*BEGIN\s+BULK", text):
        text = f"BEGIN BULK\n{text}"
    return io.StringIO(text)


def _numbered_groups(
    cell_data: Mapping[str, Cells], named: Iterable[tuple[str, int, str]]
) -> dict[str, Cells]:
    """Return the cells of numbered groups by keys such as ``"nastran:ref 3"``, and by name.

    ``named`` holds the array, the number and the name of parts of each named group.
    """
    groups: dict[str, Cells] = {}
    for array, columns in cell_data.items():
        if any(c.ndim != 1 or c.dtype.kind not in "iu" for c in columns.values()):
            continue
        values = np.unique(np.concatenate(list(columns.values()))) if columns else np.zeros(0)
        if values.size <= _MOST_GROUPS:
            for value in values:
                groups[f"{array} {value}"] = {
                    kind: np.flatnonzero(column == value) for kind, column in columns.items()
                }
    for array, number, name in named:
        for kind, column in cell_data.get(array, {}).items():
            part = np.flatnonzero(column == number)
            group = groups.setdefault(name, {})
            group[kind] = np.union1d(group.get(kind, part), part)
    return groups


class _Names:
    """Cells of a mesh in a file, and those that have a name."""

    def __init__(self, path: Path, content: dict[str, Any]) -> None:
        self._path, self._all, self._points = path, content["cells"], content["points"]
        self._sets: dict[str, Cells] = content["cell_sets"]
        self._nodes = content["point_sets"]
        kinds = {"hexahedron", "tetra"} & self._all.keys()
        unsupported = {kind for kind in self._all if kind.startswith(("wedge", "pyramid"))}
        if len(kinds) != 1 or unsupported:
            listed = ", ".join(sorted(kinds | unsupported)) or "none"
            raise InputError(
                f"{path.name}: wanted hexahedra or tetrahedra, one kind of them, got {listed}"
            )
        (self.kind,) = kinds
        self.cells = np.asarray(self._all[self.kind], dtype=np.int64)
        if not self._sets:
            raise InputError(
                f"{path.name}: has no names; name its volumes and faces, as physical groups in "
                "Gmsh or as sets in Abaqus"
            )

    def listed(self) -> str:
        names = sorted({*self._sets, *self._nodes})
        return quoted(names[:12], "and") + (" and more" if len(names) > 12 else "")

    def _missing(self, name: str, role: str) -> InputError:
        names = {*self._sets, *self._nodes}
        return InputError(
            f'{self._path.name}: has no {role} "{shorten(str(name), 40)}"'
            f"{did_you_mean(str(name), names)}; it has {self.listed()}"
        )

    def volume(self, name: str) -> Indices:
        if name not in self._sets:
            raise self._missing(name, "volume")
        members = self._sets[name].get(self.kind, ())
        if not len(members):
            raise InputError(f'{self._path.name}: "{name}" holds no solid cells')
        return np.asarray(members, dtype=np.int64)

    def nodes(self, name: str) -> Indices:
        try:
            return self.cells[self.volume(name)]
        except InputError:
            return self.face(name)

    def face(self, name: str) -> Indices:
        if name in self._sets:
            members = self._sets[name]
            kinds = [kind for kind in ("quad", "triangle") if len(members.get(kind, ()))]
            if len(kinds) == 1:
                return np.asarray(self._all[kinds[0]][members[kinds[0]]], dtype=np.int64)
            if name not in self._nodes:
                raise InputError(f'{self._path.name}: "{name}" holds no facets of one kind')
        if name not in self._nodes:
            raise self._missing(name, "face")
        inside = np.zeros(len(self._points), dtype=bool)
        inside[self._nodes[name]] = True
        facets = facets_of(self.cells, self.kind)
        facets = facets[inside[facets].all(axis=1)]
        if not len(facets):
            raise InputError(f'{self._path.name}: no side of a cell has all its nodes in "{name}"')
        return np.asarray(outer(facets), dtype=np.int64)
