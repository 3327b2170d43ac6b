"""Each public docstring gives units, shapes, errors raised and its source."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from typing import Any

import pytest
from cases import folded

import microslip as ms
from microslip.friction import PeriodicResponse, Sliders, Verdict

ERRORS = {"InputError", "StudyError"}
PUBLIC = [getattr(ms, name) for name in ms.__all__ if name != "__version__"]
PUBLIC += [PeriodicResponse, Sliders, Verdict]
CORE = [
    item
    for item in PUBLIC
    if not item.__module__.startswith(("microslip.study", "microslip.results"))
    and item.__name__ not in ERRORS
]
SOURCE = re.compile(r"\(19\.\d+\)|\b10\.\d{4,}/|\bDLMF \d")
# Reference to another member for what is the same there.
LIKE = re.compile(r"\bas\s+:meth:`(\w+)`")


def members(item: type) -> Iterator[tuple[str, Any]]:
    """Public members that microslip gives a class, inherited ones included."""
    for name in dir(item):
        if name.startswith("_"):
            continue
        owner = next((c for c in item.__mro__ if name in vars(c)), object)
        if not owner.__module__.startswith("microslip"):
            continue
        yield name, inspect.getattr_static(item, name)


def function_of(member: Any) -> Any:
    if isinstance(member, (classmethod, staticmethod)):
        return member.__func__
    return member if inspect.isfunction(member) else None


def doc(item: type, name: str) -> str:
    """The docstring of a member with those that it stands for."""
    text = ""
    for owner in item.__mro__:
        found = vars(owner).get(name)
        if found is None:
            continue
        own = getattr(function_of(found) or found, "__doc__", None) or ""
        text += own + "\n"
        for other in LIKE.findall(own):
            assert hasattr(item, other)
            text += (getattr(getattr(item, other), "__doc__", None) or "") + "\n"
    return text


METHODS = [
    (item, name, function_of(member))
    for item in CORE
    for name, member in members(item)
    if function_of(member) is not None and name in vars(item)
]
WITH_NUMBERS = [
    (item, name, function)
    for item, name, function in METHODS
    if re.search(r"ArrayLike|float", str(inspect.signature(function).replace(return_annotation="")))
]


ROWS = {f"{row[0].__name__}.{row[1]}": row for row in WITH_NUMBERS}
CLASSES = {item.__name__: item for item in PUBLIC}


@folded("item", CLASSES, whole=True)
def test_everything_public_has_a_docstring(item: type) -> None:
    # A dataclass writes its signature where there is none.
    assert item.__doc__
    assert not item.__doc__.startswith(f"{item.__name__}(")
    missing = []
    for name, member in members(item):
        named = (
            PeriodicResponse,
            Verdict,
            ms.FirstLoading,
            ms.HarmonicForce,
            ms.CoupledHarmonics,
            ms.SegalmanFit,
            ms.FieldResponse,
        )
        if item in (*named, ms.CoupledHarmonics, ms.FieldResponse):
            continue  # named tuples document their fields beside them
        target = function_of(member) or member
        if name in getattr(item, "__annotations__", {}) or name in getattr(
            item, "__dataclass_fields__", {}
        ):
            continue  # fields are the parameters of the class
        if name in getattr(item, "keys", {}):
            continue
        if not (getattr(target, "__doc__", None) or "").strip():
            missing.append(name)
    assert missing == []


@folded("row", ROWS, whole=True)
def test_units(row: tuple[type, str, Any]) -> None:
    item, name, _ = row
    assert re.search(r"\[[^\]]+\]", doc(item, name)), "no unit in brackets"


@folded("row", ROWS, whole=True)
def test_shapes(row: tuple[type, str, Any]) -> None:
    item, name, function = row
    if "ArrayLike" not in str(inspect.signature(function)):
        pytest.skip("takes no array")
    assert re.search(r"shape|one-dimensional", doc(item, name))


@folded("item", {item.__name__: item for item in CORE}, whole=True)
def test_parameters_of_classes(item: type) -> None:
    """Every parameter of a class is described, with its unit where it is a number."""
    made = (
        PeriodicResponse,
        Sliders,
        Verdict,
        ms.State,
        ms.Trial,
        ms.HarmonicForce,
        ms.CoupledHarmonics,
        ms.AsperityFields,
        ms.FirstLoading,
        ms.SegalmanFit,
        ms.CoupledResponse,
        ms.CoupledCycle,
        ms.FieldResponse,
        ms.FieldCycle,
        ms.ForcedResponse,
        ms.FreeDecay,
        ms.Convergence,
        ms.Decay,
        ms.MeshedJoint,
        ms.ModalIdentification,
        ms.ReducedJoint,
        ms.RingDown,
        ms.ModalCurve,
        ms.Motion,
        ms.Preload,
        ms.FieldState,
        ms.IwanFit,
        ms.IsotropicField,
        ms.VectorCycle,
        ms.VectorResponse,
        ms.VectorState,
        ms.Summits,
        ms.Identification,
        ms.Comparison,
    )
    if inspect.isabstract(item) or item in made:
        return
    text = inspect.getdoc(item) or ""
    assert "Parameters\n" in text
    section = text.partition("Parameters\n")[2]
    for name, parameter in inspect.signature(item).parameters.items():
        assert re.search(rf"(^|, )\**{name}(, \w+)* : ", section, re.MULTILINE), name
        if name != "progress" and re.search(r"float|ArrayLike|NDArray", str(parameter.annotation)):
            assert re.search(rf"(?s){name}(, \w+)* : .*?\[[^\]]+\]", section), f"unit of {name}"


@folded("item", {c.__name__: c for c in CORE if hasattr(ms, c.__name__)}, whole=True)
def test_source(item: type) -> None:
    """An equation of the chapter or a DOI, in the class or one of its own members."""
    if item is ms.units:
        return  # arithmetic of the SI
    text = item.__doc__ or ""
    for name, member in members(item):
        if name in vars(item):
            text += getattr(function_of(member) or member, "__doc__", None) or ""
    assert SOURCE.search(text)


@folded("item", CLASSES, whole=True)
def test_lines_are_not_long(item: type) -> None:
    for text in [item.__doc__ or ""] + [
        getattr(function_of(m) or m, "__doc__", None) or ""
        for _, m in members(item)
        if function_of(m) or isinstance(m, property)
    ]:
        first = text.strip().partition("\n\n")[0]
        assert len(first.replace("\n", " ")) < 300
        assert all(len(line) <= 100 for line in text.split("\n"))


def test_both_damping_measures_are_told_apart() -> None:
    for item in (ms.Interface, ms.Loop):
        eta, zeta = inspect.getdoc(item.loss_factor), inspect.getdoc(item.damping_ratio)
        assert eta is not None
        assert "(19.30)" in eta
        assert zeta is not None
        assert "half" in zeta.lower() or "eta/2" in zeta
