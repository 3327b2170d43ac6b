"""Floor 6: what the cycles of a record say: energy, damping, friction, stiffness, regime."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from microslip._checks import Floats, exact, number, positive, show
from microslip._frozen import lock
from microslip.errors import InputError
from microslip.friction import BackboneLaw
from microslip.tribometer.cycles import Cycles, split
from microslip.tribometer.record import Record

UNITS: Mapping[str, str] = MappingProxyType(
    {
        "start": "-",
        "period": "-",
        "amplitude": "m",
        "displacement_offset": "m",
        "force_amplitude": "N",
        "force_offset": "N",
        "normal_load": "N",
        "dissipated_energy": "J",
        "energy_ratio": "-",
        "loss_factor": "-",
        "damping_ratio": "-",
        "sliding_distance": "m",
        "sliding_ratio": "-",
        "fouvry_ratio": "-",
        "friction_peak": "-",
        "friction_energy": "-",
        "reversal_stiffness": "N/m",
        "closure_error": "-",
    }
)
"""Columns of the cycles, with their SI units."""

REGIMES = ("stick", "partial slip", "gross slip")
SHARE = 0.25
"""Of the range of the force after a reversal, from which its stiffness is read."""
ONSET = 0.99
"""Of the force limit: gross slip, for a law that only tends to it."""
RESOLVED = 1e-3
"""Least energy ratio that counts as a loss, for laws that have none below their yield."""
OPEN = 0.25
"""Closure error beyond which a cycle is not one of those that the means are of."""
_FOLDS = 64


class Estimate(NamedTuple):
    """A number that was measured, with its confidence interval."""

    value: float
    """The mean."""
    low: float
    """Lower end of the interval; not a number where there is only one cycle."""
    high: float
    """Its upper end."""
    standard_error: float
    """Of the mean; not a number where there is only one cycle."""
    number: int
    """How many values it is the mean of."""


class Thresholds(NamedTuple):
    """Where one regime ends and the next begins."""

    stick: float
    """Energy ratio A up to which the contact counts as sticking."""
    gross: float
    """Fouvry's ratio B from which it slides as a whole."""
    source: str
    """What they are those of."""


# One sphere (19.15): A where T0 is 1 % below its first tangent, B at the slip limit.
def _of_sphere() -> Thresholds:
    # With s = (1 - r^(2/3)), T = 1 - r and T/(3/2 s) = 0.99; s is near 0.04.
    slip = 0.04
    for _ in range(60):
        slip -= (1.0 - (1.0 - slip) ** 1.5 - 0.99 * 1.5 * slip) / (
            1.5 * (1.0 - slip) ** 0.5 - 0.99 * 1.5
        )
    r = (1.0 - slip) ** 1.5
    energy = 4.8 * (1.0 - r ** (5 / 3) - (5 / 6) * (1.0 - r) * (1.0 + r ** (2 / 3)))
    width = 2.0 * 0.5 ** (2 / 3) - 1.0
    return Thresholds(energy / (4.0 * slip * (1.0 - r)), 0.2 / width, "one sphere")


