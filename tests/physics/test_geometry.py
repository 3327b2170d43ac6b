"""Geometry that stiffens or softens, against periods in closed form and integration in time."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest
from scipy import optimize, special

import microslip as ms


@pytest.mark.parametrize("hardening", [3.0, -0.4])
def test_a_cubic_spring_swings_as_elliptic_functions_have_it(hardening: float) -> None:
    """x'' + x + h x^3 = 0 from the turning point A: T = 4 K(m)/sqrt(1 + h A^2)."""
    stiffness = 4e4
    structure = ms.Structure([[1.0]], [[stiffness]])
    bent = structure.with_geometry([1.0], quartic=np.full((1,) * 4, 0.25 * hardening * stiffness))
    curve = bent.modes(0, [0.5, 0.9], harmonics=[1, 3, 5, 7, 9])
    for i, fundamental in enumerate(curve.modal_amplitude):

        def solution(a: float) -> tuple[float, float]:
            root = 1.0 + hardening * a * a
            m = 0.5 * hardening * a * a / root
            omega = math.sqrt(stiffness * root)
            period = 4.0 * special.ellipk(m) / omega
            phase = 2.0 * math.pi * np.arange(256) / 256
            u = omega * period * np.arange(256) / 256
            if m < 0.0:  # by Jacobi's imaginary transformation
                _, cn, dn, _ = special.ellipj(u * math.sqrt(1.0 - m), -m / (1.0 - m))
                motion = a * cn / dn
            else:
                motion = a * special.ellipj(u, m)[1]
            return 2.0 * float(motion @ np.cos(phase)) / 256, 1.0 / period

        tip = optimize.brentq(
            lambda a, f=fundamental, s=solution: s(a)[0] - f, 0.5 * fundamental, 1.15
        )
        assert curve.frequency[i] == pytest.approx(solution(tip)[1], rel=1e-6)


COUPLED = 3e9
"""Of both coordinates: like an arch's, softening first by its square, then stiffening."""


def arch_forces(z: np.ndarray) -> np.ndarray:
    """Beyond the linear ones: gradient of C [(z0^2/2 - h z0 + z1^2)^2 - h^2 z0^2] / 2, h 1 mm."""
    h, stretch = 1e-3, 0.5 * z[0] ** 2 - 1e-3 * z[0] + z[1] ** 2
    return COUPLED * np.array([stretch * (z[0] - h) - h * h * z[0], 2.0 * stretch * z[1]])


MASS = np.diag([1.0, 1.2, 0.8])
STIFFNESS = np.diag([4e5, 9e5, 3e5])
ACROSS = np.array([0.0, 0.02, 1.0])
PLACES = np.eye(3)[:, :2]


@functools.cache
def arch() -> ms.Structure:
    """Two bending coordinates, and a third degree of freedom with a joint, tied to both."""
    tied = STIFFNESS + 2e5 * np.outer([1.0, 0.3, -1.0], [1.0, 0.3, -1.0])
    soft = ms.Iwan(np.full(30, 1e4), np.geomspace(0.02, 6.0, 30))
    held = ms.Structure(MASS, tied).attach(soft, directions=ACROSS)
    steps = 1.2e-3 * np.linspace(-1.0, 1.0, 5)
    z = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    return held.with_geometry(PLACES, cases=(z, [arch_forces(row) for row in z]))


def spring_forces(structure: ms.Structure, z: np.ndarray) -> np.ndarray:
    springs = structure.attachments[-1]
    return np.stack(
        [springs.columns @ springs.static_forces(row @ springs.columns)[0] for row in z]
    )


