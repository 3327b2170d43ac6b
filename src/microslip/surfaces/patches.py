"""Division of a scan into patches."""

from __future__ import annotations

import math
from typing import Any, TypeVar

import numpy as np

from microslip._core.checks import show
from microslip._core.errors import InputError
from microslip.surfaces.height_map import HeightMap

Map = TypeVar("Map", bound=HeightMap)


def cut(scan: Map, patches: tuple[int, int] | int = (3, 3)) -> list[Map]:
    """Divide a scan into patches of equal size, within one point."""
    counts = _counts(patches, scan.heights.ndim)
    if math.prod(counts) < 2:
        raise InputError(f"`patches` must be two or more, got {show(patches)}")
    if any(n // count < 8 for n, count in zip(scan.heights.shape, counts, strict=True)):
        raise InputError(
            f"`patches` must have at least eight points along each side, got {show(patches)} "
            f"patches of {' x '.join(str(n) for n in scan.heights.shape)} points"
        )
    edges = [
        np.linspace(0, n, count + 1).astype(int)
        for n, count in zip(scan.heights.shape, counts, strict=True)
    ]
    parts = []
    for index in np.ndindex(*counts):
        where = tuple(
            slice(int(edge[i]), int(edge[i + 1])) for edge, i in zip(edges, index, strict=True)
        )
        heights = scan.heights[where]
        if np.isnan(heights).all():
            continue
        patch = scan.changed(
            heights,
            name=f"{scan.name}, patch {index}",
            notes=(*scan.notes, f"patch {index} of {counts}"),
        )
        parts.append(patch)
    return parts


def _counts(patches: Any, axes: int) -> tuple[int, ...]:
    counts = patches if isinstance(patches, (tuple, list)) else (patches,) * axes
    # The default (3, 3) is for an area; a profile gets the same number of patches.
    if axes == 1 and len(counts) == 2 and all(_is_count(n) for n in counts):
        counts = (int(counts[0]) * int(counts[1]),)
    if len(counts) != axes or not all(_is_count(n) for n in counts):
        raise InputError(
            f"`patches` must be whole numbers above zero, one for each axis, got {show(patches)}"
        )
    return tuple(int(n) for n in counts)


def _is_count(value: Any) -> bool:
    return isinstance(value, (int, np.integer)) and not isinstance(value, bool) and int(value) > 0