@dataclass(frozen=True, eq=False)
class Measurement:
    """What the cycles of a record say, each for itself and in the mean.

    Parameters
    ----------
    name : str
        Name of the record.
    cycles : mapping of str to ndarray
        Columns with a value for each cycle, one-dimensional, in SI units: ``start`` (sample) and
        ``period`` [samples], ``amplitude`` [m] and ``force_amplitude`` [N] (half ranges),
        ``displacement_offset`` [m] and ``force_offset`` [N] (their middles), ``normal_load`` [N],
        ``dissipated_energy`` [J], ``energy_ratio`` A, ``loss_factor``, ``damping_ratio``,
        ``sliding_distance`` [m], ``sliding_ratio`` D, ``fouvry_ratio`` B, ``friction_peak``,
        ``friction_energy``, ``reversal_stiffness`` [N/m] and ``closure_error`` [-].
    regimes : tuple of str
        "stick", "partial slip" or "gross slip", for each cycle.
    thresholds : Thresholds
        Where the regimes end.
    mean : mapping of str to Estimate
        Means of the columns with their confidence intervals (Student), over the cycles that close
        to a quarter of their force.
    confidence : float
        Level of the intervals [-].
    frequency : float or None
        Measured frequency [Hz]; None where the record has no time.
    third_harmonic, load_ripple : float or None
        Third harmonic of the displacement over its fundamental [-]; half the range of the normal
        load within the cycle over its mean [-], None where it was not recorded.
    rig_stiffness : float or None
        Stiffness [N/m] whose deflection was taken off the displacement.
    loop : tuple of ndarray
        Displacement [m] and force [N] of the mean cycle, one-dimensional, for pictures.
    notes : tuple of str
        What was noticed.

    Raises
    ------
    InputError
        Never: :func:`microslip.measure` makes it.

    Notes
    -----
    Loops are read as in Fig. 19.7 and (19.29)-(19.30); D and B are those of Fouvry, Kapsa and
    Vincent (1995, DOI 10.1016/0043-1648(94)06582-9).
    """

    name: str
    cycles: Mapping[str, NDArray[np.float64]]
    regimes: tuple[str, ...]
    thresholds: Thresholds
    mean: Mapping[str, Estimate]
    confidence: float
    frequency: float | None
    third_harmonic: float
    load_ripple: float | None
    rig_stiffness: float | None
    loop: tuple[NDArray[np.float64], NDArray[np.float64]]
    notes: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.regimes)

    @property
    def regime(self) -> str:
        """The regime of most cycles."""
        return max(REGIMES, key=self.regimes.count)

    def drift(self, column: str) -> Estimate:
        """How much a column changes from one cycle to the next: its trend by least squares.

        Parameters
        ----------
        column : str
            Such as "displacement_offset" [m] or "dissipated_energy" [J].

        Returns
        -------
        Estimate
            Change a cycle, in the unit of the column, with its confidence interval.

        Raises
        ------
        InputError
            No such column.
        """
        if column not in self.cycles:
            raise InputError(f"column must be one of {', '.join(self.cycles)}, got {show(column)}")
        y = self.cycles[column]
        fine = np.isfinite(y)
        return trend(np.flatnonzero(fine).astype(float), y[fine], self.confidence)

    def table(self) -> str:
        """The means as text: quantity, mean, confidence interval and unit."""
        lines = [f"{self.name}: {len(self)} cycles, {self.regime}"]
        for name, mean in self.mean.items():
            interval = f"[{mean.low:.6g}, {mean.high:.6g}]" if mean.number > 1 else "-"
            lines.append(f"{name:<20} {mean.value:>13.6g}  {interval:<30} {UNITS[name]}")
        return "\n".join(lines)

    def summary(self) -> dict[str, Any]:
        """All but the columns as plain values, NaN as None, as summary.json has it."""
        return {
            "name": self.name,
            "cycles": len(self),
            "regime": self.regime,
            "regimes": {name: self.regimes.count(name) for name in REGIMES},
            "thresholds": self.thresholds._asdict(),
            "confidence": self.confidence,
            "frequency": self.frequency,
            "third_harmonic": self.third_harmonic,
            "load_ripple": self.load_ripple,
            "rig_stiffness": self.rig_stiffness,
            "mean": {
                name: {"unit": UNITS[name], **{k: _plain(v) for k, v in mean._asdict().items()}}
                for name, mean in self.mean.items()
            },
            "notes": list(self.notes),
        }

    def __repr__(self) -> str:
        return f"Measurement({self.name!r}, {len(self)} cycles, {self.regime})"


