"""Second step of an identification: fit of the Greenwood interface to the free form."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from microslip._core.checks import Floats, positive, show
from microslip._core.errors import InputError
from microslip._core.wording import did_you_mean
from microslip.contact import GreenwoodWilliamson, TabulatedNormalLaw
from microslip.contact.materials import MaterialPair
from microslip.identification.bands import QUANTILE
from microslip.identification.free_form import FreeForm
from microslip.identification.interface_model import (
    FRICTION,
    SCALE,
    SEPARATION,
    InterfaceModel,
    Materials,
    Values,
)
from microslip.identification.second_step import (
    ASSUMED,
    BOUNDED,
    IDENTIFIED,
    NOT,
    RIG_PARAMETER,
    Datum,
    InterfaceStep,
    Law,
    Parameter,
    Problem,
    Scatter,
    SufficientStatistics,
    Unknown,
    fit_law,
    fitted_parameters,
    verdict_of,
)

CONTACT_AREA = "contact_area"
_SUMMITS = ("radius", "density", "summit_count", CONTACT_AREA)
_UNITS = {
    "force_limit": "N", "tangential_stiffness": "N/m", "radius": "m", "approach": "m", "std": "m",
    "density_root_radius": "m^-1.5", "summit_count": "", "density": "m^-2", CONTACT_AREA: "m^2",
}  # fmt: skip
_SCALES, _SEPARATIONS = (0.1, 0.25, 0.6, 1.5), (-0.5, 0.8, 2.0, 3.5)
"""Starts: slip scale over the length of the force limit over the stiffness; separation."""
_VARYING_LOAD = 3e-4
"""Relative standard error of the force limit where the load varies within the cycle.