def test_a_potential_is_found_in_cases_and_as_tensors() -> None:
    """Forces of the springs are those of the function, in between and with either sign."""
    z = np.random.default_rng(0).uniform(-1e-3, 1e-3, (40, 3))
    force = spring_forces(arch(), z)
    wanted = np.stack([arch_forces(row[:2]) for row in z])
    np.testing.assert_allclose(force[:, :2], wanted, atol=1e-9 * np.abs(wanted).max())
    cubic, quartic = np.zeros((2,) * 3), np.zeros((2,) * 4)
    # C [(z0^4/8 + z1^4/2 + z0^2 z1^2/2) - h z0^3/2 - h z0 z1^2]
    cubic[0, 0, 0] = -0.5e-3 * COUPLED
    for place in ((0, 1, 1), (1, 0, 1), (1, 1, 0)):
        cubic[place] = -1e-3 * COUPLED / 3.0
    quartic[0, 0, 0, 0], quartic[1, 1, 1, 1] = COUPLED / 8.0, COUPLED / 2.0
    for place in (
        (0, 0, 1, 1),
        (0, 1, 0, 1),
        (0, 1, 1, 0),
        (1, 0, 0, 1),
        (1, 0, 1, 0),
        (1, 1, 0, 0),
    ):
        quartic[place] = 0.5 * COUPLED / 6.0
    same = ms.Structure(MASS, STIFFNESS).with_geometry(PLACES, cubic=cubic, quartic=quartic)
    springs = same.attachments[-1]
    by_tensor = np.stack(
        [springs.columns @ springs.static_forces(z_ @ springs.columns)[0] for z_ in z]
    )
    np.testing.assert_allclose(by_tensor[:, :2], wanted, atol=1e-9 * np.abs(wanted).max())
    rows = np.random.default_rng(2).uniform(-1e-3, 1e-3, (30, 2))
    total = np.stack([arch_forces(row) + STIFFNESS[:2, :2] @ row for row in rows])
    fitted = (
        ms.Structure(MASS, STIFFNESS).with_geometry(PLACES, cases=(rows, total)).attachments[-1]
    )
    by_case = np.stack([fitted.columns @ fitted.static_forces(z_ @ fitted.columns)[0] for z_ in z])
    np.testing.assert_allclose(by_case[:, :2], wanted, atol=1e-6 * np.abs(wanted).max())


def test_an_arch_with_a_joint_rings_on_its_modal_curve() -> None:
    """A motion in time, damped less by what the mode loses, keeps frequency and amplitude.

    The forces in time are those of the function, not of the springs.
    """
    amplitude = 4e-4
    curve = arch().modes(0, [amplitude])
    omega, zeta = 2.0 * math.pi * curve.frequency[0], curve.damping_ratio[0]
    assert abs(curve.frequency[0] / curve.linear_frequency - 1.0) > 0.01
    (law, column) = (arch().attachments[0].law, arch().attachments[0].columns[:, 0])
    linear = np.asarray(arch().stiffness)

    def forces(x: np.ndarray, pull: float) -> np.ndarray:
        return linear @ x + pull * column + PLACES @ arch_forces(x[:2])

    steps, periods = 512, 12  # other modes grow with time
    h = 2.0 * math.pi / omega / steps
    x = amplitude * curve.shape[0].real
    v = np.zeros(3)
    state = law.start()
    path = np.empty((steps * periods, 3))
    drag = 2.0 * zeta * omega  # given back, as the extended periodic motion has it
    for i in range(len(path)):
        a = np.linalg.solve(MASS, -forces(x, state.try_(float(column @ x))[0])) + drag * v
        state.commit()
        v += h * a  # symplectic: kicks and drifts
        x = x + h * v
        path[i] = x
    late = path[-8 * steps :]
    crossing = np.flatnonzero(
        (late[:-1, 0] < late[:, 0].mean()) & (late[1:, 0] >= late[:, 0].mean())
    )
    mean = late[:, 0].mean()
    times = crossing + (mean - late[crossing, 0]) / (late[crossing + 1, 0] - late[crossing, 0])
    frequency = 1.0 / (np.diff(times).mean() * h)
    late = late[crossing[0] : crossing[-1]]
    turn = np.exp(-2j * math.pi * frequency * h * np.arange(len(late)))
    first = 2.0 / len(late) * (turn @ (late - late.mean(axis=0)))
    size = math.sqrt(float((first.conj() @ MASS @ first).real))
    there = arch().modes(0, [size])
    # What grows or falls in ten periods is what the mode's ratio is wrong by: 2 %.
    assert size == pytest.approx(amplitude, rel=0.02 * zeta * 2.0 * math.pi * 8.0)
    assert frequency == pytest.approx(there.frequency[0], rel=1e-3)


