"""Bolts of a structure in a study, and its finite-element mesh."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from microslip._core import units
from microslip._core.errors import InputError
from microslip._core.wording import quote
from microslip.contact.materials import Material
from microslip.friction.pressure import BOLTS
from microslip.structures.bolts import SIZED, Bolts, by_size
from microslip.structures.mesh import check_elastic
from microslip.study.fields import (
    COLUMN_UNIT,
    LINE,
    PLACE,
    POSITIVE_DENSITY,
    POSITIVE_LENGTH,
    one_of,
    optional,
    scalar,
    text,
)
from microslip.study.part import Part, key, optional_key
from microslip.study.pressure import TightenedBolts
from microslip.study.readers import KeyedError, ListOf, Place
from microslip.study.uncertain import Uncertain

if TYPE_CHECKING:
    from microslip.structures import MeshedJoint


DRAWING_KEYS = ("length", "width", "thickness", "lap")


_PLACES = Uncertain(PLACE)


class BoltsPart(TightenedBolts):
    """Identical bolts through the overlap (lap) of two parts: positions, diameters, tension."""

    positions: tuple[float, ...] | None = optional_key(
        ListOf(_PLACES, '["-30 mm", "0 mm", "30 mm"]', (1, 200), single=True),
        "Positions along the lap, from its middle; not used with a mesh.",
    )
    across: tuple[float, ...] | None = optional_key(
        ListOf(_PLACES, '["-30 mm", "0 mm", "30 mm"]', (1, 200), single=True),
        "Positions across the lap, one per bolt; by default all in the middle.",
        '["0 mm", "0 mm", "0 mm"]',
    )
    shank: float | None = optional(Bolts, "shank")
    washer: float | None = optional(Bolts, "washer")
    head: float | None = optional(Bolts, "head")
    washer_thickness: float | None = optional(Bolts, "washer_thickness")
    mass: float | None = optional(Bolts, "mass")
    tension: float | None = optional(Bolts, "tension")
    thread: float | None = optional(Bolts, "thread")
    pitch: float | None = optional(Bolts, "pitch")
    size: str | None = optional_key(
        one_of(*BOLTS), "Size of the bolts, instead of diameters and pitch.", '"M8"'
    )
    clamp_length: float | None = optional_key(
        Uncertain(POSITIVE_LENGTH),
        "Thickness clamped by a bolt, for the loss by embedding; by default from the drawing.",
        '"25 mm"',
    )

    def check(self, place: Place) -> None:
        """Set the dimensions that follow from the bolt size; check the number of positions."""
        if self.size is not None:
            given = {name: getattr(self, name) for name in SIZED}
            self.__dict__.update(by_size(self.size, self.thread_friction, **given))
        super().check(place)
        along = self.positions or ()
        if self.across is not None and len(self.across) != len(along):
            raise KeyedError(
                ".across",
                f"wanted one position per bolt, {len(along)} in all, got {len(self.across)}",
            )

    def build(self) -> Bolts:
        """Return the bolts of a lap joint."""
        sizes: dict[str, Any] = {
            name: getattr(self, name)
            for name in self.keys
            if name in Bolts.__dataclass_fields__ and name != "positions"
        }
        along = self.positions or ()
        places = along if self.across is None else np.stack([along, self.across], axis=1)
        return Bolts(places, **{k: v for k, v in sizes.items() if v is not None})


_MOST_ITEMS = 200
_STAND_IN = Material(1.0, 0.0)  # placeholder until the materials of the study are assigned


def _names(example: str, distinct: bool = True) -> ListOf:
    return ListOf(LINE, example, (1, _MOST_ITEMS), distinct=distinct)


class MeshPart(Part):
    """Mesh of a structure with named bodies, faces and bolts, given instead of dimensions."""

    file: str = key(
        text("the name of a mesh", "beam.msh"),
        "File that meshio reads, such as Gmsh's .msh with physical groups or Abaqus' "
        ".inp with sets; relative to the folder of the study.",
    )
    unit: str = key(COLUMN_UNIT, "Unit of length of the mesh.", '"mm"', default="m")
    bodies: tuple[str, ...] = key(
        _names('["left", "right", "bolts"]'),
        "Names of the volumes, which together contain all cells; bodies with shared nodes are "
        "bonded.",
    )
    contacts: tuple[tuple[str, str], ...] = key(
        ListOf(
            ListOf(LINE, '["left face", "right face"]', (2, 2)),
            '[["left face", "right face"]]',
            (1, 20),
        ),
        "Names of the two faces of each contact, the lower first: surfaces, or sets "
        "of nodes. Their meshes need not match.",
    )
    bolts: tuple[str, ...] = key(
        _names('["shank 1", "shank 2"]'),
        "Names of the volumes of the bolt shanks, each a body or a part of one.",
    )
    ground: tuple[str, ...] = key(
        _names('["foot"]'), "Names of fixed volumes or faces.", default=()
    )
    materials: tuple[str, ...] | None = optional_key(
        _names('["steel", "steel", "titanium"]', distinct=False),
        "Material of each body; by default the first of surface.materials.",
    )
    densities: tuple[float, ...] | None = optional_key(
        ListOf(POSITIVE_DENSITY, '["7850 kg/m^3", "7850 kg/m^3", "4430 kg/m^3"]', (1, _MOST_ITEMS)),
        "Mass density of each body; by default `structure.density`.",
    )
    along: tuple[float, float, float] | None = optional_key(
        ListOf(scalar("1.0"), "[1, 0, 0]", (3, 3)),
        "Direction along the contacts; by default their longest direction, with positions "
        "measured from their middle.",
    )
    joint: MeshedJoint
    """Mesh as read, with placeholders for materials and tensions."""

    def check(self, place: Place) -> None:
        """Read the mesh and check the names in it."""
        from microslip.structures import MeshedJoint
        from microslip.structures.reduction_patches import contact_frame

        for name in ("materials", "densities"):
            values = getattr(self, name)
            if values is not None and len(values) != len(self.bodies):
                raise KeyedError(
                    f".{name}",
                    f"wanted one per body, {len(self.bodies)} in all, got {len(values)}",
                )
        refusal = f'wanted a unit such as "mm", got {quote(self.unit)}'
        try:
            scale = units.factor_of(self.unit, units.LENGTH, refusal)
        except ValueError as error:
            raise KeyedError(".unit", str(error)) from None
        try:
            joint = MeshedJoint.read(
                place.path(self.file),
                bodies=dict.fromkeys(self.bodies, (_STAND_IN, 1.0)),
                contacts=self.contacts,
                bolts=dict.fromkeys(self.bolts, 1.0),
                ground=self.ground,
                scale=float(scale),
            )
        except InputError as error:
            message = str(error).replace("write scale=1e-3", 'write unit = "mm"')
            raise ValueError(message) from None
        self.keep(joint=joint)
        along = None if self.along is None else np.array(self.along)
        for contact in joint.mesh.contacts:
            try:
                contact_frame(joint.mesh, contact, along)
            except InputError as error:
                key = place.key if along is None else ".along"
                raise KeyedError(key, str(error)) from None
        place.notes.append(
            f"{place.key}: {len(joint.mesh.cells)} {joint.mesh.kind} cells from {self.file}."
        )

    def build(
        self, materials: Mapping[str, Material], usual: str, density: float | None
    ) -> MeshedJoint:
        """Return the joint whose bodies have the materials and densities [kg/m^3] of the study.

        ``usual`` (name of a material) and ``density`` apply if the mesh lists none for its bodies.
        """
        names = self.materials or (usual,) * len(self.bodies)
        densities = self.densities or (cast(float, density),) * len(self.bodies)
        for name in names:
            check_elastic(materials[name])
        bodies = tuple(
            body._replace(material=materials[name], density=heavy)
            for body, name, heavy in zip(self.joint.mesh.bodies, names, densities, strict=True)
        )
        return replace(self.joint, mesh=replace(self.joint.mesh, bodies=bodies))
