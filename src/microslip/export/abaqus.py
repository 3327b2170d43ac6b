"""Connectors for Abaqus: elastic, perfectly plastic in one component, in parallel."""

from __future__ import annotations

from microslip.export.numbered_cells import numbered_cells
from microslip.export.order import Accuracy, Order


def write(order: Order) -> tuple[dict[str, str], Accuracy]:
    """One file to be included in the part or model that has the nodes."""
    name = order.name.upper()
    lines = [f"** {line}" for line in order.header()]
    lines.append("** Directions are the global ones; nodes that rotate need an orientation.")
    for index, patch in numbered_cells(order):
        for cell in patch:
            label = f"{name}-{cell.number}"
            lines += [
                f"*ELEMENT, TYPE=CONN3D2, ELSET={label}",
                f"{cell.number}, {cell.nodes[0]}, {cell.nodes[1]}",
                f"*CONNECTOR SECTION, ELSET={label}, BEHAVIOR={label}",
                "CARTESIAN,",
                f"*CONNECTOR BEHAVIOR, NAME={label}",
                f"*CONNECTOR ELASTICITY, COMPONENT={order.direction}",
                f"{cell.stiffness:.15e},",
                f"*CONNECTOR PLASTICITY, COMPONENT={order.direction}",
                "*CONNECTOR HARDENING, TYPE=ISOTROPIC",
                f"{cell.limit:.15e}, 0.",
            ]
        lines += [f"*ELSET, ELSET={name}_{index}, GENERATE", f"{patch[0].number}, {cell.number}, 1"]
    return {order.stem + order.suffix: "\n".join(lines) + "\n"}, order.accuracy
