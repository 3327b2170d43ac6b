"""Floor 8: metals of the table in a study: those named, and what entries leave out."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from pydantic import ValidationInfo

from microslip._core.units import engineering
from microslip._core.wording import did_you_mean, quoted, shorten, show
from microslip.materials import Metal, metal_called, metals
from microslip.study.part import Reading

_KEYS = ("young_modulus", "poisson_ratio", "hardness")


def with_metals(given: dict[str, Any], info: ValidationInfo) -> dict[str, Any]:
    """Complete the materials of a study by the table of metals."""
    own = given.get("material", {})
    if not isinstance(own, dict):
        return given  # pydantic says so
    structure = given.get("structure")
    material = dict(own)
    named = [
        name
        for table in (
            given.get("surface"),
            structure.get("mesh") if isinstance(structure, dict) else None,
        )
        if isinstance(table, dict) and isinstance(table.get("materials"), (list, tuple))
        for name in table["materials"]
    ]
    for name in named:
        if isinstance(name, str) and metal_called(name) is not None:
            material.setdefault(name, {})
    notes: list[str] = []
    for name, entry in material.items():
        # Keys of a study in Python may be anything yet; pydantic says that they are texts.
        metal = metal_called(name) if isinstance(name, str) else None
        if metal and isinstance(entry, dict) and entry.get("rigid", False) is False:
            material[name] = _completed(entry, metal, notes, name)
    if isinstance(info.context, Reading):
        info.context.notes.extend(notes)
    return {**given, "material": material}


def _completed(entry: dict[str, Any], metal: Metal, notes: list[str], name: str) -> dict[str, Any]:
    """An entry with what it leaves to the table; the text says the very same double."""
    entry, taken = dict(entry), []
    for key in _KEYS:
        value = getattr(metal, key)
        if key not in entry and value is not None:
            plain = key == "poisson_ratio"
            entry[key] = value if plain else f"{value!r} Pa"
            shown = f"{value:g}" if plain else engineering(value, "Pa", 4, trim=True)
            taken.append(f"{key} {shown} ({metal.sources[key]})")
    if taken:
        called = "" if name == metal.name else f', as "{metal.name}"'
        notes.append(
            f"material.{name} is taken from the table of metals{called}: {'; '.join(taken)}."
        )
    return entry


def unknown(name: str, own: Iterable[str]) -> str:
    """What to say of a body that is neither a material of the study nor a metal of the table."""
    own = [other for other in own if metal_called(other) is None]
    table = 'a metal of the table (see "microslip materials")'
    if own:
        wanted = f"{quoted(own)}, the materials of this file, or {table}"
    else:
        wanted = f"{table} or one described by [material.{shorten(name, 40)}]"
    # A part of a name, such as "4340", may be too short to be like all of it.
    parts = [metal for metal in metals() if len(name) > 2 and name.casefold() in metal]
    hint = did_you_mean(name, [*own, *metals()]) or did_you_mean(parts[0] if parts else "", parts)
    return f"wanted {wanted}, got {show(name)}{hint}"
