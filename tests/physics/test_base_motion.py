"""Structures on moving bases against integration in time of all degrees of freedom."""

from __future__ import annotations

import functools
import math
import subprocess
import sys

import numpy as np
import pytest
from usual import JOINT, SLIP, SPRING

import microslip as ms

MASS = np.array([2.0, 3.0, 2.0])
FREE = SPRING * np.array(
    [[1.0, -1.0, 0.0, 0.0, 0.0], [-1.0, 2.0, -1.0, 0.0, 0.0], [0.0, -1.0, 2.0, -1.0, 0.0],
     [0.0, 0.0, -1.0, 2.0, -1.0], [0.0, 0.0, 0.0, -1.0, 1.0]]
)  # fmt: skip
"""Support, three masses, support."""
ALL = np.array([1.0, *MASS, 1.0])
BETWEEN = np.array([0.0, 1.0, -1.0, 0.0, 0.0])
BESIDE = np.array([0.0, 0.0, 0.0, 1.0, -1.0])
SHARE = 2e-7  # of the stiffness, in the damping
HARMONICS = [1, 2, 3, 5, 7, 9]


@functools.cache
def between_supports() -> ms.Structure:
    """Joints between two masses, and between the last one and its support."""
    whole = ms.Structure(np.diag(ALL), FREE, SHARE * FREE)
    return whole.attach(JOINT, directions=np.stack([BETWEEN, BESIDE], axis=1))


def settled(
    supports: dict[int, complex], omega: float, periods: int, steps: int
) -> tuple[np.ndarray, np.ndarray]:
    """First harmonics of absolute motions and of the supports' reactions, by Newmark's method.

    In absolute coordinates, with the joints' own states; Richardson's extrapolation is left to the
    caller.
    """
    held = np.array(sorted(supports))
    free = np.setdiff1d(np.arange(5), held)
    amplitude = np.array([supports[place] for place in held])
    h = 2.0 * math.pi / omega / steps
    damping = SHARE * FREE
    sides = [BETWEEN, BESIDE]
    states = [JOINT.start() for _ in sides]
    x, v, a = np.zeros((3, 5))
    at = np.exp(1j * omega * h * np.arange(periods * steps + 1))

    def base(i: int) -> None:
        grown = min(1.0, i / (20.0 * steps))
        x[held] = grown * (-amplitude * at[i] / omega**2).real
        v[held] = grown * (amplitude * at[i] / (1j * omega)).real
        a[held] = grown * (amplitude * at[i]).real

    fixed = np.diag(ALL) + 0.5 * h * damping + 0.25 * h * h * FREE
    motion, reaction = np.zeros((steps, 5)), np.zeros((steps, held.size))
    for i in range(1, periods * steps + 1):
        drift, speed = x + h * v + 0.25 * h * h * a, v + 0.5 * h * a
        new = a.copy()
        base(i)
        new[held] = a[held]
        place, fast = x[held].copy(), v[held].copy()
        for _ in range(30):
            here, rate = drift + 0.25 * h * h * new, speed + 0.5 * h * new
            here[held], rate[held] = place, fast
            trials = [
                state.try_(float(side @ here)) for state, side in zip(states, sides, strict=True)
            ]
            force = sum(side * float(t[0]) for side, t in zip(sides, trials, strict=True))
            gap = ALL * new + damping @ rate + FREE @ here + force
            tangent = fixed + sum(
                0.25 * h * h * float(t[1]) * np.outer(side, side)
                for side, t in zip(sides, trials, strict=True)
            )
            change = np.linalg.solve(tangent[np.ix_(free, free)], gap[free])
            new[free] -= change
            if np.abs(change).max() <= 1e-12 * np.abs(new).max():
                break
        x, v, a = here, rate, new
        for state in states:
            state.commit()
        if i > (periods - 1) * steps:
            motion[i - (periods - 1) * steps - 1] = x
            reaction[i - (periods - 1) * steps - 1] = gap[held]
    turn = np.exp(-1j * omega * h * np.arange(1, steps + 1)) * 2.0 / steps
    return turn @ motion, turn @ reaction


def held_matrix() -> np.ndarray:
    """Stiffness of the three masses with joints that stick and supports that stand."""
    joints = JOINT.tangential_stiffness * sum(np.outer(b, b) for b in (BETWEEN, BESIDE))
    return (FREE + joints)[1:4, 1:4]


