"""An estimate with its confidence interval."""

from __future__ import annotations

from typing import Any, NamedTuple


class Estimate(NamedTuple):
    """An estimate with its 95 % confidence interval, numbers or arrays of one shape."""

    value: Any
    """Best estimate; not a number where only one end of the interval is known."""
    low: Any
    """Lower end."""
    high: Any
    """Upper end; infinity where the loops give none."""
