"""microslip: the friction of rough, jointed surfaces by the Extended Greenwood Model."""

from microslip._core.packages import names_of_stub as _names
from microslip._version import __version__

__getattr__, __dir__, __all__ = _names(__name__, __file__)
__all__ = [*__all__, "__version__"]
