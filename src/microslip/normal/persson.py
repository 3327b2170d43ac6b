"""Persson's separation under a load, from a power spectrum: a table for a normal law."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from microslip._core.checks import (
    LARGEST,
    Floats,
    exact,
    floats,
    plain,
    positive,
    positives,
    record,
    show,
    whole_number,
)
from microslip._core.frozen import Locked, assign, lock
from microslip._core.parameters import Parametric, parameter
from microslip.errors import InputError
from microslip.materials import MaterialPair
from microslip.normal.base import PRESSURE, STIFFNESS, TOO_SOFT, TOO_STIFF, NormalLaw, check_pair
from microslip.normal.table import TabulatedNormalLaw
from microslip.numerics.quadrature import gauss_legendre

_END = 6.6  # beyond, exp(-x^2) is no part of anything
_PIECE = 10  # nodes between two points of the spectrum
_MOST_PIECES = 400
_FACTORS = ((3e-4, 0.55), (1e-3, 0.62), (3e-3, 0.72), (1e-2, 0.81), (3e-2, 0.94), (0.1, 1.0))
"""p/E*h' [-] and the stiffness there over that of boundary elements, on self-affine faces."""
_BEARING = 3.3  # share of the heights that the load stands on, over Persson's contact share
_BY_TAIL = 0.9  # power of the ratio of mean heights above, fitted to boundary elements
_FEWEST = 20  # heights in a mean

if TYPE_CHECKING:

    class SpectrumLike(Protocol):
        """Interface of :class:`microslip.scans.Spectrum`."""

        @property
        def wavenumber(self) -> Floats:
            """Wavenumbers [1/m]."""

        @property
        def density(self) -> Floats:
            """Power spectral density there [m^4]."""


@lru_cache(maxsize=1)
def _erf2_to_end() -> Floats:
    """Chebyshev series over 0 ... _END of the integral of erf^2(y) exp(-y^2)/y from x on."""
    from scipy.special import erf

    def over_x(t: Any) -> Any:
        x = 0.5 * _END * (t + 1.0)
        return np.asarray(erf(x) ** 2 * np.exp(-x * x) / np.where(x > 0.0, x, 1.0))

    falling = -np.asarray(chebyshev.chebint(chebyshev.chebinterpolate(over_x, 90), scl=0.5 * _END))
    falling[0] -= chebyshev.chebval(1.0, falling)
    return lock(falling)


