"""The boundary elements of measured faces: closed forms, their order, another solver."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import special

from microslip.contact.boundary_elements import HalfSpace, closing, press, sliding
from microslip.contact.face_solution import solve_face

EQUAL = (2.0 - 0.33) / (2.0 * (1.0 - 0.33))
"""Normal over tangential stiffness of round contacts, Poisson's ratio 0.33."""


def face(points: int, shortest: int = 8, seed: int = 1, lay: float = 1.0) -> np.ndarray:
    """Self-affine heights [pixels], H = 0.8, rms slope 0.1, cut out of a larger periodic face."""
    m = 2 * points
    qx, qy = np.fft.rfftfreq(m) * m, np.fft.fftfreq(m) * m * lay
    q = np.hypot(qy[:, None], qx)
    size = np.where((q > 0.0) & (q < m / shortest), np.maximum(q, 8.0) ** -1.8, 0.0)
    phase = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, q.shape)
    z = np.fft.irfft2(size * np.exp(1j * phase), s=(m, m))[:points, :points]
    slope = math.sqrt(np.mean(np.diff(z, axis=0) ** 2) + np.mean(np.diff(z, axis=1) ** 2))
    return (z - z.mean()) * (0.1 / slope)


def polonsky_keer(z: np.ndarray, pressure: float, tolerance: float) -> tuple[np.ndarray, float]:
    """Pressures under a mean pressure and their separation, on the grid doubled by its mirror.

    Polonsky and Keer (1999), DOI 10.1016/S0043-1648(99)00113-1, with complex transforms.
    """
    z = np.block([[z, z[:, ::-1]], [z[::-1], z[::-1, ::-1]]])
    q = 2.0 * np.pi * np.hypot(np.fft.fftfreq(z.shape[0])[:, None], np.fft.fftfreq(z.shape[1]))
    with np.errstate(divide="ignore"):
        kernel = np.where(q > 0.0, 2.0 / q, 0.0)
    p, t, old, restart = np.full(z.shape, pressure), np.zeros(z.shape), 1.0, 0.0
    for _ in range(20_000):
        gap = np.fft.ifft2(kernel * np.fft.fft2(p)).real - z
        inside = p > 0.0
        level = gap[inside].mean()
        gap = gap - level
        square = float(np.sum(gap[inside] ** 2))
        t = np.where(inside, gap + restart * square / old * t, 0.0)
        old = square
        r = np.fft.ifft2(kernel * np.fft.fft2(t)).real
        r -= r[inside].mean()
        step = np.sum(gap[inside] * t[inside]) / np.sum(r[inside] * t[inside])
        p = np.maximum(p - step * t, 0.0)
        overlap = (p == 0.0) & (gap < 0.0)
        restart = 0.0 if overlap.any() else 1.0
        p[overlap] -= step * gap[overlap]
        p *= pressure / p.mean()
        if np.abs(gap[p > 0.0]).max() < tolerance and not (gap[p == 0.0] < -tolerance).any():
            return p, -level
    raise AssertionError("not converged")


def test_a_sphere_is_hertz_and_converges() -> None:
    # What the images of the sphere and the mean displace near it: (N/pi) (-3.900265/L + 9.03362/4
    # r^2/L^3), by Ewald's sums; the square adds to the curvature and, in the mean, to the approach.
    errors = []
    for n in (64, 128, 256):
        x = np.arange(n) - n // 2
        radius = 2.0 * n
        z = -(x[:, None] ** 2 + x**2) / (2.0 * radius)
        top = -float(z.mean())
        space = HalfSpace((n, n), mirrored=False)
        p = press(space, z + top, top - (0.06 * n) ** 2 / radius, tolerance=1e-12 * n)
        load = float(p.sum())
        a = (0.75 * load * radius) ** (1.0 / 3.0)
        image = 9.03362 / 4.0 * load / (math.pi * n**3)
        approach = (0.06 * n) ** 2 / radius + 3.900265 / (math.pi * n) * load - 0.4 * image * a * a
        near = 1.0 / (1.0 / radius + 2.0 * image)
        errors.append(abs(load / (4.0 / 3.0 * math.sqrt(near) * approach**1.5) - 1.0))
        assert float(p.max()) == pytest.approx(1.5 * load / (math.pi * a**2), rel=5e-3)
    assert errors[0] > 1.5 * errors[1] > 2.25 * errors[2]
    assert errors[2] < 3e-4


