"""COMBIN40 elements for Ansys: a spring in series with a slider, in parallel."""

from __future__ import annotations

from microslip.export.numbered_cells import numbered_cells
from microslip.export.order import Accuracy, Order


def write(order: Order) -> tuple[dict[str, str], Accuracy]:
    """One macro of the preprocessor; types and real constants have the elements' numbers."""
    name = order.name.upper()
    kind = order.first_number
    lines = [f"! {line}" for line in order.header()]
    lines += [
        "! Displacements are those of the nodal coordinate systems.",
        "/PREP7",
        f"ET,{kind},COMBIN40",
        f"KEYOPT,{kind},3,{order.direction}",
        f"TYPE,{kind}",
    ]
    for index, patch in numbered_cells(order):
        for cell in patch:
            lines += [
                f"R,{cell.number},{cell.stiffness:.15e},0,0,0,{cell.limit:.15e},0",
                f"REAL,{cell.number}",
                f"EN,{cell.number},{cell.nodes[0]},{cell.nodes[1]}",
            ]
        lines += [
            f"ESEL,S,ELEM,,{patch[0].number},{cell.number}",
            f"CM,{name}_{index},ELEM",
            "ALLSEL",
        ]
    return {order.stem + order.suffix: "\n".join(lines) + "\n"}, order.accuracy
