"""What the data can tell of each number, what they cannot, and what would settle it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip._core.units import engineering, significant
from microslip.identification.coordinates import RIG, Coordinate
from microslip.identification.profiles import Interval
from microslip.identification.quantities import Quantity

WIDEST_SHAPE = 1.5
"""Width of the interval of a shape parameter beyond which it counts as not identified."""
WIDEST_RATIO = 4.0
"""Ratio of the ends of the interval of a positive quantity beyond which it counts so."""

IDENTIFIED, IN_DOUBT, APPARENT, BEYOND, ABOVE, BELOW, NOT, FIXED = (
    "identified",
    "in doubt",
    "apparent",
    "extrapolated",
    "bounded above",
    "bounded below",
    "not identified",
    "fixed",
)

HAS_VALUE = (IDENTIFIED, IN_DOUBT, APPARENT, BEYOND, FIXED)
"""Verdicts on numbers of which a value can be told."""

AT_A_LOAD = ("standardised_separation", "contact_area")
"""Parameters that all records share, but as they are at one load."""

_RIG_APART = "measure the rig's stiffness apart and give it with its uncertainty"


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
    does not answer the records), "extrapolated" (of what no record reached), "bounded above",
    "bounded below", "not identified" or "fixed"."""
    reason: str
    """Why it is not identified, how far it is only bounded or what it hangs on; else empty."""
    remedy: str
    """What measurement would settle it; else empty."""
    at_bound: bool
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


@dataclass(frozen=True)
class Direction:
    """A way through parameter space along which the loops stay the same within their noise."""

    text: str
    """The direction in words."""
    change: dict[str, float]
    """Change of each parameter: of a plain number itself, of others the logarithm."""
    remedy: str
    """What measurement would settle it."""


@dataclass(frozen=True)
class Design:
    """What the records hold, as far as a remedy depends on it."""

    loads: int
    scales_with_load: bool
    rig_is_free: bool
    microslip: bool
    """Whether some record stays below gross slip, so that it sees the beginning of the branch."""
    gross_slip: bool
    """Whether some record reaches it."""


def design_of(
    slips: Sequence[float], coordinates: Sequence[Coordinate], loads: int, scales_with_load: bool
) -> Design:
    """The design of the measurement; ``slips`` are shares of the force limit that are reached."""
    rigs = [coordinate for coordinate in coordinates if coordinate.parameter == RIG]
    is_free = any(not rig.fixed for rig in rigs) and all(rig.prior is None for rig in rigs)
    sticks, slides = any(share < 0.95 for share in slips), any(share > 0.99 for share in slips)
    return Design(loads, scales_with_load, is_free, sticks, slides)


def fixed_number(source: Coordinate | Quantity, value: float) -> Fitted:
    """A number that was not fitted."""
    ends = value, value, value, 0.0
    return Fitted(source.name, source.unit, *ends, FIXED, "", "", False, source.load)


class Judged(NamedTuple):
    """Verdict on a number, and its interval in physical values."""

    verdict: str
    low: float
    high: float
    low_open: bool
    high_open: bool
    at_bound: bool
    """Whether the best value lies at a bound."""
    searched: tuple[float, float]
    """Ends of what was searched, where an end is open."""

    def number(
        self,
        source: Coordinate | Quantity,
        value: float,
        error: float,
        reason: str,
        remedy: str,
        profile: tuple[tuple[float, float], ...] = (),
    ) -> Fitted:
        """The number that was judged, of a coordinate or of a quantity."""
        return Fitted(
            *(source.name, source.unit, value, self.low, self.high, error, self.verdict),
            *(reason, remedy, self.at_bound, source.load, self.low_open, self.high_open, profile),
        )


def judge(coordinate: Coordinate, value: float, interval: Interval) -> Judged:
    """What an interval says of a number; an end that is but the bound of the search is none."""
    ends = (
        (coordinate.outer(interval.low), interval.low_open),
        (coordinate.outer(interval.high), interval.high_open),
    )
    (low, low_open), (high, high_open) = sorted(ends, key=lambda end: end[0])
    searched = low, high
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
    return Judged(verdict, low, high, low_open, high_open, at_bound, searched)


