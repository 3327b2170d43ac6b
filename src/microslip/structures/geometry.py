"""Geometric stiffening or softening: a potential of third and fourth order of few coordinates.

V = V3 z z z + V4 z z z z of z = P^T x is written as a sum of powers of linear forms w z, which any
such polynomial is: each form is then a spring along its own direction that knows no other, and
the sum is conservative whatever its numbers are.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import permutations
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, floats
from microslip.errors import InputError
from microslip.structures.periodic_motion import HarmonicBasis, HarmonicForces

HARMONICS = (0, 1, 2, 3, 4, 5)
"""Harmonics of motions with a geometry: the even ones change an arch's damping by 15 %."""
_MOST = 6
_LEFT = 0.05  # of the forces beyond the linear ones: what a fit may leave


class Springs(NamedTuple):
    """Force 3 c3 u^2 + 4 c4 u^3 along each form's motion u."""

    square: Floats
    cube: Floats

    def at(self, u: Floats) -> tuple[Floats, Floats]:
        """Forces [N] and stiffnesses [N/m]; forms in the first axis."""
        shape = (-1,) + (1,) * (u.ndim - 1)
        c3, c4 = self.square.reshape(shape), self.cube.reshape(shape)
        return 3.0 * c3 * u**2 + 4.0 * c4 * u**3, 6.0 * c3 * u + 12.0 * c4 * u**2


@dataclass(frozen=True, eq=False)
class GeometryAttachment:
    """The forms as directions; else as :class:`LawAttachment`, but that nothing is lost."""

    springs: Springs
    columns: Floats
    """Directions of the forms (degrees of freedom, forms)."""
    coordinates: Floats
    """P, (degrees of freedom, coordinates)."""
    reach: Floats | None
    """Largest size of each coordinate for which the potential is known."""
    rest: Floats | None = None
    """Displacements (degrees of freedom,) from which it bends; those of no force unless given."""

    has_gaps = False
    held_load = 0.0

    @property
    def holding(self) -> Floats:
        """Nothing is held by it at rest."""
        return np.zeros(self.columns.shape[1])

    def static_forces(self, motion: Floats) -> tuple[Floats, Floats]:
        """Forces and stiffnesses by form."""
        return self.springs.at(self._bent(motion))

    def stuck(self, motion: Floats) -> Floats:
        """Stiffnesses about a static motion."""
        return self.springs.at(self._bent(motion))[1]

    def _bent(self, motion: Floats) -> Floats:
        return motion if self.rest is None else motion - self.columns.T @ self.rest

    def group(self, motion: Floats, line: Floats) -> GeometryGroup:
        """The forms about a static motion."""
        del line
        return GeometryGroup(self.springs, self.columns, self._bent(motion))

    def check_reach(self, size: Floats) -> None:
        """Refuse motions, the sizes (..., coordinates) of which leave what it is known for."""
        if self.reach is None:
            return
        size = np.where(np.isfinite(size), size, 0.0).reshape(-1, self.reach.size)
        share = np.max(size, axis=0, initial=0.0) / self.reach
        worst = int(np.argmax(share))
        if share[worst] > 1.001:
            raise InputError(
                f"amplitudes must stay within the static cases: coordinate {worst} of the geometry "
                f"reaches {share[worst] * self.reach[worst]:.3g}, the cases {self.reach[worst]:.3g}"
            )


class GeometryGroup:
    """Conservative springs about a static state; its members mean what those of LawGroup do."""

    def __init__(self, springs: Springs, columns: Floats, static: Floats) -> None:
        self._springs, self.static = springs, static
        self.directions = columns[:, :, None]
        self._loaded, stiffness = springs.at(static)
        self.stuck = stiffness[:, None]
        self.lost = np.zeros(static.size)

    def harmonic_forces(self, coefficients: Floats, basis: HarmonicBasis) -> HarmonicForces:
        """By samples, as many as make the cubes exact."""
        count = 4 * basis.harmonics[-1] + 1
        phase = 2.0 * math.pi * np.arange(count) / count
        waves = np.ones((basis.size, count))
        for k in range(1, basis.size, 2):
            waves[k], waves[k + 1] = (f(basis.orders[k] * phase) for f in (np.cos, np.sin))
        weights = waves * 2.0 / count
        weights[0] *= 0.5
        motion = self.static[:, None] + coefficients[:, 0] @ waves
        force, slope = self._springs.at(motion)
        result = (force - self._loaded[:, None]) @ weights.T
        jacobian = np.einsum("ks,fs,ls->fkl", weights, slope, waves)
        return HarmonicForces(result[:, None], jacobian[:, None, :, None, :])

    def start(self) -> GeometryGroup:
        """Springs have no memory: they are their own state, as LawStates is of laws."""
        return self

    def try_(self, displacement: Floats) -> tuple[Floats, Floats]:
        """Forces (forms, 1) and tangents (forms, 1, 1)."""
        force, slope = self._springs.at(self.static + displacement[:, 0])
        return (force - self._loaded)[:, None], slope[:, None, None]

    def commit(self) -> None:
        """Nothing is remembered."""


