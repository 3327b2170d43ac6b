"""Joint under a nonuniform pressure: a sum of interfaces, one for each level of pressure.

Equation numbers (19.x) are those of chapter 19, DOI 10.1007/978-3-319-56818-8_19.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, exact, floats, number, plain, positive, show
from microslip._core.errors import InputError
from microslip._core.frozen import assign, lock
from microslip.contact import NormalLaw
from microslip.contact.validity import Verdict, surface_verdicts
from microslip.friction.base import BackboneLaw
from microslip.friction.interface import Interface
from microslip.friction.parallel import Parallel
from microslip.friction.pressure import Pressure


@dataclass(frozen=True, eq=False, repr=False)
class PressedJoint(Parallel):
    """Joint under a pressure that varies over its area, between bodies that move rigidly.

    It is a :class:`Parallel` sum of one :class:`Interface` for each area of equal pressure, at its
    own separation.

    Parameters
    ----------
    surface : NormalLaw
        A surface whose apparent area is not less than the pressed area.
    friction_coefficient : float
        Coulomb's coefficient mu [-], above zero.
    pressure : Pressure
        Distribution of the load over areas.
    normal_load : float
        Total normal load [N], above zero.

    Notes
    -----
    By the superposition of Ciavarella and Jaeger (DOI 10.1115/1.2833765), summed over the areas i,
    T0 = sum mu [N_i(d_i) - N_i(d_i + delta/kappa)]. A face that yields is assumed to have been
    tightened in proportion to the same pressures: the area with the highest pressure to the
    tightening pressure of the surface. The elastic deformation of the bodies is not included.
    """

    laws: Sequence[BackboneLaw] = field(init=False, default=())
    surface: NormalLaw
    friction_coefficient: float
    pressure: Pressure
    normal_load: float

    def __post_init__(self) -> None:
        if not isinstance(self.pressure, Pressure):
            raise InputError(
                f"`pressure` must be a Pressure, got {show(self.pressure)}; write "
                "ms.Pressure.cone(outer=0.01)"
            )
        if not isinstance(self.surface, NormalLaw):
            raise InputError(
                "`surface` must be a normal load law, such as ms.GreenwoodWilliamson, got "
                f"{show(self.surface)}"
            )
        load = positive("normal_load", self.normal_load, "N", 2000.0)
        mu = positive("friction_coefficient", self.friction_coefficient)
        assign(self, normal_load=load, friction_coefficient=mu)
        apparent = getattr(self.surface, "area", None)
        if apparent is not None and self.pressure.area > apparent * (1.0 + 1e-9):
            raise InputError(
                f"`pressure` must act on at most the area of the surface, {exact(apparent)} m^2, "
                f"got {self.pressure.area:.6g} m^2"
            )
        pressures = self.pressure.shares / self.pressure.areas
        largest = float(pressures.max())
        if apparent is not None:
            assign(self, surface=self.surface._under(largest * load * apparent))
        places = zip(*(part.tolist() for part in (
            self.pressure.areas, self.pressure.shares, pressures / largest
        )), strict=True)  # fmt: skip
        laws = tuple(
            Interface(self.surface._patch(area, tightening), mu, normal_load=share * load)
            for area, share, tightening in places
        )
        assign(self, laws=laws)

    def at(self, *, normal_load: float) -> PressedJoint:
        """Return the joint under another total load [N] with the same distribution."""
        load = positive("normal_load", normal_load, "N", 2000.0)
        # Interfaces keep their surfaces, so tightening is computed once for each area.
        joints = zip(self._joints, self.pressure.shares.tolist(), strict=True)
        laws = tuple(law.at(normal_load=share * load) for law, share in joints)
        joint = object.__new__(PressedJoint)
        names = ("surface", "friction_coefficient", "pressure")
        assign(joint, **{name: getattr(self, name) for name in names}, normal_load=load, laws=laws)
        return joint

    @cached_property
    def pressures(self) -> Floats:
        """Pressure [Pa] on each area of the distribution."""
        return lock(self.normal_load * self.pressure.shares / self.pressure.areas)

    @cached_property
    def separations(self) -> Floats:
        """Separation [m] of each area of the distribution."""
        return lock(np.array([law.separation for law in self._joints]))

    @property
    def _joints(self) -> tuple[Interface, ...]:
        return self.laws  # type: ignore[return-value]

    def slip_shares(self, displacement: float) -> Floats:
        """Return T/(mu N) [-] of each area at a displacement [m] from rest: 1 in full slip."""
        u = number("displacement", displacement, "m", 1e-7)
        return np.array([float(law.backbone(u)) / law.force_limit for law in self._joints])

    @cached_property
    def separation(self) -> float:
        """Separation [m] of the area with the highest pressure."""
        return float(self.separations[np.argmax(self.pressures)])

    @property
    def slip_per_indentation(self) -> float:
        """Slip per indentation kappa [-], equal for all areas."""
        return self._joints[0].slip_per_indentation

    @cached_property
    def normal_stiffness(self) -> float:
        """Normal stiffness [N/m] for a uniform approach of the faces."""
        return math.fsum(law.normal_stiffness for law in self._joints)

    @cached_property
    def contact_count(self) -> float | None:
        """Number of summits in contact, None for a surface without summits."""
        return self._total("contact_count")

    @cached_property
    def contact_area(self) -> float | None:
        """Real contact area [m^2], None for a surface that does not define it."""
        return self._total("contact_area")

    def _total(self, name: str) -> float | None:
        values = [getattr(law, name) for law in self._joints]
        return None if any(value is None for value in values) else math.fsum(values)

    def stick_area(self, displacement: ArrayLike) -> Any:
        """Compute the contact area [m^2] that sticks on first loading: all stick circles (19.9).

        Displacements [m] are from rest, of any shape, which is that of the result.
        """
        x = floats("displacement", displacement, "m")
        return plain(np.asarray(sum(np.asarray(law.stick_area(x)) for law in self._joints)))

    @property
    def validity(self) -> tuple[Verdict, ...]:
        """Verdicts on the assumptions of the model, for the area with the highest pressure.

        Only the number of contacts is that of the whole joint.
        """
        worst = self._joints[int(np.argmax(self.pressures))]
        return surface_verdicts(worst.surface, worst.separation, contacts=self.contact_count)

    def __repr__(self) -> str:
        return (
            f"PressedJoint({type(self.surface).__name__}, {self.pressure!r}, "
            f"friction_coefficient={exact(self.friction_coefficient)}, "
            f"normal_load={exact(self.normal_load)})"
        )

    @classmethod
    @cache
    def examples(cls) -> tuple[PressedJoint, ...]:
        """Return the worked example of the package under three patches of pressure."""
        joint = Interface.examples()[0]
        spread = Pressure.patches([2e-5, 4e-5, 6e-5], [3.0, 2.0, 0.5])
        return (cls(joint.surface, joint.friction_coefficient, spread, 2000.0),)