_POWERS = {
    "m^-1.5": "m⁻¹·⁵",
    "m^-1": "m⁻¹",
    "m^-2": "m⁻²",
    "m^2": "m²",
    "1/m^2": "m⁻²",
    "1/m": "m⁻¹",
}
_WITH_PREFIX = ("m", "N", "N/m", "J", "s", "Hz", "Pa")


def number_text(value: float, unit: str, digits: int = 3) -> str:
    """A value with its unit, with a prefix where that has the power one."""
    if math.isnan(value):
        return "–"
    if math.isinf(value):
        return "infinite"
    if unit in ("", "-"):
        return significant(value, digits)
    if unit in _WITH_PREFIX:
        return engineering(value, unit, digits)
    return f"{significant(value, digits)} {_POWERS.get(unit, unit)}"


def ends_text(ends: tuple[str, str], low_open: bool, high_open: bool) -> str:
    """The ends of an interval, of which those are left out that are open."""
    if low_open and high_open:
        return "open"
    if low_open:
        return f"up to {ends[1]}"
    return f"from {ends[0]}" if high_open else f"{ends[0]} … {ends[1]}"


_LABELS = {
    "friction_coefficient": "friction coefficient μ",
    "slip_scale": "slip scale κσ",
    "standardised_separation": "separation h = d/σ",
    "rig_stiffness": "stiffness of the rig",
    "delay": "delay of the force",
    "force_limit": "force limit μN",
    "tangential_stiffness": "stiffness at rest kₜ",
    "load_scale": "load scale of the surface",
    "std": "spread of the heights σ",
    "density_root_radius": "density × √radius",
    "density_radius": "density × radius",
    "density": "density of the summits",
    "radius": "radius of the summits",
    "contact_area": "real contact area",
    "yield_displacement": "yield displacement",
}
_SYMBOLS = {
    "friction_coefficient": "μ",
    "slip_scale": "κσ",
    "standardised_separation": "h",
    "rig_stiffness": "rig",
    "force_limit": "μN",
    "contact_area": "area",
}


def label(name: str, load: float | None = None) -> str:
    """A name as people read it, such as "slip scale κσ at 500 N", with the load [N] it is of."""
    return _at_load(name, load, _LABELS)


def short_symbol(name: str, load: float | None) -> str:
    """Symbol of a parameter, or its words, with the load [N] it belongs to."""
    return _at_load(name, load, _LABELS | _SYMBOLS)


def _at_load(name: str, load: float | None, texts: Mapping[str, str]) -> str:
    key, _, place = name.partition(" ")
    if load is not None and not place and key in AT_A_LOAD:
        place = f"at {engineering(load, 'N', 4, trim=True)}"
    return f"{texts.get(key, key.replace('_', ' '))} {place}".rstrip()


def digits_of(fitted: Fitted) -> int:
    """Significant digits with which the ends of an interval still differ."""
    width = fitted.high - fitted.low
    if not math.isfinite(width) or width <= 0.0 or fitted.value == 0.0:
        return 3
    return min(max(3, 2 - math.floor(math.log10(width / abs(fitted.value)))), 9)


def reason_for(coordinate: Coordinate, judged: Judged, confidence: float) -> str:
    """Why a number is not identified, in one sentence."""
    level = f"{100.0 * confidence:g} %"
    low, high = (number_text(end, coordinate.unit) for end in (judged.low, judged.high))
    if judged.verdict == ABOVE:
        return f"the loops only say that it is not above {high} ({level})"
    if judged.verdict == BELOW:
        return f"the loops only say that it is not below {low} ({level})"
    if judged.verdict != NOT:
        return ""
    answers = f"within the noise of the loops every value {{}} answers them ({level})"
    if judged.low_open and judged.high_open:
        searched = tuple(number_text(end, coordinate.unit) for end in judged.searched)
        if not all(math.isfinite(end) for end in judged.searched):
            return answers.format("that was tried")
        return answers.format(f"that was tried, from {searched[0]} to {searched[1]},")
    if judged.low_open:
        return answers.format(f"up to {high}")
    if judged.high_open:
        return answers.format(f"from {low} on")
    wide = (
        f"wider than {WIDEST_SHAPE:g}"
        if coordinate.shape
        else f"more than a factor {WIDEST_RATIO:g}"
    )
    return f"{answers.format(f'from {low} to {high}')}: {wide}"