def test_waves_are_westergaards_and_johnsons() -> None:
    errors = []
    for n in (64, 256):
        x = 2.0 * np.pi * (np.arange(n) + 0.5) / n
        z = np.tile(0.01 * n * np.cos(x), (4, 1))
        space = HalfSpace(z.shape, mirrored=False)
        p = press(space, z, 0.003 * n, tolerance=1e-12 * n)
        full = math.pi * 0.01  # E* pi amplitude / wavelength closes it
        half = math.asin(math.sqrt(float(p.mean()) / full))
        psi = 0.5 * ((x + np.pi) % (2.0 * np.pi) - np.pi)
        root = np.sqrt(np.maximum(math.sin(half) ** 2 - np.sin(psi) ** 2, 0.0))
        errors.append(float(np.mean(np.abs(p[0] - 2.0 * full * np.cos(psi) * root))) / full)
    assert errors[1] < 3e-4
    assert errors[0] > 3.0 * errors[1]
    n = 256
    x = 2.0 * np.pi * np.arange(n) / n
    z = 0.01 * n * np.cos(x)[:, None] * np.cos(x)
    space = HalfSpace(z.shape, mirrored=False)
    full = math.sqrt(2.0) * math.pi * 0.01
    shares = {}
    for d in (0.9, 2e-4):
        p = press(space, z, d * 0.01 * n, tolerance=1e-10 * n)
        shares[d] = float(p.mean()) / full, float(np.mean(p > 0.0))
    load, share = shares[0.9]  # Hertz at light load (Johnson, Greenwood and Higginson 1985)
    assert share == pytest.approx(math.pi * (3.0 / (8.0 * math.pi) * load) ** (2 / 3), rel=0.03)
    load, share = shares[2e-4]  # penny-shaped gaps next to full contact
    assert 1.0 - share == pytest.approx(1.5 / math.pi * (1.0 - load), rel=0.06)


def test_another_solver_finds_the_same_pressures() -> None:
    z = face(48)
    for pressure in (2e-4, 5e-3):
        p, d = polonsky_keer(z, pressure, 1e-11)
        space = HalfSpace(z.shape)
        mine = press(space, z, d, tolerance=1e-12)
        assert float(mine.mean()) == pytest.approx(pressure, rel=1e-8)
        assert np.abs(mine - p[:48, :48]).max() < 1e-8 * p.max()


def test_the_slope_is_that_of_differences_while_the_contact_is_the_same() -> None:
    z = face(32)
    space = HalfSpace(z.shape)
    for d in (1.5, 0.5):
        p = press(space, z, d * z.std(), tolerance=1e-14)
        step = 1e-5
        ends = [press(space, z, d * z.std() + s, p, tolerance=1e-14) for s in (-step, step)]
        assert all(np.array_equal(end > 0.0, p > 0.0) for end in ends)
        slope = (ends[0].mean() - ends[1].mean()) / (2.0 * step)
        grown = closing(space, p > 0.0, tolerance=1e-12)
        assert float(grown.mean()) == pytest.approx(slope, rel=1e-8)


def test_what_has_yielded_is_found_again_and_one_tightening_is_as_good_as_two() -> None:
    z = face(64)
    common = {"hardness": 0.02, "stiffness_ratio": EQUAL, "lightest": 0.2, "loads": 4}
    solution = solve_face([z], pressure=3e-3, **common)
    assert solution.hard > 0.5
    assert solution.pressure[0, 0] == pytest.approx(3e-3, rel=1e-4)
    # By hand: pressed with the bound, flattened, pressed again without it.
    space, d = HalfSpace(z.shape), float(solution.separation[0])
    p = press(space, z, d, hardness=0.02, tolerance=1e-10)
    gap = space.displacement(p) - z + d
    flat = z + np.where(p >= 0.02, np.minimum(gap, 0.0), 0.0)
    again = press(space, flat, d, tolerance=1e-10)
    assert np.abs(again - p).max() < 1e-6 * 0.02
    # Tightened to a third first: the same in the end.
    first = solve_face([z], pressure=1e-3, **common)
    q = press(space, z, float(first.separation[0]), hardness=0.02, tolerance=1e-10)
    gap = space.displacement(q) - z + float(first.separation[0])
    worn = z + np.where(q >= 0.02, np.minimum(gap, 0.0), 0.0)
    second = solve_face([worn], pressure=3e-3, **common)
    for ours, theirs in ((second.separation, solution.separation), (second.slope, solution.slope)):
        assert ours[0] == pytest.approx(theirs[0], rel=5e-3)


