"""One document of a result, and its renderers: terminal, HTML, JSON, CSV, netCDF. No physics."""

from microslip._core.packages import names_of_stub as _names

# Tables and figures written directly need no Matplotlib.
__getattr__, __dir__, __all__ = _names(__name__, __file__)
