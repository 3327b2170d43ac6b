"""Loads of a measured face against its separation: tightened once, then unloaded.

The face is solved in one or several pieces, all with heights above the mean plane of the whole face
and at equal separations; pressures are averaged over the pieces. Pressures are in units of E*,
lengths in units of the point spacing along x, as in :mod:`.boundary_elements`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from microslip._core.by_value import ByValue
from microslip._core.checks import Floats
from microslip._core.errors import InputError
from microslip._core.frozen import LockedArrays
from microslip._core.threads import single_threaded
from microslip.contact.boundary_elements import HalfSpace, closing, press, sliding

OnPiece = Callable[[int, int], None]

TOLERANCE = 1e-5
"""Largest residual of the gap, over the rms height."""
_TIGHTENED = 1e-6  # how near the tightening pressure is met
_ATTEMPTS = 60
_STEP = math.log(2.5)
_FEWEST = 12  # points in contact below which no lighter load is solved
NEAR_REST = (0.985, 0.95, 0.87, 0.72)
"""Additional loads near the largest one, relative to it: N'' there governs small cycles."""


@dataclass(frozen=True, eq=False)
class FaceSolution(ByValue, LockedArrays):
    """Solution of a tightened face at falling loads; pressures [E*], lengths [pixels along x]."""

    separation: Floats
    """Separations, increasing."""
    pressure: Floats
    """Mean pressure of each piece at the separations, shape (separations, pieces)."""
    slope: Floats
    """-dp/dd of each piece at the separations, shape (separations, pieces)."""
    contact: Floats
    """Fraction of the points in contact at the separations."""
    sliding: Floats
    """Ratio of tangential to normal stiffness at the largest load, shape (2, 2)."""
    hard: float
    """Fraction of the points in contact whose pressure is the hardness after tightening."""
    pixels: int
    """Number of points in contact after tightening."""
    map: Floats
    """Pressures of the first piece after tightening."""
    reach: Floats
    """Number of loads, from the largest, at which each point of the first piece is in contact."""
    lighter_tightenings: Floats
    """Lower tightening pressures, decreasing, and -dp/dd on unloading from each, (2, loads)."""
    loading: Floats
    """Mean pressures of first loading, increasing, and their separations, (2, loads)."""


class _Piece:
    """Part of the face, with its pressures P [E*] and -dP/dd at the last solved separation d."""

    def __init__(self, heights: Floats, aspect: float) -> None:
        self.heights = heights
        self.space = HalfSpace((heights.shape[0], heights.shape[1]), aspect)
        self.pressure: Floats | None = None
        self.growth: Floats | None = None
        self.separation = math.inf

    def press(self, separation: float, hardness: float, tolerance: float) -> tuple[float, float]:
        """Solve the pressures at a separation d; return their mean p and -dp/dd on approach."""
        start = self.pressure
        if start is not None and self.growth is not None:
            start = start + (self.separation - separation) * self.growth
        self.pressure = press(
            self.space, self.heights, separation, start, hardness=hardness, tolerance=tolerance
        )
        touching = (self.pressure > 0.0) & (self.pressure < hardness)
        self.growth = closing(self.space, touching, self.growth)
        self.separation = separation
        return float(self.pressure.mean()), float(self.growth.mean())

    def yielded(self, hardness: float) -> None:
        """Lower the heights at points with the hardness until they no longer overlap the body."""
        assert self.pressure is not None
        gap = self.space.displacement(self.pressure) - self.heights + self.separation
        hard = self.pressure >= hardness
        self.heights = self.heights + np.where(hard, np.minimum(gap, 0.0), 0.0)

    def relieved(self) -> float:
        """Return -dp/dd of the mean pressure p after the points at the hardness have yielded."""
        assert self.pressure is not None
        return float(closing(self.space, self.pressure > 0.0, self.growth).mean())

    @property
    def touching(self) -> int:
        return 0 if self.pressure is None else int(np.count_nonzero(self.pressure > 0.0))

    def bearing(self, hardness: float) -> int:
        return 0 if self.pressure is None else int(np.count_nonzero(self.pressure >= hardness))


@dataclass
class _Face:
    pieces: list[_Piece]
    weights: Floats
    tolerance: float
    rms: float
    done: int = 0
    progress: OnPiece | None = None
    total: int = 1
    path: list[tuple[float, float]] = field(default_factory=list)

    def press(self, separation: float, hardness: float) -> tuple[Floats, Floats]:
        values = np.array([p.press(separation, hardness, self.tolerance) for p in self.pieces])
        self.done += 1
        if self.progress is not None:
            self.progress(min(self.done, self.total), self.total)
        return values[:, 0], values[:, 1]

    def tighten(self, pressure: float, hardness: float, floor: float) -> float:
        """Return the separation >= ``floor`` at a mean ``pressure``, found by Newton's method."""
        d = max(float(np.median([p.heights.max() for p in self.pieces])) - 0.2 * self.rms, floor)
        d += 0.1 * self.rms if d <= floor else 0.0
        low, high = floor, math.inf  # of the separation
        for _ in range(_ATTEMPTS):
            p, s = (float(values @ self.weights) for values in self.press(d, hardness))
            if p > 0.0:
                self.path.append((p, d))
            if p > 0.0 and abs(p / pressure - 1.0) < _TIGHTENED:
                return d
            low, high = (d, high) if p > pressure else (low, d)
            # Not more than a factor of 2.5 at a time: the path is the first loading.
            fall = max(math.log(p / pressure), -_STEP) if p > 0.0 else 0.0
            # Grains of dust far above the face must not use up the attempts.
            usual, longest = 0.5 * self.rms, 0.6 * self.rms
            if d > 6.0 * self.rms:
                usual = longest = 0.25 * d
            step = fall * p / s if p > 0.0 and s > 0.0 else -usual
            new = d + min(max(step, -longest), longest)
            if not low < new < high:
                new = 0.5 * (low + min(high, d + self.rms))
            if abs(new - d) < 1e-9 * self.rms:
                break
            d = new
        raise InputError(
            "the face is in full contact, or at its hardness everywhere, below the tightening "
            f"pressure (at {p / pressure:.3g} of it); lower the `tightening_pressure`"
        )

    def first_loading(self, d: float, hardness: float, loads: int, ratio: float) -> Floats:
        """Return tightening pressures up to the final one, and -dp/dd on unloading from each.

        Shape (2, loads), at most ``loads``. They are solved from the final separation ``d``
        outwards, each pressure about ``ratio`` < 1 times the one before; then the pieces are reset
        to the state before.
        """
        states = [(p.pressure, p.growth, p.separation) for p in self.pieces]
        found = []
        for _ in range(loads):
            pressures, slopes = self.press(d, hardness)
            if sum(p.touching for p in self.pieces) < _FEWEST:
                break
            mean, slope = float(pressures @ self.weights), float(slopes @ self.weights)
            self.path.insert(0, (mean, d))  # the end of the path stays the tightening
            relieved = np.array([p.relieved() for p in self.pieces])
            found.append((mean, float(relieved @ self.weights)))
            # Where all that touches yields there is no slope: the relieved one is a longer step.
            d -= math.log(ratio) * mean / max(slope, 0.2 * found[-1][1])
        for piece, state in zip(self.pieces, states, strict=True):
            piece.pressure, piece.growth, piece.separation = state
        return np.array(found).reshape(-1, 2).T


