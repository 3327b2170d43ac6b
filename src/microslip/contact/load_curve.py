"""The load curve N(d) of a surface, for the hysteresis of one joint or of many nodes."""

from __future__ import annotations

import math
from functools import cached_property, lru_cache
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from microslip._core import kernels
from microslip._core.checks import Floats, show
from microslip._core.errors import InputError
from microslip._core.kernels.pieces import Pieces
from microslip._core.kernels.profile import Profile
from microslip.contact.base import NormalLaw
from microslip.contact.exact_curves import SlipLosses, scalar_curve
from microslip.contact.grids import sum_over_pairs

_REACHES = 1.1 ** np.arange(-60.0, 150.0)  # decay lengths
_FAINT_LOAD = 1e-30  # of the largest load: what is lighter counts as none
_FAR = 1e3  # decay lengths: more than any contact reaches
_CACHED_CURVES = 8  # curves, of the surfaces that were asked for last
_ORIGINS = 64  # of curves that fields share, over the span of a surface
_DEPTH_RATIO = 1.25  # ratio of the depths from which on profiles of kinked curves are made


def check_surface(surface: Any) -> None:
    """Raise an InputError unless the argument is a normal law."""
    if not isinstance(surface, NormalLaw):
        from microslip.contact.laws import NORMAL_LAWS

        names = ", ".join(law.__name__ for law in NORMAL_LAWS)
        raise InputError(f"`surface` must be a normal load law ({names}), got {show(surface)}")


