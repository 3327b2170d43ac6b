"""Bolts of a structure in a study, and a mesh in place of a drawing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from microslip._core import units
from microslip._core.errors import InputError
from microslip._core.wording import quote
from microslip.contact.materials import Material
from microslip.friction.pressure import BOLTS
from microslip.structures.bolts import SIZED, Bolts, by_size
from microslip.structures.mesh import check_elastic, slack_bolts
from microslip.study.fields import (
    COLUMN_UNIT,
    LENGTH,
    LINE,
    MASS_DENSITY,
    PLACE,
    number,
    one_of,
    optional,
    text,
    whole_number,
)
from microslip.study.part import Part, key, optional_key
from microslip.study.pressure import TightenedBolts
from microslip.study.readers import Items, KeyedError, Place
from microslip.study.uncertain import Unsure

if TYPE_CHECKING:
    from microslip.structures import MeshedJoint


MOST_BOLTS = 200
DRAWING_KEYS = ("length", "width", "thickness", "lap")


_PLACES = Unsure(PLACE)


class BoltsPart(TightenedBolts):
    """Equal bolts through the lap: places from its middle, diameters, tension or torque."""

    positions: tuple[float, ...] | None = optional_key(
        Items(_PLACES, '["-30 mm", "0 mm", "30 mm"]', (1, 200), single=True),
        "Places along the lap, from its middle; a mesh has them itself.",
    )
    across: tuple[float, ...] | None = optional_key(
        Items(_PLACES, '["-30 mm", "0 mm", "30 mm"]', (1, 200), single=True),
        "Places across the lap, one a bolt; all in the middle unless given.",
        '["0 mm", "0 mm", "0 mm"]',
    )
    slack: tuple[int, ...] = key(
        Items(whole_number(1, MOST_BOLTS, "3"), "[3]", (1, MOST_BOLTS), single=True, distinct=True),
        "Slack bolts, counted from 1 along the lap; the report compares with all tight.",
        default=(),
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
        one_of(*BOLTS), "Size of the bolts, in place of diameters and pitch.", '"M8"'
    )
    clamp_length: float | None = optional_key(
        Unsure(LENGTH),
        "Thickness of all that a bolt clamps, for what embeds; that of the drawing unless given.",
        '"25 mm"',
    )

    def check(self, place: Place) -> None:
        """The size that the thread gives, and one place across for each along."""
        if self.size is not None:
            given = {name: getattr(self, name) for name in SIZED}
            self.__dict__.update(by_size(self.size, self.thread_friction, **given))
        super().check(place)
        check_places(self.positions, self.across)

    def build(self) -> Bolts:
        """The bolts of a drawing."""
        sizes: dict[str, Any] = {
            name: getattr(self, name)
            for name in self.keys
            if name in Bolts.__dataclass_fields__ and name != "positions"
        }
        along = self.positions or ()
        places = along if self.across is None else np.stack([along, self.across], axis=1)
        return Bolts(places, **{k: v for k, v in sizes.items() if v is not None})


def check_slack(slack: Sequence[int], count: int) -> None:
    """Refuse numbers of slack bolts that no bolt has."""
    try:
        slack_bolts(slack, count)
    except InputError as error:
        raise KeyedError(".bolts.slack", str(error)) from None


def check_places(along: Sequence[float] | None, across: Sequence[float] | None) -> None:
    """Refuse places across that do not go with those along."""
    if across is not None and len(across) != len(along or ()):
        raise KeyedError(
            ".across",
            f"wanted one place a bolt, {len(along or ())} of them, got {len(across)}",
        )


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
    materials: tuple[str, ...] | None = optional_key(
        _names('["steel", "steel", "titanium"]', distinct=False),
        "Material of each body; the first of the surface unless given.",
    )
    densities: tuple[float, ...] | None = optional_key(
        Items(MASS_DENSITY, '["7850 kg/m^3", "7850 kg/m^3", "4430 kg/m^3"]', (1, _MOST_ITEMS)),
        "Mass density of each body; `structure.density` unless given.",
    )
    along: tuple[float, float, float] | None = optional_key(
        Items(number("1.0"), "[1, 0, 0]", (3, 3)),
        "Direction along the contacts; that in which they are longest unless "
        "given, and places in them then count from their middle.",
    )
    joint: MeshedJoint
    """The mesh as it was read; its materials and tensions are still to come."""

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
        refusal = f'wanted a unit such as "mm", got {quote(self.unit)}'
        try:
            scale = units.factor_of(self.unit, units.LENGTH, refusal)
        except ValueError as error:
            raise KeyedError(".unit", str(error)) from None
        try:
            joint = MeshedJoint.read(
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
        self.keep(joint=joint)
        along = None if self.along is None else np.array(self.along)
        for contact in joint.mesh.contacts:
            try:
                contact_frame(joint.mesh, contact, along)
            except InputError as error:
                key = place.key if along is None else ".along"
                raise KeyedError(key, str(error)) from None
        place.reading.notes.append(
            f"{place.key}: {len(joint.mesh.cells)} {joint.mesh.kind} cells from {self.file}."
        )

    def build(
        self, materials: Mapping[str, Material], usual: str, density: float | None
    ) -> MeshedJoint:
        """The joint, its bodies of what the study says."""
        names = self.materials or (usual,) * len(self.bodies)
        densities = self.densities or (cast(float, density),) * len(self.bodies)
        for name in names:
            check_elastic(materials[name])
        bodies = tuple(
            body._replace(material=materials[name], density=heavy)
            for body, name, heavy in zip(self.joint.mesh.bodies, names, densities, strict=True)
        )
        return replace(self.joint, mesh=replace(self.joint.mesh, bodies=bodies))
