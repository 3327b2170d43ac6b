"""Start values of a fit, from loops and records."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from microslip._core.checks import Floats, positive, show, without_unit
from microslip._core.checks import record as series
from microslip._core.errors import InputError
from microslip._core.parameters import rescaled, says_all, values_of
from microslip.friction.fit_parameters import FitParameter, fit_parameters_of

Share = Callable[[Floats], Floats]
"""Share of a force limit against displacement over a length: 0 at 0, 1 in the end."""

_MOST_BINS = 48


class Features(NamedTuple):
    """One closed loop, the mean of all cycles of a loop or a record, about its own middle."""

    amplitude: float
    """Half the range of displacement [m]."""
    force_amplitude: float
    """Half the range of force [N], between the ends of the branches."""
    gone: Floats
    """Ways from a reversal [m], rising."""
    force: Floats
    """Forces along the motion there [N]; symmetric, so one branch stands for both."""

    @property
    def half(self) -> Floats:
        """Half the way from the reversal [m]: where Masing's rule asks for the backbone."""
        return 0.5 * self.gone

    @property
    def backbone(self) -> Floats:
        """Backbone force [N]: half the rise of the force from a reversal."""
        return 0.5 * (self.force + self.force_amplitude)

    @property
    def stiffness(self) -> float:
        """Stiffness after a reversal [N/m], as far as the samples resolve it."""
        u, force = self.half, self.backbone
        first = max(2, int(np.argmax(force > 0.35 * self.force_amplitude)))
        u, force = u[:first], force[:first]
        return max(float(u @ force) / float(u @ u), self.force_amplitude / self.amplitude)

    @property
    def energy(self) -> float:
        """Energy of a cycle [J] (19.29)."""
        x = np.concatenate(([0.0], self.gone, [2.0 * self.amplitude]))
        t = np.concatenate(([-self.force_amplitude], self.force, [self.force_amplitude]))
        return float(np.sum((t[1:] + t[:-1]) * np.diff(x)))

    @property
    def sliding_ratio(self) -> float:
        """Width of the loop at its middle force over its range of displacement [-]."""
        crossed = float(np.interp(0.0, np.maximum.accumulate(self.force), self.gone))
        return max(0.0, 1.0 - crossed / self.amplitude)


# -- features ---------------------------------------------------------------------------------


def all_features(data: Any) -> list[Features]:
    """Features of a loop, of a record, or of each of several."""
    return [_features(*pair) for pair in _pairs(data)]


def _pairs(data: Any) -> list[tuple[Floats, Floats]]:
    several = list(data) if isinstance(data, (list, tuple)) else [data]
    if not several:
        raise InputError("`data` must be loops or records, at least one, got none")
    pairs = []
    for item in several:
        if not hasattr(item, "displacement") or not hasattr(item, "force"):
            raise InputError(
                "`data` must be a Loop, a Record or a list of such (anything that has "
                f"displacement [m] and force [N]), got {show(item)}"
            )
        if callable(item.force):
            raise InputError(
                "`data` must be what was measured, a Loop or a Record, got a law; give "
                f"law.loop(amplitude), got {show(item)}"
            )
        x, t = series("displacement", item.displacement), series("force", item.force)
        if x.shape != t.shape or x.size < 4:
            raise InputError(
                "displacement and force must be of one length, at least four samples, "
                f"got {x.size} and {t.size}"
            )
        pairs.append((x, t))
    return pairs


