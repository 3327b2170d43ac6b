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


def spread_over_laws(result: Identification, refit: Refit) -> Identification:
    """The result with the limit of sliding as wide as the laws are apart that answer the loops.

    Exponential heights and one sphere beside the law itself: a tail that ends late, and none.
    """
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
