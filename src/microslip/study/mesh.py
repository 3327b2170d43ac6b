"""Floor 10: a user's own mesh of a bolted structure: its file, and the names of its parts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, Self, cast

import numpy as np
from pydantic import AfterValidator, PrivateAttr, ValidationInfo, model_validator

from microslip._core.checks import Floats
from microslip._core.units import LENGTH, MASS_DENSITY, factor_of
from microslip._core.wording import show
from microslip.errors import InputError
from microslip.materials import Material
from microslip.study.columns import UnitName, text
from microslip.study.fields import Line, array, different, number, quantity
from microslip.study.metals import unknown
from microslip.study.part import KeyedError, Part, Reading, optional, required

if TYPE_CHECKING:
    from microslip.structures import MeshedJoint

KEY = "structure.mesh"
_MOST_ITEMS = 200
_STAND_IN = Material(1.0, 0.0)  # stands for a body's own, which other tables of the study describe

MeshName = Annotated[str, text('the name of a mesh such as "beam.msh"')]
Names = Annotated[
    tuple[Line, ...], array('["left", "right"]', _MOST_ITEMS), AfterValidator(different)
]
Pair = Annotated[tuple[Line, Line], array('["left face", "right face"]', 2, min_items=2)]
Coordinate = Annotated[float, number("a finite number such as 1.0")]


class MeshPart(Part):
    """A mesh in place of a drawing: hexahedra or tetrahedra with named bodies, faces and bolts."""

    file: MeshName = required(
        "File that meshio reads, such as Gmsh's .msh with physical groups or Abaqus' "
        ".inp with sets; relative to the folder of the study.",
        '"beam.msh"',
    )
    unit: UnitName = optional("Unit of length of the mesh.", '"mm"', default="m")
    bodies: Names = required(
        "Names of the volumes; together they hold all cells. Those that share nodes are joined.",
        '["left", "right", "bolts"]',
    )
    contacts: Annotated[tuple[Pair, ...], array('[["left face", "right face"]]', 20)] = required(
        "Names of the two faces of each contact, the lower first: surfaces, or sets "
        "of nodes. Their meshes need not match.",
        '[["left face", "right face"]]',
    )
    bolts: Names = required(
        "Names of the volumes of the shanks, each a body or a part of one.",
        '["shank 1", "shank 2"]',
    )
    materials: Annotated[tuple[Line, ...], array('["steel", "aluminium"]', _MOST_ITEMS)] | None = (
        optional(
            "Material of each body; the first of the surface unless given.",
            '["steel", "steel", "titanium"]',
        )
    )
    densities: (
        Annotated[
            tuple[Annotated[float, quantity(MASS_DENSITY, "7850 kg/m^3")], ...],
            array('["7850 kg/m^3", "2700 kg/m^3"]', _MOST_ITEMS),
        ]
        | None
    ) = optional(
        "Mass density of each body; `structure.density` unless given.",
        '["7850 kg/m^3", "7850 kg/m^3", "4430 kg/m^3"]',
    )
    along: (
        Annotated[tuple[Coordinate, Coordinate, Coordinate], array("[1, 0, 0]", 3, min_items=3)]
        | None
    ) = optional(
        "Direction along the contacts; that in which they are longest unless "
        "given, and places in them then count from their middle.",
        "[1, 0, 0]",
    )
    _joint: MeshedJoint = PrivateAttr()

    @model_validator(mode="after")
    def _read(self, info: ValidationInfo) -> Self:
        from microslip.structures import MeshedJoint
        from microslip.structures.reduction_patches import contact_frame

        for name in ("materials", "densities"):
            values = getattr(self, name)
            if values is not None and len(values) != len(self.bodies):
                raise KeyedError(
                    f"{KEY}.{name}",
                    f"wanted one a body, {len(self.bodies)} of them, got {len(values)}",
                )
        refusal = f'wanted a unit such as "mm", got {show(self.unit)}'
        reading = Reading.of(info)
        try:
            scale = factor_of(self.unit, LENGTH, refusal)
        except ValueError as error:
            raise KeyedError(f"{KEY}.unit", str(error)) from None
        try:
            self._joint = MeshedJoint.read(
                reading.path(self.file),
                bodies=dict.fromkeys(self.bodies, (_STAND_IN, 1.0)),
                contacts=self.contacts,
                bolts=dict.fromkeys(self.bolts, 1.0),
                scale=float(scale),
            )
        except InputError as error:
            message = str(error).replace("write scale=1e-3", 'write unit = "mm"')
            raise KeyedError(KEY, message) from None
        along = None if self.along is None else np.array(self.along)
        for contact in self._joint.mesh.contacts:
            try:
                contact_frame(self._joint.mesh, contact, along)
            except InputError as error:
                raise KeyedError(KEY if along is None else f"{KEY}.along", str(error)) from None
        reading.notes.append(
            f"{KEY}: {len(self._joint.mesh.cells)} {self._joint.mesh.kind} cells from {self.file}."
        )
        return self

    @property
    def joint(self) -> MeshedJoint:
        """The mesh as it was read; its materials and tensions are still to come."""
        return self._joint

    def check_materials(self, materials: Mapping[str, Any]) -> None:
        """See that the study describes what the bodies are made of."""
        for item, name in enumerate(self.materials or (), start=1):
            if name not in materials:
                raise KeyedError(f"{KEY}.materials, item {item}", unknown(name, materials))

    def build(
        self, materials: Mapping[str, Material], usual: str, density: float | None, tension: Floats
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
        return replace(
            self.joint,
            mesh=replace(self.joint.mesh, bodies=bodies),
            tension=tuple(float(value) for value in tension),
        )
