"""Iwan's parallel model: any number of Jenkins' cells side by side."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, whole_number
from microslip._core.errors import InputError
from microslip._core.frozen import Locked, lock
from microslip._core.parameters import parameter
from microslip.friction.base import CellModel
from microslip.friction.guesses import cell_stiffnesses, yield_grid
from microslip.friction.sliders import Sliders


class _Cells(NamedTuple):
    """Cells in the order in which they yield, with what has slipped and what still sticks."""

    yields: Floats
    stiffnesses: Floats
    stuck: Floats  # stiffness of the cells from each on; after the last one 0
    slipped: Floats  # force of the cells before each; after the last one the limit
    forces: Floats  # backbone at each yield displacement
    energies: Floats  # of a cycle of that amplitude


class IwanFit(NamedTuple):
    """Accuracy of cells (Iwan 1966, DOI 10.1115/1.3625199) against a law over a range."""

    backbone_error: float
    """Largest relative error of the backbone, which lies nowhere below the law [-]."""
    energy_error: float
    """Largest relative error of the dissipated energy [-]."""
    error_at_smallest: float
    """Energy error at the smallest amplitude, where the first cells begin to yield [-]."""
    smallest_amplitude: float
    """Smallest amplitude looked at [m]."""
    largest_amplitude: float
    """Largest one [m]."""


@dataclass(frozen=True, eq=False)
class Iwan(Locked, CellModel):
    """Cells in parallel, each a spring with a Coulomb slider: Iwan's model (1966).

    Parameters
    ----------
    stiffnesses : array_like
        Stiffness of the spring of each cell [N/m], above zero, one-dimensional.
    force_limits : array_like
        Force at which the slider of each cell slips [N], above zero, as many.

    Notes
    -----
    T0(u) = sum of min(k_i u, f_i) (Iwan 1966, DOI 10.1115/1.3625199), a polygon with a corner at
    every yield displacement y_i = f_i/k_i; E_d(a) = 4 sum of f_i (a - y_i) over the cells that
    yield. Sorted once, a value costs O(log n), and every sum has terms of one sign only.
    """

    stiffnesses: ArrayLike = field(
        metadata=parameter("k_i", "N/m", "stiffness of each spring", above=0.0, many=True)
    )
    force_limits: ArrayLike = field(
        metadata=parameter("f_i", "N", "force at which each slider slips", above=0.0, many=True)
    )

    fit: ClassVar[IwanFit | None] = None
    """Error of the cells against the law that they were made from, over a range of amplitudes."""

    def __post_init__(self) -> None:
        self._check_parameters()
        cells = [np.size(values) for values in (self.stiffnesses, self.force_limits)]
        if cells[0] != cells[1]:
            raise InputError(
                "stiffnesses and force_limits must be of one length, one of each for a cell, "
                f"got {cells[0]} and {cells[1]}"
            )

    @property
    def cell_count(self) -> int:
        """Number of cells."""
        return np.asarray(self.stiffnesses).size

    @property
    def force_limit(self) -> float:
        """Force at which all cells slip [N]: the sum of their limits."""
        return float(self._cells.slipped[-1])

    @cached_property
    def _cells(self) -> _Cells:
        stiffnesses, limits = np.asarray(self.stiffnesses), np.asarray(self.force_limits)
        order = np.argsort(limits / stiffnesses, kind="stable")
        stiffnesses, limits = stiffnesses[order], limits[order]
        yields = limits / stiffnesses
        stuck = np.append(_running_sum(stiffnesses[::-1])[::-1], 0.0)
        slipped = np.append(0.0, _running_sum(limits))
        forces = np.maximum.accumulate(slipped[1:] + yields * stuck[1:])
        steps = np.append(0.0, 4.0 * slipped[1:-1] * np.diff(yields))
        return _Cells(yields, stiffnesses, stuck, slipped, forces, _running_sum(steps))

    def _backbone(self, u: Floats) -> Floats:
        cells = self._cells
        yielded = np.searchsorted(cells.yields, u, side="right")
        stretched = np.minimum(u, cells.yields[-1])
        force = cells.slipped[yielded] + stretched * cells.stuck[yielded]
        return np.asarray(np.minimum(force, self.force_limit))  # not a last place above it

    def _slope(self, u: Floats) -> Floats:
        yielded = np.searchsorted(self._cells.yields, u, side="right")
        return np.asarray(self._cells.stuck[yielded])

    def _inverse(self, force: Floats) -> Floats:
        cells = self._cells
        yielded = np.searchsorted(cells.forces[:-1], force, side="right")
        u = (force - cells.slipped[yielded]) / cells.stuck[yielded]
        # Between the corners, also where a difference of close forces rounds beyond them.
        low = np.where(yielded > 0, cells.yields[yielded - 1], 0.0)
        return np.asarray(np.clip(u, low, cells.yields[yielded]))

    def _energy(self, amplitude: Floats) -> Floats:
        cells = self._cells
        yielded = np.searchsorted(cells.yields, amplitude, side="right")
        last = np.maximum(yielded - 1, 0)
        past = np.maximum(amplitude - cells.yields[last], 0.0)
        return cells.energies[last] + 4.0 * cells.slipped[yielded] * past

    def _energy_slope(self, amplitude: Floats) -> Floats:
        cells = self._cells
        return 4.0 * cells.slipped[np.searchsorted(cells.yields, amplitude, side="right")]

    def sliders(self) -> Sliders:
        """The cells themselves, in the order in which they yield [m, N/m]."""
        return Sliders(lock(self._cells.yields.copy()), lock(self._cells.stiffnesses.copy()), None)

    def __repr__(self) -> str:
        return (
            f"Iwan({self.cell_count} {'cell' if self.cell_count == 1 else 'cells'}, "
            f"stiffness={self.tangential_stiffness:g}, force_limit={self.force_limit:g})"
        )

    @classmethod
    def guess(cls, data: Any, cells: int = 12) -> Iwan:
        """Cells to start a fit from: stiffnesses by least squares on a geometric grid of yields.

        There are ``cells`` to choose from, 1 to 1000; those without stiffness are left out. The
        rest is as of :meth:`BackboneLaw.guess`.
        """
        yields = yield_grid(data, whole_number("cells", cells, 1, 1000))
        stiffnesses = cell_stiffnesses(data, yields)
        real = stiffnesses > 1e-12 * stiffnesses.max()
        return cls(stiffnesses[real], stiffnesses[real] * yields[real])

    @classmethod
    def examples(cls) -> tuple[Iwan, ...]:
        """One cell, a few unlike ones with two that yield together, and very many."""
        unlike = cls([4e8, 1e7, 2e8, 5e7, 1e8], [10.0, 20.0, 30.0, 40.0, 15.0])
        shares = (np.arange(1000.0) + 0.5) / 1000.0
        dense = cls(np.full(1000, 1e6), 0.8 * shares)
        return cls([2e8], [150.0]), unlike, dense


def _running_sum(x: Floats) -> Floats:
    """Sums of the first 1, 2, 3 ... values by pairs: rounding grows with log n, not with n."""
    if x.size < 8:
        return np.cumsum(x)
    pairs = _running_sum(x[:-1:2] + x[1::2])
    result = np.empty_like(x)
    result[0] = x[0]
    result[1::2] = pairs
    result[2::2] = pairs[: (x.size - 1) // 2] + x[2::2]
    return result
