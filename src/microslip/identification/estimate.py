"""Estimate of a quantity with its confidence interval."""

from __future__ import annotations

from typing import Any, NamedTuple


class Estimate(NamedTuple):
    """Value with its 95 % confidence interval; all fields are numbers, or arrays of one shape."""

    value: Any
    """Best estimate; not a number where only one end of the interval is known."""
    low: Any
    """Lower end."""
    high: Any
    """Upper end; infinite if the loops give no upper bound."""


def as_pair(datum: Any) -> Any:
    """Return (value, standard deviation) of a datum that has both, otherwise the datum itself.

    Both are attributes of numbers of the package uncertainties (``nominal_value``, ``std_dev``) and
    of estimates of this package (``value``, ``standard_error``).
    """
    for names in (("nominal_value", "std_dev"), ("value", "standard_error")):
        if all(hasattr(datum, name) for name in names):
            return tuple(getattr(datum, name) for name in names)
    return datum
