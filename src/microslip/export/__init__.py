"""Export of joints to files of other programs."""

from microslip._core.packages import names_of_stub as _names

__getattr__, __dir__, __all__ = _names(__name__, __file__)
