"""The law of a joint that is pressed unevenly: a sum of joints, one for each place."""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, exact, floats, number, plain, positive, show
from microslip._core.errors import InputError
from microslip._core.frozen import assign, lock, made_once
from microslip.contact import NormalLaw
from microslip.contact.materials import MaterialPair
from microslip.contact.validity import Verdict, validity
from microslip.friction.base import BackboneLaw
from microslip.friction.interface import Interface
from microslip.friction.parallel import Parallel
from microslip.friction.pressure import Pressure


def _checked_pressure(pressure: Any) -> Pressure:
    """A distribution of pressure, and nothing else."""
    if isinstance(pressure, Pressure):
        return pressure
    raise InputError(
        f"`pressure` must be a Pressure, got {show(pressure)}; write ms.Pressure.cone(outer=0.01)"
    )


@dataclass(frozen=True, eq=False, repr=False)
class PressedJoint(Parallel):
    """A joint under a pressure that varies from place to place, while the body moves as one.

    Every place is at the separation that its pressure asks for, so the law is a sum of joints, one
    for each area that is pressed alike: a :class:`Parallel` law.

    Parameters
    ----------
    surface : NormalLaw
        A surface with an apparent area, which must hold what is pressed.
    friction_coefficient : float
        Coulomb's coefficient mu [-], above zero.
    pressure : Pressure
        Distribution of the load.
    normal_load : float
        All of it [N].

    Notes
    -----
    The sum of Ciavarella and Jaeger's superposition over the places, T0 = sum mu [N_p(d_p) -
    N_p(d_p + delta/kappa)] (DOI 10.1115/1.2833765). A tightened surface was tightened under the
    same distribution. The bodies beneath are rigid: what they give way is not in it.
    """

    laws: Sequence[BackboneLaw] = field(init=False, default=())
    surface: NormalLaw
    friction_coefficient: float
    pressure: Pressure
    normal_load: float

    def __post_init__(self) -> None:
        _checked_pressure(self.pressure)
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
                f"`pressure` must lie within the area of the surface, {exact(apparent)} m^2, got "
                f"one on {self.pressure.area:.6g} m^2"
            )
        places = zip(self.pressure.areas.tolist(), self.pressure.shares.tolist(), strict=True)
        laws = tuple(
            Interface(self.surface._patch(area, share), mu, normal_load=share * load)
            for area, share in places
        )
        assign(self, laws=laws)

    def at(self, *, normal_load: float) -> PressedJoint:
        """The same joint under another load [N], spread in the same way."""
        load = positive("normal_load", normal_load, "N", 2000.0)
        # The places keep their surfaces, so that tightening is computed once for each.
        joint = copy(self)
        joint.__dict__.clear()
        shares = self.pressure.shares.tolist()
        fields = {
            "surface": self.surface,
            "friction_coefficient": self.friction_coefficient,
            "pressure": self.pressure,
            "normal_load": load,
            "laws": tuple(
                law.at(normal_load=share * load)
                for law, share in zip(self._joints, shares, strict=True)
            ),
        }
        joint.__dict__.update(fields)
        return joint

    # -- places -----------------------------------------------------------------------------------

    @cached_property
    def pressures(self) -> Floats:
        """Pressure [Pa] on each area of the distribution."""
        return lock(self.normal_load * self.pressure.shares / self.pressure.areas)

    @cached_property
    def separations(self) -> Floats:
        """Separation [m] of each."""
        return lock(np.array([law.separation for law in self._joints]))

    @property
    def _joints(self) -> tuple[Interface, ...]:
        return self.laws  # type: ignore[return-value]

    def slip_shares(self, displacement: float) -> Floats:
        """Ratio T/(mu N) of each place at a displacement [m], 0 to 1."""
        u = number("displacement", displacement, "m", 1e-7)
        return np.array([float(law.backbone(u)) / law.force_limit for law in self._joints])

    # -- all of it --------------------------------------------------------------------------------

    @cached_property
    def separation(self) -> float:
        """Separation [m] where the pressure is largest."""
        return float(self.separations[np.argmax(self.pressures)])

    @property
    def slip_per_indentation(self) -> float:
        """Kappa [-], the same everywhere."""
        return self._joints[0].slip_per_indentation

    @cached_property
    def normal_stiffness(self) -> float:
        """Normal stiffness [N/m] of the faces that move as one."""
        return math.fsum(law.normal_stiffness for law in self._joints)

    @cached_property
    def contact_count(self) -> float | None:
        """Summits in contact; None for a surface that does not know its contacts."""
        return self._total("contact_count")

    @cached_property
    def contact_area(self) -> float | None:
        """Real contact area [m^2]; None for a surface that does not know its contacts."""
        return self._total("contact_area")

    def _total(self, name: str) -> float | None:
        values = [getattr(law, name) for law in self._joints]
        return None if any(value is None for value in values) else math.fsum(values)

    def stick_area(self, displacement: ArrayLike) -> Any:
        """Compute the contact area [m^2] that still sticks on first loading, (19.9) summed.

        Parameters
        ----------
        displacement : array_like
            Displacements [m] of any shape, which the result has too.
        """
        x = floats("displacement", displacement, "m")
        return plain(np.asarray(sum(np.asarray(law.stick_area(x)) for law in self._joints)))

    @property
    def validity(self) -> tuple[Verdict, ...]:
        """Verdicts where the pressure is largest; contacts are those of the whole joint."""
        worst = self._joints[int(np.argmax(self.pressures))]
        return validity(worst, contacts=self.contact_count)

    def __repr__(self) -> str:
        return (
            f"PressedJoint({type(self.surface).__name__}, {self.pressure!r}, "
            f"friction_coefficient={exact(self.friction_coefficient)}, "
            f"normal_load={exact(self.normal_load)})"
        )

    @classmethod
    def guess(
        cls,
        data: Any,
        *,
        pressure: Pressure | None = None,
        pair: MaterialPair | None = None,
        normal_load: ArrayLike | None = None,
        heights: Any = None,
        radius: float | None = None,
        area: float | None = None,
    ) -> PressedJoint:
        """A joint to start a fit from: that of :meth:`Interface.guess` under a given pressure.

        The ``pressure`` is required; without an ``area`` [m^2] the surface has that of the
        pressure.
        """
        spread = _checked_pressure(pressure)
        area = spread.area if area is None else area
        joint = Interface.guess(
            data, pair=pair, normal_load=normal_load, heights=heights, radius=radius, area=area
        )
        return cls(joint.surface, joint.friction_coefficient, spread, joint.normal_load)

    @classmethod
    @made_once
    def examples(cls) -> tuple[PressedJoint, ...]:
        """The project's worked example under a ring that is pressed on few places."""
        joint = Interface.examples()[0]
        spread = Pressure.patches([2e-5, 4e-5, 6e-5], [3.0, 2.0, 0.5])
        return (cls(joint.surface, joint.friction_coefficient, spread, 2000.0),)
