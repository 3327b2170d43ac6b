"""What a state has dissipated while its load varied, worked out when it is asked for."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from microslip._core.checks import Floats
from microslip.memory.diagram import Diagram

_MAX_PENDING = 1024  # steps, before their losses are worked out together


class Losing(Protocol):
    """What a ledger asks of an interface."""

    def losses(self, separation: Floats, displacement: Floats, diagram: Diagram) -> Floats:
        """Energies [J] of the steps of a record that goes on from a diagram."""


class Ledger:
    """Energy dissipated up to a diagram [J], and the steps since: bounded, however long they are.

    The losses of many steps at once cost far less than one by one.
    """

    __slots__ = ("_begin", "_displacements", "_pending", "_separations", "total")

    def __init__(self, diagram: Diagram, total: float) -> None:
        self.total = total
        self._begin = diagram.copy()
        self._separations: list[Floats] = []
        self._displacements: list[Floats] = []
        self._pending = 0

    def copy(self) -> Ledger:
        """An independent ledger with the same content."""
        ledger = Ledger(self._begin, self.total)
        ledger._separations, ledger._displacements = self._separations[:], self._displacements[:]
        ledger._pending = self._pending
        return ledger

    def note(
        self, separation: Floats, displacement: Floats, diagram: Diagram, surface: Losing
    ) -> None:
        """Add steps, the last of which led to ``diagram``."""
        self._separations.append(separation)
        self._displacements.append(displacement)
        self._pending += separation.size
        # Rows that are gone are not to be kept for long.
        if self._pending >= _MAX_PENDING or self._begin.depth > 64 + 8 * diagram.depth:
            self.settle(diagram, surface)

    def settle(self, diagram: Diagram, surface: Losing) -> float:
        """Energy dissipated up to now, at ``diagram``."""
        if self._pending:
            d, x = np.concatenate(self._separations), np.concatenate(self._displacements)
            self.total += float(surface.losses(d, x, self._begin).sum())
            self._begin = diagram.copy()
            self._separations, self._displacements, self._pending = [], [], 0
        return self.total
