"""Base class of normal load laws N(d), the only part of the model that depends on the surface.

Equation numbers (19.x) are those of chapter 19, DOI 10.1007/978-3-319-56818-8_19.
"""

from __future__ import annotations

import dataclasses
import math
from abc import ABC, abstractmethod
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core import quadrature
from microslip._core.checks import LARGEST, Floats, exact, floats, plain, show
from microslip._core.errors import InputError
from microslip._core.parameters import Parametric
from microslip.contact.materials import Material, MaterialPair
from microslip.contact.spheres import DROP, EXCESS, EXCESS_SLOPE, FALL, Spheres
from microslip.contact.spline import Spline

MEAN_PRESSURE = "mean contact pressure over hardness"
"""Name of the quantity that a rule checks for laws with a contact area but without summits."""
YIELD = "Hertz pressure over that of first yield"
"""Name of the quantity that a rule checks for one sphere."""
OVER_HARDNESS = "tightening pressure over hardness"
CONTACT_POINTS = "points in contact"
SCATTER = "scatter of the pieces"
BETWEEN = "height variance between pieces"
RESOLUTION = "change of stiffness by pixel and cut-off"
"""Names of the quantities that the rules check for a measured face."""

LARGEST_PRESSURE = 0.7
"""Mean pressure over hardness above which nearly all of a face has yielded."""
FEWEST_POINTS = 100
"""Number of points in contact below which a grid does not resolve the contacts."""


def plasticity_index(pair: MaterialPair, spread: float, radius: float) -> dict[str, float | None]:
    """Return {rule name: plasticity index (E*/H) sqrt(spread/radius) [-]}.

    Greenwood and Williamson (1966, DOI 10.1098/rspa.1966.0242), with the standard deviation of the
    summit heights ``spread`` and the summit radius ``radius`` [m]. The dict is empty if ``spread``
    is zero; the index is None if the pair has no hardness.
    """
    if not spread > 0.0:
        return {}
    if pair.hardness is None:
        return {"plasticity index": None}
    return {"plasticity index": pair.composite_modulus / pair.hardness * math.sqrt(spread / radius)}


def sparse_contacts(
    surface: Any, area: float, spread: float, radius: float, separation: float | None
) -> dict[str, float | None]:
    """Return the quantities that four validity rules check, by rule name.

    They are density * radius * spread, real over apparent area, rms contact radius over summit
    spacing, and the number of contacts. ``surface`` must have a summit count, a contact count and a
    contact area; ``area`` is the apparent area [m^2], ``spread`` the standard deviation of the
    summit heights [m] and ``radius`` their radius [m]. A separation of None means that nothing
    touches.
    """
    real, count = 0.0, 0.0
    if separation is not None:
        real = float(surface.contact_area(separation))
        count = float(surface.contact_count(separation))
    density = surface.summit_count / area
    mean_square = real / (math.pi * count) if count > 0.0 else 0.0
    return {
        "density * radius * std": density * radius * spread,
        "real over apparent area": real / area,
        "contact radius over summit spacing": math.sqrt(mean_square * density),
        "contacts": count,
    }


def check_pair(pair: Any) -> None:
    """Raise an InputError unless the argument is a MaterialPair."""
    if not isinstance(pair, MaterialPair):
        raise InputError(
            f"`pair` must be a MaterialPair, got {show(pair)}; write "
            "MaterialPair(Material(69e9, 0.33), Material(69e9, 0.33))"
        )


FAINTEST = 1e-290
"""Load [N] below which products may underflow."""


