"""Memory of a record: open reversals and the last sample.

Masing's rule with factor two, wiping-out and return to the first loading curve (Madelung's rules;
Jaeger 1998, Ciavarella 1998 for the contact) determine from the displacements alone on which branch
a sample is and how far from its reversal. The backbone is then evaluated at all distances at once.

In the chapter (DOI 10.1007/978-3-319-56818-8_19) the branches are first loading (19.19), unloading
(19.20), reloading (19.21) with its offset (19.22), and unloading (19.23) with its offset (19.24).
Here each branch starts from the force at its reversal, whatever its sign.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from microslip._core import kernels
from microslip._core.checks import Floats
from microslip._core.kernels import Integers
from microslip._core.kernels.table import PolynomialTable

CurveFunction = Callable[[Floats], Floats]


class Tree(NamedTuple):
    """Branches of a record: sample i has the value sign[i] B(half[i]) + value of sample parent[i].

    B is the backbone. On first loading (19.19) ``half`` is the distance from rest and ``sign`` is 1
    or -1. On later branches (19.20), (19.21), (19.23) ``half`` is half the distance from the
    reversal ``parent`` and ``sign`` is 2 or -2.

    ``parent`` is the index of a sample, -1 for rest, or -2 - k for entry k of the initial memory,
    whose last entry is the last displacement before the record.
    """

    half: Floats
    sign: Floats
    parent: Integers


class Memory:
    """Memory of a record: displacements and values of open reversals, and the last sample.

    Values are forces; for a record of forces the values are displacements. Reversals are stored
    oldest first. The memory grows only with their number.
    """

    __slots__ = ("depth", "direction", "last", "stack", "value")

    def __init__(self) -> None:
        self.stack = np.empty((8, 2))
        self.depth = 0
        self.last = 0.0
        self.value = 0.0
        self.direction = 0

    def copy(self) -> Memory:
        """Return an independent copy."""
        memory = Memory()
        memory.stack = self.stack.copy()
        memory.depth, memory.direction = self.depth, self.direction
        memory.last, memory.value = self.last, self.value
        return memory

    __copy__ = copy

    def _reserve(self, extra: int) -> Floats:
        if self.stack.shape[0] >= self.depth + extra:
            return self.stack
        # Doubling gives amortised constant cost for chunks of one sample.
        stack = np.empty((max(self.depth + extra, 2 * self.depth), 2))
        stack[: self.depth] = self.stack[: self.depth]
        return stack

    def _store(self, stack: Floats, depth: int) -> None:
        if stack.shape[0] > 4 * depth + 64:
            stack = stack[: 2 * depth + 8].copy()
        self.stack, self.depth = stack, depth

    def respond(self, x: Floats, backbone: CurveFunction, table: PolynomialTable | None) -> Floats:
        """Return the values at displacements ``x``, one-dimensional, and update the memory.

        A table of the ``backbone`` lets the kernel compute them in one pass.
        """
        if table is not None:
            values, stack = np.empty(x.size), self._reserve(x.size + 1)
            with np.errstate(over="ignore"):  # overflowing distances are in gross slip
                depth, self.last, self.value, self.direction = kernels.compiled.respond(
                    x, values, stack, self.depth, self.last, self.value, self.direction,
                    *table.arguments,
                )  # fmt: skip
            self._store(stack, depth)
            return values
        base = np.append(self.stack[: self.depth, 1], self.value)
        with np.errstate(over="ignore"):
            tree, places, codes, last, direction = self._branches(x)
            values = backbone(tree.half) * tree.sign
        kernels.compiled.accumulate(tree.parent, values, base)
        old = np.where(codes < 0, -2 - codes, 0)
        new = np.where(codes >= 0, values[np.maximum(codes, 0)], base[old])
        self._store(np.column_stack((places, new)), places.size)
        self.last, self.value, self.direction = last, float(values[-1]), direction
        return values

    def _branches(self, x: Floats) -> tuple[Tree, Floats, Integers, float, int]:
        room = self.depth + x.size + 1
        places, codes = np.empty(room), np.empty(room, dtype=np.int64)
        places[: self.depth] = self.stack[: self.depth, 0]
        codes[: self.depth] = -2 - np.arange(self.depth)
        tree = Tree(np.empty(x.size), np.empty(x.size), np.empty(x.size, dtype=np.int64))
        depth, last, direction = kernels.compiled.branches(
            x, *tree, places, codes, self.depth, self.last, self.direction
        )
        return tree, places[:depth], codes[:depth], last, direction

    def tree(self, x: Floats) -> Tree:
        """Return the branches of a record that continues the memory, which is not updated."""
        return self._branches(x)[0]

    def closed(self, x: Floats, first: int = 0) -> Floats:
        """Return the amplitudes [m] of the loops that a record closes; the memory is not updated.

        They are half the widths of loops. A return to first loading past the only open reversal
        closes half a loop; it is marked by a negative amplitude: minus the distance of that
        reversal from rest. The ``first`` oldest reversals are ignored; if ``first`` is not 0, at
        least two others must remain open.
        """
        depth = self.depth - first
        places, result = (np.empty(depth + x.size + 1) for _ in range(2))
        places[:depth] = self.stack[first : self.depth, 0]
        count = kernels.compiled.closings(x, result, places, depth, self.last, self.direction)
        return result[:count]

    def probe(self, x: float) -> tuple[float, float, float, tuple[int, int, int]]:
        """Return the outcome of a move to displacement ``x``; the memory is not updated.

        The outcome is ``half`` and ``sign`` as in :class:`Tree`, the value at the start of the
        branch, and the argument ``move`` of :meth:`move`.
        """
        move: tuple[int, int, int] = kernels.compiled.locate(
            x, self.stack, self.depth, self.last, self.direction
        )
        depth, pushed, direction = move
        if depth == 0:
            return abs(x), -1.0 if x < 0.0 else 1.0, 0.0, move
        if pushed:
            place, start = self.last, self.value
        else:
            place, start = float(self.stack[depth - 1, 0]), float(self.stack[depth - 1, 1])
        return 0.5 * abs(x - place), 2.0 if direction > 0 else -2.0, start, move

    def move(self, x: float, value: float, move: tuple[int, int, int]) -> None:
        """Update the memory by a move to ``x``, where the force is ``value``; see :meth:`probe`."""
        depth, pushed, direction = move
        if pushed:
            self.stack = self._reserve(1)
            self.stack[depth - 1] = self.last, self.value
        self._store(self.stack, depth)
        self.last, self.value, self.direction = x, value, direction
