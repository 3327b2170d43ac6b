"""Friction laws of joints and of fields of contact nodes: hysteresis, closed loops, sweeps."""

from microslip._core.packages import names_of_stub as _names

# Give `to_iwan` to every law, whichever law is imported first.
from microslip.friction import conversions as _conversions  # noqa: F401

# Lazy: importing one law does not load the others.
__getattr__, __dir__, __all__ = _names(
    __name__, __file__, {"SegalmanFit": "fit SegalmanIwan with SciPy as in docs/comparison.md"}
)
