"""Error bars of the parameters of a scan, from patches of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import number, show
from microslip._core.frozen import Locked, lock
from microslip._core.wording import did_you_mean, quoted
from microslip.errors import InputError
from microslip.scans.height_map import HeightMap
from microslip.scans.spectrum import mirrored_counts

Map = TypeVar("Map", bound=HeightMap)
Parameter = Callable[[HeightMap], float]


def _parameter(measure: Callable[[HeightMap], Any], name: str) -> Parameter:
    return lambda scan: float(getattr(measure(scan), name))


_MEASURES: tuple[tuple[Callable[[HeightMap], Any], tuple[str, ...]], ...] = (
    (lambda scan: scan.statistics(), ("rms", "mean_deviation", "skewness", "kurtosis")),
    (lambda scan: scan.moments(), ("m0", "m2", "m4", "nayak", "anisotropy")),
    (lambda scan: scan.moments().mccool(), ("density", "radius", "std", "mean_height")),
)
PARAMETERS = {name: _parameter(measure, name) for measure, names in _MEASURES for name in names}
"""Parameters that go by name; density, radius, std and mean height are McCool's."""


@dataclass(frozen=True, eq=False)
class PatchErrors(Locked):
    """A parameter of a scan, and how it scatters from patch to patch.

    Notes
    -----
    Patches are alike where waves are longer than they are, and their scatter is then 0.4 to 0.7 of
    the true error of Sq, Sa and m0. For these the error is that of a Gaussian surface with the
    spectrum of the scan, if that is larger: the variance of m0 is the sum of the squared powers of
    its independent waves, each of which scatters as much as it is large. Of surfaces with one wave
    to the side it was 0.7 of the true scatter, with two 0.9, with four and more 1.0 to 1.2.
    """

    value: float
    """The parameter of the whole scan [its unit]."""
    values: NDArray[np.float64]
    """Value of each patch, row by row; patches without one are left out."""
    failed: int = 0
    """Number of patches without a value or without points."""
    long_waves: float = 0.0
    """Standard error [its unit] by the waves of the whole scan, of heights (see Notes)."""

    @property
    def mean(self) -> float:
        """Mean over the patches."""
        return float(self.values.mean())

    @property
    def std(self) -> float:
        """Standard deviation from patch to patch: how alike places of the surface are."""
        return float(self.values.std(ddof=1))

    @property
    def standard_error(self) -> float:
        """Error bar of the whole: of the mean over the patches, or by long waves if larger."""
        return max(self.std / math.sqrt(self.values.size), self.long_waves)

    @property
    def bias(self) -> float:
        """Mean over the patches less the value of the whole.

        Waves longer than a patch are level in it: beyond a few error bars the parameter depends
        on the size of the scan, and the error bar is too small.
        """
        return self.mean - self.value

    def interval(self, confidence: float = 0.95) -> tuple[float, float]:
        """Interval about the value of the whole, by Student's t of the patches.

        The ``confidence`` is the share of such intervals that hold the truth, from 0.5 to below 1
        or an InputError, if the patches are independent: much larger than the longest wave that
        counts.
        """
        from scipy.special import stdtrit

        confidence = number("confidence", confidence)
        if not 0.5 <= confidence < 1.0:
            raise InputError(f"`confidence` must be from 0.5 to below 1, got {confidence:g}")
        reach = float(stdtrit(self.values.size - 1, 0.5 + 0.5 * confidence)) * self.standard_error
        return self.value - reach, self.value + reach


