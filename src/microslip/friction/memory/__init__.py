"""The law-agnostic engines of hysteresis, at a constant and at a varying normal load."""

from microslip._core.packages import names_of_stub as _names

# One joint does not load the code for many nodes.
__getattr__, __dir__, __all__ = _names(__name__, __file__)
