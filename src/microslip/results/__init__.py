"""What each product says of itself, as one document: predicted, measured, identified, scanned.

A new kind of result is one module here (or a package, where it is long). It offers

``KIND``
    What its summary.json says it is.
``document(result) -> Document``
    Its answer, sections and plain numbers. The terminal, the page and summary.json follow.
``files(result) -> tuple of File``
    What is written: :func:`~microslip.report.files.standard_files` with the document, and the
    tables and arrays of its own.

and nothing else: how these look and how they are written whole or not at all is the business of
:mod:`microslip.report`.
"""

# As in the package itself: what is not used is not loaded.
import lazy_loader as _lazy

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
