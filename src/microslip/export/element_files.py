"""Joints as elements of finite-element programs: Jenkins cells (spring and slider) in parallel."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from microslip._core.errors import InputError
from microslip.export.request import Accuracy, Order

Deck = tuple[dict[str, str | bytes], Accuracy]
"""Text by file name, and its accuracy."""

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


def numbered_cells(
    order: Order, *, gap: int = 0, connected: bool = True
) -> Iterator[tuple[int, list[JenkinsCell]]]:
    """Yield the index of each patch, from 1, and its cells with consecutive numbers.

    ``gap`` is the number of numbers left free after each patch. With ``connected``, InputError is
    raised for a patch without mesh nodes.
    """
    number = order.first_number
    for index, (patch, model) in enumerate(zip(order.patches, order.cell_models, strict=True), 1):
        if connected and not patch.nodes:
            raise InputError(
                f"`nodes` must be given for {order.kind}: the two nodes of the mesh that the "
                "joint connects, for example nodes=[[1, 2]]"
            )
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
            f"`first_number` must not repeat nodes of the mesh: {order.kind} adds nodes {first} to "
            f"{end - 1}, and the joint connects {', '.join(map(str, made_anew))}; for example "
            f"first_number={max(joined) + 1}"
        )


def _deck(order: Order, mark: str, lines: list[str]) -> Deck:
    text = "\n".join([*(f"{mark} {line}" for line in order.header()), *lines]) + "\n"
    return {order.stem + order.suffix: text}, order.accuracy


def abaqus(order: Order) -> Deck:
    """Return connector elements, elastic and perfectly plastic in one direction, for *INCLUDE."""
    name = order.name.upper()
    lines = ["** Directions are global; nodes that rotate need an orientation."]
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
    return _deck(order, "**", lines)


def ansys(order: Order) -> Deck:
    """Return a macro of COMBIN40 elements; real constants have the numbers of the elements."""
    name, kind = order.name.upper(), order.first_number
    lines = [
        "! Displacements refer to the nodal coordinate systems.",
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
        elements = f"ESEL,S,ELEM,,{patch[0].number},{cell.number}"
        lines += [elements, f"CM,{name}_{index},ELEM", "ALLSEL"]
    return _deck(order, "!", lines)


def calculix(order: Order) -> Deck:
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


def lsdyna(order: Order) -> Deck:
    """Return elastoplastic springs (discrete elements), each with its own part and material."""
    first = order.first_number
    lines = [
        "$ Fields of ten characters hold stiffnesses and limits to five digits or more.",
        "*KEYWORD",
        "*DEFINE_SD_ORIENTATION",
        _row(10, first, 0, *(float(k == order.direction) for k in (1, 2, 3))),
        "*SECTION_DISCRETE",
        _row(10, first, 0, 0.0, 0.0, 0.0, 0.0),
        _row(10, 0.0, 0.0),
    ]
    for index, patch in numbered_cells(order):
        for cell in patch:
            lines += [
                "*PART",
                f"{order.name} {cell.number}",
                _row(10, cell.number, first, cell.number),
                "*MAT_SPRING_ELASTOPLASTIC",
                _row(10, cell.number, cell.stiffness, 0.0, cell.limit),
                "*ELEMENT_DISCRETE",
                _row(8, cell.number, cell.number, *cell.nodes, first),
            ]
        numbers = [cell.number for cell in patch]
        lines += ["*SET_DISCRETE", _row(10, first - 1 + index)]
        lines += [_row(10, *numbers[i : i + 8]) for i in range(0, len(numbers), 8)]
    return _deck(order, "$", [*lines, "*END"])


def _row(width: int, *fields: float) -> str:
    texts = (str(f) if isinstance(f, int) else compact(f, width - 1) for f in fields)
    return "".join(text.rjust(width) for text in texts)


def nastran(order: Order) -> Deck:
    """Return rods for nonlinear solutions, and their constraints.

    The constraints form the MPC set ``order.first_number``. The two mesh nodes of a joint usually
    coincide, which would give a rod of length zero. Each patch therefore gets two grid points of
    its own, 1 m apart, which are constrained to move along the rod as the mesh nodes do in the
    direction of the joint.
    """
    first = order.first_number
    _own_nodes(order, 2 * len(order.patches))
    lines = [f"$ Case control needs MPC = {first}; its grid points also begin at {first}."]
    for index, patch in numbered_cells(order):
        ends = first + 2 * index - 2, first + 2 * index - 1
        for place, (grid_point, mesh) in enumerate(zip(ends, patch[0].nodes, strict=True)):
            lines += _card("GRID", grid_point, "", float(place), 0.0, 0.0, "", 23456)
            lines += _card("MPC", first, grid_point, 1, 1.0, mesh, order.direction, -1.0)
        for cell in patch:
            # Unit length and unit area: moduli are stiffnesses, stresses are forces.
            lines += _card("CROD", cell.number, cell.number, *ends)
            lines += _card("PROD", cell.number, cell.number, 1.0)
            lines += _card("MAT1", cell.number, cell.stiffness, "", 0.0)
            lines += _card("MATS1", cell.number, "", "PLASTIC", 0.0, 1, 1, cell.limit)
        lines.append(f"$ patch {index}: elements {patch[0].number} to {patch[-1].number}")
    return _deck(order, "$", lines)


def _card(name: str, *fields: float | str) -> list[str]:
    words = [compact(f, 16) if isinstance(f, float) else str(f) for f in fields]
    lines = []
    for i in range(0, len(words), 4):
        start = f"{name}*" if i == 0 else "*"
        lines.append((start.ljust(8) + "".join(w.ljust(16) for w in words[i : i + 4])).rstrip())
    return [*lines, "*"] if len(lines) % 2 else lines


def opensees(order: Order) -> Deck:
    """Return OpenSees commands for elastic, perfectly plastic materials in parallel.

    They are a Python script, or Tcl if the file name ends in .tcl. ``MultiLinear`` of OpenSees is
    not used: its reloading does not follow Masing's rules.
    """
    tcl, tied = order.suffix == ".tcl", bool(order.patches[0].nodes)
    how = "source" if tcl else "exec, or import and call"
    lines = [f"# To use: {how}; the tags begin at {order.first_number}."]
    if not tied:
        lines.append(
            f"# Then: element zeroLength TAG NODE NODE -mat <{order.name}> -dir {order.direction}"
        )
    if not tcl:
        parts = "materials and elements" if tied else "materials"
        lines += ["", "", f"def {order.name}(ops):"]
        lines.append(f'    """Make the {parts}; the tag of the first sum."""')
    sums = []
    for _, cells in numbered_cells(order, gap=1, connected=False):
        for cell in cells:
            words = "ElasticPP", cell.number, cell.stiffness, cell.limit / cell.stiffness
            lines.append(_command(tcl, "uniaxialMaterial", *words))
        total, tags = cells[-1].number + 1, [cell.number for cell in cells]
        lines.append(_command(tcl, "uniaxialMaterial", "Parallel", total, *tags))
        sums.append(total)
        if cells[0].nodes:
            ends = *cells[0].nodes, "-mat", total, "-dir", order.direction
            lines.append(_command(tcl, "element", "zeroLength", total, *ends))
    lines.append(f"set {order.name} {sums[0]}" if tcl else f"    return {sums[0]}")
    return _deck(order, "#", lines)


def _command(tcl: bool, command: str, *words: object) -> str:
    if tcl:
        return " ".join(map(str, (command, *words)))
    arguments = (f'"{word}"' if isinstance(word, str) else repr(word) for word in words)
    return f"    ops.{command}({', '.join(arguments)})"


def compact(value: float, width: int) -> str:
    """Format a number with a decimal point, as accurately as ``width`` characters allow."""
    best, smallest_error = "", math.inf
    for digits in range(1, 18):
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        point = "" if "." in mantissa else "."
        for text in (f"{value:.{digits}f}", f"{mantissa}{point}E{int(exponent)}"):
            error = abs(float(text) - value)
            if len(text) <= width and error < smallest_error:
                best, smallest_error = text, error
    return best
