"""Arrays of a file by name, in a tree of structs or groups, as in MAT, HDF5 and NumPy files."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from microslip._core.checks import Floats
from microslip._core.errors import InputError
from microslip._core.wording import shorten
from microslip.readers.files import first_line
from microslip.readers.tables import RawColumn, RawTable, Stated, refuse_long

MOST_COLUMNS = 64
"""Largest number of columns of a matrix; wider matrices are images, not records."""

_RATES = {"fs", "samplerate", "samplingrate", "samplefrequency", "samplingfrequency"}
_STEPS = {"dt", "samplinginterval", "sampleinterval", "timestep"}
_UNITS = ("unit", "units")
_LABELS = ("label", "name")


class Leaf(NamedTuple):
    """Array of a file: its shape, and a function that loads the numbers."""

    shape: tuple[int, ...]
    get: Callable[[], Any]
    unit: str | None = None
    rate: float | None = None


class Arrays(NamedTuple):
    """Content of a file with named arrays."""

    kind: str
    """Kind of the file, such as "MAT-file"."""
    tree: Mapping[str, Any]
    """Leaves, numbers and texts by name, in nested mappings and sequences."""
    join: str
    """Separator between the names on the path to a leaf."""
    advice: str = ""
    """Advice on how to save a file without usable arrays, appended to the message."""


class _Slot(NamedTuple):
    """Location of a column: an array and, in a matrix, its index ``place`` (None in a vector)."""

    column: RawColumn
    leaf: Leaf
    place: int | None


def arrays_in(node: Any) -> Any:
    """Convert the content from a child process: arrays become leaves, numbers and texts stay."""
    if isinstance(node, dict):
        return {str(key): arrays_in(item) for key, item in node.items()}
    if isinstance(node, list):
        return [arrays_in(item) for item in node]
    if isinstance(node, np.ndarray):
        if node.dtype.kind not in "iuf":
            return None
        return node.item() if node.size == 1 else Leaf(node.shape, lambda: node)
    return node if isinstance(node, str) or is_numeric(node) else None


def leaves(arrays: Arrays) -> dict[str, Leaf]:
    """Return all arrays of a file by full name, which joins the names of groups and array."""
    by_name: dict[str, Leaf] = {}

    def walk(name: str, node: Any) -> None:
        if isinstance(node, Leaf):
            by_name[name] = node
        elif isinstance(node, Mapping):
            for key, value in node.items():
                walk(f"{name}{arrays.join}{key}" if name else key, value)
        elif isinstance(node, Sequence) and not isinstance(node, (str, bytes)):
            for i, value in enumerate(node, start=1):
                walk(f"{name}({i})", value)

    walk("", arrays.tree)
    return by_name


def single_array(arrays: Mapping[str, Leaf], channel: str | int | None, kind: str) -> str:
    """Return the name of the array with the heights: the requested one, or the only suitable one.

    Suitable are matrices; vectors only if there is no matrix. ``kind`` names the kind of file in
    messages.
    """
    listed = ", ".join(
        f'"{shorten(name, 40)}" ({" x ".join(map(str, leaf.shape)) or "one number"})'
        for name, leaf in list(arrays.items())[:12]
    )
    if len(arrays) > 12:
        listed += f" and {len(arrays) - 12} more"
    if channel is not None:
        if channel not in arrays:
            raise ValueError(
                f"this {kind} has no array {shorten(repr(channel), 40)}; it has {listed or 'none'}"
            )
        return str(channel)
    able = [name for name, leaf in arrays.items() if len(leaf.shape) == 2 and min(leaf.shape) > 1]
    # A vector can be a profile or no heights at all; it is accepted only if it is the only array.
    able = able or [name for name, leaf in arrays.items() if max(leaf.shape, default=0) > 3]
    if not able:
        raise ValueError(f"wanted a matrix of heights, got a {kind} with {listed or 'no numbers'}")
    if len(able) > 1:
        raise InputError(f"this {kind} holds more than one array: {listed}; write `channel=...`")
    return able[0]


def values_of_leaf(name: str, leaf: Leaf) -> Any:
    """Load the numbers of an array."""
    try:
        return np.asarray(leaf.get())
    except OSError as error:
        raise ValueError(f'"{name}" is damaged: {first_line(error)}') from None


def array_table(arrays: Arrays) -> RawTable:
    """Return the columns of a file: vectors by name, columns of matrices as "name#1", "name#2".

    A text called `unit` in the same group as numbers is their unit; a text called `name` or `label`
    in the same group as a single vector is its name.
    """
    slots: list[_Slot] = []
    rates: list[Stated] = []
    _walk("", "", arrays.tree, arrays.join, slots, rates)
    if not slots:
        advice = f"; {arrays.advice}" if arrays.advice else ""
        raise ValueError(f"wanted arrays of numbers, got none in this {arrays.kind}{advice}")
    kind, stated = arrays.kind, {}
    if rates:
        stated["sample_rate"] = rates[0]
        second_rate = next((r for r in rates if not math.isclose(r.value, rates[0].value)), None)
        if second_rate:
            del stated["sample_rate"]
            kind += (
                f'; two sample rates, {rates[0].value:g} Hz by "{rates[0].where}" and '
                f'{second_rate.value:g} Hz by "{second_rate.where}", so neither is used'
            )

    def load(places: Sequence[int]) -> list[Floats]:
        columns = []
        refuse_long(slots[place].column for place in places)
        for place in places:
            slot = slots[place]
            matrix = np.squeeze(values_of_leaf(slot.column.heading, slot.leaf))
            if slot.place is not None:
                long = matrix.shape[0] >= matrix.shape[1]
                matrix = matrix[:, slot.place] if long else matrix[slot.place]
            columns.append(np.array(matrix, dtype=float))
        return columns

    return RawTable(kind, tuple(slot.column for slot in slots), load, stated=stated)


def is_numeric(value: Any) -> bool:
    """Return whether a value is a real number; False for a Boolean."""
    return isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)


def rate_by(name: str, value: Any) -> Stated | None:
    """Return the sampling rate [Hz] if the name is that of a rate or time step, else None."""
    plain = re.sub(r"[\W_]", "", name.rpartition("/")[2].rpartition(".")[2]).casefold()
    if not is_numeric(value) or not 0.0 < float(value) < math.inf:
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
    elif rate := rate_by(name, node):
        rates.append(rate)


def _text(node: Mapping[str, Any], keys: Sequence[str]) -> str | None:
    texts = {key.casefold(): value for key, value in node.items() if isinstance(value, str)}
    return next((texts[key].strip() or None for key in keys if key in texts), None)


def _slots(name: str, short: str, leaf: Leaf) -> Iterator[_Slot]:
    shape = [n for n in leaf.shape if n != 1]
    if len(shape) == 1 and shape[0] > 1:
        yield _Slot(RawColumn(name, leaf.unit, shape[0], leaf.rate, short), leaf, None)
    elif len(shape) == 2 and 1 < min(shape) <= MOST_COLUMNS:
        for j in range(min(shape)):
            end = f"#{j + 1}"
            column = RawColumn(name + end, leaf.unit, max(shape), leaf.rate, short + end)
            yield _Slot(column, leaf, j)
