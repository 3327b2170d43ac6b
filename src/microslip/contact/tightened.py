"""A surface whose summits have yielded once: plastic when tightened, elastic afterwards."""

from __future__ import annotations

import dataclasses
import math
from abc import abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, exact, plain, positive
from microslip._core.errors import InputError
from microslip._core.frozen import made_once
from microslip._core.quadrature import gauss_legendre
from microslip.contact.base import NormalLaw, aluminium, sparse_contacts
from microslip.contact.elastic_plastic import (
    HARDNESS_RATIO,
    SummitModel,
    flattening,
    indentation_of,
    model_of,
    recovery,
    recovery_slope,
)
from microslip.contact.heights import Discrete, Gaussian, HeightDistribution
from microslip.contact.heights.density import DensityHeights
from microslip.contact.materials import MaterialPair
from microslip.contact.spheres import DERIVATIVES, Spheres

_NODES, _WEIGHTS = gauss_legendre(24)
_GRID = 33  # first panels over the span of the heights


class RecoveredHeights(DensityHeights):
    """Heights of the relieved summits, weighted by a power of their flattening.

    A summit of height y, pressed to s = y - d_min, ends at d_min + recovery(s). With the weight
    sqrt(R'/R) the partial moments are those of a surface of the one radius R.
    """

    def __init__(
        self,
        heights: HeightDistribution,
        closest: float,
        model: SummitModel,
        radius: float,
        power: int,
    ) -> None:
        self._heights, self._closest, self._model = heights, closest, model
        self._unit = model.yield_indentation * radius
        self._power = power
        self.edge = max(closest, heights.edge)

    def at_power(self, power: int, radius: float) -> RecoveredHeights:
        """The same heights with another weight: 0 counts summits, 2 their areas."""
        return RecoveredHeights(self._heights, self._closest, self._model, radius, power)

    @cached_property
    def _indentations(self) -> Floats:
        """Indentations [m] at tightening where the density is not smooth, or is cut for panels."""
        low, high = self._heights.span
        grid = np.linspace(low, high, _GRID) - self._closest
        breaks = self._heights._breaks - self._closest
        kinks = self._unit * np.array(self._model.edges)
        edges = np.unique(np.concatenate((grid, breaks, kinks, [low - self._closest])))
        top = high - self._closest
        bottom = max(low - self._closest, 0.0)
        return np.unique(np.concatenate(([bottom, top], edges[(edges > bottom) & (edges < top)])))

    @cached_property
    def _edges(self) -> Floats:
        return self._closest + self._unit * recovery(self._indentations / self._unit)

    @property
    def spread(self) -> float:
        """Spread of the heights of the summits before they yielded [m]."""
        return self._heights.spread

    @cached_property
    def span(self) -> tuple[float, float]:
        """From the closest separation to the highest of the relieved summits [m]."""
        return float(self._edges[0]), float(self._edges[-1])

    def _pdf(self, y: Floats) -> Floats:
        recovered = (y - self._closest) / self._unit
        r = indentation_of(np.maximum(recovered, 0.0))
        density = self._heights._density(self._closest + self._unit * r) / recovery_slope(r)
        weight = flattening(self._model, r) ** self._power
        return np.asarray(np.where(recovered >= 0.0, density * weight, 0.0))


