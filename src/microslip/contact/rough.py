"""A rough face from drawing parameters, with yielding: no scan, no summits to count."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, exact, plain, positive
from microslip._core.errors import InputError
from microslip._core.frozen import assign, lock, made_once
from microslip._core.parameters import parameter
from microslip.contact.base import (
    OVER_HARDNESS,
    TOO_SOFT,
    TOO_STIFF,
    NormalLaw,
    aluminium,
    check_pair,
)
from microslip.contact.elastic_plastic import HARDNESS_RATIO
from microslip.contact.greenwood_williamson import GreenwoodWilliamson
from microslip.contact.heights import Gaussian
from microslip.contact.materials import Material, MaterialPair
from microslip.contact.persson import PerssonCurve
from microslip.contact.table import TabulatedNormalLaw
from microslip.contact.tightened import yield_stress_of

ERROR = 0.12
"""Standard deviation of ln stiffness against boundary elements [-]; the worst are 30 % off."""
_LARGER = 1.06  # than both theories, in the mean
_BY_LOAD = 1.2768192821378979  # radius of equal spheres over that of the mean curvature
_YIELDED, _SHRINK, _RELIEVED = 0.95, 0.6, 2.0 / 3.0
_TOUCHING = 2.2 / math.sqrt(8.0 / math.pi)  # area at light loads, over that of Persson
_HARDEST = 0.6  # mean pressure over hardness beyond which nothing was compared
_FULL = 0.5  # of full contact, to which the elastic theory goes
_BEYOND = 1e6  # times the heaviest load, for trial steps
_PER_DECADE = 64
_LIGHTEST = 1e-8
_LEAST_SLOPE = 1e-9  # rms; with less, stiffnesses are beyond all floats
_UNIT_MODULUS = 1e11  # E* [Pa], which both theories only multiply with


@dataclass(frozen=True, eq=False, repr=False)
class RoughSurface(TabulatedNormalLaw):
    """A rough face by its height, cut-offs and Hurst exponent; its summits may have yielded.

    Parameters
    ----------
    pair : MaterialPair
        The two materials; with a hardness what is pressed harder than that has yielded.
    rms : float
        Root mean square height Rq of both faces together [m].
    roll_off : float
        Longest wave of the roughness [m]: the cut-off (nesting index) of its filter, or the
        wavelength below which its spectrum falls.
    shortest : float
        Shortest wave [m].
    area : float
        Apparent area [m^2].
    hurst : float
        Hurst's exponent [-]: the power spectral density falls as q^(-2 - 2 H).
    tightening_load : float, optional
        Largest normal load that it has carried [N]. Without it every load is the first one, and
        with it the face is elastic up to that load.
    stiffness_factor : float
        Factor on the stiffness [-]: for a measured one, and for bands.
    heights : array_like, optional
        Heights of the face [m], of any shape and 200 or more: the verdicts then tell by which
        factor their distribution, which is no Gaussian's, takes the stiffness off.

    Notes
    -----
    The stiffness K(p) of an isotropic Gaussian face that is elastic is 1.06 times the larger of two
    theories: Greenwood and Williamson (1966) with the moments of Nayak (1971,
    DOI 10.1115/1.3451608), which is right where contacts are few, and Persson's (Yang and Persson
    2008, DOI 10.1088/0953-8984/20/21/215214), which holds where they interact.

    Where it yields, the real area tends to p/H and the face is elastic afterwards on what was
    pressed flat: K_y = 0.95 E* <q> A (1 - 0.6 A) (p/p_t)^(2/3), A = p_t/H, with the mean wavenumber
    <q> of the spectrum and the tightening pressure p_t. Together K = sqrt(K_e^2 + K_y^2). This
    second part is fitted to boundary elements with a bound on pressure (Almqvist et al. 2007,
    DOI 10.1115/1.2401208): H/E*h' from 0.03 to 1, Hurst exponents 0.3 to 1, shortest waves 3 to 32
    times below the roll-off, p/H to 0.27. K at tightening is within 12 % (rms), the worst 30 %;
    below a fifth of the tightening load it is up to half too stiff.
    """

    key = "rough"

    separations: Any = field(init=False, default=None)
    loads: Any = field(init=False, default=None)
    tail: Any = field(init=False, default="exponential")
    rms: float = field(
        metadata=parameter("Rq", "m", "rms height of the roughness", above=0.0, example=1e-6)
    )
    roll_off: float = field(
        metadata=parameter("lambda_r", "m", "longest wave of the roughness", above=0.0,
                           example=1e-4)
    )  # fmt: skip
    shortest: float = field(
        metadata=parameter("lambda_s", "m", "its shortest wave", above=0.0, example=5e-6)
    )
    area: float = field(metadata=parameter("S_a", "m^2", "apparent area", above=0.0))
    hurst: float = field(
        default=0.8, metadata=parameter("H", meaning="Hurst's exponent", above=0.0, most=1.0)
    )
    tightening_load: float | None = None
    stiffness_factor: float = field(
        default=1.0, metadata=parameter("f", meaning="factor on the stiffness", above=0.0)
    )
    heights: Any = None

    def __init__(
        self,
        pair: MaterialPair,
        rms: float,
        roll_off: float,
        shortest: float,
        area: float,
        hurst: float = 0.8,
        tightening_load: float | None = None,
        stiffness_factor: float = 1.0,
        heights: ArrayLike | None = None,
    ) -> None:
        check_pair(pair)
        assign(
            self, pair=pair, rms=rms, roll_off=roll_off, shortest=shortest, area=area, hurst=hurst,
            stiffness_factor=stiffness_factor, heights=heights,
        )  # fmt: skip
        self._check_parameters()
        if not self.shortest < 0.9 * self.roll_off:
            raise InputError(
                f"`shortest` must be below 0.9 of the roll_off {exact(self.roll_off)} m, got "
                f"{exact(self.shortest)}"
            )
        if not self.rms_slope >= _LEAST_SLOPE:
            raise InputError(
                f"`rms` and `roll_off` must be those of a rough face, of a slope of at least "
                f"{_LEAST_SLOPE:g}, got {exact(self.rms_slope)}"
            )
        if tightening_load is not None:
            tightening_load = positive("tightening_load", tightening_load, "N", 5000.0)
            if self.hardness is None:
                raise InputError(
                    "`tightening_load` wanted only with a hardness of the pair: a face without "
                    "one stays elastic; write Material(210e9, 0.3, hardness=1.7e9)"
                )
            if tightening_load > self._heaviest_first:
                raise InputError(
                    f"`tightening_load` must be at most {self._heaviest_first:.6g} N, 0.6 of the "
                    f"hardness on the area, got {exact(tightening_load)} N"
                )
        assign(self, tightening_load=tightening_load, heights=self._spectrum.heights)  # checked
        # Beyond its end the law goes on for the trial steps of static solutions.
        heaviest = self._heaviest_first
        count = round(-_PER_DECADE * math.log10(_LIGHTEST))
        loads = np.geomspace(heaviest, _LIGHTEST * heaviest, count)
        stiff = self._stiffness_under(loads)
        beyond = np.geomspace(_BEYOND, 1.0, _PER_DECADE)[:-1]
        loads = np.concatenate([beyond * heaviest, loads])
        # d = - int dN/K, by the trapezium in ln N, where N/K is nearly constant.
        lengths = loads / np.concatenate([beyond * stiff[0], stiff])
        steps = 0.5 * (lengths[1:] + lengths[:-1]) * np.log(loads[:-1] / loads[1:])
        separations = np.concatenate(([0.0], np.cumsum(steps)))
        # Mean planes are as far apart as Persson's theory has them under a light load.
        at = int(np.argmin(np.abs(np.log(loads / (1e-3 * heaviest)))))
        separations += self._spectrum.separation(loads[at]) - separations[at]
        super().__init__(pair, separations, loads, tail="exponential")

    # -- what is known of it -------------------------------------------------------------------

    @classmethod
    def from_slope(
        cls, pair: MaterialPair, *, rms: float, slope: float, roll_off: float, area: float,
        hurst: float = 0.8, tightening_load: float | None = None,
    ) -> RoughSurface:  # fmt: skip
        """By the rms slope of profiles Rdq in place of the shortest wave.

        Parameters
        ----------
        pair, rms, roll_off, area, hurst, tightening_load
            As of the class.
        slope : float
            Root mean square slope Rdq of a profile [-] (ISO 21920-2), 0.707 of that of the face.
        """
        slope = positive("slope", slope, "", 0.1)
        sizes = cls(
            pair, rms, roll_off, 0.5 * positive("roll_off", roll_off, "m", 1e-4), area, hurst
        )
        rms, roll_off, hurst = sizes.rms, sizes.roll_off, sizes.hurst  # checked

        def miss(log_ratio: float) -> float:
            q = 2.0 * math.pi / roll_off
            mean_square = moments(rms, hurst, q, q * math.exp(log_ratio))[1]
            return math.log(mean_square / slope**2)

        from scipy.optimize import brentq

        low, high = math.log(1.0 / 0.89), math.log(1e5)
        if not miss(low) < 0.0 < miss(high):
            q = 2.0 * math.pi / roll_off
            ends = [math.sqrt(moments(rms, hurst, q, q * math.exp(x))[1]) for x in (low, high)]
            raise InputError(
                f"`slope` must be between {ends[0]:.3g} and {ends[1]:.3g} at this height, roll_off "
                f"and Hurst exponent, got {exact(slope)}"
            )
        shortest = roll_off * math.exp(-brentq(miss, low, high, xtol=1e-12))
        return cls(pair, rms, roll_off, shortest, area, hurst, tightening_load)

    @property
    def hardness(self) -> float | None:
        """Hardness of the softer body [Pa]; None where neither is known."""
        return self.pair.hardness

    @cached_property
    def _wavenumbers(self) -> tuple[float, float]:
        return 2.0 * math.pi / self.roll_off, 2.0 * math.pi / self.shortest

    @cached_property
    def rms_slope(self) -> float:
        """Root mean square of the gradient h' [-]."""
        return math.sqrt(2.0 * moments(self.rms, self.hurst, *self._wavenumbers)[1])

    @cached_property
    def mean_wavenumber(self) -> float:
        """Mean wavenumber of the spectrum [1/m], which the stiffness of flattened faces follows."""
        return mean_wavenumber(self.hurst, *self._wavenumbers)

    @cached_property
    def _spectrum(self) -> PerssonCurve:
        return _spectrum(
            self.pair, self.rms, self.hurst, *self._wavenumbers, self.area, self.heights
        )

    # -- stiffness -----------------------------------------------------------------------------

    @cached_property
    def _heaviest_first(self) -> float:
        """Load [N] to which the law goes on first loading."""
        hardest = math.inf if self.hardness is None else _HARDEST * self.hardness * self.area
        return min(_FULL * self._full, hardest)

    @property
    def _full(self) -> float:
        """Load of full contact [N] in Persson's theory."""
        return self.area * self.pair.composite_modulus * self.rms_slope / math.sqrt(2.0)

    def _stiffness_under(self, loads: Floats) -> Floats:
        """-dN/dd under loads [N/m]; first loads each, or relieved from the tightening."""
        return self.stiffness_factor * np.hypot(self._elastic_part(loads), self._flat_part(loads))

    def _elastic_part(self, loads: Floats) -> Floats:
        stiff = self.pair.composite_modulus * self.area
        pressures, stiffnesses = _elastic(self.rms, self.hurst, *self._wavenumbers)
        return np.asarray(stiff * np.exp(np.interp(np.log(loads / stiff), pressures, stiffnesses)))

    def _flat_part(self, loads: Floats) -> Floats:
        """Stiffness of the part that was pressed flat."""
        if self.hardness is None:
            return np.zeros_like(loads)
        stiff = self.pair.composite_modulus * self.area
        first = loads if self.tightening_load is None else np.asarray(self.tightening_load)
        share = np.minimum(first / (self.hardness * self.area), _HARDEST)
        flat = _YIELDED * stiff * self.mean_wavenumber * share * (1.0 - _SHRINK * share)
        return np.asarray(flat * (loads / first) ** _RELIEVED)

    def _excess_by_heights(self, load: float) -> float:
        """Factor by which the stiffness under a load [N] is too large for the given heights.

        Heights decide the elastic part; what was pressed flat bears p/H of any face.
        """
        at = np.array([load])
        elastic, flat = float(self._elastic_part(at)[0]), float(self._flat_part(at)[0])
        by_heights = elastic / self._spectrum.stiffness_by_heights(load)
        return math.hypot(elastic, flat) / math.hypot(by_heights, flat)

    # -- as a normal law -----------------------------------------------------------------------

    def _under(self, load: float) -> NormalLaw:
        known = self.tightening_load
        if self.hardness is None or (known is not None and load <= known * (1.0 + 1e-12)):
            return self
        return dataclasses.replace(self, tightening_load=load)

    def tightened(
        self,
        normal_load: float,
        *,
        yield_stress: float | None = None,
        hardness: float | None = None,
        model: str = "",
    ) -> RoughSurface:
        """The face after it was pressed together under a load [N]; elastic up to that.

        Parameters
        ----------
        normal_load : float
            The largest load [N].
        yield_stress, hardness : float, optional
            Hardness of the softer body [Pa]; that of the pair unless given.
        model : str, optional
            Without effect: whatever is pressed harder than the hardness yields.
        """
        pair = self.pair
        if yield_stress is not None or hardness is not None:
            pair = pair.with_hardness(HARDNESS_RATIO * yield_stress_of(yield_stress, hardness))
        return dataclasses.replace(self, pair=pair, tightening_load=normal_load)

    def _patch(self, area: float, share: float) -> NormalLaw:
        load = None if self.tightening_load is None else share * self.tightening_load
        return dataclasses.replace(self, area=area, tightening_load=load)

    @cached_property
    def _span(self) -> tuple[float, float]:
        heaviest = int(np.argmin(np.abs(np.asarray(self.loads) - self._heaviest)))
        return float(np.asarray(self.separations)[heaviest]), super()._span[1]

    @property
    def _heaviest(self) -> float:
        return self._heaviest_first if self.tightening_load is None else self.tightening_load

    def _separations(self, value: ArrayLike) -> Floats:
        return NormalLaw._separations(self, value)  # also closer than its end, for trial steps

    def _solve(self, loads: Floats) -> Floats:
        known = self.tightening_load
        # The law is spanned to the point of its table nearest to that load, within half a step.
        spanned = 0.0 if known is None else max(known, float(self.load(self._span[0])))
        if self.hardness is not None and known and loads.max() > spanned * (1.0 + 1e-9):
            raise InputError(
                f"`normal_load` must be at most the tightening load {known:.6g} N (above it the "
                f"summits yield again), got {exact(loads.max())} N; tighten it to that load first"
            )
        heaviest = self._heaviest_first
        if loads.max() > heaviest * (1.0 + 1e-9):
            raise InputError(
                f"`load` must be at most {heaviest:.6g} N, where {self._limit_said}, got "
                f"{exact(loads.max())} N; a larger area or a harder material bears more"
            )
        return super()._solve(loads)

    @property
    def _limit_said(self) -> str:
        """Reason why the law ends where it does."""
        if self._heaviest_first < _FULL * self._full:
            return "the pressure is 0.6 of the hardness"
        return "half of the face touches"

    def contact_area(self, separation: ArrayLike) -> Any:
        """Real contact area [m^2], for separations [m] of any shape.

        At the shortest waves: 2.2 p/E*h' where it is elastic (Putignano et al. 2012,
        DOI 10.1016/j.jmps.2012.01.006), p/H of the tightening where it is pressed flat.
        """
        loads = np.asarray(self.load(separation))
        share = np.asarray(self._spectrum.contact_share(_TOUCHING * loads))
        if self.hardness is not None:
            first = np.maximum(loads, self.tightening_load or 0.0)
            flat = first / (self.hardness * self.area) * (loads / first) ** _RELIEVED
            share = np.minimum(np.hypot(share, flat), 1.0)
        return plain(self.area * share)

    def _assumptions(self, separation: float | None) -> dict[str, float | None]:
        load = 0.0 if separation is None else float(self.load(separation))
        first = max(load, self.tightening_load or 0.0)
        values: dict[str, float | None] = {OVER_HARDNESS: None}
        if self.hardness is not None:
            stiff = self.pair.composite_modulus * self.rms_slope
            values = {
                OVER_HARDNESS: first / (self.area * self.hardness),
                "hardness over modulus and slope": self.hardness / stiff,
                "load over that of tightening": load / first if first > 0.0 else 1.0,
            }
        if self.heights is not None:
            excess = self._excess_by_heights(load) if load > 0.0 else None
            values[TOO_STIFF] = None if excess is None else max(excess, 1.0)
            values[TOO_SOFT] = None if excess is None else max(1.0 / excess, 1.0)
        return values

    def __repr__(self) -> str:
        return (
            f"RoughSurface(rms={self.rms:g}, roll_off={self.roll_off:g}, "
            f"shortest={self.shortest:g}, hurst={self.hurst:g}, area={self.area:g}, "
            f"tightening_load={self.tightening_load})"
        )

    @classmethod
    @made_once
    def examples(cls) -> tuple[NormalLaw, ...]:
        """A ground face of Al 2017 that stays elastic, and one that was tightened."""
        metal = aluminium().with_hardness(1.2e9)
        return (
            cls(aluminium(), 5e-7, 1e-4, 1e-5, 2e-4),
            cls(metal, 5e-7, 1e-4, 1e-5, 2e-4, tightening_load=5000.0),
        )


