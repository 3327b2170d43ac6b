"""Every parameter of a scan against the short-wave cut-off, on which all depend."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, sized
from microslip._core.frozen import Locked, lock
from microslip._core.units import engineering
from microslip.errors import InputError
from microslip.scans.checks import length_of
from microslip.scans.conditioning import condition, remaining
from microslip.scans.height_map import HeightMap
from microslip.scans.levelling import Level
from microslip.scans.summits import Summits, find_summits

_COUNT = 8
"""Cut-offs of the default table, besides none, at most."""
_STEP = 1.25
"""The least ratio of one to the next, about: closer ones say the same."""
_MIN_PIXELS = 4.0
"""The shortest cut-off, in pixels: a Gaussian filter needs some."""


@dataclass(frozen=True, eq=False)
class CutoffTable(Locked):
    """Parameters of a scan against the short-wave cut-off; one value for each in every array."""

    cutoff: Floats
    """Cut-offs [m], rising; 0 where there is none and the pixel decides."""
    rms: Floats
    """Root mean square height [m]."""
    m0: Floats
    m2: Floats
    m4: Floats
    """Moments [m^2], [-], [1/m^2]."""
    nayak: Floats
    """Nayak's alpha [-]."""
    mccool_density: Floats
    mccool_radius: Floats
    mccool_std: Floats
    mccool_mean_height: Floats
    """McCool's (1987) parameters, DOI 10.1115/1.3261349 [1/m^2], [m], [m], [m]."""
    counted: Floats
    """Summits counted [-]; NaN where they were not."""
    counted_density: Floats
    counted_radius: Floats
    counted_std: Floats
    counted_mean_height: Floats
    """Parameters of the counted summits [1/m^2], [m], [m], [m]."""
    notes: tuple[str, ...] = ()
    """Conditioning of the scan, and values that could not be computed with the reason."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns, the cut-off first."""
        return tuple(field.name for field in fields(self) if field.name != "notes")

    def rows(self) -> list[dict[str, float]]:
        """The table row by row, one for each cut-off, by the names of the columns."""
        columns = {name: getattr(self, name) for name in self.names}
        return [
            {name: float(values[row]) for name, values in columns.items()}
            for row in range(self.cutoff.size)
        ]


def default_cutoffs(scan: HeightMap) -> Floats:
    """Cut-offs from none over four pixels to an eighth of the shorter side, or more of it."""
    low = max(_MIN_PIXELS * max(scan.pixel), 1.25 * (scan.cutoff or 0.0))
    side = min(scan.size)
    high = max(side / 8.0, min(side / 3.0, 4.0 * low))
    if scan.long_cutoff is not None:
        high = min(high, 0.5 * scan.long_cutoff)
    if high < low:
        return np.zeros(1)
    steps = round(math.log(high / low) / math.log(_STEP))
    return np.append(0.0, np.geomspace(low, high, min(1 + steps, _COUNT)))


def over_cutoffs(
    scan: HeightMap,
    cutoffs: ArrayLike | Sequence[float | str | None] | None = None,
    *,
    level: Level | None = None,
    counted: bool = True,
    method: Literal["watershed", "neighbours"] = "watershed",
    prominence: float | str | None = None,
    progress: Callable[[int, int], None] | None = None,
    known: Summits | None = None,
) -> CutoffTable:
    """Every parameter against the short-wave cut-off, as of :meth:`microslip.Scan.over_cutoffs`.

    Evaluates a scan as it is: nothing is removed unless ``level`` says so. ``known`` are summits of
    this very scan, counted in this way: at their cut-off they are taken. Where a cut-off leaves too
    little a parameter is NaN, with a note.
    """
    lengths = default_cutoffs(scan) if cutoffs is None else _lengths(cutoffs)
    if lengths.ndim != 1 or (lengths < 0.0).any():
        raise InputError("`cutoffs` must be a series of lengths [m], or 0 for none")
    lengths = np.unique(lengths)
    # Levelled once; the filter works on what is left.
    levelled = scan if level is None else condition(scan, level=level)
    notes = list(levelled.notes)
    names = [field.name for field in fields(CutoffTable)[1:-1]]
    columns = {name: np.full(lengths.size, math.nan) for name in names}
    for row, cutoff in enumerate(lengths):
        short = float(cutoff) or None
        at = "no cut-off" if short is None else f"cut-off {engineering(short, 'm')}"
        filtered = None
        if counted and not scan.is_profile:
            try:
                # From the unfiltered scan: its noise decides which peaks are summits.
                summits = known
                if summits is None or not _same_length(summits.cutoff, short):
                    summits = find_summits(levelled, short, method=method, prominence=prominence)
                filtered = summits.scan
                _count(summits, columns, row)
            except InputError as error:
                notes.append(f"{at}: {error.text}")
        try:
            filtered = filtered or condition(levelled, cutoff=remaining(levelled, short))
            _measure(filtered, columns, row)
        except InputError as error:
            if cutoffs is not None and filtered is None:
                raise  # a cut-off of the user's that cannot be used
            notes.append(f"{at}: {error.text}")
        if progress is not None:
            progress(row + 1, lengths.size)
    if scan.is_profile and counted:
        notes.append("a profile has no summits to count")
    arrays = {name: lock(values) for name, values in columns.items()}
    return CutoffTable(lock(lengths), **arrays, notes=tuple(notes))


def _same_length(a: float | None, b: float | None) -> bool:
    return a == b or (a is not None and b is not None and math.isclose(a, b))


def _lengths(cutoffs: Any) -> Floats:
    """Cut-offs [m], of numbers and of text."""
    if isinstance(cutoffs, (str, list, tuple)):
        cutoffs = [
            0.0
            if item is None
            else length_of("cutoffs", item, "10 um")
            if isinstance(item, str)
            else item
            for item in ([cutoffs] if isinstance(cutoffs, str) else cutoffs)
        ]
    return np.atleast_1d(sized("cutoffs", cutoffs))


def _measure(scan: HeightMap, columns: dict[str, Floats], row: int) -> None:
    moments = scan.moments()
    for name in ("rms", "m0", "m2", "m4", "nayak"):
        columns[name][row] = getattr(moments, name)
    summits = moments.mccool()
    for name in ("density", "radius", "std", "mean_height"):
        columns[f"mccool_{name}"][row] = getattr(summits, name)


def _count(counted: Summits, columns: dict[str, Floats], row: int) -> None:
    summits = counted.statistics("counted")
    columns["counted"][row] = counted.count
    for name in ("density", "radius", "std", "mean_height"):
        columns[f"counted_{name}"][row] = getattr(summits, name)
