"""Standard errors of a scan's parameters from nine patches of it, and their names."""

from __future__ import annotations

import math
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from microslip.errors import InputError
from microslip.scans.height_map import HeightMap
from microslip.scans.moments import BY_MOMENTS
from microslip.scans.patches import cut, long_wave_error
from microslip.scans.summits import Summits


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
    for number in range(9):
        inside = patch == number
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
