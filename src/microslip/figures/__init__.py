"""Figures as data, and their renderers: SVG, Matplotlib, HTML. No physics."""

from microslip._core.packages import names_of_stub as _names

# Figures as SVG need no Matplotlib, so the names below are loaded when they are first used.
__getattr__, __dir__, __all__ = _names(__name__, __file__)
