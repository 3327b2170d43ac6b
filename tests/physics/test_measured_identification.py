"""Loops of friction computed point by point, from which an identification gets mu back.

The face is doubled by its mirror, as the law has it; its frictional contact knows no law.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from physics.test_measured_friction import FRICTION, Contact, periodic_face, slipped

import microslip as ms
from microslip.contact.boundary_elements import HalfSpace, press

PIXEL, AREA, STEPS, CYCLES = 2e-6, 1e-4, 48, 6
STEEL = ms.Material(210e9, 0.3)
PAIR = ms.MaterialPair(STEEL, STEEL)
MODULUS = PAIR.composite_modulus
PRESSURE, HARDNESS = 0.003, 0.02


def levelled(z: np.ndarray) -> np.ndarray:
    """Heights about their least-squares plane."""
    rows, columns = np.indices(z.shape)
    plane = np.stack([np.ones(z.size), rows.ravel(), columns.ravel()], axis=1)
    return z - (plane @ np.linalg.lstsq(plane, z.ravel(), rcond=None)[0]).reshape(z.shape)


def loops(z: np.ndarray, amplitudes: list[list[float]], shares: list[float]) -> list[ms.Record]:
    """Records of the doubled face [pixels], yielded, at shares of the tightening load."""
    both = np.block([[z, z[:, ::-1]], [z[::-1], z[::-1, ::-1]]])
    space, rms = HalfSpace(both.shape, mirrored=False), float(both.std())
    rng, unit, records = np.random.default_rng(1), MODULUS * AREA, []

    def found(heights: np.ndarray, pressure: float, hardness: float) -> tuple[float, np.ndarray]:
        low, high = 0.0, float(both.max())
        for _ in range(34):
            d = 0.5 * (low + high)
            p = press(space, heights, d, hardness=hardness, tolerance=1e-6 * rms)
            low, high = (d, high) if p.mean() > pressure else (low, d)
        return d, press(space, heights, d, p, hardness=hardness, tolerance=1e-8 * rms)

    d, p = found(both, PRESSURE, HARDNESS)
    gap = space.displacement(p) - both + d
    flat = both + np.where(p >= HARDNESS, np.minimum(gap, 0.0), 0.0)
    for share, reaches in zip(shares, amplitudes, strict=True):
        d, p = found(flat, share * PRESSURE, math.inf)
        contact = Contact(space, flat, d, p, 0.0, np.eye(2))
        load = min(float(p.mean()), share * PRESSURE) * unit
        for reach in reaches:
            u = reach / PIXEL * np.cos(2.0 * math.pi * np.arange(1, STEPS + 1) / STEPS)
            path = np.concatenate((reach / PIXEL * np.linspace(0.2, 1.0, 5), u))
            force = slipped(contact, np.outer(path, [1.0, 0.0]))[5:, 0] / p.size * unit
            noise = rng.normal(size=(2, CYCLES * STEPS))
            records.append(
                ms.Record(
                    np.tile(u * PIXEL, CYCLES) + 2e-10 * noise[0],
                    np.tile(force, CYCLES) + 2e-3 * load * noise[1],
                    time=np.arange(CYCLES * STEPS) / 480.0,
                    normal_load=load,
                )
            )
    return records


@pytest.mark.parametrize("points", [32, pytest.param(48, marks=pytest.mark.slow)])
def test_friction_comes_back_with_the_surface_given_and_as_a_start(points: int) -> None:
    z = levelled(periodic_face(2 * points, 5, 1 / 4)[:points, :points])
    law = ms.MeasuredContact(
        z * PIXEL, PAIR, HARDNESS * MODULUS, PRESSURE * MODULUS,
        pixel=PIXEL, piece=None, direction=0.0, area=AREA,
    )  # fmt: skip
    shares = [1.0, 0.6]
    joints = [
        ms.Interface(law, FRICTION, normal_load=s * PRESSURE * MODULUS * AREA) for s in shares
    ]
    amplitudes = [
        [x * joint.force_limit / joint.tangential_stiffness for x in (1.0, 4.0)] for joint in joints
    ]
    records = loops(z, amplitudes, shares)
    # So few points, and a piece repeated where the truth is mirrored: 3 % takes larger faces.
    for record, joint, (first, _) in zip(records[::2], joints, amplitudes, strict=True):
        u, force = np.asarray(record.displacement), np.asarray(record.force)
        energy = 0.5 * float((force + np.roll(force, 1)) @ (u - np.roll(u, 1))) / CYCLES
        assert joint.dissipated_energy(first) == pytest.approx(energy, rel=0.08)
    given = ms.identify(records, "given-surface", surface=law, rig_stiffness="rigid")
    started = ms.identify(
        records, ms.Interface(law, 0.2, normal_load=joints[1].normal_load), rig_stiffness="rigid"
    )
    for result in (given, started):
        friction = result.parameters["friction_coefficient"]
        assert friction.value == pytest.approx(FRICTION, rel=5e-3)
        assert friction.low - 2e-3 < FRICTION < friction.high + 2e-3
    assert set(given.parameters) == {"friction_coefficient"}
    # With its lengths free the face is found again, to what so few contacts and the law differ by.
    assert started.derived["std"].value == pytest.approx(law.numbers.rms, rel=0.15)
    built = started.joint(normal_load=joints[0].normal_load)
    assert built.tangential_stiffness == pytest.approx(joints[0].tangential_stiffness, rel=0.1)
