"""Documents of each product: predicted, measured, identified, scanned.

A new kind of result is one module here (or a package, where it is long). It offers

``KIND``
    What its summary.json says it is.
``document(result) -> Document``
    Its answer, sections, plain numbers, and the tables and texts that go with it into a folder.
    The terminal, the page, summary.json and the files follow.

and nothing else: how these look and how they are written whole or not at all is the business of
:mod:`microslip.report`.
"""

# As in the package itself: what is not used is not loaded.
from microslip._core.packages import names_of_stub as _names

__getattr__, __dir__, __all__ = _names(__name__, __file__)
