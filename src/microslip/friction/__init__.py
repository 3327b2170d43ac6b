"""Floor 5: tangential laws, each fully given by its backbone, and one that is not."""

import lazy_loader as _lazy

# Every law turns into other models, whichever of them is imported first.
from microslip.friction import conversions as _conversions  # noqa: F401

# Who wants one law does not wait for the others.
__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
