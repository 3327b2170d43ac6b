"""The load curve that all nodes of a field share."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Literal

import numpy as np

from microslip import kernels
from microslip._core.checks import Floats
from microslip.friction.interface import Interface
from microslip.kernels.profile import Profile
from microslip.memory import Slips
from microslip.normal import NormalLaw
from microslip.normal.grids import pairs_of

_FAINT_LOAD = 1e-30  # of the load at the origin: what is lighter counts as none
_CACHED_CURVES = 8  # curves, of the surfaces that were asked for last
_ORIGINS = 64  # of curves that fields share, over the span of a surface
_DEPTH_RATIO = 1.25  # ratio of the depths from which on profiles of kinked curves are made


def field_curve(surface: NormalLaw, nearest: float) -> FieldCurve:
    """The curve of a surface for separations about ``nearest``, shared by all fields on it.

    Its origin is one of a few, so that what a field gives does not depend on which came before.
    """
    low, high = surface._span
    width = (high - low) / _ORIGINS
    place = (nearest - low) / width if width > 0.0 else math.inf
    if 0.0 <= place <= _ORIGINS:
        nearest = low + width * math.floor(place)
    return _curve(_Identity(surface), nearest)


class _Identity:
    """A surface by which object it is: one's own may be equal to others, or have no hash."""

    def __init__(self, surface: NormalLaw) -> None:
        self.surface = surface

    def __hash__(self) -> int:
        return id(self.surface)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Identity) and other.surface is self.surface


@lru_cache(maxsize=_CACHED_CURVES)
def _curve(identity: _Identity, nearest: float) -> FieldCurve:
    return FieldCurve(identity.surface, nearest)


class FieldCurve:
    """N(d) of a surface, with its falls; separations count from an origin, as *steps*.

    Where the surface is smooth it is one profile, for all nodes and as deep as has been asked for;
    else the surface is asked itself.
    """

    def __init__(self, surface: NormalLaw, nearest: float) -> None:
        self.surface = surface
        self.origin = nearest if self._loaded(nearest) else self._middle()
        # Its friction is of no account: only the load curve of this joint is made use of.
        self._coupling = Interface(surface, 1.0, separation=self.origin)._coupling
        self._kinked: dict[int, Profile | None] = {}

    def _middle(self) -> float:
        """A separation with many contacts."""
        low, high = self.surface._span
        return 0.5 * (low + high) if self._loaded(0.5 * (low + high)) else low

    def _loaded(self, separation: float) -> bool:
        """Whether what is carried there is no rounding of what the surface can carry."""
        heaviest = self.surface._derivative_at(self.surface._span[0], 0)
        return self.surface._derivative_at(separation, 0) > 1e-15 * heaviest

    def profile(self, low: float) -> Profile | None:
        """The curve from ``low`` on to where nothing is left; None where it cannot be a profile."""
        profile = self._coupling.profile(min(low, 0.0), self._far)
        if profile is None and self.surface._small_kinks.size:
            return self._kinked_profile(min(low, 0.0))
        return profile

    def _kinked_profile(self, low: float) -> Profile | None:
        """The same for heights whose density is a table of many points."""
        surface, origin = self.surface, self.origin
        edge, top = surface._edge - origin, surface._top - origin
        if low < edge or not math.isfinite(top):
            return None
        # From one of a few depths on, each with a profile of its own: the same for all who ask.
        depth = max(1, math.ceil(math.log((top - low) / top) / math.log(_DEPTH_RATIO)))
        if depth not in self._kinked:
            begin = max(top - top * _DEPTH_RATIO**depth, edge)
            self._kinked[depth] = Profile.sample_kinked(
                lambda x, order: surface._derivative(x + origin, order), begin, top, edge
            )
        return self._kinked[depth]

    @property
    def _far(self) -> float:
        """More steps than any contact reaches."""
        return 1e3 * self._coupling._joint.normal_load / self._coupling._joint.normal_stiffness

    def parting(self) -> float:
        """Step from which on nothing is in contact."""
        top = self.surface._top
        if math.isfinite(top):
            return top - self.origin
        profile = self.profile(0.0)
        if profile is not None:
            panels = len(profile.coefficients) - profile.first
            return math.nextafter(profile.anchor + panels / profile.inverse_width, math.inf)
        step = self._far * 1e-3
        faintest = _FAINT_LOAD * self.surface._derivative_at(self.origin, 0)
        while self.surface._derivative_at(self.origin + step, 0) > faintest:
            step *= 1.25
        return step

    def steps_of(self, loads: Floats) -> Floats:
        """Steps of loads above zero [N]."""
        return self._coupling.steps_of(loads, numbered=False)

    def drop(self, base: Floats, width: Floats) -> Floats:
        """N(b) - N(b + w)."""
        profile = self.profile(float(base.min()))
        if profile is None:
            return self._coupling.drop(base, width)
        result = np.empty(base.size)
        kernels.active.drops(base, width, result, *profile.arguments)
        return result

    def excess(self, kind: Literal["excess", "excess_slope"], step: Floats, u: Floats) -> Floats:
        """Half the integral of v (u - v) N''(d + v), or of v N''(d + v), over 0 <= v <= u."""
        profile = self.profile(float(step.min())) if kind == "excess_slope" else None
        if profile is not None:
            result = np.empty(step.size)
            kernels.active.excesses(step, u, result, *profile.arguments)
            return 0.5 * result
        pairs, there = pairs_of(self.surface), step + self.origin
        if pairs is not None:
            return pairs(self.surface, kind, there, u)
        integral = self.surface._excess if kind == "excess" else self.surface._excess_slope
        pair_values = zip(there.tolist(), u.tolist(), strict=True)
        return np.array([integral(d, np.array([v]))[0] for d, v in pair_values])

    def losses(self, slips: Slips, count: int) -> Floats:
        """What slip loses in each of so many samples, over mu kappa, where there is no profile."""
        return self._coupling._losses.of(slips, count)

    def load(self, step: Floats) -> tuple[Floats, Floats]:
        """N and -N'."""
        profile = self.profile(float(step.min()))
        if profile is None:
            there = step + self.origin
            return self.surface._derivative(there, 0), -self.surface._derivative(there, 1)
        value, fall = np.empty(step.size), np.empty(step.size)
        kernels.active.loads(step, value, fall, *profile.arguments)
        return value, fall
