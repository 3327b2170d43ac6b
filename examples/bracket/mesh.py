"""Mesh an L-shaped bracket on a plate, held by two M8 bolts, with gmsh (pip install gmsh).

The plates, the heads with nuts, and the shanks are volumes. Those that are joined share nodes, as
`fragment` makes them; the two faces of the contact share none, as no call holds both plates.
"""

import gmsh

THICK, HEAD, SHANK, HOLE, FLATS = 8.0, 6.0, 8.0, 9.0, 13.0  # millimetres
BOLTS = ((20.0, 15.0), (20.0, 45.0))

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
cad = gmsh.model.occ


def discs(low, height, diameter):
    """Cylinders around all bolts from a height."""
    return [(3, cad.addCylinder(x, y, low, 0, 0, height, diameter / 2)) for x, y in BOLTS]


plate, _ = cad.cut([(3, cad.addBox(0, 0, -THICK, 160, 60, THICK))], discs(-9, 10, HOLE))
web = [(3, cad.addBox(0, 0, THICK, THICK, 60, 60))]
foot, _ = cad.fuse([(3, cad.addBox(0, 0, 0, 40, 60, THICK))], web)
bracket, _ = cad.cut(foot, discs(-1, 10, HOLE))
nuts, heads = discs(-THICK - HEAD, HEAD, FLATS), discs(THICK, HEAD, FLATS)
shanks = discs(-THICK, 2 * THICK, SHANK)

_, parts = cad.fragment(plate, nuts + shanks)
plate, nuts, shanks = parts[0], parts[1] + parts[2], parts[3] + parts[4]
_, parts = cad.fragment(bracket, heads + shanks)
bracket, heads, shanks = parts[0], parts[1] + parts[2], parts[3:]
cad.synchronize()


def faces_at_joint(volume):
    """Faces of a volume in the plane z = 0."""
    around = [tag for _, tag in gmsh.model.getBoundary(volume, oriented=False)]
    boxes = {tag: cad.getBoundingBox(2, tag) for tag in around}
    return [tag for tag, box in boxes.items() if max(abs(box[2]), abs(box[5])) < 1e-3]


for name, volumes in {
    "plate": plate,
    "bracket": bracket,
    "heads": nuts + heads,
    "shank 1": shanks[0],
    "shank 2": shanks[1],
}.items():
    gmsh.model.addPhysicalGroup(3, [tag for _, tag in volumes], name=name)
gmsh.model.addPhysicalGroup(2, faces_at_joint(plate), name="plate face")
gmsh.model.addPhysicalGroup(2, faces_at_joint(bracket), name="bracket face")
# What of the plate lies beside the foot has no partner, and is left out.
gmsh.option.setNumber("Mesh.MeshSizeMax", 7.0)
gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 10)
gmsh.model.mesh.generate(2)
# The faces of the contact lie on each other: the sides are filled one after the other.
gmsh.option.setNumber("Mesh.MeshOnlyVisible", 1)
gmsh.option.setNumber("Mesh.MeshOnlyEmpty", 1)
for side in (plate + nuts, bracket + heads, shanks[0] + shanks[1]):
    gmsh.model.setVisibility(gmsh.model.getEntities(), 0)
    gmsh.model.setVisibility(side, 1, recursive=True)
    gmsh.model.mesh.generate(3)
gmsh.model.setVisibility(gmsh.model.getEntities(), 1)
gmsh.write("bracket.msh")  # version 4.1
gmsh.finalize()
