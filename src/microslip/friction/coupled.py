"""An interface whose normal load varies while it moves."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip import normal
from microslip._core.checks import Floats, check_one_of, exact, is_whole, record, show
from microslip._core.frozen import Locked, lock
from microslip.errors import InputError
from microslip.friction.curves import curve_of
from microslip.friction.losses import Losses
from microslip.kernels.profile import Profile
from microslip.memory import Diagram, along, loads_along
from microslip.normal.base import NormalLaw
from microslip.normal.grids import sum_over_pairs

if TYPE_CHECKING:
    from microslip.kernels.twin_hold import Curve

Bools = NDArray[np.bool_]

_REACHES = 1.1 ** np.arange(-60.0, 150.0)  # decay lengths
_FAINT_LOAD = 1e-30  # of the largest load: what is lighter counts as none


class Joint(Protocol):
    """A joint whose normal load may vary, as :class:`microslip.Interface` is one."""

    @property
    def surface(self) -> NormalLaw:
        """Its normal load law."""

    @property
    def friction_coefficient(self) -> float:
        """Coefficient mu [-]."""

    @property
    def normal_load(self) -> float:
        """Its own load [N]."""

    @property
    def separation(self) -> float:
        """Its own separation [m]."""

    @property
    def normal_stiffness(self) -> float:
        """-N' there [N/m]."""

    @property
    def slip_per_indentation(self) -> float:
        """Kappa [-]."""

    @property
    def _friction(self) -> float: ...

    @property
    def _coupling(self) -> Coupling: ...


def check_surface(surface: Any) -> None:
    """Every joint stands on a normal law."""
    if not isinstance(surface, NormalLaw):
        names = ", ".join(law.__name__ for law in normal.NORMAL_LAWS)
        raise InputError(f"`surface` must be a normal load law ({names}), got {show(surface)}")


