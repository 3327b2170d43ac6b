"""Documents of each product, and the writers of their pages, tables and files.

A new kind of result is one module here (or a package, where it is long). It offers

``KIND``
    Value of ``kind`` in its summary.json.
``document(result) -> Document``
    Its answer, sections, numbers, and the tables and texts of its folder. The terminal, the page,
    summary.json and the files are written from the document by the modules of this package.
"""

from microslip._core.packages import names_of_stub as _names

# Names are loaded when they are first used, as in the package itself.
__getattr__, __dir__, __all__ = _names(__name__, __file__)
