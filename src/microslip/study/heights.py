"""Summit heights of a study, including the distributions of SciPy."""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np

from microslip._core.parameters import key_of
from microslip._core.wording import did_you_mean, quote, shorten
from microslip.contact.heights import HEIGHTS, Statistical
from microslip.study.fields import (
    HEIGHT,
    UNCERTAIN_LENGTH,
    Numbers,
    can_be_described,
    scalar,
    table_of,
    text,
)
from microslip.study.part import Part, SubTable, key, tag
from microslip.study.readers import KeyedError, NamedValues, Place


def distribution_names() -> list[str]:
    """Return the names of the continuous distributions of scipy.stats."""
    from scipy import stats

    return [name for name in dir(stats) if isinstance(getattr(stats, name), stats.rv_continuous)]


class GivenHeights(Part):
    """Individual summit heights [m], all equally likely."""

    kind: str = tag("values", "Given heights, all equally likely.")
    values: tuple[float, ...] = key(
        Numbers(HEIGHT, '["0.4 um", "0.7 um"]'), "Heights: a list or a column of a CSV file."
    )

    def build(self) -> Any:
        """Return the heights as an array."""
        return np.array(self.values)


class ScipyHeights(Part):
    """A continuous distribution of scipy.stats as summit heights, with loc and scale [m]."""

    kind: str = tag("scipy", "A continuous distribution of scipy.stats.")
    distribution: str = key(
        text("the name of a distribution", "weibull_min"),
        'Name in scipy.stats, such as "weibull_min".',
    )
    parameters: dict[str, float] = key(
        NamedValues(scalar(), "{ c = 2.0 }"),
        "Shape parameters by their names in SciPy; plain numbers.",
        default={},
    )
    location: float = key(HEIGHT, "Parameter loc of SciPy, a shift of all heights.", default=0.0)
    scale: float = key(UNCERTAIN_LENGTH, "Parameter scale of SciPy.", '"1 um"')

    def build(self) -> Any:
        """Return the frozen distribution of scipy.stats, heights in metres."""
        from scipy import stats

        distribution = getattr(stats, self.distribution)
        return distribution(**self.parameters, loc=self.location, scale=self.scale)

    def check(self, place: Place) -> None:
        """Record an error for unknown distributions, or those that give infinite loads."""
        from scipy import stats

        name, words = self.distribution, f"scipy.stats.{self.distribution} refuses them"
        if not isinstance(getattr(stats, name, None), stats.rv_continuous):
            expected = 'a continuous distribution of scipy.stats such as "weibull_min"'
            near = did_you_mean(name, distribution_names())
            raise KeyedError(".distribution", f"wanted {expected}, got {quote(name)}{near}")
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            try:
                heights = self.build()
                # SciPy marks invalid parameters by a support of NaN.
                if any(map(math.isnan, heights.support())):
                    raise ValueError("out of their range")
            except Exception as error:  # SciPy functions raise various errors
                raise KeyedError(".parameters", f"{words}: {_reason(error)}") from None
            try:
                Statistical(heights)
            except Exception as error:
                raise ValueError(f"scipy.stats.{name}: {_reason(error)}") from None


def _reason(error: Exception) -> str:
    return shorten(" ".join(str(error).split()) or type(error).__name__, 120)


_OWN_TABLES: dict[str, type[Part]] = {"values": GivenHeights, "scipy": ScipyHeights}

HEIGHTS_TABLES: dict[str, type[Any]] = {
    name: _OWN_TABLES.get(name) or table_of(kind, "kind", __name__)
    for kind in HEIGHTS
    if (name := key_of(kind)) in _OWN_TABLES or can_be_described(kind)
}
"""Tables of all exported heights, by kind."""


ANY_HEIGHTS = SubTable(*HEIGHTS_TABLES.values(), tag="kind")

# Generated classes must be found by name to be pickled.
globals().update({table.__name__: table for table in HEIGHTS_TABLES.values()})
