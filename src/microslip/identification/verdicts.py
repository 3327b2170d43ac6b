"""Verdicts on each number and on the fit: identified, bounded or not, and the remedy."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from microslip._core.checks import Floats
from microslip._core.units import interval_digits, significant
from microslip._core.verdicts import Rule, Verdict
from microslip._core.wording import joined
from microslip.identification.caveats import (
    ABOVE,
    APPARENT,
    BELOW,
    FIXED,
    IDENTIFIED,
    NOT,
    Call,
    Caveat,
    ends_text,
    number_text,
)
from microslip.identification.coordinates import RIG, Coordinate
from microslip.identification.profiles import Interval

WIDEST_SHAPE = 1.5
"""Width of the interval of a shape parameter beyond which it counts as not identified."""
WIDEST_RATIO = 4.0
"""Ratio of the ends of the interval of a positive quantity beyond which it counts so."""

_RIG_APART = "measure the rig's stiffness separately and give it with its uncertainty"


@dataclass(frozen=True)
class Fitted:
    """One number of an identification, with what the data say of it."""

    name: str
    unit: str
    value: float
    """Best value; where the verdict is "not identified" it is one of many."""
    low: float
    """Lower end of the profile interval; where that is open 0, or minus infinity."""
    high: float
    """Upper end; where it is open infinity."""
    standard_error: float
    """From the curvature at the best value; of a fixed value 0."""
    verdict: str
    """"identified", "in doubt" (identified under what does not hold), "apparent" (of a law that
    does not fit the records), "extrapolated" (of what no record reached), "bounded above",
    "bounded below", "not identified" or "fixed"."""
    caveat: Caveat | None = None
    """Reason why it is not identified, is bounded on one side only, or is in doubt."""
    at_bound: bool = False
    """Whether the best value lies at a bound."""
    load: float | None = None
    """Normal load [N] that it belongs to, of a separation that all loads share the reference load;
    None for one that belongs to all."""
    low_open: bool = False
    """Whether the loops set no lower end: all values down to the bound of the search answer."""
    high_open: bool = False
    """Whether they set no upper end."""
    profile: tuple[tuple[float, float], ...] = field(default=(), repr=False)
    """Values that the profile visited, and by how much chi-squared rises there, over the factor
    by which the noise was found larger."""

    @property
    def identified(self) -> bool:
        """Whether the number may be used."""
        return self.verdict in (IDENTIFIED, FIXED)

    @property
    def reason(self) -> str:
        """The caveat in words; empty without one."""
        return "" if self.caveat is None else self.caveat.words()

    @property
    def remedy(self) -> str:
        """The measurement that would settle it; empty where none is known."""
        return "" if self.caveat is None else self.caveat.remedy()


def interval_text(number: Fitted) -> str:
    """Return the interval of a number as text, without an end that is open."""
    digits = interval_digits(number.low, number.high, number.value)
    low, high = (number_text(end, number.unit, digits) for end in (number.low, number.high))
    return ends_text((low, high), number.low_open, number.high_open)


def mark(
    numbers: Mapping[str, Fitted], caveat: Caveat, names: Sequence[str] | None = None
) -> dict[str, Fitted]:
    """The numbers, those that a caveat reaches with its verdict: what they rest on does not hold.

    Of what is identified, or apparent where the verdict is another; ``names`` says which it
    reaches.
    """
    verdict = caveat.row.verdict
    return {
        name: replace(fitted, verdict=verdict, caveat=caveat)
        if fitted.verdict in (IDENTIFIED, APPARENT)
        and fitted.verdict != verdict
        and (names is None or name in names)
        else fitted
        for name, fitted in numbers.items()
    }


@dataclass(frozen=True)
class Direction:
    """A combination of parameters along which the loops stay the same within their noise."""

    change: dict[str, float]
    """Change of each parameter: of a plain number itself, of other_steps the logarithm."""
    steps: tuple[tuple[str, str], ...]
    """The parameters that change, the first being the one that is open, and how much."""
    remedies: tuple[str, ...]

    def words(self, call: Call = str) -> str:
        """The direction in words, parameters as an edge calls them."""
        first, *other_steps = (f"{call(name)} {change}" for name, change in self.steps)
        along = f" with {joined(other_steps)}" if other_steps else ""
        return f"{first}{along} changes the loops by less than the noise"

    @property
    def text(self) -> str:
        """The direction in words."""
        return self.words()

    @property
    def remedy(self) -> str:
        """The measurement that would settle it; empty where none is known."""
        return "; ".join(self.remedies)


@dataclass(frozen=True)
class Design:
    """Properties of the records on which a remedy depends."""

    loads: int
    scales_with_load: bool
    rig_is_free: bool
    microslip: bool
    """Whether some record stays below gross slip, so that it sees the beginning of the branch."""
    gross_slip: bool
    """Whether some record reaches it."""

    def remedies(self, coordinate: Coordinate, verdict: str) -> tuple[str, ...]:
        """Measurements that would settle a number that is not identified."""
        if verdict == IDENTIFIED:
            return ()
        if coordinate.parameter == RIG:
            return (_RIG_APART, *(() if self.gross_slip else ("or record a cycle of gross slip",)))
        helpful = {
            _RIG_APART: self.rig_is_free,
            "records at another normal load, best a tenth or ten times of this one": (
                self.scales_with_load and self.loads < 2
            ),
            "records with microslip amplitudes, below the force limit": not self.microslip,
            "a record that reaches gross slip": not self.gross_slip,
        }
        return tuple(remedy for remedy, helps in helpful.items() if helps) or (
            "more cycles, or a displacement measured closer to the contact",
        )


def design_of(
    slips: Sequence[float], coordinates: Sequence[Coordinate], loads: int, scales_with_load: bool
) -> Design:
    """The design of the measurement; ``slips`` are shares of the force limit that are reached."""
    rigs = [coordinate for coordinate in coordinates if coordinate.parameter == RIG]
    is_free = any(not rig.fixed for rig in rigs) and all(rig.prior is None for rig in rigs)
    sticks, slides = any(share < 0.95 for share in slips), any(share > 0.99 for share in slips)
    return Design(loads, scales_with_load, is_free, sticks, slides)


def judge(
    coordinate: Coordinate,
    value: float,
    error: float,
    interval: Interval,
    confidence: float,
    design: Design | None = None,
    profile: tuple[tuple[float, float], ...] = (),
) -> Fitted:
    """Verdict of an interval on a number; the bound of the search is no end."""
    ends = ((coordinate.outer(end.value), end.is_open) for end in interval[:2])
    (low, low_open), (high, high_open) = sorted(ends, key=lambda end: end[0])
    searched = (low, high) if math.isfinite(low) and math.isfinite(high) else (None, None)
    if low_open:
        natural = coordinate.kind == "linear" and 0.0 <= coordinate.low < math.inf
        low = coordinate.low if natural else (-math.inf if coordinate.shape else 0.0)
    if high_open:
        high = math.inf
    room = coordinate.limits
    q = coordinate.inner(value)
    at_bound = min(q - room[0], room[1] - q) <= 1e-6 * min(room[1] - room[0], 1.0)
    if low_open and high_open:
        verdict = NOT
    elif coordinate.shape:
        wide = high - low > WIDEST_SHAPE or low_open or high_open
        verdict = NOT if wide else IDENTIFIED
    elif low_open or high_open:
        verdict = ABOVE if low_open else BELOW
    else:
        verdict = NOT if high > WIDEST_RATIO * low else IDENTIFIED
    caveat = None
    if verdict != IDENTIFIED:
        kind = {(True, True): "open", (True, False): "open below", (False, True): "open above"}
        data = {
            "low": low,
            "high": high,
            "first": searched[0],
            "last": searched[1],
            "unit": coordinate.unit,
            "confidence": confidence,
            "width": WIDEST_SHAPE if coordinate.shape else None,
            "factor": None if coordinate.shape else WIDEST_RATIO,
        }
        remedies = () if design is None else design.remedies(coordinate, verdict)
        name = kind.get((low_open, high_open), "wide") if verdict == NOT else verdict
        caveat = Caveat(name, data, remedies)
    return Fitted(
        *(coordinate.name, coordinate.unit, value, low, high, error, verdict, caveat),
        *(at_bound, coordinate.load, low_open, high_open, profile),
    )


def direction_of(
    coordinate: Coordinate,
    coordinates: Sequence[Coordinate],
    low: Floats,
    high: Floats,
    remedies: tuple[str, ...],
) -> Direction | None:
    """The direction between the two ends of the profile of a coordinate; all are free ones."""
    change: dict[str, float] = {}
    for free, a, b in zip(coordinates, low, high, strict=True):
        if free.kind == "inverse":
            with np.errstate(divide="ignore"):
                change[free.name] = float(np.log(a) - np.log(b)) if min(a, b) > 0.0 else math.inf
        else:
            change[free.name] = float(b - a) * (free.scale if free.kind == "linear" else 1.0)
    full_change = change[coordinate.name]
    if not math.isfinite(full_change) or full_change == 0.0:
        return None
    unit = 1.0 if coordinate.shape else math.log(2.0)
    if coordinate.kind == "linear" and not coordinate.shape:
        unit = math.inf
    factor = min(1.0, unit / abs(full_change)) * math.copysign(1.0, full_change)
    change = {name: factor * value for name, value in change.items()}
    other_coordinates = [
        free
        for free in sorted(coordinates, key=lambda c: -abs(change[c.name]) / _mention_limit(c))
        if free is not coordinate and abs(change[free.name]) >= _mention_limit(free)
    ]
    steps = tuple(
        (c.name, _change_text(c, change[c.name])) for c in (coordinate, *other_coordinates[:4])
    )
    return Direction(change, steps, remedies)


def _mention_limit(coordinate: Coordinate) -> float:
    """Change below which a direction does not mention a coordinate."""
    if coordinate.kind == "linear" and not coordinate.shape:
        return 1e-2 * (abs(coordinate.start) or 1.0)
    return 5e-4


def _change_text(coordinate: Coordinate, change: float) -> str:
    word = "up" if change > 0.0 else "down"
    if math.isinf(change):
        return f"{word} without end"
    if coordinate.shape or coordinate.kind == "linear":
        return f"{word} by {number_text(abs(change), coordinate.unit, 2)}"
    share = math.expm1(change)
    if share > 1.0:
        return f"up by a factor of {significant(1.0 + share, 2)}"
    return f"{word} by {significant(100.0 * abs(share), 2)} %"


def is_parallel(direction: Direction, reference: Direction) -> bool:
    """Whether two directions are the same but for their length and sign."""
    a, b = (
        np.nan_to_num(np.array(list(d.change.values())), posinf=10.0, neginf=-10.0)
        for d in (direction, reference)
    )
    return bool(abs(np.dot(a, b)) > 0.95 * np.linalg.norm(a) * np.linalg.norm(b))


# -- how far a fit can be trusted -----------------------------------------------------------------

CAUSES_FROM, WRONG_FROM = 2.0, 25.0
"""Reduced chi-squared from which on causes are looked for, and from which on what was given may be
wrong."""

MISFIT = Rule(
    name="error hidden by the misfit",
    watch=0.01,
    # A force that was clipped moves the limit of sliding by up to four times what shows: 5 %.
    outside=0.0125,
    meaning="the misfit is noise, or cannot move any number by much",
    reason="largest relative shift of a number that the residuals do not show, if the error of the "
    "law is as large along that number as across it",
    remedy="compare other laws, or look for effects of the rig: the best fit of a law does not "
    "prove the law",
    missing="numbers that the records determine",
)
TOLD_SHARE = Rule(
    name="share of parameters identified",
    watch=1.0,
    outside=1e-9,
    meaning="the records determine every free parameter",
    reason="profiles of the likelihood that close on both sides",
    remedy="each open parameter names the measurement that would determine it",
)
RULES: tuple[Rule, ...] = (MISFIT, TOLD_SHARE)


def verdicts(stake: float | None, is_known: Iterable[bool], converged: bool) -> tuple[Verdict, ...]:
    """Verdicts on a fit, by which free parameters are known: none of one that did not converge."""
    identified = list(is_known)
    share = sum(identified) / len(identified) if identified else 1.0
    return MISFIT.judge(stake), TOLD_SHARE.judge(share if converged else 0.0)
