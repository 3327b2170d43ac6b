"""Floor 8: joints in a structure."""

import lazy_loader as _lazy

# Who wants an oscillator does not wait for matrices.
__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