class LoadCurve:
    """Load curve N of a surface, as a function of the step: the separation less the origin [m].

    A smooth N is approximated by a profile, a piecewise polynomial over the steps requested so far;
    other surfaces are evaluated directly. A ``shared`` curve serves all nodes of contact fields,
    which may have any separation: its profile extends to separations at which the load is
    negligible, and is made even if N'' has many small kinks.
    """

    def __init__(
        self,
        surface: NormalLaw,
        origin: float,
        load: float | None = None,
        *,
        friction: float = 1.0,
        slip: float = 1.0,
        shared: bool = False,
    ) -> None:
        self.surface, self.origin = surface, origin
        self.load_at_origin = surface._derivative_at(origin, 0) if load is None else load
        # Of the joint that stands on it: mu [-], and displacement per step, kappa [-].
        self.friction, self.slip = friction, slip
        self.shared = shared
        self._profile: Profile | None = None
        self._faint = False  # whether it ends where the load is too light to matter
        self._refused: tuple[float, float] | None = None
        self._kinked: dict[int, Profile | None] = {}
        self._pieces: Pieces | None = None

    @cached_property
    def _length(self) -> float:
        """Decay length -N/N' at the origin [m]."""
        return self.load_at_origin / -self.surface._derivative_at(self.origin, 1)

    def profile(self, low: float, high: float) -> Profile | None:
        """Return a piecewise polynomial of N over the steps `low` to `high` [m].

        It may end before ``high`` if the load is negligible there. None if N is not smooth enough.
        """
        if self.shared:
            low = min(low, 0.0)
            return self._covering(low, _FAR * self._length) or self._kinked_profile(low)
        return self._covering(low, high)

    def arguments(self, low: float, high: float) -> tuple[Any, ...]:
        """Return the curve over the steps `low` to `high` as arguments of the compiled kernels.

        Without a profile these are the polynomials of a tabulated law, or a Python function that
        the kernels call.
        """
        profile = self.profile(low, high)
        if profile is not None:
            return profile.arguments
        if self.shared and self.surface._spline is not None:
            return self.smooth_parts(low, high).arguments
        return kernels.curve_arguments(self)

    def _covering(self, low: float, high: float) -> Profile | None:
        profile = self._profile
        if profile is not None:
            if profile.low <= low and high <= (math.inf if self._faint else profile.high):
                return profile
            low, high = min(low, profile.low), max(high, profile.high)
        low, high = min(low, 0.0), max(high, 0.0)
        refused = self._refused
        if refused is not None and low <= refused[0] and high >= refused[1]:
            return None
        sampled, faint = self._make_profile(low, high)
        if sampled is None:
            self._refused = low, high
            return None
        self._profile, self._faint = sampled, faint
        return sampled

    def _make_profile(self, low: float, high: float) -> tuple[Profile | None, bool]:
        law, origin, length = self.surface, self.origin, self._length
        edge, breaks = law._edge - origin, law._breaks
        if low < edge or (breaks.size and breaks[-1] > low + origin):
            return None, False
        # A little further, so that the next record is likely to be covered, too.
        margin = length + 0.5 * min(high - low, 20.0 * length)
        begin, end = max(low - margin, edge), high + margin
        faintest = _FAINT_LOAD * law._derivative_at(begin + origin, 0)
        faint = law._derivative_at(end + origin, 0) < faintest
        if faint:
            grid = begin + length * _REACHES
            end = float(grid[law._derivative(grid + origin, 0) >= faintest][-1])
        reach = law._table_reach(end + origin)
        if reach is None:
            return None, False
        return Profile.sample(self.derivative, begin, end, end + reach, edge), faint

    def _kinked_profile(self, low: float) -> Profile | None:
        edge, top = self.surface._edge - self.origin, self.surface._top - self.origin
        if not self.surface._small_kinks.size or low < edge or not math.isfinite(top):
            return None
        # From one of a few depths on, each with a profile of its own: the same for all who ask.
        depth = max(1, math.ceil(math.log((top - low) / top) / math.log(_DEPTH_RATIO)))
        if depth not in self._kinked:
            begin = max(top - top * _DEPTH_RATIO**depth, edge)
            self._kinked[depth] = Profile.sample_kinked(self.derivative, begin, top, edge)
        return self._kinked[depth]

    def smooth_parts(self, low: float, high: float) -> Profile | Pieces:
        """Return the normal load over at least the steps `low` to `high`, split at its kinks.

        This is the profile if it has no kinks; otherwise pieces between the kinks of N'', on which
        N and -N' of the surface are evaluated.
        """
        profile = (
            self._covering(min(low, 0.0), _FAR * self._length)
            if self.shared
            else self._covering(low, high)
        )
        if profile is not None:
            return profile
        pieces = self._pieces
        if pieces is None or pieces.edges[0] > low:
            law, low = self.surface, min(low, 0.0)
            top = max(self.parting(), low + self._length)
            # A little nearer where the law knows it, so that the next motion is covered, too.
            nearest = law._span[0] - self.origin
            begin = min(low, max(low - 0.1 * self._length, nearest))
            heights = np.zeros(0) if law._spheres is None else law._spheres.heights
            marks = (law._breaks, law._kinks, law._small_kinks, heights)
            places = np.unique(np.concatenate(marks)) - self.origin
            pieces = Pieces.sample(
                lambda x: -self.derivative(x, 1),
                lambda x: self.derivative(x, 0),
                places,
                begin,
                top,
                self.origin,
            )
            if pieces is None:
                raise InputError(
                    "`surface` must have a load curve of fewer kinks for harmonics without "
                    "samples; use JointField.harmonics with samples=512"
                )
            self._pieces = pieces
        return pieces

    def derivative(self, step: Floats, order: int) -> Floats:
        """Derivative of N of order 0 (N itself) to 2 at steps [m], computed from the surface."""
        return self.surface._derivative(step + self.origin, order)

    def derivative_at(self, step: float, order: int) -> float:
        """N [N] (order 0) or its derivative [N/m^order] at one step [m]."""
        return self.surface._derivative_at(step + self.origin, order)

    @cached_property
    def scalar(self) -> Any:
        """Load curve for single separations, used for laws without a compiled profile."""
        return scalar_curve(self.surface, self.origin)

    @cached_property
    def slip_losses(self) -> SlipLosses:
        """Energies dissipated by slip, used for laws without a compiled profile."""
        return SlipLosses(self.surface, self.origin)

    def load(self, step: Floats) -> tuple[Floats, Floats]:
        """Load N [N] and normal stiffness -N' [N/m] at steps [m]."""
        profile = self.profile(float(step.min()), 0.0) if self.shared else None
        if profile is None:
            if step.size == 1:  # a trial
                one_load, one_fall = self.scalar.load(float(step[0]))
                return np.array([one_load]), np.array([one_fall])
            return self.derivative(step, 0), -self.derivative(step, 1)
        value, fall = np.empty(step.size), np.empty(step.size)
        kernels.compiled.loads(step, value, fall, *profile.arguments)
        return value, fall

    def drop(self, base: Floats, width: Floats) -> Floats:
        """Return N(base) - N(base + width) [N] for separations ``base`` and ``width`` >= 0 [m]."""
        profile = self.profile(float(base.min()), 0.0) if self.shared and base.size else None
        if profile is not None:
            result = np.empty(base.size)
            kernels.compiled.drops(base, width, result, *profile.arguments)
            return result
        if base.size < 2:  # a trial, or nothing
            pairs = zip(base.tolist(), width.tolist(), strict=True)
            return np.array([self.scalar.drop(b, w) for b, w in pairs])
        return sum_over_pairs(self.surface, "drop", base + self.origin, width)

    def excess(self, kind: Literal["excess", "excess_slope"], step: Floats, u: Floats) -> Floats:
        """Return the excess [N m] or its derivative with respect to u [N], by ``kind``.

        The excess is half the integral of v (u - v) N''(step + v) over 0 <= v <= u.
        """
        shared = self.shared and kind == "excess_slope"
        profile = self.profile(float(step.min()), 0.0) if shared else None
        if profile is None:
            return sum_over_pairs(self.surface, kind, step + self.origin, u)
        result = np.empty(step.size)
        kernels.compiled.excesses(step, u, result, *profile.arguments)
        return 0.5 * result

    def parting(self) -> float:
        """Step [m] at which the last contact ends, or the load becomes negligible."""
        top = self.surface._top
        if math.isfinite(top):
            return top - self.origin
        profile = self.profile(0.0, _FAR * self._length)
        if profile is not None:
            panels = len(profile.coefficients) - profile.first
            return math.nextafter(profile.anchor + panels / profile.inverse_width, math.inf)
        step, faintest = self._length, _FAINT_LOAD * self.load_at_origin
        while self.surface._derivative_at(self.origin + step, 0) > faintest:
            step *= 1.25
        return step

    def steps_at(self, separation: ArrayLike) -> Floats:
        """Validate separations [m] and return them relative to the origin."""
        return np.asarray(self.surface._separations(separation)) - self.origin

    def step_of(self, load: float) -> float:
        """Return the step [m] at which the surface carries a load [N]."""
        if load == self.load_at_origin:
            return 0.0
        profile = self._profile
        if profile is not None and profile.span[0] <= load <= profile.span[1]:
            return float(profile.separations(np.array([load]))[0])
        return float(self.steps_of(np.array([load]), numbered=False)[0])

    def steps_of(self, load: Floats, numbered: bool = True) -> Floats:
        """Return the steps [m] of loads >= 0 [N]; for zero load, the step at which contact ends.

        With ``numbered``, error messages contain the index of the sample.
        """
        at_rest = load == self.load_at_origin
        steps = np.zeros_like(load)
        unloaded = load == 0.0
        if unloaded.any():
            top = self.surface._top
            if not math.isfinite(top):
                raise InputError(
                    "`normal_load` must stay above zero on this surface, whose heights are "
                    "unbounded, so that contact never ends; got 0"
                    + (f" at sample {int(np.argmax(unloaded))}" if numbered else "")
                )
            steps[unloaded] = top - self.origin
        loaded = ~(at_rest | unloaded)
        try:
            if loaded.all():
                return self._steps_of(load)
            if loaded.any():
                steps[loaded] = self._steps_of(load[loaded])
        except InputError as error:
            i, message = 0, error.statement
            # If any load is outside the range of the surface, the lightest or the heaviest is.
            for end in (int(np.where(loaded, load, math.inf).argmin()), int(load.argmax())):
                try:
                    self.surface.separation(load[end : end + 1])
                except InputError as refused:
                    i, message = end, refused.statement
            where = f" at sample {i}" if numbered else ""
            raise InputError(f"`normal_load` {message}{where}") from None
        return steps

    def _steps_of(self, load: Floats) -> Floats:
        lightest, heaviest = float(load.min()), float(load.max())
        profile = self._profile
        if profile is None or not (profile.span[0] <= lightest and heaviest <= profile.span[1]):
            ends = np.asarray(self.surface.separation(np.array([heaviest, lightest])))
            if load.size == 1:
                return ends[:1] - self.origin
            low, high = (ends - self.origin).tolist()
            profile = self._covering(low, high)
        low_load, high_load = (math.inf, 0.0) if profile is None else profile.span
        if profile is not None and low_load <= lightest and heaviest <= high_load:
            return profile.separations(load)
        inside = (load >= low_load) & (load <= high_load)
        steps = np.empty_like(load)
        if profile is not None:
            steps[inside] = profile.separations(load[inside])
        values, places = np.unique(load[~inside], return_inverse=True)
        steps[~inside] = (np.asarray(self.surface.separation(values)) - self.origin)[places]
        return steps


