"""An interface whose normal load varies while it moves."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._checks import Floats, exact, record, show
from microslip._frozen import Locked, lock
from microslip._quadrature import gauss_legendre
from microslip.errors import InputError
from microslip.friction.curves import LawCurve, SpheresCurve
from microslip.kernels.profile import Profile
from microslip.memory import Diagram, Slips, along, loads_along
from microslip.normal.grids import pairs_of

if TYPE_CHECKING:
    from microslip.friction.interface import Interface
    from microslip.kernels.twin_hold import Curve

_NODES, _WEIGHTS = gauss_legendre(24)
# Towards both ends of a run the nodes lie as of a cosine: what has a root there is smooth then.
_ANGLES = 0.5 * math.pi * _NODES
_PLACES = np.sin(_ANGLES) ** 2
_SHARES = 0.5 * math.pi * _WEIGHTS * np.sin(2.0 * _ANGLES)
_BLOCK = 1 << 14  # pieces at a time
_FEW_SUMMITS = 64
_REACHES = 1.1 ** np.arange(-60.0, 150.0)  # decay lengths
_FAINT = 1e-30  # of the largest load: what is lighter need not be resolved


class Coupling:
    """What the memory of a varying load asks of an interface; separations count from its own."""

    def __init__(self, joint: Interface) -> None:
        self._joint = joint
        self._law = joint.surface
        self._origin = joint.separation
        self.friction = joint._friction
        self.slip = joint.slip_per_indentation
        self._pairs = pairs_of(self._law)
        self._profile: Profile | None = None
        self._faint = False  # whether it ends where the load is too light to matter
        self._refused: tuple[float, float] | None = None

    def drop(self, base: Floats, width: Floats) -> Floats:
        """N(b) - N(b + w)."""
        if not base.size:
            return base
        if self._pairs is None:
            return self._law._drop(base + self._origin, width)
        return self._pairs(self._law, "drop", base + self._origin, width)

    def profile(self, low: float, high: float) -> Profile | None:
        """N from low to high and from there on, as a profile; None where it cannot be one.

        Where the load is less than can matter, ``high`` may lie further out.
        """
        known = self._profile
        if known is not None:
            if known.low <= low and high <= (math.inf if self._faint else known.high):
                return known if low <= known.high else None
            low, high = min(low, known.low), max(high, known.high)
        low, high = min(low, 0.0), max(high, 0.0)
        refused = self._refused
        if refused is not None and low <= refused[0] and high >= refused[1]:
            return None
        made, faint = self._make_profile(low, high)
        if made is None:
            self._refused = low, high
            return None
        self._profile, self._faint = made, faint
        return made

    def _make_profile(self, low: float, high: float) -> tuple[Profile | None, bool]:
        """A profile, and whether it ends where the load is too light to matter."""
        law, origin = self._law, self._origin
        edge, breaks = law._edge - origin, law._breaks
        if low < edge or (breaks.size and breaks[-1] > low + origin):
            return None, False
        # A little further, so that the next record is likely to be covered, too.
        length = self._joint.normal_load / self._joint.normal_stiffness
        more = length + 0.5 * min(high - low, 20.0 * length)
        begin, end = max(low - more, edge), high + more
        least = _FAINT * law._derivative_at(begin + origin, 0)
        faint = law._derivative_at(end + origin, 0) < least
        if faint:
            grid = begin + length * _REACHES
            end = float(grid[law._derivative(grid + origin, 0) >= least][-1])
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
        return -self._law._derivative_at(separation + self._origin, 1)

    def load(self, separation: Floats) -> Floats:
        """N there [N]."""
        return self._law._derivative(separation + self._origin, 0)

    def curve(self) -> Curve:
        """N asked one separation at a time, for a law without a profile."""
        spheres = self._law._spheres
        if spheres is not None and spheres.heights.size <= _FEW_SUMMITS:
            return SpheresCurve(spheres, self._origin)
        return LawCurve(self._law, self._origin)

    def step_of(self, load: float) -> float:
        """Separation at one load [N]."""
        if load == self._joint.normal_load:
            return 0.0
        known = self._profile
        if known is not None and known.span[0] <= load <= known.span[1]:
            return float(known.separations(np.array([load]))[0])
        return float(self.steps_of(np.array([load]))[0])

    def steps_of(self, load: Floats) -> Floats:
        """Separations at loads >= 0 [N]; without a load, that at which the last contact parts."""
        own = load == self._joint.normal_load
        steps = np.zeros_like(load)
        none = load == 0.0
        if none.any():
            top = self._law._top
            if not math.isfinite(top):
                raise InputError(
                    "normal_load must stay above zero on this surface, whose heights have no end: "
                    f"at any separation some summit touches; got 0 at sample "
                    f"{int(np.flatnonzero(none)[0])}"
                )
            steps[none] = top - self._origin
        other = ~(own | none)
        if other.all():
            return self._steps_of(load)
        if other.any():
            steps[other] = self._steps_of(load[other])
        return steps

    def _steps_of(self, load: Floats) -> Floats:
        """The same of loads that are neither none nor the joint's own."""
        lightest, heaviest = float(load.min()), float(load.max())
        known = self._profile
        if known is None or not (known.span[0] <= lightest and heaviest <= known.span[1]):
            ends = np.asarray(self._law.separation(np.array([heaviest, lightest])))
            if load.size == 1:
                return ends[:1] - self._origin
            low, high = (ends - self._origin).tolist()
            known = self.profile(low, high)
        if known is None:
            values, which = np.unique(load, return_inverse=True)
            return (np.asarray(self._law.separation(values)) - self._origin)[which]
        least, most = known.span
        if least <= lightest and heaviest <= most:
            return known.separations(load)
        steps = np.empty_like(load)
        inside = (load >= least) & (load <= most)
        steps[inside] = known.separations(load[inside])
        values, which = np.unique(load[~inside], return_inverse=True)
        steps[~inside] = (np.asarray(self._law.separation(values)) - self._origin)[which]
        return steps

    def losses(self, separation: Floats, displacement: Floats) -> Floats:
        """Energy dissipated in each step [J] of a history from rest."""
        places = displacement / self.slip
        profile = self.profile(float(separation.min()), float(separation.max()))
        with np.errstate(over="ignore", invalid="ignore"):  # fronts may be beyond all numbers
            if profile is None:
                return self.dissipated(Diagram().slips(separation, places), places.size)
            return self.friction * self.slip * Diagram().losses(separation, places, profile)

    def dissipated(self, slips: Slips, samples: int) -> Floats:
        """Energy dissipated in each step [J]: positive integrands only.

        While the front runs by dq over D, with s behind it, mu kappa (1 - s D) [N(d) - N(q) +
        N'(q) (q - d)] dq is lost.
        """
        if not slips.sample.size:
            return np.zeros(samples)
        total = np.zeros(samples)
        marks = self._law._kinks - self._origin
        block = max(1, _BLOCK // (1 + marks.size))
        for begin in range(0, slips.sample.size, block):
            part = Slips._make(column[begin : begin + block] for column in slips)
            total += np.bincount(part.sample, self._losses(part, marks), minlength=samples)
        return self.friction * self.slip * total

    def _losses(self, slips: Slips, marks: Floats) -> Floats:
        """Integral of each run, piece by piece where the front or the separation passes a mark."""
        _, start, end, density, sign, first, last = slips
        cuts = [np.zeros((start.size, 1)), np.ones((start.size, 1))]
        for low, high in ((start, end), (first, last)):
            with np.errstate(divide="ignore", invalid="ignore"):
                share = (marks - low[:, None]) / (high - low)[:, None]
            cuts.append(np.clip(np.nan_to_num(share), 0.0, 1.0))
        edges = np.sort(np.concatenate(cuts, axis=1), axis=1)
        run, piece = np.nonzero(np.diff(edges, axis=1) > 0.0)
        low, width = edges[run, piece], np.diff(edges, axis=1)[run, piece]
        u = low[:, None] + width[:, None] * _PLACES
        q = start[run, None] + u * (end - start)[run, None]
        d = first[run, None] + u * (last - first)[run, None]
        gap = np.maximum(q - d, 0.0).ravel()
        separation = (d + self._origin).ravel()
        if self._pairs is None:
            heights = self._law._excess_slope(separation, gap).reshape(u.shape)
        else:
            heights = self._pairs(self._law, "excess_slope", separation, gap).reshape(u.shape)
        value = np.bincount(run, width * (heights @ _SHARES), minlength=start.size)
        return np.asarray(2.0 * (end - start) * (1.0 - sign * density) * value)


@dataclass(frozen=True, eq=False)
class CoupledResponse(Locked):
    """A history of an interface under displacement and normal load, one entry a sample.

    Made by :meth:`microslip.Interface.coupled_response`, after Jaeger (1998),
    DOI 10.1115/1.2833765.
    """

    displacement: Floats
    """Displacements [m]."""
    force: Floats
    """Tangential forces [N]."""
    normal_load: Floats
    """Normal loads [N]."""
    separation: Floats
    """Separations [m]."""
    _coupling: Coupling
    _steps: Floats
    """Separations from the joint's own [m]."""

    @cached_property
    def dissipated_energy(self) -> Floats:
        """Energy dissipated up to each sample [J], from rest; it never falls.

        Once a periodic history has settled, the rise over a cycle is the area of its loop. In the
        first cycles the area also holds energy that is stored.
        """
        return lock(np.cumsum(self._coupling.losses(self._steps, self.displacement)))

    def ratcheting(self, samples_per_cycle: int) -> Floats:
        """How far the displacement gets in each cycle of a periodic history.

        Under force control a load that varies moves a joint on: contacts slip when it is light.
        Where the entries fade to rounding the joint has settled; where they do not, it ratchets,
        which near gross slip is physical.

        Parameters
        ----------
        samples_per_cycle : int
            Samples in a cycle; cycles are counted back from the last sample.

        Returns
        -------
        ndarray
            Displacement at the end of each whole cycle less that at its beginning [m]. What comes
            before the first whole cycle is left out.

        Raises
        ------
        InputError
            Not a whole number above zero, or no more samples than one cycle has.
        """
        if isinstance(samples_per_cycle, bool) or not isinstance(
            samples_per_cycle, (int, np.integer)
        ):
            raise InputError(
                f"samples_per_cycle must be a whole number, got {show(samples_per_cycle)}"
            )
        count, size = int(samples_per_cycle), self.displacement.size
        if not 0 < count < size:
            raise InputError(
                f"samples_per_cycle must be above zero and below the {size} samples there are, "
                f"got {count}"
            )
        return np.diff(self.displacement[(size - 1) % count :: count])


def forces(joint: Interface, displacement: ArrayLike, normal_load: Any, separation: Any) -> Floats:
    """See :meth:`microslip.Interface.coupled_force`."""
    x = record("displacement", displacement).reshape(-1)
    return _forces(joint._coupling, x, _steps(joint, x.size, normal_load, separation))


def respond(
    joint: Interface, displacement: ArrayLike, normal_load: Any, separation: Any
) -> CoupledResponse:
    """See :meth:`microslip.Interface.coupled_response`."""
    x = record("displacement", displacement).reshape(-1)
    steps = _steps(joint, x.size, normal_load, separation)
    return _response(joint, x, _forces(joint._coupling, x, steps), steps)


def respond_to_force(
    joint: Interface, force: ArrayLike, normal_load: Any, separation: Any
) -> CoupledResponse:
    """The same under force control."""
    f = record("force", force).reshape(-1)
    coupling = joint._coupling
    steps = _steps(joint, f.size, normal_load, separation)
    # Of the loads as they were given: those of the separations differ from them by rounding.
    load = coupling.load(steps) if normal_load is None else np.asarray(normal_load, dtype=float)
    limit = np.broadcast_to(joint.friction_coefficient * load.reshape(-1), f.shape)
    beyond = np.flatnonzero(np.abs(f) >= limit)
    if beyond.size:
        i = int(beyond[0])
        raise InputError(
            "force must stay below the force limit mu N in size (no displacement holds it beyond), "
            f"got {exact(f[i])} N at sample {i}, where the limit is {limit[i]:.10g} N"
        )
    profile = coupling.profile(float(steps.min()), float(steps.max()))
    places = Diagram().hold(steps, f / coupling.friction, profile or coupling.curve())
    return _response(joint, coupling.slip * places, f, steps)


def _forces(coupling: Coupling, x: Floats, steps: Floats) -> Floats:
    profile = coupling.profile(float(steps.min()), float(steps.max()))
    values = Diagram().respond(steps, x / coupling.slip, coupling.drop, profile)
    values *= coupling.friction
    return values


def _response(joint: Interface, x: Floats, force: Floats, steps: Floats) -> CoupledResponse:
    coupling = joint._coupling
    return CoupledResponse(
        lock(x.copy()),
        lock(np.array(force)),
        lock(coupling.load(steps)),
        lock(steps + joint.separation),
        coupling,
        lock(steps),
    )


def _steps(joint: Interface, size: int, normal_load: Any, separation: Any) -> Floats:
    """Separations from the joint's own along the history."""
    if (normal_load is None) == (separation is None):
        came = "neither" if normal_load is None else "both"
        raise InputError(
            f"normal_load=... [N] or separation=... [m] must be given, one of them, got {came}"
        )
    if separation is not None:
        values = along("separation", separation, size)
        return np.asarray(joint.surface._separations(values)) - joint.separation
    return joint._coupling.steps_of(loads_along("normal_load", normal_load, size))