def measure(
    record: Record,
    *,
    model: BackboneLaw | None = None,
    rig_stiffness: float | None = None,
    confidence: float = 0.95,
) -> Measurement:
    """Measure every cycle of a record.

    Parameters
    ----------
    record : Record
        Displacement, force and, where there is one, normal load.
    model : BackboneLaw, optional
        Law whose thresholds tell the regimes apart; without it those of one sphere.
    rig_stiffness : float, optional
        Stiffness of the rig in series [N/m], above zero: its deflection T/k is taken off the
        displacement. Energy, force, sliding distance and B do not depend on it.
    confidence : float, optional
        Level of the confidence intervals [-], between 0 and 1.

    Returns
    -------
    Measurement
        Columns of the cycles, their means with confidence intervals, and regimes.

    Raises
    ------
    InputError
        Not a record, a displacement without a full cycle or that does not move, a value out of its
        range, a model without finite stiffness.

    Notes
    -----
    The energy is the area of the polygon through all samples (19.29); white noise has no bias on
    it. A cycle that does not close is closed by its chord, and ``closure_error`` says how far its
    ends are apart, of the range of the force, the noise of two samples included. Displacements at
    reversals are read from a parabola through the samples around, forces from one through those
    before, over windows that the noise asks for; without noise they are the samples. The stiffness
    after a reversal is the first slope of a parabola through the first quarter of the force's
    range, displacement over -ln(1 - f), f being the share of that range. ``friction_peak`` is the
    force amplitude over the mean load P, ``friction_energy`` is E_d/4 P delta_g, with delta_g half
    the width of the loop in the middle of its forces. Regimes: "stick" up to the energy ratio A at
    which the model's backbone is 1 % below its first tangent; "gross slip" from the
    B = E_d/4 T_m delta_g of the model where it reaches its limit, or 99 % of one that it only tends
    to (one sphere: 0.7695); D and B are those of Fouvry, Kapsa and Vincent (1995, DOI
    10.1016/0043-1648(94)06582-9).
    """
    if not isinstance(record, Record):
        raise InputError(
            f"record must be a Record, got {show(record)}; "
            "write Record(displacement, force) or Record.read(path)"
        )
    level = number("confidence", confidence, "", 0.95)
    if not 0.0 < level < 1.0:
        raise InputError(f"confidence must be between 0 and 1, got {exact(level)}")
    limits = thresholds(model)
    x, force, notes = record.displacement, record.force, list(record.notes)
    if rig_stiffness is not None:
        rig_stiffness = positive("rig_stiffness", rig_stiffness, "N/m", 1e8)
        x = x - force / rig_stiffness
    # Split where the transducer turns: behind a compliant rig the contact stands still for long.
    cycles = split(record.displacement, force)
    if force.min() == force.max():
        raise InputError(
            f"force must vary, got {exact(force[0])} N at all {force.size} samples: a dead sensor, "
            "or another column than the force"
        )
    sign = -1.0 if cycles.flipped else 1.0
    columns = _columns(sign * x, sign * force, record.normal_load, cycles)
    for name in ("displacement_offset", "force_offset"):
        columns[name] = sign * columns[name]
    if float(np.median(columns["dissipated_energy"])) < 0.0:
        notes.append(
            "the dissipated energy is negative: the force has the opposite sign (sign=-1 when "
            "reading turns it), or the two columns are swapped"
        )
    regimes = _regimes(columns, limits)
    if any(np.isnan(columns["reversal_stiffness"])):
        notes.append(
            "in some cycles too few samples lie in the first quarter of the force after a "
            "reversal to read a stiffness"
        )
    closed = columns["closure_error"] <= OPEN
    if not closed.any():
        notes.append("no cycle closes, the ends of each differ by over a quarter of the force")
        closed[:] = True
    elif not closed.all():
        left_out = ", ".join(str(i + 1) for i in np.flatnonzero(~closed)[:5])
        left_out += ", ..." if np.count_nonzero(~closed) > 5 else ""
        notes.append(
            f"left out of the means: {np.count_nonzero(~closed)} cycles whose ends differ by over "
            f"a quarter of the force, such as in running in (cycle {left_out})"
        )
    notes += _clipped(record)
    sliding = float(np.nanmedian(columns["sliding_ratio"]))
    if rig_stiffness is None and regimes.count("gross slip") > len(regimes) / 2 and sliding < 0.9:
        notes.append(
            f"gross slip by B, though only {sliding:.0%} of the displacement slides: the rest is "
            "elastic, mostly of the rig where amplitudes exceed a few micrometres; give "
            "rig_stiffness to take it off"
        )
    with_mean = [name for name in columns if name != "start"]
    return Measurement(
        name=record.name,
        cycles=MappingProxyType({name: lock(values) for name, values in columns.items()}),
        regimes=regimes,
        thresholds=limits,
        mean=MappingProxyType({name: mean_of(columns[name][closed], level) for name in with_mean}),
        confidence=level,
        frequency=_frequency(record, cycles),
        third_harmonic=_third_harmonic(record.displacement, cycles),
        load_ripple=_ripple(record, cycles),
        rig_stiffness=rig_stiffness,
        loop=_mean_loop(x, force, cycles, np.flatnonzero(closed)),
        notes=tuple(notes),
    )


