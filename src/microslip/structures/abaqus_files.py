"""Reader of the text files that Abaqus writes by *MATRIX OUTPUT and *SUBSTRUCTURE MATRIX OUTPUT.

The formats are those of the Abaqus Keywords Guide: MATRIX INPUT and LABELS (node and degree of
freedom of each row and column), COORDINATE (equation numbers), and for a substructure the linear
*USER ELEMENT (lower triangles of the symmetric matrices, row by row).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

from microslip._core.checks import Floats
from microslip._core.errors import InputError
from microslip.readers.child import parsed
from microslip.readers.files import refuse_beyond

_BYTES_A_SECOND: Final = 2e6
_OF_A_JOB: Final = re.compile(r"(.*)_(STIF|MASS|DMPV)(\d*)", re.IGNORECASE)
_PARTS: Final = {"stiffness": "STIF", "mass": "MASS", "damping": "DMPV"}
_TYPES: Final = {"STIFFNESS": "stiffness", "MASS": "mass", "VISCOUSDAMPING": "damping"}
_FIXED: Final = 1e35
"""Diagonal stiffness [N/m] with which Abaqus enforces boundary conditions."""


def load_abaqus(file: Path) -> dict[str, Any]:
    """Read the matrices of an Abaqus substructure, or of the matrix files of one job, by kind.

    The kinds are "mass", "stiffness" and "damping", as far as the files contain them. Rows are
    sorted by node, then by degree of freedom; fixed degrees of freedom are removed.
    """
    files = {"": file}
    if job := _OF_A_JOB.fullmatch(file.stem):
        beside = {kind: f"{job[1]}_{part}{job[3]}".casefold() for kind, part in _PARTS.items()}
        names = {path.stem.casefold(): path for path in file.parent.glob("*.[mM][tT][xX]")}
        files = {kind: names[stem] for kind, stem in beside.items() if stem in names}
    found: dict[str, Any] = {}
    for kind, path in files.items():
        content = parsed("Abaqus matrix file", path, read_abaqus, bytes_a_second=_BYTES_A_SECOND)
        found |= {kind or name: matrix for name, matrix in content.items()}
    parts = {kind: (part["places"].tolist(), part["matrix"]) for kind, part in found.items()}
    matrices = over_all_places(parts)
    if "stiffness" not in matrices:
        return matrices
    free = np.flatnonzero(matrices["stiffness"].diagonal() < _FIXED)
    return {kind: matrix[free][:, free] for kind, matrix in matrices.items()}


def over_all_places(parts: Mapping[str, tuple[list[list[int]], Any]]) -> dict[str, Any]:
    """Expand matrices to all nodes and degrees of freedom that occur in any of them."""
    from scipy.sparse import coo_matrix

    every = sorted({tuple(place) for places, _ in parts.values() for place in places})
    number = {place: k for k, place in enumerate(every)}
    result = {}
    for kind, (places, entries) in parts.items():
        at = np.array([number[tuple(place)] for place in places])
        index = (at[entries.row], at[entries.col])
        result[kind] = coo_matrix((entries.data, index), shape=(len(every),) * 2).tocsc()
    return result


# ------------------------------------------------------------------ what runs in the child


def read_abaqus(path: Path) -> dict[str, Any]:
    """Return the matrices of a file by type, with the node and degree of freedom of each row."""
    lines = path.read_text(encoding="latin-1").splitlines()
    if lines and lines[0].startswith("%%MatrixMarket"):
        raise InputError(
            "is a Matrix Market file: give its folder, with mass.mtx and stiffness.mtx"
        )
    if any(line[:13].upper().replace(" ", "") == "*USERELEMENT" for line in lines):
        return _substructure(lines)
    rows = [line for line in lines if line.strip() and not line.lstrip().startswith(("*", "%"))]
    width = len(_words(rows[0])) if rows else 0
    if width not in (3, 5):
        raise ValueError(
            "wanted rows of node, degree of freedom, node, degree of freedom, value, or of row, "
            f"column, value, got {width} numbers"
        )
    refuse_beyond(len(rows), width)
    table = np.loadtxt((row.replace(",", " ") for row in rows), ndmin=2, comments=None)
    if table.shape[1] != width:
        raise ValueError(f"wanted {width} numbers in each row, got {table.shape[1]}")
    places = table[:, :-1].astype(np.int64)
    if (places != table[:, :-1]).any():
        raise ValueError("nodes and degrees of freedom must be whole numbers")
    ends = np.concatenate(np.split(places, 2, axis=1))
    known, at = np.unique(ends, axis=0, return_inverse=True)
    row, column = np.split(at.ravel(), 2)
    return {"": {"places": known, "matrix": _mirrored(row, column, table[:, -1], len(known))}}


def _words(text: str) -> list[str]:
    return text.replace(",", " ").split()


def _mirrored(row: Any, column: Any, values: Floats, size: int) -> Any:
    from scipy.sparse import coo_matrix

    given = set(zip(row.tolist(), column.tolist(), strict=True))
    if len(given) < len(values):
        raise ValueError("gives an entry twice: wanted assembled matrices, not those of elements")
    alone = np.array([(j, i) not in given for i, j in zip(row, column, strict=True)], dtype=bool)
    return coo_matrix(
        (
            np.append(values, values[alone]),
            (np.append(row, column[alone]), np.append(column, row[alone])),
        ),
        shape=(size, size),
    )


def _substructure(lines: list[str]) -> dict[str, Any]:
    blocks: list[tuple[str, list[str]]] = []
    for line in lines:
        if line.startswith("*") and not line.startswith("**"):
            blocks.append((line.upper().replace(" ", ""), []))
        elif blocks and line.strip() and not line.startswith("**"):
            blocks[-1][1].append(line)
    head, degrees = next(block for block in blocks if block[0].startswith("*USERELEMENT"))
    full = "UNSYM" in head
    nodes = re.search(r"NODES=(\d+)", head)
    places = _degrees(int(nodes[1]) if nodes else 0, degrees)
    found = {}
    for title, rows in blocks:
        kind = re.match(r"\*MATRIX,TYPE=(\w+)", title)
        if kind is None or kind[1] not in _TYPES:
            continue
        values = np.array([float(word) for row in rows for word in _words(row)])
        size = round(np.sqrt(len(values)) if full else (np.sqrt(8.0 * len(values) + 1.0) - 1) / 2)
        if size != len(places) or len(values) != (size**2 if full else size * (size + 1) // 2):
            raise ValueError(
                f"the {_TYPES[kind[1]]} has {len(values)} numbers, and its nodes have "
                f"{len(places)} degrees of freedom"
            )
        row, column = np.indices((size, size)).reshape(2, -1) if full else np.tril_indices(size)
        name = _TYPES[kind[1]]
        found[name] = {"places": places, "matrix": _mirrored(row, column, values, size)}
    if not found:
        raise ValueError("holds no *MATRIX of stiffness or mass")
    return found


def _degrees(count: int, rows: list[str]) -> Any:
    """Return the node (index in the element) and degree of freedom of each matrix row.

    The first line lists the degrees of freedom of the first node. Each further line starts with the
    index of the node from which its list applies.
    """
    refuse_beyond(10 * count)
    lists: dict[int, list[int]] = {}
    for number, row in enumerate(rows):
        words = [int(word) for word in _words(row)]
        lists[words[0] if number else 1] = words[1:] if number else words
    places, current = [], list[int]()
    for node in range(1, count + 1):
        current = lists.get(node, current)
        places += [(node, degree) for degree in current]
        refuse_beyond(len(places))
    if not places:
        raise InputError("names no degrees of freedom")
    return np.array(places, dtype=np.int64)
