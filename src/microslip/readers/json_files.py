"""JSON: columns by their names, structs of numbers with their units, or a list of rows."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from microslip.readers.arrays import Arrays, Leaf
from microslip.readers.files import decoded, refuse_beyond

MAX_BYTES = 1_000_000_000


def read_arrays(path: Path) -> Arrays:
    """All lists of numbers of a file, by their names; null is no number."""
    if (size := path.stat().st_size) > MAX_BYTES:
        raise ValueError(
            f"wanted JSON of at most {MAX_BYTES // 1_000_000} MB, got {size // 1_000_000} MB; save "
            "it as HDF5 or Parquet"
        )
    with decoded("JSON file"):
        content = path.read_bytes()
        refuse_beyond(content.count(b","))
        tree = json.loads(content.decode("utf-8-sig"))
    if isinstance(tree, list) and tree and all(isinstance(row, dict) for row in tree):
        names = dict.fromkeys(name for row in tree for name in row)
        tree = {name: [row.get(name) for row in tree] for name in names}
    if not isinstance(tree, dict):
        raise ValueError("wanted JSON with columns by their names, or a list of rows")
    return Arrays("JSON file", _leaves(tree), ".")


def _leaves(tree: Mapping[str, Any]) -> dict[str, Any]:
    leaves: dict[str, Any] = {}
    for name, value in tree.items():
        if isinstance(value, dict):
            leaves[name] = _leaves(value)
        elif isinstance(value, list):
            try:
                numbers = np.array(
                    [np.nan if item is None else item for item in value], dtype=float
                )
            except (TypeError, ValueError, OverflowError):
                continue
            leaves[name] = Leaf(numbers.shape, numbers.copy)
        else:
            leaves[name] = value
    return leaves
