"""From what was asked for to the coordinates of a fit; every mistake is named here."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from microslip._core.checks import exact, number, positive, show
from microslip._core.units import engineering
from microslip._core.wording import did_you_mean
from microslip.errors import Argument, InputError
from microslip.identification.coordinates import AREA, RIG, Coordinate, coordinate_of
from microslip.identification.folding import Folded
from microslip.identification.load_labels import labels_of
from microslip.identification.models.base import Model
from microslip.identification.rig_stiffness import is_rigid, of_each_rig, rig_coordinate
from microslip.loops import Loop
from microslip.tribometer.record import Record

SAME_LOAD = 0.01
"""Loads that differ by no more than this share count as one."""
FAR_SOFTER = 3.0
"""Ratio of the stiffness of loops to that of a rig which no noise and no delay explain."""
_SHARES = (0.9, 0.5, 0.97, 0.1)  # of the compliance after a reversal that may be the rig's


def levels_of(loads: Sequence[float | None]) -> list[int]:
    """Number of the load level of each record; loads within 1 % are one level."""
    known = sorted({load for load in loads if load is not None})
    level: dict[float | None, int] = {}
    number_of, last = -1, 0.0
    for load in known:
        if number_of < 0 or load > last * (1.0 + SAME_LOAD):
            number_of, last = number_of + 1, load
        level[load] = number_of
    level[None] = number_of + 1
    return [level[load] for load in loads]


def checked_loads(model: Model, folded: Sequence[Folded]) -> None:
    """A law that scales with the load wants it of every record, above zero."""
    if not model.scales_with_load:
        return
    for one in folded:
        load = one.normal_load
        if load is None or not load > 0.0:
            came = "none" if load is None else f"{exact(load)} N"
            raise InputError(
                f"{one.name}: the law {model.name!r} needs the normal load [N], above zero, got "
                f"{came}; write Record(..., normal_load=500.0), or take law='jenkins', which has no"
                " load"
            )


def listed(records: Any) -> list[Record]:
    """The records one by one, of whatever holds them."""
    found = [records] if isinstance(records, Record) else records
    if isinstance(found, np.ndarray):
        found = found.ravel().tolist()
    if isinstance(found, Iterable) and not isinstance(found, (str, bytes, Mapping)):
        found = list(found)
    if not isinstance(found, list) or not found:
        raise InputError(
            Argument("records"),
            f" must be a Record or a list of them, got {show(records)}; "
            "write Record(displacement, force) or Record.read(path)",
        )
    return found


def checked_area(contact: Coordinate | None, area: float | None) -> None:
    """A real contact area is part of the apparent one."""
    if contact is None or contact.parameter != AREA or area is None or contact.start <= area:
        return
    raise InputError(
        Argument("contact_area"),
        f" must not be above the apparent area, {exact(area)} m^2, got {exact(contact.start)} m^2",
    )


def stiffness_after_reversal(loop: Loop, share: float = 0.2) -> float:
    """Largest secant stiffness [N/m] over the first ``share`` of the force after a reversal."""
    x, force = loop.displacement[:-1], loop.force[:-1]
    span = float(np.ptp(force))
    best = 0.0
    for turn, sign in ((int(np.argmax(x)), -1.0), (int(np.argmin(x)), 1.0)):
        after = np.roll(x, -turn), np.roll(force, -turn)
        moved, gone = sign * (after[0] - after[0][0]), sign * (after[1] - after[1][0])
        far = np.flatnonzero((gone > share * span) & (moved > 0.0))
        if far.size:
            best = max(best, float(gone[far[0]] / moved[far[0]]))
    return best or 2.0 * span / float(np.ptp(x))


# -- what was asked for ---------------------------------------------------------------------------


def _mapping(name: str, given: Any) -> dict[str, Any]:
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise InputError(
            Argument(name),
            f" must be a dict by parameter names, such as {{'friction_coefficient': 0.5}}, "
            f"got {show(given)}",
        )
    return dict(given)


def _names(name: str, given: Any) -> list[str]:
    if given is None:
        return []
    if isinstance(given, Mapping):
        return [key for key, wanted in given.items() if wanted]
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise InputError(Argument(name), f" must be a list of parameter names, got {show(given)}")
    return list(given)


def _check_names(name: str, given: Iterable[Any], known: Sequence[str]) -> None:
    for key in given:
        if key not in known:
            hint = did_you_mean(key, known) if isinstance(key, str) else ""
            raise InputError(
                f"{name}: {show(key)} is no parameter of this fit, which has "
                f"{', '.join(known)}{hint}"
            )


def _limits(key: str, given: Any) -> tuple[float, float]:
    try:
        low, high = given
    except (TypeError, ValueError):
        raise InputError(f"bounds of {key} must be (lowest, highest), got {show(given)}") from None
    low, high = number(f"lowest {key}", low), number(f"highest {key}", high)
    if not low < high:
        raise InputError(f"bounds of {key} must be (lowest, highest), got ({low:g}, {high:g})")
    return low, high


def _value(option: str, key: str, given: Any, one: Coordinate) -> float:
    """A number of an option; text, which has perhaps a unit, gets an example of the right size."""
    if isinstance(given, str):
        of = {"m": 3e-7, "N": 1000.0, "N/m": 2e8}
        example = of.get(one.unit, 0.5 if one.low >= 0.0 else 2.0)
        unit = f" [{one.unit}]" if one.unit else ""
        raise InputError(
            f"{option}: {key} must be a finite number{unit}, got {show(given)}; write "
            f"{option}={{'{key}': {example:g}}}"
        )
    return number(f"{'start of' if option == 'start' else 'fixed'} {key}", given, one.unit)


def _records(count: int) -> str:
    return "1 record" if count == 1 else f"{count} records"


def _within(what: str, value: float, one: Coordinate) -> float:
    if not one.low <= value <= one.high:
        unit = f" {one.unit}" if one.unit else ""
        raise InputError(
            f"{what} {one.name} must be within its bounds, {one.low:g} to {one.high:g}{unit}, got "
            f"{exact(value)}{unit}; bounds={{'{one.parameter}': (lowest, highest)}} sets others"
        )
    return value


def coordinates_for(
    model: Model,
    folded: Sequence[Folded],
    *,
    fixed: Any,
    bounds: Any,
    start: Any,
    shared: Any,
    per_load: Any,
) -> tuple[list[Coordinate], list[tuple[int, ...]], dict[str, float]]:
    """Coordinates of the law, which of them each record has, and the values to start from."""
    loads = [one.normal_load for one in folded]
    levels = levels_of(loads)
    labels = labels_of(folded, levels)
    several = len(set(levels)) > 1
    one_for_all = _names("shared", shared)
    one_a_load = _names("per_load", per_load)
    known = [*model.names, RIG]
    _check_names("shared", one_for_all, model.names)
    _check_names("per_load", one_a_load, model.names)
    for key in one_for_all:
        if key in one_a_load:
            raise InputError(f"{key} cannot be both shared and per_load; name it in one of them")
    if one_a_load and not several:
        raise InputError(
            f"per_load: {', '.join(one_a_load)} cannot differ between loads, for all records have "
            "one; add records at another normal load"
        )
    found: list[Coordinate] = []
    places: dict[tuple[str, int], int] = {}
    for parameter in model.parameters:
        splits = several and (
            parameter.name in one_a_load
            or (not model.scales_with_load and parameter.name not in one_for_all)
        )
        for level in sorted(set(levels)):
            if not splits and level != levels[0]:
                continue
            of_level = [loads[i] for i in range(len(folded)) if levels[i] == level]
            load = None if of_level[0] is None else float(np.mean([x for x in of_level if x]))
            one = coordinate_of(
                parameter, 1.0, load if splits or not several else None, several=splits
            )
            if splits and load is not None:
                one = replace(one, name=f"{parameter.name} at {labels[level]} N")
            elif parameter.name in model.at_reference:
                one = replace(one, load=getattr(model, "reference_load", load))
            places[parameter.name, level if splits else -1] = len(found)
            found.append(one)
    columns = [
        tuple(places.get((name, level), places.get((name, -1), 0)) for name in model.names)
        for level in levels
    ]
    own = [*known, *(one.name for one in found if one.name not in known)]
    fixed, bounds, start = (
        _mapping("fixed", fixed),
        _mapping("bounds", bounds),
        _mapping("start", start),
    )
    for name, given in (("fixed", fixed), ("bounds", bounds), ("start", start)):
        _check_names(name, given, own)
        if RIG in given and name == "fixed":
            raise InputError("fixed: write rig_stiffness=2e8 for a rig of known stiffness [N/m]")
    given_start: dict[str, float] = {}
    for i, one in enumerate(found):
        for key in (one.parameter, one.name):
            if key in bounds:
                low, high = _limits(key, bounds[key])
                if one.kind == "log":
                    positive(f"lowest {key}", low)
                one = replace(one, low=low, high=high, shape=one.shape)
            if key in start:
                value = _within("start of", _value("start", key, start[key], one), one)
                given_start[one.name] = value
        for key in (one.parameter, one.name):
            if key in fixed:
                value = _within("fixed", _value("fixed", key, fixed[key], one), one)
                one = replace(one, fixed=True, start=value)
        found[i] = one
    if RIG in start:
        given_start[RIG] = positive(f"start of {RIG}", start[RIG], "N/m", 1e8)
    return found, columns, given_start


def split(model: Model, coordinates: Sequence[Coordinate]) -> Model:
    """The model where loads have values of their own of what else belongs to one load."""
    mine = [one for one in coordinates if one.parameter in model.at_reference]
    names = {one.parameter for one in mine}
    if len(mine) <= len(names):
        return model
    return model.split(names, [one.load for one in mine if one.load is not None])


def rig_coordinates(
    given: Any, rigs: Any, folded: Sequence[Folded], loops: Sequence[Loop], bounds: Any
) -> tuple[list[Coordinate], list[int | None]]:
    """Coordinates of the rigs' stiffnesses, and which of them each record has (from 0)."""
    if rigs is None:
        labels = ["rig"] * len(folded)
    else:
        if isinstance(rigs, np.ndarray):
            rigs = rigs.ravel().tolist()
        if isinstance(rigs, str) or not isinstance(rigs, Sequence) or len(rigs) != len(folded):
            raise InputError(
                Argument("rigs"),
                f" must hold a label for each of the {_records(len(folded))}, got {show(rigs)}",
            )
        labels = [str(label) for label in rigs]
    known = list(dict.fromkeys(labels))
    told = of_each_rig(given, known, rigs is not None)
    place: dict[str, int] = {}
    found: list[Coordinate] = []
    for label, own in told.items():
        if is_rigid(own):
            continue
        place[label] = len(found)
        mine = [loops[i] for i in range(len(folded)) if labels[i] == label]
        scale = max(stiffness_after_reversal(loop) for loop in mine)
        name = RIG if len(known) == 1 else f"{RIG} of {label}"
        low, high = 1e-3 * scale, math.inf
        limits = _mapping("bounds", bounds).get(RIG)
        if limits is not None:
            low, high = _limits(RIG, limits)
            positive(f"lowest {RIG}", low, "N/m")
        one = Coordinate(
            name, RIG, "N/m", low, high, "inverse", 1.1 * scale, scale=scale, rig=label
        )
        found.append(rig_coordinate(one, own))
    return found, [place.get(label) for label in labels]


