"""Cells between the nodes of a mesh, numbered one after the other, and numbers in narrow fields."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from microslip.errors import Argument, InputError
from microslip.export.order import Order


class Cell(NamedTuple):
    """A spring in series with a slider, between two nodes where they are known."""

    number: int
    nodes: tuple[int, ...]
    stiffness: float
    limit: float


def numbered_cells(
    order: Order, *, gap: int = 0, connected: bool = True
) -> Iterator[tuple[int, list[Cell]]]:
    """The cells of each patch with its number, from 1; so many numbers stay free after a patch."""
    number = order.first_number
    for index, (patch, model) in enumerate(zip(order.patches, order.cell_models, strict=True), 1):
        if connected and not patch.nodes:
            raise InputError(
                Argument("nodes"),
                f" must be given for {order.kind}: the two nodes of the mesh that the joint lies "
                "between, for example nodes=[[1, 2]]",
            )
        values = zip(
            np.asarray(model.stiffnesses).tolist(),
            np.asarray(model.force_limits).tolist(),
            strict=True,
        )
        cells = [Cell(number + i, patch.nodes, *pair) for i, pair in enumerate(values)]
        number += len(cells) + gap
        yield index, cells


def compact(value: float, width: int) -> str:
    """A number with a decimal point in so many characters, as exact as they allow."""
    best, off = "", math.inf
    for digits in range(1, 18):
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        point = "" if "." in mantissa else "."
        for text in (f"{value:.{digits}f}", f"{mantissa}{point}E{int(exponent)}"):
            error = abs(float(text) - value)
            if len(text) <= width and error < off:
                best, off = text, error
    return best
