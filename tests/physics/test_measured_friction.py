"""Friction of rough contact, solved point by point in both tangential directions, against the law.

The truth: at a held normal load the tractions of each step minimise 1/2 q.Kq - q.(K q_old + step)
with |q| <= mu p at every point, the step of the rigid motion along x; so what slips moves against
its traction, in the plane (Cerruti's kernel, both components). It knows nothing of superposition.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest

import microslip as ms
from microslip.contact.boundary_elements import HalfSpace, closing, press, sliding

RATIO = (2.0 - 0.3) / (2.0 * (1.0 - 0.3))
FRICTION = 0.4


def periodic_face(points: int, seed: int, lay: float) -> np.ndarray:
    """Self-affine heights [pixels], H = 0.8, rms slope 0.1; a lay below one runs along x."""
    qx, qy = np.fft.rfftfreq(points) * points, np.fft.fftfreq(points) * points * lay
    q = np.hypot(qy[:, None], qx)
    size = np.where(
        (q > 0.0) & (q < points / 8 * min(1.0, 2.0 * lay)), np.maximum(q, 2.0) ** -1.8, 0.0
    )
    waves = size * np.exp(2j * np.pi * np.random.default_rng(seed).random(q.shape))
    z = np.fft.irfft2(waves, s=(points, points))
    slope = math.sqrt(sum(np.mean((np.roll(z, 1, axis) - z) ** 2) for axis in (0, 1)))
    return (z - z.mean()) * (0.1 / slope)


class Contact(NamedTuple):
    """A face pressed, and what the law says of it, all on the same periodic grid."""

    space: HalfSpace
    heights: np.ndarray
    separation: float
    pressure: np.ndarray
    stiffness: float  # normal
    tensor: np.ndarray

    def load(self, separation: float) -> float:
        """Load of the law at another separation, solved."""
        tolerance = 1e-8 * self.heights.std()
        return float(
            press(self.space, self.heights, separation, self.pressure, tolerance=tolerance).sum()
        )

    def backbone(self, displacement: float, ratio: float) -> float:
        """T0 = mu [N(d) - N(d + delta/(mu lambda))]."""
        further = self.separation + displacement / (FRICTION * ratio)
        return FRICTION * (float(self.pressure.sum()) - self.load(further))


def contact(
    points: int, pressure: float, hardness: float = math.inf, seed: int = 5, lay: float = 1.0
) -> Contact:
    """A face under a mean pressure over E* h', after it has yielded where it does."""
    z = periodic_face(points, seed, lay)
    space = HalfSpace(z.shape, mirrored=False)
    tolerance = 1e-8 * z.std()
    low, high = 0.02 * z.std(), float(z.max())
    for _ in range(40):
        d = 0.5 * (low + high)
        p = press(space, z, d, hardness=hardness, tolerance=1e-4 * z.std())
        low, high = (d, high) if p.mean() > 0.1 * pressure else (low, d)
    p = press(space, z, d, p, hardness=hardness, tolerance=tolerance)
    gap = space.displacement(p) - z + d
    z = z + np.where(p >= hardness, np.minimum(gap, 0.0), 0.0)
    p = press(space, z, d, p, tolerance=tolerance)
    grown = closing(space, p > 0.0)
    return Contact(space, z, d, p, float(grown.sum()), sliding(space, p > 0.0, RATIO))


def slipped(face: Contact, history: np.ndarray) -> np.ndarray:
    """Forces of a history of displacements from rest, both of shape (steps, 2)."""
    limit = FRICTION * face.pressure
    inside = limit > 0.0
    rows = np.flatnonzero(inside)
    q = np.zeros((2, *limit.shape))
    moved = np.zeros((2, *limit.shape))
    forces, last, step = [], np.zeros(2), 1.0 / 8.0

    def clipped(t: np.ndarray) -> np.ndarray:
        size = np.hypot(*t)
        return np.where(
            inside, t * np.where(size > limit, limit / np.where(size > 0.0, size, 1.0), 1.0), 0.0
        )

    for place in history:
        target = moved + (place - last)[:, None, None]
        residual = (target - moved) * inside  # moved is K q
        scale = float(np.linalg.norm(place - last))
        for _ in range(3000):
            new = clipped(q + step * residual)
            change = new - q
            if float(np.abs(change).max()) <= 2e-4 * step * scale:
                break
            carried = face.space.sheared(change, RATIO)
            # Barzilai and Borwein's step, along the projected arc.
            curve = float(np.vdot(change, carried * inside))
            least = min(1.0, float(np.vdot(change, residual)) / curve) if curve > 0.0 else 1.0
            q = q + least * change
            moved = moved + least * carried
            residual = (target - moved) * inside
            step = min(max(float(np.vdot(change, change)) / curve, 1e-3), 1e2)
        else:
            raise AssertionError("friction not converged")
        forces.append(q.sum(axis=(1, 2)))
        last = place
    assert rows.size > 100
    return np.array(forces)