def _power(low: float, high: float, exponent: float) -> float:
    """Integral of q^exponent."""
    n = exponent + 1.0
    if abs(n) < 1e-9:
        return math.log(high / low)
    return float(high**n - low**n) / n


def moments(rms: float, hurst: float, low: float, high: float) -> tuple[float, float, float]:
    """Spectral moments m0, m2, m4 of profiles of a face whose spectrum is a power law."""
    m = [_power(low, high, n - 1.0 - 2.0 * hurst) for n in (0, 2, 4)]
    return rms**2, rms**2 * m[1] / m[0] / 2.0, rms**2 * m[2] / m[0] * 0.375


def mean_wavenumber(hurst: float, low: float, high: float) -> float:
    """Mean wavenumber [1/m] of a face whose spectrum is a power law between two of them."""
    return _power(low, high, -2.0 * hurst) / _power(low, high, -2.0 * hurst - 1.0)


def _spectrum(
    pair: MaterialPair,
    rms: float,
    hurst: float,
    low: float,
    high: float,
    area: float,
    heights: Any = None,
) -> PerssonCurve:
    q = np.array([low, high])
    level = rms**2 / (2.0 * math.pi * _power(low, high, -1.0 - 2.0 * hurst))
    return PerssonCurve(pair, q, level * q ** (-2.0 - 2.0 * hurst), area, heights=heights)


