"""Public docstrings give units of numbers, shapes of arrays, and the source of what is computed."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from typing import Any

from cases import folded

import microslip as ms
from microslip.contact import Verdict
from microslip.friction import PeriodicResponse, Sliders

PUBLIC = {name: getattr(ms, name) for name in ms.__all__ if name != "__version__"}
PUBLIC |= {item.__name__: item for item in (PeriodicResponse, Sliders, Verdict)}
COMPUTING = {
    name: item
    for name, item in PUBLIC.items()
    if not item.__module__.startswith(("microslip.study", "microslip.report"))
    and name not in ("InputError", "StudyError")
}
SOURCE = re.compile(r"\(19\.\d+\)|\b10\.\d{4,}/|\bDLMF \d")
# Reference to another member for what is the same there.
LIKE = re.compile(r"\bas\s+:meth:`(\w+)`")
UNIT = re.compile(r"\[[^\]]+\]")


def members(item: type) -> Iterator[tuple[str, Any, Any]]:
    """Public members that microslip gives a class, inherited ones included, and their functions."""
    for name in dir(item):
        owner = next((c for c in item.__mro__ if name in vars(c)), object)
        if not name.startswith("_") and owner.__module__.startswith("microslip"):
            member = inspect.getattr_static(item, name)
            function = getattr(member, "__func__", member)
            yield name, member, function if inspect.isfunction(function) else None


def doc(item: type, name: str) -> str:
    """The docstring of a member with those that it stands for."""
    text = ""
    for owner in item.__mro__:
        if name in vars(owner):
            text += (getattr(vars(owner)[name], "__doc__", None) or "") + "\n"
    others = [other for other in LIKE.findall(text) if other != name]
    return text + "\n".join(getattr(item, other).__doc__ or "" for other in others)


METHODS = {
    f"{item.__name__}.{name}": (item, name, str(inspect.signature(f).replace(return_annotation="")))
    for item in COMPUTING.values()
    if inspect.isclass(item)
    for name, _, f in members(item)
    if f is not None and name in vars(item)
}


@folded("method", METHODS, whole=True)
def test_numbers_have_units_and_arrays_shapes(method: tuple[type, str, str]) -> None:
    item, name, signature = method
    if re.search(r"ArrayLike|float", signature):
        assert UNIT.search(doc(item, name)), "no unit in brackets"
    if "ArrayLike" in signature:
        assert re.search(r"shape|one-dimensional", doc(item, name)), "no shape"


@folded("item", COMPUTING, whole=True)
def test_parameters_have_units(item: Any) -> None:
    """Every parameter is described, with its unit where it is a number; what is made by others is
    described beside its fields."""
    text = inspect.getdoc(item) or ""
    assert "Parameters\n" in text or not hasattr(item, "examples") or inspect.isabstract(item)
    section = text.partition("Parameters\n")[2]
    for name, parameter in inspect.signature(item).parameters.items() if section else ():
        assert re.search(rf"(^|, )\**{name}(, \w+)* : ", section, re.MULTILINE), name
        if name != "progress" and re.search(r"float|ArrayLike|NDArray", str(parameter.annotation)):
            assert re.search(rf"(?s){name}(, \w+)* : .*?\[[^\]]+\]", section), f"unit of {name}"


@folded("item", COMPUTING, whole=True)
def test_the_source_is_reported(item: Any) -> None:
    """An equation of the chapter or a DOI, in the class or one of its own members."""
    text = item.__doc__ or ""
    for name, member, _ in members(item) if inspect.isclass(item) else ():
        text += (getattr(member, "__doc__", None) or "") if name in vars(item) else ""
    assert item is ms.units or SOURCE.search(text)  # which is arithmetic of the SI
