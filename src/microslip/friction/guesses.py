"""Initial guesses of fits from loops and records."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from microslip._core.checks import Floats, positive, show, without_unit
from microslip._core.checks import record as series
from microslip._core.errors import InputError
from microslip._core.parameters import is_fully_declared, rescaled, values_of
from microslip.friction.fit_parameters import FitParameter, fit_parameters_of

NormalisedBackbone = Callable[[Floats], Floats]
"""Normalised backbone: T0 over the force limit as a function of displacement over a length."""

_MOST_BINS = 48


class Features(NamedTuple):
    """Mean cycle of a loop or a record, centred about its mean displacement and force."""

    amplitude: float
    """Half the range of displacement [m]."""
    force_amplitude: float
    """Half the difference of the forces at both ends of the branches [N]."""
    distance: Floats
    """Distances from the reversal [m], increasing."""
    force: Floats
    """Force in the direction of motion at each distance [N], averaged over both branches."""

    @property
    def half(self) -> Floats:
        """Half the distance from the reversal [m], which is the backbone displacement."""
        return 0.5 * self.distance

    @property
    def backbone(self) -> Floats:
        """Backbone force [N]: half the rise of the force from a reversal."""
        return 0.5 * (self.force + self.force_amplitude)

    @property
    def stiffness(self) -> float:
        """Stiffness after a reversal [N/m], within the resolution of the samples."""
        u, force = self.half, self.backbone
        first = max(2, int(np.argmax(force > 0.35 * self.force_amplitude)))
        u, force = u[:first], force[:first]
        return max(float(u @ force) / float(u @ u), self.force_amplitude / self.amplitude)

    @property
    def energy(self) -> float:
        """Energy of a cycle [J] (19.29)."""
        x = np.concatenate(([0.0], self.distance, [2.0 * self.amplitude]))
        t = np.concatenate(([-self.force_amplitude], self.force, [self.force_amplitude]))
        return float(np.sum((t[1:] + t[:-1]) * np.diff(x)))

    @property
    def sliding_ratio(self) -> float:
        """Width of the loop at mid force relative to the range of displacement [-]."""
        crossed = float(np.interp(0.0, np.maximum.accumulate(self.force), self.distance))
        return max(0.0, 1.0 - crossed / self.amplitude)


# -- features ---------------------------------------------------------------------------------


def all_features(data: Any) -> list[Features]:
    """Return the features of a loop, a record, or each item of a list."""
    return [_features(*pair) for pair in _pairs(data)]


def _pairs(data: Any) -> list[tuple[Floats, Floats]]:
    several = list(data) if isinstance(data, (list, tuple)) else [data]
    if not several:
        raise InputError("`data` must be one or more loops or records, got an empty list")
    pairs = []
    for item in several:
        if not hasattr(item, "displacement") or not hasattr(item, "force"):
            raise InputError(
                "`data` must be a Loop, a Record or a list of these (any object with "
                f"displacement [m] and force [N]), got {show(item)}"
            )
        if callable(item.force):
            raise InputError(
                f"`data` must be measured data, a Loop or a Record, got the law {show(item)}; "
                "write law.loop(amplitude)"
            )
        x, t = series("displacement", item.displacement), series("force", item.force)
        if x.shape != t.shape or x.size < 4:
            raise InputError(
                "`displacement` and `force` must have the same length, at least four samples, "
                f"got {x.size} and {t.size}"
            )
        pairs.append((x, t))
    return pairs


def _features(x: Floats, t: Floats) -> Features:
    span = float(np.ptp(x))
    if span <= 0.0:
        raise InputError(f"`displacement` must vary, got {x[0]:g} m throughout")
    if float(np.ptp(t)) <= 0.0:
        raise InputError(f"`force` must vary, got {t[0]:g} N throughout")
    turns = _turning_points(_smoothed(x, len(_turning_points(x))))
    x = _smoothed(x, turns.size)
    lengths = np.abs(np.diff(x[turns]))
    full = np.flatnonzero(lengths > 0.75 * lengths.max()) if lengths.size else lengths
    ways = np.sign(np.diff(x[turns]))[full] if lengths.size else lengths
    if not (np.any(ways > 0.0) and np.any(ways < 0.0)):
        raise InputError(
            "`data` must hold a closed cycle, forward and back over the whole range of "
            f"displacement, got {x.size} samples with {turns.size} turning points"
        )
    bins = int(np.clip(np.median(np.diff(turns)[full]) // 2, 3, _MOST_BINS))
    # Bins of equal phase of a sine are narrow near the reversal.
    edges = 0.5 * (1.0 - np.cos(math.pi * np.arange(bins + 1) / bins))
    edges[-1] = np.inf
    rows: dict[float, list[tuple[Floats, Floats]]] = {1.0: [], -1.0: []}
    for i, way in zip(full, ways, strict=True):
        part = slice(int(turns[i]), int(turns[i + 1]) + 1)
        distance = np.maximum((x[part] - x[turns[i]]) * way, 0.0)
        places = np.searchsorted(edges, distance / distance.max(), side="right") - 1
        count = np.bincount(places, minlength=bins).astype(float)
        with np.errstate(invalid="ignore", divide="ignore"):
            mean_gone = np.bincount(places, distance, bins) / count
            mean_force = way * np.bincount(places, t[part], bins) / count
        rows[float(way)].append((mean_gone, mean_force))
    sides = [
        [_column_medians(np.array([row[k] for row in rows[w]])) for k in (0, 1)]
        for w in (1.0, -1.0)
    ]
    distance, force = (0.5 * (sides[0][k] + sides[1][k]) for k in (0, 1))
    filled = np.isfinite(distance) & np.isfinite(force)
    distance, force = distance[filled], force[filled]
    top = float(np.median(force[-3:])) if force.size > 8 else float(force[-1])
    if top <= 0.0:
        raise InputError(
            "`force` must rise with the displacement, got a loop whose force falls on "
            "average; reverse the sign of the force or the displacement"
        )
    real = distance > 0.0
    return Features(0.5 * float(np.median(lengths[full])), top, distance[real], force[real])


def _column_medians(rows: Floats) -> Floats:
    filled = np.isfinite(rows).any(axis=0)
    result = np.full(rows.shape[1], np.nan)
    result[filled] = np.nanmedian(rows[:, filled], axis=0)
    return result


def _turning_points(x: Floats) -> Any:
    """Return the indices of the turning points of large swings and of both ends of the record."""
    low, high = float(x.min()), float(x.max())
    side = np.where(x > low + 0.7 * (high - low), 1, np.where(x < low + 0.3 * (high - low), -1, 0))
    outside = np.flatnonzero(side)
    starts = outside[np.append(True, np.diff(side[outside]) != 0)]
    extremes = []
    for start, end in zip(starts, np.append(starts[1:], x.size), strict=True):
        part = x[start:end] * side[start]
        extremes.append(start + int(np.argmax(part)))
    turns = sorted({0, *extremes, x.size - 1})
    # The parts before the first and after the last turning point may be incomplete branches.
    return np.array(turns)


def _smoothed(x: Floats, turns: int) -> Floats:
    if x.size < 64:
        return x
    noise = float(np.std(np.diff(x, 3))) / math.sqrt(20.0)
    window = x.size // (32 * max(turns, 2)) | 1
    if noise < 5e-4 * float(np.ptp(x)) or window < 3:
        return x
    padded = np.concatenate(
        (2.0 * x[0] - x[window // 2 : 0 : -1], x, 2.0 * x[-1] - x[-2 : -window // 2 - 1 : -1])
    )
    return np.convolve(padded, np.full(window, 1.0 / window), mode="valid")


def loads_per_loop(loads: Any, count: int, data: Any = None) -> list[float]:
    """Return one normal load [N] per loop, as given or from the records."""
    if loads is None and data is not None:
        records = list(data) if isinstance(data, (list, tuple)) else [data]
        stated = [getattr(item, "normal_load", None) for item in records]
        loads = [None if load is None else float(np.mean(load)) for load in stated]
    loads = without_unit("normal_load", loads, "N")
    several = isinstance(loads, (list, tuple)) or (isinstance(loads, np.ndarray) and loads.ndim > 0)
    listed = list(loads) if several else [loads] * count
    if len(listed) != count:
        raise InputError(
            f"`normal_load` must be one number [N] or one for each of the {count} records, "
            f"got {len(listed)} numbers"
        )
    if any(load is None for load in listed):
        raise InputError(
            "`normal_load` must be known for every record, since the model scales with it; write "
            "normal_load=... [N], or set it in the record"
        )
    return [positive("normal_load", load, "N", 500.0) for load in listed]


# -- fits of scaled shapes ------------------------------------------------------------------------


class Scaled(NamedTuple):
    """Fit of a scaled shape: force limit [N], length [m] and relative residual [-]."""

    limit: float
    length: float
    misfit: float


def backbone_points(features: Sequence[Features]) -> tuple[Floats, Floats]:
    """Return the displacements [m] and forces [N] of the backbone from all loops."""
    u, force = (np.concatenate([getattr(f, k) for f in features]) for k in ("half", "backbone"))
    return u, force


def fit_shape(u: Floats, force: Floats, share: NormalisedBackbone) -> Scaled:
    """Fit force limit and length of a normalised backbone to points."""

    def rows(lengths: Floats) -> Floats:
        return share((u / lengths[:, None]).ravel()).reshape(lengths.size, u.size)

    return fit_limit_and_length(rows, force, 0.2 * float(u.min()), 50.0 * float(u.max()))


def fit_limit_and_length(
    rows: Callable[[Floats], Floats], force: Floats, low: float, high: float
) -> Scaled:
    """Fit force limit and length by a refined grid search over lengths.

    ``rows`` returns the normalised curves (lengths, points) for an array of lengths.
    """
    best = Scaled(0.0, 0.0, math.inf)
    square = float(force @ force)
    for count in (81, 25, 25):
        lengths = np.geomspace(low, high, count)
        curves = rows(lengths)
        limits = np.maximum(curves @ force, 0.0) / np.maximum((curves**2).sum(axis=1), 1e-300)
        misfits = ((force - limits[:, None] * curves) ** 2).sum(axis=1)
        # Among equally good lengths take the shortest, the one within the data.
        at = int(np.argmax(misfits <= misfits.min() + 1e-9 * square))
        if misfits[at] < best.misfit:
            best = Scaled(float(limits[at]), float(lengths[at]), float(misfits[at]))
        step = float(lengths[1] / lengths[0])
        low, high = best.length / step, best.length * step
    return best._replace(misfit=math.sqrt(best.misfit / square))


def guess_law(kind: Any, data: Any) -> Any:
    """Return an initial guess for any law that declares its parameters.

    The shapes of its examples are scaled to the measured branches; the best one is refined by least
    squares.
    """
    parameters = fit_parameters_of(kind)
    if not is_fully_declared(kind) or any(
        item.many or item.dimension is None for item in parameters
    ):
        raise InputError(
            f"{kind.__name__} must define a classmethod guess(data): the default works only for "
            "laws that declare all parameters as numbers with units of N and m"
        )
    u, force = backbone_points(all_features(data))
    best, values = math.inf, dict[str, float]()
    for shape in _shapes(kind, parameters):
        fit = fit_shape(u, force, kind(**shape)._backbone)
        if fit.misfit < best:
            best, values = fit.misfit, rescaled(kind, shape, fit.limit, fit.length)
    if not math.isfinite(best):
        raise InputError(f"{kind.__name__} has no parameter values that reproduce these loops")
    scales = [item.dimension for item in parameters if item.dimension != (0, 0)]
    # Two parameters, a force and a length, are already determined.
    if len(parameters) > 2 or len(set(scales)) < len(parameters):
        values = _refined(kind, parameters, values, u, force)
    return kind(**values)


def _shapes(kind: Any, parameters: Sequence[FitParameter]) -> list[dict[str, float]]:
    """Return trial parameters in units of force limit and length, from examples and defaults."""
    shapes = []
    for law in kind.examples():
        stiffness = law.tangential_stiffness
        if math.isfinite(stiffness):
            limit = law.force_limit
            shapes.append(rescaled(kind, values_of(law), 1.0 / limit, stiffness / limit))
    plain = [item for item in parameters if item.dimension == (0, 0)]
    for share in (0.25, 0.5, 0.75) if plain else (0.5,):
        shape = {item.name: 1.0 for item in parameters}
        for item in plain:
            # The far ends of a search range do not indicate usual values.
            low, high = max(item.low, -10.0), min(item.high, 10.0)
            middle = low + share * (high - low)
            shape[item.name] = middle if item.required else item.default
        shapes.append(shape)
    return shapes


def _refined(
    kind: Any,
    parameters: Sequence[FitParameter],
    values: Mapping[str, float],
    u: Floats,
    force: Floats,
) -> dict[str, float]:
    """Refine parameters by least squares within their search ranges."""
    from scipy.optimize import least_squares

    logs = [item.is_positive for item in parameters]
    ends = np.array([(item.low, item.high) for item in parameters]).T
    at = np.clip([values[item.name] for item in parameters], *ends)

    def inner(row: Floats) -> Floats:
        return np.array([math.log(x) if log else x for x, log in zip(row, logs, strict=True)])

    def outer(q: Floats) -> dict[str, float]:
        row = [math.exp(x) if log else float(x) for x, log in zip(q, logs, strict=True)]
        return {
            item.name: min(max(x, item.low), item.high)
            for item, x in zip(parameters, row, strict=True)
        }

    def misses(q: Floats) -> Floats:
        return np.asarray((kind(**outer(q))._backbone(u) - force) / force.max())

    fit = least_squares(misses, inner(at), bounds=(inner(ends[0]), inner(ends[1])), max_nfev=60)
    return outer(fit.x)


def yield_grid(data: Any, cells: int) -> Floats:
    """Return a geometric grid of yield displacements [m] over the resolution of the loops."""
    features = all_features(data)
    u, _ = backbone_points(features)
    last = 0.95 * float(u.max())
    reach = min(f.force_amplitude / f.stiffness for f in features)
    first = min(max(0.2 * reach, float(u.min())), 0.5 * last)
    return np.geomspace(first, last, cells) if cells > 1 else np.array([reach])


def cell_stiffnesses(data: Any, yields: Floats) -> Floats:
    """Fit nonnegative stiffnesses [N/m] of cells with given yield displacements [m]."""
    from scipy.optimize import nnls

    u, force = backbone_points(all_features(data))
    scale = float(force.max()) / float(u.max())
    shares, _ = nnls(np.minimum(u[:, None], yields) * scale, force)
    return np.asarray(shares * scale)
