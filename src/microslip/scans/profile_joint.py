"""The joint of a profile: that of the isotropic face with its spectrum and moments."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from microslip._core.verdicts import Verdict
from microslip.errors import InputError
from microslip.friction import Interface
from microslip.materials import MaterialPair
from microslip.normal import NormalLaw, RoughSurface
from microslip.normal.rough import mean_wavenumber, moments
from microslip.scans.height_laws import LawAtLoad
from microslip.scans.height_map import HeightMap
from microslip.scans.patches import cut
from microslip.scans.scan_rules import PIECES, judged
from microslip.scans.spectrum import spectrum
from microslip.scans.summit_statistics import SummitStatistics

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