def softer(
    coordinates: Sequence[Coordinate],
    rigs: Sequence[int | None],
    loops: Sequence[Loop],
    times: float = 1.0,
) -> str | None:
    """What says that loops are so many ``times`` stiffer than the rig that was given for them.

    Of more than once only for a rig without an uncertainty, which the loops may else overrule.
    """
    for j, one in enumerate(coordinates):
        if one.parameter != RIG or not (one.fixed or (one.prior is not None and times == 1.0)):
            continue
        mine = [loop for loop, rig in zip(loops, rigs, strict=True) if rig == j]
        # Over half of the force noise counts little, and the rig gives way by all of it.
        stiffest = max((stiffness_after_reversal(loop, 0.5) for loop in mine), default=0.0)
        if stiffest > times * one.start:
            return (
                f"the loops are stiffer ({engineering(stiffest, 'N/m')} after a reversal) than the "
                f"{one.name} given, {engineering(one.start, 'N/m')}: no joint behind such a rig "
                "makes them; check its unit and that of the force, or leave the rig free"
            )
    return None


# -- where to begin -------------------------------------------------------------------------------


def starts_for(
    model: Model,
    coordinates: Sequence[Coordinate],
    columns: Sequence[tuple[int, ...]],
    rigs: Sequence[int | None],
    folded: Sequence[Folded],
    loops: Sequence[Loop],
    given: Mapping[str, float],
) -> Iterator[list[float]]:
    """Physical values of all coordinates to start from, one after the other as they are wanted.

    The law guesses from loops of which a share of the compliance after a reversal is taken off as
    the rig's.
    """
    free_rig = any(one.parameter == RIG and not one.fixed for one in coordinates)
    for share in _SHARES if free_rig else (0.0,):
        values = [one.start for one in coordinates]
        for i, one in enumerate(coordinates):
            if one.parameter == RIG and not one.fixed and one.prior is None:
                values[i] = given.get(RIG, one.scale / share)
        told = model.start
        if told is not None:
            theirs = list(values)
            for i, one in enumerate(coordinates):
                if not one.fixed and one.parameter in told:
                    theirs[i] = given.get(one.name, told[one.parameter])
            yield _bounded(coordinates, theirs)
        try:
            own = _guessed(model, columns, rigs, folded, loops, values)
        except InputError:
            own = {i: given[one.name] for i, one in enumerate(coordinates) if one.name in given}
            if any(i not in own and not coordinates[i].fixed for column in columns for i in column):
                continue
        for i, guess in own.items():
            one = coordinates[i]
            if not one.fixed:
                values[i] = given.get(one.name, guess)
        yield _bounded(coordinates, values)


def _bounded(coordinates: Sequence[Coordinate], values: Sequence[float]) -> list[float]:
    return [
        min(max(value, one.low), one.high) for one, value in zip(coordinates, values, strict=True)
    ]


def _guessed(
    model: Model,
    columns: Sequence[tuple[int, ...]],
    rigs: Sequence[int | None],
    folded: Sequence[Folded],
    loops: Sequence[Loop],
    values: Sequence[float],
) -> dict[int, float]:
    """Guesses of the law for the loops without what the rigs do."""
    own: dict[int, float] = {}
    bare = []
    for loop, rig in zip(loops, rigs, strict=True):
        compliance = 0.0 if rig is None else 1.0 / values[rig]
        middle = loop.force - 0.5 * (loop.force.max() + loop.force.min())
        bare.append(Loop(loop.displacement - compliance * middle, middle))
    for group in dict.fromkeys(columns):
        mine = [i for i, column in enumerate(columns) if column == group]
        guess = model.guess([bare[i] for i in mine], [folded[i].normal_load for i in mine])
        for name, place in zip(model.names, group, strict=True):
            own.setdefault(place, guess[name])
    return own
