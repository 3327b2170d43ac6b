"""Floor 6: which cycles of a record the means are of: those that close and are alike.

A mean over amplitudes that step, or over friction that runs in, belongs to no cycle, and the more
cycles the narrower the interval around it. So means are of a stretch in which nothing moves.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats
from microslip._core.units import engineering
from microslip._core.wording import plural
from microslip.errors import InputError
from microslip.tribometer.estimates import trend
from microslip.tribometer.spikes import Spike

ALIKE = 0.02
"""Relative change of amplitude, force or energy over a stretch that counts as none,"""
CERTAIN = 5.0
"""or this many standard errors of its trend; the limits are this project's."""
NOISE = 10.0
"""Range of the amplitudes of like cycles at most, over their noise."""
OPEN = 0.25
"""Closure error beyond which a cycle is not one of those that the means are of."""
_MOST_LOSS = 1.05 * 4.0 / math.pi  # of a rectangle; noise may make its corners a little less
FEWEST = 5
"""Cycles of a settled stretch, at least."""
JUDGED = 20
"""Cycles from which a record is judged: the noise of fewer is not known, and their mean is not
narrow."""
SLOWER = 0.25
"""Rate at which the end of a record may still change, over that of all of it."""
_HALVES, _MOST_STRETCHES = 6, 64
_LOSS = 0.01
"""Of the rectangle around a loop: what energies move by is of no less than that."""
_MOVING = ("force_amplitude", "dissipated_energy")


class Level(NamedTuple):
    """A stretch of cycles at one amplitude, where a record has several."""

    selection: NDArray[np.intp]
    """Its cycles in which nothing moves; all of them where that is nowhere so."""
    is_moving: bool
    """Whether it is nowhere so."""


class Settled(NamedTuple):
    """Cycles between which nothing moves."""

    selection: NDArray[np.bool_]
    """The cycles that the means are of."""
    is_moving: bool
    """Whether no settled stretch was found: then the means are of all that count."""
    notes: tuple[str, ...]
    levels: tuple[Level, ...] = ()
    """Stretches of one amplitude, in their order; none where the amplitude is the same in all."""


def counted_cycles(
    columns: Mapping[str, NDArray[np.float64]], spikes: tuple[Spike, ...]
) -> tuple[NDArray[np.bool_], list[str]]:
    """The cycles that the means are of, and what to say of the others."""
    notes = []
    closure, first = columns["closure_error"], columns["start"]
    last = first + columns["period"]
    sound = np.ones(closure.size, dtype=bool)
    for spike in spikes:
        sound &= (last < spike.first) | (first > spike.last)
    texts = "; ".join(map(str, spikes[:3])) + ("; ..." if len(spikes) > 3 else "")
    if not sound.any():
        raise InputError(
            f"no cycle is without a spike: {plural(len(spikes), 'spike')}, {texts}; look at the "
            "sensor and its cable, or leave these samples out"
        )
    if not sound.all():
        notes.append(
            f"left out of the means: {_cycles(~sound)} with a spike, here straight lines: {texts}"
        )
    elif spikes:
        notes.append(f"spikes beyond the whole cycles: {texts}")
    closed = closure <= OPEN
    if not (sound & closed).any():
        notes.append("no cycle closes, the ends of each differ by over a quarter of the force")
        return sound, notes
    if not closed.all():
        notes.append(
            f"left out of the means: {_cycles(~closed)} whose ends differ by over a quarter of "
            "the force, as in running in"
        )
    return sound & closed, notes


def excess_loss_notes(loss_factor: NDArray[np.float64]) -> list[str]:
    """What to say of loops that are larger than the rectangle around them."""
    large = loss_factor > _MOST_LOSS
    if not large.any():
        return []
    return [
        f"a loss factor above 4/π = 1.27, up to {float(np.nanmax(loss_factor)):.3g}, in "
        f"{_cycles(large)}: no closed loop has more than the rectangle around it, so these "
        "channels are no loop, have spikes, or a rig softer than it is was taken off"
    ]


def _cycles(is_named: NDArray[np.bool_]) -> str:
    """Such as "2 cycles (3, 8)"."""
    places = np.flatnonzero(is_named) + 1
    numbers = ", ".join(map(str, places[:5])) + (", ..." if places.size > 5 else "")
    return f"{plural(places.size, 'cycle')} ({numbers})"


def settled(
    columns: Mapping[str, Floats], sound: NDArray[np.bool_], alike: float = ALIKE
) -> Settled:
    """The settled ones of the sound cycles: force and energy move by ``alike`` at most."""
    places = np.flatnonzero(sound)
    if places.size < JUDGED:
        return Settled(sound, False, ())
    amplitude = columns["amplitude"][places]
    runs = _runs(amplitude)
    notes: list[str] = []
    levels: tuple[Level, ...] = ()
    if runs is not None:
        if not runs:
            return Settled(sound, True, (_moving_note(columns, places, ("amplitude",)),))
        first, stop = max(runs, key=lambda run: run[1] - run[0])
        notes.append(_steps_note(columns, places, runs))
        levels = tuple(_level(columns, places[begin:end], alike) for begin, end in runs)
        places = places[first:stop]
    late = _settled_end(columns, places, alike)
    if late is None:
        notes.append(_moving_note(columns, places, _MOVING))
        return Settled(_mask(places, sound.size), True, tuple(notes), levels)
    if late > 0:
        notes.append(
            f"force or energy still moves at first: from {_span(columns, places, _MOVING)} over "
            f"cycles {places[0] + 1} to {places[-1] + 1}; the means are of cycles "
            f"{places[late] + 1} to {places[-1] + 1}, where neither changes by over "
            f"{100.0 * alike:g} %"
        )
    return Settled(_mask(places[late:], sound.size), False, tuple(notes), levels)


