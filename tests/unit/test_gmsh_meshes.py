"""Meshes as Gmsh writes them: all versions, orders and formats give the same joint."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest

import microslip as ms

pytest.importorskip("meshio")
ARCHIVE = Path(__file__).parents[1] / "reference" / "gmsh_meshes.zip"
STEEL = (ms.Material(young_modulus=210e9, poisson_ratio=0.3), 7850.0)
NAMED = ("lower", "upper", "bolt", "low face", "high face")
NAMES = {
    ".msh": NAMED,
    ".med": NAMED,
    ".inp": tuple(name.replace(" ", "_") for name in NAMED),
    ".bdf": tuple(f"nastran:ref {number}" for number in range(1, 6)),
    ".vtu": tuple(f"gmsh:physical {number}" for number in range(1, 6)),
}
with zipfile.ZipFile(ARCHIVE) as _archive:
    FILES = sorted(_archive.namelist())


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("meshes")
    with zipfile.ZipFile(ARCHIVE) as archive:
        archive.extractall(place)
    return place


def joint(path: Path) -> ms.MeshedJoint:
    if path.suffix == ".med":
        pytest.importorskip("h5py")
    lower, upper, bolt, low_face, high_face = NAMES[path.suffix]
    return ms.MeshedJoint.read(
        path,
        bodies=dict.fromkeys((lower, upper, bolt), STEEL),
        contacts=[(low_face, high_face)],
        bolts={bolt: 5e3},
        scale=1e-3,
    )


@pytest.mark.parametrize("name", FILES)
def test_every_format_gives_the_same_joint(name: str, folder: Path) -> None:
    found = joint(folder / name)
    # 60 mm by 20 mm, less a hole of radius 4.5 mm as its few facets have it.
    assert 1.2e-3 - np.pi * 4.5e-3**2 < found.face_area < 1.2e-3
    rounding = 2e-6 if name.endswith(".bdf") else 1e-12  # Nastran's fields hold six digits
    first = joint(folder / "order1-2.2-ascii.msh")
    assert found.mesh.cells.shape == first.mesh.cells.shape
    assert found.face_area == pytest.approx(first.face_area, rel=rounding)
    sizes = [len(body.cells) for body in found.mesh.bodies]
    assert sizes == [len(body.cells) for body in first.mesh.bodies]
    ends = found.mesh.points.min(axis=0), found.mesh.points.max(axis=0)
    np.testing.assert_allclose(ends, [(0, 0, -3e-3), (80e-3, 20e-3, 15e-3)], atol=1e-8)


@pytest.mark.parametrize("change", ["5 0 8", "4.1 9 8"])
def test_a_file_that_meshio_does_not_read_has_a_remedy(folder: Path, change: str) -> None:
    text = (folder / "order1-4.1-ascii.msh").read_text()
    path = folder / "old.msh"
    path.write_text(text.replace("4.1 0 8", change, 1))
    with pytest.raises(ms.InputError, match=r"gmsh old\.msh -save -format msh22 -o new\.msh"):
        joint(path)
    unknown = path.rename(folder / "part.unv")
    with pytest.raises(ms.InputError, match=r"gmsh part\.unv -save"):
        ms.MeshedJoint.read(
            unknown, bodies={"a": STEEL}, contacts=[("b", "c")], bolts={"d": 5e3}, scale=1e-3
        )
