"""Joints as elements of finite-element programs: Jenkins cells (spring and slider) in parallel."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from microslip._core.errors import InputError
from microslip.export.request import Files, Order

# Corners of the CalculiX brick C3D8 in node order.
_CORNERS = (
    (0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1),
)  # fmt: skip


class JenkinsCell(NamedTuple):
    """Spring in series with a slider, between two mesh nodes if they are given."""

    number: int
    nodes: tuple[int, ...]
    stiffness: float
    limit: float


def numbered_cells(order: Order, gap: int = 0) -> Iterator[tuple[int, list[JenkinsCell]]]:
    """Yield the index of each patch, from 1, and its cells with consecutive numbers.

    ``gap`` is the number of numbers left free after each patch.
    """
    number = order.first_number
    for index, (patch, model) in enumerate(zip(order.patches, order.cell_models, strict=True), 1):
        columns = (np.asarray(c).tolist() for c in (model.stiffnesses, model.force_limits))
        pairs = enumerate(zip(*columns, strict=True), number)
        cells = [JenkinsCell(k, patch.nodes, *pair) for k, pair in pairs]
        number += len(cells) + gap
        yield index, cells


def _own_nodes(order: Order, count: int) -> None:
    """Raise InputError if one of the ``count`` nodes added by the file is already in a patch."""
    first, end = order.first_number, order.first_number + count
    joined = {node for patch in order.patches for node in patch.nodes}
    made_anew = sorted(node for node in joined if first <= node < end)
    if made_anew:
        raise InputError(
            f"`first_number` must not repeat nodes of the mesh: calculix adds nodes {first} to "
            f"{end - 1}, and the joint connects {', '.join(map(str, made_anew))}; for example "
            f"first_number={max(joined) + 1}"
        )


def _deck(order: Order, mark: str, lines: list[str]) -> Files:
    text = "\n".join([*(f"{mark} {line}" for line in order.header()), *lines]) + "\n"
    return {order.stem + order.suffix: text}


def calculix(order: Order) -> Files:
    """Return parallel unit cubes, elastic and perfectly plastic, loaded along x.

    A unit cube with free sides is a Jenkins cell: its modulus is the stiffness and its yield stress
    the force limit. Springs of CalculiX with a table are elastic, and its trusses, which it expands
    into bricks with hinges, did not converge in tests.
    """
    # CalculiX reads at most 20 characters of a number; these have 19.
    name, first = order.name.upper(), order.first_number
    _own_nodes(order, 8 * sum(model.cell_count for model in order.cell_models))
    lines = [
        "** To use: *INCLUDE, INPUT=this file, after the mesh and before the first *STEP; small",
        f"** displacements (no NLGEOM). Its nodes and elements begin at {first}.",
        f"** The force of patch 1: *NODE PRINT, NSET={name}_1, TOTALS=ONLY, with RF.",
    ]
    for index, cells in numbered_cells(order):
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
            # Two faces lie on symmetry planes.
            for n, corner in corners:
                lines += [f"{n}, {axis}, {axis}" for axis in (2, 3) if not corner[axis - 1]]
            for n, corner in corners if cell.nodes else ():
                end = cell.nodes[corner[0]]
                lines += ["*EQUATION", "2", f"{n}, 1, 1., {end}, {order.direction}, -1."]
            ends += [str(n) for n, corner in corners if corner[0]]
        lines += [f"*NSET, NSET={name}_{index}", *ends]
    if not order.patches[0].nodes:
        lines.append("** Tie its nodes at x = 0 and at x = 1 to the two sides of the joint.")
    return _deck(order, "**", lines)


def opensees(order: Order) -> Files:
    """Return OpenSees commands for elastic, perfectly plastic materials in parallel, in Python.

    ``MultiLinear`` of OpenSees is not used: its reloading does not follow Masing's rules.
    """
    tied = bool(order.patches[0].nodes)
    lines = [f"# Run by exec, or import and call the function; tags begin at {order.first_number}."]
    if not tied:
        lines.append(
            f"# Then: element zeroLength TAG NODE NODE -mat <{order.name}> -dir {order.direction}"
        )
    parts = "materials and elements" if tied else "materials"
    lines += ["", "", f"def {order.name}(ops):"]
    lines.append(f'    """Create the {parts}. Return the tag of the first parallel material."""')
    sums = []
    for _, cells in numbered_cells(order, gap=1):
        for cell in cells:
            words = "ElasticPP", cell.number, cell.stiffness, cell.limit / cell.stiffness
            lines.append(_command("uniaxialMaterial", *words))
        total, tags = cells[-1].number + 1, [cell.number for cell in cells]
        lines.append(_command("uniaxialMaterial", "Parallel", total, *tags))
        sums.append(total)
        if cells[0].nodes:
            ends = *cells[0].nodes, "-mat", total, "-dir", order.direction
            lines.append(_command("element", "zeroLength", total, *ends))
    lines.append(f"    return {sums[0]}")
    return _deck(order, "#", lines)


def _command(command: str, *words: object) -> str:
    arguments = (f'"{word}"' if isinstance(word, str) else repr(word) for word in words)
    return f"    ops.{command}({', '.join(arguments)})"
