"""Structures with joints: modes, forced and random response, motion in time, bolted laps."""

from microslip._core.packages import names_of_stub as _names

# An oscillator alone does not load the matrices.
__getattr__, __dir__, __all__ = _names(__name__, __file__)
