"""Matrices and a mesh of small structures in files of other programs, for the tests."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
from laps import DENSITY, STEEL, fork

NAMED: dict[str, Any] = {
    "bodies": dict.fromkeys(("post", "low", "high"), (STEEL, DENSITY)),
    "contacts": [("low face", "high face")],
    "bolts": {"post": 1e3},
}


def output2(**matrices: Any) -> bytes:
    """Matrices as Nastran's OUTPUT2 writes them: records between their lengths, keys between."""

    def record(data: bytes) -> bytes:
        return struct.pack("=i", len(data)) + data + struct.pack("=i", len(data))

    def keys(*values: int) -> bytes:
        return b"".join(record(struct.pack("=i", value)) for value in values)

    content = keys(3) + record(struct.pack("=3i", 11, 22, 26)) + keys(7)
    content += record(b"NASTRAN FORT TAPE ID CODE - ") + keys(2) + record(b"XXXXXXXX") + keys(-1, 0)
    for name, matrix in matrices.items():
        title, size = record(name.ljust(8).encode()), len(matrix)
        trailer = struct.pack("=7i", 101, size, size, 6, 2, size, 0)
        content += keys(2) + title + keys(-1, 7) + record(trailer) + keys(-2, 1, 0, 2) + title
        content += keys(-3, 1, 1)
        for number, column in enumerate(matrix.T, start=1):
            content += keys(1 + 2 * size) + record(struct.pack(f"=i{size}d", 1, *column))
            content += keys(-3 - number, 1, int(number < size))
        content += keys(0)
    return content + keys(0)


def punched(name: str, matrix: Any) -> str:
    """A matrix as DMIG cards of a punch file: grids 10, 20, ... along x, the upper half."""
    cards = f"DMIG    {name:8}{0:8}{6:8}{2:8}{0:8}{'':8}{'':8}{len(matrix):8}\n"
    for j in range(len(matrix)):
        cards += f"DMIG*   {name:16}{'':16}"[:24] + f"{10 * (j + 1):16}{1:16}\n"
        for i in range(j + 1):
            number = f"{matrix[i, j]:16.9E}".replace("E", "D")
            cards += f"*       {10 * (i + 1):16}{1:16}{number}\n" if matrix[i, j] else ""
    return cards


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
