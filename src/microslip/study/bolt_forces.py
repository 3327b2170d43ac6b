"""Keys of tightened bolts: torque, grade, and embedding after tightening."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from microslip._core.units import LENGTH
from microslip.structures.bolt_tightening import (
    GRADES,
    TIGHTENING_FACTOR,
    BoltForces,
    ClampedBolt,
    embedding_of,
    tension_band,
)
from microslip.structures.bolts import Bolts
from microslip.study.fields import one_of, optional, quantity, whole_number
from microslip.study.part import Part, key
from microslip.study.readers import KeyedError, Place
from microslip.study.uncertain import Spread, Unsure

_LOST = "; the tension falls by f_Z over the resiliences of bolt and plates."


class TightenedBolts(Part):
    """Keys common to bolts of a structure and bolts that press a joint."""

    torque: float | None = optional(Bolts, "torque")
    nut_factor: float | None = optional(Bolts, "nut_factor")
    thread_friction: float | None = optional(Bolts, "thread_friction")
    bearing_friction: float | None = optional(Bolts, "bearing_friction")
    hole: float | None = optional(Bolts, "hole")
    grade: str | None = key(
        one_of(*GRADES),
        "Property class, whose proof stress bounds the tension.",
        '"8.8"',
        default=None,
    )
    tightening_factor: float | None = optional(
        Bolts,
        "tightening_factor",
        help="Largest over smallest preload at one torque (VDI 2230's alpha_A), so the torque is "
        "an uncertain input; where others are uncertain it is 1.6 unless given.",
    )
    embedding: float | None = key(
        Unsure(quantity(LENGTH, "8 um")),
        f"Embedding f_Z of all faces of a bolt (VDI 2230){_LOST}",
        default=None,
    )
    rz: float | None = key(
        Unsure(quantity(LENGTH, "6.3 um")),
        f"Rz of the faces, for f_Z by the table of VDI 2230, in place of embedding{_LOST}",
        default=None,
    )
    interfaces: int = key(
        whole_number(1, 20), "Number of faces between the plates, for rz.", default=1
    )
    size: str | None

    _plate_modulus: float | None = None  # of what the bolts clamp, once the materials are read

    @property
    def model_spreads(self) -> dict[str, Spread]:
        """Scatter of the tension at a given torque."""
        if self.torque is None or isinstance(self.torque, Spread):
            return {}
        low, high = tension_band(self.tightening_factor or TIGHTENING_FACTOR)
        return {"torque": Spread.between(low * self.torque, high * self.torque)}

    def check(self, place: Place) -> None:
        """Refuse embedding given twice or without a size; a given factor always scatters."""
        if self.embedding is not None and self.rz is not None:
            raise KeyedError(".rz", "wanted embedding or rz, got both; remove one")
        for name in ("embedding", "rz"):
            if getattr(self, name) is not None and self.size is None:
                raise KeyedError(
                    ".size", f'missing; {name} wants the resilience of a size such as size = "M8"'
                )
        if self.rz is not None:
            embedding_of(self.rz, self.interfaces)
        if self.tightening_factor is not None:
            self.__dict__.update(self.model_spreads)

    @property
    def embeds(self) -> bool:
        """Whether any tension is lost."""
        return self.embedding is not None or self.rz is not None

    def clamped(self, length: float) -> ClampedBolt | None:
        """A bolt through plates so thick together [m]; None where size or plates are not known."""
        if self.size is None or self._plate_modulus is None:
            return None
        return ClampedBolt(self.size, length, self._plate_modulus)

    def forces(self, assembly: float, length: float, utilisation: float | None) -> BoltForces:
        """Forces of a bolt by its tension after tightening [N] and the thickness clamped [m]."""
        clamped, embedded = self.clamped(length), self.embedding or 0.0
        if self.rz is not None:
            embedded = embedding_of(self.rz, self.interfaces)
        factor = self.tightening_factor or (1.0 if self.torque is None else TIGHTENING_FACTOR)
        return BoltForces(
            assembly,
            tightening_factor=factor,
            embedding=float(embedded),
            loss=0.0 if clamped is None else clamped.loss(float(embedded)),
            load_factor=None if clamped is None else clamped.load_factor(),
            utilisation=utilisation,
        )


def clamp(study: Any) -> None:
    """Tell bolts and a structure of which materials of a study their plates and parts are."""
    pressure, part = getattr(study.joint, "pressure", None), study.structure
    bodies = tuple(getattr(study.surface, "materials", ()))
    if pressure is not None and isinstance(pressure, TightenedBolts):
        modulus = _modulus(study, bodies, pressure.plates)  # type: ignore[attr-defined]
        joint = study.joint.copy(pressure=pressure.copy(_plate_modulus=modulus))
        joint.settle()
        study.__dict__["joint"] = joint
    if part is not None:
        names = part.materials or bodies[:1]
        modulus = _modulus(study, names, [1.0] * len(names))
        metals = {name: material.build() for name, material in study.material.items()}
        study.__dict__["structure"] = part.copy(
            bolts=part.bolts.copy(_plate_modulus=modulus), _metals=(metals, *bodies[:1])
        )


def _modulus(study: Any, names: Sequence[str], thickness: Sequence[float]) -> float | None:
    """Modulus of plates on each other [Pa]; None if one is not described, or is rigid."""
    metals = [study.material.get(name) for name in names]
    moduli = [getattr(metal, "young_modulus", None) for metal in metals]
    soft = sum(t / float(e) for t, e in zip(thickness, moduli, strict=True) if e is not None)
    return None if None in metals or not soft else sum(thickness) / soft
