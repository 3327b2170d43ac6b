"""Every public callable that takes numbers, with arguments that it takes."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from usual import JOINT, METAL, PAIR, SURFACE

import microslip as ms

from .structure_entrances import add_structures
from .surface_entrances import add_scans, add_surfaces


class Entrance(NamedTuple):
    """A callable, arguments that it takes, and those of them that are numbers."""

    call: Callable[..., Any]
    arguments: dict[str, Any]
    numeric: tuple[str, ...]


@lru_cache
def entrances() -> dict[str, Entrance]:
    """Every public callable that takes numbers."""
    al, pair, surface, joint = METAL, PAIR, SURFACE, JOINT
    separation = np.linspace(0.0, 1e-6, 11)
    table = ms.TabulatedNormalLaw(pair, separation, 1e3 * (1.0 - separation / 1e-6) ** 2)
    laws = {
        "joint": joint,
        "Coulomb": ms.Coulomb(100.0),
        "Jenkins": ms.Jenkins(1e8, 100.0),
        "Iwan": ms.Iwan([1e8, 2e8], [10.0, 20.0]),
        "Segalman": ms.SegalmanIwan(100.0, 1e8, -0.5, 1.0),
        "sphere": ms.Interface(ms.SphereOnFlat(pair, 5e-3), 0.5, 10.0),
        "table": ms.Interface(table, 0.5, 500.0),
    }
    found: dict[str, Entrance] = {}

    def add(name: str, call: Callable[..., Any], _free: tuple[str, ...] = (), **given: Any) -> None:
        numeric = tuple(key for key in given if key not in _free)
        found[name] = Entrance(call, given, numeric)

    add("Material", ms.Material, young_modulus=69e9, poisson_ratio=0.33, hardness=1e9)
    add("MaterialPair", ms.MaterialPair, first=al, second=al)
    add("Gaussian", ms.Gaussian, std=5e-7, mean=0.0)
    add("Exponential", ms.Exponential, scale=5e-7)
    add("Discrete", ms.Discrete, values=[0.0, 1e-7])
    add("GreenwoodWilliamson", ms.GreenwoodWilliamson, pair=pair, heights=ms.Gaussian(5e-7),
        radius=1e-3, density=1e8, area=2e-4)  # fmt: skip
    add("AsperityPopulation", ms.AsperityPopulation, pair=pair, heights=[0.0, 1e-7], radii=1e-3)
    add("SphereOnFlat", ms.SphereOnFlat, pair=pair, radius=5e-3)
    add("TabulatedNormalLaw", ms.TabulatedNormalLaw, pair=pair, separation=[0.0, 1e-6, 2e-6],
        load=[3.0, 1.0, 0.0])  # fmt: skip
    add("Interface", ms.Interface, surface=surface, friction_coefficient=0.5, normal_load=100.0)
    add("Interface at d", ms.Interface, surface=surface, friction_coefficient=0.5, separation=1e-7)
    add("Interface.at", joint.at, normal_load=100.0)
    add("Coulomb", ms.Coulomb, force_limit=1.0)
    add("Jenkins", ms.Jenkins, stiffness=1e8, force_limit=1.0)
    add("Iwan", ms.Iwan, stiffnesses=[1e8, 2e8], force_limits=[1.0, 2.0])
    add("SegalmanIwan", ms.SegalmanIwan, force_limit=1.0, stiffness=1e8, chi=-0.5, beta=1.0)
    add("Asperity", ms.Asperity, pair=pair, radius=1e-3, normal_load=1.0, friction_coefficient=0.5)
    add("Loop", ms.Loop, displacement=[1.0, 2.0, 1.0, 0.0], force=[0.0, 1.0, 2.0, 1.0])
    for name in ("load", "stiffness", "contact_count", "contact_area", "contact_probability"):
        add(f"surface.{name}", getattr(surface, name), separation=1e-7)
    add("surface.separation", surface.separation, load=100.0)
    for name, law in laws.items():
        for method in ("backbone", "backbone_stiffness"):
            add(f"{name}.{method}", getattr(law, method), displacement=1e-7)
        add(f"{name}.force", law.force, displacement=[1e-7, -1e-7])
        add(f"{name}.periodic", law.periodic, displacement_cycle=[1e-7, -1e-7])
        add(f"{name}.loop", law.loop, amplitude=1e-7, samples=16)
        add(f"{name}.advance", law.start().advance, displacement=[1e-7])
        add(f"{name}.try_", law.start().try_, displacement=1e-7)
        for method in ("dissipated_energy", "energy_ratio", "loss_factor", "damping_ratio",
                       "secant_stiffness", "dissipation_exponent"):  # fmt: skip
            add(f"{name}.{method}", getattr(law, method), amplitude=1e-7)
        if name == "Coulomb":
            continue
        add(f"{name}.backbone_displacement", law.backbone_displacement, force=0.1)
        add(f"{name}.displacement", law.displacement, force=[0.1, -0.1])
        add(f"{name}.loss_factor of force", law.loss_factor, force_amplitude=0.1)
        add(f"{name}.to_iwan", law.to_iwan, cells=10)
    add("joint.stick_area", joint.stick_area, displacement=1e-7)
    add("joint.coupled_force", joint.coupled_force, displacement=[1e-7, 0.0],
        normal_load=[1e3, 2e3])  # fmt: skip
    add("joint.coupled_response", joint.coupled_response, displacement=[1e-7, 0.0],
        separation=[3e-7, 2e-7])  # fmt: skip
    add("joint.try_ with a load", joint.start().try_, displacement=1e-7, normal_load=1e3)
    add("Oscillator", ms.Oscillator, joint=joint, mass=1.0, stiffness=1e6,
        viscous_damping_ratio=0.01)  # fmt: skip
    _add_motion(add, laws)
    _add_fields(add, surface, joint)
    add_structures(add, surface, joint)
    add_surfaces(add, surface, joint)
    add_scans(add, pair)
    _add_records(add, joint)
    return found


Add = Callable[..., None]


def _add_motion(add: Add, laws: dict[str, Any]) -> None:
    """Settled cycles, harmonics, trials and heights."""
    joint = laws["joint"]
    for name, law in laws.items():
        add(f"{name}.periodic from rest", law.periodic, displacement_cycle=[1e-7, -1e-7], rest=1e-8)
        add(f"{name}.harmonics", law.harmonics, coefficients=[1e-8, 1e-7, 0.0], harmonics=[0, 1],
            rest=0.0, rtol=1e-8)  # fmt: skip
        cycle = law.periodic([2e-7, -1e-7, 1e-7])
        add(f"{name}.periodic.derivative", cycle.derivative, directions=np.eye(3))
    add("joint.periodic, separation varies", joint.periodic, displacement_cycle=[1e-7, -1e-7],
        separation=[3e-7, 2e-7])  # fmt: skip
    add("joint.harmonics, separation varies", joint.harmonics, coefficients=[0.0, 1e-7, 0.0],
        separation=[3e-7, 1e-8, 0.0])  # fmt: skip
    beside = ms.Parallel([ms.Coulomb(1.0), joint])  # rigid friction is integrated by itself
    add("Parallel.harmonics", beside.harmonics, coefficients=[1e-8, 1e-7, 0.0], harmonics=[0, 1],
        rest=0.0, rtol=1e-8)  # fmt: skip
    add("joint.try_ with a separation", joint.start().try_, displacement=1e-7, separation=3e-7)
    add("joint.advance with a load", joint.start().advance, displacement=[1e-7], normal_load=[1e3])
    add("joint.start", joint.start, depth=8)
    _add_options(add, joint)
    add("Parallel", ms.Parallel, laws=[joint, laws["Jenkins"]])
    add("TabulatedHeights", ms.TabulatedHeights, height=[0.0, 1e-6, 2e-6], density=[0.0, 1e6, 0.0])
    for heights in (ms.Gaussian(5e-7), ms.TabulatedHeights([0.0, 1e-6, 2e-6], [0.0, 1e6, 0.0])):
        kind = type(heights).__name__
        add(f"{kind}.pdf", heights.pdf, height=1e-7)
        add(f"{kind}.cdf", heights.cdf, height=1e-7)
        add(f"{kind}.partial_moment", heights.partial_moment, order=1.5, threshold=1e-7)


def _add_options(add: Add, joint: Any) -> None:
    """Arguments of which a call takes one or the other, and what comes of cycles."""
    two = {"displacement": [1e-7, 0.0]}
    add("joint.coupled_force at d", joint.coupled_force, **two, separation=[3e-7, 2e-7])
    add("joint.coupled_response of forces", joint.coupled_response, force=[1.0, 0.0],
        normal_load=[1e3, 2e3])  # fmt: skip
    add("joint.advance with a separation", joint.start().advance, displacement=[1e-7],
        separation=[3e-7])  # fmt: skip
    for method in ("dissipated_energy", "energy_ratio", "damping_ratio", "secant_stiffness",
                   "dissipation_exponent"):  # fmt: skip
        for law in (joint, ms.SegalmanIwan(100.0, 1e8, -0.5, 1.0)):
            add(f"{type(law).__name__}.{method} of force", getattr(law, method),
                force_amplitude=0.1)  # fmt: skip
    add("joint.to_iwan over a range", joint.to_iwan, cells=10, smallest_amplitude=1e-8,
        largest_amplitude=1e-6)  # fmt: skip
    add("Sliders.density", joint.sliders().density, yield_displacement=1e-7)
    cycle = joint.periodic([1e-7, -1e-7, 0.0], separation=[3e-7, 2e-7, 3e-7])
    add("CoupledCycle.derivative", cycle.derivative, displacement=[0.0, 1.0, 0.0],
        separation=[1.0, 0.0, 0.0])  # fmt: skip


def _add_fields(add: Add, surface: Any, joint: Any) -> None:
    """Fields of nodes, and two directions."""
    one = np.full(3, 1e-5)
    add("JointField", ms.JointField, surface=surface, friction_coefficient=0.3, areas=one,
        loads=one * 1e7, surface_area=2e-4)  # fmt: skip
    for name, value in (("pressures", 1e7), ("separations", 1e-7), ("gaps", 1e-7)):
        add(f"JointField of {name}", ms.JointField, surface=surface, friction_coefficient=0.3,
            areas=one, **{name: np.full(3, value)})  # fmt: skip
    field = ms.JointField(surface, 0.3, areas=one, loads=one * 1e7)
    moves, apart = np.full(3, 1e-8), np.full(3, 2e-7)
    cycle, gaps = np.outer(moves, [1.0, -1.0, 0.5]), np.outer(apart, [1.0, 1.1, 1.0])
    add("field.at", field.at, separations=apart)
    add("field.along", field.along, directions=np.full((3, 2), 0.7))
    add("field.load", field.load, separations=apart)
    add("field.dissipated_energy", field.dissipated_energy, amplitude=moves)
    add("field.periodic", field.periodic, displacements=cycle)
    add("field.periodic, it opens", field.periodic, displacements=cycle, separations=gaps)
    add("field.harmonics", field.harmonics, coefficients=cycle, harmonics=[0, 1], samples=16)
    add("field.harmonics, it opens", field.harmonics, coefficients=cycle, separations=gaps)
    add("field.try_", field.start().try_, displacement=moves)
    add("field.try_, it opens", field.start().try_, displacement=moves, separations=apart)
    add("field.two_directions", field.two_directions, sliders=16, nearest=1e-9)
    add("field.start", field.start, depth=8)
    plane = field.two_directions(16)
    add("plane.try_", plane.start().try_, displacement=np.full((3, 2), 1e-8), separations=apart)
    add("plane.periodic", plane.periodic, displacements=np.stack([cycle, cycle], axis=-1),
        separations=gaps)  # fmt: skip
    add("IsotropicJoint", ms.IsotropicJoint, joint=joint, sliders=16, smallest_amplitude=1e-9,
        largest_amplitude=1e-6)  # fmt: skip
    turning = ms.IsotropicJoint(joint, 16)
    path = 1e-7 * np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
    add("turning.try_", turning.start().try_, displacement=[1e-8, 2e-8])
    add("turning.force", turning.force, displacement=path)
    add("turning.periodic", turning.periodic, displacement_cycle=path, tolerance=1e-6)
    add("turning.harmonics", turning.harmonics, coefficients=np.full((2, 3), 1e-8), samples=16,
        tolerance=1e-6)  # fmt: skip
    add("turning.start", turning.start, ("energies",), energies=True)
    add("VectorCycle.derivative", turning.periodic(path).derivative, directions=path)
    add("FieldCycle.derivative", field.periodic(cycle, gaps).derivative, displacements=cycle,
        separations=gaps)  # fmt: skip
    add("field.at loads", field.at, loads=np.full(3, 100.0))
    add("field.periodic from rest", field.periodic, displacements=cycle, rest=0.0)
    add("field.harmonics from rest", field.harmonics, coefficients=cycle, rest=0.0)
    add("plane.harmonics", plane.harmonics, coefficients=np.stack([cycle, cycle], axis=1),
        separations=gaps, samples=16, tolerance=1e-6)  # fmt: skip
    add("plane.periodic, tolerance", plane.periodic, tolerance=1e-6,
        displacements=np.stack([cycle, cycle], axis=-1))  # fmt: skip


def _add_records(add: Add, joint: Any) -> None:
    """Records and scans, and what is read from them."""
    rig = ms.VirtualTribometer(ms.Jenkins(1e8, 100.0), sample_rate=64.0)
    record = rig.record(amplitude=2e-6, frequency=1.0, cycles=4)
    x, force = record.displacement, record.force
    add("Record", ms.Record, displacement=x, force=force, time=np.arange(x.size) / 64.0)
    add("Record at a rate", ms.Record, displacement=x, force=force, sample_rate=64.0,
        normal_load=np.full(x.size, 9.0))  # fmt: skip
    add("measure", ms.measure, record=record, rig_stiffness=1e9, confidence=0.9)
    add("VirtualTribometer", ms.VirtualTribometer, joint=joint, rig_stiffness=1e9, load_ripple=0.01,
        ripple_phase=0.1, third_harmonic=0.01, sample_rate=100.0, seed=1)  # fmt: skip
    add("VirtualTribometer.record", rig.record, amplitude=1e-6, frequency=1.0, cycles=2)
    add("identify", ms.identify, records=record, rig_stiffness=(1e12, 1e10))
    add("compare", ms.compare, records=record, laws=["jenkins"])
    add("measure, folded", ms.measure, record=record, confidence=0.9)
    add("VirtualTribometer with noise", ms.VirtualTribometer, joint=joint, noise=0.01,
        sample_rate=100.0)  # fmt: skip
    loaded = ms.Record(
        displacement=x, force=force, sample_rate=64.0, normal_load=np.full(x.size, 9.0)
    )
    found = ms.identify(loaded)
    add("identify an interface", ms.identify, ("pair",), records=loaded, pair=joint.surface.pair,
        area=1e-4)  # fmt: skip
    for quantity in (
        "force", "dissipated_energy", "damping_ratio", "loss_factor", "secant_stiffness",
    ):  # fmt: skip
        add(f"Identification.{quantity}", getattr(found, quantity), amplitude=[0.5e-6],
            normal_load=9.0)  # fmt: skip
    for quantity in ("stiffness_at", "force_limit_at", "law_at"):
        add(f"Identification.{quantity}", getattr(found, quantity), normal_load=9.0)
    add("Identification.interface", found.interface, ("pair",), pair=joint.surface.pair, area=1e-4)
    add("SliderLaw", ms.SliderLaw, yield_displacements=[1e-7, 1e-6], stiffnesses=[1e7, 2e7],
        smallest_amplitude=1e-8, largest_amplitude=1e-6)  # fmt: skip
    _add_evaluations(add, joint)


def _add_evaluations(add: Add, joint: Any) -> None:
    """Many joints at once."""
    named = {"young_modulus": 69e9, "poisson_ratio": 0.33, "std": 5e-7, "radius": 1e-3,
             "density": 1e8, "area": 2e-4, "friction_coefficient": 0.5}  # fmt: skip
    add("evaluate", ms.evaluate, **named, mean=0.0, normal_load=[1e3, 2e3], amplitude=1e-7,
        other_young_modulus=2e11, other_poisson_ratio=0.3)  # fmt: skip
    add("evaluate at d", ms.evaluate, **named, separation=1e-7, force_amplitude=[1.0, 2.0])
    add("evaluate of a surface", ms.evaluate, ("surface",), surface=joint.surface,
        friction_coefficient=0.5, normal_load=1e3, amplitude=1e-7)  # fmt: skip