def first_mode() -> float:
    """Angular frequency of the held structure."""
    return math.sqrt(np.linalg.eigvalsh(held_matrix() / np.sqrt(np.outer(MASS, MASS)))[0])


@pytest.mark.slow
@pytest.mark.parametrize("apart", [False, True])
def test_motions_on_a_base_are_what_integration_settles_at(apart: bool) -> None:
    """One rigid base, and two supports in different phase: motions, and the supports' forces.

    The joints slip by 0.5 to 2.7 of their scales.
    """
    omega = 0.97 * first_mode()
    inputs = np.array([60.0, 40.0j if apart else 60.0])
    response = between_supports().base_response(
        directions=np.eye(2), acceleration=inputs, supports=[0, 4],
        frequencies=np.array([0.999, 1.0]) * omega / (2.0 * math.pi),
        harmonics=HARMONICS, samples=256,
    )  # fmt: skip
    point = np.flatnonzero(response.requested)[-1]
    first = response.harmonics.index(1)
    coarse, fine = (settled({0: inputs[0], 4: inputs[1]}, omega, 60, n) for n in (128, 256))
    motion, force = ((4.0 * f - c) / 3.0 for c, f in zip(coarse, fine, strict=True))
    assert 0.4 < abs(BETWEEN @ motion) / SLIP < abs(BESIDE @ motion) / SLIP
    seen = response.absolute_displacement[point, :, first]
    assert np.abs(seen - motion).max() < 3e-4 * np.abs(motion).max()
    np.testing.assert_allclose(response.base_force[point, :, first], force, rtol=3e-4)


def on_one_base() -> ms.Structure:
    """The same, of degrees of freedom that count from the base."""
    inner = slice(1, 4)
    held = ms.Structure(np.diag(MASS), FREE[inner, inner], SHARE * FREE[inner, inner])
    return held.attach(JOINT, directions=np.stack([BETWEEN[inner], BESIDE[inner]], axis=1))


def test_a_rigid_base_is_two_supports_that_move_as_one() -> None:
    """But for the mass of the supports themselves."""
    frequencies = np.array([0.95, 1.0]) * first_mode() / (2.0 * math.pi)
    options = {"acceleration": 30.0, "frequencies": frequencies}
    two = between_supports().base_response(directions=[1.0, 1.0], supports=[0, 4], **options)
    one = on_one_base().base_response(directions=np.ones(3), joints_on_base=True, **options)
    np.testing.assert_allclose(two.displacement[:, 1:4], one.displacement, rtol=1e-9, atol=1e-18)
    last, first = [0.0, 0.0, 1.0], one.harmonics.index(1)
    np.testing.assert_allclose(
        two.transmissibility([0.0, *last, 0.0]), one.transmissibility(last), rtol=1e-9
    )
    supports = two.base_force[:, 0, first] - 2.0 * two.base_acceleration[:, 0]
    np.testing.assert_allclose(supports, one.base_force[:, 0, first], rtol=1e-9)


def test_the_peak_on_a_base_is_that_of_the_modal_curve_in_closed_form() -> None:
    """|shape^T M R| a = 2 zeta omega^2 q."""
    structure = on_one_base()
    curve = structure.modes(0, np.geomspace(1e-7, 3e-5, 12))
    middle = 8
    shape, omega = curve.shape[middle], 2.0 * math.pi * curve.frequency[middle]
    push = abs(shape.conj() @ (MASS * np.ones(3)))
    q = curve.modal_amplitude[middle]
    level = 2.0 * curve.damping_ratio[middle] * omega**2 * q / push
    response = structure.base_response(
        directions=np.ones(3), acceleration=level, joints_on_base=True,
        frequencies=np.linspace(0.98, 1.02, 41) * curve.frequency[middle],
    )  # fmt: skip
    first = response.displacement[:, :, response.harmonics.index(1)]
    peak = np.sqrt(np.max(np.abs(first) ** 2 @ MASS))
    assert curve.damping_ratio[middle] > 2.0 * curve.damping_ratio[0]  # friction, not C
    assert peak == pytest.approx(q, rel=0.01)


