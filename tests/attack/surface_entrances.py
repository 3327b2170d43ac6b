"""Callables on surfaces, pressures, drawings, scans and sets of summits, with their arguments."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy import stats

import microslip as ms

Add = Callable[..., None]


def add_surfaces(add: Add, surface: Any, joint: Any) -> None:
    """Surfaces that are no plain population, and laws under an uneven pressure."""
    pair = surface.pair
    population = ms.AsperityPopulation(pair, heights=[0.0, 1e-7], radii=1e-3)
    add("AsperityPopulation of an area", ms.AsperityPopulation, pair=pair, heights=[0.0, 1e-7],
        radii=1e-3, copies=2.0, area=1e-4)  # fmt: skip
    sphere = ms.SphereOnFlat(pair, 5e-3)
    for law in (population, sphere):
        kind = type(law).__name__
        for method in ("load", "contact_count", "contact_area", "contact_probability"):
            add(f"{kind}.{method}", getattr(law, method), separation=3e-7)
    add("SphereOnFlat.hertz_pressure", sphere.hertz_pressure, separation=-1e-8)
    add("Interface.at a separation", joint.at, separation=1e-7)
    add("Discrete.probability_above", ms.Discrete([0.0, 1e-7]).probability_above, height=1e-8)
    normal = ms.Statistical(stats.norm(scale=5e-7))
    add("Statistical.partial_moment", normal.partial_moment, order=1.5, threshold=1e-7)
    add("MaterialPair.with_hardness", pair.with_hardness, hardness=1e9)
    for quantity, at in (("force", [0.0, 1e-7, -1e-7]), ("dissipated_energy", 1e-7)):
        add(f"Interface.parameter_derivatives, {quantity}", joint.parameter_derivatives,
            ("quantity",), quantity=quantity, at=at)  # fmt: skip
    _add_rough_faces(add, pair)
    _add_pressures(add, surface)
    _add_spectra(add, pair)
    _add_spheres(add, pair)


def _add_rough_faces(add: Add, pair: Any) -> None:
    """Measured faces."""
    heights = np.random.default_rng(0).normal(size=(24, 24)) * 1e-6
    add("MeasuredContact", ms.MeasuredContact, heights=heights, pair=pair, hardness=5e9,
        tightening_pressure=1.5e9, pixel=1e-6, area=1e-8, piece=24, loads=4,
        lightest=1e-2)  # fmt: skip
    face = ms.MeasuredContact.examples()[0]
    add("MeasuredContact.along", face.along, direction=0.3)
    add("MeasuredContact.contact_area", face.contact_area, separation=face.separations[3])
    add("MeasuredContact.slip_per_indentation", face.slip_per_indentation, direction=0.3)


def _add_pressures(add: Add, surface: Any) -> None:
    ring = {"outer": 1e-2, "inner": 3e-3, "count": 2}
    add("Pressure.annulus", ms.Pressure.annulus, **ring)
    add("Pressure.cone", ms.Pressure.cone, **ring, rings=8)
    add("Pressure.parabola", ms.Pressure.parabola, **ring, rings=8)
    add("Pressure.patches", ms.Pressure.patches, area=[1e-4, 2e-4], pressure=[1e6, 2e6])
    add("Pressure.bolt", ms.Pressure.bolt, ("size",), size="M8", plates=[5e-3, 5e-3], count=2,
        hole=9e-3, head=13e-3, angle=0.5, edge=2e-2, rings=8)  # fmt: skip
    pressure = ms.Pressure.cone(7e-3, 3e-3, rings=8)
    add("PressedJoint", ms.PressedJoint, surface=surface, friction_coefficient=0.3,
        pressure=pressure, normal_load=100.0)  # fmt: skip
    pressed = ms.PressedJoint(surface, 0.3, pressure, 100.0)
    add("PressedJoint.at", pressed.at, normal_load=200.0)
    add("PressedJoint.stick_area", pressed.stick_area, displacement=1e-8)
    add("PressedJoint.slip_shares", pressed.slip_shares, displacement=1e-8)
    add("PressedJoint.force", pressed.force, displacement=[1e-8, -1e-8])


def _add_spectra(add: Add, pair: Any) -> None:
    add("Finish", ms.Finish, ra=8e-7, rsm=1e-4)
    add("Finish of Rq", ms.Finish, rq=1e-6, rdq=0.1)
    add("Finish of Rz", ms.Finish, rz=6e-6, rsm=1e-4)
    hard = pair.with_hardness(1.2e9)
    add("DrawnFace", ms.DrawnFace, ("pair",), pair=hard, rms=4e-7, slope=0.1, area=1e-4,
        tightening_pressure=3e7, breadth=0.8, lay=0.5)  # fmt: skip

    def from_finish(**numbers: Any) -> ms.DrawnFace:
        return ms.DrawnFace.from_finish(hard, ms.Finish(ra=8e-7, rsm=1e-4), **numbers)

    from_finish.__qualname__ = "DrawnFace.from_finish"
    add("DrawnFace.from_finish", from_finish, area=1e-4, tightening_pressure=3e7)
    face = ms.DrawnFace(hard, 4e-7, 0.1, 1e-4, 3e7, lay=0.5)
    add("DrawnFace.along", face.along, direction=0.3)
    add("DrawnFace.contact_area", face.contact_area, separation=face.separations[3])
    add("DrawnFace.scatter", face.scatter, size=1e-3)
    add("DrawnFace.slip_per_indentation", face.slip_per_indentation, direction=0.3)


def _add_spheres(add: Add, pair: Any) -> None:
    asperity = ms.Asperity(pair, radius=1e-3, normal_load=1.0, friction_coefficient=0.5)
    add("Asperity of an indentation", ms.Asperity, pair=pair, radius=1e-3, indentation=1e-7,
        friction_coefficient=0.5)  # fmt: skip
    for name, value in (("normal_load", 2.0), ("separation", -1e-7)):
        add(f"Asperity.at {name}", asperity.at, **{name: value})
    radius = 0.5 * asperity.contact_radius
    add("Asperity.pressure", asperity.pressure, radius=radius)
    add("Asperity.normal_displacement", asperity.normal_displacement, radius=radius)
    add("Asperity.fields", asperity.fields, displacement=[1e-8, 0.0])
    add("Asperity.fields of forces", asperity.fields, force=[0.1, 0.0])
    add("Asperity.stick_radius", asperity.stick_radius, displacement=1e-8)
    add("Asperity.stick_radius of a force", asperity.stick_radius, force=0.1)
    fields = asperity.fields([1e-8, 0.0])
    add("AsperityFields.traction", fields.traction, radius=radius)
    add("AsperityFields.slip", fields.slip, radius=radius)
    add("AsperityFields.surface_displacement", fields.surface_displacement, x=radius, y=0.0)


def add_scans(add: Add, pair: Any) -> None:
    """Scans and their summits."""
    heights = 1e-7 * np.random.default_rng(1).standard_normal((40, 32))
    add("Scan", ms.Scan, heights=heights, pixel=1e-6)
    scan = ms.Scan(heights, 1e-6)
    add("Scan with cut-offs", ms.Scan, heights=heights, pixel=1e-6, cutoff=4e-6, long_cutoff=1e-5)
    add("Scan.condition", scan.condition, cutoff=4e-6, long_cutoff=1e-5)
    add("Scan.summits", scan.summits, cutoff=4e-6, prominence=1e-9)
    add("Scan.summits by prominence", scan.summits, cutoff=4e-6, prominence=1e-8)
    add("Scan.profile_parameters", scan.profile_parameters, section=1e-5, axis="x")
    summits = scan.summits(cutoff=4e-6, prominence=1e-9)
    add("Summits.to_surface", summits.to_surface, ("pair",), pair=pair, area=1e-8)
