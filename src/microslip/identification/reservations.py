"""Numbers whose intervals close, but under what does not hold."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from microslip._core.units import significant
from microslip.identification.coordinates import AREA, DENSITY, RADIUS, RIG, Coordinate
from microslip.identification.verdicts import IDENTIFIED, IN_DOUBT, Fitted, shown

LEANT = 4.0
"""Reduced chi-squared from which on the rig's stiffness hangs on the law more than on the loops."""
GROWN = 0.1
"""Growth of the force over the cycles of a record from which on a mean over them is of no state."""
_FAR = 10.0
"""Ratio of loads from which on the one of a contact area is far from those of the records."""
BY_AREA = (RADIUS, DENSITY, "summit_count")
"""What follows from a contact area."""


def in_doubt(numbers: Mapping[str, Fitted], why: str) -> dict[str, Fitted]:
    """The same numbers, none identified: what they were found under does not hold."""
    return {
        name: replace(fitted, verdict=IN_DOUBT, reason=why)
        if fitted.verdict == IDENTIFIED
        else fitted
        for name, fitted in numbers.items()
    }


def remedied(numbers: Mapping[str, Fitted], remedy: str) -> dict[str, Fitted]:
    """The same numbers, with what would settle those in doubt."""
    return {
        name: replace(fitted, remedy=remedy) if fitted.verdict == IN_DOUBT else fitted
        for name, fitted in numbers.items()
    }


def hung_on_law(numbers: Mapping[str, Fitted], reduced: float) -> dict[str, Fitted]:
    """The same numbers, the rig's stiffness with a word on the law under which it was found."""
    why = (
        "it hangs on the law: it takes up what the law lacks, which leaves "
        f"{significant(math.sqrt(reduced), 2)} times the noise, and other laws find other values"
    )
    remedy = "compare laws; measure the rig's stiffness apart and give it with its uncertainty"
    return {
        name: replace(fitted, reason=why, remedy=remedy)
        if name.startswith(RIG) and fitted.verdict == IDENTIFIED
        else fitted
        for name, fitted in numbers.items()
    }


def far_area(coordinates: Sequence[Coordinate], loads: Sequence[float | None]) -> str | None:
    """What says that a contact area was measured at a load that no record is near."""
    measured = next(
        (coordinate.load for coordinate in coordinates if coordinate.parameter == AREA), None
    )
    known = [load for load in loads if load]
    if measured is None or not known:
        return None
    if min(known) / _FAR <= measured <= _FAR * max(known):
        return None
    ends = " to ".join(dict.fromkeys(shown(end, "N") for end in (min(known), max(known))))
    return (
        f"the contact area was measured at {shown(measured, 'N')}, far from the loads of the "
        f"records, {ends}: what follows from it rests on the law between them"
    )
