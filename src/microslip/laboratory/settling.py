"""Settled cycles of a record, over which means are taken.

A mean over stepped amplitudes or running-in does not describe any cycle, but its confidence
interval narrows with the number of cycles. So means are taken over cycles without trends.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip._core.units import engineering
from microslip._core.wording import plural
from microslip.laboratory.estimates import CERTAIN, Trend, dependence_of, quantile, trend

ALIKE, MORE_ALIKE = 0.02, 0.003
"""Largest relative change of force or energy over a settled stretch, and the one tried first."""
ONE_AMPLITUDE = 0.01
"""Largest relative range of cycles of one amplitude, unless noise makes it larger."""
_DRIFT = 1.1
"""Largest over smallest amplitude of a drift; more is a run-up."""
_NOISE = 10.0
"""Largest range of the amplitudes of like cycles over their noise."""
OPEN = 0.25
"""Closure error above which a cycle is left out of the means."""
_MOST_LOSS = 1.05 * 4.0 / math.pi  # of a rectangle, with a margin for noise
FEWEST = 5
"""Fewest cycles of a settled stretch."""
JUDGED, HALVED = 8, 20
"""Fewest cycles for a trend of force and energy, and for a settled part of a record."""
ALIKE_OF_FEW, CHANCE = 0.0075, 0.01
"""Largest relative trend of the amplitude of few settled cycles, and the significance level."""
SLOWER = 0.25
"""Largest rate of change at the end of a record over that of all of it."""
_DISTINCT = 3.0
"""Standard errors by which rates differ significantly."""
_FEW_FREE = 5
"""Degrees of freedom up to which the mean of correlated cycles is unknown."""
_HALVES, _MOST_STRETCHES = 6, 64
_JITTER = 4.0
"""Largest range of irregular amplitudes over that of like ones."""
_LOSS = 0.01
"""Smallest scale for changes of the energy, over the rectangle around a loop."""
_MOVING = ("force_amplitude", "dissipated_energy", "force_rms")


class Settled(NamedTuple):
    """Selection of cycles without trends, with notes on cycles left out."""

    selection: NDArray[np.bool_]
    """Mask of the cycles of the means."""
    is_moving: bool
    """Whether no settled stretch was found; then all valid cycles are selected."""
    notes: tuple[str, ...]
    levels: tuple[tuple[NDArray[np.intp], bool], ...] = ()
    """Settled cycles at each of several amplitudes, or all its cycles if none are settled, and
    whether none are; empty with a single amplitude."""


def excess_loss_notes(loss_factor: NDArray[np.float64]) -> list[str]:
    """Return notes on loops with a larger area than the rectangle around their reversal points."""
    large = loss_factor > _MOST_LOSS
    if not large.any():
        return []
    return [
        f"the loss factor exceeds 4/π = 1.27, the limit of friction alone: it is up to "
        f"{float(np.nanmax(loss_factor)):.3g} in {named_cycles(large)}; viscous or inertial "
        "forces, or spikes, increase the area of the loops"
    ]


def named_cycles(is_named: NDArray[np.bool_]) -> str:
    """Format the number of selected cycles and their numbers, such as "2 cycles (3, 8)"."""
    places = np.flatnonzero(is_named) + 1
    numbers = ", ".join(map(str, places[:5])) + (", ..." if places.size > 5 else "")
    return f"{plural(places.size, 'cycle')} ({numbers})"


def settled(columns: Mapping[str, Floats], sound: NDArray[np.bool_], noise: float = 0.0) -> Settled:
    """Find the settled cycles among the ``sound`` ones, which are closed and have no spikes.

    If there are several amplitudes, each is a level, and the longest one is selected; single cycles
    of other amplitudes, such as a run-up, are left out, unless the record is nothing else: then all
    are selected, as not settled. At one amplitude the selection is the end of the record over which
    force and energy change by at most 0.3 %, or by 2 % if they never change so little. ``noise``
    [m] is the error of an amplitude.
    """
    places = np.flatnonzero(sound)
    notes: list[str] = []
    levels: tuple[tuple[NDArray[np.intp], bool], ...] = ()
    if places.size > 1:
        amplitudes = columns["amplitude"][places]
        parts = _one_amplitude(amplitudes, noise)
        if not parts:
            return _without_plateau(columns, places, sound.size)
        largest = max(parts, key=len)
        if len(parts) > 1:
            means = sorted(float(amplitudes[part].mean()) for part in parts)
            low, high = (engineering(end, "m") for end in (means[0], means[-1]))
            notes.append(
                f"the amplitude is not the same in all cycles: {len(parts)} amplitudes from {low} "
                f"to {high}. Each has its own means; those of the record are over cycles "
                f"{places[largest[0]] + 1} to {places[largest[-1]] + 1}"
            )
            late_ones = [settled_from(columns, places[part]) for part in parts]
            levels = tuple(
                (places[part][late or 0 :], late is None)
                for part, late in zip(parts, late_ones, strict=True)
            )
        elif largest.size < places.size:
            others = np.delete(places, largest)
            mean = engineering(float(amplitudes[largest].mean()), "m")
            ends = (end(columns["amplitude"][others]) for end in (np.min, np.max))
            low, high = (engineering(float(end), "m") for end in ends)
            notes.append(
                f"left out of the means: {named_cycles(_mask(others, sound.size))} at "
                f"{low if others.size == 1 else f'{low} to {high}'}, as in a run-up; the others "
                f"have an amplitude of {mean}"
            )
        places = places[largest]
    late = settled_from(columns, places)
    if late is None:
        notes.append(_moving_note(columns, places, _MOVING[:2]))
        return Settled(_mask(places, sound.size), True, tuple(notes), levels)
    if late > 0:
        notes.append(
            f"force or energy still moves at first: {_span(columns, places, _MOVING[:2])} from "
            f"cycle {places[0] + 1} to {places[-1] + 1}; means are over cycles {places[late] + 1} "
            f"to {places[-1] + 1}, where neither changes by more than {100.0 * ALIKE:g} %"
        )
    return Settled(_mask(places[late:], sound.size), False, tuple(notes), levels)


def _without_plateau(columns: Mapping[str, Floats], places: NDArray[np.intp], size: int) -> Settled:
    """Select all cycles; after a run-up, stretches of one amplitude are levels too."""
    amplitudes, note = np.abs(columns["amplitude"]), _moving_note(columns, places, ("amplitude",))
    if amplitudes[places].max() <= _DRIFT * amplitudes[places].min():
        return Settled(_mask(places, size), True, (note,))
    parts = [places[:1]]
    for row in places[1:]:
        low, high = sorted((amplitudes[parts[-1][0]], amplitudes[row]))
        if high <= (1.0 + ONE_AMPLITUDE) * low:
            parts[-1] = np.append(parts[-1], row)
        else:
            parts.append(np.array([row]))
    note += f"; each of {len(parts)} amplitudes has its own results"
    return Settled(_mask(places, size), True, (note,), tuple((part, True) for part in parts))


def requested(columns: Mapping[str, Floats], selection: NDArray[np.bool_]) -> Settled:
    """Select the requested cycles, and decide whether they are settled."""
    places = np.flatnonzero(selection)
    if _moving(columns, places, ALIKE):
        return Settled(selection, True, (_moving_note(columns, places, _MOVING[:2]),))
    return Settled(selection, False, ())


def settled_from(columns: Mapping[str, Floats], places: NDArray[np.intp]) -> int | None:
    """Return the index in ``places`` of the first settled cycle; None if cycles never settle."""
    late = _settled_end(columns, places, MORE_ALIKE)
    late = _settled_end(columns, places, ALIKE) if late is None else late
    if late:
        # If the end itself wanders, the change before it may be chance.
        ends = [dependence_of(columns[name][places[late:]]) for name in _MOVING[:2]]
        if any(end.factor > 1.0 and end.freedom <= _FEW_FREE for end in ends):
            return None
    return late


def _one_amplitude(values: Floats, noise: float) -> list[NDArray[np.intp]]:
    """Group cycles of like amplitude [m]; return no group if the amplitude changes steadily."""
    usual = float(np.median(np.abs(values)))
    logs = np.log(np.maximum(np.abs(values), 1e-9 * max(usual, 1e-300)))
    jitter = 0.0
    if values.size >= JUDGED:
        # Steps enlarge one estimate, ramps the other; for like cycles both are the noise.
        second = float(np.median(np.abs(np.diff(logs, 2)))) / 0.6745 / math.sqrt(6.0)
        first = float(np.quantile(np.abs(np.diff(logs)), 0.3)) / 0.3853 / math.sqrt(2.0)
        jitter = min(first, second)
    # The noise of few cycles is poorly known.
    factor = _NOISE * (1.0 + 4.0 / math.sqrt(values.size))
    share = max(ONE_AMPLITUDE, factor * jitter)
    # Amplitudes in steps of what is alike: a share of large ones, the noise of small ones.
    smallest = factor * noise / share
    levels = np.log(np.maximum(np.abs(values), max(smallest, 1e-9 * usual, 1e-300))) / share
    if smallest > 0.0:
        levels += np.minimum(np.abs(values) / smallest, 1.0) / share
    if float(np.ptp(levels)) <= 1.0:
        is_ramp = 2 < values.size < HALVED and _moves(logs, ALIKE_OF_FEW)
        return [] if is_ramp else [np.arange(values.size)]
    runs: list[tuple[int, int]] = []
    open_stretches = [(0, values.size)]
    for _ in range(_MOST_STRETCHES):
        if not open_stretches:
            break
        open_stretches.sort(key=lambda stretch: stretch[1] - stretch[0])
        first_of, stop = open_stretches.pop()
        begin, end = _longest(levels[first_of:stop])
        if end - begin < 2:
            continue
        begin, end = begin + first_of, end + first_of
        open_stretches += [(first_of, begin), (end, stop)]
        if _is_level(levels, begin, end):
            runs.append((begin, end))
    if not runs and float(np.ptp(levels)) <= _JITTER and not _moves(logs, ALIKE_OF_FEW):
        return [np.arange(values.size)]
    groups: list[list[tuple[int, int]]] = []
    for begin, end in sorted(runs):
        middle = float(np.median(levels[begin:end]))
        for group in groups:
            if abs(float(np.median(levels[group[0][0] : group[0][1]])) - middle) < 0.5:
                group.append((begin, end))
                break
        else:
            groups.append([(begin, end)])
    return [np.concatenate([np.arange(*run) for run in group]) for group in groups]


def _is_level(levels: Floats, begin: int, end: int) -> bool:
    if end - begin < FEWEST:
        # Too few cycles for a trend: the amplitude must jump before and after them.
        inside = float(levels[begin:end].mean())
        beside = [levels[at] for at in (begin - 1, end) if 0 <= at < levels.size]
        change = abs(float(levels[end - 1] - levels[begin]))
        return change < 0.5 and all(abs(at - inside) > 2.0 for at in beside)
    return not _moves(levels[begin:end], 0.25)


def _longest(values: Floats) -> tuple[int, int]:
    """Return begin and end of the longest stretch of values with a range of up to 1."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    begin, shortest, longest = 0, 1, values.size
    while shortest < longest:
        size = (shortest + longest + 1) // 2
        # Filters are centred; windows that reach beyond the ends are left out.
        whole = slice(size // 2, values.size - (size - 1) // 2)
        ranges = maximum_filter1d(values, size)[whole] - minimum_filter1d(values, size)[whole]
        fine = np.flatnonzero(ranges <= 1.0)
        if fine.size:
            begin, shortest = int(fine[0]), size
        else:
            longest = size - 1
    return begin, begin + shortest


def _moves(values: Floats, smallest: float) -> bool:
    """Return whether values have a significant trend that changes them by over ``smallest``."""
    slope, error = _slope(values)[:2]
    certain = CERTAIN
    if values.size < HALVED:
        certain = max(certain, quantile(1.0 - CHANCE, max(values.size - 2, 1)))
    return abs(slope * (values.size - 1)) > smallest and abs(slope) > certain * error


def _slope(values: Floats) -> Trend:
    return trend(np.arange(values.size, dtype=float), values)


def _moving(
    columns: Mapping[str, Floats], places: NDArray[np.intp], alike: float
) -> dict[str, float]:
    """Return the size of the slope per cycle of each column with a trend in ``places``.

    A trend is significant and changes the column by more than the fraction ``alike``.
    """
    if places.size < JUDGED:
        return {}
    around = 4.0 * abs(
        float(np.median(columns["amplitude"][places]))
        * float(np.median(columns["force_amplitude"][places]))
    )
    moving = {}
    for name in columns.keys() & set(_MOVING):
        values = columns[name][places]
        usual = abs(float(np.median(values)))
        if name == "dissipated_energy":
            usual = max(usual, _LOSS * around)
        if _moves(values, alike * usual):
            moving[name] = abs(_slope(values)[0])
    return moving


def _settled_end(
    columns: Mapping[str, Floats], places: NDArray[np.intp], alike: float
) -> int | None:
    """Return the index in ``places`` from which there is no trend (see _moving); None if never."""
    if not (rates := _moving(columns, places, alike)):
        return 0
    number = places.size // 2
    for _ in range(_HALVES):
        if number < HALVED:
            return None
        end = places[places.size - number :]
        # Over few cycles no trend is significant: it must have become significantly slower.
        slopes = {name: _slope(columns[name][end]) for name in rates}
        slower = all(
            abs(slopes[name][0]) <= max(SLOWER * rate, _DISTINCT * slopes[name][1])
            and _DISTINCT * slopes[name][1] <= rate
            for name, rate in rates.items()
        )
        if slower and not _moving(columns, end, alike):
            return int(places.size - number)
        number //= 2
    return None


def _mask(places: NDArray[np.intp], size: int) -> NDArray[np.bool_]:
    is_chosen = np.zeros(size, dtype=bool)
    is_chosen[places] = True
    return is_chosen


_WORDS = {
    "amplitude": ("amplitude", "m"),
    "force_amplitude": ("force amplitude", "N"),
    "dissipated_energy": ("energy a cycle", "J"),
}


def _span(columns: Mapping[str, Floats], places: NDArray[np.intp], names: tuple[str, ...]) -> str:
    tenth = max(1, places.size // 10)
    texts = []
    for name in names:
        word, unit = _WORDS[name]
        ends = (float(columns[name][part].mean()) for part in (places[:tenth], places[-tenth:]))
        low, high = (engineering(end, unit) for end in ends)
        texts.append(f"{word} {low} to {high}")
    return ", ".join(texts)


def _moving_note(
    columns: Mapping[str, Floats], places: NDArray[np.intp], names: tuple[str, ...]
) -> str:
    return (
        f"not settled: {_span(columns, places, names)} from cycle {places[0] + 1} to "
        f"{places[-1] + 1} (running in, wear, or a change of the rig); intervals are the range of "
        "the cycles, since no mean describes them; `cycles=slice(first, last)` selects settled ones"
    )