def patch_errors(
    scan: HeightMap,
    parameter: str | Callable[[HeightMap], float],
    patches: tuple[int, int] | int = (3, 3),
) -> PatchErrors:
    """Error bar of a parameter from patches of the scan.

    Parameters
    ----------
    scan : Scan
        A scan, levelled and limited in its band as it is to be judged, or a profile. The patches
        are cut from it as it is and not levelled again.
    parameter : str or callable
        A name of :data:`PARAMETERS`, such as "rms" or "radius", or a function of a scan that
        returns a number, such as ``lambda s: s.summits(cutoff=1e-5).density``.
    patches : tuple of int or int
        Rows and columns of patches; of a profile, their number. Two in all at least.

    Returns
    -------
    PatchErrors
        The value of the whole scan and those of the patches.
    """
    if isinstance(parameter, str):
        if parameter not in PARAMETERS:
            hint = did_you_mean(parameter, PARAMETERS)
            raise InputError(
                f"`parameter` must be {quoted(PARAMETERS)} or a function of a scan, got "
                f"{show(parameter)}{hint}"
            )
        function = PARAMETERS[parameter]
    elif callable(parameter):
        function = parameter
    else:
        raise InputError(
            f"`parameter` must be a name or a function of a scan, got {show(parameter)}"
        )
    parts = cut(scan, patches)
    total = math.prod(_counts(patches, scan.heights.ndim))
    value = number("the parameter", function(scan))
    values = []
    for part in parts:
        try:
            values.append(number("the parameter", function(part)))
        except InputError:  # such as a patch without a summit
            continue
    if len(values) < 2:
        raise InputError(
            f"only {len(values)} of {total} patches give a number; choose fewer, larger ones"
        )
    powers = _BY_WAVES.get(parameter, 0.0) if isinstance(parameter, str) else 0.0
    waves = powers * value * long_wave_error(scan) if powers else 0.0
    return PatchErrors(value, lock(np.array(values)), total - len(values), waves)


_BY_WAVES = {"rms": 0.5, "mean_deviation": 0.5, "m0": 1.0}
"""Parameters that long waves decide, with the power of m0 that they go with."""


def long_wave_error(scan: HeightMap) -> float:
    """Standard error of m0 over m0 [-], of a Gaussian surface with the spectrum of the scan."""
    z = scan.heights - np.nanmean(scan.heights)
    power = np.abs(np.fft.rfftn(np.nan_to_num(z))) ** 2
    # Waves that stand for their mirror image, too, count as one of twice the power.
    power *= mirrored_counts(z.shape[-1])
    power.flat[0] = 0.0
    # A power that scatters as much as it is large has a mean square of twice its squared mean.
    return math.sqrt(0.5 * float(np.sum(power * power))) / float(power.sum())


def cut(scan: Map, patches: tuple[int, int] | int = (3, 3)) -> list[Map]:
    """Patches of a scan, of the same size but for a point."""
    counts = _counts(patches, scan.heights.ndim)
    if math.prod(counts) < 2:
        raise InputError(f"`patches` must be two or more, got {show(patches)}")
    if any(n // count < 8 for n, count in zip(scan.heights.shape, counts, strict=True)):
        raise InputError(
            f"`patches` must have eight points along a side, got {show(patches)} patches of "
            f"{' x '.join(str(n) for n in scan.heights.shape)} points"
        )
    edges = [
        np.linspace(0, n, count + 1).astype(int)
        for n, count in zip(scan.heights.shape, counts, strict=True)
    ]
    parts = []
    for index in np.ndindex(*counts):
        where = tuple(
            slice(int(edge[i]), int(edge[i + 1])) for edge, i in zip(edges, index, strict=True)
        )
        heights = scan.heights[where]
        if np.isnan(heights).all():
            continue
        patch = scan.changed(
            heights,
            name=f"{scan.name}, patch {index}",
            notes=(*scan.notes, f"patch {index} of {counts}"),
        )
        parts.append(patch)
    return parts


def _counts(patches: Any, axes: int) -> tuple[int, ...]:
    counts = patches if isinstance(patches, (tuple, list)) else (patches,) * axes
    # The default is for an area; along a profile it makes as many patches.
    if axes == 1 and len(counts) == 2 and all(_is_count(n) for n in counts):
        counts = (int(counts[0]) * int(counts[1]),)
    if len(counts) != axes or not all(_is_count(n) for n in counts):
        raise InputError(
            f"`patches` must be whole numbers above zero, one for each axis, got {show(patches)}"
        )
    return tuple(int(n) for n in counts)


def _is_count(value: Any) -> bool:
    return isinstance(value, (int, np.integer)) and not isinstance(value, bool) and int(value) > 0
