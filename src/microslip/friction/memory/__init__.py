"""Hysteresis states: the memory of past reversals, at constant and at varying normal load."""

from microslip._core.packages import names_of_stub as _names

# Lazy: a single joint does not load the code for fields.
__getattr__, __dir__, __all__ = _names(__name__, __file__)
