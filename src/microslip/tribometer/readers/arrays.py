"""Named arrays in a tree (structs, groups) as columns: what MAT and HDF5 files have in common."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip.tribometer.readers.base import MAX_SAMPLES, Column, Stated, Table, first_line

MOST_COLUMNS = 64
"""Columns that one matrix may have; a wider one is a picture, not a record."""

_RATES = {"fs", "samplerate", "samplingrate", "samplefrequency", "samplingfrequency"}
_STEPS = {"dt", "samplinginterval", "sampleinterval", "timestep"}
_UNITS = ("unit", "units")
_LABELS = ("label", "name")


class Leaf(NamedTuple):
    """Numbers in the tree, not read yet."""

    shape: tuple[int, ...]
    get: Callable[[], Any]
    unit: str | None = None
    rate: float | None = None


class _Slot(NamedTuple):
    """One column of a leaf; of a vector the only one."""

    column: Column
    leaf: Leaf
    place: int | None


def table(kind: str, tree: Mapping[str, Any], join: str) -> Table:
    """Columns of a tree of mappings, sequences, leaves, numbers and texts.

    Parameters
    ----------
    kind : str
        What the file is.
    tree : mapping
        What is in it. A text `unit` beside numbers is their unit, a text `name` or `label` beside
        one vector is its name.
    join : str
        What stands between names on the way to a leaf.

    Returns
    -------
    Table
        Vectors by their names, columns of matrices as "name#1", "name#2".

    Raises
    ------
    ValueError
        If there is no vector and no matrix, or two sample rates.
    """
    slots: list[_Slot] = []
    rates: list[Stated] = []
    _walk("", "", tree, join, slots, rates)
    if not slots:
        raise ValueError(f"wanted arrays of numbers, got none in this {kind}")
    stated = {}
    if rates:
        stated["sample_rate"] = rates[0]
        other = next((r for r in rates if not math.isclose(r.value, rates[0].value)), None)
        if other:
            del stated["sample_rate"]
            kind += (
                f'; two sample rates, {rates[0].value:g} Hz by "{rates[0].where}" and '
                f'{other.value:g} Hz by "{other.where}", so neither is taken'
            )

    def load(places: Sequence[int]) -> list[Floats]:
        found = []
        for place in places:
            slot = slots[place]
            if (slot.column.size or 0) > MAX_SAMPLES:
                raise ValueError(
                    f'"{slot.column.name}": wanted at most {MAX_SAMPLES} samples, '
                    f"got {slot.column.size}"
                )
            try:
                whole = np.squeeze(np.asarray(slot.leaf.get()))
            except OSError as error:
                raise ValueError(f'"{slot.column.name}" is damaged: {first_line(error)}') from None
            if slot.place is not None:
                long = whole.shape[0] >= whole.shape[1]
                whole = whole[:, slot.place] if long else whole[slot.place]
            found.append(np.array(whole, dtype=float))
        return found

    return Table(kind, tuple(slot.column for slot in slots), load, stated=stated)


def is_number(value: Any) -> bool:
    """Whether something is one real number."""
    return isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)


def rate_by(name: str, value: Any) -> Stated | None:
    """Sample rate that a number of this name states, if it is one."""
    plain = re.sub(r"[\W_]", "", name.rpartition("/")[2].rpartition(".")[2]).casefold()
    if not is_number(value) or not 0.0 < float(value) < math.inf:
        return None
    if plain in _RATES:
        return Stated(float(value), name)
    return Stated(1.0 / float(value), name) if plain in _STEPS else None


def _walk(
    name: str, short: str, node: Any, join: str, slots: list[_Slot], rates: list[Stated]
) -> None:
    if isinstance(node, Leaf):
        slots.extend(_slots(name, short, node))
    elif isinstance(node, Mapping):
        unit, label = _text(node, _UNITS), _text(node, _LABELS)
        vectors = [k for k, v in node.items() if isinstance(v, Leaf) and any(_slots(k, k, v))]
        for key, value in node.items():
            last = key
            if isinstance(value, Leaf):
                last = label if label and vectors == [key] else key
                value = value._replace(unit=value.unit or unit)
            _walk(f"{name}{join}{last}" if name else last, last, value, join, slots, rates)
    elif isinstance(node, Sequence) and not isinstance(node, (str, bytes)):
        for i, value in enumerate(node, start=1):
            _walk(f"{name}({i})", f"{short}({i})", value, join, slots, rates)
    elif found := rate_by(name, node):
        rates.append(found)


def _text(node: Mapping[str, Any], keys: Sequence[str]) -> str | None:
    """The text under one of these keys."""
    found = {key.casefold(): value for key, value in node.items() if isinstance(value, str)}
    return next((found[key].strip() or None for key in keys if key in found), None)


def _slots(name: str, short: str, leaf: Leaf) -> Iterator[_Slot]:
    """Columns of an array: samples run along its longer side."""
    shape = [n for n in leaf.shape if n != 1]
    if len(shape) == 1 and shape[0] > 1:
        yield _Slot(Column(name, leaf.unit, shape[0], leaf.rate, short), leaf, None)
    elif len(shape) == 2 and 1 < min(shape) <= MOST_COLUMNS:
        for j in range(min(shape)):
            end = f"#{j + 1}"
            column = Column(name + end, leaf.unit, max(shape), leaf.rate, short + end)
            yield _Slot(column, leaf, j)