def remedy_for(coordinate: Coordinate, verdict: str, design: Design) -> str:
    """What would settle a number that is not identified."""
    if verdict in (IDENTIFIED, FIXED):
        return ""
    if coordinate.parameter == RIG:
        return _RIG_APART + ("" if design.gross_slip else "; or record a cycle of gross slip")
    remedies = {
        _RIG_APART: design.rig_is_free,
        "records at another normal load, best a tenth or ten times of this one": (
            design.scales_with_load and design.loads < 2
        ),
        "records with microslip amplitudes, below the force limit": not design.microslip,
        "a record that reaches gross slip": not design.gross_slip,
    }
    helpful = [remedy for remedy, helps in remedies.items() if helps]
    return "; ".join(helpful or ["more cycles, or a displacement measured closer to the contact"])


def direction_of(
    coordinate: Coordinate,
    coordinates: Sequence[Coordinate],
    low: Floats,
    high: Floats,
    remedy: str,
) -> Direction | None:
    """The direction between the two ends of the profile of a coordinate; all are free ones."""
    change: dict[str, float] = {}
    for free, a, b in zip(coordinates, low, high, strict=True):
        if free.kind == "inverse":
            with np.errstate(divide="ignore"):
                change[free.name] = float(np.log(a) - np.log(b)) if min(a, b) > 0.0 else math.inf
        else:
            change[free.name] = float(b - a) * (free.scale if free.kind == "linear" else 1.0)
    if not math.isfinite(change[coordinate.name]) or change[coordinate.name] == 0.0:
        return None
    unit = 1.0 if coordinate.shape else math.log(2.0)
    if coordinate.kind == "linear" and not coordinate.shape:
        unit = math.inf
    factor = min(1.0, unit / abs(change[coordinate.name])) * math.copysign(
        1.0, change[coordinate.name]
    )
    change = {name: factor * value for name, value in change.items()}
    first = _change_text(coordinate, change[coordinate.name])
    other_changes = [
        _change_text(free, change[free.name])
        for free in sorted(coordinates, key=lambda c: -abs(change[c.name]) / _mention_limit(c))
        if free is not coordinate and abs(change[free.name]) >= _mention_limit(free)
    ]
    along = f" with {_joined(other_changes[:4])}" if other_changes else ""
    text = f"{first}{along} changes the loops by less than the noise"
    return Direction(text, change, remedy)


def _mention_limit(coordinate: Coordinate) -> float:
    """Change below which a direction does not mention a coordinate."""
    if coordinate.kind == "linear" and not coordinate.shape:
        return 1e-2 * (abs(coordinate.start) or 1.0)
    return 5e-4


def _change_text(coordinate: Coordinate, change: float) -> str:
    word = "up" if change > 0.0 else "down"
    if math.isinf(change):
        return f"{coordinate.name} {word} without end"
    if coordinate.shape or coordinate.kind == "linear":
        return f"{coordinate.name} {word} by {number_text(abs(change), coordinate.unit, 2)}"
    share = math.expm1(change)
    if share > 1.0:
        return f"{coordinate.name} up by a factor of {significant(1.0 + share, 2)}"
    return f"{coordinate.name} {word} by {significant(100.0 * abs(share), 2)} %"


def _joined(texts: Sequence[str]) -> str:
    return texts[0] if len(texts) == 1 else f"{', '.join(texts[:-1])} and {texts[-1]}"


def is_parallel(direction: Direction, reference: Direction) -> bool:
    """Whether two directions are the same but for their length and sign."""
    a, b = (
        np.nan_to_num(np.array(list(d.change.values())), posinf=10.0, neginf=-10.0)
        for d in (direction, reference)
    )
    return bool(abs(np.dot(a, b)) > 0.95 * np.linalg.norm(a) * np.linalg.norm(b))