@lru_cache(maxsize=64)
def _elastic(rms: float, hurst: float, low: float, high: float) -> tuple[Floats, Floats]:
    """Logarithms of pressure over E* and of stiffness over E* and area [1/m], of an elastic face.

    By both theories, times what they lack.
    """
    pair = MaterialPair(Material(_UNIT_MODULUS, 0.0), Material.rigid())
    m0, m2, m4 = moments(rms, hurst, low, high)
    # Summits of Nayak's moments, each of which carries what its two curvatures say.
    alpha = m0 * m4 / m2**2
    share = 1.0 - 3.0 * math.sqrt(3.0) + 16.0 / math.pi
    std, mean = math.sqrt((1.0 - share / alpha) * m0), 4.0 * math.sqrt(m0 / math.pi / alpha)
    radius = _BY_LOAD * 0.375 * math.sqrt(math.pi / m4)
    density = m4 / m2 / (6.0 * math.pi * math.sqrt(3.0))
    summits = GreenwoodWilliamson(pair, Gaussian(std, mean), radius, density, 1.0)
    d = np.linspace(mean + 9.0 * std, mean - 15.0 * std, 1500)
    n, k = summits._derivative(d, 0) / _UNIT_MODULUS, -summits._derivative(d, 1) / _UNIT_MODULUS
    x = np.linspace(math.log(1e-13), math.log(_FULL * math.sqrt(m2)), 240)
    by_waves = (
        _spectrum(pair, rms, hurst, low, high, 1.0).stiffness(_UNIT_MODULUS * np.exp(x))
        / _UNIT_MODULUS
    )
    fine = np.linspace(x[0], x[-1], 2000)
    by_summits = np.interp(fine, np.log(n), np.log(k))
    larger = np.maximum(by_summits, np.interp(fine, x, np.log(by_waves)))
    return lock(fine), lock(larger + math.log(_LARGER))
