"""Documents of each kind of result, and the writers of their pages, tables and files.

To add a kind of result, add a module or package here that defines

``document(result) -> Document``
    Function that returns the document: the main result in a sentence, sections, numbers, and the
    tables and texts of its folder. The modules of this package write the terminal output, the
    page, summary.json and the files from the document.
"""

from microslip._core.packages import names_of_stub as _names

# Lazy import, as in the package itself.
__getattr__, __dir__, __all__ = _names(__name__, __file__)
