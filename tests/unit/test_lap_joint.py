"""Bolts, laps and reduced joints: what they refuse, what they keep, what files give back."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from foreign_files import NAMED, mesh_file
from laps import DENSITY, STEEL, boxes, fork, small_joint, small_lap

import microslip as ms
from microslip.structures.mesh import Body, JointMesh, Solids
from microslip.structures.reduction import Reducer

# -- laps ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"material": ms.Material.rigid()}, "neither rigid nor incompressible"),
        ({"element_size": 1e-4}, "above the limit of 10000"),
        ({"patches": 3}, r"patches must be two whole numbers, along and across, such as \(15, 2\)"),
        ({"patches": (1000, 1000)}, "patches must be at most"),
        ({"patches": [[0.0, -0.01, 0.0, 0.01]]}, "the bounds of a patch must increase"),
        ({"patches": [[1.0, 1.1, 0.0, 0.01]]}, "no patch holds any of the faces"),
        ({"sensors": {"tip": ((1.0, 0, 0), "z")}}, 'sensor "tip" must lie on the bodies'),
        ({"sensors": {"tip": ((0.1, 0, 0), "w")}}, 'the direction of sensor "tip" must be "x"'),
        ({"sensors": {"tip": ((0.1, 0, 0), (0, 0, 0))}}, "must not be zero"),
        ({"masses": {(5.0, 0.0, 0.0): 0.1}}, "an added mass must lie on the bodies"),
    ],
)
def test_reductions_that_are_none(given: dict[str, Any], message: str) -> None:
    wanted = {"material": STEEL, "density": DENSITY, "patches": (2, 1), "element_size": 0.012}
    with pytest.raises(ms.InputError, match=message):
        small_lap().reduce(**(wanted | given))


def test_single_laps_and_rows_of_bolts() -> None:
    bolts = ms.Bolts(
        [(-0.02, -0.02), (0.02, 0.02)], shank=0.006, hole=0.0066, washer=0.012, tension=[4e3, 5e3]
    )
    plates = ms.LapJoint(
        length=0.3, width=0.08, thickness=0.004, lap=0.08, bolts=bolts, style="single-lap"
    )
    mesh = plates.mesh(STEEL, DENSITY, element_size=0.02)
    heights = mesh.points[mesh.cells[mesh.bodies[0].cells]][..., 2]
    assert heights.min() == pytest.approx(-0.004)
    assert heights.max() == 0.0
    assert len(mesh.shanks) == 2
    contact = mesh.contacts[0]
    np.testing.assert_array_equal(mesh.points[contact.lower], mesh.points[contact.upper])
    assert np.intersect1d(contact.lower, contact.upper).size == 0


def test_bodies_that_share_no_corners_are_refused() -> None:
    solids, line = Solids(1e-9), [0.0, 0.01]
    bodies = [Body(n, boxes(solids, (line, line, line), n), STEEL, DENSITY) for n in ("low", "up")]
    mesh = JointMesh(solids.points, np.array(solids.cells), "hexahedron", tuple(bodies), (), ())
    with pytest.raises(ms.InputError, match="2 separate parts: not connected to low: up"):
        Reducer(mesh, None, None)


# -- reduced joints --------------------------------------------------------------------------------


@pytest.mark.slow
def test_what_is_saved_is_read_again(tmp_path: Path) -> None:
    joint = small_joint().with_form(lambda x, y: 1e-6 + 1e-3 * x**2)
    joint.save(tmp_path / "joint.npz")
    again = ms.ReducedJoint.load(tmp_path / "joint.npz")
    for name in ("mass", "stiffness", "patch_gaps", "sensor_rows", "bolt_tension"):
        np.testing.assert_array_equal(getattr(again, name), getattr(joint, name))
    assert again.sensor_names == ("tip",)
    assert again.full_size == joint.full_size
    np.testing.assert_array_equal(again.surface.motion, joint.surface.motion)
    with pytest.raises(ms.InputError, match="exists; replace it with overwrite=True"):
        joint.save(tmp_path / "joint.npz")
    with pytest.raises(ms.InputError, match=r"is written to an .npz file"):
        joint.save(tmp_path / "joint.mat")


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("stiffness", np.zeros((3, 3)), "stiffness has the shape"),
        ("stiffness", np.full((33, 33), np.nan), "stiffness contains values that are not finite"),
        ("stiffness", -np.eye(33), "stiffness must not be negative"),
        ("mass", np.zeros((33, 33)), "mass must be positive definite"),
        ("mass", np.array("x"), "mass has the shape"),
        ("patch_areas", np.zeros(6), "patch_areas must be above zero"),
        ("samples_patches", np.full(2448, 6), "samples_patches must be from 0 to 5"),
        ("surface_facets", np.full((800, 4), -1), "surface_facets must be from 0 to 961"),
        ("full_size", np.array("many"), "full_size has the shape"),
    ],
)
def test_a_stored_joint_of_other_numbers_is_refused(
    tmp_path: Path, name: str, value: Any, message: str
) -> None:
    small_joint().save(tmp_path / "joint.npz")
    with np.load(tmp_path / "joint.npz") as sound:
        np.savez(tmp_path / "changed.npz", **{**sound, name: value})
    with pytest.raises(ms.InputError, match=message):
        ms.ReducedJoint.load(tmp_path / "changed.npz")


def test_form_by_function_table_and_patch() -> None:
    joint = small_joint()
    x, y = joint.samples.places.T
    table = np.stack([x, y, 1e-6 + 3e-4 * x], axis=1)
    by_function = joint.with_form(lambda x, y: 1e-6 + 3e-4 * x)
    by_table = joint.with_form(table)
    np.testing.assert_allclose(by_table.patch_gaps, by_function.patch_gaps, atol=1e-15)
    assert by_function.patch_gaps.min() == 0.0
    # A gap that rises linearly has the value of the centre of area, here by samples.
    np.testing.assert_allclose(np.ptp(by_function.patch_gaps), 3e-4 * 0.02, rtol=2e-3)
    np.testing.assert_allclose(
        joint.with_form(by_table.patch_gaps).patch_gaps, by_table.patch_gaps, atol=1e-20
    )
    reversed_ = joint.with_form(table, -1.0).patch_gaps
    np.testing.assert_allclose(reversed_ + by_table.patch_gaps, np.ptp(by_table.patch_gaps))
    assert not joint.with_form(table, 0.0).patch_gaps.any()


def test_patches_are_halved_where_the_loss_is() -> None:
    from microslip.structures.reduction_convergence import dissipating_patches, halved_boxes

    loss = np.array([[0.5, 0.1, 0.35, 0.05], [0.1, 0.1, 0.1, 4.0]])
    np.testing.assert_array_equal(dissipating_patches(loss), [True, False, True, True])
    boxes = np.array([[7.0, 0.0, 2.0, 0.0, 1.0], [7.0, 2.0, 4.0, 0.0, 1.0]])
    cut = halved_boxes(boxes, np.array([True, False]), 0)
    np.testing.assert_array_equal(cut, [[7, 2, 4, 0, 1], [7, 0, 1, 0, 1], [7, 1, 2, 0, 1]])
    cut = halved_boxes(boxes, np.array([False, True]), 1)
    np.testing.assert_array_equal(cut[1:], [[7, 2, 4, 0, 0.5], [7, 2, 4, 0.5, 1]])


# -- meshes of one's own ---------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", [".msh", ".inp"])
def test_a_mesh_of_ones_own_gives_the_same_joint(tmp_path: Path, suffix: str) -> None:
    from microslip.structures.reduction import Reducer

    read = ms.MeshedJoint.read(mesh_file(tmp_path / f"fork{suffix}"), **NAMED).reduce((3, 2))
    own = Reducer(fork(5, 8), None, None).reduce(tension=1e3, patches=(3, 2))
    np.testing.assert_allclose(read.stiffness[:19, :19], own.stiffness[:19, :19], rtol=1e-6)
    np.testing.assert_allclose(read.patch_areas, own.patch_areas, rtol=1e-9)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"bodies": {}}, "bodies must be named, got none"),
        ({"bolts": {}}, "bolts must be named, got none"),
        ({"bodies": {"post": (STEEL, DENSITY)}}, "belong to none of the bodies"),
        ({"bodies": {"post": STEEL}}, 'body "post" must have a material and a density'),
        ({"bolts": {"pots": 1e3}}, 'has no volume "pots"; did you mean "post"'),
        ({"bolts": {"post": -1e3}}, 'the tension of bolt "post" must be above zero'),
        ({"limit": 100}, "points, more than limit=100"),
        (
            {"contacts": [("low face", "hi face")]},
            'has no face "hi face"; did you mean "high face"',
        ),
        ({"contacts": ["low face"]}, "a contact must be two names"),
        ({"contacts": [("low face", "low face")]}, "share nodes"),
        ({"scale": 1e6}, "if it is in millimetres, write scale=1e-3"),
    ],
)
def test_meshes_that_do_not_fit(tmp_path: Path, changes: dict[str, Any], message: str) -> None:
    path = mesh_file(tmp_path / "fork.msh")
    with pytest.raises(ms.InputError, match=message):
        ms.MeshedJoint.read(path, **(NAMED | changes))


def test_shanks_are_where_the_mesh_has_them() -> None:
    meshed = ms.MeshedJoint(fork(5, 8), (1e3,))
    ((x, y, diameter, contact),) = meshed.shank_sections()
    # The post lies at x from -10 to 0 mm, the faces from 0 to 50 mm; its section is 10 x 20 mm.
    np.testing.assert_allclose((x, y), (-0.03, 0.0), atol=1e-12)
    assert 0.25 * math.pi * diameter**2 == pytest.approx(0.01 * 0.02, rel=1e-12)
    assert contact == 0
    assert meshed.face_area == pytest.approx(0.05 * 0.02, rel=1e-12)
    assert meshed.shank_sections([1e300, 0.0, 0.0]) == meshed.shank_sections([1.0, 0.0, 0.0])
