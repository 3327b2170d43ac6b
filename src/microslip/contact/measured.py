"""Normal load law of a measured face, solved by boundary elements with yielding."""

from __future__ import annotations

import dataclasses
import math
import os
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, exact, number, plain, positive, whole_number
from microslip._core.errors import InputError
from microslip._core.frozen import assign
from microslip.contact.base import (
    BETWEEN,
    CONTACT_POINTS,
    FEWEST_POINTS,
    MEAN_PRESSURE,
    OVER_HARDNESS,
    RESOLUTION,
    SCATTER,
    NormalLaw,
    aluminium,
    check_pair,
)
from microslip.contact.face_law import FaceLaw, FirstLoading, checked_direction
from microslip.contact.face_solution import FaceSolution, OnPiece
from microslip.contact.materials import MaterialPair
from microslip.contact.measured_face import (
    ContactNumbers,
    Task,
    cached,
    check_pressure,
    contact_numbers,
    face_of,
    progress_halves,
    resolution_changes,
)
from microslip.figures.plottable import Plottable

if TYPE_CHECKING:
    from microslip.figures.plot import Plot

_SAMPLES = 24  # points of the table between two solutions


@dataclass(frozen=True, eq=False, repr=False, init=False)
class MeasuredContact(FaceLaw, Plottable):
    """Measured face solved point by point: interacting contacts that yield.

    Parameters
    ----------
    heights : Scan or array_like
        Heights of the gap between both faces, summits upwards: a scan, or heights [m] without
        missing points, rows along y. The least-squares plane is removed.
    pair : MaterialPair
        The two materials.
    hardness : float, optional
        Largest pressure at a point [Pa]; by default that of the pair. ``math.inf`` for an elastic
        face.
    tightening_pressure : float, optional
        Mean pressure [Pa] to which the face has been tightened. Without it the face is elastic up
        to a mean pressure of 0.05 E* h', with the composite modulus E* of the pair and the rms
        gradient h' of the heights, and the hardness is used by verdicts only.
    pixel : float or pair of float, optional
        Distance of neighbouring points [m] along x and y, for heights that are not a scan.
    area : float, optional
        Apparent area [m^2] of the joint; by default that of the scan.
    piece : int or None
        Approximate number of points along a side of the pieces into which the face is divided; None
        solves the face in one piece.
    direction : float, optional
        Direction of the motion from x of the scan [rad]; None is the mean over all directions. In a
        field with two tangential displacements it is the direction of the first one.
    loads : int
        Number of solved loads, in geometric progression; up to four more lie between the heaviest
        two, for the damping of small cycles.
    lightest : float
        Lightest over heaviest load [-].
    coarser : bool
        Whether to solve the face two more times, to report the changes of its stiffness: with every
        second point only, and without the shortest waves, which have half of the mean square slope.
    progress : callable, optional
        Called with the numbers of finished and of all solutions (approximate).
    cache : str or path, optional
        Folder in which solutions are stored and reused if the inputs are equal.

    Notes
    -----
    The face is solved by boundary elements at given separations of the mean planes; the slope N' is
    exact at each solved separation. Points that carry the hardness at tightening are flattened
    permanently, and the law is that of the elastic flattened face (Almqvist et al. 2007, DOI
    10.1016/j.triboint.2005.11.008), up to the tightening load. Between the loads ln N is a cubic
    Hermite spline, made convex where necessary; below the lightest load N is an exponential. The
    law includes the compliance of the half-space for waves up to the size of the face; if the mesh
    of the body resolves such waves, their compliance is counted twice.

    Contacts slip as in the theory of Cattaneo and Mindlin. The ratio of normal and tangential
    stiffness is solved on the points in contact (kernel of Cerruti) and depends on the direction
    under a lay.
    """

    solution: FaceSolution = field(init=False)
    numbers: ContactNumbers = field(init=False)
    area: float = field(init=False)
    direction: float | None = field(init=False)

    def __init__(
        self,
        heights: Any,
        pair: MaterialPair,
        hardness: float | None = None,
        tightening_pressure: float | None = None,
        *,
        pixel: Any = None,
        area: float | None = None,
        piece: int | None = 256,
        direction: float | None = None,
        loads: int = 12,
        lightest: float = 1e-3,
        coarser: bool = False,
        progress: OnPiece | None = None,
        cache: str | os.PathLike[str] | None = None,
    ) -> None:
        check_pair(pair)
        face = face_of(heights, pixel)
        loads = whole_number("loads", loads, 4, 200)
        lightest = number("lightest", lightest)
        if not 0.0 < lightest <= 0.5:
            raise InputError(f"`lightest` must be in (0, 0.5], got {exact(lightest)}")
        if piece is not None:
            piece = whole_number("piece", piece, 16, 2**16)
        bound = _hardness(hardness, pair, tightening_pressure)
        modulus = pair.composite_modulus
        pressure = check_pressure(tightening_pressure, bound, modulus, face)
        task = Task(
            face, pressure / modulus, bound / modulus, pair.stiffness_ratio, piece, loads, lightest
        )  # fmt: skip
        first_half, second_half = progress_halves(progress) if coarser else (progress, None)
        solution = task.solved(first_half) if cache is None else cached(task, cache, first_half)
        if solution.pixels < FEWEST_POINTS:
            raise InputError(
                f"`tightening_pressure` must bring at least {FEWEST_POINTS} points into contact, "
                f"got {solution.pixels} of {face.heights.size} under {pressure:.4g} Pa; use a "
                "larger scan, a smaller pixel, or a longer short-wave cut-off"
            )
        changes = resolution_changes(task, solution, second_half) if coarser else {}
        area = face.area if area is None else positive("area", area, "m^2", 1e-4)
        numbers = dataclasses.replace(contact_numbers(task, solution, pressure, bound), **changes)
        self._set(solution, numbers, pair, area, direction)

    def _set(
        self,
        solution: FaceSolution,
        numbers: ContactNumbers,
        pair: MaterialPair,
        area: float,
        direction: float | None,
    ) -> None:
        checked_direction(self, direction)
        d, p = _table(solution)
        assign(self, solution=solution, numbers=numbers, area=area)
        rate = float(solution.slope[0].mean()) / p[0] / numbers.pixel[0]
        # The pressure was met to a millionth; from here on it is met.
        self._set_curve(pair, d * numbers.pixel[0], p / p[0], self._heaviest, rate)

    @classmethod
    def _made_of(
        cls,
        solution: FaceSolution,
        numbers: ContactNumbers,
        pair: MaterialPair,
        area: float,
        direction: float | None = None,
    ) -> MeasuredContact:
        law = object.__new__(cls)
        law._set(solution, numbers, pair, area, direction)
        return law

    def along(self, direction: float | None) -> MeasuredContact:
        """Return the face for motion at an angle [rad] to x of the scan; None averages all."""
        return self._made_of(self.solution, self.numbers, self.pair, self.area, direction)

    def of_pieces(self, pieces: ArrayLike) -> MeasuredContact:
        """Return the law averaged over pieces of the scan, by their indices [-], one-dimensional.

        Indices start at 0 and may be repeated, so that bootstrap samples of the pieces show how
        well the scan represents the joint.
        """
        old, columns = self.solution, np.asarray(pieces)
        p, s = old.pressure[:, columns], old.slope[:, columns]
        count = int(np.count_nonzero(p.mean(axis=1) > 0.0))  # further out none of these touches
        solution = dataclasses.replace(
            old,
            separation=old.separation[:count],
            pressure=p[:count],
            slope=s[:count],
            contact=old.contact[:count],
        )
        return self._made_of(solution, self.numbers, self.pair, self.area, self.direction)

    def _patch(self, area: float, tightening: float) -> NormalLaw:
        found = self._tightened_by(np.array([tightening]))
        if found is None or tightening == 1.0:
            return self._made_of(self.solution, self.numbers, self.pair, area, self.direction)
        length, offset = (float(values[0]) for values in found)
        old, pixel = self.solution, self.numbers.pixel[0]
        separation = offset / pixel + length * old.separation
        pressure = tightening * old.pressure
        path = old.loading[:, old.loading[0] < tightening * old.loading[0, -1]]
        end = np.array([pressure[0].mean(), separation[0]])
        solution = dataclasses.replace(
            old,
            separation=separation,
            pressure=pressure,
            slope=tightening / length * old.slope,
            contact=tightening * old.contact,
            loading=np.column_stack([path, end]),
        )
        numbers = dataclasses.replace(
            self.numbers,
            pressure=tightening * self.numbers.pressure,
            contact_share=tightening * self.numbers.contact_share,
        )
        return self._made_of(solution, numbers, self.pair, area, self.direction)

    def _length_factors(self, shares: Floats) -> Floats | None:
        """Interpolate p/k_n between the solved tightening pressures, see FaceLaw._length_factors.

        Scaled from 100 MPa to tightening at 3 to 50 MPa, a law deviates from one solved for the
        lower pressure by up to 9 % in force. The energy of a cycle of amplitude mu N/k_t is 0.8 to
        1.35 times that of the solved law; with all factors set to one it is 2 to 20 times as large.
        """
        if self.solution.lighter_tightenings.size < 4:  # an elastic face
            return None
        p, slopes = self.solution.lighter_tightenings[:, ::-1]
        lengths = np.log(p / slopes)
        found = np.interp(np.log(shares), np.log(p / p[-1]), lengths)
        return np.asarray(np.exp(found - lengths[-1]))

    def _figure(self) -> Plot:
        from microslip.contact.figures import face_plot

        return face_plot(self)

    @property
    def _tangential(self) -> Floats:
        return self.solution.sliding

    @property
    def _tightening(self) -> float:
        return self.numbers.pressure

    @property
    def first_loading(self) -> FirstLoading:
        """Mean pressure, separation and stiffness of first loading, up to the tightening pressure.

        The stiffness is a finite difference between the solved loads.
        """
        pressure, separation = self.solution.loading
        p = pressure * self.pair.composite_modulus
        d = separation * self.numbers.pixel[0]
        stiffness = -self.area * p * np.gradient(np.log(p), d)
        return FirstLoading(p, d, stiffness)

    def _standardised(self, separation: float) -> float | None:
        return separation / self.numbers.rms

    def contact_area(self, separation: ArrayLike) -> Any:
        """Real contact area [m^2], counted in grid points, at separations [m] of any shape."""
        loads = np.asarray(self.load(separation), dtype=float)
        p = np.log(self.solution.pressure.mean(axis=1))[::-1]
        share = np.log(self.solution.contact)[::-1]
        with np.errstate(divide="ignore"):
            at = np.log(loads / (self.area * self.pair.composite_modulus))
        # Below the lightest load the area falls with it.
        inside = np.interp(at, p, share) + np.minimum(at - p[0], 0.0)
        return plain(np.asarray(self.area * np.exp(inside)))

    def _assumptions(self, separation: float | None) -> dict[str, Any]:
        numbers, area = self.numbers, 0.0
        if separation is not None:
            area = float(self.contact_area(max(separation, self.closest)))
        values: dict[str, float | None] = {
            CONTACT_POINTS: numbers.points * area / (self.area * numbers.contact_share),
            SCATTER: numbers.scatter,
            BETWEEN: numbers.between_pieces,
        }
        changes = [abs(x - 1.0) for x in (numbers.coarser, numbers.smoother) if x is not None]
        if changes:
            values[RESOLUTION] = max(changes)
        hardness = self.pair.hardness
        if numbers.hardness is not None:
            values[OVER_HARDNESS] = numbers.pressure / numbers.hardness
        elif separation is not None and area > 0.0 and hardness is not None:
            d = max(separation, self.closest)
            values[MEAN_PRESSURE] = float(self.load(d)) / area / hardness
        else:
            values[MEAN_PRESSURE] = None if hardness is None else 0.0
        return values

    def __repr__(self) -> str:
        numbers = self.numbers
        hardness = "elastic" if numbers.hardness is None else f"hardness={numbers.hardness:g}"
        return (
            f"MeasuredContact({hardness}, pressure={numbers.pressure:g}, area={self.area:g}, "
            f"direction={self.direction}, pieces={numbers.pieces})"
        )

    @classmethod
    @cache
    def examples(cls) -> tuple[NormalLaw, ...]:
        """Return a small rough aluminium face that has yielded, loaded across its lay."""
        how: dict[str, Any] = {"pixel": 2e-6, "area": 1e-4, "piece": 32, "direction": math.pi / 2}
        return (cls(_waves(), aluminium(), 1.2e9, 5e7, **how),)


