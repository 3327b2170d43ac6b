"""Names and packages that are loaded when they are first used.

The core of the library runs where only NumPy and SciPy are installed. What reads units, validates
studies, draws or writes files loads its package in a function, and says in one line which one is
missing.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

from microslip._core.errors import InputError


class MissingPackageError(InputError, ImportError):
    """A package is not installed; the message says what needs it and how it is installed."""


@contextmanager
def needed_for(purpose: str, extra: str = "", instead: str = "") -> Iterator[None]:
    """Say in one line that a package is missing, where one is that the block imports.

    Parameters
    ----------
    purpose : str
        Subject that needs it, with its verb, such as ``"units need"``.
    extra : str
        Extra of microslip that brings it; none for what an installation has by itself.
    instead : str
        Alternative that needs no package.
    """
    try:
        yield
    except ModuleNotFoundError as missing:
        package = str(missing.name).partition(".")[0]
        if package == "microslip":
            raise
        requirement = f'"microslip[{extra}]"' if extra else _DISTRIBUTIONS.get(package, package)
        raise MissingPackageError(
            f"{purpose} {package}, which is not installed: pip install {requirement}"
            + (f"; {instead}" if instead else "")
        ) from None


_DISTRIBUTIONS = {"skfem": "scikit-fem"}
"""Packages that are installed under another name than they are imported by."""


def names_of_stub(
    package: str, file: str, removed: Mapping[str, str] | None = None
) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """Make ``__getattr__``, ``__dir__`` and ``__all__`` of a package from its stub.

    Parameters
    ----------
    package : str
        Name of the package, its ``__name__``.
    file : str
        Its ``__file__``. The stub beside it imports every public name from the module that holds
        it, ``from .module import name as name``.
    removed : mapping, optional
        Names of earlier versions, and what to use instead.
    """
    tree = ast.parse(Path(file).with_suffix(".pyi").read_text(encoding="utf-8"))
    modules = {
        alias.name: f"{package}.{node.module}"
        for node in tree.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }

    def find(name: str) -> Any:
        if name not in modules:
            remedy = f"; removed in 0.3: {removed[name]}" if removed and name in removed else ""
            raise AttributeError(f"module {package!r} has no attribute {name!r}{remedy}")
        with needed_for(f"{package}.{name} needs"):
            value = getattr(import_module(modules[name]), name)
        setattr(sys.modules[package], name, value)
        return value

    return find, lambda: sorted(modules), sorted(modules)