@dataclass(frozen=True, eq=False, repr=False)
class PerssonCurve(Locked, Parametric):
    """A surface by its power spectrum, pressed on a half space, by Persson's theory.

    Parameters
    ----------
    pair : MaterialPair
        The two materials.
    wavenumber : array_like
        Wavenumbers q [1/m] (2 pi over the wavelength), rising, from the longest wave to the
        shortest that counts.
    spectrum : array_like
        Power spectral density C(q) there [m^4]; its integral over the plane of wavenumbers is the
        mean square height. Straight between the points in logarithms.
    area : float
        Apparent area [m^2].
    stored_share : float, optional
        Persson's gamma [-]: how much of the elastic energy of full contact partial contact stores.
    heights : array_like, optional
        Heights of the face [m], of any shape and origin. The law does not follow from them, but
        how far it is off does: the verdicts of a joint tell it.

    Notes
    -----
    Yang and Persson (2008), DOI 10.1088/0953-8984/20/21/215214: the mean separation under a
    pressure p, written here with v^2 the integral of q^3 C up to q,

    u(p) = 2 int dv/q(v) int_x^inf [gamma + 3 (1 - gamma) erf^2(y)] exp(-y^2) dy/y,
    x = p/(sqrt(pi) E* v),

    which has the same value without a root that is infinite at the longest wave. Separations are
    those of the mean planes, above zero. The half space beneath gives way, too, so what is
    tangential follows by the same superposition (Ciavarella, Jaeger) with that compliance in it: do
    not add that of a body as large as the longest wave.
    """

    pair: MaterialPair
    wavenumber: Any = field(
        metadata=parameter(
            "q", "1/m", "wavenumbers of the spectrum", above=0.0, many=True, example=1e5
        )
    )
    spectrum: Any = field(
        metadata=parameter(
            "C", "m^4", "power spectral density at these", above=0.0, many=True, example=1e-24
        )
    )
    area: float = field(metadata=parameter("S_a", "m^2", "apparent area", above=0.0))
    stored_share: float = field(
        default=0.45,
        metadata=parameter("gamma", meaning="share of the elastic energy", above=0.0, most=1.0),
    )
    heights: Any = None

    def __post_init__(self) -> None:
        check_pair(self.pair)
        super().__post_init__()
        q, c = self.wavenumber, self.spectrum
        if q.size != c.size or q.size < 2:
            raise InputError(
                "`wavenumber` and the spectrum must be two lists of one length, two at least, "
                f"got {q.size} and {c.size}"
            )
        if not np.all(np.diff(q) > 0.0):
            raise InputError("`wavenumber` must rise [1/m]")
        if self.heights is not None:
            heights = floats("heights", self.heights, "m").ravel()
            if heights.size < 10 * _FEWEST or np.ptp(heights) == 0.0:
                raise InputError(
                    f"`heights` must be {10 * _FEWEST} or more that differ, got {heights.size}"
                )
            assign(self, heights=lock(np.sort(heights)))

    @classmethod
    def from_spectrum(
        cls,
        spectrum: SpectrumLike,
        pair: MaterialPair,
        area: float,
        *,
        longest: float | None = None,
        shortest: float | None = None,
        heights: ArrayLike | None = None,
    ) -> PerssonCurve:
        """From the spectrum of a scan, ``scan.spectrum()``.

        Parameters
        ----------
        spectrum : Spectrum
            Heights of a scan, its form removed.
        pair : MaterialPair
            The two materials.
        area : float
            Apparent area [m^2].
        longest, shortest : float, optional
            Wavelengths [m] between which it counts; all that are in it unless given.
        heights : array_like, optional
            Heights of the same scan [m] of any shape, for the verdict on what is not Gaussian in
            them.
        """
        if not (hasattr(spectrum, "wavenumber") and hasattr(spectrum, "density")):
            raise InputError(
                f"`spectrum` must be that of a scan, scan.spectrum(), got {show(spectrum)}"
            )
        q, c = (record(name, getattr(spectrum, name)) for name in ("wavenumber", "density"))
        if q.shape != c.shape:
            raise InputError(
                f"`wavenumber` and density must be of one length, got {q.size} and {c.size}"
            )
        if c.min() < 0.0:
            raise InputError(f"`spectrum` must not be negative, got {exact(c.min())}")
        if len(getattr(spectrum, "axes", (0, 0))) < 2:
            raise InputError("PerssonCurve needs the spectrum of a map, got that of a profile")
        low = 0.0 if longest is None else 2.0 * math.pi / positive("longest", longest, "m", 1e-3)
        high = math.inf
        if shortest is not None:
            high = 2.0 * math.pi / positive("shortest", shortest, "m", 1e-5)
        # What filters have left of the shortest waves is no part of any slope.
        inside = (q >= low) & (q <= high) & (c > max(1e-20 * float(c.max()), 1e-39))
        if np.count_nonzero(inside) < 2:
            raise InputError(
                "PerssonCurve needs two rings of the spectrum or more between its wavelengths, "
                f"got {np.count_nonzero(inside)}"
            )
        return cls(pair, q[inside], c[inside], area, heights=heights)

    @classmethod
    def self_affine(
        cls,
        pair: MaterialPair,
        *,
        rms: float,
        hurst: float,
        longest: float,
        roll_off: float,
        shortest: float,
        area: float,
    ) -> PerssonCurve:
        """A self-affine surface: an even spectrum down to the roll-off, a falling one from there.

        Parameters
        ----------
        pair : MaterialPair
            The two materials.
        rms : float
            Root mean square height [m].
        hurst : float
            Hurst's exponent [-], above 0 and at most 1: C falls as q^(-2 - 2 H).
        longest, roll_off, shortest : float
            Wavelengths [m], falling.
        area : float
            Apparent area [m^2].
        """
        rms, hurst = positive("rms", rms, "m", 1e-6), positive("hurst", hurst)
        if hurst > 1.0:
            raise InputError(f"`hurst` must be in (0, 1], got {exact(hurst)}")
        ends = [
            2.0 * math.pi / positive(name, value, "m", 1e-3)
            for name, value in (
                ("longest", longest),
                ("roll_off", roll_off),
                ("shortest", shortest),
            )
        ]
        if not ends[0] <= ends[1] < ends[2]:
            raise InputError("longest, roll_off and shortest must be wavelengths that fall [m]")
        slope = -2.0 - 2.0 * hurst
        flat = math.pi * (ends[1] ** 2 - ends[0] ** 2)
        tail = 2.0 * math.pi * ends[1] ** 2 * (1.0 - (ends[2] / ends[1]) ** (-2.0 * hurst))
        level = rms**2 / (flat + tail / (2.0 * hurst))
        q = np.array(ends if ends[0] < ends[1] else ends[1:])
        c = level * np.minimum((q / ends[1]) ** slope, 1.0)
        return cls(pair, q, c, area)

    class Rings(NamedTuple):
        """A spectrum as two arrays, for :meth:`from_spectrum`."""

        wavenumber: Floats
        density: Floats

    # -- the spectrum -----------------------------------------------------------------------------

    @cached_property
    def _nodes(self) -> tuple[Floats, Floats]:
        """Places v of an integral over it [m/m], and their weights over q [m]."""
        q, c = np.log(self.wavenumber), np.log(self.spectrum)
        count = max(-(-60 // (q.size - 1)), 1)
        if q.size > _MOST_PIECES:
            edges = np.linspace(q[0], q[-1], _MOST_PIECES + 1)
        else:
            edges = np.unique(np.concatenate(
                [np.linspace(a, b, count + 1) for a, b in pairwise(q)]
            ))  # fmt: skip
        ends = np.concatenate(([0.0], np.cumsum(self._between(edges[:-1], edges[1:], q, c))))
        v = np.sqrt(ends)
        share, weight = gauss_legendre(_PIECE)
        places = v[:-1, None] + np.diff(v)[:, None] * share
        # q(v) by Newton in each piece, where the spectrum is a power law.
        target = places**2 - ends[:-1, None]
        low, high = edges[:-1, None], edges[1:, None]
        at = low + (high - low) * target / (ends[1:, None] - ends[:-1, None])
        for _ in range(60):
            reached = self._between(np.broadcast_to(low, at.shape), at, q, c)
            slope = np.exp(4.0 * at + np.interp(at, q, c))
            new = np.clip(at - (reached - target) / slope, low, high)
            converged = np.abs(new - at).max() < 1e-15 * max(abs(q[0]), abs(q[-1]), 1.0)
            at = new
            if converged:
                break
        weights = 2.0 * np.diff(v)[:, None] * weight / np.exp(at)
        return places.reshape(-1), weights.reshape(-1)

    @staticmethod
    def _between(low: Floats, high: Floats, q: Floats, c: Floats) -> Floats:
        """Integral of q^3 C from low to high [-], logarithms within one piece of the spectrum."""
        middle = 0.5 * (low + high)
        piece = np.clip(np.searchsorted(q, middle) - 1, 0, q.size - 2)
        power = 4.0 + (c[piece + 1] - c[piece]) / (q[piece + 1] - q[piece])
        begin = c[piece] + (power - 4.0) * (low - q[piece]) + 4.0 * low
        width = power * (high - low)
        small = np.abs(width) < 1e-8
        ratio = np.where(small, 1.0 + 0.5 * width, np.expm1(width) / np.where(small, 1.0, width))
        return np.asarray(np.exp(begin) * (high - low) * ratio)

    @property
    def rms_slope(self) -> float:
        """Root mean square slope of the surface [-], that of its gradient."""
        q, c = np.log(self.wavenumber), np.log(self.spectrum)
        return math.sqrt(2.0 * math.pi * float(self._between(q[:-1], q[1:], q, c).sum()))

    # -- separation by pressure -------------------------------------------------------------------

    def separation(self, load: ArrayLike) -> Any:
        """Mean separation of the mean planes [m] under loads [N] of any shape."""
        from scipy.special import exp1

        loads = positives("load", load, "N")
        v, weights = self._nodes
        scale = math.sqrt(math.pi) * self.pair.composite_modulus * self.area
        series = _erf2_to_end()
        gaps = np.empty(loads.size)
        for start in range(0, loads.size, 256):
            part = slice(start, start + 256)
            x = loads.reshape(-1)[part, None] / (scale * v)
            partial = chebyshev.chebval(2.0 / _END * np.minimum(x, _END) - 1.0, series)
            far = x < 26.0
            log = np.where(far, exp1(np.where(far, x * x, 1.0)), 0.0)
            inner = 0.5 * self.stored_share * log
            inner += 3.0 * (1.0 - self.stored_share) * np.where(x < _END, partial, 0.0)
            gaps[part] = inner @ weights
        return plain(gaps.reshape(loads.shape))

    def stiffness(self, load: ArrayLike) -> Any:
        """Normal stiffness -dN/du [N/m] under loads [N] of any shape."""
        from scipy.special import erf

        loads = positives("load", load, "N")
        v, weights = self._nodes
        scale = math.sqrt(math.pi) * self.pair.composite_modulus * self.area
        x = loads.reshape(-1, 1) / (scale * v)
        stored = self.stored_share + 3.0 * (1.0 - self.stored_share) * erf(x) ** 2
        return plain(loads / ((stored * np.exp(-x * x)) @ weights).reshape(loads.shape))

    def contact_share(self, load: ArrayLike) -> Any:
        """Real over apparent area [-] at the shortest waves, under loads [N] of any shape."""
        from scipy.special import erf

        full = self.pair.composite_modulus * self.rms_slope / math.sqrt(2.0)
        loads = np.clip(floats("load", load, "N"), -LARGEST, LARGEST)
        return plain(np.asarray(erf(loads / self.area / full)))

    def stiffness_by_heights(self, load: float) -> float:
        """Factor [-] by which the stiffness under a load [N] is too large for the given heights.

        Of faces of one spectrum the stiffness under a light load goes as the pressure over the mean
        height of what stands above the bearing level, and the law has that of a Gaussian.
        """
        if self.heights is None:
            raise InputError("`heights` missing: give those of the face, heights=scan.heights")
        from scipy.special import ndtri

        share = _BEARING * self.contact_share(positive("load", load, "N", 100.0))
        ratio, count, spread = 1.0, self.heights.size, float(self.heights.std())
        for _ in range(12):  # what stands out further is steeper, so that less of it bears
            above = min(max(round(share / ratio * count), _FEWEST), count // 2)
            level, top = self.heights[-above - 1], self.heights[-above:]
            score = -float(ndtri(above / count))
            density = math.exp(-0.5 * score**2) / math.sqrt(2.0 * math.pi)
            gaussian = spread * (density * count / above - score)
            ratio = math.sqrt(ratio * max(float(top.mean() - level), 1e-9 * spread) / gaussian)
        return float(ratio**_BY_TAIL)

    def to_surface(self, points: int = 2000) -> PerssonSurface:
        """The curve as a normal law, from next to nothing to half of full contact.

        Parameters
        ----------
        points : int, optional
            Points of its table, evenly spaced in the logarithm of the load: 2000 give loads to
            3e-8, k_t to 7e-6 and E_d to 6e-5 at a hundredth of the rms height, less below.

        Returns
        -------
        PerssonSurface
            A table with an exponential tail, which is the law of light loads.
        """
        points = whole_number("points", points, 10, 1_000_000)
        full = self.area * self.pair.composite_modulus * self.rms_slope / math.sqrt(2.0)
        loads = np.geomspace(0.5 * full, 1e-9 * full, points)
        return PerssonSurface(self, self.separation(loads), loads)

    def __repr__(self) -> str:
        return (
            f"PerssonCurve({self.wavenumber.size} wavenumbers, rms_slope={self.rms_slope:.4g}, "
            f"area={self.area:g})"
        )


class PerssonSurface(TabulatedNormalLaw):
    """Persson's law of a spectrum as a table, which knows its area; of `PerssonCurve.to_surface`.

    From a curve, separations [m], rising, and the loads [N] there.
    """

    curve: PerssonCurve

    def __init__(self, curve: PerssonCurve, separation: ArrayLike, load: ArrayLike) -> None:
        super().__init__(curve.pair, separation, load, tail="exponential")
        assign(self, curve=curve)

    @property
    def area(self) -> float:
        """Apparent area [m^2]."""
        return self.curve.area

    def contact_area(self, separation: ArrayLike) -> Any:
        """Real contact area [m^2] at the shortest waves, for separations [m] of any shape."""
        share = self.curve.contact_share(self.load(separation))
        return plain(self.area * np.asarray(share))

    def _assumptions(self, separation: float | None) -> dict[str, float | None]:
        hardness = self.pair.hardness
        values: dict[str, float | None]
        if separation is None:
            values = {PRESSURE: None if hardness is None else 0.0, STIFFNESS: _FACTORS[0][1]}
            return values | (
                {} if self.curve.heights is None else {TOO_STIFF: None, TOO_SOFT: None}
            )
        d = max(separation, float(np.asarray(self.separations)[0]))
        load = float(self.load(d))
        touching = None if hardness is None else load / float(self.contact_area(d)) / hardness
        modulus = self.pair.composite_modulus * self.curve.rms_slope
        at, factors = np.transpose(_FACTORS)
        factor = np.interp(math.log(load / self.area / modulus), np.log(at), factors)
        values = {PRESSURE: touching, STIFFNESS: float(factor)}
        if self.curve.heights is not None:
            excess = self.curve.stiffness_by_heights(load)
            values |= {TOO_STIFF: max(excess, 1.0), TOO_SOFT: max(1.0 / excess, 1.0)}
        return values

    def _solve(self, loads: Floats) -> Floats:
        heaviest = float(np.asarray(self.loads)[0])
        if loads.max() > heaviest:
            raise InputError(
                f"`load` must be at most {heaviest:.6g} N, half of full contact, to which the "
                f"curve is computed, got {exact(loads.max())} N; give a larger area or a smaller "
                "load"
            )
        return super()._solve(loads)

    def _patch(self, area: float, share: float) -> NormalLaw:
        curve = dataclasses.replace(self.curve, area=area)
        loads = np.asarray(self.loads) * (area / self.area)
        return PerssonSurface(curve, self.separations, loads)

    def __repr__(self) -> str:
        return f"PerssonSurface({self.curve!r})"
