"""Imports on first use: names of a package, and optional packages.

The core of the library needs only NumPy. Functions that fit, read units, validate studies, draw or
write files import further packages when called, and report a missing one in one line.
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
    """Optional package that is not installed; the message gives the pip command."""


@contextmanager
def needed_for(purpose: str, extra: str = "", instead: str = "") -> Iterator[None]:
    """Convert the error of a package that is missing inside the block to a one-line message.

    Parameters
    ----------
    purpose : str
        Beginning of the message, such as ``"units need"``; the name of the package follows.
    extra : str
        Optional extra of microslip that installs the package; empty if microslip requires it.
    instead : str
        End of the message: what can be used without the package.
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
"""Names on PyPI of packages with a different import name."""


def names_of_stub(
    package: str, file: str, removed: Mapping[str, str] | None = None
) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """Create ``__getattr__``, ``__dir__`` and ``__all__`` of a package from its stub.

    Parameters
    ----------
    package : str
        Name of the package, its ``__name__``.
    file : str
        ``__file__`` of the package. The stub beside it imports each public name from its module,
        ``from .module import name as name``.
    removed : mapping, optional
        Names of earlier versions with their replacements.
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
