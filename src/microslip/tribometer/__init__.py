"""Records of rigs and the loops in them."""

from microslip._core.packages import names_of_stub as _names

# Commands read their options from here without waiting for what they work on.
__getattr__, __dir__, __all__ = _names(__name__, __file__)
