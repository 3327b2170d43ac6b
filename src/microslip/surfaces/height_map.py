"""Heights on a regular grid, with cached parameters and estimated noise."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._core.checks import Floats, positive, show
from microslip._core.errors import InputError
from microslip._core.frozen import Locked, assign
from microslip._core.units import engineering
from microslip.figures.plot import Plot
from microslip.figures.plottable import Plottable
from microslip.surfaces.checks import enough, height_array, objection, pixel_of
from microslip.surfaces.filters import weights
from microslip.surfaces.moments import Moments, Statistics, moments_of, statistics_of

_BLOCK = 1 << 20  # points used for the median


def noise_std(heights: Floats, step: int = 1) -> float:
    """Estimate the standard deviation of white noise from fourth differences [m].

    Second differences along x of second differences along y vanish for smooth heights, and amplify
    the standard deviation of white noise six times. The median of their absolute values is
    insensitive to single spikes and scratches. Differences are taken over ``step`` points, which
    makes no difference for white noise.
    """
    if min(heights.shape) < 2 * step + 1:
        return 0.0
    # Evenly spaced rows: a million points suffice for a median.
    middle = np.arange(step, heights.shape[0] - step, max(1, heights.size // _BLOCK))
    across = heights[middle - step] - 2.0 * heights[middle] + heights[middle + step]
    bends = np.abs(across[:, 2 * step :] - 2.0 * across[:, step:-step] + across[:, : -2 * step])
    bends = bends[~np.isnan(bends)]
    return float(np.median(bends)) / 0.6744897501960817 / 6.0 if bends.size else 0.0


def noise_passed(std: float, pixel: tuple[float, ...], cutoff: float | None) -> float:
    """Return the standard deviation [m] of white noise after the Gaussian short-wave filter.

    ``std`` [m] is that before it; without a cut-off nothing changes.
    """
    if cutoff is None:
        return std
    return std * math.prod(float(np.linalg.norm(weights(cutoff / step))) for step in pixel)


def present(heights: Floats, reach: int) -> NDArray[np.bool_]:
    """Return a mask of points with no missing point up to ``reach`` points away."""
    rows, columns = heights.shape
    result = np.zeros(heights.shape, dtype=bool)
    inner = result[reach : rows - reach, reach : columns - reach]
    if inner.size == 0:
        return result
    there = ~np.isnan(heights)
    inner[:] = True
    if there.all():
        return result
    # The square neighbourhood is separable: rows first, then columns.
    width = 2 * reach + 1
    along = np.ones((rows, columns - 2 * reach), dtype=bool)
    for k in range(width):
        along &= there[:, k : k + columns - 2 * reach]
    for k in range(width):
        inner &= along[k : k + rows - 2 * reach]
    return result


@dataclass(frozen=True, eq=False, repr=False)
class HeightMap(Locked, Plottable):
    """Heights of a surface or of a line on it; base class of :class:`~microslip.Scan`."""

    heights: NDArray[np.float64]
    pixel: tuple[float, ...]
    name: str
    notes: tuple[str, ...]
    cutoff: float | None
    long_cutoff: float | None

    _noise_before: float | None = None
    """Noise [m] before the short-wave cut-off, if one was applied: it cannot be estimated
    afterwards."""
    _unfiltered: HeightMap | None = None
    """Scan before filling and filtering, on which gaps and spikes are judged."""

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
        """Return a copy with other heights and, optionally, other attributes."""
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
        """Whether the scan is a line instead of an area."""
        return self.heights.ndim == 1

    @property
    def size(self) -> tuple[float, ...]:
        """Length [m] along x and y; for a profile, its length."""
        counts = self.heights.shape[::-1]
        return tuple(n * step for n, step in zip(counts, self.pixel, strict=True))

    @property
    def area(self) -> float:
        """Area [m^2] of the pixels of all points, including missing points."""
        if self.is_profile:
            raise InputError(f"{self.name[:60]}: a profile has no area; use a scan of an area")
        return math.prod(self.size)

    @property
    def missing(self) -> float:
        """Fraction of missing points [-]."""
        return float(np.count_nonzero(np.isnan(self.heights)) / self.heights.size)

    def measurable(self) -> Self:
        """Return the scan; raise an InputError for constant heights or dominating spikes."""
        if self._objection:
            raise InputError(f"{self.name[:60]}: {self._objection}")
        return self

    def statistics(self) -> Statistics:
        """Return height parameters such as rms and skewness.

        Raises the errors of :meth:`measurable`.
        """
        return self.measurable()._statistics

    def moments(self) -> Moments:
        """Return the spectral moments m0, m2 and m4 from finite differences, also by axis.

        Raises the errors of :meth:`measurable`, and an InputError for an area with fewer than three
        rows or columns.
        """
        enough(self.name, self.heights)
        return self.measurable()._moments

    def _noise_behind(self, cutoff: float | None) -> float:
        """Return the standard deviation [m] of the noise left by a further filter ``cutoff`` [m].

        The noise is assumed to be white before all short-wave filters of the scan if it is known
        there, or else in this scan.
        """
        if self._noise_before is None:
            return noise_passed(self.noise, self.pixel, cutoff)
        combined = math.hypot(self.cutoff or 0.0, cutoff or 0.0)
        return noise_passed(self._noise_before, self.pixel, combined or None)

    @cached_property
    def noise(self) -> float:
        """Upper bound of the noise of an area [m], as standard deviation; includes roughness."""
        return noise_std(self.heights)

    @property
    def unfiltered(self) -> HeightMap:
        """Levelled scan before filling and filtering; the scan itself if nothing was applied."""
        return self if self._unfiltered is None else self._unfiltered

    @cached_property
    def rough_share_of_noise(self) -> float:
        """Fraction of the noise variance, :attr:`noise` squared, that is due to roughness [-].

        For white noise the estimated variance v(s) is the same for differences over s = 1, 2 and 4
        points. An increase with s is due to roughness: v(s) = a + b s^p is solved for a, b and p,
        and the fraction is b/v(1).
        """
        first, second, fourth = (noise_std(self.heights, step) ** 2 for step in (1, 2, 4))
        if not second > first > 0.0:
            return 0.0
        growth = max(fourth - second, 0.0) / (second - first)
        power = min(max(growth, math.sqrt(2.0)), 256.0)  # from a rough to a smooth surface
        return min((second - first) / (power - 1.0) / first, 1.0)

    @cached_property
    def _objection(self) -> str:
        return objection(self.heights)

    @cached_property
    def _statistics(self) -> Statistics:
        return statistics_of(self.heights)

    @cached_property
    def _moments(self) -> Moments:
        return moments_of(self.heights, self.pixel)


Map = TypeVar("Map", bound=HeightMap)