@dataclass(frozen=True, eq=False)
class TightenedSurface(NormalLaw):
    """A rough surface that was pressed together once and is elastic since, up to that load.

    Made by ``surface.tightened(...)``. Relieved from a yielded state a summit is elastic with the
    shape it kept, lower by its residual indentation and flatter; so the surface is an elastic
    population again, and everything tangential follows from its N(d) as from any other.

    Parameters
    ----------
    pair : MaterialPair
        The two materials.
    heights : HeightDistribution
        Heights of the summits before [m].
    radius : float or ndarray
        Their radius [m]; one for each of given summits.
    summit_count : float
        Number of all summits.
    tightening_load : float
        Largest normal load it has carried [N].
    yield_stress : float
        Uniaxial yield stress of the softer body [Pa].
    model : str
        "jackson-green", "kogut-etsion" or "fully-plastic".
    area : float, optional
        Apparent area [m^2].

    Notes
    -----
    After Jackson and Green (2005), DOI 10.1115/1.1866166, for the way in, and Etsion, Kligerman and
    Kadin (2005, Int. J. Solids Struct. 42, 3716) for what a summit keeps of it. Loads above the
    tightening load are plastic again: a joint under one stands on the surface tightened to it.
    Loads that vary must stay below. Junction growth is not covered.
    """

    pair: MaterialPair
    heights: HeightDistribution
    radius: Any
    summit_count: float
    tightening_load: float
    yield_stress: float
    model: str = "jackson-green"
    area: float | None = None

    def __post_init__(self) -> None:
        for name, unit in (("tightening_load", "N"), ("yield_stress", "Pa")):
            object.__setattr__(self, name, positive(name, getattr(self, name), unit))
        _ = self._model  # another name is an error now, not later

    @cached_property
    def _model(self) -> SummitModel:
        return model_of(self.model, self.pair, self.yield_stress)

    @cached_property
    def _stiff(self) -> Floats:
        """Weights of the Hertz constant (4/3) E* sqrt(R) [N/m^1.5] of each summit, all alike."""
        return np.asarray(4.0 / 3.0 * self.pair.composite_modulus * np.sqrt(self.radius))

    # -- tightening -------------------------------------------------------------------------------

    @cached_property
    def closest_separation(self) -> float:
        """Separation d_min [m] that was reached at the tightening load."""
        low, high = self.heights.span
        scale = max(high - low, 1e-12)
        for _ in range(200):
            if self._loading(low) >= self.tightening_load:
                break
            high, low, scale = low, low - scale, 2.0 * scale
        else:
            raise InputError(
                "`normal_load` must be one that the surface can carry, got "
                f"{exact(self.tightening_load)} N"
            )
        return self._bisect(low, high)

    def _bisect(self, low: float, high: float) -> float:
        """Separation of the tightening load on the way in: regula falsi on its logarithm."""

        def miss(d: float) -> float:
            load = self._loading(d)
            return math.log(load / self.tightening_load) if load > 0.0 else -700.0

        above, below, side = miss(low), miss(high), 0
        for _ in range(200):
            middle = (low * below - high * above) / (below - above) if above != below else low
            if not low < middle < high:
                middle = 0.5 * (low + high)
            here = miss(middle)
            if here == 0.0 or high - low <= 4e-16 * max(abs(low), abs(high)):
                return middle
            if here > 0.0:
                low, above = middle, here
                below *= 0.5 if side == 1 else 1.0
                side = 1
            else:
                high, below = middle, here
                above *= 0.5 if side == -1 else 1.0
                side = -1
        return 0.5 * (low + high)

    def _loading(self, d: float, power: int = 0) -> float:
        """Elastic-plastic load [N] on the way in, at a separation.

        Each summit's counts as often as a power of its indentation over that at first yield says.
        """
        units = self._model.yield_indentation * np.asarray(self.radius)
        at_yield = self._stiff * units**1.5
        if isinstance(self.heights, Discrete):
            r = np.maximum(np.asarray(self.heights.values) - d, 0.0) / units
            loads = at_yield * self._model.load_of(r) * r**power
            return float(np.sum(loads) * self.summit_count / r.size)
        edges = self._recovered_at(d)._indentations
        # In the root of the indentation, where the load begins like its cube.
        root = np.sqrt(edges)
        z = root[:-1, None] + np.diff(root)[:, None] * _NODES
        s = z * z
        density = self.heights._density(d + s)
        load = self._model.load_of(s / units) * at_yield * (s / units) ** power
        sums = (2.0 * z * density * load) @ _WEIGHTS
        return float(self.summit_count * (sums @ np.diff(root)))

    def _recovered_at(self, closest: float) -> RecoveredHeights:
        return RecoveredHeights(self.heights, closest, self._model, float(self.radius), 1)

    @cached_property
    def yielded_share(self) -> float:
        """Share of the contacts at tightening that yielded [-]."""
        d = self.closest_separation
        units = self._model.yield_indentation * np.asarray(self.radius)
        if isinstance(self.heights, Discrete):
            depth = np.asarray(self.heights.values) - d
            touching = int(np.count_nonzero(depth > 0.0))
            return float(np.count_nonzero(depth > units)) / touching if touching else 0.0
        touching_share = self.heights._moment_at(0, d)
        if touching_share <= 0.0:
            return 0.0
        return self.heights._moment_at(0, d + float(units)) / touching_share

    # -- relieved ---------------------------------------------------------------------------------

    @cached_property
    def _recovered(self) -> RecoveredHeights:
        return self._recovered_at(self.closest_separation)

    @cached_property
    def mean_indentation(self) -> float:
        """Indentation over that at first yield, at tightening, in the mean over the load [-]."""
        d = self.closest_separation
        return self._loading(d, 1) / self._loading(d)

    def _assumptions(self, separation: float | None) -> dict[str, float | None]:
        values: dict[str, float | None] = {}
        if self.area is not None:  # given summits, without an area, are all there are
            radius = float(np.mean(self.radius))
            values = sparse_contacts(self, self.area, self.heights.spread, radius, separation)
            # Junctions have met once where they met at tightening.
            tightest = float(self.contact_area(self.closest_separation)) / self.area
            values["real over apparent area at tightening"] = tightest
        return {**values, "indentation over yield": self.mean_indentation}

    def _under(self, load: float) -> NormalLaw:
        """The same once tightened anew, where a load [N] makes summits yield further."""
        if load <= self.tightening_load * (1.0 + 1e-12):
            return self
        return dataclasses.replace(self, tightening_load=load)

    def tightened(self, normal_load: float, **how: Any) -> NormalLaw:
        """The surface after another tightening to a load [N]; the largest of all counts."""
        if how:
            raise InputError(
                f"`{next(iter(how))}` is that of the first tightening, {self!r}; leave it out"
            )
        return self._under(positive("normal_load", normal_load, "N", 5000.0))

    def _patch(self, area: float, share: float) -> NormalLaw:
        """A part, which bore its share of the load that tightened the whole."""
        if self.area is None:
            raise InputError("`surface` must have an apparent area over which a pressure is spread")
        count, load = self.summit_count * (area / self.area), self.tightening_load * share
        return dataclasses.replace(self, area=area, summit_count=count, tightening_load=load)

    def _standardised(self, separation: float) -> float | None:
        return self.heights._standardised(separation)

    def _slip_measure(self) -> tuple[float, str] | None:
        name = self.heights._spread_name
        return (self.heights.spread, name) if name else None

    @cached_property
    def _relieved(self) -> tuple[Floats, Floats]:
        """Heights and flattenings of given summits after tightening."""
        values = np.asarray(self.heights.values)  # type: ignore[attr-defined]
        units = self._model.yield_indentation * np.asarray(self.radius)
        r = (values - self.closest_separation) / units
        heights = np.where(r > 1.0, self.closest_separation + units * recovery(r), values)
        return heights, flattening(self._model, r)

    @cached_property
    def _spheres(self) -> Spheres | None:
        if not isinstance(self.heights, Discrete):
            return None
        heights, flat = self._relieved
        stiff = np.broadcast_to(self._stiff, flat.shape) * flat
        return Spheres(heights, stiff * (self.summit_count / flat.size))

    @property
    def _heaviest(self) -> float:
        return self.tightening_load

    @property
    def _constant(self) -> float:
        return float(self.summit_count * self._stiff)

    @property
    def _span(self) -> tuple[float, float]:
        if self._spheres is not None:
            return self.closest_separation, float(self._spheres.heights[0])
        return self._recovered.span

    @property
    def _edge(self) -> float:
        return -math.inf if self._spheres is not None else self.closest_separation

    @property
    def _top(self) -> float:
        return self._span[1] if math.isfinite(self.heights.top) else math.inf

    @property
    def _small_kinks(self) -> Floats:
        return np.zeros(0) if self._spheres is not None else self._recovered._breaks

    def _separations(self, value: ArrayLike) -> Floats:
        d = super()._separations(value)
        self._check_relieved(d)
        return np.maximum(d, self.closest_separation)

    def _check_relieved(self, d: Floats) -> None:
        closest = self.closest_separation
        if d.size and float(d.min()) < closest - 1e-9 * self.heights.spread:
            raise InputError(
                f"`separation` must be at least {closest:.6g} m, that of the tightening load "
                f"{self.tightening_load:.6g} N (closer the summits yield again), got "
                f"{d.min():.6g}"
            )

    def _derivative(self, separation: Floats, order: int) -> Floats:
        if self._spheres is not None:
            return self._spheres.derivative(separation, order)
        self._check_relieved(separation)
        moment = self._recovered._moment(3 - 2 * order, separation)
        return (DERIVATIVES[order] * self._constant) * moment

    def _solve(self, loads: Floats) -> Floats:
        heaviest = float(loads.max())
        if heaviest > self.tightening_load * (1.0 + 1e-12):
            raise InputError(
                f"`load` must be at most the tightening load {self.tightening_load:.10g} N "
                f"(above it the summits yield again), got {exact(heaviest)} N"
            )
        # What the tables round of the largest load must not ask for a closer separation.
        return super()._solve(np.minimum(loads, self._derivative_at(self.closest_separation, 0)))

    def contact_probability(self, separation: ArrayLike) -> Any:
        """Probability that a summit is in contact, for separations [m] of any shape."""
        return plain(np.asarray(self.contact_count(separation)) / self.summit_count)

    def contact_count(self, separation: ArrayLike) -> Any:
        """Number of summits in contact, for separations [m] of any shape."""
        d = self._separations(separation)
        if self._spheres is not None:
            touching = np.searchsorted(-self._spheres.heights, -d, side="left")
            share = self.summit_count / self._spheres.heights.size
            return plain(np.asarray(touching, dtype=float) * share)
        return plain(self.summit_count * self._counting._moment(0, d))

    def contact_area(self, separation: ArrayLike) -> Any:
        """Real contact area [m^2] of the flattened summits, for separations [m] of any shape."""
        d = self._separations(separation)
        if self._spheres is None:
            depth = self._areal._moment(2, d)
            return plain(math.pi * self.summit_count * float(self.radius) * depth)
        heights, flat = self._relieved
        radii = np.broadcast_to(np.asarray(self.radius), flat.shape) * flat**2
        depths = [float(np.maximum(heights - v, 0.0) @ radii) for v in d.reshape(-1)]
        share = math.pi * self.summit_count / flat.size
        return plain(share * np.array(depths).reshape(d.shape))

    @cached_property
    def _counting(self) -> RecoveredHeights:
        return self._recovered.at_power(0, float(self.radius))

    @cached_property
    def _areal(self) -> RecoveredHeights:
        return self._recovered.at_power(2, float(self.radius))

    def __repr__(self) -> str:
        return (
            f"TightenedSurface({self.heights!r}, tightening_load={self.tightening_load:g}, "
            f"yield_stress={self.yield_stress:g}, model={self.model!r})"
        )

    @classmethod
    @made_once
    def examples(cls) -> tuple[NormalLaw, ...]:
        """The worked example of this project, of Al 2017, tightened to 5 kN; and few summits."""
        heights = Gaussian(std=5e-7)
        milled = cls(aluminium(), heights, 1e-3, 2e4, 5000.0, 250e6, area=2e-4)
        summits = Discrete(np.array([0.0, 2e-7, -3e-7, 5e-7, 1e-7]))
        return milled, cls(aluminium(), summits, 1e-3, 100.0, 40.0, 250e6, area=1e-4)


