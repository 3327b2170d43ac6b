"""Pairs of elastic materials, distributions of summit heights, and normal load laws N(d)."""

from microslip._core.packages import names_of_stub as _names

# One law alone does not load the others.
__getattr__, __dir__, __all__ = _names(__name__, __file__)
