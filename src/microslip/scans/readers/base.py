"""What every reader of scans gives, and what it may be told."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from microslip._core.wording import shorten


@dataclass(frozen=True)
class Wishes:
    """What the user states of a file; None where nothing."""

    format: Any = None
    unit: Any = None
    pixel: Any = None
    key: Any = None
    channel: Any = None
    valid: Any = None
    limit: Any = None


@dataclass(frozen=True)
class Raw:
    """Heights as they are in a file.

    Parameters
    ----------
    kind : str
        What the file is and how it was understood, for the notes.
    heights : ndarray
        In whatever unit; missing points are NaN or masked.
    unit : str, optional
        Unit of the heights, as the file says; None if it does not.
    pixel : tuple of float, optional
        Distance of neighbours [m], as the file says.
    steps : tuple of float, optional
        The same in the unit of coordinates, which `columns` or the user has to say.
    columns : pair of str or None
        Units of the coordinates and of the heights, as the names of columns say.
    notes : tuple of str
        What else is to be told.
    """

    kind: str
    heights: np.ndarray
    unit: str | None = None
    pixel: tuple[float, ...] | None = None
    steps: tuple[float, ...] | None = None
    columns: tuple[str | None, str | None] = (None, None)
    notes: tuple[str, ...] = field(default=())


class Reader(ABC):
    """One kind of file."""

    names: ClassVar[tuple[str, ...]]
    """What ``format=`` calls it, and ways to take it."""

    takes: ClassVar[tuple[str, ...]] = ()
    """Which of key and channel it understands."""

    @abstractmethod
    def knows(self, head: bytes, suffix: str) -> bool:
        """Whether a file that begins and is called so is of this kind."""

    @abstractmethod
    def read(self, path: Path, wishes: Wishes) -> Raw:
        """The heights of a file.

        Raises
        ------
        ValueError
            If it cannot be used; the message says what is wrong, and not the file.
        """


def first_line(error: BaseException) -> str:
    """What a library says, on one line."""
    lines = str(error).strip().splitlines()
    return shorten(lines[0], 160) if lines else type(error).__name__


def few(shape: tuple[int, ...], limit: int) -> None:
    """Refuse more points than were allowed, before they are read.

    Raises
    ------
    ValueError
        If there are more.
    """
    if (count := math.prod(shape)) > limit:
        size = " x ".join(str(n) for n in shape)
        raise ValueError(
            f"holds {size} = {count} points, more than limit={limit}; give a higher limit if "
            f"there is memory for it ({count * 8e-9:.3g} GB and a few times that)"
        )


def one_of(arrays: dict[str, tuple[int, ...]], wishes: Wishes, what: str) -> str:
    """The array that is meant, by its key, or because no other could be.

    Raises
    ------
    ValueError
        If there is no such array, none at all or more than one.
    """
    listed = ", ".join(
        f'"{shorten(name, 40)}" ({" x ".join(map(str, shape)) or "one number"})'
        for name, shape in list(arrays.items())[:12]
    )
    if len(arrays) > 12:
        listed += f" and {len(arrays) - 12} more"
    if wishes.key is not None:
        if wishes.key not in arrays:
            raise ValueError(
                f"{what} has no array {shorten(repr(wishes.key), 40)}; it has {listed or 'none'}"
            )
        return str(wishes.key)
    able = [name for name, shape in arrays.items() if len(shape) == 2 and min(shape) > 1]
    # A vector can be a profile, or no heights at all; only alone there is no doubt.
    able = able or [name for name, shape in arrays.items() if max(shape, default=0) > 3]
    if not able:
        raise ValueError(f"wanted a matrix of heights, got {what} with {listed or 'no numbers'}")
    if len(able) > 1:
        raise ValueError(f"{what} holds more than one array: {listed}; write key=")
    return able[0]