def compared(face: Contact, direction: int, ratio: float) -> tuple[float, float]:
    """Largest error of the force over mu N, and the error of a loop's energy, at mu N/k_t."""
    limit = FRICTION * float(face.pressure.sum())
    top = limit * ratio / face.stiffness
    first = list(top * np.linspace(0.125, 1.0, 8))
    back = list(top * np.linspace(0.8, -1.0, 10))
    again = list(top * np.linspace(-0.8, 1.0, 10))
    history = np.outer(first + back + again, np.eye(2)[direction])
    forces = slipped(face, history)[:, direction]
    law = [face.backbone(u, ratio) for u in first]
    law += [law[-1] - 2.0 * face.backbone(0.5 * (top - u), ratio) for u in back]
    law += [law[-1] + 2.0 * face.backbone(0.5 * (top + u), ratio) for u in again]
    loop = [top, *back, *again]
    energies = [
        np.trapezoid(np.concatenate(([values[7]], values[8:])), loop) for values in (forces, law)
    ]
    return float(np.abs(forces - law).max()) / limit, float(energies[1] / energies[0]) - 1.0


CASES = [
    (0.02, math.inf, 1.0, 1),
    (0.03, 0.02, 1.0, 1),
    (0.05, math.inf, 1 / 6, 0),
    (0.03, 0.02, 1 / 6, 1),
]


@pytest.mark.parametrize(
    ("points", "pressure", "hardness", "lay", "direction"),
    [
        *((64, *case) for case in CASES),
        *(pytest.param(128, *case, marks=pytest.mark.slow) for case in CASES),
    ],
)
def test_first_loading_and_a_loop(points, pressure, hardness, lay, direction) -> None:
    face = contact(points, pressure, hardness, lay=lay)
    ratio = 1.0 / float(face.tensor[direction, direction])
    force, energy = compared(face, direction, ratio)
    assert force < 0.01
    assert abs(energy) < 0.03
    if lay < 1.0:  # round contacts' ratio is no answer under a lay
        assert abs(compared(face, direction, RATIO)[1]) > 0.1


def laid(face: Contact, turned: float, lay: bool) -> ms.NormalLaw:
    """The law of a face, solved at 40 separations, with its lay in axes that are turned."""
    steps = np.linspace(0.0, 1.0, 40) ** 1.5
    d = face.separation + (float(face.heights.max()) - face.separation) * steps[:-1]
    loads = [float(face.pressure.sum()), *(face.load(x) for x in d[1:])]
    c, s = math.cos(turned), math.sin(turned)
    turn = np.array([[c, -s], [s, c]])
    tensor = turn.T @ face.tensor @ turn
    members = {
        "_lay": property(lambda self: tensor / tensor[0, 0] if lay else None),
        "stiffness_ratio": property(lambda self: 1.0 / tensor[0, 0] if lay else RATIO),
    }
    body = ms.Material(1.0, 0.3)
    kind = type("Laid", (ms.TabulatedNormalLaw,), members)
    return kind(ms.MaterialPair(body, body), np.append(d, face.heights.max()), [*loads, 0.0])


@pytest.mark.parametrize(
    ("points", "case"),
    [
        (64, CASES[2]),
        *(pytest.param(128, case, marks=pytest.mark.slow) for case in CASES[2:]),
    ],
)
def test_oblique_to_a_lay_and_turned(points, case) -> None:
    """Both stiffnesses at first, a force that turns to the motion as all slips, then a corner."""
    pressure, hardness, lay, _ = case
    face = contact(points, pressure, hardness, lay=lay)
    limit = FRICTION * float(face.pressure.sum())
    reach = 1.2 * limit / face.stiffness
    line = np.outer(np.linspace(0.25, 3.0, 12), [math.sqrt(0.5), math.sqrt(0.5)])
    path = reach * np.concatenate((line, line[-1] - np.outer(np.linspace(0.3, 3.0, 10), [1, 0])))
    wanted = slipped(face, path) / limit
    small = 1e-3 * reach
    truth = np.array([slipped(face, small * way[None])[0] for way in np.eye(2)]) / small
    errors = []
    for turned, surface in ((0.0, True), (0.6, True), (0.0, False)):
        c, s = math.cos(turned), math.sin(turned)
        turn = np.array([[c, -s], [s, c]])
        field = ms.JointField(
            laid(face, turned, surface),
            FRICTION, areas=1.0, separations=face.separation, surface_area=1.0,
        ).two_directions(128)  # fmt: skip
        state, found = field.start(), []
        first = turn @ state.try_([0.0, 0.0]).stiffness[0] @ turn.T
        if surface:
            assert first / np.trace(first) == pytest.approx(truth / np.trace(truth), abs=0.003)
        for x in path @ turn:
            found.append(turn @ state.try_(x).force[0] / limit)
            state.commit()
        errors.append(float(np.linalg.norm(np.array(found) - wanted, axis=1).max()))
    # The axes of the field do not matter; one ratio for all directions is no answer.
    assert errors[1] == pytest.approx(errors[0], rel=1e-6)
    assert errors[0] < 0.012
    assert errors[2] > 0.05
    gross = wanted[11] / np.linalg.norm(wanted[11])
    assert np.linalg.norm(gross - math.sqrt(0.5)) < 0.08
