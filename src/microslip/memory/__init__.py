"""Floor 3: the law-agnostic engines of hysteresis, at a constant and at a varying normal load."""

import lazy_loader as _lazy

# One joint does not wait for what moves many.
__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
