"""Elements for CalculiX: cubes in parallel, elastic and perfectly plastic, pulled along x.

Its springs with a table are elastic, and its trusses, which it makes into bricks with hinges, did
not converge here. A cube of unit size whose sides are free carries Jenkins' cell: its modulus is
the stiffness, its yield stress the limit.
"""

from __future__ import annotations

from microslip.export.numbered_cells import numbered_cells
from microslip.export.order import Accuracy, Order

# Corners in the order of C3D8, and the sides that rest on planes of symmetry.
_CORNERS = (
    (0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1),
)  # fmt: skip


def write(order: Order) -> tuple[dict[str, str], Accuracy]:
    """One file to be included after the mesh, before the first step."""
    # Numbers have 19 characters: CalculiX reads 20 of one and no more.
    name = order.name.upper()
    lines = [f"** {line}" for line in order.header()]
    lines += [
        "** To use: *INCLUDE, INPUT=this file, after the mesh and before the first *STEP; small",
        f"** displacements (no NLGEOM). Its nodes and elements begin at {order.first_number}.",
        f"** The force of patch 1: *NODE PRINT, NSET={name}_1, TOTALS=ONLY, with RF.",
    ]
    first = order.first_number
    for index, cells in numbered_cells(order, connected=False):
        ends = []
        for cell in cells:
            label = f"{name}{cell.number}"
            start = first + 8 * (cell.number - first)
            corners = list(zip(range(start, start + 8), _CORNERS, strict=True))
            lines.append("*NODE")
            lines += [f"{n}, {x}., {y}., {z}." for n, (x, y, z) in corners]
            lines += [
                f"*ELEMENT, TYPE=C3D8, ELSET={label}",
                f"{cell.number}, {', '.join(str(n) for n, _ in corners)}",
                f"*MATERIAL, NAME={label}",
                "*ELASTIC",
                f"{cell.stiffness:.13e}, 0.",
                "*PLASTIC",
                f"{cell.limit:.13e}, 0.",
                f"{cell.limit:.13e}, 1.",
                "*DENSITY",
                "1.E-12",
                f"*SOLID SECTION, ELSET={label}, MATERIAL={label}",
                "*BOUNDARY",
            ]
            for n, corner in corners:
                lines += [f"{n}, {axis}, {axis}" for axis in (2, 3) if not corner[axis - 1]]
            for n, corner in corners if cell.nodes else ():
                end = cell.nodes[corner[0]]
                lines += ["*EQUATION", "2", f"{n}, 1, 1., {end}, {order.direction}, -1."]
            ends += [str(n) for n, corner in corners if corner[0]]
        lines += [f"*NSET, NSET={name}_{index}", *ends]
    if not order.patches[0].nodes:
        lines.append("** Its nodes at x = 0 and at x = 1 are to be tied to the joint's two sides.")
    return {order.stem + order.suffix: "\n".join(lines) + "\n"}, order.accuracy
