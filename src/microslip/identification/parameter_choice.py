"""From the request to the coordinates of a fit; every mistake is named here."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from microslip._core.checks import Floats, exact, members, number, positive, show
from microslip._core.errors import InputError
from microslip._core.wording import did_you_mean
from microslip.friction.loops import Loop
from microslip.identification.coordinates import (
    RIG,
    Coordinate,
    coordinate_of,
    labels_of,
    levels_of,
    limits_of,
    option_mapping,
)
from microslip.identification.models.base import Model
from microslip.identification.problem import Problem
from microslip.laboratory.folding import Folded
from microslip.laboratory.record import Record

_SHARES = (0.9, 0.5, 0.97, 0.1)  # of the compliance after a reversal that may be the rig's


def checked_loads(model: Model, folded: Sequence[Folded]) -> None:
    """A law that scales with the load wants it of every record, above zero."""
    if not model.scales_with_load:
        return
    for record in folded:
        load = record.normal_load
        if load is None or not load > 0.0:
            came = "none" if load is None else f"{exact(load)} N"
            raise InputError(
                f"{record.name}: the law {model.name!r} needs the normal load [N], above zero, "
                f"got {came}; state it with the record, as `normal_load=500.0` [N], or take "
                '`law="jenkins"`, which has no load'
            )


def record_list(records: Any) -> list[Record]:
    """The records one by one, of whatever holds them."""
    expected = "a Record or a list of them; write Record(displacement, force) or Record.read(path)"
    return members(
        "records", [records] if isinstance(records, Record) else records, Record, expected
    )


# -- what was asked for ---------------------------------------------------------------------------


def _names(name: str, option: Any) -> list[str]:
    if option is None:
        return []
    if isinstance(option, Mapping):
        return [key for key, is_named in option.items() if is_named]
    if isinstance(option, str) or not isinstance(option, Iterable):
        raise InputError(f"`{name}` must be a list of parameter names, got {show(option)}")
    return list(option)


def _check_names(name: str, keys: Iterable[Any], names: Sequence[str]) -> None:
    for key in keys:
        if key not in names:
            hint = did_you_mean(key, names) if isinstance(key, str) else ""
            raise InputError(
                f"`{name}`: {show(key)} is no parameter of this fit, which has "
                f"{', '.join(names)}{hint}"
            )


def _value(option: str, key: str, values: Mapping[str, Any], coordinate: Coordinate) -> float:
    """A number of an option within its bounds; of text, which may have a unit, an example."""
    raw_value, unit = values[key], coordinate.unit
    if isinstance(raw_value, str):
        examples = {"m": 3e-7, "N": 1000.0, "N/m": 2e8}
        example = examples.get(unit, 0.5 if coordinate.low >= 0.0 else 2.0)
        raise InputError(
            f"`{option}`: {key} must be a finite number{f' [{unit}]' if unit else ''}, got "
            f'{show(raw_value)}; write `{option}={{"{key}": {example!r}}}`'
        )
    value = number(f"{'start of' if option == 'start' else 'fixed'} {key}", raw_value, unit)
    if not coordinate.low <= value <= coordinate.high:
        unit = f" {unit}" if unit else ""
        raise InputError(
            f"`{option}`: {coordinate.name} must be within its bounds, {coordinate.low:g} to "
            f"{coordinate.high:g}{unit}, got {exact(value)}{unit}; set others by "
            f'`bounds={{"{coordinate.parameter}": ...}}`'
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
            own_load = load if splits or not several else None
            coordinate = coordinate_of(parameter, 1.0, own_load)
            if splits:
                place = "without load" if load is None else f"at {labels[level]} N"
                coordinate = replace(coordinate, name=f"{parameter.name} {place}")
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
        option_mapping("fixed", fixed),
        option_mapping("bounds", bounds),
        option_mapping("start", start),
    )
    for name, option in (("fixed", fixed), ("bounds", bounds), ("start", start)):
        _check_names(name, option, names)
        if RIG in option and name == "fixed":
            raise InputError(
                "`fixed`: write `rig_stiffness=200000000.0` for a rig of known stiffness [N/m]"
            )
    given_start: dict[str, float] = {}
    for i, free_coordinate in enumerate(coordinates):
        keys = free_coordinate.parameter, free_coordinate.name
        for key in keys:
            if key in bounds:
                low, high = limits_of(key, bounds[key])
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


# -- where to begin -------------------------------------------------------------------------------


def starts_for(problem: Problem, start_values: Mapping[str, float]) -> Iterator[Floats]:
    """Coordinates to start from, guessed with a share of the compliance as the rig's."""
    for values in _starts(problem, start_values):
        inside = (
            c.inner(min(max(value, c.low), c.high))
            for c, value in zip(problem.coordinates, values, strict=True)
        )
        yield np.array(list(inside))[problem.free]


def _starts(problem: Problem, start_values: Mapping[str, float]) -> Iterator[list[float]]:
    model, coordinates, columns = problem.model, problem.coordinates, problem.columns
    free = {i: c for i, c in enumerate(coordinates) if not c.fixed}
    free_rigs = {i: c for i, c in free.items() if c.parameter == RIG}
    for share in _SHARES if free_rigs else (0.0,):
        values = [coordinate.start for coordinate in coordinates]
        for i, rig in free_rigs.items():
            if rig.prior is None:
                values[i] = start_values.get(RIG, rig.scale / share)
        if model.start is not None:
            instance_start = list(values)
            for i, coordinate in free.items():
                if coordinate.parameter in model.start:
                    value = model.start[coordinate.parameter]
                    instance_start[i] = start_values.get(coordinate.name, value)
            yield instance_start
        try:
            guessed = _guessed(problem, values)
        except InputError:
            guessed = {
                i: start_values[coordinate.name]
                for i, coordinate in enumerate(coordinates)
                if coordinate.name in start_values
            }
            if any(i in free and i not in guessed for column in columns for i in column):
                continue
        for i in guessed.keys() & free.keys():
            values[i] = start_values.get(coordinates[i].name, guessed[i])
        yield values
        if model.start is not None and {"friction_coefficient", "slip_scale"} <= model.start.keys():
            # The instance with the friction of the loops, on which its slip depends as well.
            for i, coordinate in free.items():
                if coordinate.parameter == "slip_scale":
                    friction = values[columns[0][model.names.index("friction_coefficient")]]
                    values[i] = instance_start[i] * friction / model.start["friction_coefficient"]
                elif coordinate.parameter not in (RIG, "friction_coefficient"):
                    values[i] = instance_start[i]
            yield values


def _guessed(problem: Problem, values: Sequence[float]) -> dict[int, float]:
    """Guesses of the law for the loops without what the rigs do."""
    guesses: dict[int, float] = {}
    bare = []
    for record, rig in zip(problem.folded, problem.rigs, strict=True):
        loop = record.loop
        compliance = 0.0 if rig is None else 1.0 / values[rig]
        middle = loop.force - 0.5 * (loop.force.max() + loop.force.min())
        bare.append(Loop(loop.displacement - compliance * middle, middle))
    for group in dict.fromkeys(problem.columns):
        members = [i for i, column in enumerate(problem.columns) if column == group]
        guess = problem.model.guess([bare[i] for i in members], [problem.loads[i] for i in members])
        for name, place in zip(problem.model.names, group, strict=True):
            guesses.setdefault(place, guess[name])
    return guesses
