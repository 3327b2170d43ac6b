"""Elements for pyHarm: a joint in one direction, in two, and as a contact with its normal.

pyHarm finds them by its entry points; ``pyHarm.extension.load("microslip")`` registers them, or
``Maestro({"plugin": microslip.hosts.pyharm.elements(), ...})``. A connector of theirs reads::

    {"type": "microslip_joint", "connect": {"beam": [3], "GROUND": [3]}, "dirs": [0], "law": joint}

Displacements are those of the first node less those of the second. The extra ``pyharm`` installs
pyHarm, whose import takes seconds.
"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from pyHarm.DynamicOperator import get_array_nh
from pyHarm.Elements.NodeToNodeElements.NodeToNodeElement import NodeToNodeElement

from microslip._core.checks import Floats, show
from microslip.errors import InputError
from microslip.friction import BackboneLaw, Interface, IsotropicJoint, JointField


def elements() -> list[type[Any]]:
    """All elements, as pyHarm's loader of extensions asks for them."""
    return [JointElement, PlanarJointElement, ContactElement]


class _Element(NodeToNodeElement):  # type: ignore[misc]
    """Common base of the elements: coefficients of motion and force, and their Jacobian.

    Attributes
    ----------
    length : float
        Length [m] that pyHarm's displacements count in.
    """

    directions: ClassVar[int]
    law_kind: ClassVar[type]
    law_text: ClassVar[str]

    def __post_init__(self) -> None:
        numbers = get_array_nh(self.nh)[0]
        self.harmonics = [int(number) for number in numbers]
        self.length = 1.0
        dirs = self.data["dirs"]
        if len(dirs) != self.directions:
            raise InputError(
                f"`dirs` must be {self.directions} direction(s) for {self.factory_keyword}, got "
                f"{dirs}"
            )
        law = self.data.get("law")
        if not isinstance(law, self.law_kind):
            raise InputError(f"`law` must be {self.law_text}, got {show(law)}")
        self.read_law(law)
        self._known: tuple[bytes, Floats, Floats] | None = None

    def __flag_update__(self) -> None:
        self.flag_nonlinear = True
        self.flag_AFT = True

    def read_law(self, law: Any) -> None:
        """Keep the law of the connector's data."""
        self.law: Any = law

    def response(self, motion: Floats) -> tuple[Floats, Floats]:
        """Forces [N] (directions, coefficients) of a motion [m] of that shape, and their Jacobian.

        It has the shape (directions, directions, coefficients, coefficients) [N/m].
        """
        raise NotImplementedError

    def generateIndices(self, expl_dofs: Any) -> None:
        """Find the degrees of freedom, as pyHarm does, and what takes them to the joint."""
        super().generateIndices(expl_dofs)
        across = self.Pslave - self.Pmaster
        self._across = np.concatenate([turn @ across for turn in self.Pdir])

    def adim(self, lc: float, wc: float) -> None:
        """Count displacements in a characteristic length; forces stay forces."""
        self.length *= lc
        self.flag_adim = True
        self._known = None

    def _solved(self, xg: Floats) -> tuple[Floats, Floats]:
        """Residual and Jacobian; pyHarm asks for both at one place, one after the other."""
        x = np.ascontiguousarray(xg[self.indices], dtype=float)
        key = x.tobytes()
        if self._known is None or self._known[0] != key:
            motion = self.length * (self._across @ x)
            force, jacobian = self.response(motion.reshape(self.directions, -1))
            full = jacobian.transpose(0, 2, 1, 3).reshape(motion.size, motion.size)
            turned = self._across.T @ full @ self._across
            self._known = key, self._across.T @ force.reshape(-1), self.length * turned
        return self._known[1], self._known[2]

    def evalResidual(self, xg: Floats, om: float) -> Floats:
        """Forces [N] on the degrees of freedom of both nodes."""
        self.R = self._solved(xg)[0].copy()
        return self.R

    def evalJacobian(self, xg: Floats, om: float) -> tuple[Floats, Floats]:
        """Their derivatives by the displacements, and by the frequency, on which none depends."""
        self.J = self._solved(xg)[1].copy()
        self.dJdom = np.zeros(len(self.indices))
        return self.J, self.dJdom


class JointElement(_Element):
    """A backbone law in one direction.

    Data: ``law``, a backbone law; ``rest``, where the joint began, 0.0 [m] or "mean". There are no
    samples.
    """

    factory_keyword = "microslip_joint"
    directions = 1
    law_kind, law_text = BackboneLaw, "a backbone law"

    def read_law(self, law: Any) -> None:
        """Any backbone law."""
        self.law = law
        self.rest = self.data.get("rest", 0.0)

    def response(self, motion: Floats) -> tuple[Floats, Floats]:
        """Harmonics of the settled cycle."""
        harmonics = self.law.harmonics(motion[0], self.harmonics, self.rest)
        return harmonics.force[None], harmonics.jacobian[None, None]


class PlanarJointElement(_Element):
    """A joint in two directions at a constant load: sliders of vectors.

    Data: ``law``, an :class:`microslip.IsotropicJoint`; samples are pyHarm's ``nti``.
    """

    factory_keyword = "microslip_planar_joint"
    directions = 2
    law_kind, law_text = IsotropicJoint, "an IsotropicJoint, such as IsotropicJoint(joint)"

    def response(self, motion: Floats) -> tuple[Floats, Floats]:
        """Harmonics of the settled cycle of both directions."""
        force, jacobian = self.law.harmonics(motion, self.harmonics, samples=self.nti)
        return force, jacobian


class ContactElement(_Element):
    """A contact that opens, closes and slips in two directions; ``dirs`` names the normal first.

    Data: ``law``, an :class:`microslip.Interface`, whose separation is that of no motion;
    ``sliders``, 128; ``balanced``, whether the load at rest is taken off, True, since the forces
    that press the joint are rarely in the model. The normal displacement opens the contact.
    """

    factory_keyword = "microslip_contact"
    directions = 3
    law_kind, law_text = Interface, "an Interface, which has a surface"

    def read_law(self, law: Any) -> None:
        """A joint with a surface."""
        if 0 not in self.harmonics:
            raise InputError("a contact needs the mean: nh must be a number, or begin with 0")
        field = JointField(
            law.surface,
            law.friction_coefficient,
            areas=[1.0],
            separations=[law.separation],
            surface_area=1.0,
        )
        self.law = field.two_directions(self.data.get("sliders", 128))
        self.separation = law.separation
        self.load = law.normal_load if self.data.get("balanced", True) else 0.0

    def response(self, motion: Floats) -> tuple[Floats, Floats]:
        """Harmonics of the normal and both tangential forces."""
        separation = motion[0].copy()
        separation[0] += self.separation
        force, load, jacobian = self.law.harmonics(
            motion[None, 1:], self.harmonics, separations=separation[None], samples=self.nti
        )
        normal = -load[0]
        normal[0] += self.load
        order = [2, 0, 1]  # of (T1, T2, N)
        turned = jacobian[0][np.ix_(order, order)].copy()
        turned[0] *= -1.0
        return np.concatenate((normal[None], force[0])), turned
