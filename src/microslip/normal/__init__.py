"""Floor 2: normal load laws, one class a law."""

import lazy_loader as _lazy

# Who wants one law does not wait for the others.
__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
