"""The joint of a scan solved point by point, and the joint of a profile.

The first is under a load that has tightened it; the second that of the isotropic face with the
spectrum and the moments of the profile.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from microslip._core.units import engineering
from microslip._core.verdicts import Verdict
from microslip.errors import InputError
from microslip.friction import Interface
from microslip.materials import MaterialPair
from microslip.normal import MeasuredContact, NormalLaw, RoughSurface
from microslip.normal.measured_face import ContactNumbers
from microslip.normal.rough import mean_wavenumber, moments
from microslip.scans.height_laws import LawAtLoad
from microslip.scans.height_map import HeightMap
from microslip.scans.patches import cut
from microslip.scans.scan_rules import PIECES, judged
from microslip.scans.spectrum import spectrum
from microslip.scans.summit_statistics import SummitStatistics

MOST_POINTS = 512 * 512
"""Points of a scan that is solved unasked, in seconds."""
_ENOUGH = 500
"""Points in contact from which on the law is the one to take."""


@dataclass(frozen=True)
class PointByPoint:
    """A scan solved under a load, or why it was not."""

    joint: Interface | None
    at_load: LawAtLoad | None
    pressure: float
    """Mean pressure of tightening [Pa]: that of the load, with four digits, rounded up."""
    piece: int | None
    """Points along a side of its pieces, about."""
    missing: str = ""
    """Reason why there is none."""

    @property
    def law(self) -> MeasuredContact | None:
        """The normal law."""
        surface = None if self.joint is None else self.joint.surface
        return surface if isinstance(surface, MeasuredContact) else None

    @property
    def is_main(self) -> bool:
        """Whether a study should build on it: points enough are in contact."""
        return self.law is not None and self.law.numbers.points >= _ENOUGH

    @property
    def verdicts(self) -> tuple[Verdict, ...]:
        """Verdicts."""
        return () if self.joint is None else self.joint.validity

    def words(self) -> str:
        """The result, or why there is none, in words."""
        if self.law is None:
            return f"Not solved point by point: {self.missing}."
        text = f"Solved point by point: {contact_words(self.law.numbers)}."
        if self.is_main:
            text += " Verdicts on summits and their radii do not apply to it."
        return text


def point_by_point(
    scan: HeightMap,
    pair: MaterialPair,
    normal_load: float,
    *,
    area: float | None,
    friction_coefficient: float,
    amplitude: float | None,
    direction: float | None,
    asked: bool,
    report: Callable[[float], None],
) -> PointByPoint:
    """Solve a scan under a load [N]; one of many points only where that is asked."""
    pressure = _rounded_up(normal_load / (area or math.prod(scan.size)))
    shortest = min(scan.heights.shape)
    piece = 256 if shortest >= 384 else 128 if shortest >= 192 else None
    why = ""
    if scan.missing > 0.0:
        why = "points are missing; fill them by `fill=True`"
    elif scan.heights.size > MOST_POINTS and not asked:
        why = f"{scan.heights.size} points take their time; ask for it by `point_by_point=True`"
    if why:
        return PointByPoint(None, None, pressure, piece, why)
    try:
        law = MeasuredContact(
            scan, pair, tightening_pressure=pressure, area=area, piece=piece, direction=direction,
            progress=lambda done, total: report(done / total),
        )  # fmt: skip
        joint = Interface(law, friction_coefficient, normal_load=normal_load)
        found = LawAtLoad.of(joint, amplitude, law.area)
    except InputError as error:
        return PointByPoint(None, None, pressure, piece, error.text)
    return PointByPoint(joint, found, pressure, piece)


def contact_words(numbers: ContactNumbers) -> str:
    """The solution of a face, in words."""
    n = numbers
    state = f"elastic up to {engineering(n.pressure, 'Pa')}"
    if n.hardness is not None:
        state = (
            f"tightened to {engineering(n.pressure, 'Pa')} at a hardness of "
            f"{engineering(n.hardness, 'Pa')}, {100.0 * n.hard_share:.0f} % of the contact at it"
        )
    scatter = ""
    if n.scatter is not None:
        scatter = f", whose stiffness scatters by {100.0 * n.scatter:.0f} %"
    low, high = n.stiffness_ratios
    changes = [
        f"{100.0 * (value - 1.0):+.0f} % {how}"
        for value, how in (
            (n.coarser, "by twice the pixel"),
            (n.smoother, f"without waves below {engineering(n.cutoff or 0.0, 'm')}"),
        )
        if value is not None
    ]
    resolution = f"; its stiffness changes by {' and '.join(changes)}" if changes else ""
    return (
        f"{state}; {n.points} points in contact, {100.0 * n.contact_share:.1f} % of the face; "
        f"p/E*h' {n.relative_pressure:.2g}, h' {n.slope:.2g}; {n.pieces} "
        f"piece{'s' if n.pieces > 1 else ''}{scatter}; normal over tangential stiffness "
        f"{low:.3f} to {high:.3f} by direction{resolution}"
    )


def _rounded_up(value: float) -> float:
    """Four digits, so that a study in which they are written bears the load."""
    scale = 10.0 ** (math.floor(math.log10(value)) - 3)
    return math.ceil(value / scale) * scale


HURST = 0.8
_PIECES = 4
_WIDEST = 1e4  # roll-off over shortest wave
_ONE_WAVE = 1.15  # square of the mean wavenumber over the mean square; 1.23 of a sine


@dataclass(frozen=True)
class ProfileJoint:
    """A joint by the laws that a profile is enough for, if its face is isotropic."""

    normal_load: float
    """[N]."""
    area: float
    """Apparent area [m^2]."""
    laws: Mapping[str, LawAtLoad]
    """"rough" by its spectrum, "mccool" and "nayak" by its moments."""
    surface: RoughSurface
    """The first of them."""
    scatter: float | None
    """Standard error of the logarithm of its stiffness, by pieces of the profile [-]."""
    validity: tuple[Verdict, ...]
    """Verdicts on the joint of the first."""

    def verdicts(self) -> tuple[Verdict, ...]:
        """Verdicts of the law, and on the stiffness from so short a profile."""
        return *self.validity, *judged({PIECES: self.scatter})


def rough_of_profile(
    profile: HeightMap, pair: MaterialPair, area: float, band: float | None = None
) -> RoughSurface:
    """The rough face of a profile [m], by its rms height and two moments of its spectrum.

    The mean wavenumber of an isotropic face is pi/2 times that of its profiles, its mean square
    twice theirs: both ends of a power law of Hurst's exponent 0.8 follow from them, or one where
    the ratio of both is given as the band.
    """
    profile = profile.measurable()
    axis = spectrum(profile).axes[0]
    total = float(axis.power.sum())
    first = 0.5 * math.pi * float(axis.wavenumber @ axis.power) / total
    second = 2.0 * float(axis.wavenumber**2 @ axis.power) / total
    ratio = _band(first**2 / second) if band is None else band
    roll_off = 2.0 * math.pi / first * mean_wavenumber(HURST, 1.0, ratio)
    heights = profile.heights[np.isfinite(profile.heights)]
    rms = math.sqrt(profile.moments().m0)
    return RoughSurface(pair, rms, roll_off, roll_off / ratio, area, HURST, heights=heights)


def _band(target: float) -> float:
    """Longest over shortest wave, by the square of the mean wavenumber over the mean square."""
    from scipy.optimize import brentq

    def miss(log_ratio: float) -> float:
        ends = 1.0, math.exp(log_ratio)
        mean_square = 2.0 * moments(1.0, HURST, *ends)[1]
        return mean_wavenumber(HURST, *ends) ** 2 / mean_square - target

    low, high = math.log(1.0 / 0.89), math.log(_WIDEST)
    if target < _ONE_WAVE and miss(low) <= 0.0:  # a narrow band, as chance has it
        return math.exp(low)
    if not miss(high) < 0.0 < miss(low):
        raise InputError(
            "the profile has no spectrum of a rough face: its waves are all of one length, or "
            "noise; choose another short-wave cut-off"
        )
    return math.exp(brentq(miss, low, high))


def profile_joint(
    profile: HeightMap,
    estimates: Mapping[str, SummitStatistics | None],
    pair: MaterialPair,
    normal_load: float,
    area: float | None,
    friction_coefficient: float,
    amplitude: float | None,
) -> ProfileJoint:
    """The joint of a conditioned profile under a load [N] on an apparent area [m^2]."""
    if area is None:
        raise InputError('`area="2 cm^2"` goes with a profile, which has none')
    rough = rough_of_profile(profile, pair, area)
    surfaces: dict[str, NormalLaw] = {"rough": rough}
    for name, part in estimates.items():
        if part is not None:
            surfaces[name] = part.to_surface(pair, area)
    joints = {
        name: Interface(surface, friction_coefficient, normal_load=normal_load)
        for name, surface in surfaces.items()
    }
    laws = {name: LawAtLoad.of(joint, amplitude, area) for name, joint in joints.items()}
    logs: list[float] = []
    with suppress(InputError):  # too short for pieces
        for piece in cut(profile, _PIECES):
            part_law = rough_of_profile(piece, pair, area, rough.roll_off / rough.shortest)
            logs.append(math.log(part_law.stiffness(part_law.separation(normal_load))))
    scatter = float(np.std(logs, ddof=1)) / math.sqrt(_PIECES) if len(logs) == _PIECES else None
    return ProfileJoint(
        normal_load, area, MappingProxyType(laws), rough, scatter, joints["rough"].validity
    )