def geometry(
    coordinates: Floats,
    cubic: ArrayLike | None,
    quartic: ArrayLike | None,
    cases: Any,
    force: Callable[[Floats], ArrayLike] | None,
    reach: ArrayLike | None,
) -> GeometryAttachment:
    """See :meth:`microslip.Structure.with_geometry`."""
    p = coordinates.shape[1]
    if p > _MOST:
        raise InputError(f"coordinates must be at most {_MOST}, few and well chosen, got {p}")
    given = [cubic is not None or quartic is not None, cases is not None, force is not None]
    if sum(given) != 1:
        raise InputError(
            "a geometry needs one of: tensors cubic= and quartic=, static cases=(coordinates, "
            "forces), or force= with its reach="
        )
    limits = None if reach is None else floats("reach", reach)
    if limits is not None:
        if limits.size not in (1, p):
            raise InputError(
                f"reach must be one number or {p}, a coordinate each, got {limits.size}"
            )
        limits = np.broadcast_to(limits.reshape(-1), (p,)).copy()
    if limits is not None and limits.min() <= 0.0:
        raise InputError("reach must be above zero, the largest size of each coordinate")
    forms = _forms(p)
    if given[0]:
        tensors = [
            _tensor(n, t, p, o) for n, t, o in (("cubic", cubic, 3), ("quartic", quartic, 4))
        ]
        parts = [
            _as_powers(tensor, forms, order) for tensor, order in zip(tensors, (3, 4), strict=True)
        ]
        return GeometryAttachment(Springs(*parts), coordinates @ forms.T, coordinates, limits)
    if force is not None:
        if limits is None:
            raise InputError("force needs reach=, the largest size of each coordinate")
        z = np.concatenate([share * forms for share in (-1.0, -0.5, 0.5, 1.0)]) * limits
        try:
            answers = np.array([np.asarray(force(row.copy()), dtype=float) for row in z])
        except (TypeError, ValueError) as error:
            raise InputError(f"force, as a function of the coordinates, failed: {error}") from None
        cases = (z, answers)
    try:
        z, forces = (floats("cases", part) for part in cases)
        z, forces = (part.reshape(len(part), -1) for part in (z, forces))
    except InputError:
        raise
    except Exception:  # an object's own iteration may raise anything
        raise InputError("cases must be coordinates and forces, a row for each case") from None
    if z.shape != forces.shape or z.shape[1] != p:
        raise InputError(
            f"cases must be coordinates and forces of shape (cases, {p}), got {z.shape} and "
            f"{forces.shape}"
        )
    if limits is None:
        limits = np.abs(z).max(axis=0)
    if limits.min() <= 0.0:
        raise InputError("cases must move each coordinate")
    springs, scaled = _fit(z, forces, limits, forms)
    return GeometryAttachment(springs, coordinates @ scaled.T, coordinates, limits)


def _forms(p: int) -> Floats:
    """Directions whose fourth powers hold all polynomials of that order (forms, coordinates)."""
    if p == 1:
        return np.ones((1, 1))
    count = math.ceil(1.5 * math.comb(p + 3, 4))
    raw = np.random.default_rng(1).normal(size=(count, p))
    return np.asarray(raw / np.linalg.norm(raw, axis=1, keepdims=True))


def _tensor(name: str, value: ArrayLike | None, p: int, order: int) -> Floats:
    shape = (p,) * order
    if value is None:
        return np.zeros(shape)
    tensor = floats(name, value)
    if tensor.shape != shape:
        raise InputError(f"{name} must have the shape {shape}, got {tensor.shape}")
    for turned in permutations(range(order)):
        gap = np.abs(tensor - tensor.transpose(turned))
        if float(gap.max()) > 1e-8 * float(np.abs(tensor).max()):
            place = tuple(int(i) for i in np.unravel_index(int(np.argmax(gap)), shape))
            raise InputError(
                f"{name} must be symmetric in all its indices, as a potential's is, but at {place} "
                f"two orders of them differ by {gap[place]:.3g}; take the mean over all orders"
            )
    return tensor


def _powers(forms: Floats, order: int) -> Floats:
    """Tensors of the powers of forms, (forms, entries)."""
    result = np.ones((len(forms), 1))
    for _ in range(order):
        result = (result[:, :, None] * forms[:, None, :]).reshape(len(forms), -1)
    return result


def _as_powers(tensor: Floats, forms: Floats, order: int) -> Floats:
    """Factors of the forms' powers that make a tensor."""
    return np.asarray(np.linalg.lstsq(_powers(forms, order).T, tensor.reshape(-1))[0])


def _fit(z: Floats, forces: Floats, reach: Floats, forms: Floats) -> tuple[Springs, Floats]:
    """Springs of the forms of scaled coordinates, the linear part left to the matrices."""
    along = (z / reach) @ forms.T
    # Work on scaled coordinates: all forces count beside the largest.
    blocks = [order * (along ** (order - 1))[:, :, None] * forms[None] for order in (2, 3, 4)]
    matrix = np.concatenate(blocks, axis=1).transpose(0, 2, 1).reshape(z.size, -1)
    right = (forces * reach).reshape(-1)
    p = reach.size
    unknowns = sum(math.comb(p + order - 1, order) for order in (2, 3, 4))
    rank = int(np.linalg.matrix_rank(matrix, tol=1e-9 * np.linalg.norm(matrix, 2)))
    if rank < unknowns:
        raise InputError(
            f"cases must tell all {unknowns} numbers of a potential of {p} coordinates, these tell "
            f"{rank}: load them to more sizes, with both signs and in pairs and triples"
        )
    weights = np.linalg.lstsq(matrix, right, rcond=1e-10)[0]
    c2, c3, c4 = np.split(weights, 3)
    linear = matrix[:, : c2.size] @ c2
    left = np.linalg.norm(right - matrix @ weights)
    beyond = np.linalg.norm(right - linear)
    if left > _LEFT * beyond and left > 1e-9 * np.linalg.norm(right):
        raise InputError(
            f"forces of the cases must follow one potential of third and fourth order: "
            f"{100.0 * left / beyond:.2g} % of what is not linear is left over; take smaller "
            "displacements, or check that the forces belong to the coordinates"
        )
    return Springs(c3, c4), forms / reach