class ElasticSummits(NormalLaw):
    """A surface of known summits that are elastic, and yield when it is tightened."""

    @abstractmethod
    def _as_spheres(self) -> dict[str, Any]:
        """Fields of a :class:`TightenedSurface` that say what its summits are."""

    def tightened(
        self,
        normal_load: float,
        *,
        yield_stress: float | None = None,
        hardness: float | None = None,
        model: str = "jackson-green",
    ) -> TightenedSurface:
        """The surface after it was pressed together once, its summits having yielded.

        Parameters
        ----------
        normal_load : float
            Tightening load [N], the largest that it has carried.
        yield_stress : float, optional
            Uniaxial yield stress of the softer body [Pa].
        hardness : float, optional
            Its hardness [Pa] instead, 2.84 times the yield stress.
        model : str, optional
            "jackson-green" (DOI 10.1115/1.1866166), "kogut-etsion" (DOI 10.1115/1.1490373) or
            "fully-plastic".

        Returns
        -------
        TightenedSurface
            A normal load law for loads up to the tightening load.
        """
        return TightenedSurface(
            self.pair,
            tightening_load=normal_load,
            yield_stress=yield_stress_of(yield_stress, hardness),
            model=model,
            **self._as_spheres(),
        )


def yield_stress_of(yield_stress: float | None, hardness: float | None) -> float:
    """The yield stress [Pa] that one of both gives."""
    if (yield_stress is None) == (hardness is None):
        came = "neither" if hardness is None else "both"
        raise InputError(
            f"`yield_stress` [Pa] or `hardness` [Pa] must be given, one of them, got {came}; "
            "write `yield_stress=250000000.0`"
        )
    if hardness is not None:
        return positive("hardness", hardness, "Pa", 1.2e9) / HARDNESS_RATIO
    return positive("yield_stress", yield_stress, "Pa", 250e6)
