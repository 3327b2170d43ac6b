"""Floor 10: the joint of a study: an interface under its loads, or any other friction law."""

from __future__ import annotations

from functools import reduce
from operator import or_
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from microslip._core.parameters import key_of
from microslip.friction import LAWS, BackboneLaw, Interface
from microslip.normal import NormalLaw
from microslip.study.fields import Loads, UncertainFriction
from microslip.study.parametric import DescribedAlone, can_be_described, table_of
from microslip.study.part import Part

INTERFACE = key_of(Interface)


class Joint(Part):
    """What presses and holds the surfaces: friction coefficient [–] and normal loads [N]."""

    law: Literal["interface"] = Field(
        default="interface", description="The surface decides; other laws have keys of their own."
    )
    friction_coefficient: UncertainFriction = Field(
        description="Coulomb's coefficient of friction, above zero.", examples=["0.55"]
    )
    normal_load: Loads = Field(
        default=(),
        description="One normal load or a list of different ones; one joint for each. Only a "
        "[structure] needs none: its bolts press.",
        examples=['["500 N", "2 kN"]'],
    )

    @property
    def loads(self) -> tuple[float, ...]:
        """Normal loads [N], one joint for each."""
        return self.normal_load

    def build(self, surface: NormalLaw, normal_load: float) -> Interface:
        """The joint at one of its loads."""
        return Interface(surface, self.friction_coefficient, normal_load)


class LawJoint(DescribedAlone):
    """A friction law by its own parameters; it knows no surface and no normal load."""

    law: str

    @property
    def loads(self) -> tuple[float, ...]:
        """It knows none."""
        return ()

    def build(self) -> BackboneLaw:
        """The law."""
        law: BackboneLaw = super().build()
        return law


LAW_TABLES: dict[str, type[Any]] = {
    key_of(law): table_of(law, "law", "joint", __name__, LawJoint)
    for law in LAWS
    if law is not Interface and can_be_described(law)
}
"""Tables of the friction laws that are made of numbers only, by their names."""


globals().update({table.__name__: table for table in LAW_TABLES.values()})


def _law(given: Any) -> str:
    """The law of a joint; without one it is an interface."""
    law = given.get("law", INTERFACE) if isinstance(given, dict) else getattr(given, "law", None)
    return law if isinstance(law, str) else INTERFACE


_TABLES: dict[str, type[Any]] = {INTERFACE: Joint, **LAW_TABLES}

if TYPE_CHECKING:
    AnyJoint = Any
else:
    AnyJoint = Annotated[
        reduce(or_, (Annotated[table, Tag(name)] for name, table in _TABLES.items())),
        Discriminator(_law),
    ]
