"""From what was asked for to the coordinates of a fit; every mistake is named here."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from microslip._core.checks import exact, members, number, positive, show
from microslip._core.units import engineering
from microslip._core.wording import did_you_mean, plural
from microslip.errors import UNSAID, Argument, InputError
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
    rising = sorted({load for load in loads if load is not None})
    level: dict[float | None, int] = {}
    number_of, last = -1, 0.0
    for load in rising:
        if number_of < 0 or load > last * (1.0 + SAME_LOAD):
            number_of, last = number_of + 1, load
        level[load] = number_of
    level[None] = number_of + 1
    return [level[load] for load in loads]


def checked_loads(model: Model, folded: Sequence[Folded]) -> None:
    """A law that scales with the load wants it of every record, above zero."""
    if not model.scales_with_load:
        return
    for record in folded:
        load = record.normal_load
        if load is None or not load > 0.0:
            came = "none" if load is None else f"{exact(load)} N"
            raise InputError(
                f"{record.name}: the law {model.name!r} needs the normal load [N], above zero, got "
                f"{came}; state it with the record, as ",
                *(Argument("normal_load", 500.0), " [N], or take ", Argument("law", "jenkins")),
                ", which has no load",
            )


def record_list(records: Any) -> list[Record]:
    """The records one by one, of whatever holds them."""
    expected = "a Record or a list of them; write Record(displacement, force) or Record.read(path)"
    return members(
        "records", [records] if isinstance(records, Record) else records, Record, expected
    )


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


def _mapping(name: str, option: Any) -> dict[str, Any]:
    if option is None:
        return {}
    if not isinstance(option, Mapping):
        raise InputError(
            Argument(name),
            f" must be a dict by parameter names, such as {{'friction_coefficient': 0.5}}, "
            f"got {show(option)}",
        )
    return dict(option)


def _names(name: str, option: Any) -> list[str]:
    if option is None:
        return []
    if isinstance(option, Mapping):
        return [key for key, is_named in option.items() if is_named]
    if isinstance(option, str) or not isinstance(option, Iterable):
        raise InputError(Argument(name), f" must be a list of parameter names, got {show(option)}")
    return list(option)


def _check_names(name: str, keys: Iterable[Any], names: Sequence[str]) -> None:
    for key in keys:
        if key not in names:
            hint = did_you_mean(key, names) if isinstance(key, str) else ""
            raise InputError(
                Argument(name),
                f": {show(key)} is no parameter of this fit, which has {', '.join(names)}{hint}",
            )


def _limits(key: str, limits: Any) -> tuple[float, float]:
    try:
        low, high = limits
    except (TypeError, ValueError):
        raise InputError(f"bounds of {key} must be (lowest, highest), got {show(limits)}") from None
    low, high = number(f"lowest {key}", low), number(f"highest {key}", high)
    if not low < high:
        raise InputError(f"bounds of {key} must be (lowest, highest), got ({low:g}, {high:g})")
    return low, high


def _value(option: str, key: str, values: Mapping[str, Any], coordinate: Coordinate) -> float:
    """A number of an option within its bounds; of text, which may have a unit, an example."""
    raw_value, unit = values[key], coordinate.unit
    if isinstance(raw_value, str):
        examples = {"m": 3e-7, "N": 1000.0, "N/m": 2e8}
        example = examples.get(unit, 0.5 if coordinate.low >= 0.0 else 2.0)
        raise InputError(
            Argument(option),
            f": {key} must be a finite number{f' [{unit}]' if unit else ''}, got "
            f"{show(raw_value)}; write ",
            Argument(option, {key: example}),
        )
    value = number(f"{'start of' if option == 'start' else 'fixed'} {key}", raw_value, unit)
    if not coordinate.low <= value <= coordinate.high:
        unit = f" {unit}" if unit else ""
        raise InputError(
            Argument(option),
            f": {coordinate.name} must be within its bounds, {coordinate.low:g} to "
            f"{coordinate.high:g}{unit}, got {exact(value)}{unit}; set others by ",
            Argument("bounds", {coordinate.parameter: UNSAID}),
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
    loads = [record.normal_load for record in folded]
    levels = levels_of(loads)
    labels = labels_of(folded, levels)
    several = len(set(levels)) > 1
    one_for_all = _names("shared", shared)
    one_a_load = _names("per_load", per_load)
    law_names = [*model.names, RIG]
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
    coordinates: list[Coordinate] = []
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
            coordinate = coordinate_of(
                parameter, 1.0, load if splits or not several else None, several=splits
            )
            if splits and load is not None:
                coordinate = replace(coordinate, name=f"{parameter.name} at {labels[level]} N")
            elif parameter.name in model.at_reference:
                coordinate = replace(coordinate, load=getattr(model, "reference_load", load))
            places[parameter.name, level if splits else -1] = len(coordinates)
            coordinates.append(coordinate)
    columns = [
        tuple(places.get((name, level), places.get((name, -1), 0)) for name in model.names)
        for level in levels
    ]
    names = [*law_names, *(c.name for c in coordinates if c.name not in law_names)]
    fixed, bounds, start = (
        _mapping("fixed", fixed),
        _mapping("bounds", bounds),
        _mapping("start", start),
    )
    for name, option in (("fixed", fixed), ("bounds", bounds), ("start", start)):
        _check_names(name, option, names)
        if RIG in option and name == "fixed":
            raise InputError(
                *(Argument("fixed"), ": write ", Argument("rig_stiffness", 2e8)),
                " for a rig of known stiffness [N/m]",
            )
    given_start: dict[str, float] = {}
    for i, free_coordinate in enumerate(coordinates):
        keys = free_coordinate.parameter, free_coordinate.name
        for key in keys:
            if key in bounds:
                low, high = _limits(key, bounds[key])
                if free_coordinate.kind == "log":
                    positive(f"lowest {key}", low)
                free_coordinate = replace(free_coordinate, low=low, high=high)
            if key in start:
                given_start[free_coordinate.name] = _value("start", key, start, free_coordinate)
        for key in keys:
            if key in fixed:
                value = _value("fixed", key, fixed, free_coordinate)
                free_coordinate = replace(free_coordinate, fixed=True, start=value)
        coordinates[i] = free_coordinate
    if RIG in start:
        given_start[RIG] = positive(f"start of {RIG}", start[RIG], "N/m", 1e8)
    return coordinates, columns, given_start


def split_model(model: Model, coordinates: Sequence[Coordinate]) -> Model:
    """The model where loads have values of their own of what else belongs to one load."""
    at_own_load = [
        coordinate for coordinate in coordinates if coordinate.parameter in model.at_reference
    ]
    names = {record.parameter for record in at_own_load}
    if len(at_own_load) <= len(names):
        return model
    return model.split(names, [record.load for record in at_own_load if record.load is not None])


def rig_coordinates(
    stiffness: Any, rigs: Any, folded: Sequence[Folded], loops: Sequence[Loop], bounds: Any
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
                f" must hold a label for each of the {plural(len(folded), 'record')}, got "
                f"{show(rigs)}",
            )
        labels = [str(label) for label in rigs]
    rig_labels = list(dict.fromkeys(labels))
    given_stiffness = of_each_rig(stiffness, rig_labels, rigs is not None)
    place: dict[str, int] = {}
    coordinates: list[Coordinate] = []
    for label, own_stiffness in given_stiffness.items():
        if is_rigid(own_stiffness):
            continue
        place[label] = len(coordinates)
        rig_loops = [loops[i] for i in range(len(folded)) if labels[i] == label]
        scale = max(stiffness_after_reversal(loop) for loop in rig_loops)
        name = RIG if len(rig_labels) == 1 else f"{RIG} of {label}"
        low, high = 1e-3 * scale, math.inf
        limits = _mapping("bounds", bounds).get(RIG)
        if limits is not None:
            low, high = _limits(RIG, limits)
            positive(f"lowest {RIG}", low, "N/m")
        coordinate = Coordinate(
            name, RIG, "N/m", low, high, "inverse", 1.1 * scale, scale=scale, rig=label
        )
        coordinates.append(rig_coordinate(coordinate, own_stiffness))
    return coordinates, [place.get(label) for label in labels]


def rig_contradiction(
    coordinates: Sequence[Coordinate],
    rigs: Sequence[int | None],
    loops: Sequence[Loop],
    times: float = 1.0,
) -> str | None:
    """What says that loops are so many ``times`` stiffer than the rig that was given for them.

    Of more than once only for a rig without an uncertainty, which the loops may else overrule.
    """
    for j, coordinate in enumerate(coordinates):
        if coordinate.parameter != RIG or not (
            coordinate.fixed or (coordinate.prior is not None and times == 1.0)
        ):
            continue
        rig_loops = [loop for loop, rig in zip(loops, rigs, strict=True) if rig == j]
        # Over half of the force noise counts little, and the rig gives way by all of it.
        stiffest = max((stiffness_after_reversal(loop, 0.5) for loop in rig_loops), default=0.0)
        if stiffest > times * coordinate.start:
            return (
                f"the loops are stiffer ({engineering(stiffest, 'N/m')} after a reversal) than the "
                f"{coordinate.name} given, {engineering(coordinate.start, 'N/m')}: no joint behind "
                "such a rig makes them; check its unit and that of the force, or leave the rig free"
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
    start_values: Mapping[str, float],
) -> Iterator[list[float]]:
    """Physical values of all coordinates to start from, one after the other as they are wanted.

    The law guesses from loops of which a share of the compliance after a reversal is taken off as
    the rig's.
    """
    free_rig = any(
        coordinate.parameter == RIG and not coordinate.fixed for coordinate in coordinates
    )
    for share in _SHARES if free_rig else (0.0,):
        values = [coordinate.start for coordinate in coordinates]
        for i, moved_coordinate in enumerate(coordinates):
            if (
                moved_coordinate.parameter == RIG
                and not moved_coordinate.fixed
                and moved_coordinate.prior is None
            ):
                values[i] = start_values.get(RIG, moved_coordinate.scale / share)
        instance_values = model.start
        if instance_values is not None:
            instance_start = list(values)
            for i, moved_coordinate in enumerate(coordinates):
                if not moved_coordinate.fixed and moved_coordinate.parameter in instance_values:
                    instance_start[i] = start_values.get(
                        moved_coordinate.name, instance_values[moved_coordinate.parameter]
                    )
            yield _bounded(coordinates, instance_start)
        try:
            guessed = _guessed(model, columns, rigs, folded, loops, values)
        except InputError:
            guessed = {
                i: start_values[coordinate.name]
                for i, coordinate in enumerate(coordinates)
                if coordinate.name in start_values
            }
            if any(
                i not in guessed and not coordinates[i].fixed for column in columns for i in column
            ):
                continue
        for i, guess in guessed.items():
            moved_coordinate = coordinates[i]
            if not moved_coordinate.fixed:
                values[i] = start_values.get(moved_coordinate.name, guess)
        yield _bounded(coordinates, values)


def _bounded(coordinates: Sequence[Coordinate], values: Sequence[float]) -> list[float]:
    return [
        min(max(value, coordinate.low), coordinate.high)
        for coordinate, value in zip(coordinates, values, strict=True)
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
    guesses: dict[int, float] = {}
    bare = []
    for loop, rig in zip(loops, rigs, strict=True):
        compliance = 0.0 if rig is None else 1.0 / values[rig]
        middle = loop.force - 0.5 * (loop.force.max() + loop.force.min())
        bare.append(Loop(loop.displacement - compliance * middle, middle))
    for group in dict.fromkeys(columns):
        members = [i for i, column in enumerate(columns) if column == group]
        guess = model.guess([bare[i] for i in members], [folded[i].normal_load for i in members])
        for name, place in zip(model.names, group, strict=True):
            guesses.setdefault(place, guess[name])
    return guesses
