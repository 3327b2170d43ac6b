"""Spread of a fit's numbers over other laws that fit the same loops as well."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType

from microslip._core.errors import InputError
from microslip.contact.heights import Exponential
from microslip.identification.caveats import BEYOND, Caveat, number_text
from microslip.identification.result import Identification
from microslip.identification.verdicts import Fitted, mark

Numbers = Mapping[str, Fitted]
FRICTION, _SEPARATION = "friction_coefficient", "standardised_separation"

_AS_GOOD = 10.0
"""Akaike's criterion over that of the best law up to which another law answers the loops, too."""

Refit = Callable[..., Identification]
"""Identifies another law, by its name and options, from the same records."""


def spread_over_laws(result: Identification, refit: Refit) -> Identification:
    """Spread of the numbers over other laws that fit the loops as well.

    The limit of sliding that no record reached is as wide as exponential heights and a sphere have
    it. Where heights are searched without an upper end, their limit is the exponential one: what
    that has elsewhere is in doubt.
    """
    parameters = result.parameters
    is_beyond = FRICTION in parameters and parameters[FRICTION].verdict == BEYOND
    is_open = any(n.high_open for name, n in parameters.items() if name.startswith(_SEPARATION))
    refits = {}
    for name, law, options in (
        ("exponential heights", "interface", {"heights": Exponential(1.0)}),
        ("one sphere", "sphere", {}),
    ):
        if is_beyond or (is_open and law == "interface"):
            try:
                refits[name] = refit(law, summits=math.inf, intervals="curvature", **options)
            except InputError:
                continue
    best_aic = min([result.aic, *(fit.aic for fit in refits.values() if fit.converged)])
    as_good = {
        name: fit
        for name, fit in refits.items()
        if fit.converged and fit.aic <= best_aic + _AS_GOOD
    }
    if is_beyond:
        result = _beyond(result, {name: fit.parameters[FRICTION] for name, fit in as_good.items()})
    if is_open and (exponential := as_good.get("exponential heights")) is not None:
        result = _elsewhere(result, {**exponential.parameters, **exponential.derived})
    return result


def _elsewhere(result: Identification, other_numbers: Numbers) -> Identification:
    """Numbers that another law has outside their intervals are in doubt."""

    def doubted(numbers: Numbers) -> MappingProxyType[str, Fitted]:
        marked = dict(numbers)
        for name, number in numbers.items():
            other = other_numbers.get(name)
            if other is None or other.at_bound:  # an open separation opens intervals, no values
                continue
            if not number.low <= other.value <= number.high:
                data = {"value": other.value, "unit": other.unit}
                marked |= mark({name: number}, Caveat("other heights", data))
        return MappingProxyType(marked)

    return replace(result, parameters=doubted(result.parameters), derived=doubted(result.derived))


def _beyond(result: Identification, found: Numbers) -> Identification:
    """The limits of sliding as wide as other laws have them."""
    friction = result.parameters[FRICTION]
    assert friction.caveat is not None
    low = min([friction.low, *(number.low for number in found.values())]) / friction.value
    high = max([friction.high, *(number.high for number in found.values())]) / friction.value
    laws = [f"{number_text(number.value, '')} ({name})" for name, number in found.items()]
    spread = {"laws": laws or None, "none": None if laws else ""}
    caveat = replace(friction.caveat, data={**friction.caveat.data, **spread})

    def widened(numbers: Numbers) -> MappingProxyType[str, Fitted]:
        return MappingProxyType(
            {
                name: replace(
                    number,
                    low=min(number.low, low * number.value),
                    high=max(number.high, high * number.value),
                    caveat=caveat,
                )
                if number.verdict == BEYOND
                else number
                for name, number in numbers.items()
            }
        )

    return replace(result, parameters=widened(result.parameters), derived=widened(result.derived))