# -- cycles ---------------------------------------------------------------------------------------


def _columns(
    x: Floats, force: Floats, load: NDArray[np.float64] | float | None, cycles: Cycles
) -> dict[str, Floats]:
    cuts, first, last = cycles.cuts, cycles.cuts[:-1], cycles.cuts[1:]
    begin, end = int(cuts[0]), int(cuts[-1])
    count = (last - first).astype(float)
    top, bottom = _heights(x, cycles.peaks, cycles), _heights(x, cycles.troughs, cycles)
    high = _forces(force, cycles.peaks, cycles)
    low = _forces(force, cycles.troughs, cycles)
    amplitude, force_amplitude = 0.5 * (top - bottom), 0.5 * (high - low)
    # Against the cycle's own middle, or rounding grows with the offset.
    mid_x = np.repeat(0.5 * (top + bottom), last - first)
    mid_force = np.repeat(0.5 * (high + low), last - first)
    work = (0.5 * (force[begin:end] + force[begin + 1 : end + 1]) - mid_force) * np.diff(
        x[begin : end + 1]
    )
    chord = (0.5 * (force[first] + force[last]) - 0.5 * (high + low)) * (x[first] - x[last])
    energy = np.add.reduceat(work, first - begin) + chord
    del work
    sliding = _sliding_distance(
        x[begin : end + 1] - np.append(mid_x, mid_x[-1]),
        force[begin : end + 1] - np.append(mid_force, mid_force[-1]),
        cycles,
    )
    del mid_x, mid_force
    columns = {
        "start": first.astype(float),
        "period": count,
        "amplitude": amplitude,
        "displacement_offset": 0.5 * (top + bottom),
        "force_amplitude": force_amplitude,
        "force_offset": 0.5 * (high + low),
    }
    pressed: Floats | None = None
    if isinstance(load, np.ndarray):
        pressed = np.add.reduceat(load[begin:end], first - begin) / count
    elif load is not None:
        pressed = np.full(first.size, load)
    if pressed is not None:
        columns["normal_load"] = pressed
    ratio = _over(energy, 4.0 * amplitude * force_amplitude)
    columns |= {
        "dissipated_energy": energy,
        "energy_ratio": ratio,
        "loss_factor": 4.0 / math.pi * ratio,
        "damping_ratio": 2.0 / math.pi * ratio,
        "sliding_distance": sliding,
        "sliding_ratio": _over(sliding, amplitude),
        "fouvry_ratio": _over(energy, 4.0 * force_amplitude * sliding),
    }
    if pressed is not None:
        columns["friction_peak"] = _over(force_amplitude, pressed)
        columns["friction_energy"] = _over(energy, 4.0 * pressed * sliding)
    columns["reversal_stiffness"] = _stiffness(x, force, cycles, (top, high), (bottom, low))
    gap = np.abs(force[last] - force[first])
    columns["closure_error"] = _over(gap, 2.0 * np.abs(force_amplitude))
    return columns