def _level(columns: Mapping[str, Floats], places: NDArray[np.intp], alike: float) -> Level:
    """The settled end of a stretch; of one that is too short to be judged all cycles."""
    late = 0 if places.size < JUDGED else _settled_end(columns, places, alike)
    return Level(places[late or 0 :], late is None)


def _runs(values: Floats) -> list[tuple[int, int]] | None:
    """Stretches of like values, the longest first taken; None where all are alike."""
    noise = float(np.median(np.abs(np.diff(values, 2)))) / 0.6745 / np.sqrt(6.0)
    # The noise of few cycles is not known well.
    range_of_noise = NOISE * (1.0 + 4.0 / np.sqrt(values.size)) * noise
    widest = max(ALIKE * float(np.median(np.abs(values))), range_of_noise)
    if float(np.ptp(values)) <= widest:
        return None
    runs: list[tuple[int, int]] = []
    open_stretches = [(0, values.size)]
    for _ in range(_MOST_STRETCHES):
        if not open_stretches:
            break
        open_stretches.sort(key=lambda stretch: stretch[1] - stretch[0])
        first, stop = open_stretches.pop()
        begin, end = _longest(values[first:stop], widest)
        if end - begin < FEWEST:
            continue
        begin, end = begin + first, end + first
        open_stretches += [(first, begin), (end, stop)]
        # A ramp has stretches, too, in which it moves by less than the limit, from end to end.
        if not _moves(values[begin:end], 0.25 * widest):
            runs.append((begin, end))
    return sorted(runs)


def _longest(values: Floats, widest: float) -> tuple[int, int]:
    """The longest stretch with a range of at most ``widest``: begin and one past its end."""
    best, begin = (0, 0), 0
    highest: deque[int] = deque()
    lowest: deque[int] = deque()
    for i, value in enumerate(values):
        while highest and values[highest[-1]] <= value:
            highest.pop()
        while lowest and values[lowest[-1]] >= value:
            lowest.pop()
        highest.append(i)
        lowest.append(i)
        while values[highest[0]] - values[lowest[0]] > widest:
            begin += 1
            if highest[0] < begin:
                highest.popleft()
            if lowest[0] < begin:
                lowest.popleft()
        if i + 1 - begin > best[1] - best[0]:
            best = begin, i + 1
    return best


def _moves(values: Floats, smallest: float) -> bool:
    """Whether a straight line over the values rises by more than that, and not by accident."""
    slope, error = _slope(values)
    return abs(slope * (values.size - 1)) > smallest and abs(slope) > CERTAIN * error


def _slope(values: Floats) -> tuple[float, float]:
    line = trend(np.arange(values.size, dtype=float), values, 0.95)
    return line.value, line.standard_error


def _settled_end(
    columns: Mapping[str, Floats], places: NDArray[np.intp], alike: float
) -> int | None:
    """From where on neither force nor energy moves; None where they do to the end."""
    number = places.size
    rates = [abs(_slope(columns[name][places])[0]) for name in _MOVING]
    for halves in range(_HALVES):
        end = places[places.size - number :]
        force, energy = (columns[name][end] for name in _MOVING)
        height = abs(float(np.median(force)))
        around = 4.0 * abs(float(np.median(columns["amplitude"][end]))) * height
        usual = max(abs(float(np.median(energy))), _LOSS * around)
        moves = _moves(force, alike * height) or _moves(energy, alike * usual)
        # Over few cycles nothing moves by much: it must have become slower, too.
        slower = halves == 0 or all(
            abs(_slope(values)[0]) <= max(SLOWER * rate, CERTAIN * _slope(values)[1])
            for values, rate in zip((force, energy), rates, strict=True)
        )
        if not moves and slower:
            return int(places.size - number)
        number //= 2
        if number < JUDGED:
            break
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
    """Such as "force amplitude 300 N to 500 N": in the mean of the first and the last tenth."""
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
        f"{places[-1] + 1}; intervals are the range of the cycles, not of a mean, which belongs "
        "to none of them"
    )


def _steps_note(
    columns: Mapping[str, Floats], places: NDArray[np.intp], runs: list[tuple[int, int]]
) -> str:
    """Which stretches of one amplitude there are, and of which the means are."""
    amplitude = columns["amplitude"][places]
    texts = []
    for first, stop in runs:
        of = places[first:stop]
        texts.append(
            f"cycles {of[0] + 1} to {of[-1] + 1} at "
            f"{engineering(float(columns['amplitude'][of].mean()), 'm')} with "
            f"{engineering(float(columns['dissipated_energy'][of].mean()), 'J')} a cycle"
        )
    first, stop = max(runs, key=lambda run: run[1] - run[0])
    return (
        f"the amplitude is not the same in all cycles, {engineering(float(amplitude.min()), 'm')} "
        f"to {engineering(float(amplitude.max()), 'm')}; settled are {'; '.join(texts[:8])}"
        f"{'; ...' if len(texts) > 8 else ''}. The means are of cycles {places[first] + 1} to "
        f"{places[stop - 1] + 1}"
    )