def _hardness(hardness: float | None, pair: MaterialPair, pressure: float | None) -> float:
    if hardness is None:
        return math.inf if pressure is None or pair.hardness is None else pair.hardness
    if isinstance(hardness, float) and hardness == math.inf:
        return hardness
    hardness = positive("hardness", hardness, "Pa", 1.2e9)
    if pressure is None:
        raise InputError(
            "`tightening_pressure` [Pa] must be given with a hardness: the yielding depends on "
            "it; write `tightening_pressure=100000000.0`"
        )
    return hardness


def _table(solution: FaceSolution) -> tuple[Floats, Floats]:
    """Return separations d and mean pressures p, interpolated between the solved loads.

    ln p is a cubic Hermite spline in d; points at which p(d) would not be convex are omitted.
    """
    from scipy.interpolate import CubicHermiteSpline

    d = solution.separation
    p, s = solution.pressure.mean(axis=1), solution.slope.mean(axis=1)
    if d.size < 2:
        raise InputError(
            f"two of the solved loads must have points in contact, got {d.size}; write more "
            "`loads`, or a larger `lightest`"
        )
    curve = CubicHermiteSpline(d, np.log(p), -s / p)
    share = np.arange(_SAMPLES) / _SAMPLES
    fine = np.append((d[:-1, None] + np.diff(d)[:, None] * share).ravel(), d[-1])
    values = np.exp(np.minimum(curve(fine), np.log(p[0])))
    # The lower convex hull; where a cubic bends the wrong way its points are left out.
    hull = [0]
    for i in range(1, fine.size):
        while len(hull) > 1:
            a, b = hull[-2:]
            before = (values[b] - values[a]) / (fine[b] - fine[a])
            if (values[i] - values[b]) / (fine[i] - fine[b]) > before * (1.0 - 1e-12):
                break
            hull.pop()
        if values[i] < values[hull[-1]]:
            hull.append(i)
    return fine[hull], values[hull]


def _waves() -> Floats:
    from scipy import fft

    n = 64
    kx, ky = np.meshgrid(np.arange(n), 2.0 * np.arange(n))
    k = np.hypot(kx, ky)
    band = (k >= 3.0) & (k <= 24.0)
    size = np.where(band, np.maximum(k, 6.0) ** -1.8, 0.0)
    signs = np.random.default_rng(1).normal(size=(n, n))
    z = np.asarray(fft.idctn(size * signs), dtype=float)
    return np.asarray(z * (3e-7 / z.std()))
