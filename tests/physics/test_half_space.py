"""Compliance of the solid behind a contact: closed forms against each other and by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ellipkm1

import microslip as ms
from microslip.contact.half_space import in_series, solid_stiffness

PAIR = ms.MaterialPair(ms.Material(200e9, 0.3), ms.Material(70e9, 0.33))


def test_a_round_contact_by_hand() -> None:
    normal, tangential = solid_stiffness(PAIR, math.pi * 1e-6)
    assert normal == pytest.approx(2e-3 * PAIR.composite_modulus, rel=1e-14)
    # Mindlin: k_n/k_t is E*/4G* of any round contact.
    assert normal / tangential == pytest.approx(PAIR.stiffness_ratio, rel=1e-14)


@pytest.mark.parametrize("hole", [0.3, 0.6, 0.8])
def test_an_annulus_lies_between_thin_ring_and_full_disc(hole: float) -> None:
    """Of one outer radius a hole takes little; rings of rigid discs bound it from below."""
    area = math.pi * (1.0 - hole**2) * 1e-6
    (ring, _), (disc, _) = solid_stiffness(PAIR, area, hole), solid_stiffness(PAIR, math.pi * 1e-6)
    assert 0.89 * disc < ring < disc


def _of_annulus(hole: float, rings: int) -> float:
    """Stiffness of a rigid annulus of outer radius 1 over E*, by rings of even pressure.

    A ring line of radius s displaces a point at radius r by 4 s/(r + s) K(m) per pressure and
    width, with 1 - m = ((r - s)/(r + s))^2. Cubed coordinates resolve its logarithm.
    """
    edges = 0.5 * (1.0 + hole) - 0.5 * (1.0 - hole) * np.cos(np.linspace(0.0, np.pi, rings + 1))
    r = np.sqrt(0.5 * (edges[1:] ** 2 + edges[:-1] ** 2))
    u, weight = np.polynomial.legendre.leggauss(24)
    u, weight = 0.5 * (u + 1.0), 0.5 * weight
    parts = []
    for end in (edges[:-1], edges[1:]):  # both sides of the point nearest to r within each ring
        near = np.clip(r[:, None], edges[:-1], edges[1:])[..., None]
        s = near + (end[:, None] - near) * u**3
        line = 4.0 * s / (r[:, None, None] + s)
        line *= ellipkm1(((r[:, None, None] - s) / (r[:, None, None] + s)) ** 2 + 1e-300)
        parts.append(np.sum(line * abs(end[:, None] - near) * 3.0 * u**2 * weight, axis=-1))
    pressure = np.linalg.solve((parts[0] + parts[1]) / np.pi, np.ones(rings))
    return float(np.sum(pressure * np.pi * np.diff(edges**2)))


@pytest.mark.parametrize("hole", [0.01, 0.3, 0.5, 0.7, 0.8, 0.9, 0.97])
def test_an_annulus_agrees_with_rings_of_pressure(hole: float) -> None:
    normal, tangential = solid_stiffness(PAIR, math.pi * (1.0 - hole**2), hole)
    within = 1e-3 if hole <= 0.5 else 6e-3
    assert normal / PAIR.composite_modulus == pytest.approx(_of_annulus(hole, 40), rel=within)
    assert normal / tangential == pytest.approx(PAIR.stiffness_ratio, rel=1e-14)


def _of_rectangle(length: float, width: float, rows: int) -> float:
    """Stiffness over E* of a rigid punch [m] by boundary elements, finer towards the edges.

    The displacement of an element under an even pressure is Love's (Johnson 1985, eq. 3.25).
    """

    def seen(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        return np.asarray(u * np.arcsinh(v / abs(u)) + v * np.arcsinh(u / abs(v)))

    edges = [-0.5 * side * np.cos(np.linspace(0.0, np.pi, rows + 1)) for side in (length, width)]
    x, y = (g.ravel() for g in np.meshgrid(*(0.5 * (e[1:] + e[:-1]) for e in edges)))
    a, b = (g.ravel() for g in np.meshgrid(*(0.5 * np.diff(e) for e in edges)))
    dx, dy = x[:, None] - x, y[:, None] - y
    by_pressure = seen(dx + a, dy + b) - seen(dx - a, dy + b)
    by_pressure += seen(dx - a, dy - b) - seen(dx + a, dy - b)
    pressure = np.linalg.solve(by_pressure / np.pi, np.ones(x.size))
    return float(np.sum(pressure * 4.0 * a * b))


@pytest.mark.parametrize("aspect", [1.0, 2.0, 4.0, 10.0])
def test_a_rectangle_agrees_with_boundary_elements(aspect: float) -> None:
    """Two meshes extrapolate the error of the edges, which falls with the square of the rows."""
    length, width = math.sqrt(aspect), math.sqrt(1.0 / aspect)
    coarse, fine = (_of_rectangle(length, width, rows) for rows in (10, 20))
    normal, tangential = solid_stiffness(PAIR, 1.0, aspect=aspect)
    assert normal / PAIR.composite_modulus == pytest.approx((4.0 * fine - coarse) / 3.0, rel=0.008)
    assert normal / tangential == pytest.approx(PAIR.stiffness_ratio, rel=1e-14)
    if aspect == 1.0:  # the capacity of a square plate, 0.36679 of its side, times pi
        assert normal / PAIR.composite_modulus == pytest.approx(1.15230, rel=5e-3)


def test_springs_in_series() -> None:
    assert in_series(2.0, 2.0) == 1.0
    assert in_series(3.0, 0.0) == 0.0


def test_a_study_reports_both_stiffnesses_and_a_structure_does_not() -> None:
    from laps import STRIP

    text = STRIP.partition("[structure]")[0].replace("0.35", '0.35\nnormal_load = ["60 N"]')
    result = ms.Study.from_toml(text).run()
    joint = result.summary["joints"][0]
    alone, rig = joint["tangential_stiffness"], joint["rig_tangential_stiffness"]
    pair = result.joints[0].surface.pair
    assert rig == pytest.approx(in_series(alone, solid_stiffness(pair, 2e-4)[1]), rel=1e-12)
    assert rig < alone


def test_a_rectangle_in_a_study() -> None:
    from laps import STRIP

    text = STRIP.partition("[structure]")[0].replace("0.35", '0.35\nnormal_load = ["60 N"]')
    text += '\n[joint.pressure]\nkind = "rectangle"\nlength = "4 mm"\nwidth = "1 mm"\ncount = 2\n'
    result = ms.Study.from_toml(text).run()
    joint, pair = result.summary["joints"][0], result.joints[0].surface.pair
    solid = 2.0 * solid_stiffness(pair, 4e-6, aspect=4.0)[1]
    expected = in_series(joint["tangential_stiffness"], solid)
    assert joint["rig_tangential_stiffness"] == pytest.approx(expected, rel=1e-12)
