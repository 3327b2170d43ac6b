"""Geometric stiffening or softening by a potential of third and fourth order in few coordinates.

The potential V = V3 z z z + V4 z z z z of the coordinates z = P^T x is written as a sum of powers
of linear forms w z, as any such polynomial can be. Each form is then an independent nonlinear
spring along its own direction, and the forces are conservative for all coefficients.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import permutations, product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, floats
from microslip._core.errors import InputError
from microslip.contact.materials import Material
from microslip.structures.periodic_motion import HarmonicBasis, HarmonicForces

GEOMETRY_HARMONICS = (0, 1, 2, 3, 4, 5)
"""Harmonics of motions with a geometry: the even ones change an arch's damping by 15 %."""
_MOST = 6
_LEFT = 0.05  # of the forces beyond the linear ones: what a fit may leave


class Springs(NamedTuple):
    """Springs with the force 3 c3 u^2 + 4 c4 u^3, one for each direction with displacement u."""

    square: Floats
    cube: Floats

    def at(self, u: Floats) -> tuple[Floats, Floats]:
        """Return forces [N] and stiffnesses [N/m]; directions in the first axis."""
        shape = (-1,) + (1,) * (u.ndim - 1)
        c3, c4 = self.square.reshape(shape), self.cube.reshape(shape)
        return 3.0 * c3 * u**2 + 4.0 * c4 * u**3, 6.0 * c3 * u + 12.0 * c4 * u**2


@dataclass(frozen=True, eq=False)
class GeometryAttachment:
    """Springs that represent the geometric stiffness. Same interface as :class:`LawAttachment`."""

    springs: Springs
    columns: Floats
    """Directions of the forms (degrees of freedom, forms)."""
    coordinates: Floats
    """Projection of displacements on the coordinates, (degrees of freedom, coordinates)."""
    reach: Floats | None
    """Largest magnitude of each coordinate in the static cases; None for tensors."""
    rest: Floats | None = None
    """Displacements (degrees of freedom,) at which the springs are unloaded; zero by default."""

    has_gaps = False
    largest_load_at_rest = 0.0

    @property
    def representative_stiffness(self) -> Floats:
        """Stiffness at rest [N/m], which is zero."""
        return np.zeros(self.columns.shape[1])

    def static_forces(self, motion: Floats) -> tuple[Floats, Floats]:
        """Return forces [N] and stiffnesses [N/m] at displacements of the springs (forms,) [m]."""
        return self.springs.at(self._bent(motion))

    def stuck(self, motion: Floats) -> Floats:
        """Return tangent stiffnesses [N/m] at static displacements of the springs (forms,) [m]."""
        return self.springs.at(self._bent(motion))[1]

    def _bent(self, motion: Floats) -> Floats:
        return motion if self.rest is None else motion - self.columns.T @ self.rest

    def group(self, motion: Floats, line: Floats) -> GeometryGroup:
        """Return springs linearised about a static motion (forms,) [m]; ``line`` is not used."""
        del line
        return GeometryGroup(self.springs, self.columns, self._bent(motion))

    def check_reach(self, size: Floats) -> None:
        """Raise an InputError if magnitudes of coordinates (..., coordinates) exceed ``reach``."""
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
    """Group of conservative springs linearised about a static state. Same interface as LawGroup."""

    def __init__(self, springs: Springs, columns: Floats, static: Floats) -> None:
        self._springs, self.static = springs, static
        self.directions = columns[:, :, None]
        self._loaded, stiffness = springs.at(static)
        self.stuck = stiffness[:, None]
        self.lost = np.zeros(static.size)

    def harmonic_forces(self, coefficients: Floats, basis: HarmonicBasis) -> HarmonicForces:
        """Return Fourier coefficients of the forces minus those at rest, by sampling."""
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
        """Return the group itself: springs have no memory."""
        return self

    def try_(self, displacement: Floats) -> tuple[Floats, Floats]:
        """Return forces (forms, 1) [N], minus those at rest, and tangents (forms, 1, 1) [N/m]."""
        force, slope = self._springs.at(self.static + displacement[:, 0])
        return (force - self._loaded)[:, None], slope[:, None, None]

    def commit(self) -> None:
        """Do nothing, because the springs have no memory."""


def geometry(
    coordinates: Floats,
    cubic: ArrayLike | None,
    quartic: ArrayLike | None,
    cases: Any,
) -> GeometryAttachment:
    """Return the attachment of :meth:`microslip.Structure.with_geometry`."""
    p = coordinates.shape[1]
    if p > _MOST:
        raise InputError(f"coordinates must be at most {_MOST}, got {p}")
    by_tensors = cubic is not None or quartic is not None
    if by_tensors == (cases is not None):
        raise InputError(
            "a geometry needs either tensors cubic= and quartic=, or static cases=(coordinates, "
            "forces)"
        )
    forms = _forms(p)
    if by_tensors:
        tensors = [
            _tensor(n, t, p, o) for n, t, o in (("cubic", cubic, 3), ("quartic", quartic, 4))
        ]
        parts = [
            _as_powers(tensor, forms, order) for tensor, order in zip(tensors, (3, 4), strict=True)
        ]
        return GeometryAttachment(Springs(*parts), coordinates @ forms.T, coordinates, None)
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
    limits = np.abs(z).max(axis=0)
    if limits.min() <= 0.0:
        raise InputError("cases must move each coordinate")
    springs, scaled = _fit(z, forces, limits, forms)
    return GeometryAttachment(springs, coordinates @ scaled.T, coordinates, limits)