def shared_curve(surface: NormalLaw, nearest: float) -> LoadCurve:
    """Return the load curve that all contact fields on a surface share.

    Its origin is ``nearest`` [m], rounded down to a fixed grid within the span of the surface, so
    that results do not depend on the order of requests.
    """
    low, high = surface._span
    width = (high - low) / _ORIGINS
    place = (nearest - low) / width if width > 0.0 else math.inf
    if 0.0 <= place <= _ORIGINS:
        nearest = low + width * math.floor(place)
    return _shared_curve(_Identity(surface), nearest)


class _Identity:
    def __init__(self, surface: NormalLaw) -> None:
        self.surface = surface

    def __hash__(self) -> int:
        return id(self.surface)

    def __eq__(self, identity: object) -> bool:
        return isinstance(identity, _Identity) and identity.surface is self.surface


@lru_cache(maxsize=_CACHED_CURVES)
def _shared_curve(identity: _Identity, nearest: float) -> LoadCurve:
    surface = identity.surface
    low, high = surface._span
    # What is carried at the origin must be no rounding of what the surface can carry.
    faint = 1e-15 * surface._derivative_at(low, 0)
    middles = (nearest, 0.5 * (low + high))
    loaded = [place for place in middles if surface._derivative_at(place, 0) > faint]
    return LoadCurve(surface, loaded[0] if loaded else low, shared=True)
