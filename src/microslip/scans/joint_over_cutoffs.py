"""Quantities of a joint against both cut-offs of the scan and against its size."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, positive, positives, show
from microslip._core.frozen import Locked, lock
from microslip._core.units import engineering
from microslip._core.verdicts import Verdict
from microslip.errors import InputError
from microslip.friction import Interface
from microslip.materials import MaterialPair
from microslip.normal.base import check_pair
from microslip.scans.checks import area_of, length_of
from microslip.scans.conditioning import Filter, band, condition
from microslip.scans.height_laws import Heights
from microslip.scans.height_map import HeightMap
from microslip.scans.levelling import Level
from microslip.scans.patches import cut
from microslip.scans.scan_rules import judged
from microslip.scans.summit_set import Method, Summits
from microslip.scans.summits import find_summits

JOINT_UNITS = {
    "tangential_stiffness": "N/m",
    "real_area": "-",
    "plasticity_index": "-",
    "contact_radius_over_cutoff": "-",
    "loss_factor": "-",
}
"""Quantities of a joint with their units; the real area is over the apparent one."""

_STEP = 2.0
Progress = Callable[[int, int], None]


@dataclass(frozen=True, eq=False)
class JointOverCutoffs(Locked):
    """A joint at rest against the short-wave and the long-wave cut-off of the scan."""

    cutoff: Floats
    """Short-wave cut-offs [m], rising; 0 where the pixel decides."""
    long_cutoff: Floats
    """Long-wave cut-offs [m], rising; infinite where the form removed and the scan decide."""
    chosen: tuple[int, int]
    """Place (row, column) of the joint that was asked for."""
    values: Mapping[str, Floats]
    """Values of each quantity, for long-wave cut-offs (rows) and short-wave cut-offs (columns); not
    a number where there are no summits, or no hardness or amplitude was given."""
    patches: Mapping[str, Floats]
    """The same of the joint on each of two by two patches of the scan at the same pressure, each
    levelled by itself and with the cut-offs that were asked for: a scan of half the length."""
    size: float
    """Shorter side of the scan [m], which stands for the long-wave cut-off where there is none."""
    normal_load: float
    area: float
    """Load [N] and apparent area [m^2]."""
    heights: str
    """Law of the summit heights."""
    notes: tuple[str, ...] = ()
    """Missing values, with the reason."""

    def slope(self, quantity: str, cutoff: str) -> float:
        """Slope d ln quantity / d ln cut-off ("cutoff" or "long_cutoff") at the joint asked for.

        By differences to the neighbours in the table; not a number where there are none. Another
        name is an InputError.
        """
        if quantity not in self.values:
            raise InputError(f"`quantity` must be among {[*self.values]}, got {quantity}")
        row, column = self.chosen
        if cutoff == "cutoff":
            places, line, at = self.cutoff, self.values[quantity][row], column
        elif cutoff == "long_cutoff":
            long = np.minimum(self.long_cutoff, self.size)
            places, line, at = long, self.values[quantity][:, column], row
        else:
            raise InputError(f'`cutoff` must be "cutoff" or "long_cutoff", got {show(cutoff)}')
        with np.errstate(divide="ignore", invalid="ignore"):
            x, y = np.log(places), np.log(line)
        good = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
        # The neighbours at both sides; at an end, or beside "none", the one there is.
        near = [*good[good < at][-1:], *good[good == at], *good[good > at][:1]]
        if len(near) < 2:
            return math.nan
        return float((y[near[-1]] - y[near[0]]) / (x[near[-1]] - x[near[0]]))

    def bias(self, quantity: str) -> float:
        """Geometric mean over the patches over the value of the whole scan [-].

        Far from one the quantity depends on the size of the scan: waves longer than a patch are
        form in it.
        """
        ratios = self.patches[quantity]
        ratios = ratios[np.isfinite(ratios) & (ratios > 0.0)]
        scan_value = float(self.values[quantity][self.chosen])
        return float(np.exp(np.log(ratios).mean())) / scan_value if ratios.size else math.nan

    def verdicts(self) -> tuple[Verdict, ...]:
        """Whether the cut-offs and the size of the scan decide the stiffness."""
        short, long = (self.slope("tangential_stiffness", name) for name in _CUTOFFS)
        bias = self.bias("tangential_stiffness")
        return judged(
            {
                "slope of stiffness over short-wave cut-off": abs(short),
                "slope of stiffness over long-wave cut-off": abs(long),
                "stiffness on patches of half the length, as a factor": max(bias, 1.0 / bias),
                "contact radius over cut-off": float(
                    self.values["contact_radius_over_cutoff"][self.chosen]
                ),
            }
        )


_CUTOFFS = ("cutoff", "long_cutoff")


def joint_over_cutoffs(
    scan: HeightMap,
    pair: MaterialPair,
    normal_load: float,
    *,
    cutoff: float | str | None,
    long_cutoff: float | str | None = None,
    cutoffs: ArrayLike | None = None,
    long_cutoffs: ArrayLike | None = None,
    area: float | str | None = None,
    friction_coefficient: float = 0.5,
    amplitude: float | None = None,
    heights: Heights = "population",
    level: Level | None = "plane",
    method: Method = "watershed",
    prominence: float | str | None = None,
    filter: Filter = "gaussian",
    progress: Progress | None = None,
) -> JointOverCutoffs:
    """Quantities of a joint against both cut-offs and on patches of the scan.

    Parameters
    ----------
    pair : MaterialPair
        The two materials.
    normal_load : float
        Load of the joint [N].
    cutoff, long_cutoff : float, str or None
        The cut-offs [m] that are meant, at which slopes are given.
    cutoffs, long_cutoffs : array_like, optional
        Others [m], one-dimensional; by default half to four times the cut-off, and an eighth
        to a half of the scan.
    area : float or str, optional
        Apparent area of the joint [m^2]; by default that of the scan.
    friction_coefficient, amplitude : float, optional
        Friction coefficient [-] and amplitude [m] for the loss factor.
    heights : {"gaussian", "table", "discrete", "population"}
        Law of the summit heights, as in :meth:`microslip.Summits.to_surface`.
    level, method, prominence, filter
        As in :meth:`condition` and :meth:`summits`.
    progress : callable, optional
        Called with the joints done and those to do, after each.

    Returns
    -------
    JointOverCutoffs
        Stiffness, real area, plasticity index, contact radius over cut-off and loss factor.
    """
    scan = scan.measurable()
    if scan.is_profile:
        raise InputError("a profile has no summits to count")
    # Here, as what a joint refuses at one cut-off is a note and no error.
    check_pair(pair)
    load = positive("normal_load", normal_load, "N", 2000.0)
    friction_coefficient = positive("friction_coefficient", friction_coefficient, "", 0.5)
    if amplitude is not None:
        amplitude = positive("amplitude", amplitude, "m", 1e-7)
    if area is not None:
        area = area_of(area)
    short, long = band(scan, cutoff, long_cutoff)
    levelled = scan if level is None else condition(scan, level=level)
    shorts = _around(short, cutoffs, 2.0 * max(scan.pixel), min(scan.size) / 4.0)
    longs = _longs(scan, long, long_cutoffs, shorts)
    counting = {"method": method, "prominence": prominence}
    joint = _JointOf(pair, load, area, friction_coefficient, amplitude, heights)
    values = {name: np.full((longs.size, shorts.size), math.nan) for name in JOINT_UNITS}
    notes: list[str] = []
    total, count = values["real_area"].size + 4, 0
    whole_area = 0.0
    for row, long_wave in enumerate(longs):
        filtered = levelled
        if math.isfinite(long_wave) and long_wave != scan.long_cutoff:
            filtered = condition(levelled, long_cutoff=float(long_wave), filter=filter)
        for column, short_wave in enumerate(shorts):
            at = (
                f"cut-off {_text(short_wave)}, long-wave "
                f"{'none' if math.isinf(long_wave) else engineering(float(long_wave), 'm')}"
            )
            try:
                if short_wave >= 0.8 * long_wave:
                    raise InputError("nothing is left between the cut-offs")
                summits = find_summits(filtered, float(short_wave) or None, **counting)  # type: ignore[arg-type]
                whole_area = joint.store(values, (row, column), summits, float(short_wave))
            except InputError as error:
                notes.append(f"{at}: {error.text}")
            count += 1
            if progress is not None:
                progress(count, total)
    row_of_long = int(np.argmin(np.abs(longs - (long or math.inf)))) if long else longs.size - 1
    place = row_of_long, int(np.argmin(np.abs(shorts - (short or 0.0))))
    patches = _patches(scan, joint, level, short, (long, filter), counting)
    if progress is not None:
        progress(total, total)
    return JointOverCutoffs(
        lock(shorts),
        lock(longs),
        place,
        {name: lock(array) for name, array in values.items()},
        {name: lock(array) for name, array in patches.items()},
        min(scan.size),
        load,
        whole_area,
        heights,
        tuple(dict.fromkeys(notes)),
    )


def _around(
    cutoff: float | None, values: ArrayLike | None, shortest: float, longest: float
) -> Floats:
    """The cut-off that was asked for, half and twice of it; or those that were given."""
    if values is not None:
        lengths = _lengths("cutoffs", values, "10 um")
        return np.unique(np.append(lengths, cutoff or 0.0))
    first = cutoff or 0.0
    start = first or 2.0 * shortest
    series = start * _STEP ** np.arange(-1.0, 3.0)
    return np.unique(np.append(series[(series > shortest) & (series < longest)], first))


def _lengths(name: str, values: Any, example: str) -> list[float]:
    """Cut-offs [m] from numbers or texts with units, in a list or alone."""
    if isinstance(values, str):
        return [length_of(name, values, example)]
    if isinstance(values, (list, tuple)) and any(isinstance(item, str) for item in values):
        return [length_of(name, item, example) for item in values]
    return positives(name, values, "m").reshape(-1).tolist()


def _longs(
    scan: HeightMap, cutoff: float | None, values: ArrayLike | None, shorts: Floats
) -> Floats:
    if values is not None:
        series = _lengths("long_cutoffs", values, "0.8 mm")
    else:
        start = cutoff or min(scan.size)
        powers = np.arange(-2.0, 2.0) if cutoff else np.arange(-3.0, 0.0)
        series = [
            value for value in start * _STEP**powers if 2.0 * shorts[0] < value < min(scan.size)
        ]
    if cutoff is None or scan.long_cutoff is None:
        series.append(math.inf)
    return np.unique(np.append(series, cutoff or math.inf))


@dataclass(frozen=True)
class _JointOf:
    """Function from summits to the quantities of a joint."""

    pair: MaterialPair
    normal_load: float
    area: float | str | None
    friction_coefficient: float
    amplitude: float | None
    heights: Heights

    def store(
        self,
        values: Mapping[str, Floats],
        place: Any,
        summits: Summits,
        cutoff: float,
        share: float = 1.0,
    ) -> float:
        """Store the quantities of the joint on some summits, at a share of the load and area."""
        surface: Any = summits.to_surface(self.pair, self.area, heights=self.heights)
        load = self.normal_load * (share if self.area is None else 1.0)
        joint = Interface(surface, self.friction_coefficient, normal_load=load)
        count = float(surface.contact_count(joint.separation))
        real = float(surface.contact_area(joint.separation))
        area = float(surface.area)
        unit = cutoff or math.sqrt(math.prod(summits.scan.pixel))
        quantities = {
            # Per joint of the whole area, so that patches compare with it.
            "tangential_stiffness": joint.tangential_stiffness
            / (share if self.area is None else 1.0),
            "real_area": real / area,
            "plasticity_index": surface._assumptions(joint.separation).get("plasticity index"),
            "contact_radius_over_cutoff": math.sqrt(real / (math.pi * count)) / unit
            if count
            else None,
            "loss_factor": None if self.amplitude is None else joint.loss_factor(self.amplitude),
        }
        for name, value in quantities.items():
            values[name][place] = math.nan if value is None else float(value)
        return area


def _patches(
    scan: HeightMap,
    joint: _JointOf,
    level: Level | None,
    short: float | None,
    long_filter: tuple[float | None, Filter],
    counting: Mapping[str, Any],
) -> dict[str, Floats]:
    """The joint on two by two patches at the same pressure, each as if it were the scan."""
    values = {name: np.full(4, math.nan) for name in JOINT_UNITS}
    long, filter = long_filter
    parts: list[HeightMap] = []
    with suppress(InputError):  # too small for patches
        parts = cut(scan, (2, 2))
    for index, part in enumerate(parts):
        with suppress(InputError):  # too small for the cut-off, or without a summit
            levelled = condition(part, level=level or "plane")
            if long is not None and scan.long_cutoff is None:
                levelled = condition(levelled, long_cutoff=long, filter=filter)
            summits = find_summits(levelled, short, **counting)
            joint.store(values, index, summits, short or 0.0, part.area / scan.area)
    return values


def _text(cutoff: float) -> str:
    return "none" if cutoff == 0.0 else engineering(float(cutoff), "m")