def _features(x: Floats, t: Floats) -> Features:
    span = float(np.ptp(x))
    if span <= 0.0:
        raise InputError(f"`displacement` must move, got {x[0]:g} m throughout")
    if float(np.ptp(t)) <= 0.0:
        raise InputError(f"`force` must vary, got {t[0]:g} N throughout")
    turns = _turns(_smoothed(x, len(_turns(x))))
    x = _smoothed(x, turns.size)
    lengths = np.abs(np.diff(x[turns]))
    full = np.flatnonzero(lengths > 0.75 * lengths.max()) if lengths.size else lengths
    ways = np.sign(np.diff(x[turns]))[full] if lengths.size else lengths
    if not (np.any(ways > 0.0) and np.any(ways < 0.0)):
        raise InputError(
            "`data` must hold a closed cycle, one way and back over the whole range of "
            f"displacement, got {x.size} samples with {turns.size} turning points"
        )
    bins = int(np.clip(np.median(np.diff(turns)[full]) // 2, 3, _MOST_BINS))
    # Even in the phase of a sine, so that bins are narrow where a branch begins.
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
    sides = [[_middle(np.array([row[k] for row in rows[w]])) for k in (0, 1)] for w in (1.0, -1.0)]
    distance, force = (0.5 * (sides[0][k] + sides[1][k]) for k in (0, 1))
    filled = np.isfinite(distance) & np.isfinite(force)
    distance, force = distance[filled], force[filled]
    top = float(np.median(force[-3:])) if force.size > 8 else float(force[-1])
    if top <= 0.0:
        raise InputError(
            "`force` must rise with the displacement, got a loop whose force falls on "
            "average; reverse the sign of one"
        )
    real = distance > 0.0
    return Features(0.5 * float(np.median(lengths[full])), top, distance[real], force[real])


def _middle(rows: Floats) -> Floats:
    """Medians of columns, not a number where a column has none."""
    filled = np.isfinite(rows).any(axis=0)
    result = np.full(rows.shape[1], np.nan)
    result[filled] = np.nanmedian(rows[:, filled], axis=0)
    return result


def _turns(x: Floats) -> Any:
    """Indices of the turning points of all swings over most of the range, and of both ends."""
    low, high = float(x.min()), float(x.max())
    side = np.where(x > low + 0.7 * (high - low), 1, np.where(x < low + 0.3 * (high - low), -1, 0))
    outside = np.flatnonzero(side)
    starts = outside[np.append(True, np.diff(side[outside]) != 0)]
    extremes = []
    for start, end in zip(starts, np.append(starts[1:], x.size), strict=True):
        part = x[start:end] * side[start]
        extremes.append(start + int(np.argmax(part)))
    turns = sorted({0, *extremes, x.size - 1})
    # What leads from an end of the record to the next turning point may be a branch or none.
    return np.array(turns)


def _smoothed(x: Floats, turns: int) -> Floats:
    """The displacement without its noise, if it has any to speak of."""
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


def loads_of(loads: Any, count: int, data: Any = None) -> list[float]:
    """Normal loads [N] as one for each of ``count`` loops: as given, or those of the records."""
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
            f"got {len(listed)}"
        )
    if any(load is None for load in listed):
        raise InputError(
            "`normal_load` must be known for every record: the model scales with it; give "
            "normal_load=... [N], or state it with the record"
        )
    return [positive("normal_load", load, "N", 500.0) for load in listed]


# -- laws of one length ---------------------------------------------------------------------------


class Scaled(NamedTuple):
    """A shape drawn through points: force limit [N], length [m], and what is left over [-]."""

    limit: float
    length: float
    misfit: float


def points_of(features: Sequence[Features]) -> tuple[Floats, Floats]:
    """Displacements [m] and forces [N] of the backbone as all loops show it."""
    u, force = (np.concatenate([getattr(f, k) for f in features]) for k in ("half", "backbone"))
    return u, force


def draw(u: Floats, force: Floats, share: Share) -> Scaled:
    """The length and the limit with which a shape goes best through points."""

    def rows(lengths: Floats) -> Floats:
        return share((u / lengths[:, None]).ravel()).reshape(lengths.size, u.size)

    return best_of(rows, force, 0.2 * float(u.min()), 50.0 * float(u.max()))


def best_of(rows: Callable[[Floats], Floats], force: Floats, low: float, high: float) -> Scaled:
    """The best of many lengths between two: ``rows`` gives the curve of each."""
    best = Scaled(0.0, 0.0, math.inf)
    square = float(force @ force)
    for count in (81, 25, 25):
        lengths = np.geomspace(low, high, count)
        curves = rows(lengths)
        limits = np.maximum(curves @ force, 0.0) / np.maximum((curves**2).sum(axis=1), 1e-300)
        misfits = ((force - limits[:, None] * curves) ** 2).sum(axis=1)
        # Of equally good ones the shortest: what no loop shows is not there.
        at = int(np.argmax(misfits <= misfits.min() + 1e-9 * square))
        if misfits[at] < best.misfit:
            best = Scaled(float(limits[at]), float(lengths[at]), float(misfits[at]))
        step = float(lengths[1] / lengths[0])
        low, high = best.length / step, best.length * step
    return best._replace(misfit=math.sqrt(best.misfit / square))


def guessed_law(kind: Any, data: Any) -> Any:
    """A law of any kind that says its parameters: the one closest to the branches of loops."""
    parameters = fit_parameters_of(kind)
    if not says_all(kind) or any(item.many or item.dimension is None for item in parameters):
        raise InputError(
            f"{kind.__name__} must have a classmethod guess(data) of its own to be guessed: the "
            "default serves laws that declare their parameters, as numbers with units of N and m"
        )
    u, force = points_of(all_features(data))
    best, values = math.inf, dict[str, float]()
    for shape in _shapes(kind, parameters):
        fit = draw(u, force, kind(**shape)._backbone)
        if fit.misfit < best:
            best, values = fit.misfit, rescaled(kind, shape, fit.limit, fit.length)
    if not math.isfinite(best):
        raise InputError(f"{kind.__name__} has no values with which it draws these loops")
    scales = [item.dimension for item in parameters if item.dimension != (0, 0)]
    # A limit and a length are settled already.
    if len(parameters) > 2 or len(set(scales)) < len(parameters):
        values = _settled(kind, parameters, values, u, force)
    return kind(**values)


def _shapes(kind: Any, parameters: Sequence[FitParameter]) -> list[dict[str, float]]:
    """Values to try in units of force and length: those of the examples, and of the defaults."""
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


def _settled(
    kind: Any,
    parameters: Sequence[FitParameter],
    values: Mapping[str, float],
    u: Floats,
    force: Floats,
) -> dict[str, float]:
    """Values near some that draw a law best through points, within what is searched."""
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
    """Yield displacements [m] of cells, geometric over what the loops resolve."""
    features = all_features(data)
    u, _ = points_of(features)
    last = 0.95 * float(u.max())
    reach = min(f.force_amplitude / f.stiffness for f in features)
    first = min(max(0.2 * reach, float(u.min())), 0.5 * last)
    return np.geomspace(first, last, cells) if cells > 1 else np.array([reach])


def cell_stiffnesses(data: Any, yields: Floats) -> Floats:
    """Stiffnesses [N/m], not negative, of cells with given yield displacements [m]."""
    from scipy.optimize import nnls

    u, force = points_of(all_features(data))
    scale = float(force.max()) / float(u.max())
    shares, _ = nnls(np.minimum(u[:, None], yields) * scale, force)
    return np.asarray(shares * scale)
