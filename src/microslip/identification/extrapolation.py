"""Limits of sliding that no record reached: what other laws make of the same loops."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import MappingProxyType

from microslip._core.units import significant
from microslip.errors import InputError
from microslip.heights import Exponential
from microslip.identification.result import Identification
from microslip.identification.verdicts import BEYOND

FRICTION = "friction_coefficient"
_AS_GOOD = 10.0
"""Akaike's criterion over that of the best law up to which another law answers the loops, too."""

Refit = Callable[..., Identification]
"""Identifies another law, by its name and options, from the same records."""


def spread_over_laws(found: Identification, refit: Refit) -> Identification:
    """The result with the limit of sliding as wide as the laws are apart that answer the loops.

    Exponential heights and one sphere beside the law itself: a tail that ends late, and none.
    """
    friction = found.parameters.get(FRICTION)
    if friction is None or friction.verdict != BEYOND:
        return found
    others = {}
    for name, law, options in (
        ("exponential heights", "interface", {"heights": Exponential(1.0)}),
        ("one sphere", "sphere", {}),
    ):
        try:
            others[name] = refit(law, **options)
        except InputError:
            continue
    least = min([found.aic, *(other.aic for other in others.values() if other.converged)])
    low, high, said = friction.low, friction.high, []
    for name, other in others.items():
        number = other.parameters[FRICTION]
        if not other.converged or other.aic > least + _AS_GOOD:
            continue
        low, high = min(low, number.low), max(high, number.high)
        said.append(f"{significant(number.value, 3)} ({name})")
    if not said:
        more = "; of other laws (exponential heights, one sphere) none answers these loops as well"
    else:
        more = f"; laws that answer these loops as well find {', '.join(said)}"
    wider = {FRICTION: replace(friction, low=low, high=high, reason=friction.reason + more)}
    parts = low / friction.value, high / friction.value
    derived = {
        name: replace(
            number,
            low=min(number.low, parts[0] * number.value),
            high=max(number.high, parts[1] * number.value),
        )
        if number.verdict == BEYOND
        else number
        for name, number in found.derived.items()
    }
    return replace(
        found,
        parameters=MappingProxyType({**found.parameters, **wider}),
        derived=MappingProxyType(derived),
    )
