"""Numbers whose intervals close, but under what does not hold."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from microslip._core.units import significant
from microslip.identification.coordinates import AREA, DENSITY, RADIUS, Coordinate
from microslip.identification.folding import Folded
from microslip.identification.verdicts import (
    APPARENT,
    BEYOND,
    IDENTIFIED,
    IN_DOUBT,
    Fitted,
    number_text,
)

LIMITS = ("friction_coefficient", "force_limit")
"""Numbers that only a contact in gross slip shows."""
REACHED = 0.95
"""Share of the limit that a record has to reach for it to be seen."""
_FAR = 10.0
"""Ratio of loads from which on the one of a contact area is far from those of the records."""
BY_AREA = (RADIUS, DENSITY, "summit_count")
"""What follows from a contact area."""


def mark_in_doubt(numbers: Mapping[str, Fitted], why: str) -> dict[str, Fitted]:
    """The same numbers, none identified: what they were found under does not hold."""
    return {
        name: replace(fitted, verdict=IN_DOUBT, reason=why)
        if fitted.verdict in (IDENTIFIED, APPARENT)
        else fitted
        for name, fitted in numbers.items()
    }


def with_remedy(numbers: Mapping[str, Fitted], remedy: str) -> dict[str, Fitted]:
    """The same numbers, with what would settle those in doubt."""
    return {
        name: replace(fitted, remedy=remedy) if fitted.verdict in (IN_DOUBT, APPARENT) else fitted
        for name, fitted in numbers.items()
    }


def mark_apparent(
    numbers: Mapping[str, Fitted], folded: Sequence[Folded], stake: float | None
) -> dict[str, Fitted]:
    """The same numbers, those identified as what a law that does not answer comes closest with."""
    ends = [
        " to ".join(dict.fromkeys(number_text(end, unit) for end in (min(values), max(values))))
        for values, unit in (
            ([record.amplitude for record in folded], "m"),
            ([record.normal_load for record in folded if record.normal_load], "N"),
        )
        if values
    ]
    why = (
        f"of a law that does not answer the records: it stands for loops of {' at '.join(ends)} in "
        "the mean"
    )
    if stake is not None:
        why += f"; what the law lacks may hide {significant(100.0 * stake, 2)} % of a number"
    return with_remedy(
        {
            name: replace(fitted, verdict=APPARENT, reason=why)
            if fitted.verdict == IDENTIFIED
            else fitted
            for name, fitted in numbers.items()
        },
        "free or correct what is fixed, or compare laws: their spread says more than an interval",
    )


def mark_extrapolated(numbers: Mapping[str, Fitted], reached: float) -> dict[str, Fitted]:
    """The same numbers, the limit of sliding as what no record reached."""
    why = (
        f"no record slides as a whole: the loops reach {significant(100.0 * reached, 2)} % of this "
        "limit, and the rest is what the law makes of it"
    )
    return {
        name: replace(fitted, verdict=BEYOND, reason=why, remedy="a record that reaches gross slip")
        if fitted.verdict in (IDENTIFIED, APPARENT) and name.partition(" ")[0] in LIMITS
        else fitted
        for name, fitted in numbers.items()
    }


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
    ends = " to ".join(
        dict.fromkeys(number_text(end, "N") for end in (min(record_loads), max(record_loads)))
    )
    return (
        f"the contact area was measured at {number_text(measured, 'N')}, far from the loads of the "
        f"records, {ends}: what follows from it rests on the law between them"
    )