def test_a_sensor_is_held_by_the_level_of_the_base() -> None:
    """And at each point the motion is that under this level, found from the base's side."""
    structure = on_one_base()
    at = [0.0, 0.0, 1.0]
    middle = first_mode() / (2.0 * math.pi)
    options = {"directions": np.ones(3), "joints_on_base": True}
    held = structure.base_response(
        **options, acceleration=1.0, control="response", at=at, level=2000.0,
        frequencies=np.linspace(0.85, 1.1, 31) * middle,
    )  # fmt: skip
    assert held.status == "solved"
    assert not held.turning_points.size
    omega = 2.0 * math.pi * held.frequency
    absolute = held.absolute_displacement[:, :, held.harmonics.index(1)] @ at
    np.testing.assert_allclose(abs(absolute) * omega**2, 2000.0, rtol=1e-9)
    least = int(np.argmin(np.abs(held.base_acceleration[:, 0])))
    for place in (0, least, held.frequency.size - 1):
        level = held.base_acceleration[place, 0].real
        again = structure.base_response(
            **options, acceleration=level, frequencies=held.frequency[place] * np.array([0.98, 1.0])
        )
        point = np.flatnonzero(again.requested)[-1]
        np.testing.assert_allclose(
            again.displacement[point], held.displacement[place], rtol=1e-6, atol=1e-12
        )


def test_incomplete_bases_are_refused() -> None:
    structure, whole = on_one_base(), between_supports()
    options = {"acceleration": 1.0, "frequencies": [100.0, 200.0]}
    for words, other in (
        ("must not deform joints", {"directions": np.ones(3)}),
        (r"shape \(3,\) or", {"directions": np.ones(4)}),
        (r"column \(0,\) is all zeros", {"directions": np.zeros(3)}),
        ("control must be", {"directions": np.ones(3), "control": "sensor"}),
        ("needs the sensor", {"directions": np.ones(3), "control": "response"}),
        ("at and level belong", {"directions": np.ones(3), "level": 1.0}),
        ("acceleration must be one", {"directions": np.ones(3), "acceleration": [1.0, 2.0]}),
    ):
        allowed = words != "must not deform joints"
        with pytest.raises(ms.InputError, match=words):
            structure.base_response(**{**options, "joints_on_base": allowed, **other})
    for words, other in (
        ("supports must be different", {"supports": [0, 0]}),
        ("supports must be different", {"supports": [0, 9]}),
        (r"shape \(2,\) or", {"supports": [0, 4], "directions": [1.0]}),
    ):
        with pytest.raises(ms.InputError, match=words):
            whole.base_response(**{**options, "directions": [1.0, 1.0], **other})


def test_dashpots_need_a_frame() -> None:
    """Proportional to the mass they resist rigid motion; the ground takes up what they pull."""
    stiffness = np.array([[2e6, -1e6], [-1e6, 1e6]])
    mass = np.diag([1.0, 2.0])
    structure = ms.Structure(mass, stiffness, 3.0 * mass + 1e-5 * stiffness)
    frequency = np.array([99.0, 100.0])
    options = {"directions": [1.0, 1.0], "acceleration": 1.0, "frequencies": frequency}
    omega = 2.0 * math.pi * 100.0
    for frame in ("base", "ground"):
        seen = structure.base_response(**options, damping_frame=frame).absolute_displacement
        dynamic = stiffness - omega**2 * mass + 1j * omega * (3.0 * mass + 1e-5 * stiffness)
        # Absolute coordinates: the base pulls by stiffness and by the dashpots that stand on it.
        pull = stiffness + 1j * omega * (
            1e-5 * stiffness + (3.0 * mass if frame == "base" else 0.0)
        )
        expected = np.linalg.solve(dynamic, pull @ np.full(2, -1.0 / omega**2))
        np.testing.assert_allclose(seen[-1, :, 1], expected, rtol=1e-9)