def _over(numerator: Floats, denominator: Floats) -> Floats:
    nothing = np.full_like(numerator, np.nan)
    return np.divide(numerator, denominator, out=nothing, where=denominator != 0.0)


def _around(values: Floats, places: NDArray[np.int64], low: int, high: int) -> Floats:
    """Samples around places, a row for each; at the ends of the record the last one again."""
    rows = np.clip(places[:, None] + np.arange(low, high + 1), 0, values.size - 1)
    return np.asarray(values[rows])


def _heights(x: Floats, places: NDArray[np.int64], cycles: Cycles) -> Floats:
    """Displacements at turning points: parabolas through both sides."""
    half = cycles.window
    if half < 1:
        return x[places]
    t = np.arange(-half, half + 1) / half
    weights = np.linalg.pinv(np.stack((np.ones_like(t), t, t**2), axis=1))[0]
    return np.asarray(_around(x, places, -half, half) @ weights)


def _forces(force: Floats, places: NDArray[np.int64], cycles: Cycles) -> Floats:
    """Forces at turning points: parabolas through the samples before, where nothing has kinks."""
    half = cycles.window
    if half < 2:
        return force[places]
    t = np.arange(-half, 1) / half
    weights = np.linalg.pinv(np.stack((np.ones_like(t), t**2), axis=1))[0]
    return np.asarray(_around(force, places, -half, 0) @ weights)


def _sliding_distance(x: Floats, force: Floats, cycles: Cycles) -> Floats:
    """Half the width of each loop in the middle of its forces; both given from the first cut on.

    Noise crosses the middle several times on a way: their mean place counts.
    """
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
    width = _over(np.bincount(way, place, minlength=turn.size).astype(float), count)
    return np.abs(0.5 * (width[1::2] - width[::2]))


def _stiffness(
    x: Floats,
    force: Floats,
    cycles: Cycles,
    top: tuple[Floats, Floats],
    bottom: tuple[Floats, Floats],
) -> Floats:
    """Tangential stiffness after reversals, from the mean of both compliances in each cycle."""
    span = top[1] - bottom[1]
    both = [
        _compliance(sign * x, sign * force, begin, end, sign * at[0], sign * at[1], span)
        for sign, begin, end, at in (
            (-1.0, cycles.peaks, cycles.troughs, top),
            (1.0, cycles.troughs, np.append(cycles.peaks[1:], cycles.cuts[-1]), bottom),
        )
    ]
    compliance = 0.5 * (both[0] + both[1])
    nothing = np.full_like(span, np.nan)
    return np.divide(1.0, compliance, out=nothing, where=compliance > 0.0)


def _compliance(
    x: Floats,
    force: Floats,
    begin: NDArray[np.int64],
    end: NDArray[np.int64],
    from_x: Floats,
    from_force: Floats,
    span: Floats,
) -> Floats:
    """First slope of the displacement over the force, both rising, on each way [m/N].

    Not over the force itself but over the -ln(1 - f) of its share f of the range: for exponential
    heights in gross slip that is a straight line, and for others nearly one.
    """
    length = np.maximum(end - begin, 0)
    owner = np.repeat(np.arange(begin.size), length)
    place = np.arange(owner.size) + np.repeat(begin - np.cumsum(length) + length, length)
    f = (force[place] - from_force[owner]) / span[owner]
    chosen = f <= SHARE
    owner, place, f = owner[chosen], place[chosen], f[chosen]
    moved, f = x[place] - from_x[owner], -np.log1p(-f)
    sums = [np.bincount(owner, f**n, minlength=begin.size) for n in range(5)]
    right = [np.bincount(owner, moved * f**n, minlength=begin.size) for n in range(3)]
    matrix = np.array([[sums[i + j] for j in range(3)] for i in range(3)]).transpose(2, 0, 1)
    vector = np.array(right).T
    enough = sums[0] >= 5
    # Samples that all lie together say nothing of a slope.
    enough[enough] = np.linalg.cond(matrix[enough]) < 1e12
    slope = np.full(begin.size, np.nan)
    slope[enough] = np.linalg.solve(matrix[enough], vector[enough][..., None])[:, 1, 0]
    return slope / span