@single_threaded
def solve_face(
    pieces: list[Floats],
    *,
    pressure: float,
    hardness: float,
    stiffness_ratio: float,
    aspect: float = 1.0,
    loads: int = 12,
    lightest: float = 1e-3,
    progress: OnPiece | None = None,
) -> FaceSolution:
    """Tighten a face to a mean pressure, flatten yielded points, and unload it in steps.

    Parameters
    ----------
    pieces : list of ndarray
        Heights of the pieces above the mean plane of the whole face [pixels along x].
    pressure, hardness : float
        Mean tightening pressure, and largest pressure at a point [E*].
    stiffness_ratio, aspect : float
        Normal over tangential stiffness of a round contact, and spacing along y over along x [-].
    loads : int
        Number of loads in geometric progression; up to four more lie between the heaviest two.
    lightest : float
        Lightest over heaviest load [-].
    progress : callable, optional
        Called with the numbers of finished and of all solutions (approximate).

    Returns
    -------
    FaceSolution
        Separation, pressures of the pieces and their slopes at each load, the heaviest first.
    """
    ratio = lightest ** (1.0 / (loads - 1))
    near = [share for share in NEAR_REST if share > 1.1 * ratio]
    shares = np.array([1.0, *near, *ratio ** np.arange(1, loads)])
    sizes = np.array([piece.size for piece in pieces], dtype=float)
    rms = math.sqrt(sum(float(np.vdot(z, z)) for z in pieces) / sizes.sum())
    face = _Face(
        [_Piece(z, aspect) for z in pieces], sizes / sizes.sum(), TOLERANCE * rms, rms,
        progress=progress, total=shares.size + 8,
    )  # fmt: skip
    # Without a hardness no piece comes closer than its own mean plane.
    floor = max(float(z.mean()) for z in pieces) if math.isinf(hardness) else -math.inf
    d = face.tighten(pressure, hardness, floor)
    face.done, face.total = 8, shares.size + 8
    points = sum(p.touching for p in face.pieces)
    bearing = sum(piece.bearing(hardness) for piece in face.pieces)
    lighter_tightenings = np.zeros((0, 0))
    if not math.isinf(hardness):
        lighter_tightenings = face.first_loading(d, hardness, loads, ratio)
    if bearing:
        for piece in face.pieces:
            piece.yielded(hardness)
            piece.growth = None
    rows: list[tuple[float, Floats, Floats, float]] = []
    last, last_rate = d, 0.0
    for k, share in enumerate(shares):
        pressures, slopes = face.press(d, math.inf)
        mean, slope = float(pressures @ face.weights), float(slopes @ face.weights)
        touching = sum(p.touching for p in face.pieces)
        if k and touching < _FEWEST:
            break
        first = np.asarray(face.pieces[0].pressure)
        if k == 0:
            picture, reach = first.copy(), np.zeros(first.shape)
            tensor = _sliding(face, stiffness_ratio, aspect)
        reach[(first > 0.0) & (reach == k)] += 1.0
        rows.append((d, pressures, slopes, touching / sizes.sum()))
        # ln p is concave: its slope here, and how it changed since the load before.
        rate = slope / mean
        change = (rate - last_rate) / (d - last) if k else 0.0
        last, last_rate = d, rate
        fall = math.log(share / shares[min(k + 1, shares.size - 1)])
        d += fall / (rate + 0.5 * max(change, 0.0) * fall / rate)
    separation, p, s, contact = (np.array(column) for column in zip(*rows, strict=True))
    return FaceSolution(
        separation, p, s, contact, tensor, bearing / max(points, 1), points,
        picture, reach, lighter_tightenings, _first_loading(face.path),
    )  # fmt: skip