def test_what_lasts_on_a_base_is_reported_of_every_point() -> None:
    """A softening spring, its fundamental alone: 246 points with one fold, held by base or sensor.

    A motion of square s lasts where the base's level rises with it and the mean is held: in closed
    form d/ds [s (g^2 + (omega d)^2)] > 0, g = k + 3/4 c s - omega^2, and k + 3/2 c s > 0.
    """
    stiffness, cubic, dashpot = 4e4, -6e9, 2.0
    spring = ms.Structure([[1.0]], [[stiffness]], [[dashpot]])
    soft = spring.with_geometry([1.0], quartic=np.full((1,) * 4, 0.25 * cubic))
    on = {"directions": [1.0], "damping_frame": "base", "harmonics": [1]}
    frequencies = np.linspace(34.0, 28.0, 61)
    swept = soft.base_response(**on, acceleration=0.2, frequencies=frequencies)
    held = [
        soft.base_response(**on, acceleration=1.0, frequencies=frequencies, control="response",
                           at=[1.0], level=level)
        for level in (20.0, 40.0)
    ]  # fmt: skip
    assert swept.turning_points.size == 2
    for response in (swept, *held):
        omega = 2.0 * math.pi * response.frequency
        s = np.abs(response.displacement[:, 0, response.harmonics.index(1)]) ** 2
        g = stiffness + 0.75 * cubic * s - omega**2
        rises = g**2 + (omega * dashpot) ** 2 + 1.5 * cubic * s * g > 0.0
        lasts = rises & (stiffness + 1.5 * cubic * s > 0.0)
        assert 3 < (~lasts).sum() < 40
        np.testing.assert_array_equal(response.stable, lasts)


def test_motions_on_a_base_are_those_under_its_inertia_force() -> None:
    """By the inertia that the base means, the motions are those under a force, folds and all."""
    free = on_one_base()
    soft = free.with_geometry([1.0, 0.0, 0.0], quartic=np.full((1,) * 4, -1e20))
    frequencies = np.linspace(1.0, 0.93, 71) * first_mode() / (2.0 * math.pi)
    options = {"frequencies": frequencies, "harmonics": [0, 1, 2, 3]}
    base = soft.base_response(
        directions=np.ones(3), acceleration=20.0, joints_on_base=True, **options
    )
    force = soft.forced_response(-20.0 * MASS, **options)
    np.testing.assert_array_equal(base.stable, force.stable)
    np.testing.assert_allclose(base.frequency, force.frequency, rtol=1e-9)
    assert (~base.stable).sum() > 8


LARGE = """
import numpy as np
import scipy.sparse as sp
import microslip as ms

def chain(n):
    return sp.diags([-np.ones(n - 1), 2.0 * np.ones(n), -np.ones(n - 1)], [-1, 0, 1])

sizes = (12, 12, 278)
lines = [sp.identity(n) for n in sizes]
k = sum(1e7 * sp.kron(sp.kron(*(chain(n) if i == a else lines[i] for i, n in
        list(enumerate(sizes))[:2])), chain(sizes[2]) if a == 2 else lines[2]) for a in range(3))
n = k.shape[0]
part = ms.Structure(1e-3 * sp.identity(n, format="csc"), k.tocsc(), 1e-7 * k.tocsc())
law = ms.Iwan([2e6] * 4, np.geomspace(0.1, 3.0, 4))
for a, b in ((5000, 5001), (20000, 20012)):
    line = np.zeros(n)
    line[[a, b]] = 1.0, -1.0
    part = part.attach(law, directions=line)
rest = part.preload()
f = rest.linear_modes(1).frequency[0]
at, on = np.eye(1, n, 20000)[0], {"directions": np.ones(n)}
swept = rest.base_response(acceleration=5.0, frequencies=f * np.linspace(0.9, 1.1, 40), **on)
noise = rest.random_response(([0.5 * f, 3.0 * f], [1.0, 1.0]), **on)
shock = rest.shock(ms.Pulse.half_sine(100.0, 0.5 / f), duration=18.0 / f, **on)
assert swept.status == noise.status == shock.status == "solved"
assert shock.time.size > 3500
print(n, swept.amplitude(at).max(), noise.standard_deviation(at), shock.peak(at))
print(next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM")))
"""


@pytest.mark.slow
def test_long_runs_of_forty_thousand_degrees_of_freedom_stay_below_a_gigabyte() -> None:
    """A sweep, noise, and 3600 steps of a shock, all motions of which are a gigabyte."""
    run = subprocess.run([sys.executable, "-c", LARGE], capture_output=True, text=True, check=True)
    assert int(run.stdout.split()[-1]) < 1_000_000  # kB
