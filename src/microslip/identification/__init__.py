"""Identification of the parameters of a law from measured loops, with their uncertainty."""

from microslip._core.packages import names_of_stub as _names

# Commands read their options here before the modules that do the work are loaded.
__getattr__, __dir__, __all__ = _names(__name__, __file__)
