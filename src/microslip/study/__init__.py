"""Floor 8: a validated description of one prediction, and its result."""

# As in the package itself: a template or the table of metals needs no pydantic.
import lazy_loader as _lazy

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
