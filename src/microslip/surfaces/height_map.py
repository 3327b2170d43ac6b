"""Heights on a regular grid, with quantities computed once, their noise among them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core.checks import Floats, positive, show
from microslip._core.errors import InputError
from microslip._core.frozen import Locked, assign
from microslip._core.units import engineering
from microslip.figures.plot import Plot
from microslip.figures.plottable import Plottable
from microslip.surfaces.checks import enough, height_array, length_of, objection, pixel_of
from microslip.surfaces.filters import weights
from microslip.surfaces.moments import Moments, Statistics, moments_of, statistics_of

_BLOCK = 1 << 20  # points a pass


def noise_std(heights: Floats, step: int = 1) -> float:
    """Standard deviation of the noise that differs from point to point, from fourth differences.

    Second differences along x of second differences along y leave nothing of a form whose height
    is a sum of a cubic in x, one in y and xy; white noise they make six times as high. Their
    median size is taken, which single spikes and scratches do not move. Differences are over
    ``step`` points: of noise they are all alike.
    """
    if min(heights.shape) < 2 * step + 1:
        return 0.0
    # Whole rows in even steps: a million points are enough for a median.
    middle = np.arange(step, heights.shape[0] - step, max(1, heights.size // _BLOCK))
    across = heights[middle - step] - 2.0 * heights[middle] + heights[middle + step]
    bends = np.abs(across[:, 2 * step :] - 2.0 * across[:, step:-step] + across[:, : -2 * step])
    bends = bends[~np.isnan(bends)]
    return float(np.median(bends)) / 0.6744897501960817 / 6.0 if bends.size else 0.0


def rough_share(heights: Floats) -> float:
    """Share of the noise's variance that is roughness: it grows with the step of the differences.

    Of white noise v(1) = v(2) = v(4). What is more at longer steps is taken for a power of the
    step, and that power continued to the step of one.
    """
    first, second, fourth = (noise_std(heights, step) ** 2 for step in (1, 2, 4))
    if not second > first > 0.0:
        return 0.0
    growth = max(fourth - second, 0.0) / (second - first)
    power = min(max(growth, math.sqrt(2.0)), 256.0)  # of a rough surface to a smooth one
    return min((second - first) / (power - 1.0) / first, 1.0)


def noise_passed(std: float, pixel: tuple[float, ...], cutoff: float | None) -> float:
    """Standard deviation [m] of white noise of ``std`` [m] behind the Gaussian filter."""
    if cutoff is None:
        return std
    return std * math.prod(float(np.linalg.norm(weights(cutoff / step))) for step in pixel)


def present(heights: Floats, reach: int) -> NDArray[np.bool_]:
    """Points all of whose neighbours up to ``reach`` points away are there and not missing."""
    rows, columns = heights.shape
    result = np.zeros(heights.shape, dtype=bool)
    inner = result[reach : rows - reach, reach : columns - reach]
    if inner.size == 0:
        return result
    there = ~np.isnan(heights)
    inner[:] = True
    if there.all():
        return result
    # A square is a row of columns.
    width = 2 * reach + 1
    along = np.ones((rows, columns - 2 * reach), dtype=bool)
    for k in range(width):
        along &= there[:, k : k + columns - 2 * reach]
    for k in range(width):
        inner &= along[k : k + rows - 2 * reach]
    return result


@dataclass(frozen=True, eq=False, repr=False)
class HeightMap(Locked, Plottable):
    """Heights of a surface or of a line on it: what every step of its evaluation is given.

    Its only user's class is :class:`~microslip.Scan`, which says its parameters.
    """

    heights: NDArray[np.float64]
    pixel: tuple[float, ...]
    name: str
    notes: tuple[str, ...]
    cutoff: float | None
    long_cutoff: float | None

    _noise_before: float | None = None
    """Noise [m] before the short-wave cut-off, if conditioning applied it: behind a filter there
    are hardly any differences from point to point left to tell it by."""
    _unfiltered: HeightMap | None = None
    """The scan before anything was filled or filtered: gaps and spikes are judged there."""

    def __init__(
        self,
        heights: ArrayLike,
        pixel: float | str | tuple[float | str, ...],
        *,
        name: str = "scan",
        notes: tuple[str, ...] = (),
        cutoff: float | None = None,
        long_cutoff: float | None = None,
    ) -> None:
        array = height_array(heights)
        if not isinstance(name, str):
            raise InputError(f"`name` must be text, got {show(name)}")
        if isinstance(notes, str) or not all(isinstance(note, str) for note in notes):
            raise InputError(f"`notes` must be a tuple of texts, got {show(notes)}")
        assign(self, heights=array, pixel=pixel_of(pixel, array.ndim), name=name)
        assign(self, notes=tuple(notes))
        for key, length in (("cutoff", cutoff), ("long_cutoff", long_cutoff)):
            checked = None if length is None else positive(key, length, "m", 1e-5)
            assign(self, **{key: checked})

    def changed(self, heights: ArrayLike, **changes: Any) -> Self:
        """The same with other heights, and whatever else changes with them."""
        noise = changes.pop("noise_before", self._noise_before)
        unfiltered = changes.pop("unfiltered", self._unfiltered)
        about = {key: getattr(self, key) for key in ("name", "notes", "cutoff", "long_cutoff")}
        result = type(self)(heights, self.pixel, **{**about, **changes})
        assign(result, _noise_before=noise, _unfiltered=unfiltered)
        return result

    def __repr__(self) -> str:
        shape = " x ".join(str(n) for n in self.heights.shape[::-1])
        steps = " x ".join(engineering(step, "m") for step in dict.fromkeys(self.pixel))
        return f"{type(self).__name__}({self.name[:60]!r}, {shape} points, pixel {steps})"

    def _figure(self) -> Plot:
        from microslip.surfaces.figures import map_figure

        return map_figure(self)

    @property
    def is_profile(self) -> bool:
        """Whether this is a line and not an area."""
        return self.heights.ndim == 1

    @property
    def size(self) -> tuple[float, ...]:
        """Length [m] along x and along y; of a profile, along it."""
        counts = self.heights.shape[::-1]
        return tuple(n * step for n, step in zip(counts, self.pixel, strict=True))

    @property
    def area(self) -> float:
        """Area [m^2] that the points stand for, missing ones among them."""
        if self.is_profile:
            raise InputError(f"{self.name[:60]}: a profile has no area; wanted a scan of an area")
        return math.prod(self.size)

    @property
    def missing(self) -> float:
        """Share of the points that are missing [-]."""
        return float(np.count_nonzero(np.isnan(self.heights)) / self.heights.size)

    def measurable(self) -> Self:
        """The scan itself, if its heights vary and no spike drowns the others."""
        if self._objection:
            raise InputError(f"{self.name[:60]}: {self._objection}")
        return self

    def statistics(self) -> Statistics:
        """Height parameters, such as rms and skewness; errors as :meth:`measurable`."""
        return self.measurable()._statistics

    def moments(self) -> Moments:
        """Spectral moments m0, m2 and m4, from finite differences, of each axis too.

        Errors as :meth:`measurable`; two rows or columns only.
        """
        enough(self.name, self.heights)
        return self.measurable()._moments

    def noise_behind(self, cutoff: float | None) -> float:
        """Standard deviation [m] of the noise behind a filter of a cut-off [m] and earlier ones.

        It is that of white noise of the size that the scan had before any filter, if that is known.
        """
        if cutoff is not None:
            cutoff = length_of("cutoff", cutoff, "10 um")
            shortest, longest = 2.0 * min(self.pixel), max(self.size)
            if not shortest <= cutoff <= longest:
                raise InputError(
                    f"`cutoff` must be between two pixels, {shortest:g} m, and the size of the "
                    f"scan, {longest:g} m, got {cutoff:g} m"
                )
        if self._noise_before is None:
            return noise_passed(self.noise, self.pixel, cutoff)
        combined = math.hypot(self.cutoff or 0.0, cutoff or 0.0)
        return noise_passed(self._noise_before, self.pixel, combined or None)

    @cached_property
    def noise(self) -> float:
        """Standard deviation of the noise of an area from point to point [m]: an upper bound."""
        return noise_std(self.heights)

    @property
    def unfiltered(self) -> HeightMap:
        """The scan before anything was filled or filtered, levelled; this one if nothing was."""
        return self if self._unfiltered is None else self._unfiltered

    @cached_property
    def rough_share_of_noise(self) -> float:
        """Share of :attr:`noise` squared that grows with the distance as roughness does [-]."""
        return rough_share(self.heights)

    @cached_property
    def _objection(self) -> str:
        return objection(self.heights)

    @cached_property
    def _statistics(self) -> Statistics:
        return statistics_of(self.heights)

    @cached_property
    def _moments(self) -> Moments:
        return moments_of(self.heights, self.pixel)
