"""Elements for OpenSees, in Tcl and Python: elastic, perfectly plastic materials in parallel.

``MultiLinear`` is no substitute: its reloading follows another rule than Masing's.
"""

from __future__ import annotations

from microslip.export.numbered_cells import numbered_cells
from microslip.export.order import Accuracy, Order


def write(order: Order) -> tuple[dict[str, str], Accuracy]:
    """One file; a name that ends in .tcl asks for Tcl."""
    tcl = order.suffix == ".tcl"
    lines = [f"# {line}" for line in order.header()]
    if tcl:
        lines += _usage(order, "source")
    else:
        lines += [*_usage(order, "exec, or import and call"), "", "", f"def {order.name}(ops):"]
        lines.append(
            f'    """Make the materials{_and_elements(order)}; the tag of the first sum."""'
        )
    sums = []
    for _, cells in numbered_cells(order, gap=1, connected=False):
        for cell in cells:
            yields = cell.limit / cell.stiffness
            words = "ElasticPP", cell.number, repr(cell.stiffness), repr(yields)
            lines.append(_command(tcl, "uniaxialMaterial", *words))
        total, tags = cells[-1].number + 1, [cell.number for cell in cells]
        lines.append(_command(tcl, "uniaxialMaterial", "Parallel", total, *tags))
        sums.append(total)
        if cells[0].nodes:
            ends = *cells[0].nodes, "-mat", total, "-dir", order.direction
            lines.append(_command(tcl, "element", "zeroLength", total, *ends))
    lines.append(f"set {order.name} {sums[0]}" if tcl else f"    return {sums[0]}")
    return {order.stem + order.suffix: "\n".join(lines) + "\n"}, order.accuracy


def _command(tcl: bool, command: str, *words: object) -> str:
    if tcl:
        return " ".join(map(str, (command, *words)))
    numbers = (f'"{w}"' if isinstance(w, str) and not _is_number(w) else str(w) for w in words)
    return f"    ops.{command}({', '.join(numbers)})"


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _and_elements(order: Order) -> str:
    return "" if not order.patches[0].nodes else " and elements"


def _usage(order: Order, how: str) -> list[str]:
    lines = [f"# To use: {how}; the tags begin at {order.first_number}."]
    if not order.patches[0].nodes:
        lines.append(
            f"# Then: element zeroLength TAG NODE NODE -mat <{order.name}> -dir {order.direction}"
        )
    return lines
