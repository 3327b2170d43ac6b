"""Write gmsh_meshes.zip: two bolted plates as Gmsh (pip install gmsh meshio) writes them.

The lower plate is cut into two volumes, the bolt has heads, points of the geometry carry unused
nodes. Run by hand; the tests read the archive, so that they need no Gmsh.
"""

from __future__ import annotations

import tempfile
import zipfile
from pathlib import Path

import gmsh
import meshio

TARGET = Path(__file__).with_name("gmsh_meshes.zip")


def geometry() -> None:
    shapes = gmsh.model.occ
    lower, upper = shapes.addBox(0, 0, 0, 60, 20, 6), shapes.addBox(20, 0, 6, 60, 20, 6)
    hole = (3, shapes.addCylinder(40, 10, -3, 0, 0, 18, 4.5))
    shank = (3, shapes.addCylinder(40, 10, -3, 0, 0, 18, 4))
    heads = [(3, shapes.addCylinder(40, 10, z, 0, 0, 3, 7)) for z in (-3, 12)]
    low, _ = shapes.cut([(3, lower)], [hole], removeTool=False)
    high, _ = shapes.cut([(3, upper)], [hole])
    bolt, _ = shapes.fuse([shank], heads)
    low, _ = shapes.fragment(low, [(2, shapes.addRectangle(0, 0, 3, 60, 20))])
    shapes.synchronize()
    volumes = {"lower": low, "upper": high, "bolt": bolt}
    for name, parts in volumes.items():
        tags = [tag for dimension, tag in parts if dimension == 3]
        gmsh.model.addPhysicalGroup(3, tags, name=name)
    for name, body in (("low face", "lower"), ("high face", "upper")):
        parts = [part for part in volumes[body] if part[0] == 3]
        sides = {s for part in parts for s in gmsh.model.getBoundary([part], oriented=False)}
        boxes = {tag: shapes.getBoundingBox(2, tag) for _, tag in sides}
        flat = [t for t, b in boxes.items() if abs(b[2] - 6) < 1e-3 and abs(b[5] - 6) < 1e-3]
        gmsh.model.addPhysicalGroup(2, flat, name=name)


def main() -> None:
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    with tempfile.TemporaryDirectory() as folder:
        for order in (1, 2):
            gmsh.clear()
            geometry()
            gmsh.option.setNumber("Mesh.MeshSizeMin", 8)
            gmsh.option.setNumber("Mesh.MeshSizeMax", 12)
            gmsh.model.mesh.generate(3)
            gmsh.model.mesh.setOrder(order)
            gmsh.option.setNumber("Mesh.SaveElementTagType", 2)
            for version in (2.2, 4.1):
                for binary in (0, 1):
                    gmsh.option.setNumber("Mesh.MshFileVersion", version)
                    gmsh.option.setNumber("Mesh.Binary", binary)
                    gmsh.write(f"{folder}/order{order}-{version}-{['ascii', 'binary'][binary]}.msh")
            for suffix in ("inp", "bdf", "med"):
                gmsh.write(f"{folder}/order{order}.{suffix}")
            mesh = meshio.read(f"{folder}/order{order}-4.1-ascii.msh")
            mesh.cell_sets = {}
            mesh.write(f"{folder}/order{order}.vtu")
        with zipfile.ZipFile(TARGET, "w", zipfile.ZIP_LZMA) as archive:
            for path in sorted(Path(folder).iterdir()):
                archive.write(path, path.name)


if __name__ == "__main__":
    main()
