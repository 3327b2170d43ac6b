"""Figure of a measured face: pressures, contacts under three loads, and load curve."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from microslip._core.checks import Floats
from microslip._core.errors import InputError
from microslip._core.quantities import Quantity
from microslip._core.units import engineering
from microslip.contact.base import NormalLaw
from microslip.figures.kit import axis_of, coloured, length_prefix, map_panel
from microslip.figures.plot import COLORS, Area, Entry, Line, Panel, Pixels, Plot

_CONTACTS = ("#c9dcec", "#5b9bd0", "#08306b")  # under heavy, middle and light loads
_SHARES = (1.0, 0.15, 0.023)
_PIECES = "#dddddd"
_RANGE = 3e-3  # of the heaviest load, to which loads are drawn
_POINTS = 60


def face_plot(law: Any) -> Plot:
    """Plot the pressures of the first piece, its contacts under three loads, and the load curve.

    Parameters
    ----------
    law : MeasuredContact
        The face.
    """
    solution, numbers = law.solution, law.numbers
    stiff = law.pair.composite_modulus
    rows, columns = solution.map.shape
    size = max(columns * numbers.pixel[0], rows * numbers.pixel[1])
    scale = length_prefix(size)
    unit = scale[0]
    ends = 0.0, columns * numbers.pixel[0] / unit, 0.0, rows * numbers.pixel[1] / unit
    maps = [map_panel(ends, scale, column) for column in (0, 1)]
    highest = float(solution.map.max())
    pressures = np.where(solution.map > 0.0, solution.map, np.nan)
    maps[0].add(Pixels(coloured(pressures[::-1], 0.0, highest), *ends))
    top = engineering(stiff * highest, "Pa")
    piece = f", piece 1 of {numbers.pieces}: "
    maps[0].note = f"Pressure{', dark to light: ' if numbers.pieces == 1 else piece}0 to {top}"
    means = stiff * solution.pressure.mean(axis=1)
    levels = [int(np.argmin(np.abs(np.log(means / means[0] / share)))) for share in _SHARES]
    image = np.full((rows, columns, 3), 255, dtype=np.uint8)
    for level, color in zip(levels, _CONTACTS, strict=True):
        image[solution.reach > level] = [int(color[i : i + 2], 16) for i in (1, 3, 5)]
    maps[1].add(Pixels(image[::-1], *ends))
    texts = ", ".join(engineering(float(means[level]), "Pa", 2) for level in levels)
    maps[1].note = f"Contact{' under ' if numbers.pieces == 1 else piece}{texts}"
    curves, entries = load_panel(law)
    curves.cell = (1, 1, 0, 1)
    height = 3.4 * (ends[3] - ends[2]) / (ends[1] - ends[0])
    height = min(max(height, 1.5), 6.0)
    return Plot(
        [*maps, curves], height + 3.9, heights=(height, 3.0), widths=(1.0, 1.0),
        legend=tuple(entries),
    )  # fmt: skip


def load_panel(law: Any) -> tuple[Panel, Sequence[Entry]]:
    """Plot pressure against separation since the heaviest load; a band contains all pieces."""
    top = law.numbers.pressure * law.area
    loads = np.geomspace(1.0, _RANGE, _POINTS) * top * (1.0 - 1e-9)
    pressures = loads / law.area
    scale = (1e6, "M") if pressures[0] >= 1e6 else (1e3, "k")
    step = np.asarray(law.separation(loads))
    step = step - step[0]
    beyond = f"Separation beyond that at {engineering(float(pressures[0]), 'Pa')}"
    panel = Panel(
        axis_of(Quantity("m", label=beyond), float(step[-1])),
        axis_of(Quantity("Pa", label="Pressure"), scale, log=True),
    )
    length, unit = panel.x.unit, panel.y.unit
    entries = []
    bearing = np.flatnonzero((law.solution.pressure > 0.0).sum(axis=0) > 1)
    pieces = [_opened(law.of_pieces([i]), loads) for i in bearing]
    steps_of_pieces = [piece for piece in pieces if piece is not None]
    if len(steps_of_pieces) > 1:
        low, high = (
            np.min(steps_of_pieces, axis=0) / length,
            np.max(steps_of_pieces, axis=0) / length,
        )
        levels = pressures / unit
        panel.add(Area(np.append(low, high[::-1]), np.append(levels, levels[::-1]), _PIECES))
        entries.append(Entry("its pieces", _PIECES))
    panel.add(Line(step / length, pressures / unit, COLORS[0], 2.2))
    entries.append(Entry("point by point", COLORS[0]))
    return panel, entries


def _opened(law: NormalLaw, loads: Floats) -> Floats | None:
    """Return the increases of separation [m] from the first load; None if out of range."""
    try:
        d = np.asarray(law.separation(loads), dtype=float)
    except InputError:
        return None
    return np.asarray(d - d[0])
