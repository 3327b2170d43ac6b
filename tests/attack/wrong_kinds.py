"""Every public callable with about a hundred wrong kinds of input, one argument at a time."""

from __future__ import annotations

import datetime
import decimal
import fractions
import itertools
import math
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import microslip as ms

from .campaign import Random, Tally, Wrong
from .entrances import Entrance, entrances


class Awkward:
    """An object whose conversions raise."""

    def __init__(self, *broken: str) -> None:
        self.broken = broken

    def __float__(self) -> float:
        raise RuntimeError("no float") if "float" in self.broken else TypeError("none")

    def __repr__(self) -> str:
        if "repr" in self.broken:
            raise RuntimeError("no repr")
        return "Awkward()"

    def __array__(self, *_: Any, **__: Any) -> Any:
        raise RuntimeError("no array") if "array" in self.broken else TypeError("none")

    def __len__(self) -> int:
        if "len" in self.broken:
            raise RuntimeError("no length")
        return 3

    def __iter__(self) -> Iterator[float]:
        if "iter" in self.broken:
            raise RuntimeError("no iteration")
        return iter((1e-7, 2e-7, 3e-7))


class Indexed:
    """A sequence without an end."""

    def __getitem__(self, index: int) -> float:
        return 1.0

    def __len__(self) -> int:
        return 2**62


# What no argument that is a number or an array of numbers can be. None is left out: it often
# stands for an argument that is not given.
NEVER: dict[str, Callable[[], Any]] = {
    "text": lambda: "1e-6",
    "text with unit": lambda: "1 um",
    "empty text": lambda: "",
    "bytes": lambda: b"1",
    "bytearray": lambda: bytearray(b"12"),
    "complex": lambda: 1j,
    "complex array": lambda: np.array([1j, 2.0]),
    "nan": lambda: math.nan,
    "inf": lambda: math.inf,
    "minus inf": lambda: -math.inf,
    "nan in an array": lambda: np.array([1e-7, math.nan, 1e-7]),
    "inf in a list": lambda: [1e-7, math.inf],
    "huge int": lambda: 10**400,
    "huge int in a list": lambda: [1, 10**400],
    "longdouble beyond double": lambda: np.longdouble("1e4000"),
    "longdoubles beyond double": lambda: np.array([1, "1e4000"], dtype=np.longdouble),
    "list of text": lambda: ["1", "2"],
    "list with None": lambda: [1e-7, None],
    "ragged": lambda: [[1.0], [1.0, 2.0]],
    "dict": lambda: {"a": 1.0},
    "set": lambda: {1.0, 2.0},
    "frozenset": lambda: frozenset({1.0}),
    "class": lambda: float,
    "function": lambda: math.sin,
    "module": lambda: math,
    "ellipsis": lambda: ...,
    "not implemented": lambda: NotImplemented,
    "slice": lambda: slice(3),
    "generator": lambda: (x for x in (1e-7, 2e-7)),
    "endless generator": lambda: itertools.count(),
    "map": lambda: map(float, (1, 2)),
    "zip": lambda: zip((1.0,), (2.0,), strict=True),
    "date": lambda: datetime.date(2020, 1, 1),
    "time": lambda: datetime.time(12),
    "timedelta": lambda: datetime.timedelta(1),
    "path": lambda: Path("1"),
    "exception": lambda: ValueError("1"),
    "object": object,
    "object array": lambda: np.array([1.0, "a"], dtype=object),
    "object array of floats": lambda: np.array([1.0, 2.0], dtype=object),
    "text array": lambda: np.array(["1", "2"]),
    "bytes array": lambda: np.array([b"1"]),
    "bool array": lambda: np.array([True, False]),
    "datetime array": lambda: np.array(["2020"], dtype="M8[D]"),
    "timedelta array": lambda: np.array([3], dtype="m8[s]"),
    "timedelta scalar": lambda: np.timedelta64(3, "s"),
    "structured array": lambda: np.zeros(2, dtype=[("a", float)]),
    "void": lambda: np.void(b"12345678"),
    "masked array": lambda: np.ma.masked_array([1e-7, 2e-7], mask=[True, False]),
    "masked": lambda: np.ma.masked,
    "empty list": list,
    "empty array": lambda: np.zeros(0),
    "empty deep array": lambda: np.zeros((0, 3)),
    "no float": lambda: Awkward("float"),
    "no repr": lambda: Awkward("repr", "float"),
    "no array": lambda: Awkward("array", "float"),
    "no length": lambda: Awkward("len", "array"),
    "no iteration": lambda: Awkward("iter", "array"),
    "nothing works": lambda: Awkward("float", "repr", "array", "len", "iter"),
    "without an end": Indexed,
    "deep list": lambda: deep(5000),
    "recursive list": lambda: recursive(),
    "memoryview": lambda: memoryview(b"abc"),
    "partial": lambda: partial(float, 1.0),
    "random generator": lambda: np.random.default_rng(0),
    "material": lambda: ms.Material(69e9, 0.33),
    "dtype": lambda: np.dtype(float),
    "surrogate text": lambda: "\udc80",
    "control characters": lambda: "\x00\x1b[31m\n",
    "long text": lambda: "9" * 100_000,
}

