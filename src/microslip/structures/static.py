"""Static equilibrium of a structure, the minimum of a convex energy."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, wraps
from typing import Any, Concatenate, NamedTuple, ParamSpec, TypeVar

import numpy as np

from microslip._core.checks import Floats, exact, number, whole_number
from microslip._core.errors import InputError
from microslip._core.frozen import lock
from microslip._core.threads import single_threaded
from microslip.structures.geometry import GEOMETRY_HARMONICS, GeometryAttachment
from microslip.structures.joint_groups import Attachment, FieldAttachment, all_columns
from microslip.structures.matrices import (
    LARGEST_DENSE,
    dense,
    factorised,
    fastest_rate,
    is_sparse,
    least_square,
    linear_modes,
    positive_definite,
    with_springs,
)
from microslip.structures.modal_model import ModalModel, SolverResult, modal_model, stuck_stiffness
from microslip.structures.periodic_motion import HARMONICS

_P = ParamSpec("_P")
_Answer = TypeVar("_Answer", bound=SolverResult)
MOST_MODES = 100_000
_ITERATIONS = 100
_ENOUGH = 1e-12  # unbalanced force, beside the largest of all forces
_FINEST = 1e-15  # share of a step, below which none leads on


def closed_stiffness(stiffness: Any, attachments: tuple[Attachment, ...]) -> Any:
    """Return the stiffness matrix with stiff springs along all coordinates that carry static load.

    The springs have the largest entry of the matrix as stiffness.
    """
    columns = all_columns(attachments, stiffness.shape[0])
    holding = np.concatenate([np.zeros(0), *(a.representative_stiffness for a in attachments)])
    active = holding > 0.0
    if not active.any():
        return stiffness
    scale = float(abs(stiffness).max()) or 1.0
    b = columns[:, active] / np.linalg.norm(columns[:, active], axis=0)
    return with_springs(stiffness, b, np.full(b.shape[1], scale))


def static_state(
    stiffness: Any,
    mass: Any,
    attachments: tuple[Attachment, ...],
    static_force: Floats,
    start: Floats | None = None,
) -> tuple[Floats, list[Floats], float, int]:
    """Return the static equilibrium, by Newton's method with a line search on the energy.

    ``start`` are displacements near the equilibrium [m], zero by default. The results are the
    displacements [m], the forces of each attachment by column [N], the unbalanced force over the
    largest force [-], and the number of iterations.
    """
    free = _free_motions(closed_stiffness(stiffness, attachments), mass)
    _check_balanced(free, static_force)
    columns = all_columns(attachments, static_force.size)
    parts = np.cumsum([a.columns.shape[1] for a in attachments])[:-1]
    rigid = mass @ free
    solver = _Solver(stiffness, mass, columns, rigid)

    def joints(x: Floats) -> tuple[Floats, Floats]:
        motions = np.split(columns.T @ x, parts)[: len(attachments)]
        pairs = [a.static_forces(u) for a, u in zip(attachments, motions, strict=True)]
        force, stiffness = (np.concatenate([np.zeros(0), *(p[k] for p in pairs)]) for k in (0, 1))
        return force, stiffness

    preloaded = max((a.largest_load_at_rest for a in attachments), default=0.0)
    x, error, converged = np.zeros(static_force.size), math.inf, False
    if start is not None:
        x = start
    force, tangent = joints(x)
    for iterations in range(_ITERATIONS + 1):
        elastic, contact = stiffness @ x, columns @ force
        gap = static_force - elastic - contact
        gap = gap - rigid @ (free.T @ gap)
        largest = max(float(np.abs(v).max(initial=0.0)) for v in (static_force, elastic, contact))
        largest = max(largest, preloaded)
        error = float(np.abs(gap).max()) / largest if largest else 0.0
        # Where rounding is reached, a step more changes nothing.
        if error <= 1e-15 or (error <= _ENOUGH and converged):
            break
        converged = error <= _ENOUGH
        if iterations == _ITERATIONS:
            break
        step = solver.solve(tangent, gap)
        x, force, tangent, moved = _line_search(
            stiffness, columns, joints, static_force, x, step, gap
        )
        if not moved:
            break
    forces = np.split(force, parts) if attachments else []
    return x, forces, error, iterations


def _free_motions(closed: Any, mass: Any) -> Floats:
    """Return the motions (n, count) that neither the structure nor its closed joints resist."""
    size = mass.shape[0]
    least = least_square(closed, mass)
    if size <= LARGEST_DENSE and positive_definite(dense(closed) - least * dense(mass)):
        return np.zeros((size, 0))
    squares, shapes = linear_modes(closed, mass, None if size <= LARGEST_DENSE else 12)
    return shapes[:, squares <= least]


class _Solver:
    """Solver of linear systems with the tangent stiffness, with rigid-body motions restrained."""

    def __init__(self, stiffness: Any, mass: Any, columns: Floats, rigid: Floats) -> None:
        self._columns = columns
        self._stiffest = np.zeros(columns.shape[0])
        self._sparse = is_sparse(stiffness) and stiffness.shape[0] > LARGEST_DENSE
        rate = fastest_rate(stiffness, mass)
        if self._sparse:
            from scipy.sparse import csc_matrix

            # A full rank update would fill the matrix; so small a shift costs a step at most.
            self._fixed = stiffness + 1e-10 * rate * mass if rigid.shape[1] else stiffness
            self._columns = csc_matrix(columns)
        else:
            self._fixed = dense(stiffness) + rate * (rigid @ rigid.T)

    def solve(self, tangent: Floats, force: Floats) -> Floats:
        matrix = with_springs(self._fixed, self._columns, tangent)
        if self._sparse:
            return np.asarray(factorised(matrix).solve(force))
        from scipy.linalg import cho_factor, cho_solve

        shift, diagonal = 0.0, np.diag(matrix)
        # What was stiff in an earlier step says how soft a shift is.
        self._stiffest = np.maximum(self._stiffest, diagonal)
        while True:
            try:
                factor = cho_factor(matrix + shift * np.diag(self._stiffest), check_finite=False)
                return np.asarray(cho_solve(factor, force, check_finite=False))
            except np.linalg.LinAlgError:
                # Open contacts carry nothing yet.
                shift = max(10.0 * shift, 1e-14)


def _line_search(
    stiffness: Any,
    columns: Floats,
    joints: Any,
    static_force: Floats,
    x: Floats,
    step: Floats,
    gap: Floats,
) -> tuple[Floats, Floats, Floats, bool]:
    """Search along a step from ``x`` for displacements where the energy is nearly stationary.

    ``gap`` are the unbalanced forces at ``x``. Return the displacements, joint forces and tangents
    there, and whether the search succeeded.
    """
    start = float(gap @ step)  # minus the slope of the energy, above zero
    low, high, share = 0.0, math.inf, 1.0
    elastic, along = stiffness @ x, stiffness @ step
    for _ in range(60):
        trial = x + share * step
        try:
            force, tangent = joints(trial)
        except InputError:  # further than the surface has an answer: an open joint is soft
            if share < _FINEST:
                raise
            high = share
            share = 0.5 * (low + high)
            continue
        slope = float((static_force - elastic - share * along - columns @ force) @ step)
        if abs(slope) <= 0.7 * start or start <= 0.0:
            return trial, force, tangent, bool(start > 0.0)
        if slope < 0.0:
            high = share
        else:
            low = share
        share = 0.5 * (low + high) if math.isfinite(high) else 2.0 * share
    return trial, force, tangent, False


def _check_balanced(free: Floats, force: Floats) -> None:
    if not free.shape[1] or not force.any():
        return
    sizes = np.abs(free).max(axis=0)
    push = np.abs(free.T @ force) / sizes
    worst = int(np.argmax(push))
    if push[worst] > 1e-9 * np.abs(force).sum():
        place = int(np.argmax(np.abs(free[:, worst])))
        raise InputError(
            f"static_force must be balanced: it acts with {push[worst]:.3g} N on one of "
            f"{free.shape[1]} unrestrained rigid motions (largest at degree of freedom {place}); "
            "restrain the structure, or remove that part of the force"
        )


class LinearModes(NamedTuple):
    """Modes of a structure whose joints are linear springs."""

    frequency: Floats
    """Frequencies [Hz], increasing, including those of rigid motions."""
    shape: Floats
    """Shapes (n, modes), each of modal mass 1 kg."""


@dataclass(frozen=True, eq=False, repr=False)
class AtRest:
    """Matrices and joints of a structure in its static equilibrium."""

    mass: Any
    stiffness: Any
    damping: Any
    attachments: tuple[Attachment, ...]
    static_force: Floats
    """Given forces [N]."""
    displacement: Floats
    """Static displacements (n,) [m]."""
    equilibrium_error: float
    """Largest unbalanced force over the largest force [-]."""
    iterations: int
    """Number of Newton steps."""

    @property
    def message(self) -> str:
        """Outcome in a sentence: number of Newton steps, and relative unbalanced force."""
        return (
            f"at rest after {self.iterations} steps, {self.equilibrium_error:.1e} of the largest "
            "force unbalanced"
        )

    @cached_property
    def _motions(self) -> list[Floats]:
        return [a.columns.T @ self.displacement for a in self.attachments]

    def _by_node(self, measure: Any) -> Floats:
        parts = [
            measure(a, u)
            for a, u in zip(self.attachments, self._motions, strict=True)
            if isinstance(a, FieldAttachment)
        ]
        return lock(np.concatenate([*parts, np.zeros(0)]))

    @cached_property
    def gaps(self) -> Floats:
        """Separations of the nodes of all fields at rest [m], as defined by their surface law."""
        return self._by_node(lambda a, u: a.separations(u))

    @cached_property
    def normal_loads(self) -> Floats:
        """Normal loads of the nodes of all fields [N]."""
        return self._by_node(lambda a, u: a.loads(u))

    @cached_property
    def pressures(self) -> Floats:
        """Pressure of each node of all fields [Pa]: normal load over the area of the node."""
        return lock(self.normal_loads / self._by_node(lambda a, _: a.field.areas))

    @cached_property
    def model(self) -> ModalModel:
        """Modal model of the structure with sticking joints."""
        return modal_model(self.mass, self.stiffness, self.damping, self.attachments, self._motions)

    @property
    def _elastic(self) -> ModalModel:
        if not self.model.size:
            raise InputError(
                "the structure has no elastic mode; give it a stiffness, or joints that restrain it"
            )
        return self.model

    @single_threaded
    def linear_modes(self, count: int = 10) -> LinearModes:
        """Return the linear modes of small motion about the static state, with sticking joints.

        Parameters
        ----------
        count : int, optional
            Number of modes.

        Returns
        -------
        LinearModes
            ``frequency`` [Hz] and ``shape``.
        """
        count = whole_number("count", count, 1, MOST_MODES)
        stiffness = stuck_stiffness(self.stiffness, self.attachments, self._motions)
        squares, shapes = linear_modes(stiffness, self.mass, min(count, self.static_force.size))
        frequency = np.sqrt(np.maximum(squares, 0.0)) / (2.0 * math.pi)
        return LinearModes(frequency, shapes)

    @property
    def _geometric(self) -> list[GeometryAttachment]:
        return [a for a in self.attachments if isinstance(a, GeometryAttachment)]

    def _orders(self, harmonics: Sequence[int] | None) -> Sequence[int]:
        if harmonics is not None:
            return harmonics
        return GEOMETRY_HARMONICS if self._geometric else HARMONICS


def solver_method(
    solve: Callable[Concatenate[AtRest, _P], _Answer],
) -> Callable[Concatenate[AtRest, _P], _Answer]:
    """Decorate a solver: limit linear algebra to one thread, and check the computed motion.

    InputError is raised if a motion exceeds the ``reach`` of a geometric nonlinearity.
    """

    @single_threaded
    @wraps(solve)
    def within_reach(rest: AtRest, /, *args: _P.args, **options: _P.kwargs) -> _Answer:
        answer = solve(rest, *args, **options)
        for geometry in rest._geometric:
            columns = geometry.coordinates
            before = 0.0 if geometry.rest is None else geometry.rest
            geometry.check_reach(np.abs(columns.T @ (rest.displacement - before)))
            geometry.check_reach(answer._sizes(columns))
        return answer

    return within_reach


def base_damping(value: Any) -> float:
    """Validate the damping ratio of everything but the joints [-]."""
    ratio = number("damping_ratio", value, example=0.001)
    if not 0.0 <= ratio < 1.0:
        raise InputError(f"damping_ratio must be from 0 to below 1, got {exact(ratio)}")
    return ratio
