"""Numbers whose intervals close, but under what does not hold."""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

from microslip._core.units import significant
from microslip.errors import InputError
from microslip.heights import Exponential
from microslip.identification.coordinates import AREA, DENSITY, RADIUS, Coordinate
from microslip.identification.result import Identification
from microslip.identification.verdicts import (
    APPARENT,
    BEYOND,
    IDENTIFIED,
    IN_DOUBT,
    Fitted,
    number_text,
)
from microslip.tribometer.folding import Folded

FRICTION = "friction_coefficient"
LIMITS = (FRICTION, "force_limit")
"""Numbers that only a contact in gross slip shows."""
REACHED = 0.95
"""Share of the limit that a record has to reach for it to be seen."""
_FAR = 10.0
"""Ratio of loads from which on the one of a contact area is far from those of the records."""
BY_AREA = (RADIUS, DENSITY, "summit_count")
"""What follows from a contact area."""


def mark(
    numbers: Mapping[str, Fitted],
    verdict: str,
    reason: str,
    of: Sequence[str] = (IDENTIFIED, APPARENT),
    names: Container[str] | None = None,
) -> dict[str, Fitted]:
    """The numbers, some ``of`` those verdicts with another: what they rest on does not hold."""
    return {
        name: replace(fitted, verdict=verdict, reason=reason)
        if fitted.verdict in of and (names is None or name in names)
        else fitted
        for name, fitted in numbers.items()
    }


def with_remedy(
    numbers: Mapping[str, Fitted],
    remedy: str,
    of: Sequence[str] = (IN_DOUBT, APPARENT),
    names: Container[str] | None = None,
) -> dict[str, Fitted]:
    """The same numbers, with what would settle some ``of`` those verdicts."""
    return {
        name: replace(fitted, remedy=remedy)
        if fitted.verdict in of and (names is None or name in names)
        else fitted
        for name, fitted in numbers.items()
    }


def mark_apparent(
    numbers: Mapping[str, Fitted], folded: Sequence[Folded], stake: float | None
) -> dict[str, Fitted]:
    """The same numbers, those identified as what a law that does not answer comes closest with."""
    amplitudes = range_text([record.amplitude for record in folded], "m")
    loads = range_text([record.normal_load for record in folded if record.normal_load], "N")
    reason = (
        f"of a law that does not answer the records: it stands for loops of "
        f"{' at '.join(filter(None, (amplitudes, loads)))} in the mean"
    )
    if stake is not None:
        reason += f"; what the law lacks may hide {significant(100.0 * stake, 2)} % of a number"
    return with_remedy(
        mark(numbers, APPARENT, reason, of=(IDENTIFIED,)),
        "free or correct what is fixed, or compare laws: their spread says more than an interval",
    )


def mark_extrapolated(numbers: Mapping[str, Fitted], reached: float) -> dict[str, Fitted]:
    """The same numbers, the limit of sliding as what no record reached."""
    reason = (
        f"no record slides as a whole: the loops reach {significant(100.0 * reached, 2)} % of this "
        "limit, and the rest is what the law makes of it"
    )
    limits = [name for name in numbers if name.partition(" ")[0] in LIMITS]
    marked = mark(numbers, BEYOND, reason, names=limits)
    return with_remedy(marked, "a record that reaches gross slip", (BEYOND,))


def range_text(values: Sequence[float], unit: str) -> str:
    """The lowest to the highest value, one of them where they read alike; empty without any."""
    ends = (min(values), max(values)) if values else ()
    return " to ".join(dict.fromkeys(number_text(end, unit) for end in ends))


def far_area(coordinates: Sequence[Coordinate], loads: Sequence[float | None]) -> str | None:
    """What says that a contact area was measured at a load that no record is near."""
    measured = next(
        (coordinate.load for coordinate in coordinates if coordinate.parameter == AREA), None
    )
    record_loads = [load for load in loads if load]
    if measured is None or not record_loads:
        return None
    if min(record_loads) / _FAR <= measured <= _FAR * max(record_loads):
        return None
    return (
        f"the contact area was measured at {number_text(measured, 'N')}, far from the loads of the "
        f"records, {range_text(record_loads, 'N')}: what follows from it rests on the law between "
        "them"
    )


_AS_GOOD = 10.0
"""Akaike's criterion over that of the best law up to which another law answers the loops, too."""

Refit = Callable[..., Identification]
"""Identifies another law, by its name and options, from the same records."""


def spread_over_laws(result: Identification, refit: Refit) -> Identification:
    """The limit of sliding as wide as exponential heights and a sphere have it, if they answer."""
    friction = result.parameters.get(FRICTION)
    if friction is None or friction.verdict != BEYOND:
        return result
    refits = {}
    for name, law, options in (
        ("exponential heights", "interface", {"heights": Exponential(1.0)}),
        ("one sphere", "sphere", {}),
    ):
        try:
            refits[name] = refit(law, **options)
        except InputError:
            continue
    best_aic = min([result.aic, *(fit.aic for fit in refits.values() if fit.converged)])
    low, high, values = friction.low, friction.high, []
    for name, fit in refits.items():
        number = fit.parameters[FRICTION]
        if not fit.converged or fit.aic > best_aic + _AS_GOOD:
            continue
        low, high = min(low, number.low), max(high, number.high)
        values.append(f"{significant(number.value, 3)} ({name})")
    if not values:
        laws_note = (
            "; of other laws (exponential heights, one sphere) none answers these loops as well"
        )
    else:
        laws_note = f"; laws that answer these loops as well find {', '.join(values)}"
    wider = {FRICTION: replace(friction, low=low, high=high, reason=friction.reason + laws_note)}
    parts = low / friction.value, high / friction.value
    derived = {
        name: replace(
            number,
            low=min(number.low, parts[0] * number.value),
            high=max(number.high, parts[1] * number.value),
        )
        if number.verdict == BEYOND
        else number
        for name, number in result.derived.items()
    }
    return replace(
        result,
        parameters=MappingProxyType({**result.parameters, **wider}),
        derived=MappingProxyType(derived),
    )