@pytest.mark.parametrize(
    ("points", "radius", "depth"), [(128, 100.0, 16.0), (128, 50.0, 40.0), (256, 50.0, 100.0)]
)
def test_one_asperity_beyond_yield(points, radius, depth) -> None:
    """A sphere beyond first yield and relieved, against its closed form.

    Once all of a circle of radius a bears the hardness H, the edge is where it touches, at an
    indentation a^2/2R + 4Ha/(pi E*); relieved by w it bears the integral of 2E*c over w, whose
    radius c is a quarter of an ellipse of half axes a and 2Ha/E* (Abel's transform of the uniform
    pressure).
    """
    hardness = 0.02
    x = np.arange(points) - points // 2
    z = -(x[:, None] ** 2 + x**2) / (2.0 * radius)
    z, top = z - z.mean(), -float(z.mean())
    space = HalfSpace(z.shape, mirrored=False)
    yielding = (0.5 * math.pi * hardness) ** 2 * radius  # p0 = H
    d = top - depth * yielding
    p = press(space, z, d, hardness=hardness, tolerance=1e-9 * points)
    load, contact = float(p.sum()), float(np.count_nonzero(p > 0.0))
    assert load == pytest.approx(hardness * contact, rel=0.015)
    a = math.sqrt(contact / math.pi)
    images = 3.900265 / (math.pi * points)  # how much less they let a load N indent
    indentation = depth * yielding + images * load
    edge = 0.5 * a * a / radius + 4.0 * hardness * a / math.pi
    assert indentation == pytest.approx(edge, rel=0.015)
    gap = space.displacement(p) - z + d
    flat = z + np.where(p >= hardness, np.minimum(gap, 0.0), 0.0)
    stiffness = 1.0 / (1.0 / float(closing(space, p > 0.0).sum()) + images)
    assert stiffness == pytest.approx(2.0 * a, rel=0.015)
    whole, loads = 2.0 * hardness * a, []
    openings = np.linspace(0.1, 0.9, 9) * whole
    for w in openings:
        out = w
        for _ in range(6):
            p = press(space, flat, d + out, p, tolerance=1e-7 * points)
            out = w - images * (load - float(p.sum()))
        loads.append(float(p.sum()) / load)
    t = openings / whole
    exact = 1.0 - 2.0 / math.pi * (t * np.sqrt(1.0 - t * t) + np.arcsin(t))
    assert loads == pytest.approx(exact, abs=0.003)


def test_a_grain_of_dust_far_above_a_face_is_pressed_flat() -> None:
    z = face(48)
    dusty = z.copy()
    dusty[20:22, 30:32] += 60.0 * z.std()
    how = {"pressure": 3e-3, "hardness": 0.02, "lightest": 0.2, "loads": 4}
    how["stiffness_ratio"] = EQUAL
    clean, found = solve_face([z], **how), solve_face([dusty - dusty.mean()], **how)
    assert found.pressure[0, 0] == pytest.approx(3e-3, rel=1e-4)
    assert found.slope[0, 0] == pytest.approx(clean.slope[0, 0], rel=0.1)


def test_pieces_of_a_periodic_face_are_the_face() -> None:
    z = face(32)
    twice = np.block([[z, z[:, ::-1]], [z[::-1], z[::-1, ::-1]]])
    how = {"pressure": 1e-3, "hardness": math.inf, "stiffness_ratio": EQUAL, "lightest": 0.4}
    alone, whole = solve_face([z], **how), solve_face([twice], **how)
    halves = solve_face([twice[:32], twice[32:]], **how)
    for solution in (whole, halves):
        assert solution.pressure.mean(axis=1) == pytest.approx(alone.pressure[:, 0], rel=1e-4)
        assert solution.separation == pytest.approx(alone.separation, rel=1e-4)


def test_a_rectangular_pixel_is_a_stretched_face() -> None:
    z = face(64)
    fine = HalfSpace((64, 64))
    coarse = HalfSpace((32, 64), aspect=2.0)
    loads = [
        float(press(space, heights, 0.8 * z.std(), tolerance=1e-9).mean())
        for space, heights in ((fine, z), (coarse, z[::2]))
    ]
    assert loads[1] == pytest.approx(loads[0], rel=0.05)


def test_the_ratio_of_stiffnesses_includes_shape_and_lay() -> None:
    n = 320  # wide beside the contact: its images pull by a share a/n
    x = np.arange(n) - n / 2 + 0.5
    space = HalfSpace((n, n), mirrored=False)
    circle = sliding(space, np.hypot(x[:, None], x) < 12.0, EQUAL)
    assert circle == pytest.approx(np.eye(2) / EQUAL, rel=0.01, abs=1e-3)
    # An ellipse 4:1 along x. With <cos^2> over the directions, weighted by the radius, one over the
    # tangential stiffness goes with 1 + nu/(1 - nu) <cos^2> (Johnson 1985, section 7.4).
    m = 1.0 - 0.25**2
    along = (special.ellipk(m) - special.ellipe(m)) / (m * special.ellipk(m))
    tensor = sliding(space, (x[:, None] / 5.0) ** 2 + (x / 20.0) ** 2 < 1.0, EQUAL)
    nu = 0.33
    for number, share in ((tensor[0, 0], along), (tensor[1, 1], 1.0 - along)):
        assert 1.0 / number == pytest.approx(1.0 + nu / (1.0 - nu) * share, rel=0.008)
    # Turned by 30 degrees the tensor turns with it.
    c, s = math.cos(math.pi / 6), math.sin(math.pi / 6)
    u, v = c * x + s * x[:, None], -s * x + c * x[:, None]
    turned = sliding(space, (v / 5.0) ** 2 + (u / 20.0) ** 2 < 1.0, EQUAL)
    turn = np.array([[c, -s], [s, c]])
    assert turned == pytest.approx(turn @ tensor @ turn.T, abs=0.01)
