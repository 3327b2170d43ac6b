"""Elements for pyHarm: joints in one and two directions, and contacts with a normal direction.

pyHarm finds the elements by the entry points of this package; register them with
``pyHarm.extension.load("microslip")`` or ``Maestro({"plugin":
microslip.export.hosts.pyharm.elements(), ...})``. An example of a connector::

    {"type": "microslip_joint", "connect": {"beam": [3], "GROUND": [3]}, "dirs": [0], "law": joint}

Relative displacements are those of the first node minus those of the second. The extra ``pyharm``
installs pyHarm, whose import takes seconds.
"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from pyHarm.DynamicOperator import get_array_nh
from pyHarm.Elements.NodeToNodeElements.NodeToNodeElement import NodeToNodeElement

from microslip._core.checks import Floats, show
from microslip._core.errors import InputError
from microslip.export.hosts.contact_nodes import ContactNodes, contact_field
from microslip.friction import BackboneLaw, Interface, IsotropicJoint, JointField
from microslip.friction.vector_cycles import SETTLED


def elements() -> list[type[Any]]:
    """Return all element classes, as the extension loader of pyHarm expects."""
    return [JointElement, PlanarJointElement, ContactElement]


class _Element(NodeToNodeElement):  # type: ignore[misc]
    """Base class of the elements: Fourier coefficients of motion and force, and their Jacobian.

    Attributes
    ----------
    length : float
        Length [m] by which pyHarm divides displacements.
    """

    directions: ClassVar[tuple[int, ...]]
    law_kind: ClassVar[type | tuple[type, ...]]
    law_text: ClassVar[str]
    data: Any
    indices: Any

    def __post_init__(self) -> None:
        numbers = get_array_nh(self.nh)[0]
        self.harmonics = [int(number) for number in numbers]
        self.length = 1.0
        self._count = 1
        dirs = self.data["dirs"]
        if len(dirs) not in self.directions:
            counts = " or ".join(map(str, self.directions))
            raise InputError(
                f"`dirs` must be {counts} direction(s) for {self.factory_keyword}, got {dirs}"
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
        self.law: Any = law

    def response(self, motion: Floats) -> tuple[Floats, Floats]:
        """Return coefficients of forces [N] and their Jacobian for coefficients of a motion [m].

        Motion and forces have the shape (directions of all nodes, coefficients), ordered node by
        node. The Jacobian [N/m] has the shape (nodes, directions, directions, coefficients,
        coefficients); the first axis may be omitted for one node.
        """
        raise NotImplementedError

    def generateIndices(self, expl_dofs: Any) -> None:
        """Find the degrees of freedom of all pairs of nodes.

        Also assemble the matrix from these to the relative displacements of the pairs along
        ``dirs``.
        """
        data, pairs = self.data, self._pairs()
        parts = []
        for pair in pairs:
            self.data = {**data, "connect": pair}
            super().generateIndices(expl_dofs)
            across = self.Pslave - self.Pmaster
            turned = np.concatenate([turn @ across for turn in self.Pdir])
            parts.append((np.asarray(self.indices), turned))
        self.data = data
        self.indices = np.unique(np.concatenate([indices for indices, _ in parts]))
        width = len(parts[0][1])
        self._across = np.zeros((width * len(parts), self.indices.size))
        for i, (indices, turned) in enumerate(parts):
            columns = np.searchsorted(self.indices, indices)
            self._across[width * i : width * (i + 1), columns] = turned

    def _pairs(self) -> list[Any]:
        connect = self.data["connect"]
        sides = list(connect.items()) if isinstance(connect, dict) else list(connect)
        lengths = {len(nodes) for sub, nodes in sides if sub != "GROUND"}
        if lengths != {self._count}:
            raise InputError(
                f"connect must list {self._count} node(s) on each side for "
                f"{self.factory_keyword}, got {connect}"
            )
        pairs = [
            [(sub, [nodes[i if sub != "GROUND" else 0]]) for sub, nodes in sides]
            for i in range(self._count)
        ]
        return [dict(pair) for pair in pairs] if isinstance(connect, dict) else pairs

    def adim(self, lc: float, wc: float) -> None:
        """Divide displacements by a characteristic length [m]; forces are not scaled."""
        self.length *= lc
        self.flag_adim = True
        self._known = None

    def _residual_and_jacobian(self, xg: Floats) -> tuple[Floats, Floats]:
        """Return residual and Jacobian, cached because pyHarm requests them one by one."""
        x = np.ascontiguousarray(xg[self.indices], dtype=float)
        key = x.tobytes()
        if self._known is None or self._known[0] != key:
            motion = self.length * (self._across @ x)
            size = len(self.data["dirs"])
            force, jacobian = self.response(motion.reshape(self._count * size, -1))
            blocks = jacobian.reshape(self._count, size, size, *jacobian.shape[-2:])
            wide = motion.size // self._count
            blocks = blocks.transpose(0, 1, 3, 2, 4).reshape(self._count, wide, wide)
            turned = (blocks @ self._across.reshape(self._count, wide, -1)).reshape(motion.size, -1)
            turned = self._across.T @ turned
            self._known = key, self._across.T @ force.reshape(-1), self.length * turned
        return self._known[1], self._known[2]

    def evalResidual(self, xg: Floats, om: float) -> Floats:
        """Return the forces [N] on the degrees of freedom of both nodes."""
        self.R = self._residual_and_jacobian(xg)[0].copy()
        return self.R

    def evalJacobian(self, xg: Floats, om: float) -> tuple[Floats, Floats]:
        """Return derivatives of forces by displacements [N/m], and by frequency, which are 0."""
        self.J = self._residual_and_jacobian(xg)[1].copy()
        self.dJdom = np.zeros(len(self.indices))
        return self.J, self.dJdom


class JointElement(_Element):
    """Backbone law in one direction, integrated over the cycle without samples.

    Data: ``law``, a backbone law; ``rest``, the displacement [m] at which the force is zero before
    the motion, by default 0.0, or "mean" for the mean of the cycle.
    """

    factory_keyword = "microslip_joint"
    directions = (1,)
    law_kind, law_text = BackboneLaw, "a backbone law"

    def read_law(self, law: Any) -> None:
        """Store the law, and the displacement ``rest`` at which its force is zero."""
        self.law = law
        self.rest = self.data.get("rest", 0.0)

    def response(self, motion: Floats) -> tuple[Floats, Floats]:
        """Return force coefficients and Jacobian of the settled cycle."""
        harmonics = self.law.harmonics(motion[0], self.harmonics, self.rest)
        return harmonics.force[None], harmonics.jacobian[None, None]


class PlanarJointElement(_Element):
    """Joint in two tangential directions at a constant load.

    It consists of springs with sliders in parallel, whose friction forces are vectors in the plane.
    Data: ``law``, an :class:`microslip.IsotropicJoint`. Cycles have pyHarm's ``nti`` samples.
    """

    factory_keyword = "microslip_planar_joint"
    directions = (2,)
    law_kind, law_text = IsotropicJoint, "an IsotropicJoint, such as IsotropicJoint(joint)"

    def response(self, motion: Floats) -> tuple[Floats, Floats]:
        """Return force coefficients and Jacobian of the settled cycle in both directions."""
        force, jacobian = self.law.harmonics(motion, self.harmonics, samples=self.nti)
        return force, jacobian


class ContactElement(_Element):
    """Contacts that open, close and slip: nodes of a field, evaluated in one compiled call.

    ``dirs`` names the normal direction first, then one or two tangential directions; ``connect``
    lists as many nodes on each side as the law has. A positive normal displacement opens the
    contact.

    Data: ``law``, a :class:`microslip.JointField`, or an :class:`microslip.Interface` for one pair
    of nodes; at zero displacement the separations are the gaps of the field, or those at rest if it
    has none. ``sliders``, default 128, and ``nearest``: see
    :meth:`microslip.JointField.two_directions`. ``balanced``, default True: subtract the load at
    zero displacement, since a model rarely contains the forces that press a joint. ``tolerance``,
    default 1e-6: error of settled forces in two tangential directions over the force limit. With
    one tangential direction there are no sliders or samples.
    """

    factory_keyword = "microslip_contact"
    directions = 2, 3
    law_kind, law_text = (
        (Interface, JointField),
        "an Interface or a JointField",
    )

    def read_law(self, law: Any) -> None:
        """Create the contact nodes of the law."""
        if 0 not in self.harmonics:
            raise InputError("a contact needs the mean: nh must be a number, or begin with 0")
        options = (self.data.get("sliders", 128), self.data.get("nearest"))
        balanced = bool(self.data.get("balanced", True))
        tolerance = self.data.get("tolerance", SETTLED)
        self.law = ContactNodes(
            contact_field(law), len(self.data["dirs"]), *options, balanced, tolerance
        )
        self._count = self.law.field.size

    def response(self, motion: Floats) -> tuple[Floats, Floats]:
        """Return Fourier coefficients of normal and tangential forces, and their Jacobian."""
        turned = motion.reshape(self._count, -1, motion.shape[-1])
        order = np.roll(np.arange(turned.shape[1]), 1)
        force, jacobian = self.law.harmonics(np.roll(turned, -1, axis=1), self.harmonics, self.nti)
        return force[:, order].reshape(motion.shape), jacobian[:, order][:, :, order]