# What is a number after all, of a kind that few tests try.
SOMETIMES: dict[str, Callable[[], Any]] = {
    "bool": lambda: True,
    "numpy bool": lambda: np.True_,
    "float16": lambda: np.float16(1e-3),
    "float16 array": lambda: np.array([1e-3, 2e-3], dtype=np.float16),
    "float32 array": lambda: np.array([1e-7, 2e-7], dtype=np.float32),
    "longdouble": lambda: np.longdouble("1e-7"),
    "big-endian array": lambda: np.array([1e-7, 2e-7], dtype=">f8"),
    "strided array": lambda: np.linspace(0, 1e-6, 20)[::3],
    "reversed array": lambda: np.linspace(1e-7, 1e-6, 5)[::-1],
    "Fortran order": lambda: np.asfortranarray(np.full((2, 3), 1e-7)),
    "read-only array": lambda: np.broadcast_to(1e-7, (4,)),
    "uint8 array": lambda: np.array([1, 2], dtype=np.uint8),
    "int64 minimum": lambda: np.int64(-(2**63)),
    "uint64 maximum": lambda: np.uint64(2**64 - 1),
    "zero-dimensional": lambda: np.array(1e-7),
    "fraction": lambda: fractions.Fraction(1, 10**7),
    "decimal": lambda: decimal.Decimal("1e-7"),
    "range": lambda: range(1, 4),
    "tuple": lambda: (1e-7, 2e-7),
    "array of one": lambda: np.array([[1e-7]]),
    "zero": lambda: 0,
    "minus zero": lambda: -0.0,
    "minus one": lambda: -1.0,
    "denormal": lambda: 5e-324,
    "largest": lambda: 1.7976931348623157e308,
    "int beyond exact": lambda: 2**53 + 1,
    "none": lambda: None,
    "memory of floats": lambda: memoryview(np.array([1e-7, 2e-7])),
    "array subclass": lambda: np.array([1e-7, 2e-7]).view(np.recarray),
    "deep array": lambda: np.zeros((1,) * 32).tolist(),
    "matrix row": lambda: np.full((1, 3), 1e-7),
}

SLOW_ENTRANCES = ("BoltedBeam.reduce", "LapJoint.reduce", "MeshedJoint.reduce", "identify_modal",
                  "identify an interface", "Identification.interface")  # fmt: skip
"""Entrances that compute for about a second on each number that they take."""
FEW = ("numpy bool", "zero-dimensional", "decimal", "minus one", "largest", "float32 array")
"""Kinds of numbers that the slow entrances are given."""


TAKEN = {
    ("first", "material"),
    ("second", "material"),
    ("pixel", "text with unit"),
    ("cutoffs", "text with unit"),
    ("long_cutoffs", "text with unit"),
    ("seed", "huge int"),
    ("other_young_modulus", "inf"),  # what is rigid
    ("other_young_modulus", "inf in a list"),
    ("density", "object array of floats"),  # one of each part
    ("rig_stiffness", "inf"),  # a rigid rig
}
"""What an argument takes after all."""


def deep(depth: int) -> Any:
    """A list in a list in a list."""
    inner: list[Any] = [1.0]
    for _ in range(depth):
        inner = [inner]
    return inner


def recursive() -> Any:
    """A list that holds itself."""
    inner: list[Any] = [1.0]
    inner.append(inner)
    return inner


def attack_wrong_kinds(rng: Random, tally: Tally) -> None:
    """One entrance, one of its arguments, every kind."""
    doors = {name: door for name, door in entrances().items() if door.numeric}
    name = list(doors)[rng.integers(len(doors))]
    door = doors[name]
    attack_argument(name, door, door.numeric[rng.integers(len(door.numeric))], tally)


def attack_argument(name: str, door: Entrance, argument: str, tally: Tally) -> None:
    """One argument of one entrance, every kind; a few kinds of numbers where each takes long."""
    for kind, make in NEVER.items():
        given = door.arguments | {argument: make()}
        if (argument, kind) in TAKEN:
            continue
        tally.attempt(f"{name}({argument}={kind})", partial(_never, door.call, given))
    for kind, make in SOMETIMES.items():
        if name in SLOW_ENTRANCES and kind not in FEW:
            continue
        given = door.arguments | {argument: make()}
        tally.attempt(f"{name}({argument}={kind})", partial(_finite, door.call, given))


def _never(call: Callable[..., Any], given: dict[str, Any]) -> None:
    answer = call(**given)
    raise Wrong(f"accepted: {type(answer).__name__}")


def _finite(call: Callable[..., Any], given: dict[str, Any]) -> None:
    """If such a number is taken, the answer has no silent nonsense in it."""
    answer = call(**given)
    values = answer if isinstance(answer, (float, np.ndarray)) else None
    # At rest there is no exponent, and what is rigid has an infinite stiffness.
    if values is None or call.__name__ in (
        "dissipation_exponent",
        "secant_stiffness",
        "backbone_stiffness",
    ):
        return
    if not np.all(np.isfinite(values)):
        raise Wrong(f"answered {np.asarray(values).reshape(-1)[:4]}")
