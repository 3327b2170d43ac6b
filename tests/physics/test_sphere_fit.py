"""A sphere on a flat, and a surface that is known, as laws to fit, by records of Mindlin's law."""

from __future__ import annotations

import numpy as np
import pytest
from laboratory.physics import motion, respond, sampled, sphere

import microslip as ms
from microslip.identification.models import model_of

STEEL = ms.Material(210e9, 0.3)
PAIR = ms.MaterialPair(STEEL, STEEL)
RADIUS, FRICTION, RIG = 0.01, 0.6, 5e7


def record(load: float, amplitude: float, seed: int) -> ms.Record:
    """Ten cycles behind a rig, 180.3 samples each."""
    rng = np.random.default_rng(seed)
    deep = (0.75 * load / (PAIR.composite_modulus * RADIUS**0.5)) ** (2.0 / 3.0)
    x = motion(10, amplitude)
    force = respond(x, sphere(FRICTION, load, FRICTION * PAIR.stiffness_ratio * deep, RIG))
    x, force = sampled(x, 180.3), sampled(force, 180.3)
    return ms.Record(
        x + 1e-9 * rng.normal(size=x.size),
        force + 0.002 * FRICTION * load * rng.normal(size=x.size),
        normal_load=load,
        sample_rate=1803.0,
    )


def records() -> list[ms.Record]:
    """Two loads, partial and gross slip."""
    design = ((200.0, 4e-6), (200.0, 8e-6), (800.0, 12e-6), (800.0, 25e-6))
    return [record(load, amplitude, i) for i, (load, amplitude) in enumerate(design)]


def test_a_sphere_has_its_friction_radius_and_rig() -> None:
    found = ms.identify(records(), "sphere", pair=PAIR, held_back=0)
    assert found.reduced_chi_squared < 1.2
    truth = {"friction_coefficient": FRICTION, "rig_stiffness": RIG, "radius": RADIUS}
    for name, value in truth.items():
        number = found.parameters.get(name) or found.derived[name]
        assert number.verdict == "identified"
        half = 0.5 * (number.high - number.low)
        assert number.low - half < value < number.high + half
        assert half < 0.02 * value
    joint = found.joint(normal_load=400.0)
    assert joint.surface.radius == pytest.approx(RADIUS, rel=0.02)


def test_a_surface_that_is_known_leaves_friction_and_rig() -> None:
    surface = ms.SphereOnFlat(PAIR, RADIUS)
    found = ms.identify(records(), "given-surface", surface=surface, held_back=0)
    assert set(found.parameters) == {"friction_coefficient", "rig_stiffness"}
    assert found.parameters["friction_coefficient"].value == pytest.approx(FRICTION, rel=1e-3)
    assert found.parameters["rig_stiffness"].value == pytest.approx(RIG, rel=2e-3)
    with pytest.raises(ms.InputError, match="needs surface"):
        ms.identify(records()[:1], "given-surface")


def test_force_limits_without_sliding_are_extrapolated() -> None:
    found = ms.identify([record(200.0, a, 9) for a in (1.5e-6, 2e-6)], "sphere", held_back=0)
    friction = found.parameters["friction_coefficient"]
    assert friction.verdict in ("extrapolated", "not identified")


@pytest.mark.parametrize("name", ["sphere", "given-surface"])
def test_derivatives(name: str) -> None:
    """Against central differences, and against the interface itself."""
    surface = ms.SphereOnFlat(PAIR, RADIUS)
    model = model_of(name, **({"surface": surface} if name != "sphere" else {}))
    joint = ms.Interface(surface, FRICTION, normal_load=300.0)
    values = {"friction_coefficient": FRICTION}
    if name == "sphere":
        values["slip_limit"] = -joint.slip_per_indentation * joint.separation
    limit = -joint.slip_per_indentation * joint.separation
    u = limit * np.array([0.01, 0.3, 0.9, 1.5])
    force, slope, by = model.branch(u, values, 300.0)  # type: ignore[attr-defined]
    assert force == pytest.approx(np.asarray(joint.backbone(u)), rel=1e-12)
    assert slope == pytest.approx(np.asarray(joint.backbone_stiffness(u)), rel=1e-9, abs=1e-3)
    for row, key in zip(by, values, strict=True):
        step = 1e-6 * values[key]
        up, down = (
            model.branch(u, {**values, key: values[key] + way * step}, 300.0)[0]  # type: ignore[attr-defined]
            for way in (1.0, -1.0)
        )
        assert row == pytest.approx((up - down) / (2.0 * step), rel=1e-6, abs=1e-6 * abs(row).max())
