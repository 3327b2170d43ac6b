"""JSON: columns by their names, structs of numbers with their units, or a list of rows.

A few letters can hold much, so a child process reads.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from microslip.readers.arrays import Arrays, arrays_in
from microslip.readers.child import parsed
from microslip.readers.files import Unusable, refuse_beyond

MAX_BYTES = 1_000_000_000


def read_arrays(path: Path) -> Arrays:
    """All lists of numbers of a file, by their names; null is no number."""
    if (size := path.stat().st_size) > MAX_BYTES:
        raise ValueError(
            f"wanted JSON of at most {MAX_BYTES // 1_000_000} MB, got {size // 1_000_000} MB; save "
            "it as HDF5 or Parquet"
        )
    return Arrays("JSON file", arrays_in(parsed("JSON file", path, read_tree)), ".")


# ------------------------------------------------------------------ what runs in the child


def read_tree(path: Path) -> dict[str, Any]:
    """Numbers and texts by their names, lists of numbers as arrays."""
    content = path.read_bytes()
    refuse_beyond(content.count(b","))
    tree = json.loads(content.decode("utf-8-sig"))
    if isinstance(tree, list) and tree and all(isinstance(row, dict) for row in tree):
        names = dict.fromkeys(name for row in tree for name in row)
        refuse_beyond(len(names), len(tree))
        tree = {name: [row.get(name) for row in tree] for name in names}
    if not isinstance(tree, dict):
        raise Unusable("wanted JSON with columns by their names, or a list of rows")
    return _arrays(tree)


def _arrays(tree: Mapping[str, Any]) -> dict[str, Any]:
    result: dict[str, Any] = {}
    for name, value in tree.items():
        if isinstance(value, dict):
            result[name] = _arrays(value)
        elif isinstance(value, list):
            with suppress(TypeError, ValueError, OverflowError):  # no numbers
                plain = [np.nan if item is None else item for item in value]
                result[name] = np.array(plain, dtype=float)
        else:
            result[name] = value
    return result