class Coupling:
    """What the memory of a varying load asks of an interface; separations count from its own."""

    def __init__(self, joint: Joint) -> None:
        self._joint = joint
        self._law = joint.surface
        self.origin = joint.separation
        self.friction = joint._friction
        self.slip = joint.slip_per_indentation
        self._profile: Profile | None = None
        self._faint = False  # whether it ends where the load is too light to matter
        self._refused: tuple[float, float] | None = None

    @cached_property
    def _losses(self) -> Losses:
        return Losses(self._law, self.origin)

    def drop(self, base: Floats, width: Floats) -> Floats:
        """N(b) - N(b + w)."""
        if base.size < 2:  # a trial, or nothing
            pairs = zip(base.tolist(), width.tolist(), strict=True)
            return np.array([self.curve.drop(b, w) for b, w in pairs])
        return sum_over_pairs(self._law, "drop", base + self.origin, width)

    def profile(self, low: float, high: float) -> Profile | None:
        """N from low to high and from there on, as a profile; None where it cannot be one.

        Where the load is less than can matter, ``high`` may lie further out.
        """
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
        """A profile, and whether it ends where the load is too light to matter."""
        law, origin = self._law, self.origin
        edge, breaks = law._edge - origin, law._breaks
        if low < edge or (breaks.size and breaks[-1] > low + origin):
            return None, False
        # A little further, so that the next record is likely to be covered, too.
        length = self._joint.normal_load / self._joint.normal_stiffness
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
        return (
            Profile.sample(
                lambda x, order: law._derivative(x + origin, order), begin, end, end + reach, edge
            ),
            faint,
        )

    def fall(self, separation: float) -> float:
        """-N' there [N/m]."""
        return -self._law._derivative_at(separation + self.origin, 1)

    def normal_stiffnesses(self, separation: Floats) -> Floats:
        """-N' at many [N/m]."""
        return -self._law._derivative(separation + self.origin, 1)

    def excess_slope(self, base: Floats, width: Floats) -> Floats:
        """Half of N(b) - N(b + w) + w N'(b + w) [N]."""
        return sum_over_pairs(self._law, "excess_slope", base + self.origin, width)

    def load(self, separation: Floats) -> Floats:
        """N there [N]."""
        return self._law._derivative(separation + self.origin, 0)

    @cached_property
    def curve(self) -> Curve:
        """N asked one separation at a time, for a law without a profile."""
        return curve_of(self._law, self.origin)

    def step_of(self, load: float) -> float:
        """Separation at one load [N]."""
        if load == self._joint.normal_load:
            return 0.0
        profile = self._profile
        if profile is not None and profile.span[0] <= load <= profile.span[1]:
            return float(profile.separations(np.array([load]))[0])
        return float(self.steps_of(np.array([load]), numbered=False)[0])

    def steps_of(self, load: Floats, numbered: bool = True) -> Floats:
        """Separations at loads >= 0 [N]; without a load, that at which the last contact parts."""
        at_rest = load == self._joint.normal_load
        steps = np.zeros_like(load)
        unloaded = load == 0.0
        if unloaded.any():
            top = self._law._top
            if not math.isfinite(top):
                raise InputError(
                    "`normal_load` must stay above zero on this surface, whose heights have no "
                    "end: at any separation some summit touches; got 0"
                    + (f" at sample {int(np.argmax(unloaded))}" if numbered else ""),
                )
            steps[unloaded] = top - self.origin
        loaded = ~(at_rest | unloaded)
        try:
            if loaded.all():
                return self._steps_of(load)
            if loaded.any():
                steps[loaded] = self._steps_of(load[loaded])
        except InputError as error:
            i, message = self._first_refused(load, loaded, str(error))
            where = f" at sample {i}" if numbered else ""
            raise InputError(f"normal_{message}{where}") from None
        return steps

    def _first_refused(self, load: Floats, selection: Bools, message: str) -> tuple[int, str]:
        """The first sample whose load the law refuses, and what the law says to it."""
        samples = np.flatnonzero(selection)

        def refusal(loads: Floats) -> str | None:
            try:
                self._law.separation(loads)
            except InputError as error:
                return str(error)
            return None

        # What refuses a load refuses all further out, but for numbers too coarse for a light one.
        def ends(upto: int) -> Floats:
            part = load[samples[:upto]]
            return np.array([part.min(), part.max()])

        def distinct(upto: int) -> Floats:
            return np.unique(load[samples[:upto]])

        loads = ends if refusal(ends(samples.size)) else distinct
        low, high = 1, samples.size
        while low < high:
            middle = (low + high) // 2
            low, high = (low, middle) if refusal(loads(middle)) else (middle + 1, high)
        i = int(samples[high - 1])
        return i, refusal(load[i : i + 1]) or message

    def _steps_of(self, load: Floats) -> Floats:
        """The same of loads that are neither none nor the joint's own."""
        lightest, heaviest = float(load.min()), float(load.max())
        profile = self._profile
        if profile is None or not (profile.span[0] <= lightest and heaviest <= profile.span[1]):
            ends = np.asarray(self._law.separation(np.array([heaviest, lightest])))
            if load.size == 1:
                return ends[:1] - self.origin
            low, high = (ends - self.origin).tolist()
            profile = self.profile(low, high)
        if profile is None:
            values, places = np.unique(load, return_inverse=True)
            return (np.asarray(self._law.separation(values)) - self.origin)[places]
        low_load, high_load = profile.span
        if low_load <= lightest and heaviest <= high_load:
            return profile.separations(load)
        steps = np.empty_like(load)
        inside = (load >= low_load) & (load <= high_load)
        steps[inside] = profile.separations(load[inside])
        values, places = np.unique(load[~inside], return_inverse=True)
        steps[~inside] = (np.asarray(self._law.separation(values)) - self.origin)[places]
        return steps

    def steps_at(self, separation: ArrayLike) -> Floats:
        """Separations as they are given [m], checked, counted from its own."""
        return np.asarray(self._law._separations(separation)) - self.origin

    def losses(
        self, separation: Floats, displacement: Floats, diagram: Diagram | None = None
    ) -> Floats:
        """Energy dissipated in each step [J] of a history from rest, or from a diagram."""
        places = displacement / self.slip
        diagram = Diagram() if diagram is None else diagram
        low, high = float(separation.min()), float(separation.max())
        profile = self.profile(min(low, diagram.separation), max(high, diagram.separation))
        with np.errstate(over="ignore", invalid="ignore"):  # fronts may be beyond all numbers
            if profile is None:
                slips = diagram.slips(separation, places)
                lost = self._losses.of(slips, places.size)
            else:
                lost = diagram.losses(separation, places, profile)
            return self.friction * self.slip * lost