# -- regimes --------------------------------------------------------------------------------------


def thresholds(model: BackboneLaw | None = None) -> Thresholds:
    """Where the regimes of a law end.

    Parameters
    ----------
    model : BackboneLaw, optional
        The law; without it one sphere.

    Returns
    -------
    Thresholds
        A up to which it sticks, B from which it slides as a whole.

    Raises
    ------
    InputError
        Not a law, or one that is rigid at rest.
    """
    if model is None:
        return _of_sphere()
    if not isinstance(model, BackboneLaw):
        raise InputError(f"model must be a backbone law, such as an Interface, got {show(model)}")
    first = model.tangential_stiffness
    if not math.isfinite(first):
        raise InputError(
            f"model must have a finite stiffness at rest, and {type(model).__name__} is rigid there"
        )
    limit = model.force_limit
    nearly = float(model.backbone_displacement(ONSET * limit))
    onset, word = nearly, "99 % of its limit"
    if float(model.backbone(1.5 * nearly)) >= limit * (1.0 - 1e-12):
        # It reaches its limit: at the first place from which it rises no more.
        low, high = nearly, 1.5 * nearly
        for _ in range(100):
            middle = 0.5 * (low + high)
            if float(model.backbone(middle)) >= limit * (1.0 - 1e-12):
                high = middle
            else:
                low = middle
        onset, word = high, "its limit"
    low, high = 0.0, onset
    for _ in range(200):
        middle = 0.5 * (low + high)
        if float(model.backbone(middle)) < 0.99 * first * middle:
            high = middle
        else:
            low = middle
    peak = float(model.backbone(onset))
    width = abs(onset - 2.0 * float(model.backbone_displacement(0.5 * peak)))
    # Where the onset is the yield of a single slider nothing slides yet: any sliding is gross.
    energy = float(model.dissipated_energy(onset))
    gross = energy / (4.0 * peak * width) if width > 1e-6 * onset else 0.0
    stick = max(float(model.energy_ratio(high)), RESOLVED)
    return Thresholds(stick, gross, f"{type(model).__name__} at {word}")


def _regimes(columns: Mapping[str, Floats], limits: Thresholds) -> tuple[str, ...]:
    ratio, fouvry = columns["energy_ratio"], columns["fouvry_ratio"]
    stick = ~(ratio > limits.stick)
    gross = ~stick & (fouvry >= limits.gross)
    return tuple(REGIMES[0 if s else 2 if g else 1] for s, g in zip(stick, gross, strict=True))


# -- the record as a whole ------------------------------------------------------------------------


def _frequency(record: Record, cycles: Cycles) -> float | None:
    whole = cycles.cuts.size - 1
    first, last = int(cycles.cuts[0]), int(cycles.cuts[-1])
    if record.time is not None:
        return whole / float(record.time[last] - record.time[first])
    if record.sample_rate is not None:
        return whole * record.sample_rate / (last - first)
    return None


def _angles(cycles: Cycles, most: int = 1 << 18) -> tuple[slice, Floats]:
    """Some whole cycles at the begin, and the share of its cycle for each of their samples."""
    count = max(1, int(np.searchsorted(cycles.cuts, cycles.cuts[0] + most, side="right")) - 1)
    cuts = cycles.cuts[: count + 1]
    place = np.arange(cuts[0], cuts[-1])
    return slice(int(cuts[0]), int(cuts[-1])), np.interp(place, cuts, np.arange(cuts.size)) % 1.0


def _third_harmonic(x: Floats, cycles: Cycles) -> float:
    piece, share = _angles(cycles)
    y = x[piece] - x[piece].mean()
    first, third = (abs(np.dot(y, np.exp(-2j * math.pi * n * share))) for n in (1, 3))
    return float(third / first)


