"""Structure given by its mass and stiffness matrices, with attached joints."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, wraps
from typing import Any, Concatenate, ParamSpec, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, show
from microslip._core.errors import InputError
from microslip._core.frozen import assign
from microslip._core.threads import single_threaded
from microslip._core.verdicts import Rule, Verdict
from microslip.friction import BackboneLaw, JointField
from microslip.structures.base_motion import base_response
from microslip.structures.forced import forced_response
from microslip.structures.geometry import geometry
from microslip.structures.joint_groups import (
    Attachment,
    FieldAttachment,
    LawAttachment,
    checked_law,
    joint_motion,
)
from microslip.structures.matrices import (
    LARGEST_DENSE,
    check_mass,
    check_stiffness,
    direction_matrix,
    linear_modes,
    rigid_count,
    symmetric_matrix,
    vector,
)
from microslip.structures.motion import integrate
from microslip.structures.nonlinear_mode import modes
from microslip.structures.random_vibration import random_response
from microslip.structures.shock import shock
from microslip.structures.static import AtRest, static_state

_P = ParamSpec("_P")
_Result = TypeVar("_Result")


def _of_rest(
    method: Callable[Concatenate[Preload, _P], _Result],
) -> Callable[Concatenate[Structure, _P], _Result]:
    @wraps(method)
    def of_structure(structure: Structure, /, *args: _P.args, **options: _P.kwargs) -> _Result:
        return method(structure._undeformed, *args, **options)

    return of_structure


@dataclass(frozen=True, eq=False, repr=False)
class Preload(AtRest):
    """Structure at rest under static forces, the result of :meth:`microslip.Structure.preload`."""

    modes = modes
    forced_response = forced_response
    base_response = base_response
    random_response = random_response
    shock = shock
    integrate = integrate

    def __repr__(self) -> str:
        return f"Preload({self.static_force.size} degrees of freedom, {self.message})"


@dataclass(frozen=True, eq=False, init=False)
class Structure:
    """Linear structure M x'' + C x' + K x = f with attached joints.

    Parameters
    ----------
    mass : array_like or sparse matrix
        Mass matrix M [kg] of n degrees of freedom, shape (n, n), symmetric and positive definite.
    stiffness : array_like or sparse matrix
        Stiffness matrix K [N/m], shape (n, n), of the structure *without its joints*, symmetric,
        without negative eigenvalues. Motions that K does not resist must be restrained by joints,
        or be rigid-body motions.
    damping : array_like or sparse matrix, optional
        Damping matrix C [N s/m], shape (n, n), of everything but the joints; zero by default.

    Notes
    -----
    With joint directions B and joint forces T the equation of motion is
    M x'' + C x' + K x + sum of B T[B^T x] = f. :meth:`modes` computes the nonlinear modes, whose
    frequency and damping depend on the amplitude (Krack 2015, DOI
    10.1016/j.compstruc.2015.03.008). Damping other than that of the joints (material, suspension,
    air) is an input: C, or the ``damping_ratio`` of :meth:`modes`. Methods return new objects and
    leave the structure unchanged.
    """

    mass: Any
    stiffness: Any
    damping: Any
    attachments: tuple[Attachment, ...]

    def __init__(self, mass: Any, stiffness: Any, damping: Any = None) -> None:
        mass = symmetric_matrix("mass", mass)
        check_mass(mass)
        stiffness = symmetric_matrix("stiffness", stiffness, mass.shape[0])
        check_stiffness(stiffness, mass)
        if damping is not None:
            damping = symmetric_matrix("damping", damping, mass.shape[0])
        assign(self, mass=mass, stiffness=stiffness, damping=damping, attachments=())

    @property
    def size(self) -> int:
        """Number of degrees of freedom."""
        return int(self.mass.shape[0])

    # -- joints -----------------------------------------------------------------------------------

    def attach(self, joint: BackboneLaw | JointField, *, directions: Any) -> Structure:
        """Return the structure with one more set of joints.

        Parameters
        ----------
        joint : BackboneLaw or JointField
            Backbone law with a finite stiffness at rest, or a field of contact nodes with areas,
            gaps (or loads) and friction.
        directions : array_like
            For a law: b of shape (n,) or (n, joints). The displacement of a joint is b^T x, and
            its force T acts on the structure as -b T. For a field: B of shape (n, nodes, 3), for
            each node two tangential displacements and the opening, positive where the faces
            separate; in a plane (n, nodes, 2), one tangential displacement and the opening.

        Returns
        -------
        Structure
            New structure; the original is unchanged.
        """
        attachment: Attachment
        if isinstance(joint, JointField):
            b = direction_matrix("directions", directions, self.size, (3, 2))
            if b.shape[2] == 2:  # in a plane nothing moves across
                b = np.insert(b, 1, 0.0, axis=2)
            if b.shape[1] != joint.size:
                raise InputError(
                    f"directions must have one set for each of the {joint.size} nodes of the "
                    f"field, got {b.shape[1]}"
                )
            attachment = FieldAttachment(joint, b)
        elif isinstance(joint, BackboneLaw):
            attachment = LawAttachment(
                checked_law(joint), direction_matrix("directions", directions, self.size)
            )
        else:
            raise InputError(
                "joint must be a backbone law, such as ms.Interface(surface, 0.5, "
                f"normal_load=2000.0), or a JointField, got {show(joint)}"
            )
        return self.with_attachment(attachment)

    def with_attachment(self, attachment: Attachment) -> Structure:
        """Return the structure with one more attachment, which must be valid."""
        extended = object.__new__(Structure)  # the matrices are checked
        assign(extended, mass=self.mass, stiffness=self.stiffness, damping=self.damping)
        assign(extended, attachments=(*self.attachments, attachment))
        return extended

    def with_geometry(
        self,
        coordinates: Any,
        *,
        cubic: ArrayLike | None = None,
        quartic: ArrayLike | None = None,
        cases: Any = None,
    ) -> Structure:
        """Return the structure with a nonlinear geometric stiffness, for thin and curved panels.

        Parameters
        ----------
        coordinates : array_like
            P of shape (n,) or (n, p), p at most six. The geometric forces depend on the
            coordinates z = P^T x.
        cubic, quartic : array_like, optional
            Tensors V3 of shape (p, p, p) and V4 of shape (p, p, p, p), symmetric in all indices, of
            the potential energy V = V3 z z z + V4 z z z z [J], contracted over all indices. The
            forces are 3 V3 z z + 4 V4 z z z.
        cases : pair of array_like, optional
            Coordinates z and total forces of static solutions, both of shape (cases, p). A
            potential of second to fourth order is fitted to them; the second order is then
            dropped, since the stiffness matrix includes it. Motions with larger coordinates than
            those of the cases raise an InputError.

        Returns
        -------
        Structure
            New structure, whose periodic motions use harmonics 0 to 5 by default. The potential is
            represented by conservative springs, listed after the joints with zeros in ``loss``.

        Notes
        -----
        Give either tensors or ``cases``. For each static case prescribe z and
        leave all other displacements free. On reduced models of thin structures see Mignolet et al.
        (2013), DOI 10.1016/j.jsv.2012.10.017.
        """
        columns = direction_matrix("coordinates", coordinates, self.size)
        return self.with_attachment(geometry(columns, cubic, quartic, cases))

    @cached_property
    def verdicts(self) -> tuple[Verdict, ...]:
        """Verdicts on the first frequency, as a check of units, and on joints in rigid motion.

        Rigid-body motion of the structure must not deform its joints.
        """
        return judge(self.mass, self.stiffness, self.attachments)

    # -- statics ----------------------------------------------------------------------------------

    @single_threaded
    def preload(self, static_force: ArrayLike | None = None) -> Preload:
        """Compute the static equilibrium under given forces, including bolt forces.

        Parameters
        ----------
        static_force : array_like, optional
            Forces [N], shape (n,), one for each degree of freedom; zero by default. A field
            created with loads or separations is already in equilibrium: ``static_force`` then acts
            in addition to the forces that press its faces together.

        Returns
        -------
        Preload
            Static displacements, normal loads, pressures and gaps. Its methods, such as ``modes``
            and ``integrate``, compute motions about this state.

        Notes
        -----
        Fields are frictionless in this computation. Since normal loads decrease with separation,
        the equilibrium is then the minimum of a convex energy, which Newton's method with a line
        search finds. Friction of a field starts from this state; a backbone law acts from the
        undeformed structure on.
        """
        force = np.zeros(self.size)
        if static_force is not None:
            force = vector("static_force", static_force, self.size)
        state = self._preload(force)
        self._check_rest(state)
        return state

    def _preload(self, force: Floats, start: Floats | None = None) -> Preload:
        """Return the static state without checking that loads stay in the range of the surface.

        ``start`` are displacements near the state [m].
        """
        displacement, contact, error, iterations = static_state(
            self.stiffness, self.mass, self.attachments, force, start
        )
        if error > 1e-6:
            raise InputError(
                f"static_force must have a state of rest: after {iterations} steps "
                f"{error:.1e} of the largest force is unbalanced; it may pull "
                "the faces apart, or push a law beyond its limit"
            )
        least_load = 1e-12 * max(1.0, float(np.abs(force).max()))
        for attachment, loads in zip(self.attachments, contact, strict=True):
            if attachment.has_gaps and not -float(loads.sum()) > least_load:
                raise InputError(
                    f"static_force must leave some contact: all {len(loads) // 3} nodes of a field "
                    "are open; press the faces together, or check the sign of their opening"
                )
        return Preload(
            self.mass, self.stiffness, self.damping, self.attachments, force,
            displacement, error, iterations,
        )  # fmt: skip

    def _check_rest(self, state: Preload) -> None:
        for attachment in self.attachments:
            if isinstance(attachment, FieldAttachment):
                field = attachment.field
                places = attachment.loads(attachment.columns.T @ state.displacement)
                field.surface._check_rest(places * (field.surface_area / field.areas))

    @cached_property
    def _undeformed(self) -> Preload:
        if any(attachment.has_gaps for attachment in self.attachments):
            raise InputError(
                "a field with gaps has no loads before a static solution: write "
                "structure.preload(static_force).modes(...)"
            )
        return self.preload()

    linear_modes = _of_rest(Preload.linear_modes)
    modes = _of_rest(Preload.modes)
    forced_response = _of_rest(Preload.forced_response)
    base_response = _of_rest(Preload.base_response)
    random_response = _of_rest(Preload.random_response)
    shock = _of_rest(Preload.shock)
    integrate = _of_rest(Preload.integrate)


_MOST_RIGID = 12  # two free bodies

_FREQUENCY = Rule(
    "first elastic frequency",
    watch=3e4,
    outside=1e6,
    meaning="Matrices in kg and N/m give the frequencies of a real structure [Hz].",
    reason="Matrices in t, mm and N mixed with SI give frequencies wrong by a factor of 31.6.",
    remedy="Give the mass in kg and the stiffness in N/m.",
    missing="There is no elastic mode.",
)
SLOWNESS = replace(_FREQUENCY, name="first elastic frequency, from below", watch=0.5, outside=0.01)
GROUNDED = Rule(
    "joint motion in rigid motion",
    watch=1e-8,
    outside=1e-8,
    meaning=(
        "A joint between two faces does not move when the structure moves as a whole "
        "(largest b^T r, relative to the motion of the degrees of freedom that it connects)."
    ),
    reason="With centroids 0.4 mm apart, a frequency of 169 Hz was computed as 317 Hz.",
    remedy=(
        "Average both faces over the same sample points; "
        "for a joint to ground or to a loose part this is expected."
    ),
    missing="K leaves no motion free.",
)


def judge(mass: Any, stiffness: Any, attachments: tuple[Attachment, ...]) -> tuple[Verdict, ...]:
    """Return verdicts on the first frequency and on joints that rigid-body motion deforms."""
    count = None if mass.shape[0] <= LARGEST_DENSE else _MOST_RIGID + 1
    squares, shapes = linear_modes(stiffness, mass, count)
    rigid = rigid_count(squares, stiffness, mass)
    first = math.sqrt(squares[rigid]) / (2.0 * math.pi) if rigid < squares.size else None
    motion = None
    if rigid and attachments:
        motion = joint_motion(attachments, shapes[:, :rigid])[0]
    return _FREQUENCY.judge(first), SLOWNESS.judge(first), GROUNDED.judge(motion)
