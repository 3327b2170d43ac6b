"""Documents of each product, and the writers of their pages, tables and files.

A new kind of result is a module or package here with

``KIND``
    Value of ``kind`` in its summary.json.
``document(result) -> Document``
    Its answer, sections, numbers, and the tables and texts of its folder. The modules of this
    package write the terminal output, the page, summary.json and the files from the document.
"""

from microslip._core.packages import names_of_stub as _names

# Lazy import, as in the package itself.
__getattr__, __dir__, __all__ = _names(__name__, __file__)
