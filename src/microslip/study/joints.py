"""The joint of a study: an interface under its loads, or any other friction law."""

from __future__ import annotations

from microslip._core.errors import InputError
from microslip._core.parameters import key_of, parameter_of
from microslip.contact import NormalLaw
from microslip.contact.face_law import FaceLaw
from microslip.friction import BackboneLaw, Interface, PressedJoint
from microslip.friction.law_bands import LawBand
from microslip.friction.law_files import load_law_and_band
from microslip.study.fields import LOAD, key_for, text
from microslip.study.part import Part, SubTable, key, optional_key
from microslip.study.pressure import ANY_PRESSURE, PressurePart
from microslip.study.readers import KeyedError, ListOf, Place
from microslip.study.uncertain import Uncertain


class Joint(Part):
    """Friction coefficient [–] and normal loads [N] of the joint."""

    friction_coefficient: float = key_for(parameter_of(Interface, "friction_coefficient"))
    normal_load: tuple[float, ...] = key(
        ListOf(Uncertain(LOAD), '["500 N", "2 kN"]', single=True, distinct=True),
        "Normal load, or a list of different loads, with one joint per load. Optional only "
        "with a [structure], whose bolts press the faces together.",
        default=(),
    )
    pressure: PressurePart | None = optional_key(
        ANY_PRESSURE,
        "Distribution of the pressure over the faces; uniform over the whole area if absent. "
        "Bolts with a tension or a torque also give the load.",
        '{ kind = "bolt", size = "M8", preload = "15 kN", plates = ["10 mm", "10 mm"] }',
    )

    law = key_of(Interface)

    def check(self, place: Place) -> None:
        """Reject a normal load if bolts of known tension are given, which determine it."""
        if self.pressure is not None and self.pressure.load is not None:
            if self.normal_load:
                raise KeyedError(
                    ".normal_load",
                    "wanted no normal load with joint.pressure bolts of known tension or torque, "
                    "which give the load; remove one of them",
                )
            self.settle()

    def settle(self) -> None:
        """Set the normal load to the clamp force of the bolts, if that is known."""
        load = None if self.pressure is None else self.pressure.load
        if load is not None:
            self.__dict__["normal_load"] = (load,)

    @property
    def loads(self) -> tuple[float, ...]:
        """Normal loads [N]; each gives one joint."""
        return self.normal_load

    def build(self, surface: NormalLaw, normal_load: float) -> Interface | PressedJoint:
        """Return the joint at one normal load [N]."""
        if self.pressure is not None:
            # Each ring of a face that yields needs its own law, which is expensive to compute.
            spread = self.pressure.spread(*((8,) if isinstance(surface, FaceLaw) else ()))
            return PressedJoint(surface, self.friction_coefficient, spread, normal_load)
        return Interface(surface, self.friction_coefficient, normal_load)


class LawJoint(Part):
    """Joint given by the file of a friction law, without a surface or a normal load."""

    law_file: str = key(
        text("the name of a law file", "law.json"),
        "JSON file of a friction law, in place of [surface] and the other keys of [joint]; "
        "relative to the folder of the study. microslip.friction.save_law writes it.",
    )
    friction_law: BackboneLaw
    """Friction law of the file."""
    band: LawBand | None
    """Confidence intervals of an identified law; None for other laws."""

    @classmethod
    def unknown(cls, name: str) -> str:
        """Return the error message for an unknown key, such as one of a joint with a surface."""
        if name in Joint.keys:
            return f"wanted no {name} with joint.law_file; remove one of them"
        return super().unknown(name)

    def check(self, place: Place) -> None:
        """Read the law from its file."""
        try:
            law, band = load_law_and_band(place.path(self.law_file))
        except InputError as error:
            message = place.message(str(error), self.law_file)
            raise KeyedError(".law_file", message.replace("`", "")) from None
        self.keep(friction_law=law, band=band)

    @property
    def law(self) -> str:
        """Name of the friction law."""
        return key_of(type(self.friction_law))

    @property
    def loads(self) -> tuple[float, ...]:
        """Empty tuple: a friction law has no normal load."""
        return ()

    def build(self) -> BackboneLaw:
        """Return the law."""
        return self.friction_law


ANY_JOINT = SubTable(Joint, LawJoint, choose=lambda raw: LawJoint if "law_file" in raw else Joint)
