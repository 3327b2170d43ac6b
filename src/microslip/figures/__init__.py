"""Figures as data, and their renderers for SVG, Matplotlib and HTML; independent of the physics."""

from microslip._core.packages import names_of_stub as _names

# SVG figures need no Matplotlib, so names are imported on first use.
__getattr__, __dir__, __all__ = _names(__name__, __file__)
