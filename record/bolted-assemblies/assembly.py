"""Mesh of two equal flat parts bolted by their pads, from drawing PAD_PAD of Abaqus4Joints.

A part is 12.7 mm thick: an arm 25.4 mm wide between two pads 63.5 mm square, 381 mm from end to
end; the arm is flush with one side of the pads. Four 5/16 in bolts with plain washers go through
two pads. The lower part lies below z = 0 with its arm along -x; the upper part is the lower one
turned about z by some angle, after it was turned over if `mirrored` is true. Hexahedra by layers,
with rings around the holes; lengths in metres.
"""

import itertools
import math
from pathlib import Path

import meshio
import numpy as np

INCH = 0.0254
THICK, PAD, ARM, SPAN = 0.5 * INCH, 2.5 * INCH, 1.0 * INCH, 15.0 * INCH  # drawing PAD_PAD
HOLE, PITCH = 0.332 * INCH, 0.86 * INCH  # drawing PAD_PAD
SHANK, WASHER, HEAD_HEIGHT = 5 / 16 * INCH, INCH / 16, 0.203125 * INCH  # NUTWASHERBOLT_516.py
HEAD = 0.5 * INCH * math.sqrt(2.0 * math.sqrt(3.0) / math.pi)  # disc with the area of the hexagon
PRESSED = 0.5 * INCH + 1.6 * WASHER  # diameter of the washer that is bonded to the plate
TAIL = 1.5 * INCH - 2.0 * (THICK + WASHER) - HEAD_HEIGHT  # thread beyond the nut
SIDE = 4  # cells along each side of the square around a hole, 16 around the hole
ROUND = math.sqrt(2.0 * math.pi / (4 * SIDE) / math.sin(2.0 * math.pi / (4 * SIDE)))


class Mesh:
    """Points and hexahedra; points are merged by place, except across the faces of the joint."""

    def __init__(self):
        self.points, self.index, self.cells, self.groups = [], {}, [], {}

    def point(self, place, side):
        """Return the number of a point; `side` counts in the plane of the joint alone."""
        key = (*(round(value / 1e-7) for value in place), side if abs(place[2]) < 1e-7 else None)
        if key not in self.index:
            self.index[key] = len(self.points)
            self.points.append(tuple(place))
        return self.index[key]

    def extrude(self, group, quads, heights, side):
        """Add layers of hexahedra over quadrilaterals between heights."""
        for quad, (low, high) in itertools.product(quads, itertools.pairwise(heights)):
            corners = [(x, y, z) for z in (low, high) for x, y in quad]
            self.groups.setdefault(group, []).append(len(self.cells))
            self.cells.append([self.point(corner, side) for corner in corners])


def ring(inner, outer):
    """Quadrilaterals between two closed polygons."""
    count = len(inner)
    return [
        (inner[k], outer[k], outer[(k + 1) % count], inner[(k + 1) % count]) for k in range(count)
    ]


def polygons(centre):
    """Square and circles around a bolt, and the quadrilaterals inside its shank."""
    steps = np.linspace(-1.0, 1.0, SIDE + 1)[:-1]
    unit = np.ones(SIDE)
    square = np.concatenate(
        [
            np.stack(pair, axis=1)
            for pair in ((steps, -unit), (unit, steps), (-steps, unit), (-unit, -steps))
        ]
    )
    angles = -0.75 * math.pi + 2.0 * math.pi * np.arange(4 * SIDE) / (4 * SIDE)
    circle = ROUND * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    around = {"square": centre + 0.5 * PITCH * square}
    for name, diameter in (("shank", SHANK), ("hole", HOLE), ("head", HEAD), ("pressed", PRESSED)):
        around[name] = centre + 0.5 * diameter * circle
    # A square grid with rounded sides inside the shank.
    core = centre + 0.25 * SHANK * (0.7 * square + 0.3 * math.sqrt(2.0) * circle)
    grid = {}
    for i, j in itertools.product(range(SIDE + 1), repeat=2):
        u, v = 2.0 * i / SIDE - 1.0, 2.0 * j / SIDE - 1.0
        swell = 0.7 + 0.3 * math.sqrt(2.0) * max(abs(u), abs(v)) / max(math.hypot(u, v), 1e-12)
        grid[i, j] = centre + 0.25 * SHANK * np.array([u, v]) * (swell if u or v else 0.0)
    edge = [(k, 0) for k in range(SIDE)] + [(SIDE, k) for k in range(SIDE)]
    edge += [(SIDE - k, SIDE) for k in range(SIDE)] + [(0, SIDE - k) for k in range(SIDE)]
    for place, node in zip(core, edge, strict=True):
        grid[node] = place
    inside = ring(core, around["shank"])
    for i, j in itertools.product(range(SIDE), repeat=2):
        inside.append((grid[i, j], grid[i + 1, j], grid[i + 1, j + 1], grid[i, j + 1]))
    return around, inside