The effect of the law on the path of the thresholds is linear about the free form: at most 0.014 %
in 8 sets with loads that vary by 2 and 10 %.
"""
_RIGS = (1.01, 1.1, 1.5, 4.0)
"""Starts of an unknown rig: its stiffness over that of joint and rig in series."""


@np.errstate(all="ignore")  # far out in an open interval numbers overflow
def interface_step(
    statistics: SufficientStatistics,
    force: float,
    stiffness: float,
    slips: bool,
    *,
    pair: MaterialPair | None,
    area: float | None,
    heights: Any,
    known: Mapping[str, Any] | None,
    contact_area: tuple[float, float, float] | None,
) -> InterfaceStep:
    """Fit the interface to the statistics of a free-form fit.

    ``force`` [N] at the highest load and ``stiffness`` at rest [N/m] give the initial guesses;
    ``slips`` is whether the loops reach gross slip. Others are as for :func:`microslip.identify`.
    """
    if pair is not None and not isinstance(pair, MaterialPair):
        raise InputError(f"`pair` must be a MaterialPair of two materials, got {show(pair)}")
    area = None if area is None else positive("area", area, "m^2", 2e-4)
    loads = [load for load in statistics.fit.loads if load is not None]
    law, model = interface_law(loads, heights, force, stiffness)
    materials = Materials(pair, area)
    known = dict(known or {})
    summits = known.pop("summits", None)
    data, measured = _data(known, model, materials, max(loads), contact_area)
    scatter = None
    if summits is not None:
        if not isinstance(model.law, GreenwoodWilliamson):
            raise InputError(
                '`known`: "summits" needs a distribution of heights, whose summits are random; '
                "leave it out"
            )
        summits = as_pair(summits)
        count = float(summits[0]) if isinstance(summits, (tuple, list)) else float(summits)
        scatter = _scatter(model, loads, count)
    starts = interface_starts(statistics, law, model, force, stiffness)
    problem, q, least, covariance = fit_law(statistics, law, data, scatter, starts)
    statistics = problem.statistics
    parameters = fitted_parameters(problem, q, least, covariance)
    by_shape = parameters.pop(RIG_PARAMETER, None)
    if by_shape is not None and statistics.rig is not None:
        parameters[RIG_PARAMETER] = _as_given(by_shape, *statistics.rig)
    values = problem.values(q)
    for name, function in _derived(model, materials, max(loads), measured).items():
        beside = measured if name in _SUMMITS else None
        parameters[name] = _propagated(name, function, problem, values, covariance, beside)
    for name, datum in known.items():
        one, (value, error) = parameters.get(name), pair_of(name, datum)
        # Loops that determine a given number twice as well as it was given identify it.
        if one is not None and (statistics.free_rig or one.high - one.low > 2.0 * error):
            parameters[name] = _as_given(one, value, error)
    if statistics.free_rig:
        # Loops cannot separate a rig from a joint: only the shape assumed for N(d) does.
        for name, one in list(parameters.items()):
            if name not in (FRICTION, "force_limit") and one.verdict != ASSUMED:
                parameters[name] = _open(one)
    misfit, limit = max(least - statistics.least, 0.0), statistics.misfit_limit(q.size)
    excess = 1.0 if misfit <= limit else math.sqrt(misfit / max(limit, 1.0))
    share = _VARYING_LOAD if statistics.fit.friction is not None else 0.0
    for name in (FRICTION, "force_limit"):
        one = parameters.get(name)
        if one is not None and one.verdict != ASSUMED:
            size = math.sqrt(QUANTILE) * share * one.value
            below, above = (
                math.hypot(excess * abs(end - one.value), size) for end in (one.low, one.high)
            )
            parameters[name] = replace(one, low=one.value - below, high=one.value + above)
    if share and not slips and parameters[FRICTION].verdict != ASSUMED:
        # Without gross slip the path of the load counts as much as the friction.
        for name, one in parameters.items():
            if name in (FRICTION, "force_limit"):
                least = force / (max(loads) if name == FRICTION else 1.0)
                low = min(one.low, least)
                parameters[name] = replace(one, low=low, high=math.inf, verdict=BOUNDED)
            elif one.verdict in (IDENTIFIED, BOUNDED):
                parameters[name] = _open(one)
    if misfit > limit:
        by_shape = None
        # Intervals of a law that the loops contradict hold no true value; the limit needs no law.
        for name, one in parameters.items():
            if one.verdict in (IDENTIFIED, BOUNDED):
                known_limit = name in (FRICTION, "force_limit")
                parameters[name] = replace(one, verdict=BOUNDED) if known_limit else _open(one)
    return InterfaceStep(
        parameters, misfit, limit, values, by_shape, model, materials, tuple(loads)
    )


def _as_given(one: Parameter, value: float, error: float) -> Parameter:
    half = math.sqrt(QUANTILE) * error
    return replace(one, value=value, low=value - half, high=value + half, verdict=ASSUMED)


def _open(one: Parameter) -> Parameter:
    low = -math.inf if one.name == SEPARATION else 0.0
    return replace(one, value=math.nan, low=low, high=math.inf, verdict=NOT)


def interface_law(
    loads: Sequence[float], heights: Any, force: float, stiffness: float
) -> tuple[Law, InterfaceModel]:
    """Return an interface law with its unknown parameters, and the model that computes it."""
    if not loads:
        raise InputError(
            "an interface needs the normal load of each record; write "
            "Record(..., normal_load=500.0)"
        )
    model = InterfaceModel.of_shape(heights, loads)
    unknowns: tuple[Unknown, ...] = (
        Unknown(FRICTION, "", min(force / max(loads), 2.0)),
        Unknown(SCALE, "m", force / stiffness),
    )
    if not model.is_sphere:
        unknowns += (Unknown(SEPARATION, "", 1.0, False, *model.bounds()),)
    return Law(unknowns, lambda u, values, load: model.curve(u, values, load or loads[0])), model


def interface_starts(
    statistics: SufficientStatistics,
    law: Law,
    model: InterfaceModel,
    force: float,
    stiffness: float,
) -> list[dict[str, float]]:
    """Return the best-fitting parameter sets of a grid, as initial guesses of the fit."""
    places = _SEPARATIONS[:1] if model.is_sphere else _SEPARATIONS  # a sphere has none
    starts = [
        {SCALE: share * force / stiffness, SEPARATION: h} for share in _SCALES for h in places
    ]
    mu = force / max(load for load in statistics.fit.loads if load is not None)
    surface, unit = model.law, model.unit
    if isinstance(surface, TabulatedNormalLaw):  # its lengths and loads are those of a real face
        here = float(surface.separation(model.reference_load)) / unit
        starts.append({SCALE: mu * surface.stiffness_ratio * unit, SEPARATION: here})
    if statistics.free_rig:
        series = statistics.least_stiffness
        starts = [
            start
            | {
                RIG_PARAMETER: share * series,
                SCALE: start[SCALE] * (share - 1.0) / share * stiffness / series,
            }
            for start in starts
            for share in _RIGS
        ]
    problem, sums = Problem(statistics, law, ()), []
    for start in starts:
        g = problem.coefficients({FRICTION: mu} | start)
        sums.append(float(np.sum(np.nan_to_num(statistics.residuals(g), nan=1e9) ** 2)))
    return [starts[i] for i in np.argsort(sums)[: 3 if statistics.free_rig else 2]]


def _scatter(model: InterfaceModel, loads: Sequence[float], count: float) -> Scatter:
    """Return a function that computes the effect of random heights of ``count`` summits."""
    high = max(loads)

    def changes(fit: FreeForm, values: Mapping[str, float]) -> Floats:
        nodes = np.append(np.append(0.0, fit.y[:-1]), fit.y[-2] * 1.001)
        rows = model.by_summits(nodes, values, high, list(loads)) / math.sqrt(count)
        slope = np.diff(rows, axis=1) / np.diff(nodes)
        k = np.concatenate((slope[:, :-1] - slope[:, 1:], slope[:, -1:]), axis=1)
        # Heights change the shifts of steady loads; the friction of a varying load stays.
        shifts = [] if fit.friction is None else [np.zeros(len(k))]
        for shift in fit.shifts[1:] if fit.friction is None else ():
            at = np.array([-shift])
            moved = model.by_summits(at, values, high, list(loads))[:, 0] / math.sqrt(count)
            shifts.append(moved / float(model.slope(at, values, high)[0]))
        whole = np.concatenate((k, np.array(shifts).reshape(fit.extra, len(k)).T), axis=1)
        return (whole * np.where(np.isfinite(fit.scale), fit.scale, 0.0)).T

    return changes


Function = Callable[[Values], float]


def _derived(
    model: InterfaceModel,
    materials: Materials,
    top: float,
    measured: tuple[str, float, float, float] | None,
) -> dict[str, Function]:
    """Return the functions of the parameters that give further quantities, by name."""

    def of(quantities: Callable[[Values], Mapping[str, float]], name: str) -> Function:
        return lambda values: quantities(values)[name]

    names = ["force_limit", "tangential_stiffness"]
    if materials.pair is not None:
        names += ["radius", "approach"] if model.is_sphere else ["std"]
        if materials.area is not None and isinstance(model.law, GreenwoodWilliamson):
            names.append("density_root_radius")
    found = {name: of(lambda values: model.derived(values, top, materials), name) for name in names}
    if measured is not None:
        density = ["density"] if materials.area is not None else []
        for name in ("radius", "summit_count", *density, CONTACT_AREA):
            if name != measured[0]:
                found[name] = of(lambda values: _summits(values, model, materials, measured), name)
    return found


def _summits(
    values: Values,
    model: InterfaceModel,
    materials: Materials,
    measured: tuple[str, float, float, float],
) -> dict[str, float]:
    """Return radius [m], number [-] and density [m^-2] of the summits, and contact area [m^2].

    Loops determine only the density times the root of the radius. With one more measured quantity,
    all four follow. ``measured`` is its name (radius, density, or contact area, which is
    proportional to density times radius), value, standard error and normal load [N].
    """
    name, value, _, load = measured
    joint: Any = model.build(values, load, materials)
    surface = joint.surface
    datum = values.get(name, value)
    count = surface.density * surface.area
    if name == CONTACT_AREA:
        ratio = datum / joint.contact_area
    elif name == "radius":
        ratio = math.sqrt(datum / surface.radius)
    else:
        ratio = count / (datum * (materials.area or 1.0))
    return {
        "radius": surface.radius * ratio**2,
        "summit_count": count / ratio,
        "density": count / ratio / (materials.area or 1.0),
        CONTACT_AREA: joint.contact_area * ratio,
    }


def as_pair(datum: Any) -> Any:
    """Return (value, standard deviation) of a datum that has both, otherwise the datum itself.

    Both are attributes of numbers of the package uncertainties (``nominal_value``, ``std_dev``) and
    of estimates of this package (``value``, ``standard_error``).
    """
    for names in (("nominal_value", "std_dev"), ("value", "standard_error")):
        if all(hasattr(datum, name) for name in names):
            return tuple(getattr(datum, name) for name in names)
    return datum


def pair_of(name: str, datum: Any) -> tuple[float, float]:
    """Return a datum as (value, standard deviation).

    A datum is such a pair, or a number with its error as accepted by :func:`as_pair`. InputError
    is raised for anything else.
    """
    try:
        value, error = (float(part) for part in as_pair(datum))
    except (TypeError, ValueError):
        raise InputError(
            f"`known`: {name} must be (value, standard deviation), such as (5e-7, 2e-8), got "
            f"{show(datum)}"
        ) from None
    if not (math.isfinite(value) and error > 0.0 and math.isfinite(error)):
        raise InputError(
            f"`known`: {name} must be a value and a standard deviation above zero, got "
            f"{show(datum)}"
        )
    return value, error


def _data(
    known: Mapping[str, Any],
    model: InterfaceModel,
    materials: Materials,
    top: float,
    contact_area: Any,
) -> tuple[list[Datum], tuple[str, float, float, float] | None]:
    """Return the measured values to be fitted, and one for :func:`_summits`, or None."""
    measured = None
    has_summits = isinstance(model.law, GreenwoodWilliamson)
    if contact_area is not None:
        try:
            value, error, load = (float(part) for part in contact_area)
        except (TypeError, ValueError):
            raise InputError(
                "`contact_area` must be (value [m^2], uncertainty [m^2], normal load [N]), got "
                f"{show(contact_area)}"
            ) from None
        if materials.pair is None:
            raise InputError(
                "`contact_area` needs `pair=...`, the two materials: the contact area depends on "
                "the modulus"
            )
        if not has_summits:
            raise InputError(
                "`contact_area` separates radius and density of summits, which a surface without a "
                "distribution of heights does not have; leave it out"
            )
        positive("contact_area", value, "m^2", 2e-5)
        positive("uncertainty of contact_area", error, "m^2", 1e-6)
        positive("normal load of contact_area", load, "N", 2000.0)
        if materials.area is not None and value > materials.area:
            raise InputError(
                f"`contact_area` must not be above the apparent area, {materials.area:g} m^2, got "
                f"{value:g} m^2"
            )
        measured = (CONTACT_AREA, value, error, load)
    functions = _derived(model, materials, top, None)
    for name in (FRICTION, SCALE, SEPARATION):
        functions[name] = lambda values, name=name: float(values[name])  # type: ignore[misc]
    data = []
    for name, datum in known.items():
        value, error = pair_of(name, datum)
        is_separating = name in ("radius", "density") and has_summits
        if is_separating and materials.pair is not None and measured is None:
            measured = (name, value, error, top)
            continue
        if name not in functions:
            hint = did_you_mean(name, list(functions))
            raise InputError(
                f"`known`: {show(name)} is not a parameter of an interface, which has "
                f"{', '.join(functions)}{hint}"
            )
        data.append(Datum(value, error, functions[name]))
    return data, measured


def _propagated(
    name: str,
    function: Function,
    problem: Problem,
    values: Mapping[str, float],
    covariance: Floats,
    measured: tuple[str, float, float, float] | None,
) -> Parameter:
    """Return the positive value of ``function``, with its interval by error propagation."""
    value = function(values)
    by = np.zeros(len(problem.unknowns))
    for i, one in enumerate(problem.unknowns):
        step, old = 1e-3, values[one.name]
        ends = []
        for way in (step, -step):
            moved = {**values, one.name: old * math.exp(way) if one.is_log else old + way}
            ends.append(math.log(function(moved)))
        by[i] = (ends[0] - ends[1]) / (2.0 * step)
    variance = float(by @ covariance @ by) * problem.statistics.level / QUANTILE
    if measured is not None:
        kind, datum, error, _ = measured
        up, down = (
            math.log(function({**values, kind: datum * (1.0 + way * 1e-3)})) for way in (1, -1)
        )
        variance += ((up - down) / 2e-3 * error / datum) ** 2
    half = min(math.sqrt(QUANTILE * max(variance, 0.0)), 700.0)
    low, high = value * math.exp(-half), value * math.exp(half)
    return Parameter(name, _UNITS[name], value, low, high, verdict_of(low, high, True))