def _forms(p: int) -> Floats:
    """Return unit vectors w (forms, p) whose (w z)^3 and (w z)^4 span the cubics and quartics in z.

    z are p coordinates.
    """
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
                f"{name} must be symmetric in all its indices, as derivatives of a potential are, "
                f"but at {place} two permutations differ by {gap[place]:.3g}; take the mean over "
                "all permutations"
            )
    return tensor


def _as_powers(tensor: Floats, forms: Floats, order: int) -> Floats:
    powers = np.ones((len(forms), 1))
    for _ in range(order):
        powers = (powers[:, :, None] * forms[:, None, :]).reshape(len(forms), -1)
    return np.asarray(np.linalg.lstsq(powers.T, tensor.reshape(-1))[0])


def _fit(z: Floats, forces: Floats, reach: Floats, forms: Floats) -> tuple[Springs, Floats]:
    """Fit springs of third and fourth order to static cases; return them and their directions.

    ``z`` and ``forces`` (cases, p) are displacements and forces of p coordinates, ``reach`` (p,)
    the largest displacements. Each spring acts along a unit vector of ``forms`` (forms, p) in the
    space of z/reach. The linear part of the forces is fitted and dropped.
    """
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
            f"cases must determine all {unknowns} coefficients of a potential of {p} coordinates, "
            f"these determine {rank}; add cases of other sizes, both signs, and of two and three "
            "coordinates together"
        )
    weights = np.linalg.lstsq(matrix, right, rcond=1e-10)[0]
    c2, c3, c4 = np.split(weights, 3)
    linear = matrix[:, : c2.size] @ c2
    left = np.linalg.norm(right - matrix @ weights)
    beyond = np.linalg.norm(right - linear)
    if left > _LEFT * beyond and left > 1e-9 * np.linalg.norm(right):
        raise InputError(
            f"forces of the cases must follow one potential of third and fourth order: "
            f"{100.0 * left / beyond:.2g} % of the nonlinear part remains; take smaller "
            "displacements, or check that the forces belong to the coordinates"
        )
    return Springs(c3, c4), forms / reach


