"""Measured surfaces, their parameters and their summits."""

from microslip._core.packages import names_of_stub as _names

# Lazy import: commands read the options before the modules that compute are loaded.
__getattr__, __dir__, __all__ = _names(__name__, __file__, {"AxisSpectrum": "write Spectrum"})
