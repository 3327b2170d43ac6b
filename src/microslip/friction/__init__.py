"""Friction laws, each given by its backbone; joints, fields, their states, loops and sweeps."""

from microslip._core.packages import names_of_stub as _names

# Every law turns into other models, whichever of them is imported first.
from microslip.friction import conversions as _conversions  # noqa: F401

# One law alone does not load the others.
__getattr__, __dir__, __all__ = _names(__name__, __file__)