_MIDDLE = 15.0 / 8.0  # of the mean deflection under an even load: that of the middle
_STEPS = (-1.0, -2.0 / 3.0, -1.0 / 3.0, 0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0)
_ROUNDS = 40
_BENDING = np.array([[12.0, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
_SLOPES = np.array([[36.0, 3, -36, 3], [3, 4, -3, -1], [-36, -3, 36, -3], [3, -1, -3, 4]])
_POINTS = 5  # along, by Gauss: exact for the polynomials that strips bend in
Sensors = dict[str, tuple[tuple[float, float, float], str]]


class Sizes(NamedTuple):
    """Dimensions of a strip between two clamps [m]."""

    length: float
    width: float
    thickness: float
    rise: float


class Bending(NamedTuple):
    """Nonlinear stiffness of a thin part: the arguments of :meth:`ReducedJoint.with_geometry`."""

    sensors: Sensors
    """Places [m] and directions by name, for ``sensors=`` of :meth:`BoltedBeam.reduce`."""
    cases: tuple[Floats, Floats]
    """Mean deflections and elongations [m], and their forces [N]."""
    weights: Floats
    """Weights of each sensor in the two coordinates, (sensors, 2)."""


def strip_sensors(sizes: Sizes, start: float, height: float) -> tuple[Sensors, Floats]:
    """Return sensors and weights for :class:`Bending`; the left end is at (start, height) [m]."""
    sensors: Sensors = {}
    weights = []
    along, shares = np.polynomial.legendre.leggauss(_POINTS)
    places, parts = np.polynomial.legendre.leggauss(3)
    for y, part in zip(0.5 * sizes.width * places, 0.5 * parts, strict=True):
        for t, share in zip(0.5 + 0.5 * along, 0.5 * shares, strict=True):
            z = height + 0.5 * sizes.rise * (1.0 - math.cos(2.0 * math.pi * t))
            sensors[f"bend {len(sensors) + 1}"] = (start + t * sizes.length, float(y), z), "z"
            weights.append((part * share, 0.0))
        for end, sign in ((0.0, -1.0), (1.0, 1.0)):
            place = (start + end * sizes.length, float(y), height)
            sensors[f"bend {len(sensors) + 1}"] = place, "x"
            weights.append((0.0, sign * part))
    return sensors, np.array(weights)


class Strip:
    """Von Karman elements of a shallow clamped strip whose right end can move lengthwise.

    Its unloaded shape is a raised cosine. It bends cylindrically, with the modulus E/(1 - nu^2) of
    wide plates. Degrees of freedom: displacements u (lengthwise) and w and slope w' of each node.
    """

    def __init__(self, sizes: Sizes, material: Material, count: int = 32) -> None:
        length, width, thickness, rise = sizes
        self._sizes, self._step = sizes, length / count
        h, size = self._step, 3 * (count + 1)
        modulus = material.young_modulus / (1.0 - material.poisson_ratio**2)
        self._tension = modulus * width * thickness
        bent = modulus * width * thickness**3 / 12.0 / h**3
        scale = np.array([1.0, h, 1.0, h])
        scale = scale[:, None] * scale
        block = bent * scale * _BENDING
        self._slope = scale * _SLOPES / (30.0 * h * h)
        first = 3 * np.arange(count)[:, None]
        self._along, self._across = first + np.array([0, 3]), first + np.array([1, 2, 4, 5])
        self.bending = np.zeros((size, size))
        even: Floats = np.zeros(size)
        for cells in self._across:
            self.bending[np.ix_(cells, cells)] += block
            even[cells] += np.array([0.5, h / 12.0, 0.5, -h / 12.0]) / count
        self.free = np.setdiff1d(np.arange(size), [0, 1, 2, size - 2, size - 1])
        phase = 2.0 * math.pi * np.arange(count + 1) / count
        self._shape: Floats = np.zeros(size)
        self._shape[1::3] = 0.5 * rise * (1.0 - np.cos(phase))
        self._shape[2::3] = math.pi * rise / length * np.sin(phase)
        stretch: Floats = np.zeros(size)
        stretch[size - 3] = 1.0
        self.coordinates = np.stack([even, stretch], axis=1)[self.free]
        """Mean deflection and elongation, (degrees of freedom, 2)."""

    def forces(self, x: Floats) -> tuple[Floats, Floats]:
        """Return nodal forces [N, N m] at displacements of the free nodes, and their Jacobian."""
        d: Floats = np.zeros(self._shape.size)
        d[self.free] = x
        moved, shape = d[self._across], self._shape[self._across]
        turned = (shape + moved) @ self._slope
        strain = (d[self._along[:, 1]] - d[self._along[:, 0]]) / self._step
        strain += np.einsum("ei,ei->e", (shape + 0.5 * moved) @ self._slope, moved)
        pull = self._tension * self._step * strain
        force, tangent = self.bending @ d, self.bending.copy()
        ends = np.broadcast_to(np.array([-1.0, 1.0]) / self._step, (len(pull), 2))
        index = np.concatenate([self._along, self._across], axis=1)
        gradient = np.concatenate([ends, turned], axis=1)
        np.add.at(force, index, pull[:, None] * gradient)
        blocks = self._tension * self._step * gradient[:, :, None] * gradient[:, None, :]
        blocks[:, 2:, 2:] += pull[:, None, None] * self._slope
        np.add.at(tangent, (index[:, :, None], index[:, None, :]), blocks)
        return force[self.free], tangent[np.ix_(self.free, self.free)]

    def forces_at(self, places: Floats) -> Floats:
        """Return the static forces [N] for given mean deflections and elongations [m]."""
        size, p = self.coordinates.shape
        x, force = np.zeros(size), np.zeros(p)
        for share in (0.25, 0.5, 0.75, 1.0):
            for _ in range(_ROUNDS):
                bearing, tangent = self.forces(x)
                gap = np.concatenate(
                    [bearing - self.coordinates @ force, self.coordinates.T @ x - share * places]
                )
                sides = self.coordinates
                matrix = np.block([[tangent, -sides], [sides.T, np.zeros((p, p))]])
                scale = 1.0 / np.sqrt(np.abs(np.diag(tangent)))
                scale = np.append(scale, 1.0 / np.abs(sides * scale[:, None]).max(axis=0))
                step = scale * np.linalg.solve(scale[:, None] * matrix * scale, -scale * gap)
                x, force = x + step[:size], force + step[size:]
                if np.abs(step[:size]).max() <= 1e-10 * np.abs(x).max():
                    break
            else:
                raise InputError(
                    "the equilibrium of the strip did not converge; use a smaller reach"
                )
        return force

    def cases(self, reach: float) -> tuple[Floats, Floats]:
        """Return static load cases: mean deflections and elongations [m], and their forces [N].

        The middle is deflected by up to ``reach`` [m].
        """
        # Half of what the ends would come closer if nothing held them.
        shortening = 4.9 / self._sizes.length * reach * (self._sizes.rise + 0.5 * reach)
        places = np.array([z for z in product(_STEPS, _STEPS) if any(z)])
        places = places * [reach / _MIDDLE, 0.5 * shortening]
        return places, np.array([self.forces_at(row) for row in places])
