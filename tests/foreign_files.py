"""A mesh of a small structure in files of other programs, for the tests."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from laps import DENSITY, STEEL, fork

NAMED: dict[str, Any] = {
    "bodies": dict.fromkeys(("post", "low", "high"), (STEEL, DENSITY)),
    "contacts": [("low face", "high face")],
    "bolts": {"post": 1e3},
}


def mesh_file(path: Path, *, nameless: bool = False, elements: tuple[int, int] = (5, 8)) -> Path:
    """A small fork as a file of Gmsh or Abaqus, or without names as any other of meshio's."""
    import meshio

    mesh = fork(*elements)
    contact = mesh.contacts[0]
    names = {"post": 1, "low": 2, "high": 3, "low face": 4, "high face": 5}
    solids = np.empty(len(mesh.cells), dtype=int)
    for body in mesh.bodies:
        solids[body.cells] = names[body.name]
    faces = np.concatenate([contact.lower, contact.upper])
    tags = np.repeat([4, 5], [len(contact.lower), len(contact.upper)])
    blocks = [("hexahedron", mesh.cells), ("quad", faces)]
    if path.suffix == ".inp":
        sets = {body.name: [body.cells, np.zeros(0, dtype=int)] for body in mesh.bodies} | {
            "unused": [np.zeros(0, dtype=int), np.arange(3)]
        }
        nodes = {"low face": np.unique(contact.lower), "high face": np.unique(contact.upper)}
        meshio.Mesh(mesh.points, blocks, cell_sets=sets, point_sets=nodes).write(path)
        return path
    data = {} if nameless else {
        "gmsh:physical": [solids, tags], "gmsh:geometrical": [solids, tags]
    }  # fmt: skip
    field = {} if nameless else {n: np.array([t, 3 if t < 4 else 2]) for n, t in names.items()}
    meshio.Mesh(mesh.points, blocks, cell_data=data, field_data=field).write(
        path, file_format="gmsh22" if path.suffix == ".msh" else None
    )
    return path
