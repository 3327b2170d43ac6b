"""Error bars of the parameters of a scan, from patches of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from microslip._core.checks import number, show
from microslip._core.frozen import Locked, lock
from microslip._core.wording import did_you_mean, quoted
from microslip.errors import InputError
from microslip.scans.height_map import HeightMap
from microslip.scans.moments import BY_MOMENTS
from microslip.scans.spectrum import mirrored_counts
from microslip.scans.summits import Summits

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


class Quantity(NamedTuple):
    """Name of a parameter, and its SI unit; "-" for none."""

    label: str
    unit: str


HEIGHTS = {
    "rms": Quantity("rms height Sq", "m"),
    "mean_deviation": Quantity("mean deviation Sa", "m"),
    "skewness": Quantity("skewness Ssk", "-"),
    "kurtosis": Quantity("kurtosis Sku", "-"),
    "flatness": Quantity("flatness Sz, lowest to highest", "m"),
}
MOMENTS = {
    "m0": Quantity("m0, variance of heights", "m^2"),
    "m2": Quantity("m2, mean square slope", "-"),
    "m4": Quantity("m4, mean square curvature", "1/m^2"),
    "nayak": Quantity("Nayak's α = m0 m4/m2²", "-"),
    "anisotropy": Quantity("anisotropy of slopes", "-"),
}
SUMMITS = {
    "density": Quantity("density", "1/m^2"),
    "radius": Quantity("radius", "m"),
    "std": Quantity("std of heights", "m"),
    "mean_height": Quantity("mean height", "m"),
}


def standard_errors(scan: HeightMap, summits: Summits | None) -> dict[str, float]:
    """Standard errors of the means over nine patches; of a profile as well.

    By names such as "rms" and "mccool.density"; what has none is left out.
    """
    try:
        patches = cut(scan)
    except InputError:  # too small for patches
        return {}
    rows = [_of_patch(patch) for patch in patches]
    if summits is not None:
        rows += _counted_in_patches(scan, summits)
    values: dict[str, list[float]] = {}
    for row in rows:
        for name, value in row.items():
            values.setdefault(name, []).append(value)
    errors = {name: _standard_error(of_all) for name, of_all in values.items() if len(of_all) > 1}
    m0, waves = scan.moments().m0, long_wave_error(scan)
    for name, value_of_scan, power in (
        ("rms", math.sqrt(m0), 0.5),
        ("mean_deviation", scan.statistics().mean_deviation, 0.5),
        ("m0", m0, 1.0),
    ):
        errors[name] = max(errors.get(name, 0.0), power * waves * value_of_scan)
    return errors


def _standard_error(values: list[float]) -> float:
    mean = math.fsum(values) / len(values)
    square = math.fsum((value - mean) ** 2 for value in values)
    return math.sqrt(square / (len(values) - 1) / len(values))


def _of_patch(patch: HeightMap) -> dict[str, float]:
    """Parameters of a patch; those that it has none of are left out."""
    row: dict[str, float] = {}
    try:
        statistics, moments = patch.statistics(), patch.moments()
    except InputError:
        return row
    row |= {name: getattr(statistics, name) for name in HEIGHTS}
    row |= {name: getattr(moments, name) for name in MOMENTS}
    for estimate, made_of in BY_MOMENTS.items():
        with suppress(InputError):
            part = made_of(moments)
            row |= {f"{estimate}.{name}": getattr(part, name) for name in SUMMITS}
    return row


def _counted_in_patches(scan: HeightMap, summits: Summits) -> list[dict[str, float]]:
    """Counts in three by three patches, each summit in the one it lies in."""
    places = [
        np.clip((3.0 * summits.positions[:, axis] / scan.size[axis]).astype(int), 0, 2)
        for axis in (0, 1)
    ]
    patch = 3 * places[1] + places[0]
    rows = []
    for place in range(9):
        inside = patch == place
        if np.count_nonzero(inside) < 2:
            continue
        heights, radii = summits.heights[inside], summits.radii[inside]
        radius = (
            float(np.sqrt(radii).mean()) ** 2
            if summits.method == "watershed"
            else 1.0 / float(summits.curvatures[inside].mean())
        )
        rows.append(
            {
                "counted.density": 9.0 * heights.size / summits.area,
                "counted.radius": radius,
                "counted.std": float(heights.std()),
                "counted.mean_height": float(heights.mean()),
            }
        )
    return rows
