"""Quantities of each cycle of a record: amplitudes, energy, sliding, stiffness, closure, forces."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import Floats, exact, positive
from microslip._core.errors import InputError
from microslip.laboratory.blocks import CycleBlock, blocks_of
from microslip.laboratory.cuts import Cuts
from microslip.laboratory.estimates import trend
from microslip.laboratory.record import Record
from microslip.laboratory.reversals import Branches, Reversals, branches_of
from microslip.readers.roles import by_role

_MOVED, _PUSHED = ("displacement",), ("force",)
_WORK, _RATIO = ("force", "displacement"), ("force", "normal_load")
_COLUMNS: dict[str, tuple[str, tuple[str, ...], str]] = {
    "cycle_number": ("-", (), ""),
    "start": ("-", (), ""),
    "period": ("-", (), ""),
    "frequency": ("Hz", (), ""),
    "amplitude": ("m", _MOVED, "amplitude δ_m"),
    "displacement_offset": ("m", _MOVED, ""),
    "force_amplitude": ("N", _PUSHED, "force amplitude T_m"),
    "force_offset": ("N", _PUSHED, ""),
    "normal_load": ("N", ("normal_load",), "normal load N"),
    "dissipated_energy": ("J", _WORK, "energy/cycle E_d"),
    "energy_ratio": ("-", (), "energy ratio A"),
    "loss_factor": ("-", (), "loss factor η"),
    "damping_ratio": ("-", (), "damping ratio ζ"),
    "sliding_distance": ("m", _MOVED, ""),
    "sliding_ratio": ("-", (), "sliding ratio D"),
    "fouvry_ratio": ("-", (), "B = E_d/4T_mδ_g"),
    "friction_peak": ("-", _RATIO, "friction T_m/N"),
    "friction_energy": ("-", _RATIO, "friction E_d/4Nδ_g"),
    "chord_stiffness": ("N/m", _WORK, "stiffness after reversal, first 5 %"),
    "closure_error": ("-", (), "closure error"),
}
"""Columns of the cycles: SI unit, sensors whose gain errors they share, and label in tables."""
COLUMN_UNITS: Mapping[str, str] = MappingProxyType({name: row[0] for name, row in _COLUMNS.items()})
LABELS: Mapping[str, str] = MappingProxyType({n: row[2] for n, row in _COLUMNS.items() if row[2]})


def gain_error(name: str, gain_errors: Mapping[str, float]) -> float:
    """Return the relative standard deviation [-] of a column due to errors of sensor gains."""
    return math.hypot(*(gain_errors.get(sensor, 0.0) for sensor in _COLUMNS[name][1]))


def block_columns(
    moved: Floats,
    force: Floats,
    load: NDArray[np.float64] | float | None,
    cycles: Cuts,
    compliance: float = 0.0,
    time: Floats | None = None,
) -> dict[str, Floats]:
    """Evaluate the cycles of a block: the columns of :data:`COLUMN_UNITS` and ``force_rms`` [N].

    ``compliance`` [m/N] is that of the rig, whose deflection is subtracted from the displacement
    ``moved`` [m]. Frequencies are given if the ``time`` [s] of the samples is. A significant linear
    drift of a channel is subtracted, but kept in the columns of the offsets.
    """
    sign = -1.0 if cycles.flipped else 1.0
    moved, force = sign * moved, sign * force
    branches = branches_of(moved, force, cycles)
    middles = 0.5 * (branches.peaks.place + branches.troughs.place)
    drifts = _drift(branches, "x", middles), _drift(branches, "force", middles)
    if any(drifts):
        # The energy of a loop that does not close depends on where it is cut.
        away = np.arange(float(moved.size)) - middles.mean()
        moved, force = moved - drifts[0] * away, force - drifts[1] * away
        branches = branches_of(moved, force, cycles)
    x = moved - compliance * force if compliance else moved
    cuts, first, last = cycles.cuts, cycles.cuts[:-1], cycles.cuts[1:]
    begin, end = int(cuts[0]), int(cuts[-1])
    count = (last - first).astype(float)
    high, low = branches.peaks.force, branches.troughs.force
    top, bottom = branches.peaks.x - compliance * high, branches.troughs.x - compliance * low
    amplitude, force_amplitude = 0.5 * (top - bottom), 0.5 * (high - low)
    # Against the cycle's own middle, or rounding grows with the offset.
    mid_x = np.repeat(0.5 * (top + bottom), last - first)
    mid_force = np.repeat(0.5 * (high + low), last - first)
    energy = branches.energy
    swing = force[begin : end + 1] - np.append(mid_force, mid_force[-1])
    sliding = _sliding_distance(x[begin : end + 1] - np.append(mid_x, mid_x[-1]), swing, cycles)
    mean, square = (np.add.reduceat(v[:-1], first - begin) / count for v in (swing, swing**2))
    del mid_x, mid_force, swing
    progress = middles - middles.mean()
    ratio = _ratio(energy, 4.0 * amplitude * force_amplitude)
    columns = {
        "start": first.astype(float),
        "period": count,
        "amplitude": amplitude,
        "displacement_offset": sign * (0.5 * (top + bottom) + drifts[0] * progress),
        "force_amplitude": force_amplitude,
        "force_offset": sign * (0.5 * (high + low) + drifts[1] * progress),
        "force_rms": np.sqrt(np.maximum(square - mean**2, 0.0)),
        "dissipated_energy": energy,
        "energy_ratio": ratio,
        "loss_factor": 4.0 / math.pi * ratio,
        "damping_ratio": 2.0 / math.pi * ratio,
        "sliding_distance": sliding,
        "sliding_ratio": _ratio(sliding, amplitude),
        "fouvry_ratio": _ratio(energy, 4.0 * force_amplitude * sliding),
        "closure_error": _ratio(np.abs(force[last] - force[first]), 2.0 * np.abs(force_amplitude)),
    }
    if time is not None:
        samples = np.arange(float(time.size))
        columns["frequency"] = 1.0 / np.diff(np.interp(branches.edges, samples, time))
    if load is not None:
        pressed = (
            np.add.reduceat(load[begin:end], first - begin) / count
            if isinstance(load, np.ndarray)
            else np.full(first.size, load)
        )
        columns["normal_load"] = pressed
        columns["friction_peak"] = _ratio(force_amplitude, pressed)
        columns["friction_energy"] = _ratio(energy, 4.0 * pressed * sliding)
    columns |= stiffness_columns(moved, force, cycles, branches, compliance)
    return columns


def _drift(branches: Branches, channel: str, middles: Floats) -> float:
    """Return the change of the mid-range of a channel per sample; 0 if not significant."""
    high, low = getattr(branches.peaks, channel), getattr(branches.troughs, channel)
    line = trend(middles, 0.5 * (high + low), independent=False)
    return line.slope if line.is_certain else 0.0


def columns_of(record: Record, compliance: float) -> dict[str, Floats]:
    """Evaluate the cycles of all blocks of a record; ``compliance`` [m/N] is the rig's."""
    x, force, load = record.displacement, record.force, record.normal_load
    seconds, parts = record.seconds, []
    for block in blocks_of(record).having_cycles:
        at = block.samples
        pressed = load[at] if isinstance(load, np.ndarray) else load
        time = None if seconds is None else seconds[at]
        parts.append(block_columns(x[at], force[at], pressed, block.cycles, compliance, time))
        parts[-1]["start"] += block.first
        if record.cycle_number is not None:
            cuts = block.first + block.cycles.cuts
            parts[-1]["cycle_number"] = record.cycle_number[(cuts[:-1] + cuts[1:]) // 2]
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _ratio(numerator: Floats, denominator: Floats) -> Floats:
    nothing = np.full_like(numerator, np.nan)
    return np.divide(numerator, denominator, out=nothing, where=denominator != 0.0)


def _sliding_distance(x: Floats, force: Floats, cycles: Cuts) -> Floats:
    """Return half the loop's width [m] at zero ``force``; the samples begin at the first cut."""
    first = cycles.cuts[:-1] - cycles.cuts[0]
    turn = np.sort(np.concatenate((cycles.peaks, cycles.troughs))) - cycles.cuts[0]
    changes = np.flatnonzero((force[1:] >= 0.0) != (force[:-1] >= 0.0))
    # Ways since the first turning point: down from peaks (even), up from troughs (odd).
    way = np.searchsorted(turn, changes, side="right") - 1
    cycle = np.searchsorted(first, changes, side="right") - 1
    fine = (way >= 0) & (way // 2 == cycle)
    changes, way = changes[fine], way[fine]
    share = force[changes] / (force[changes] - force[changes + 1])
    place = x[changes] + share * (x[changes + 1] - x[changes])
    count = np.bincount(way, minlength=turn.size).astype(float)
    width = _ratio(np.bincount(way, place, minlength=turn.size).astype(float), count)
    # Signed, or noise would slide where nothing does.
    distance = 0.5 * (width[1::2] - width[::2])
    finite = distance[np.isfinite(distance)]
    return distance * (-1.0 if finite.size and np.median(finite) < 0.0 else 1.0)


# -- stiffness after a reversal -------------------------------------------------------------------

CHORD = 0.05
"""Fraction of the force range after a reversal over which the chord extends."""
SHARES = (0.25, 0.15, 0.1, 0.07)
"""Fractions of the force range whose samples are fitted: the largest that agrees with the smaller
ones."""
_KINK = 0.002
"""Relative error of a chord on a branch with kinks: those of 24 equal sliders change it by 0.2 to
0.4 % where one is at the end of the chord."""
_FEWEST, _MOST_SHARE = 3, 0.9
"""Fewest samples in the window, and largest fraction of the force range in it."""


def branch_compliance(
    x: Floats,
    force: Floats,
    start: Reversals,
    end: Floats,
    span: Floats,
    compliance: float,
) -> tuple[Floats, Floats]:
    """Return the chord compliance of each branch after its reversal, and its systematic error.

    Both are in [m/N], and NaN if unknown. The chord extends over the first 5 % of the force range.

    The displacement ``x`` [m] is fitted as a function of ``force`` [N] over the first part of the
    branch from the reversal ``start`` to the sample number ``end``. Signs are such that the force
    increases. Noise of the force in the abscissa of the fit, or in the choice of samples, would
    bias the stiffness upwards. So the window ends at the sample where the mean branch reaches a
    fraction of its force range ``span`` [N], and each branch is replaced by its least-squares fit
    by the mean branch and a parabola in time. Then the deflection of the rig with the given
    ``compliance`` [m/N] is subtracted.
    """
    nothing = np.full(span.size, np.nan)
    begin = np.ceil(start.place + 0.25).astype(np.int64)
    length = int(np.median(end - begin)) if begin.size else 0
    if length < _FEWEST:
        return nothing, nothing
    rows = np.clip(begin[:, None] + np.arange(length), 0, x.size - 1)
    moved = x[rows] - start.x[:, None]
    size = float(np.median(np.ptp(moved, axis=1)))
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (force[rows] - start.force[:, None]) / span[:, None]
        scaled = moved * (size / np.ptp(moved, axis=1))[:, None]
    good = np.isfinite(share).all(axis=1) & np.isfinite(scaled).all(axis=1)
    if not good.any() or size == 0.0:
        return nothing, nothing
    mean_share = share[good].mean(axis=0)
    means = (scaled[good].mean(axis=0) / size, mean_share)
    windows: list[int] = []
    for part in SHARES:
        window = max(_window(mean_share, part), min(_FEWEST, length))
        while window > 1 and mean_share[window - 1] > _MOST_SHARE:
            window -= 1
        if not windows or _FEWEST <= window < windows[-1]:
            windows.append(window)
    chords = (_fit(moved, share, window, means, span, compliance, good) for window in windows)
    return _widest_that_agrees(chords)


def _fit(
    moved: Floats,
    share: Floats,
    window: int,
    means: tuple[Floats, Floats],
    span: Floats,
    compliance: float,
    good: NDArray[np.bool_],
) -> tuple[Floats, Floats]:
    """Compute the chord compliance from the first ``window`` samples of each branch.

    Let f be the change of force since the reversal, divided by the force range. The displacement is
    fitted in three ways: by powers 1 and 2 of f, by powers 1 and 3/2 of f, and by powers 1 and 2 of
    -ln(1 - f). The mean of the largest and the smallest chord is returned, with 0.8 times their
    difference and the error of kinks, which none of the shapes has, as its systematic error.
    """
    good, nothing = good.copy(), np.full(span.size, np.nan)
    place, gone = moved[:, :window], share[:, :window]
    if window > 4:
        few = np.count_nonzero(good) <= 2
        smooth = _smoother(window, () if few else tuple(mean[:window] for mean in means))
        place, gone = place @ smooth, gone @ smooth
    place = place - compliance * span[:, None] * gone
    gone = np.clip(np.where(good[:, None], gone, 0.1), -0.5, _MOST_SHARE)
    place = np.where(good[:, None], place, 0.1)
    # Over f a slider or a spring is a straight line, over -ln(1 - f) an exponential contact; of
    # sliders that yield early the way bends with the power 3/2.
    terms = 2 if window > 1 else 1
    chords = []
    for z, z_there, power in (
        (gone, CHORD, 2.0),
        (np.maximum(gone, 0.0), CHORD, 1.5),
        (-np.log1p(-gone), -math.log1p(-CHORD), 2.0),
    ):
        powers = z[:, :, None] ** np.array([1.0, power])[:terms]
        normal = np.einsum("cni,cnj->cij", powers, powers)
        right = np.einsum("cni,cn->ci", powers, place)
        good &= np.linalg.cond(normal) < 1e12
        normal[~good] = np.eye(terms)
        factors = np.linalg.solve(normal, right[..., None])[..., 0]
        chords.append(factors @ z_there ** np.array([1.0, power])[:terms] / (CHORD * span))
    high, low = np.max(chords, axis=0), np.min(chords, axis=0)
    chord = 0.5 * (high + low)
    doubt = np.hypot(0.8 * (high - low), _KINK * chord)
    return np.where(good, chord, nothing), np.where(good, doubt, nothing)


def _widest_that_agrees(fits: Iterator[tuple[Floats, Floats]]) -> tuple[Floats, Floats]:
    """Return the fit of the widest window whose mean chord agrees with that of the next narrower.

    Means agree within 2.5 standard errors of their difference, or half the systematic error
    ``doubt`` of the wider window. Their difference and twice its standard error are added to the
    ``doubt`` in quadrature.
    """
    chord, doubt = next(fits)
    for narrow in fits:
        away = chord - narrow[0]
        away = away[np.isfinite(away)]
        if away.size == 0:  # no solution in the narrower window
            continue
        change = float(away.mean())
        error = float(away.std(ddof=1)) / math.sqrt(away.size) if away.size > 2 else 0.0
        doubt = np.abs(doubt)
        allowed = 0.5 * float(np.nanmean(doubt)) if np.isfinite(doubt).any() else 0.0
        doubt = np.sqrt(doubt**2 + change**2 + (2.0 * error) ** 2)
        if abs(change) <= max(2.5 * error, allowed):
            break
        chord, doubt = narrow
    return chord, doubt


def _smoother(window: int, means: tuple[Floats, ...]) -> Floats:
    time = np.arange(window) / window
    shapes = [np.ones(window), *means]
    room = window - 2 - len(shapes)
    shapes += [time, time**2, time**3][: max(0, min(room, 2 if means else 3))]
    if len(shapes) < 3:
        return np.eye(window)
    basis, _ = np.linalg.qr(np.array(shapes).T)
    return np.asarray(basis @ basis.T)


def _window(share: Floats, part: float) -> int:
    half = max(0, share.size // 200)
    if half:
        share = np.convolve(np.pad(share, half, mode="edge"), np.ones(2 * half + 1), "valid") / (
            2 * half + 1
        )
    beyond = np.flatnonzero(share > part)
    return int(beyond[0]) if beyond.size else int(share.size)


def stiffness_columns(
    x: Floats, force: Floats, cycles: Cuts, branches: Branches, compliance: float
) -> dict[str, Floats]:
    """Return the chord stiffness [N/m] of each cycle and its relative systematic error [-].

    The stiffness is from the mean compliance after displacement maxima and minima.
    """
    peaks, troughs = branches.peaks, branches.troughs
    span = peaks.force - troughs.force
    after_highest = Reversals(peaks.place, -peaks.x, -peaks.force)
    next_peaks = np.append(peaks.place[1:], cycles.cuts[-1])
    falling = branch_compliance(-x, -force, after_highest, troughs.place, span, compliance)
    rising = branch_compliance(x, force, troughs, next_peaks, span, compliance)
    chord, doubt = (0.5 * (a + b) for a, b in zip(falling, rising, strict=True))
    # Negative compliances due to noise are kept, to avoid a bias of means.
    stiffness = _ratio(np.ones(chord.size), chord)
    return {"chord_stiffness": stiffness, "chord_doubt": _ratio(np.abs(doubt), np.abs(chord))}


# -- errors due to the spacing of the samples -----------------------------------------------------

_MOST_SAMPLES, _MOST_CYCLES, _COARSEST = 400.0, 64, 16.0
"""Samples per cycle above which the error is bounded by that of a polygon, number of compared
cycles, and samples per cycle from which on half of them suffice for a loop."""
_ORDER = 2.0
"""Change from all samples to half of them over the error of all: 3 at a kink of the branch, 15
where it is smooth; less, since the position of the kink between samples is random."""
_NO_LENGTH = (
    "cycle_number", "start", "period", "frequency", "displacement_offset", "force_offset",
    "normal_load", "closure_error",
)  # fmt: skip
_ENCLOSED = (
    "dissipated_energy", "energy_ratio", "loss_factor", "damping_ratio", "fouvry_ratio",
    "friction_energy",
)  # fmt: skip
"""Columns in proportion to the enclosed area."""


def sampling_errors(
    record: Record, block: CycleBlock, columns: Mapping[str, Floats], compliance: float
) -> dict[str, float]:
    """Estimate the half-widths of errors of means due to sample spacing, relative to the means.

    The columns of a block are evaluated again from its even and from its odd samples. Errors of
    stiffnesses include the difference between the results of three shapes of the branch.
    """
    names = [name for name in columns if name not in _NO_LENGTH]
    period = block.cycles.period
    polygon = (2.0 * math.pi / period) ** 2 / 6.0
    errors = dict.fromkeys(names, polygon)
    if _COARSEST <= period <= _MOST_SAMPLES:
        errors = dict.fromkeys(names, 0.0)
        x, force = record.displacement[block.samples], record.force[block.samples]
        load = record.normal_load
        pressed = load[block.samples] if isinstance(load, np.ndarray) else load
        few = block.cycles.selected(0, min(_MOST_CYCLES, block.cycle_count))
        whole = block_columns(x, force, pressed, few, compliance)
        for parity in (0, 1):
            last, half = x[parity::2].size - 1, few._replace(period=0.5 * period)
            for name in ("cuts", "peaks", "troughs"):
                places = np.clip((getattr(few, name) - parity + 1) // 2, 0, last)
                half = half._replace(**{name: places})
            load_part = pressed[parity::2] if isinstance(pressed, np.ndarray) else pressed
            part = block_columns(x[parity::2], force[parity::2], load_part, half, compliance)
            for name in names:
                change = _relative(whole[name], part[name], name == "chord_stiffness")
                errors[name] = max(errors[name], change / _ORDER)
    # The reversal is extrapolated from samples beside it: an error of the next order remains.
    errors = {name: max(error, 2.0 * polygon**2) for name, error in errors.items()}
    for name in errors.keys() & set(_ENCLOSED):
        # A kink of the branch between two samples costs up to three times the mean of a polygon.
        errors[name] = max(errors[name], 0.5 * polygon)
    doubt = columns["chord_doubt"]
    fine = doubt[np.isfinite(doubt)]
    chord_doubt = float(np.median(fine)) if fine.size else 0.0
    errors["chord_stiffness"] = math.hypot(errors["chord_stiffness"], chord_doubt)
    return errors


def _relative(whole: Floats, half: Floats, is_stiffness: bool) -> float:
    """Return the median relative change of a column if only every other sample is used [-].

    The median ignores cycles of other amplitudes, in which the divisor may be almost zero.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        change = (whole / half if is_stiffness else half / whole) - 1.0
    fine = change[np.isfinite(change)]
    return abs(float(np.median(fine))) if fine.size else 0.0


_SENSORS = ("force", "displacement", "normal_load")


def checked_gains(errors: Mapping[str, float] | None) -> dict[str, float]:
    """Validate the relative standard deviations [-] of sensor gains, by measured quantity."""
    checked = {}
    for role, error in by_role("gain_errors", errors, '{"force": 0.01}', _SENSORS).items():
        checked[role] = positive(f"gain_errors: {role}", error)
        if checked[role] >= 1.0:
            raise InputError(
                f"`gain_errors`: that of {role} must be a fraction below 1, such as 0.01 for 1 %, "
                f"got {exact(checked[role])}"
            )
    return checked
