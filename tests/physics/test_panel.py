"""Curved panels from their drawing: the strip's elements, and solid ones beside them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy import linalg
from usual import rough

import microslip as ms
from microslip.structures.geometry import Sizes, Strip

STEEL = ms.Material(206e9, 0.3)
SIZES = Sizes(0.3, 0.1, 1.5e-3, 1.1e-3)


def test_forces_of_a_strip_are_derivatives_of_its_energy() -> None:
    """Membrane and bending energy by quadrature of cubic and linear shapes, without matrices."""
    strip, count = Strip(SIZES, STEEL, count=6), 6
    h = SIZES.length / count
    stiff = 206e9 / (1.0 - 0.09) * SIZES.width * SIZES.thickness
    points, shares = np.polynomial.legendre.leggauss(6)
    s, shares = 0.5 + 0.5 * points, 0.5 * h * shares
    slopes = np.stack([(6 * s**2 - 6 * s) / h, 3 * s**2 - 4 * s + 1,
                       (6 * s - 6 * s**2) / h, 3 * s**2 - 2 * s])  # fmt: skip
    curves = np.stack([(12 * s - 6) / h**2, (6 * s - 4) / h, (6 - 12 * s) / h**2, (6 * s - 2) / h])
    x0 = h * np.arange(count + 1)
    shape = np.stack(
        [0.5 * SIZES.rise * (1.0 - np.cos(2.0 * math.pi * x0 / SIZES.length)),
         math.pi * SIZES.rise / SIZES.length * np.sin(2.0 * math.pi * x0 / SIZES.length)], axis=1
    )  # fmt: skip

    def energy(x: np.ndarray) -> float:
        d = np.zeros(3 * (count + 1))
        d[strip.free] = x
        nodes, total = d.reshape(-1, 3), 0.0
        for k in range(count):
            w, w0 = nodes[k : k + 2, 1:].ravel(), shape[k : k + 2].ravel()
            turn, turn0 = w @ slopes, w0 @ slopes
            # An element's membrane strain is its mean, as shallow beams have it.
            strain = (nodes[k + 1, 0] - nodes[k, 0]) / h
            strain += shares @ (turn0 * turn + 0.5 * turn**2) / h
            total += 0.5 * stiff * h * strain**2
            total += 0.5 * stiff * SIZES.thickness**2 / 12.0 * (shares @ (w @ curves) ** 2)
        return float(total)

    x = 1e-4 * np.random.default_rng(3).normal(size=strip.free.size)
    x[strip.free % 3 == 2] *= 20.0
    force, tangent = strip.forces(x)
    for k, step in enumerate(1e-5 * np.eye(x.size)):
        slope = (energy(x + step) - energy(x - step)) / 2e-5
        assert slope == pytest.approx(force[k], rel=1e-6, abs=1e-6 * np.abs(force).max())
        row = (strip.forces(x + step)[0] - strip.forces(x - step)[0]) / 2e-5
        np.testing.assert_allclose(row, tangent[k], rtol=1e-5, atol=1e-6 * np.abs(tangent).max())


def test_a_flat_strip_bends_as_closed_forms_have_it() -> None:
    """Clamped under an even load: 384 EI/L^3 at the middle, 720 EI/L^3 in the mean."""
    strip = Strip(SIZES._replace(rise=0.0), STEEL)
    bending = 206e9 / 0.91 * 0.1 * 1.5e-3**3 / 12.0
    axial = 206e9 / 0.91 * 0.1 * 1.5e-3
    force = strip.forces_at(np.array([1e-9, 2e-9]))
    assert force[0] == pytest.approx(720.0 * bending / 0.3**3 * 1e-9, rel=1e-4)
    assert force[1] == pytest.approx(axial / 0.3 * 2e-9, rel=1e-6)
    # Stretched by a deflection of the form 16 s^2 (1 - s)^2 w, ends held: mean of w'^2/2 is
    # 1024/420 w^2/L^2, and its tension bears on the mean as a cable does, to first order.
    middle = 3e-5
    mean = 8.0 / 15.0 * middle
    pull = axial * 1024.0 / 420.0 * middle**2 / 0.3**2
    cable = pull * 1024.0 / 210.0 / 0.3 * middle * 15.0 / 8.0
    far, near = (strip.forces_at(np.array([share * mean, 0.0])) for share in (1.0, 1e-3))
    assert far[1] == pytest.approx(pull, rel=1e-3)
    assert far[0] - 1e3 * near[0] == pytest.approx(cable, rel=1e-2)


def drawing(rise: float, left: float = -0.165, ground: Any = ("left", "right")) -> ms.BoltedBeam:
    """A narrow one, a bolt an end."""
    bolts = ms.Bolts([0.0], shank=0.008, hole=0.009, washer=0.016, tension=18e3)
    laps = [ms.Lap(x, 0.03, bolts) for x in (left, 0.165)]
    return ms.BoltedBeam(length=0.36, width=0.03, thickness=1.5e-3, laps=laps, rise=rise,
                         style="single-lap", ground=ground)  # fmt: skip


def panel(rise: float) -> ms.ReducedJoint:
    """The same, reduced, with what it bears as it bends."""
    beam = drawing(rise)
    bending = beam.bending(STEEL, 1e-3)
    joint = beam.reduce(STEEL, 7800.0, (3, 1), element_size=0.03, sensors=bending.sensors)
    return joint.with_geometry(*bending)


@pytest.mark.slow
def test_a_drawn_rise_stiffens_solid_elements_as_it_does_the_strip_s() -> None:
    surface = rough(ms.Gaussian(std=1e-6), ms.MaterialPair(STEEL, STEEL), 1e-3)
    seen, told = [], []
    for rise in (0.0, SIZES.rise):
        joint = panel(rise)
        seen.append(joint.tightened(surface, 0.5).linear_modes(1).frequency[0])
        strip = Strip(SIZES._replace(width=0.03, rise=rise), STEEL)
        told.append(math.sqrt(strip.forces_at(np.array([1e-9, 0.0]))[0]))
    assert seen[1] / seen[0] == pytest.approx(told[1] / told[0], rel=0.01)
    assert seen[1] / seen[0] > 1.25
    with pytest.raises(ms.InputError, match="weights must be of the shape"):
        joint.with_geometry(["bend 1"], (np.ones((9, 1)), np.ones((9, 1))), np.ones((2, 1)))


def test_drawings_that_do_not_bend_between_clamps_are_refused() -> None:
    with pytest.raises(ms.InputError, match="two laps and ground on the left and on the right"):
        drawing(0.0, -0.1, "right").bending(STEEL)
    with pytest.raises(ms.InputError, match="rise must be"):
        drawing(-1e-3)


ARCH = Sizes(0.4, 0.1, 1.5e-3, 2.62e-3)


def mass_of(strip: Strip, count: int) -> np.ndarray:
    """Consistent, of straight and of cubic shapes [kg]."""
    h, heavy = ARCH.length / count, 7800.0 * ARCH.width * ARCH.thickness
    along = heavy * h / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
    across = heavy * h / 420.0 * np.array(
        [[156, 22 * h, 54, -13 * h], [22 * h, 4 * h * h, 13 * h, -3 * h * h],
         [54, 13 * h, 156, -22 * h], [-13 * h, -3 * h * h, -22 * h, 4 * h * h]]
    )  # fmt: skip
    mass = np.zeros((3 * count + 3, 3 * count + 3))
    for k in range(count):
        ends, turns = 3 * k + np.array([0, 3]), 3 * k + np.array([1, 2, 4, 5])
        mass[np.ix_(ends, ends)] += along
        mass[np.ix_(turns, turns)] += across
    return mass[np.ix_(strip.free, strip.free)]


def as_its_mode(strip: Strip, mass: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
    """The first mode with both ends held as a coordinate, scaled to the mean deflection."""
    even, end = strip.coordinates.T
    inner = end == 0.0
    mode, pulled = np.zeros(end.size), np.ones(end.size)
    cut = np.ix_(inner, inner)
    mode[inner] = linalg.eigh(stiffness[cut], mass[cut])[1][:, 0]
    pulled[inner] = -np.linalg.solve(stiffness[cut], stiffness[np.ix_(inner, ~inner)])[:, 0]
    along = mass @ mode
    along -= end * (pulled @ along)
    return np.stack([along * (even @ mode) / (along @ mode), end], axis=1)


@pytest.mark.slow
def test_a_released_arch_decays_along_its_modal_curve() -> None:
    """All its von Karman elements in time, a joint at its end with memory, let go at 0.8 mm.

    Modes beside the first have 5 % of damping: what the start excites in them is gone at once.
    """
    count, sensed = 8, np.linspace(2.5e-4, 8.8e-4, 12)
    strip = Strip(ARCH, STEEL, count)
    mass, stiffness = mass_of(strip, count), strip.forces(np.zeros(strip.free.size))[1]
    surface = rough(ms.Gaussian(std=1e-6), ms.MaterialPair(STEEL, STEEL), 1e-3)
    joint, end = ms.Interface(surface, 0.3, normal_load=9e3), strip.coordinates[:, 1]
    stuck = stiffness + joint.tangential_stiffness * np.outer(end, end)
    squares, shapes = linalg.eigh(stuck, mass)
    ratios = np.append(0.0046, np.full(squares.size - 1, 0.05))
    dashpots = mass @ shapes @ np.diag(2.0 * ratios * np.sqrt(squares)) @ shapes.T @ mass
    middle = np.zeros(squares.size)
    middle[np.flatnonzero(strip.free == 3 * (count // 2) + 1)] = 1.0
    strip.coordinates = as_its_mode(strip, mass, stiffness)
    curve = (
        ms.Structure(mass, stiffness, dashpots)
        .attach(joint, directions=end)
        .with_geometry(strip.coordinates, cases=strip.cases(1.2e-3))
        .modes(0, sensed, at=middle)
    )
    assert curve.frequency[-1] / curve.linear_frequency < 0.95

    # Bent by forces along the mode until the middle is where it is let go.
    x, push, along = np.zeros(squares.size), 0.0, mass @ shapes[:, 0]
    along *= np.sign(shapes[:, 0] @ middle)
    for share in np.linspace(0.1, 1.0, 10):
        for _ in range(20):
            force, tangent = strip.forces(x)
            u = float(end @ x)
            force = force + math.copysign(float(joint.backbone(abs(u))), u) * end
            tangent = tangent + float(joint.backbone_stiffness(abs(u))) * np.outer(end, end)
            system = np.block([[tangent, -along[:, None]], [middle, np.zeros(1)]])
            gap = np.append(force - push * along, middle @ x - share * 8e-4)
            step = np.linalg.solve(system, -gap)
            x, push = x + step[:-1], push + step[-1]
    state, inverse = joint.start(), np.linalg.inv(mass)
    state.try_(float(end @ x))
    state.commit()
    first, h = math.sqrt(squares[0]), 1.5 / math.sqrt(squares[-1])
    period = round(2.0 * math.pi / first / h)
    v, seen, drag = np.zeros(x.size), np.empty(16 * period), inverse @ dashpots
    for k in range(seen.size):
        pull = float(state.try_(float(end @ x))[0])
        state.commit()
        v = v - h * (inverse @ (strip.forces(x)[0] + pull * end) + drag @ v)
        x = x + h * v
        seen[k] = middle @ x

    # The fundamental by demodulation, averaged over a period three times.
    time = h * np.arange(seen.size)
    turning = 2.0 * seen * np.exp(-1j * first * time)
    for _ in range(3):
        total = np.cumsum(np.insert(turning, 0, 0.0))
        turning = (total[period:] - total[:-period]) / period
        time = time[: turning.size] + 0.5 * period * h
    fit = np.polynomial.Polynomial.fit
    size, phase = fit(time, np.log(np.abs(turning)), 4), fit(time, np.unwrap(np.angle(turning)), 5)
    at = np.linspace(time[0], time[-1], 12)[1:-1]
    amplitude, omega = np.exp(size(at)), first + phase.deriv()(at)
    told = -size.deriv()(at) / omega
    readings = 2.0 * math.pi * curve.frequency, curve.decay_damping_ratio, curve.damping_ratio
    swing, free, steady = (np.interp(amplitude, sensed, values) for values in readings)
    np.testing.assert_allclose(swing, omega, rtol=1e-3)
    np.testing.assert_allclose(free, told, rtol=0.012)
    assert (steady / told - 1.0).min() < -0.05


@pytest.mark.slow
def test_a_panel_softens_as_was_published() -> None:
    """From its drawing: a free decay of full elements at four amplitudes, to 1.3 and 4.5 %.

    Rise and free length are chosen, for the first and the last frequency. Published by Krack et al.
    (2025, DOI 10.1016/j.ymssp.2024.112016).
    """
    steel = ms.Material(206e9, 0.3, hardness=2e9)
    surface = ms.DrawnFace(
        ms.MaterialPair(steel, steel), rms=1.6e-6, slope=0.041, area=1e-4, tightening_pressure=1e4
    )
    row = [(0.0, y) for y in (-0.033, 0.0, 0.033)]
    bolts = ms.Bolts(row, size="M8", tension=12e3)
    sheet = ms.BoltedBeam(
        length=0.35, width=0.1, thickness=1.5e-3, rise=0.98e-3, style="single-lap",
        ground=["left", "right"], laps=[ms.Lap(-0.16, 0.03, bolts), ms.Lap(0.16, 0.03, bolts)],
    )  # fmt: skip
    bending = sheet.bending(steel)
    sensors = {**bending.sensors, "middle": ((0.0, 0.0, 1.75e-3), "z")}
    joint = sheet.reduce(steel, 7800.0, (6, 3), element_size=0.025, sensors=sensors)
    joint = joint.with_geometry(*bending)
    places = np.geomspace(2e-5, 1.4e-3, 9)
    state = joint.tightened(surface, 0.3)
    curve = state.modes(0, places, at=joint.sensor("middle"), damping_ratio=0.0046)
    at, seen = np.log([2e-5, 2.3e-4, 7.7e-4, 1.4e-3]), np.log(places)
    frequency = np.interp(at, seen, curve.frequency)
    np.testing.assert_allclose(frequency, [110.9, 110.3, 107.1, 103.2], rtol=0.013)
    np.testing.assert_allclose(frequency, [110.77, 110.17, 105.84, 104.18], rtol=1e-3)
    damping = 100.0 * np.interp(at, seen, curve.decay_damping_ratio)
    np.testing.assert_allclose(damping, [0.46, 0.484, 0.511, 0.526], rtol=0.045)
    np.testing.assert_allclose(damping, [0.4606, 0.4709, 0.4980, 0.5047], rtol=0.005)
