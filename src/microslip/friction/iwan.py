"""Parallel Iwan model: any number of Jenkins cells with a common displacement."""

from __future__ import annotations

from abc import abstractmethod
from bisect import bisect_right
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats
from microslip._core.errors import InputError
from microslip._core.frozen import Locked, lock
from microslip._core.parameters import parameter
from microslip.friction.base import BackboneLaw
from microslip.friction.sliders import Sliders


class _Cells(NamedTuple):
    yields: Floats
    stiffnesses: Floats
    stuck: Floats  # stiffness [N/m] of each cell and all later ones, with a final 0
    slipped: Floats  # force [N] of all earlier cells, with the force limit as the last entry
    forces: Floats  # backbone at each yield displacement
    energies: Floats  # energy [J] of a cycle with that amplitude


class IwanFit(NamedTuple):
    """Errors of an Iwan model (DOI 10.1115/1.3625199) fitted to a law, over its amplitudes."""

    backbone_error: float
    """Largest relative error of the backbone [-]; the backbone of the model is nowhere below
    that of the law."""
    energy_error: float
    """Largest relative error of the dissipated energy [-]."""
    smallest_amplitude: float
    """Lower end of the range [m]."""
    largest_amplitude: float
    """Upper end of the range [m]."""


class CellLaw(Locked, BackboneLaw):
    """Law of parallel springs, each in series with a slider."""

    @property
    @abstractmethod
    def _parts(self) -> tuple[Floats, Floats]:
        """Stiffnesses [N/m] and force limits [N] of the cells."""

    @property
    def force_limit(self) -> float:
        """Force at which all cells slip [N]: the sum of their limits."""
        return float(self._cells.slipped[-1])

    @cached_property
    def _cells(self) -> _Cells:
        stiffnesses, limits = self._parts
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
        return np.asarray(np.minimum(force, self.force_limit))  # remove rounding above the limit

    def _slope(self, u: Floats) -> Floats:
        return np.asarray(self._cells.stuck[np.searchsorted(self._cells.yields, u, side="right")])

    @cached_property
    def _lists(self) -> tuple[list[float], list[float], list[float]]:
        return tuple(values.tolist() for values in self._cells[:1] + self._cells[2:4])

    def _backbone_at(self, u: float) -> tuple[float, float]:
        yields, stuck, slipped = self._lists
        yielded = bisect_right(yields, u)
        if yielded == len(yields):
            return slipped[-1], 0.0
        force = slipped[yielded] + u * stuck[yielded]
        return min(force, slipped[-1]), stuck[yielded]

    def _inverse(self, force: Floats) -> Floats:
        cells = self._cells
        yielded = np.searchsorted(cells.forces[:-1], force, side="right")
        u = (force - cells.slipped[yielded]) / cells.stuck[yielded]
        # A small difference of forces may round to a displacement outside its segment.
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
        """Return the cells in order of yield displacement [m], with stiffnesses [N/m]."""
        return Sliders(lock(self._cells.yields.copy()), lock(self._cells.stiffnesses.copy()), None)


@dataclass(frozen=True, eq=False)
class Iwan(CellLaw):
    """Cells in parallel, each a spring with a Coulomb slider: Iwan's model (1966).

    Parameters
    ----------
    stiffnesses : array_like
        Stiffness of the spring of each cell [N/m], above zero, one-dimensional.
    force_limits : array_like
        Force at which the slider of each cell slips [N], above zero, one for each stiffness.

    Notes
    -----
    T0(u) = sum of min(k_i u, f_i) (Iwan 1966, DOI 10.1115/1.3625199), a polygon with a corner at
    every yield displacement y_i = f_i/k_i, and E_d(a) = 4 sum of f_i (a - y_i) over the cells with
    y_i < a. Cells are sorted once, so a value costs O(log cells). No digits cancel in the sums,
    since all terms have one sign.
    """

    stiffnesses: ArrayLike = field(
        metadata=parameter("k_i", "N/m", "stiffness of each spring", above=0.0, many=True)
    )
    force_limits: ArrayLike = field(
        metadata=parameter("f_i", "N", "force at which each slider slips", above=0.0, many=True)
    )

    fit: ClassVar[IwanFit | None] = None
    """Errors with respect to the law that the cells were converted from, if a range was given."""

    def __post_init__(self) -> None:
        self._check_parameters()
        cells = [np.size(values) for values in (self.stiffnesses, self.force_limits)]
        if cells[0] != cells[1]:
            raise InputError(
                "`stiffnesses` and `force_limits` must have the same length, got "
                f"{cells[0]} and {cells[1]}"
            )

    @property
    def cell_count(self) -> int:
        """Number of cells."""
        return np.asarray(self.stiffnesses).size

    @property
    def _parts(self) -> tuple[Floats, Floats]:
        return np.asarray(self.stiffnesses), np.asarray(self.force_limits)

    def __repr__(self) -> str:
        return (
            f"Iwan({self.cell_count} {'cell' if self.cell_count == 1 else 'cells'}, "
            f"stiffness={self.tangential_stiffness:g}, force_limit={self.force_limit:g})"
        )

    @classmethod
    def examples(cls) -> tuple[Iwan, ...]:
        """Return models of one cell, of five cells, and of a thousand cells."""
        unlike = cls([4e8, 1e7, 2e8, 5e7, 1e8], [10.0, 20.0, 30.0, 40.0, 15.0])
        shares = (np.arange(1000.0) + 0.5) / 1000.0
        dense = cls(np.full(1000, 1e6), 0.8 * shares)
        return cls([2e8], [150.0]), unlike, dense


def _running_sum(x: Floats) -> Floats:
    """Return cumulative sums by pairwise addition: the error grows with log(size) only."""
    if x.size < 8:
        return np.cumsum(x)
    pairs = _running_sum(x[:-1:2] + x[1::2])
    result = np.empty_like(x)
    result[0] = x[0]
    result[1::2] = pairs
    result[2::2] = pairs[: (x.size - 1) // 2] + x[2::2]
    return result