def test_geometries_that_say_too_little_are_refused() -> None:
    structure = ms.Structure(MASS, STIFFNESS)
    lopsided = np.zeros((2,) * 3)
    lopsided[0, 0, 1] = 1.0
    few = np.eye(2) * 1e-3
    around = np.random.default_rng(1).uniform(-1.0, 1.0, (40, 2))
    swirl = np.stack([-(around[:, 1] ** 3), around[:, 0] ** 3], axis=1)
    for words, options in (
        ("needs either tensors", {}),
        ("must be symmetric in all its indices", {"cubic": lopsided}),
        ("must have the shape", {"quartic": np.zeros((2, 2))}),
        ("must determine all 12 coefficients", {"cases": (few, few)}),
        ("must follow one potential", {"cases": (around, swirl)}),
        ("of shape", {"cases": (few, np.zeros((3, 2)))}),
    ):
        with pytest.raises(ms.InputError, match=words):
            structure.with_geometry(PLACES, **options)
    with pytest.raises(ms.InputError, match="at most 6"):
        ms.Structure(np.eye(8), np.eye(8)).with_geometry(
            np.eye(8)[:, :7], quartic=np.zeros((7,) * 4)
        )
    with pytest.raises(ms.InputError, match="within the static cases"):
        arch().modes(0, [3e-3])


def test_a_stiffening_spring_in_noise_has_its_exact_deviation() -> None:
    """In white noise p(x) is proportional to exp(-V(x)/var(x')), var(x') = G/(4 c) (Caughey)."""
    stiffness, dashpot, quartic, level = 4e4, 8.0, 2.5e9, 0.5
    plate = ms.Structure([[1.0]], [[stiffness]], [[dashpot]])
    bent = plate.with_geometry([1.0], quartic=np.full((1,) * 4, quartic))
    noise = ([2.0, 400.0], [level, level])
    speed = level / (4.0 * dashpot)
    x = np.linspace(-8e-3, 8e-3, 4001)
    weight = np.exp(-(0.5 * stiffness * x**2 + quartic * x**4) / speed)
    exact = math.sqrt((weight @ x**2) / weight.sum())
    assert exact < 0.92 * math.sqrt(speed / stiffness)  # the linear one
    answer = bent.random_response(noise, directions=[1.0], damping_frame="base")
    assert answer.standard_deviation([1.0]) == pytest.approx(exact, rel=0.02)


def test_no_motion_leaves_the_static_cases_unseen() -> None:
    z = np.linspace(-1e-3, 1e-3, 9)
    plate = ms.Structure([[1.0]], [[4e4]], [[8.0]])
    bent = plate.with_geometry([1.0], cases=(z, 4e4 * z + 1e10 * z**3))
    on = {"directions": [1.0], "damping_frame": "base"}
    frequencies, time = np.linspace(20.0, 45.0, 11), np.arange(0.0, 0.1, 1e-4)
    for leave in (
        lambda s: bent.base_response(**on, acceleration=s, frequencies=frequencies),
        lambda s: bent.forced_response([s], frequencies),
        lambda s: bent.random_response(([2.0, 400.0], [s, s]), **on),
        lambda s: bent.shock(ms.Pulse.half_sine(30.0 * s, 0.01), **on),
        lambda s: bent.integrate(lambda t: [30.0 * s], time),
    ):
        leave(0.05)
        with pytest.raises(ms.InputError, match="within the static cases"):
            leave(40.0)