def _first_loading(path: list[tuple[float, float]]) -> Floats:
    """Return the pressures and separations of tightening, pressures increasing, shape (2, points).

    ``path`` holds the solved (mean pressure, separation), with the tightening state last. Pressures
    above that of the last state, and points within 10 % of the next pressure, are omitted.
    """
    last, kept = path[-1], [path[-1]]
    for p, d in sorted(path[:-1], reverse=True):
        if p < 0.9 * kept[-1][0] and d > kept[-1][1] and p < last[0]:
            kept.append((p, d))
    return np.array(kept[::-1]).T


def _sliding(face: _Face, stiffness_ratio: float, aspect: float) -> Floats:
    """Return the tensor of tangential over normal stiffness [-] of the whole face, shape (2, 2).

    It is the mean over the pieces of the scan, weighted by their normal stiffness.
    """
    total, weight = np.zeros((2, 2)), 0.0
    for piece, share in zip(face.pieces, face.weights, strict=True):
        assert piece.pressure is not None
        assert piece.growth is not None
        contact = piece.pressure > 0.0
        if contact.any():
            space = HalfSpace(piece.space.shape, aspect, mirrored=False)
            part = float(share) * float(piece.growth.mean())
            total += part * sliding(space, contact, stiffness_ratio)
            weight += part
    return total / weight


def cycle_energies(solution: FaceSolution, amplitudes: Floats) -> Floats:
    """Return energies of cycles over mu^2 lambda [E* pixel] at amplitudes over mu lambda [pixels].

    The cycles are at the tightening load; ln N is a cubic Hermite spline of the separation, and
    falls linearly beyond the lightest solved load. Energies that rounding or few points of contact
    would make zero or negative are 1e-6 of p a, so that they have a logarithm.
    """
    from scipy.interpolate import CubicHermiteSpline

    d, p = solution.separation - solution.separation[0], solution.pressure.mean(axis=1)
    rates = -solution.slope.mean(axis=1) / p
    curve = CubicHermiteSpline(d, np.log(p / p[0]), rates)
    shares = np.linspace(0.0, 1.0, 401)
    at = amplitudes[:, None] * shares
    logs = curve(np.minimum(at, d[-1])) + rates[-1] * np.maximum(at - d[-1], 0.0)
    lost = -np.expm1(np.minimum(logs, 0.0))
    energies = 8.0 * np.trapezoid(lost, shares, axis=1) - 4.0 * lost[:, -1]
    return np.asarray(amplitudes * p[0] * np.maximum(energies, 1e-6))


def stiffness_scatter(solution: FaceSolution) -> float | None:
    """Return the standard deviation of ln(-dp/dd) between the pieces [-]; None for one piece.

    Each piece is evaluated where its own pressure is half the largest mean pressure of the face.
    """
    count = solution.pressure.shape[1]
    if count < 2:
        return None
    level = math.log(0.5 * float(solution.pressure[0].mean()))
    values = []
    for p, s in zip(solution.pressure.T, solution.slope.T, strict=True):
        # Lighter pieces are extrapolated, which neighbouring loads do not allow.
        loaded = (p > 0.0) & (s > 0.0) & ((p < 0.7 * p[0]) | (p == p[0]))
        x, y = np.log(p[loaded])[::-1], np.log(s[loaded])[::-1]
        if x.size < 2:
            continue
        i = int(np.clip(np.searchsorted(x, level), 1, x.size - 1))
        values.append(y[i] + (y[i] - y[i - 1]) / (x[i] - x[i - 1]) * (level - x[i]))
    return float(np.std(values, ddof=1)) if len(values) > 1 else None
