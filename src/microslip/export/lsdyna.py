"""Discrete elements for LS-DYNA: elastoplastic springs in parallel."""

from __future__ import annotations

from microslip.export.numbered_cells import compact, numbered_cells
from microslip.export.order import Accuracy, Order

_WIDE, _NARROW = 10, 8


def write(order: Order) -> tuple[dict[str, str], Accuracy]:
    """One file to be included; parts, sections and materials have numbers of their own."""
    lines = [f"$ {line}" for line in order.header()]
    lines += [
        "$ Fields of ten characters round stiffnesses and limits to five digits or more.",
        "*KEYWORD",
        "*DEFINE_SD_ORIENTATION",
        _row(_WIDE, order.first_number, 0, *(float(k == order.direction) for k in (1, 2, 3))),
        "*SECTION_DISCRETE",
        _row(_WIDE, order.first_number, 0, 0.0, 0.0, 0.0, 0.0),
        _row(_WIDE, 0.0, 0.0),
    ]
    for index, patch in numbered_cells(order):
        for cell in patch:
            lines += [
                "*PART",
                f"{order.name} {cell.number}",
                _row(_WIDE, cell.number, order.first_number, cell.number),
                "*MAT_SPRING_ELASTOPLASTIC",
                _row(_WIDE, cell.number, cell.stiffness, 0.0, cell.limit),
                "*ELEMENT_DISCRETE",
                _row(_NARROW, cell.number, cell.number, *cell.nodes, order.first_number),
            ]
        numbers = [cell.number for cell in patch]
        lines += ["*SET_DISCRETE", _row(_WIDE, order.first_number - 1 + index)]
        lines += [_row(_WIDE, *numbers[i : i + 8]) for i in range(0, len(numbers), 8)]
    lines.append("*END")
    return {order.stem + order.suffix: "\n".join(lines) + "\n"}, order.accuracy


def _row(width: int, *fields: float) -> str:
    return "".join(
        (str(field) if isinstance(field, int) else compact(field, width - 1)).rjust(width)
        for field in fields
    )