class NormalLaw(Parametric, ABC):
    """Normal load N of an interface against the separation d of its faces: decreasing and convex.

    A subclass is a frozen dataclass with a field ``pair``; it implements :meth:`_derivative` and
    :attr:`_span`. Optional are :attr:`_edge` and :attr:`_breaks`, if N'' is not smooth, and
    :meth:`contact_count` and :meth:`contact_area`. On first loading to the displacement delta the
    tangential force is T0 = mu [N(d) - N(d + delta/kappa)], with the friction coefficient mu and
    the slip per indentation kappa = mu k_n/k_t (Jaeger 1998, DOI 10.1115/1.2833765; Ciavarella
    1998, J. Appl. Mech. 65, 998), see :class:`microslip.Interface`.

    A law may yield: then the face was flattened permanently by the largest load that it has
    carried, the *tightening load*, and N(d) is its law on unloading from that load.
    """

    pair: MaterialPair

    def __post_init__(self) -> None:
        check_pair(self.pair)
        self._check_parameters()

    @abstractmethod
    def _derivative(self, separation: Floats, order: int) -> Floats:
        """Derivative of N of order 0 (N itself) to 2; -1: integral of N from d to infinity."""

    def _assumptions(self, separation: float | None) -> dict[str, float | None]:
        """Quantities that the validity rules check, by rule name; None where unknown.

        A separation [m] of None means that nothing touches.
        """
        return {}

    def _slip_measure(self) -> tuple[float, str] | None:
        """Width of the summit heights [m] and its description; None for a law without heights.

        The width times the slip per indentation is the displacement scale of slip.
        """
        return None

    def _standardised(self, separation: float) -> float | None:
        """Separation over the rms height [-]; None for a law without heights."""
        return None

    def _derivative_at(self, separation: float, order: int) -> float:
        return float(self._derivative(np.array([separation]), order)[0])

    @property
    @abstractmethod
    def _span(self) -> tuple[float, float]:
        """Separations [m] at which most (first) and hardly any (second) summits touch."""

    @property
    def _edge(self) -> float:
        """Separation [m] at which the lowest summit touches, if N'' has a kink there; else -inf."""
        return -math.inf

    @property
    def _breaks(self) -> Floats:
        """Separations [m], increasing: kinks of N'' and points near them, to split integrals."""
        return np.zeros(0)

    @property
    def _small_kinks(self) -> Floats:
        """Separations [m] of the kinks of N'' if they are too many to split at each; else empty."""
        return np.zeros(0)

    @property
    def _top(self) -> float:
        """Separation [m] at which the last contact ends; infinite if contact never ends."""
        return math.inf if self._spheres is None else float(self._spheres.heights[0])

    @cached_property
    def _deepest(self) -> float:
        """Smallest valid separation [m], at which summits are indented by their radius."""
        radius = getattr(self, "radius", getattr(self, "radii", None))
        return -LARGEST if radius is None else self._span[0] - float(np.max(radius))

    @property
    def _heaviest(self) -> float:
        """Largest load of the law [N]; infinite if there is no limit."""
        return math.inf

    @property
    def _kinks(self) -> Floats:
        """Separations [m], increasing, of all kinks of N''; empty for given summits.

        Given summits have N'' infinite at each summit, and are summed summit by summit.
        """
        edge = [self._edge] if math.isfinite(self._edge) else []
        return np.union1d(self._breaks, edge)

    @property
    def _spheres(self) -> Spheres | None:
        """Individually given summits; None for all other laws."""
        return None

    @property
    def _spline(self) -> Spline | None:
        """N as a polynomial between :attr:`_kinks`; None for all laws but tables."""
        return None

    @property
    def stiffness_ratio(self) -> float:
        """Normal over tangential stiffness of the contacts [-]; E*/(4 G*) for round contacts."""
        return self.pair.stiffness_ratio

    @property
    def _lay(self) -> Floats | None:
        """Tangential stiffness tensor over its value in the direction of motion [-], (2, 2).

        The first axis is the direction of motion. None for an isotropic surface.
        """
        return None

    def along(self, direction: float | None) -> NormalLaw:
        """Return the surface for motion in a direction [rad]; None is the mean over all directions.

        Subclasses define the axis from which it is measured; a law without a lay raises InputError.
        """
        if direction is None:
            return self
        raise InputError(
            f"`direction` must be omitted: a {type(self).__name__} has no lay; a MeasuredContact "
            "has one"
        )

    def _check_rest(self, loads: Floats) -> None:
        """Raise an InputError if loads of the joint at rest [N] are too large for the law."""

    def _tightened_by(self, shares: Floats) -> tuple[Floats, Floats] | None:
        """Return factors [-] and offsets [m] of the separation of less tightened faces.

        A face like this one, but tightened only to the fraction s of its tightening load, carries
        s N((d - offset)/factor) at separation d. ``shares`` are the values of s [-]. None for a law
        that does not yield.
        """
        return None

    @property
    def _first(self) -> NormalLaw:
        """Law of first loading, before any unloading; this law if it does not yield."""
        return self

    def _under(self, load: float) -> NormalLaw:
        """Return the law after tightening to ``load`` [N]; this law if it does not yield then."""
        return self

    @property
    def _scales(self) -> dict[str, tuple[float, float, float]] | None:
        """Sensitivities of C and L in N = C F(d/L); None for a law without this form.

        They are {name of a parameter: (its value p, d ln C/d ln p [-], d ln L/d ln p [-])}; the
        function F is independent of all parameters.
        """
        return None

    def _patch(self, area: float, tightening: float) -> NormalLaw:
        """Return this law with another apparent area [m^2] and tightening pressure.

        The new pressure is ``tightening`` [-] times that of this law, if it has one.
        """
        if not any(item.name == "area" for item in dataclasses.fields(self)):  # type: ignore[arg-type]
            raise InputError(
                "`surface` must have an apparent area over which a pressure is spread, as a "
                f"GreenwoodWilliamson surface has, got {type(self).__name__}"
            )
        return dataclasses.replace(self, area=area)  # type: ignore[type-var]

    def load(self, separation: ArrayLike) -> Any:
        """Compute the normal load N(d) (19.8).

        Parameters
        ----------
        separation : array_like
            Separations d [m] of the rigid plane from the zero of the heights, any shape.

        Returns
        -------
        float or ndarray
            Loads [N], shape of ``separation``.

        Raises
        ------
        InputError
            If a separation is not finite, or so small that it is outside the range of the law.
        """
        return plain(self._derivative(self._separations(separation), 0), separation)

    def stiffness(self, separation: ArrayLike) -> Any:
        """Normal stiffness -N'(d) [N/m] for separations of any shape; raises as :meth:`load`."""
        return plain(-self._derivative(self._separations(separation), 1), separation)

    def separation(self, load: ArrayLike) -> Any:
        """Compute the separation d at which the interface carries a load; inverse of :meth:`load`.

        Parameters
        ----------
        load : array_like
            Loads [N], above zero, any shape.

        Returns
        -------
        float or ndarray
            Separations [m], shape of ``load``, accurate to rounding.
        """
        loads = floats("load", load, "N")
        lightest, heaviest = float(loads.min()), float(loads.max())
        if lightest <= 0.0:
            raise InputError(f"`load` must be above zero [N], got {exact(lightest)}")
        if not (lightest >= FAINTEST and heaviest <= LARGEST):
            worst = heaviest if heaviest > LARGEST else lightest
            raise InputError(
                f"`load` must be between {FAINTEST:g} and {LARGEST:g} [N], got {exact(worst)}"
            )
        places = self._solve(loads.reshape(-1))
        if places.min() < self._deepest:
            raise InputError(
                f"`load` must be one that the surface can carry, got {exact(heaviest)} N, which "
                "would indent its summits by more than their radius"
            )
        return plain(places.reshape(loads.shape), load)

    # -- contacts ---------------------------------------------------------------------------

    def contact_probability(self, separation: ArrayLike) -> Any:
        """Probability that a summit is in contact (19.5), for separations [m] of any shape.

        Raises InputError for laws without summits, as do `contact_count` and `contact_area`.
        """
        raise self._unknown("contact_probability")

    def contact_count(self, separation: ArrayLike) -> Any:
        """Number of summits in contact (19.6), for separations [m] of any shape."""
        raise self._unknown("contact_count")

    def contact_area(self, separation: ArrayLike) -> Any:
        """Real contact area [m^2] (19.7), for separations [m] of any shape."""
        raise self._unknown("contact_area")

    def _unknown(self, name: str) -> InputError:
        return InputError(
            f"{type(self).__name__} has no {name}: it has loads only; "
            "use a GreenwoodWilliamson surface or an AsperityPopulation"
        )

    # -- for the interface -------------------------------------------------------------------

    # Their steps are one-dimensional; d is one separation for all of them or one for each.

    @property
    def _by_pieces(self) -> quadrature.Kinked | None:
        kinks = self._small_kinks
        return quadrature.Kinked(self, kinks) if kinks.size else None

    def _drop(self, d: Floats | float, u: Floats) -> Floats:
        """Decrease of load N(d) - N(d + u) [N] for increments u >= 0 [m], without cancellation."""
        if self._spheres is not None:
            return self._spheres.sum(DROP, d, u)
        return quadrature.drop(self, d, u, self._by_pieces)

    def _fall(self, d: Floats | float, u: Floats) -> Floats:
        """Normal stiffness -N'(d + u) [N/m] for increments u >= 0 [m] of the separation."""
        if self._spheres is not None:
            return self._spheres.sum(FALL, d, u)
        return -self._derivative(d + u, 1)

    def _excess(self, d: Floats | float, u: Floats) -> Floats:
        """Return half the integral of v (u - v) N''(d + v) dv over 0 <= v <= u [N m]."""
        if self._spheres is not None:
            return self._spheres.sum(EXCESS, d, u)
        return quadrature.excess(self, d, u, self._by_pieces)

    def _excess_slope(self, d: Floats | float, u: Floats) -> Floats:
        """Return half the integral of v N''(d + v) dv over 0 <= v <= u [N]."""
        if self._spheres is not None:
            return self._spheres.sum(EXCESS_SLOPE, d, u)
        return quadrature.excess_slope(self, d, u, self._by_pieces)

    def _corners(self, d: float) -> tuple[Floats, Floats]:
        """Increments of the separation from d [m] at which N' jumps, and the jumps [N/m]."""
        return np.zeros(0), np.zeros(0)

    def _table_reach(self, d: float) -> float | None:
        """Increment u [m] up to which N(d + u) must be tabulated; None if it is not smooth in u."""
        if self._spheres is not None or d < self._edge:
            return None
        _, length = quadrature._decay(self, d)
        steps = length * _REACHES
        gone = self._derivative(d + steps, 0) <= 3e-17 * self._derivative(np.array([d]), 0)
        return float(steps[np.argmax(gone)]) if gone.any() else None

    # -- checks and the inverse ---------------------------------------------------------------

    def _separations(self, value: ArrayLike) -> Floats:
        d = floats("separation", value, "m")
        if d.min() < self._deepest:
            raise InputError(
                f"`separation` must be at least {self._deepest:g} [m], where summits are indented "
                f"by their radius, got {d.min():g}"
            )
        return np.minimum(d, LARGEST)  # where nothing has touched for long

    def _solve(self, loads: Floats) -> Floats:
        """Solve N(d) = load for d [m] by Newton's method on ln N, with a bracket for each load.

        The brackets ensure convergence where ln N is not concave, as is possible for a table.
        """
        low, high = self._span
        scale = max(high - low, 1e-12)
        top = float(loads.max())
        for _ in range(200):
            if self._derivative_at(low, 0) >= top:
                break
            low -= scale
            scale *= 2.0
        else:
            raise InputError(f"`load` must be one that the surface can carry, got {top:g} N")
        lightest = self._derivative_at(high, 0)
        if loads.min() < lightest:
            raise InputError(
                f"`load` must be at least {lightest:.3g} N, the lightest that this surface "
                f"resolves, got {exact(loads.min())} N"
            )
        grid = np.linspace(low, high, 65)
        with np.errstate(divide="ignore"):
            heights = np.log(self._derivative(grid, 0))
        target = np.log(loads)
        right = np.clip(np.searchsorted(-heights, -target, side="left"), 1, 64)
        below, above = grid[right - 1], grid[right]
        # Within a bracket log N is nearly straight; at its empty end it is not.
        first, last = heights[right - 1], np.maximum(heights[right], heights[right - 1] - 40.0)
        share = np.clip((first - target) / np.where(first > last, first - last, 1.0), 0.0, 1.0)
        d = below + share * (above - below)
        active = np.arange(loads.size)
        for _ in range(500):
            here = d[active]
            with np.errstate(divide="ignore", invalid="ignore"):
                load = self._derivative(here, 0)
                miss = np.log(load / loads[active])
                length = load / -self._derivative(here, 1)
                step = miss * length
            heavy = miss > 0.0
            below[active] = np.where(heavy, here, below[active])
            above[active] = np.where(heavy, above[active], here)
            new = here + step
            inside = (new >= below[active]) & (new <= above[active])
            new = np.where(inside, new, 0.5 * (below[active] + above[active]))
            d[active] = new
            # Once a step is that small the next would be its square: below rounding.
            width = np.fmax(np.where(inside, 1e-9 * length, 0.0), 4e-16 * np.abs(new))
            going = (np.abs(new - here) > width) & (miss != 0.0)
            active = active[going]
            if active.size == 0:
                break
        self._check_fine(d, loads)
        return d

    def _check_fine(self, d: Floats, loads: Floats) -> None:
        off = np.abs(self._derivative(d, 0) - loads) > 1e-9 * loads
        if off.any():
            raise InputError(
                "`load` must be large enough for separations in double precision on this "
                f"surface, got {exact(loads[off][0])} N"
            )

    @classmethod
    def examples(cls) -> tuple[NormalLaw, ...]:
        """Return instances of the class for the shared tests; empty for an abstract class."""
        return ()


_REACHES = 1.25 ** np.arange(-4.0, 48.0)


def aluminium() -> MaterialPair:
    """Return the material pair of the samples of chapter 19: aluminium 2017 on itself."""
    metal = Material(young_modulus=69e9, poisson_ratio=0.33)
    return MaterialPair(metal, metal)