def _ripple(record: Record, cycles: Cycles) -> float | None:
    if not isinstance(record.normal_load, np.ndarray):
        return None
    piece, share = _angles(cycles)
    load = record.normal_load[piece]
    folds = min(_FOLDS, max(4, int(cycles.period)))
    fold = np.minimum((share * folds).astype(np.int64), folds - 1)
    count = np.bincount(fold, minlength=folds)
    mean = np.bincount(fold, load, minlength=folds)[count > 0] / count[count > 0]
    return float(0.5 * np.ptp(mean) / load.mean()) if load.mean() != 0.0 else None


def _mean_loop(
    x: Floats, force: Floats, cycles: Cycles, chosen: NDArray[np.intp], samples: int = 256
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean of up to a hundred of the chosen cycles, spread over the record; closed."""
    places = chosen[np.linspace(0, chosen.size - 1, min(100, chosen.size)).astype(int)]
    grid = np.linspace(0.0, 1.0, samples + 1)
    total = np.zeros((2, grid.size))
    for i in places:
        first, last = int(cycles.cuts[i]), int(cycles.cuts[i + 1])
        share = np.arange(last - first + 1) / (last - first)
        for row, values in zip(total, (x, force), strict=True):
            row += np.interp(grid, share, values[first : last + 1])
    total /= places.size
    total[:, -1] = total[:, 0]
    return lock(total[0].copy()), lock(total[1].copy())


def _clipped(record: Record) -> list[str]:
    """What looks like sensors at the end of their range: many samples exactly at an extreme.

    A plateau of a rig that is quiet looks alike, so it is said and no error.
    """
    found = []
    for name in ("displacement", "force"):
        values: Floats = getattr(record, name)
        for extreme in (float(values.min()), float(values.max())):
            at = np.flatnonzero(values == extreme)
            share = at.size / values.size
            together = np.count_nonzero(np.diff(at) == 1)
            if share > 0.005 and together > 0.5 * at.size and at.size > 8:
                found.append(
                    f"{share:.1%} of the {name} is exactly {extreme:g}: a clipped sensor, "
                    "or a plateau without noise"
                )
    return found


# -- statistics -----------------------------------------------------------------------------------


def quantile(confidence: float, freedom: int) -> float:
    """Half width of Student's interval in standard errors [-]."""
    from scipy.special import stdtrit

    return float(stdtrit(freedom, 0.5 + 0.5 * confidence))


def mean_of(values: Floats, confidence: float) -> Estimate:
    """Mean of values that are finite, with Student's confidence interval."""
    fine = values[np.isfinite(values)]
    if fine.size == 0:
        return Estimate(math.nan, math.nan, math.nan, math.nan, 0)
    value = float(fine.mean())
    if fine.size == 1:
        return Estimate(value, math.nan, math.nan, math.nan, 1)
    error = float(fine.std(ddof=1)) / math.sqrt(fine.size)
    half = quantile(confidence, fine.size - 1) * error
    return Estimate(value, value - half, value + half, error, int(fine.size))


def trend(x: Floats, y: Floats, confidence: float) -> Estimate:
    """Slope of a straight line by least squares, with Student's confidence interval."""
    if x.size < 2 or np.ptp(x) == 0.0:
        return Estimate(math.nan, math.nan, math.nan, math.nan, int(x.size))
    away = x - x.mean()
    square = float(np.dot(away, away))
    slope = float(np.dot(away, y)) / square
    if x.size < 3:
        return Estimate(slope, math.nan, math.nan, math.nan, int(x.size))
    rest = y - y.mean() - slope * away
    error = math.sqrt(float(np.dot(rest, rest)) / (x.size - 2) / square)
    half = quantile(confidence, x.size - 2) * error
    return Estimate(slope, slope - half, slope + half, error, int(x.size))


def _plain(value: float) -> float | None:
    return value if math.isfinite(value) else None
