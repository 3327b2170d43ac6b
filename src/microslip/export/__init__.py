"""Export of joints to files for other programs, and adapters for other Python solvers."""

from microslip._core.packages import names_of_stub as _names

__getattr__, __dir__, __all__ = _names(__name__, __file__, {"CardFile": "use ContactCard"})
