"""Callables on structures, their solvers, drawings and modal tests, with their arguments."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from laps import DENSITY, STEEL, fork, small_joint, small_lap

import microslip as ms

Add = Callable[..., None]


def add_structures(add: Add, surface: Any, joint: Any) -> None:
    """Structures, their solvers, drawings, tests and readings of signals."""
    mass = np.diag([2.0, 3.0, 2.0])
    stiff = 1e7 * np.array([[3.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    law, between = ms.Jenkins(5e6, 100.0), np.array([1.0, -1.0, 0.0])
    add("Structure", ms.Structure, mass=mass, stiffness=stiff, damping=1e-5 * stiff)
    bare = ms.Structure(mass, stiff)
    add("Structure.attach", bare.attach, joint=law, directions=between)
    field = ms.JointField(surface, 0.3, areas=[1e-5], gaps=[0.0])
    add("Structure.attach a field", bare.attach, joint=field, directions=np.eye(3)[:, None, :])
    chain = bare.attach(law, directions=between)
    add("Structure.preload", chain.preload, static_force=[0.0, 1.0, 0.0])
    add("Structure.linear_modes", chain.linear_modes, count=2)
    add("Structure.modes", chain.modes, index=0, amplitudes=[1e-6, 1e-5], harmonics=[1, 3],
        samples=32, at=[0.0, 0.0, 1.0], damping_ratio=1e-3)  # fmt: skip
    add("Structure.modes, quasi-static", chain.modes, ("method",), index=0, amplitudes=[1e-6],
        method="quasi-static")  # fmt: skip
    add("Structure.forced_response", chain.forced_response, force=[0.0, 0.0, 1.0],
        frequencies=[100.0, 120.0], harmonics=[1], samples=16)  # fmt: skip
    time = np.arange(400) * 2e-5
    add("Structure.integrate", chain.integrate, force=np.zeros((400, 3)), time=time,
        displacement=[0.0, 0.0, 1e-6], spectral_radius=0.9)  # fmt: skip
    signal = np.exp(-30.0 * time) * np.cos(1e4 * time)
    add("read_decay", ms.read_decay, time=time, signal=signal)
    add("ModalTest", ms.ModalTest, amplitude=[1e-6, 2e-6], frequency=[100.0, 99.0],
        damping_ratio=[1e-3, 2e-3], mode=0, frequency_error=0.01, damping_error=0.1)  # fmt: skip
    add("ModalTest.from_ring_down", ms.ModalTest.from_ring_down, time=time,
        signal=signal, points=4)  # fmt: skip
    bolts = {"positions": [0.0], "shank": 6e-3, "hole": 6.6e-3, "washer": 12e-3}
    add("Bolts", ms.Bolts, **bolts, tension=5e3)
    add("Bolts of a torque", ms.Bolts, **bolts, torque=10.0, thread=6e-3, nut_factor=0.2)
    add("LapJoint", ms.LapJoint, length=0.2, width=0.02, thickness=0.012, lap=0.03,
        bolts=ms.Bolts(**bolts, tension=5e3))  # fmt: skip
    oscillator = ms.Oscillator(mass=1.0, stiffness=1e6, joint=joint)
    for method in ("frequency", "damping_ratio"):
        add(f"Oscillator.{method}", getattr(oscillator, method), amplitude=1e-7)
    add("Oscillator.ring_down", oscillator.ring_down, amplitude=1e-7, cycles=3,
        samples_per_cycle=20)  # fmt: skip
    slow = np.arange(2000) * 2e-4
    test = ms.ModalTest([1e-6, 2e-6, 4e-6], [100.0, 99.0, 98.0], [1e-3, 2e-3, 3e-3], sensor="tip")
    add("ModalTest.from_ring_down in a band", ms.ModalTest.from_ring_down, time=slow,
        signal=np.exp(-3.0 * slow) * np.cos(1e3 * slow), points=4, band=(100.0, 250.0))  # fmt: skip
    preload = chain.preload([0.0, 1.0, 0.0])
    add("Preload.linear_modes", preload.linear_modes, count=2)
    add("Preload.modes", preload.modes, ("method",), index=0, amplitudes=[1e-6], harmonics=[1],
        samples=16, at=[0.0, 0.0, 1.0], damping_ratio=1e-3, method="quasi-static")  # fmt: skip
    add("Preload.forced_response", preload.forced_response, force=[0.0, 0.0, 1.0],
        frequencies=[100.0, 120.0], harmonics=[1], samples=16)  # fmt: skip
    add("Preload.integrate", preload.integrate, force=np.zeros((400, 3)), time=time,
        displacement=[0.0, 0.0, 1e-6], velocity=np.zeros(3), spectral_radius=0.9)  # fmt: skip
    base = {"directions": np.ones(3), "acceleration": 1.0, "frequencies": [100.0, 120.0]}
    add("Preload.base_response", preload.base_response, ("acceleration",), **base, samples=16)
    shaken = preload.base_response(**base, samples=16)
    add("BaseResponse.transmissibility", shaken.transmissibility, at=[0.0, 0.0, 1.0])
    noise = np.array([[50.0, 500.0], [1e-2, 1e-2]])
    damped = ms.Structure(mass, stiff, 1e-5 * stiff).attach(law, directions=between)
    resting = damped.preload([0.0, 1.0, 0.0])
    add("Preload.random_response", resting.random_response, psd=noise, directions=np.ones(3))
    random = resting.random_response(noise, directions=np.ones(3))
    for method in ("peak", "standard_deviation"):
        more = {"duration": 10.0} if method == "peak" else {}
        add(f"RandomResponse.{method}", getattr(random, method), at=[0.0, 0.0, 1.0], **more)
    add("RandomResponse.spectrum", random.spectrum, at=[0.0, 0.0, 1.0], frequencies=[60.0, 90.0])
    add("Pulse", ms.Pulse, time=[0.0, 1e-3, 2e-3], acceleration=[0.0, 10.0, 0.0])
    add("Pulse.half_sine", ms.Pulse.half_sine, amplitude=10.0, duration=2e-3)
    pulse = ms.Pulse.half_sine(10.0, 2e-3)
    add("Preload.shock", preload.shock, ("pulse",), pulse=pulse, directions=np.ones(3),
        duration=4e-3, damping_ratio=1e-3)  # fmt: skip
    shock = preload.shock(pulse, directions=np.ones(3), duration=4e-3)
    add("ShockResponse.history", shock.history, at=[0.0, 0.0, 1.0])
    add("ShockResponse.peak", shock.peak, at=[0.0, 0.0, 1.0])
    add("Structure.with_geometry", chain.with_geometry, coordinates=[[0.0], [0.0], [1.0]],
        cubic=[[[0.0]]], quartic=[[[[1e12]]]])  # fmt: skip
    forced = chain.forced_response([0.0, 0.0, 1.0], [100.0, 120.0], harmonics=[1], samples=16)
    add("ForcedResponse.amplitude", forced.amplitude, at=[0.0, 0.0, 1.0])
    add("ForcedResponse.frequency_response", forced.frequency_response, at=[0.0, 0.0, 1.0],
        force=1.0)  # fmt: skip
    add("Oscillator.ring_down of a time", oscillator.ring_down, amplitude=1e-7, duration=0.01,
        samples_per_cycle=20)  # fmt: skip
    _add_drawings(add, surface, test)


def _add_drawings(add: Add, surface: Any, test: ms.ModalTest) -> None:
    """Lap joints from their drawing, what is reduced from them, and fits to tests of them."""
    bolts = {"positions": [0.0], "shank": 6e-3, "hole": 6.6e-3, "washer": 12e-3}
    add("Bolts of a thread", ms.Bolts, **bolts, torque=10.0, thread=6e-3, pitch=1e-3,
        thread_friction=0.12, bearing_friction=0.12, head=10e-3, washer_thickness=1e-3,
        mass=0.01)  # fmt: skip
    lap, joint = small_lap(), small_joint()
    sizes = {"material": STEEL, "density": DENSITY, "element_size": 0.04}
    free = ("material",)
    add("LapJoint.mesh", lap.mesh, free, **sizes)
    add(
        "LapJoint.reduce",
        lap.reduce,
        (*free, "element_size"),
        **sizes,
        patches=(2, 1),
        kept_modes=4,
    )
    one = ms.Bolts(**bolts, tension=5e3)
    add("Bolts.fixing_mass", one.fixing_mass, density=7850.0)
    add("Lap", ms.Lap, at=0.0, length=0.03, bolts=one)
    sides = [ms.Lap(-0.05, 0.03, one), ms.Lap(0.05, 0.03, one)]
    add("BoltedBeam", ms.BoltedBeam, length=0.2, width=0.02, thickness=0.012, laps=sides)
    row = ms.BoltedBeam(length=0.2, width=0.02, thickness=0.012, laps=sides)
    add("BoltedBeam.mesh", row.mesh, free, **sizes)
    add("BoltedBeam.reduce", row.reduce, (*free, "element_size"), **sizes, patches=(2, 1),
        kept_modes=4)  # fmt: skip
    panel = ms.BoltedBeam(length=0.13, width=0.02, thickness=1e-3, laps=sides, rise=1e-3,
                          ground=["left", "right"])  # fmt: skip
    add("BoltedBeam.bending", panel.bending, free, material=STEEL, reach=1e-3)
    meshed = ms.MeshedJoint(fork(2, 2), (1e3,))
    add("MeshedJoint.reduce", meshed.reduce, patches=(2, 1), kept_modes=4, along=[1.0, 0.0, 0.0])
    add("MeshedJoint.shank_sections", meshed.shank_sections, along=[1.0, 0.0, 0.0])
    add("ReducedJoint.field", joint.field, ("surface",), surface=surface, friction_coefficient=0.3)
    add("ReducedJoint.tightened", joint.tightened, ("surface",), surface=surface,
        friction_coefficient=0.3)  # fmt: skip
    add("ReducedJoint.with_form", joint.with_form, form=np.zeros(6), factor=1.0)
    grounded = replace(
        joint,
        base_inertia=np.concatenate([np.zeros((joint.size, 3)), np.eye(3)]),
        sensor_base=np.zeros((len(joint.sensor_names), 3)),
    )
    add("ReducedJoint.on_base", grounded.on_base, ("surface",), surface=surface,
        friction_coefficient=0.3, damping_ratio=1e-3)  # fmt: skip
    add("ReducedJoint.base", grounded.base, ("direction",), direction="z")
    places = np.linspace(-1e-4, 1e-4, 5)[:, None]
    add("ReducedJoint.with_geometry", joint.with_geometry, ("sensors",),
        sensors=joint.sensor_names[:1], cases=(places, 1e13 * places**3),
        weights=[[1.0]])  # fmt: skip
    add("ReducedJoint.scaled", joint.scaled, stiffness=1.1, mass=0.9)
    add("ReducedJoint.with_tension", joint.with_tension, tension=[4e3])
    size = joint.mass.shape[0]
    add("ReducedJoint.tensions", joint.tensions, displacement=np.zeros(size),
        static_force=np.zeros(size))  # fmt: skip
    add("identify_modal", ms.identify_modal, ("joint", "surface", "tests", "fit"), joint=joint,
        surface=surface, tests=test, fit=("friction_coefficient",), friction_coefficient=0.3,
        tension=1.0, form=1.0, base_damping_ratio=1e-3)  # fmt: skip
