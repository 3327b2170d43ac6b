"""Materials of a study completed from the table of metals."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from microslip._core.units import engineering
from microslip._core.wording import did_you_mean, quote, quoted, shorten
from microslip.contact.materials import Metal, metal_called, metals
from microslip.study.readers import KeyedError

_KEYS = ("young_modulus", "poisson_ratio", "hardness")


def with_metals(tables: dict[str, Any], notes: list[str]) -> dict[str, Any]:
    """Return raw tables in which materials named after a metal are completed from its data.

    The values taken from the table of metals are added to ``notes``.
    """
    entries = tables.get("material", {})
    if not isinstance(entries, dict):
        return tables  # the error is reported when the table is read
    structure = tables.get("structure")
    material = dict(entries)
    named = [
        name
        for table in (
            tables.get("surface"),
            structure.get("mesh") if isinstance(structure, dict) else None,
        )
        if isinstance(table, dict) and isinstance(table.get("materials"), (list, tuple))
        for name in table["materials"]
    ]
    for name in named:
        if isinstance(name, str) and metal_called(name) is not None:
            material.setdefault(name, {})
    for name, entry in material.items():
        # A study from Python may have keys of any type here; they are validated later.
        metal = metal_called(name) if isinstance(name, str) else None
        if metal and isinstance(entry, dict) and entry.get("rigid", False) is False:
            material[name] = _completed(entry, metal, notes, name)
    return {**tables, "material": material}


def _completed(entry: dict[str, Any], metal: Metal, notes: list[str], name: str) -> dict[str, Any]:
    entry, additions = dict(entry), []
    for key in _KEYS:
        value = getattr(metal, key)
        if key not in entry and value is not None:
            plain = key == "poisson_ratio"
            entry[key] = value if plain else f"{value!r} Pa"
            text = f"{value:g}" if plain else engineering(value, "Pa", 4, trim=True)
            additions.append(f"{key} {text} ({metal.sources[key]})")
    if additions:
        called = "" if name == metal.name else f', as "{metal.name}"'
        notes.append(
            f"material.{name} is taken from the table of metals{called}: {'; '.join(additions)}."
        )
    return entry


def check_described(key: str, names: Iterable[str], materials: Iterable[str]) -> None:
    """Raise an error for materials defined neither in the study nor in the table of metals."""
    for item, name in enumerate(names, start=1):
        if name not in materials:
            raise KeyedError(f"{key}, item {item}", _unknown(name, materials))


def _unknown(name: str, described: Iterable[str]) -> str:
    described = [candidate for candidate in described if metal_called(candidate) is None]
    table = 'a metal of the table (see "microslip materials")'
    if described:
        choices = f"{quoted(described)}, the materials of this file, or {table}"
    else:
        choices = f"{table} or one described by [material.{shorten(name, 40)}]"
    # Part of a name, such as "4340", may be too short for a similarity match.
    parts = [metal for metal in metals() if len(name) > 2 and name.casefold() in metal]
    hint = did_you_mean(name, [*described, *metals()]) or did_you_mean(
        parts[0] if parts else "", parts
    )
    return f"wanted {choices}, got {quote(name)}{hint}"