@dataclass(frozen=True, eq=False)
class CoupledResponse(Locked):
    """A history of an interface under displacement and normal load, one entry a sample.

    Made by :meth:`microslip.Interface.coupled_response`, after Jaeger (1998),
    DOI 10.1115/1.2833765.
    """

    displacement: Floats
    """Displacements [m]."""
    force: Floats
    """Tangential forces [N]; 0 where the load is so light that it cannot matter.

    Heights without an end carry some load at any separation. Less than about 1e-30 of the largest
    load of the history counts as none.
    """
    normal_load: Floats
    """Normal loads [N]."""
    separation: Floats
    """Separations [m]."""
    _coupling: Coupling
    _steps: Floats
    """Separations from the joint's own [m]."""

    @cached_property
    def energy_per_step(self) -> Floats:
        """Energy dissipated on the way to each sample [J], from rest or from the one before."""
        return lock(self._coupling.losses(self._steps, self.displacement))

    @cached_property
    def dissipated_energy(self) -> Floats:
        """Energy dissipated up to each sample [J], from rest; it never falls.

        Once a periodic history has settled, the rise over a cycle is the area of its loop. In the
        first cycles the area also holds energy that is stored.
        """
        return lock(np.cumsum(self.energy_per_step))

    def energy_per_cycle(self, samples_per_cycle: int) -> Floats:
        """Energy dissipated [J] in each cycle of a periodic history.

        Cycles of so many samples are counted back from the last sample; those that begin at a
        sample, whole, count. Once the history has settled each entry is the area of its loop.
        """
        count, first = self._cycles(samples_per_cycle)
        return np.asarray(self.energy_per_step[first + 1 :].reshape(-1, count).sum(axis=1))

    def ratcheting(self, samples_per_cycle: int) -> Floats:
        """How far the displacement gets [m] in each cycle of a periodic history.

        Under force control a load that varies moves a joint on: contacts slip when it is light.
        Where the entries fade to rounding the joint has settled; where they do not, it ratchets,
        which near gross slip is physical. Cycles and errors as :meth:`energy_per_cycle`; what comes
        before the first whole cycle is left out.
        """
        count, first = self._cycles(samples_per_cycle)
        return np.diff(self.displacement[first::count])

    def _cycles(self, samples_per_cycle: int) -> tuple[int, int]:
        """Samples in a cycle, checked, and the sample at which the first whole cycle begins."""
        if not is_whole(samples_per_cycle):
            raise InputError(
                f"`samples_per_cycle` must be a whole number, got {show(samples_per_cycle)}"
            )
        count, size = int(samples_per_cycle), self.displacement.size
        if not 0 < count < size:
            raise InputError(
                f"`samples_per_cycle` must be above zero and below the {size} samples there are, "
                f"got {count}"
            )
        return count, (size - 1) % count


def forces(joint: Joint, displacement: ArrayLike, normal_load: Any, separation: Any) -> Floats:
    """See :meth:`microslip.Interface.coupled_force`."""
    x = record("displacement", displacement).reshape(-1)
    return _forces(joint._coupling, x, steps_of_history(joint, x.size, normal_load, separation))


def respond(
    joint: Joint, displacement: ArrayLike, normal_load: Any, separation: Any
) -> CoupledResponse:
    """See :meth:`microslip.Interface.coupled_response`."""
    x = record("displacement", displacement).reshape(-1)
    steps = steps_of_history(joint, x.size, normal_load, separation)
    return _response(joint, x, _forces(joint._coupling, x, steps), steps)


def respond_to_force(
    joint: Joint, force: ArrayLike, normal_load: Any, separation: Any
) -> CoupledResponse:
    """The same under force control."""
    f = record("force", force).reshape(-1)
    coupling = joint._coupling
    steps = steps_of_history(joint, f.size, normal_load, separation)
    # Of the loads as they were given: those of the separations differ from them by rounding.
    load = coupling.load(steps) if normal_load is None else np.asarray(normal_load, dtype=float)
    limit = np.broadcast_to(joint.friction_coefficient * load.reshape(-1), f.shape)
    beyond = np.flatnonzero(np.abs(f) >= limit)
    if beyond.size:
        i = int(beyond[0])
        raise InputError(
            "`force` must stay below the force limit mu N in size (no displacement holds it "
            f"beyond), got {exact(f[i])} N at sample {i}, where the limit is {limit[i]:.10g} "
            "N"
        )
    profile = coupling.profile(float(steps.min()), float(steps.max()))
    places = Diagram().hold(steps, f / coupling.friction, profile or coupling.curve)
    return _response(joint, coupling.slip * places, f, steps)


def _forces(coupling: Coupling, x: Floats, steps: Floats) -> Floats:
    profile = coupling.profile(float(steps.min()), float(steps.max()))
    values = Diagram().respond(steps, x / coupling.slip, coupling.drop, profile)
    values *= coupling.friction
    return values


def _response(joint: Joint, x: Floats, force: Floats, steps: Floats) -> CoupledResponse:
    coupling = joint._coupling
    return CoupledResponse(
        lock(x.copy()),
        lock(np.array(force)),
        lock(coupling.load(steps)),
        lock(steps + joint.separation),
        coupling,
        lock(steps),
    )


def steps_of_history(joint: Joint, size: int, normal_load: Any, separation: Any) -> Floats:
    """Separations from the joint's own along the history."""
    check_one_of("normal_load=... [N] or separation=... [m]", normal_load, separation)
    if separation is not None:
        values = along("separation", separation, size)
        return joint._coupling.steps_at(values)
    loads = loads_along("normal_load", normal_load, size)
    return joint._coupling.steps_of(loads, numbered=np.ndim(normal_load) > 0)
