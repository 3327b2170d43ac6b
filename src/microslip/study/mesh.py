"""A user's own mesh of a bolted structure: its file, and the names of its parts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from microslip._core.units import LENGTH, factor_of
from microslip._core.wording import show
from microslip.errors import InputError
from microslip.materials import Material
from microslip.study.fields import COLUMN_UNIT, LINE, MASS_DENSITY, number, text
from microslip.study.metals import unknown
from microslip.study.part import Part, key
from microslip.study.readers import Items, KeyedError, Place

if TYPE_CHECKING:
    from microslip.structures import MeshedJoint

_MOST_ITEMS = 200
_STAND_IN = Material(1.0, 0.0)  # stands for a body's own, which other tables of the study describe


def _names(example: str, distinct: bool = True) -> Items:
    return Items(LINE, example, (1, _MOST_ITEMS), distinct=distinct)


class MeshPart(Part):
    """A mesh in place of a drawing: hexahedra or tetrahedra with named bodies, faces and bolts."""

    file: str = key(
        text("the name of a mesh", "beam.msh"),
        "File that meshio reads, such as Gmsh's .msh with physical groups or Abaqus' "
        ".inp with sets; relative to the folder of the study.",
    )
    unit: str = key(COLUMN_UNIT, "Unit of length of the mesh.", '"mm"', default="m")
    bodies: tuple[str, ...] = key(
        _names('["left", "right", "bolts"]'),
        "Names of the volumes; together they hold all cells. Those that share nodes are joined.",
    )
    contacts: tuple[tuple[str, str], ...] = key(
        Items(
            Items(LINE, '["left face", "right face"]', (2, 2)),
            '[["left face", "right face"]]',
            (1, 20),
        ),
        "Names of the two faces of each contact, the lower first: surfaces, or sets "
        "of nodes. Their meshes need not match.",
    )
    bolts: tuple[str, ...] = key(
        _names('["shank 1", "shank 2"]'),
        "Names of the volumes of the shanks, each a body or a part of one.",
    )
    ground: tuple[str, ...] = key(
        _names('["foot"]'), "Names of volumes or faces that do not move.", default=()
    )
    materials: tuple[str, ...] | None = key(
        _names('["steel", "steel", "titanium"]', distinct=False),
        "Material of each body; the first of the surface unless given.",
        default=None,
    )
    densities: tuple[float, ...] | None = key(
        Items(MASS_DENSITY, '["7850 kg/m^3", "7850 kg/m^3", "4430 kg/m^3"]', (1, _MOST_ITEMS)),
        "Mass density of each body; `structure.density` unless given.",
        default=None,
    )
    along: tuple[float, float, float] | None = key(
        Items(number("1.0"), "[1, 0, 0]", (3, 3)),
        "Direction along the contacts; that in which they are longest unless "
        "given, and places in them then count from their middle.",
        default=None,
    )
    _joint: MeshedJoint

    def check(self, place: Place) -> None:
        """Read the mesh, and find what the study names in it."""
        from microslip.structures import MeshedJoint
        from microslip.structures.reduction_patches import contact_frame

        for name in ("materials", "densities"):
            values = getattr(self, name)
            if values is not None and len(values) != len(self.bodies):
                raise KeyedError(
                    f".{name}",
                    f"wanted one a body, {len(self.bodies)} of them, got {len(values)}",
                )
        refusal = f'wanted a unit such as "mm", got {show(self.unit)}'
        try:
            scale = factor_of(self.unit, LENGTH, refusal)
        except ValueError as error:
            raise KeyedError(".unit", str(error)) from None
        try:
            self._joint = MeshedJoint.read(
                place.reading.path(self.file),
                bodies=dict.fromkeys(self.bodies, (_STAND_IN, 1.0)),
                contacts=self.contacts,
                bolts=dict.fromkeys(self.bolts, 1.0),
                ground=self.ground,
                scale=float(scale),
            )
        except InputError as error:
            message = str(error).replace("write scale=1e-3", 'write unit = "mm"')
            raise ValueError(message) from None
        along = None if self.along is None else np.array(self.along)
        for contact in self._joint.mesh.contacts:
            try:
                contact_frame(self._joint.mesh, contact, along)
            except InputError as error:
                key = place.key if along is None else ".along"
                raise KeyedError(key, str(error)) from None
        place.reading.notes.append(
            f"{place.key}: {len(self._joint.mesh.cells)} {self._joint.mesh.kind} cells "
            f"from {self.file}."
        )

    @property
    def joint(self) -> MeshedJoint:
        """The mesh as it was read; its materials and tensions are still to come."""
        return self._joint

    def check_materials(self, materials: Mapping[str, Any]) -> None:
        """See that the study describes what the bodies are made of."""
        for item, name in enumerate(self.materials or (), start=1):
            if name not in materials:
                raise KeyedError(f"structure.mesh.materials, item {item}", unknown(name, materials))

    def build(
        self, materials: Mapping[str, Material], usual: str, density: float | None
    ) -> MeshedJoint:
        """The joint, its bodies of what the study says."""
        from microslip.structures.mesh import check_elastic

        names = self.materials or (usual,) * len(self.bodies)
        densities = self.densities or (cast(float, density),) * len(self.bodies)
        for name in names:
            check_elastic(materials[name])
        bodies = tuple(
            body._replace(material=materials[name], density=heavy)
            for body, name, heavy in zip(self.joint.mesh.bodies, names, densities, strict=True)
        )
        return replace(self.joint, mesh=replace(self.joint.mesh, bodies=bodies))