BOLTS = [np.array([0.5 * PITCH * i, 0.5 * PITCH * j]) for i in (-1, 1) for j in (-1, 1)]
LINES = np.concatenate([[-0.5 * PAD], np.linspace(-PITCH, PITCH, 4 * SIDE // 2 + 1), [0.5 * PAD]])
ARM_LINES = [0.5 * PAD - ARM, *LINES[LINES > 0.5 * PAD - ARM]]


def pad(joint, edge):
    """Quadrilaterals of a pad around the origin, its arm at x = edge times half its width."""

    def place(x, y):
        # The corner of the arm lies between two lines; the nearest node of the edge moves to it.
        nearest = LINES[np.argmin(abs(LINES - ARM_LINES[0]))]
        at_arm = abs(x - edge * 0.5 * PAD) < 1e-9 and abs(y - nearest) < 1e-9
        return np.array([x, ARM_LINES[0] if at_arm else y])

    quads = []
    for (a, b), (c, d) in itertools.product(itertools.pairwise(LINES), repeat=2):
        if max(abs(a + b), abs(c + d)) > 2.0 * PITCH:
            quads.append((place(a, c), place(b, c), place(b, d), place(a, d)))
    for centre in BOLTS:
        around, _ = polygons(centre)
        radii = ("hole", "head", "pressed", "square") if joint else ("hole", "square")
        for inner, outer in itertools.pairwise(radii):
            quads += ring(around[inner], around[outer])
    return quads


def part():
    """Quadrilaterals of the lower part: the bolted pad at the origin, arm, free pad."""
    away = SPAN - PAD
    free = [tuple(q - np.array([away, 0.0]) for q in quad) for quad in pad(False, 1)]
    stations = np.linspace(-0.5 * PAD, 0.5 * PAD - away, 13)
    arm = [
        tuple(np.array(p) for p in ((b, c), (a, c), (a, d), (b, d)))
        for a, b in itertools.pairwise(stations)
        for c, d in itertools.pairwise(ARM_LINES)
    ]
    return pad(True, -1), free + arm


def turned(quads, angle, mirrored):
    """Quadrilaterals mirrored in x = 0 where asked, then turned about z [rad]."""
    c, s = math.cos(angle), math.sin(angle)
    matrix = np.array([[c, -s], [s, c]]) @ np.diag([-1.0 if mirrored else 1.0, 1.0])
    moved = [tuple(matrix @ point for point in quad) for quad in quads]
    return [quad[::-1] for quad in moved] if mirrored else moved


def write(path: Path, angle: float, mirrored: bool) -> None:
    """Write the mesh for Abaqus: sets part 1, part 2, heads, shank 1 to 4, face 1, face 2."""
    mesh = Mesh()
    joint, rest = part()
    mesh.extrude("part 1", joint + rest, (-THICK, -0.5 * THICK, 0.0), "lower")
    upper = turned(joint + rest, angle, mirrored)
    mesh.extrude("part 2", upper, (0.0, 0.5 * THICK, THICK), "upper")
    top = THICK + WASHER
    for number, centre in enumerate(BOLTS, 1):
        around, inside = polygons(centre)
        bonded = ring(around["hole"], around["head"]) + ring(around["head"], around["pressed"])
        disc = inside + ring(around["shank"], around["hole"]) + ring(around["hole"], around["head"])
        for low, high in ((THICK, top), (-top, -THICK)):
            mesh.extrude("heads", bonded, (low, high), None)
        for low, high in ((top, top + HEAD_HEIGHT), (-top - HEAD_HEIGHT, -top)):
            mesh.extrude("heads", disc, (low, high), None)
        mesh.extrude("heads", inside, (-top - HEAD_HEIGHT - TAIL, -top - HEAD_HEIGHT), None)
        mesh.extrude(f"shank {number}", inside, np.linspace(-top, top, 5), None)
    points, cells = np.array(mesh.points), np.array(mesh.cells)
    faces = {}
    for number in (1, 2):
        corners = np.unique(cells[mesh.groups[f"part {number}"]])
        faces[f"face {number}"] = corners[abs(points[corners, 2]) < 1e-9]
    sets = {name: [np.array(members)] for name, members in mesh.groups.items()}
    file = meshio.Mesh(points, [("hexahedron", cells)], point_sets=faces, cell_sets=sets)
    meshio.write(path, file, "abaqus")
