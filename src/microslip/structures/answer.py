"""Outcome and reading of the motions of a structure, common to all of them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats
from microslip._core.frozen import LockedArrays
from microslip.structures.matrices import vector


class Answer(LockedArrays):
    """A motion that a solver followed as far as it could."""

    message: str

    @property
    def status(self) -> str:
        """``solved``, or ``stopped`` before the end."""
        return "solved" if self.message.startswith("solved") else "stopped"

    def _sizes(self, columns: Floats) -> Floats:
        """Sizes of displacements along columns (n, k), (..., k) [m]."""
        raise NotImplementedError


class ModalAnswer(Answer):
    """A motion in modal coordinates, on a base that may move."""

    _shapes: Floats
    _carried: Floats

    def _at(self, sensor: ArrayLike) -> Floats:
        """Direction of a sensor in modal coordinates (modes,)."""
        return np.asarray(self._shapes.T @ vector("at", sensor, self._shapes.shape[0]))

    def _carried_at(self, sensor: ArrayLike) -> Any:
        """Motion at the sensor by a unit of the base, or of each of its inputs [-]."""
        return vector("at", sensor, self._shapes.shape[0]) @ self._carried
