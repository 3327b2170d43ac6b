"""Rods for Nastran's nonlinear solutions: elastic, perfectly plastic, in parallel.

Nodes of a mesh that lie on each other, as those of a joint do, leave a rod no length, and this
package does not know where they are. So each patch has two grid points of its own, a metre apart,
which move along the rod as the points of the mesh do in the direction of the joint.
"""

from __future__ import annotations

from microslip.export.numbered_cells import compact, numbered_cells
from microslip.export.order import Accuracy, Order


def write(order: Order) -> tuple[dict[str, str], Accuracy]:
    """Bulk data, to be included; its constraints are the set of the first number."""
    first = order.first_number
    lines = [f"$ {line}" for line in order.header()]
    lines.append(f"$ Case control needs MPC = {first}; its points, too, begin at {first}.")
    point = first
    for index, patch in numbered_cells(order):
        ends = point, point + 1
        for place, (grid_point, mesh) in enumerate(zip(ends, patch[0].nodes, strict=True)):
            lines += _card("GRID", grid_point, "", float(place), 0.0, 0.0, "", 23456)
            lines += _card("MPC", first, grid_point, 1, 1.0, mesh, order.direction, -1.0)
        for cell in patch:
            # Of unit length, and of unit area.
            lines += _card("CROD", cell.number, cell.number, *ends)
            lines += _card("PROD", cell.number, cell.number, 1.0)
            lines += _card("MAT1", cell.number, cell.stiffness, "", 0.0)
            lines += _card("MATS1", cell.number, "", "PLASTIC", 0.0, 1, 1, cell.limit)
        lines.append(f"$ patch {index}: elements {patch[0].number} to {patch[-1].number}")
        point += 2
    return {order.stem + order.suffix: "\n".join(lines) + "\n"}, order.accuracy


def _card(name: str, *fields: float | str) -> list[str]:
    """A card in large fields, four on a line."""
    words = [compact(f, 16) if isinstance(f, float) else str(f) for f in fields]
    lines = []
    for i in range(0, len(words), 4):
        start = f"{name}*" if i == 0 else "*"
        lines.append((start.ljust(8) + "".join(w.ljust(16) for w in words[i : i + 4])).rstrip())
    if len(lines) % 2:
        lines.append("*")
    return lines
