"""From measured loops to the parameters of a law, with what they cannot tell."""

import lazy_loader as _lazy

# Commands read their options from here without waiting for what they work on.
__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
