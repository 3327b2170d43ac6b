"""microslip: the friction of rough, jointed surfaces by the Extended Greenwood Model."""

import lazy_loader as _lazy

from microslip._version import __version__

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
__all__ = [*__all__, "__version__"]
